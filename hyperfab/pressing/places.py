"""What a sandwich does over a front where the foam's law is another at each place, for presses beside one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array
from hyperfab.pressing.clip import positive_part
from hyperfab.pressing.contact import contact, stiffness
from hyperfab.pressing.gap import Front, Gap
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.sums import Sums, Touched


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
            # Raising or turning the female is the male moving the other way.
            modes = np.zeros((len(gap), 3, 3 if turns else 1))
            modes[:, 2, 0] = -1.0
            if turns:
                lever = front.vertices - arm
                modes[:, :, 1] = -np.cross([1.0, 0.0, 0.0], lever)
                modes[:, :, 2] = -np.cross([0.0, 1.0, 0.0], lever)
            size = modes.shape[2]
            tangent[:size, :size] = stiffness(front, found, self.sandwich, modes)
        part = positive_part(np.asarray(self.thickness - touch), front.faces, front.areas)
        there = self.sandwich.at(lambda values: part.at_corners(front.faces, values))
        load = float((there.pressure(part.at_corners(front.faces, gap)) * part.area).sum())
        counted = float(part.area[~front.flange[part.face]].sum())
        touched = Touched(float(part.area.sum()), counted, load)
        return Sums(found.force, found.moment, found.load, found.energy, tangent, found.pressed_area, touched)
