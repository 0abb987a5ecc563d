"""One position of the press: pressure, force, moments and the area that touches; positions of the female over the male,
and the one that balances a force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.numerics.roots import zero_between
from hyperfab.pressing.clip import Quadrature, positive_part
from hyperfab.pressing.gap import Front, Gap, axial_gap, nearest_gap, normal_gap, touch_gap
from hyperfab.pressing.mold import UPRIGHT, Mold, Pose
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.sums import Totals
from hyperfab.surface.curve import along_a_curve


@dataclass(frozen=True)
class Contact(Totals):
    """What the sandwich does at one position.

    ``gap`` (n,) [mm], its ``direction`` (n, 3) and the ``pressure`` (n,) [MPa] at the vertices of the front, from the
    nearest distance. ``pressed`` are the quadrature points of the totals, ``face`` (n,) the female's nearest faces.
    """

    gap: Array
    direction: Array
    face: Ints
    pressure: Array
    pressed: Quadrature

    @property
    def pressed_area(self) -> float:
        """Area [mm^2] of the male that bears: its nearest gap is less than the sandwich."""
        return float(self.pressed.area.sum())


def contact(front: Front, gap: Gap, sandwich: Sandwich) -> Contact:
    """Press the sandwich: the pressure acts along the direction to the nearest point, on the male's area.

    That direction is the gradient of the nearest gap, so the force is exactly the rate at which the stored energy
    grows with the travel.
    """
    points = positive_part(np.asarray(sandwich.thickness - gap.nearest), front.faces, front.areas)
    there = sandwich.at(partial(points.at_corners, front.faces))
    gap_there = points.at_corners(front.faces, gap.nearest)
    pressure, energy = there.borne(gap_there)
    load = pressure * points.area
    # The gap's gradient points from the female to the male: so does the push on the male.
    force, moment = points.resultant(front.faces, load, gap.direction, front.vertices)
    return Contact(
        gap=gap.nearest,
        direction=gap.direction,
        face=gap.face,
        pressure=sandwich.pressure(gap.nearest),
        force=force,
        moment=moment,
        load=float(load.sum()),
        energy=float((energy * points.area).sum()),
        pressed=points,
    )


def modes_of(points: Array, arm: Array, turns: bool = True) -> Array:
    """Return what raising the female by 1 mm and, where it ``turns``, turning it by 1 rad about x and y through ``arm``
    (3,) are for ``points`` (n, 3) [mm] of the male: displacements (n, 3, 1 or 3), the other way."""
    modes = np.zeros((len(points), 3, 3 if turns else 1))
    modes[:, 2, 0] = -1.0
    if turns:
        modes[:, :, 1] = -np.cross([1.0, 0.0, 0.0], points - arm)
        modes[:, :, 2] = -np.cross([0.0, 1.0, 0.0], points - arm)
    return modes


def stiffness(front: Front, result: Contact, sandwich: Sandwich, modes: Array) -> Array:
    """Return the tangent (d, d) of the force along ``modes`` (n, 3, d): displacements of the male per unit.

    The term of the turning directions is left out: it is small beside the foam's own, and without it the tangent
    is symmetric and never negative.
    """
    points = result.pressed
    gap = points.at_corners(front.faces, result.gap)
    rate = sandwich.at(partial(points.at_corners, front.faces)).stiffness(gap) * points.area
    closing = points.at_corners(front.faces, np.einsum("nc,ncd->nd", result.direction, modes))
    return np.asarray(np.einsum("kq,kqd,kqe->de", rate, closing, closing))


#: Positions are solved to this [mm]; forces follow to about 1e-9 of their stiffness.
_POSITION_TOLERANCE = 1e-9
#: Nearer than this [mm] two places touch, and no direction leads from one to the other: that of the male's place so far
#: [mm] before it met the female, as the press closes, stands for it.
_TOUCHED, _BEFORE = 1e-8, 1e-6


@dataclass(frozen=True)
class Press:
    """A male's front, the female over it, and the sandwich between them.

    A position is an ``opening`` [mm]: how much further the female stands from the male than where it was given. On
    its way it is turned as ``base`` says.
    """

    front: Front
    female: Mold
    sandwich: Sandwich
    base: Pose = UPRIGHT

    def at(self, pose: Pose | float) -> Contact:
        """Return what the sandwich does with the female at ``pose``, or raised by an opening [mm] from ``base``."""
        pose = pose if isinstance(pose, Pose) else replace(self.base, opening=float(pose))
        return contact(self.front, self.gap(pose), self.sandwich)

    def tangent(self, pose: Pose, here: Contact) -> Array:
        """Return the tangent (3, 3) of the force by raising the female and turning it about x and y through its pivot:
        N/mm, N and N mm."""
        return stiffness(self.front, here, self.sandwich, modes_of(self.front.vertices, pose.arm))

    def gap(self, pose: Pose) -> Gap:
        """Return the nearest gap from each vertex of the front to the female at ``pose``."""
        # Not the female is moved but the points against it: its search tree stays as it is.
        points = self.front.vertices
        gap = nearest_gap(pose.into_female(points), self.female, self._order)
        touched = np.flatnonzero(np.abs(gap.nearest) <= _TOUCHED)
        if len(touched):
            before = pose.into_female(points[touched])
            # Along a common wall a place may have gone on since; fmin: none goes on where no female is above.
            before[:, 2] += np.fmin(axial_gap(before, self.female), 0.0) - _BEFORE
            gap.direction[touched] = nearest_gap(before, self.female).direction
        return gap if pose.angle == 0.0 else replace(gap, direction=gap.direction @ pose.rotation.T)

    def touch(self, pose: Pose, gap: Array) -> tuple[Array, Array]:
        """Return the gaps (n,) [mm] along the male's normals with the female at ``pose``, NaN where they miss, and
        those that decide what touches; ``gap`` are the nearest ones there."""
        turned = self.front.normals if pose.angle == 0.0 else self.front.normals @ pose.rotation
        along = normal_gap(pose.into_female(self.front.vertices), turned, self.female)
        return along, touch_gap(gap, along)

    def touching(self, touch: Array) -> Quadrature:
        """Return points over the area that is touched: where the gap that decides is less than the sandwich."""
        return positive_part(np.asarray(self.sandwich.thickness - touch), self.front.faces, self.front.areas)

    @cached_property
    def _order(self) -> Ints:
        return along_a_curve(self.front.vertices)

    @cached_property
    def first_touch(self) -> float:
        """The opening at which the sandwich is first touched when the press closes."""
        return self._opening_where(lambda gap: float(np.min(gap - self.sandwich.thickness)))

    @cached_property
    def metal_contact(self) -> float:
        """The opening at which the bare molds would touch."""
        return self._opening_where(lambda gap: float(np.min(gap)))

    def opening_for(self, force: float) -> float:
        """Return the opening at which the sandwich carries ``force`` [N].

        Raises InputError where the molds touch before, naming the largest force the sandwich can carry.
        """
        low, high = self.metal_contact, self.first_touch
        largest = self.at(low).closing_force
        if force > largest:
            raise InputError(
                f"--force {force:.6g} N is out of reach: the molds touch at {largest:.6g} N",
                remedy=f"the largest force the sandwich can carry is {largest:.6g} N",
            )
        # At the first touch, found to a tolerance, a force that is next to nothing may be passed already.
        while self.at(high).closing_force >= force:
            high += max(high - low, _POSITION_TOLERANCE)
        return zero_between(lambda s: self.at(s).closing_force - force, low, high, _POSITION_TOLERANCE)

    def _opening_where(self, margin: Callable[[Array], float]) -> float:
        """Return the opening at which a margin of the gaps, growing with the opening, is zero."""

        def value(opening: float) -> float:
            return margin(self.gap(replace(self.base, opening=opening)).nearest)

        start = value(0.0)
        if start == 0.0:
            return 0.0
        # A gap changes by no more than the travel, so the first guess never passes the zero; what then is left of the
        # margin says how far to go on: whole steps would leap through the molds, where its rounding alone is left.
        near, left, factor = 0.0, start, 1.0
        far = -start
        farthest = abs(start) + 4.0 * float(np.ptp(self.female.vertices, axis=0).max())
        while (margin_there := value(far)) * start > 0.0:
            near, left, factor = far, margin_there, 2.0 * factor
            far = near - factor * left
            if abs(far) > farthest:
                raise InputError(
                    "the molds never part along the closing axis" if start < 0.0 else "the molds never touch",
                    remedy="check --axis and the two STL files",
                )
        return zero_between(value, near, far, _POSITION_TOLERANCE)
