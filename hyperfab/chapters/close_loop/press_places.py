"""Where readings of a press were taken: on the front of the male, on the female that faces it, or counted from
elsewhere than the STL is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.errors import InputError
from hyperfab.loop.press_reading import Reading
from hyperfab.loop.thresholds import FEWEST
from hyperfab.pressing.curved import barycentric
from hyperfab.pressing.mold import Mold
from hyperfab.surface import Nearest, Surface

#: Places further off the male's front than this share of its size are of another mold.
_OFF = 0.03
#: Places lie on the female that are off the male by more than this share of the clearance, and off her by less than
#: this share of that.
_THERE, _NEARER = 0.5, 0.25
#: Places are counted from elsewhere where a shift leaves less than this share of how their distances differ, and of the
#: clearance. It is told where it moves them along the surface by more than the one share of that, refused beyond the
#: other.
_LEFT, _TOLD, _MOST = 0.5, 0.1, 0.5
#: What a shift and an even distance have free.
_FREE = 4
#: Times that the shift is brought nearer: on a curved front the nearest facets change with it.
_SHIFTS = 4
_REMEDY = "give places on the male, in the coordinates of its STL"


@dataclass(frozen=True)
class _Taken:
    """Where places (m, 3) of the press frame were taken: on the ``female``, as she is drawn or as she stands, or, where
    that is None, on the male's front; ``surface`` is what they lie on."""

    told: PressResult
    places: Array
    surface: Surface
    female: Mold | None

    @property
    def whose(self) -> str:
        """Whose surface it is."""
        return "male" if self.female is None else "female"

    @property
    def far(self) -> float:
        """How far [mm] off it no place is on it."""
        return _OFF * float(np.ptp(self.told.closed.cold, axis=0).max())

    @property
    def in_press(self) -> tuple[Surface, Array]:
        """The male's front and the places, where both are: cold, or those on the female in the closed press."""
        closed = self.told.closed
        if self.female is None:
            return self.surface, self.places
        near = self.surface.nearest(self.places)
        corners = closed.female.vertices[self.female.faces[near.face]]
        weights = _weights(self.surface, near)
        return Surface(closed.front.vertices, closed.front.faces), np.asarray(np.einsum("mk,mkc->mc", weights, corners))

    @cached_property
    def shift(self) -> tuple[float, str] | None:
        """By how much [mm] (rms) a shift of all moves them along the surface, and what is told of it, where that brings
        them to one distance from it; None where none does, or little.

        What lies off it evenly, as on the thickness of a film, is at the foot of its normal all the same.
        """
        if len(self.places) < FEWEST + _FREE:
            return None
        moved, lies, spread = np.zeros(3), [], []
        for _ in range(_SHIFTS):
            near = self.surface.nearest(self.places - moved)
            normals = self.surface.normals[near.face]
            off = np.sum((self.places - moved - near.point) * normals, axis=1)
            lies.append(float(np.sqrt(np.mean(near.distance**2))))
            spread.append(float(np.std(off)))
            ways = np.column_stack([normals, np.ones(len(off))])
            # Of a flat front nothing tells a shift from an even distance: the least of both is taken.
            moved = moved + np.linalg.lstsq(ways, off, rcond=1e-3)[0][:3]
        along = moved - np.sum(moved * normals, axis=1, keepdims=True) * normals
        size = float(np.sqrt(np.mean(np.sum(along**2, axis=1))))
        clearance = self.told.closed.clearance_cold
        if spread[-1] > _LEFT * min(spread[0], clearance) or size < _TOLD * clearance or lies[-1] > self.far:
            return None
        by = ", ".join(f"{one:.2f}" for one in self.told.frame.outward(moved))
        return size, (
            f"x, y and z look shifted by ({by}) mm: without that the places would lie {lies[-1]:.2g} mm off the "
            f"{self.whose} (rms), and lie {lies[0]:.2g} mm off it"
        )


def _taken(told: PressResult, reading: Reading) -> _Taken:
    """Return where the places of a reading were taken; InputError where that is on neither mold, or counted from
    elsewhere."""
    assert reading.places is not None
    closed, places = told.closed, told.frame.inward(reading.places)
    front = Surface(closed.cold, closed.front.faces)
    off = np.abs(front.nearest(places).distance)
    found = _Taken(told, places, front, None)
    median = float(np.median(off))
    for female in (closed.case.female, closed.female) if median > _THERE * closed.clearance_cold else ():
        off_her = np.abs(female.surface.nearest(places).distance)
        if float(np.median(off_her)) < _NEARER * median:
            found, off = _Taken(told, places, female.surface, female), off_her
            break
    if found.shift is not None and found.shift[0] > _MOST * closed.clearance_cold:
        raise InputError(found.shift[1], file=reading.name, remedy=_REMEDY)
    far = int(np.argmax(off))
    if off[far] > found.far:
        x, y, z = reading.places[far]
        raise InputError(
            f"the place ({x:.4g}, {y:.4g}, {z:.4g}) mm is {off[far]:.3g} mm off the molding surface of the "
            f"{found.whose}",
            file=reading.name,
            remedy=_REMEDY,
        )
    return found


def _weights(surface: Surface, near: Nearest) -> Array:
    """Return the weights (m, 3) of the corners of the facets that are nearest."""
    weights = barycentric(surface, near.face, near.point)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def with_heights(told: PressResult, reading: Reading) -> Reading:
    """Return a reading whose places tell no coordinate along the press's axis (nan) with that of the male's front,
    seen along the axis; InputError where another coordinate lacks, or a place is beyond the front."""
    if reading.places is None or np.all(np.isfinite(reading.places)):
        return reading
    places = told.frame.inward(reading.places)
    if not np.all(np.isfinite(places[:, :2])):
        raise InputError(
            f"only a place's {told.frame.axis}, along which the press closes, can be taken from the male",
            file=reading.name,
            remedy=f"give {' and '.join(told.frame.plan)} of each place",
        )
    front = Surface(told.closed.cold, told.closed.front.faces)
    above = float(told.closed.cold[:, 2].max()) + 1.0
    starts = np.column_stack([places[:, :2], np.full(len(places), above)])
    depth, face = front.ray(starts, np.array([0.0, 0.0, -1.0]))
    for row in np.flatnonzero(face < 0)[:1]:
        first, second = told.frame.outward(starts)[row, ["xyz".index(one) for one in told.frame.plan]]
        raise InputError(
            f"the place ({first:.4g}, {second:.4g}) mm is beyond the molding surface of the male, seen along "
            f"{told.frame.axis}",
            file=reading.name,
            remedy=_REMEDY,
        )
    return replace(reading, places=told.frame.outward(np.column_stack([places[:, :2], above - depth])))


def on_front(told: PressResult, reading: Reading) -> Reading:
    """Return a reading at places with the corners (m, 3) of the facets nearest to them, and their weights on these.

    Places on the female are those of the male that face them in the closed press.
    """
    front, places = _taken(told, reading).in_press
    near = front.nearest(places)
    return replace(reading, corners=front.faces[near.face], weights=_weights(front, near))


def told_of_places(told: PressResult, reading: Reading) -> tuple[list[str], list[str]]:
    """Return what is said, and what is warned of, where a reading was taken."""
    if reading.places is None or reading.kind == "mounting":
        return [], []
    found = _taken(told, reading)
    said, warned = [], []
    if found.female is not None:
        said.append(
            f"{reading.name}: its places lie on the female; each is taken for the place of the male that faces it in "
            "the closed press"
        )
    if found.shift is not None:
        warned.append(f"{reading.name}: {found.shift[1]}; look again where they are counted from")
    return said, warned
