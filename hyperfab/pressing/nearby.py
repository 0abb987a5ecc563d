"""Presses beside one that has been closed: the gaps follow to the first order, nothing is searched again.

Where a point of the male moves by u against the point of the female that is nearest, the gap changes by its gradient
times u (``sensitivity``). What the molds grow, how far they are closed and how they are tilted move points; all else is
in the sandwich. Forces, areas and where a female balances then follow by the same code as of the press itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array
from hyperfab.pressing.balance import balance
from hyperfab.pressing.clip import positive_part
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.gap import Front, Gap
from hyperfab.pressing.mold import Growth, Pose, ungrown
from hyperfab.pressing.press import Press, contact, modes_of, stiffness
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.series import knots
from hyperfab.pressing.sums import Stack, Sums, Touched

#: The male's normal meets a wall no flatter than this: what it sees of a change is bounded.
_STEEP = 0.2
#: Over the load: what is asked of neighbours is how far apart they are, to a thousandth.
_BALANCED = 1e-5
#: Displacements (n, 3) [mm] of cold points (n, 3).
Displacement = Callable[[Array], Array]


@dataclass(frozen=True)
class _Known:
    """Gaps at one pose: of the points ``at`` (n, 3), in the female's coordinates; ``touch`` decides what touches, and
    changes by ``rate`` (n,) of what the nearest gap does."""

    gap: Gap
    at: Array
    touch: Array
    rate: Array

    @staticmethod
    def of(press: Press, pose: Pose) -> _Known:
        gap = press.gap(pose)
        _, touch = press.touch(pose, gap.nearest)
        seen = np.maximum(-(press.front.normals * gap.direction).sum(axis=1), _STEEP)
        back = gap.direction if pose.angle == 0.0 else gap.direction @ pose.rotation
        rate = np.where(touch == gap.nearest, 1.0, 1.0 / seen)
        return _Known(replace(gap, direction=back), pose.into_female(press.front.vertices), touch, rate)


@dataclass(frozen=True)
class Beside:
    """A press at ``base`` whose gaps are those ``known`` at a pose, but for the moves of the points of its ``front``
    and ``moved`` (n, 3) [mm] of the female's; whether it ``turns``."""

    front: Front
    base: Pose
    stack: Stack | ByPlace
    known: _Known
    moved: Array
    turns: bool

    def gap(self, pose: Pose) -> tuple[Array, Array]:
        """Return the nearest gap (n,) [mm] from each vertex of the front at ``pose``, and its direction (n, 3)."""
        known, direction = self.known, self.known.gap.direction
        away = pose.into_female(self.front.vertices) - known.at - self.moved
        nearest = known.gap.nearest + np.einsum("nc,nc->n", away, direction)
        return nearest, direction if pose.angle == 0.0 else direction @ pose.rotation.T

    def at(self, pose: Pose) -> Sums:
        """Return what the sandwich does with the female at ``pose``."""
        nearest, direction = self.gap(pose)
        return self.stack.sums(nearest, self.decides(nearest), direction, pose.arm, self.turns)

    def tangent(self, pose: Pose, here: Sums) -> Array:
        """Return what has been found with what acts ``here``."""
        return here.tangent

    def decides(self, nearest: Array) -> Array:
        """Return the gap that decides what touches, where the nearest one is ``nearest``."""
        return self.known.touch + self.known.rate * (nearest - self.known.gap.nearest)

    def touched_at(self) -> float:
        """Return the opening at which the sandwich is first touched, from what is known near it."""
        nearest, direction = self.gap(self.base)
        opens = -direction[:, 2]
        facing = opens > _STEEP
        return float(((self.stack.thickness - nearest)[facing] / opens[facing]).max())


@dataclass(frozen=True)
class Found:
    """What a press beside another one does.

    ``gap``        at the front's vertices (n,) [mm], and the ``touch`` that decides what touches there
    ``thickness``  of the sandwich there (n,) [mm], and its ``pressure`` (n,) [MPa]
    ``totals``     of what is pressed and touched
    ``fraction``   of the molding surface that is touched
    ``stroke``     since the first touch [mm]
    ``place``      of the female: its opening [mm] and tilt [rad]
    """

    gap: Array
    touch: Array
    thickness: Array
    pressure: Array
    totals: Sums
    fraction: float
    stroke: float
    place: Array


class Neighbourhood:
    """A press that is closed, and those beside it; ``growths`` are those of the male and the female, and ``modes`` of
    each what it may grow by besides."""

    def __init__(
        self,
        closed: Closed,
        growths: tuple[Growth, Growth],
        modes: tuple[Sequence[Growth], Sequence[Growth]] = ((), ()),
    ) -> None:
        self._closed = closed
        self._laws: tuple[FoamLaw, FoamLaw | None] | None = None
        self._knots: Array = np.zeros((5, 2))
        press, pose = closed.press, closed.pose
        first = replace(press.base, opening=closed.first_touch)
        self._known, self._first = _Known.of(press, pose), _Known.of(press, first)
        self._start = closed.clearance_cold - closed.datum.gap - pose.opening
        self._offset = np.zeros(2) if closed.case.offset is None else closed.case.offset
        self._cold = [closed.cold, self._feet(self._known, growths[1]), self._feet(self._first, growths[1])]
        self._grown = [
            growth.at(points) for growth, points in zip((growths[0], *2 * (growths[1],)), self._cold, strict=True)
        ]
        self._modes = [
            np.array([mode.at(points) for mode in each]).reshape(len(each), *points.shape)
            for each, points in zip((modes[0], *2 * (modes[1],)), self._cold, strict=True)
        ]

    def _feet(self, known: _Known, growth: Growth) -> Array:
        """Return where the female's nearest points lie on the cold mold as drawn."""
        feet = known.at - known.gap.nearest[:, None] * known.gap.direction
        return ungrown(feet - [*self._offset, self._start], growth)

    def close(
        self,
        sandwich: Sandwich,
        *,
        growths: tuple[Displacement | float, Displacement | float] = (1.0, 1.0),
        modes: tuple[Array | None, Array | None] = (None, None),
        gap: float | None,
        force: float | None,
        frame: float | None,
        tilt: tuple[float, float],
        offset: Array,
        at: tuple[float, float],
        begun: Array | None = None,
    ) -> Found:
        """Return what the press does with another ``sandwich`` and other settings.

        ``growths`` of male and female are other displacements, or factors on those there are, and ``modes`` so much of
        each mode (k,) more; balance is looked for from ``begun`` (3,) on, as ``Found.place``. Raises NotConverged where
        the female finds none.
        """
        closed = self._closed
        start = self._start if gap is None else gap - closed.datum.gap
        male, female, first = (
            (grown * by if isinstance(by, float) else by(cold))
            + (0.0 if amounts is None else np.tensordot(amounts, along, axes=1))
            for grown, by, cold, amounts, along in zip(
                self._grown,
                (growths[0], *2 * (growths[1],)),
                self._cold,
                (modes[0], *2 * (modes[1],)),
                self._modes,
                strict=True,
            )
        )
        stays = growths[0] == 1.0 and modes[0] is None
        front = closed.front if stays else _moved(closed.front, closed.cold + male)
        rise = np.array([*(offset - self._offset), start - self._start])
        mount = closed.press.base.pivot[2] + float(rise[2])
        base = Pose(0.0, tilt, (*at, mount))
        floating = closed.case.floating
        balanced = force is not None or frame is not None or floating
        stack = self._stack(front, sandwich, balanced)
        press = Beside(front, base, stack, self._known, female - self._grown[1] + rise, floating)
        pose = replace(base, opening=closed.pose.opening if force is not None else 0.0)
        if balanced:
            place = [closed.pose.opening, *(closed.pose.tilt if floating else tilt)] if begun is None else begun
            first_guess = replace(base, opening=float(place[0]), tilt=(float(place[1]), float(place[2])))
            pose, totals = balance(press, pose, force, frame, floating, first_guess, _BALANCED)
        else:
            totals = press.at(pose)
        nearest, _ = press.gap(pose)
        touch = press.decides(nearest)
        there = replace(press, known=self._first, moved=first - self._grown[2] + rise)
        return Found(
            nearest,
            touch,
            stack.thickness,
            sandwich.pressure(nearest),
            totals,
            totals.touched.counted / float(front.areas[~front.flange].sum()),
            there.touched_at() - pose.opening,
            np.array([pose.opening, *pose.tilt]),
        )

    def _stack(self, front: Front, sandwich: Sandwich, balanced: bool) -> Stack | ByPlace:
        if sandwich.law.places is not None:
            return ByPlace(front, sandwich, balanced)
        laws = sandwich.law, sandwich.fabric_law
        if self._laws is None or any(one is not two for one, two in zip(self._laws, laws, strict=True)):
            self._laws, self._knots = laws, np.array(knots(*laws))
        thick = [np.full(len(front.vertices), part, dtype=float) for part in (sandwich.foam, sandwich.fabric)]
        return Stack(front, thick[0], thick[1], self._knots)


def _moved(front: Front, vertices: Array) -> Front:
    """Return the front with its vertices elsewhere; its faces grow alike."""
    ends = [int(np.argmin(front.vertices[:, 0])), int(np.argmax(front.vertices[:, 0]))]
    before, now = (np.linalg.norm(np.diff(points[ends], axis=0)) for points in (front.vertices, vertices))
    return replace(front, vertices=vertices, areas=float(now / before) ** 2 * front.areas)


@dataclass(frozen=True)
class ByPlace:
    """A ``sandwich`` on a ``front``, given at its vertices: ``sums.Stack`` for laws without common knots. Tangents,
    which take as long again, are found only where a position is ``balanced``."""

    front: Front
    sandwich: Sandwich
    balanced: bool = True

    @cached_property
    def thickness(self) -> Array:
        """Of all (n,) [mm]."""
        return np.broadcast_to(self.sandwich.thickness, len(self.front.vertices))

    def sums(self, gap: Array, touch: Array, direction: Array, arm: Array, turns: bool = True) -> Sums:
        """Return what ``sums.Stack`` does, from the points that one press is made of."""
        front, none = self.front, np.zeros(len(gap), dtype=int)
        found = contact(front, Gap(gap, direction, none, none.astype(bool)), self.sandwich)
        tangent = np.zeros((3, 3))
        if self.balanced:
            size = 3 if turns else 1
            tangent[:size, :size] = stiffness(front, found, self.sandwich, modes_of(front.vertices, arm, turns))
        part = positive_part(np.asarray(self.thickness - touch), front.faces, front.areas)
        there = self.sandwich.at(lambda values: part.at_corners(front.faces, values))
        load = float((there.pressure(part.at_corners(front.faces, gap)) * part.area).sum())
        counted = float(part.area[~front.flange[part.face]].sum())
        touched = Touched(float(part.area.sum()), counted, load)
        return Sums(found.force, found.moment, found.load, found.energy, tangent, found.pressed_area, touched)
