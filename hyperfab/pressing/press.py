"""The press: positions of the female over the male, and the position that balances a force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.numerics.roots import zero_between
from hyperfab.pressing.clip import Quadrature, positive_part
from hyperfab.pressing.contact import Contact, contact, modes_of, stiffness
from hyperfab.pressing.gap import Front, Gap, axial_gap, nearest_gap, normal_gap, touch_gap
from hyperfab.pressing.mold import UPRIGHT, Mold, Pose
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.surface.curve import along_a_curve

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
        return along, touch_gap(self.front, gap, along)

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
        # A gap changes by no more than the travel, so the first guess never passes the zero.
        near, step = 0.0, -start
        far = near + step
        size = float(np.ptp(self.female.vertices, axis=0).max())
        while value(far) * start > 0.0:
            near, step = far, 2.0 * step
            far = near + step
            if abs(far) > 4.0 * size:
                raise InputError(
                    "the molds never part along the closing axis" if start < 0.0 else "the molds never touch",
                    remedy="check --axis and the two STL files",
                )
        return zero_between(value, near, far, _POSITION_TOLERANCE)
