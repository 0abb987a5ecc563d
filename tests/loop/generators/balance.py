"""How a sheet stands that is pulled one way: what it does across and through its thickness, where nothing holds it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Table(NamedTuple):
    """Nominal stress [MPa], width and thickness of a cloth over its stretch."""

    stretch: Array
    stress: Array
    width: Array
    thickness: Array

    def at(self, stretch: Array) -> Array:
        """Return the stress at stretches [MPa], below rest by the slope there: a part that is pushed by the others."""
        slope = self.stress[1] / (self.stretch[1] - 1.0)
        return np.interp(stretch, self.stretch, self.stress) + slope * np.minimum(stretch - 1.0, 0.0)


def bisected(rises: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Return where a rising function is zero between two bounds (n,)."""
    for _ in range(30):
        middle = 0.5 * (low + high)
        over = rises(middle) > 0.0
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return 0.5 * (low + high)


def balanced(
    first: Array, mode: str, thickness: Callable[[Array], Array], taus: Callable[[Array, Array], Array]
) -> Table:
    """Return what a sheet answers in uniaxial tension, planar tension or equal biaxial tension, stretched by ``first``.

    ``thickness`` is what stretches across make of it, ``taus`` are the true stresses (3, n) by stretches across and
    through. Raises ValueError for another mode.
    """
    if mode == "uniaxial":
        h = np.log(first)

        def across(wide: Array) -> Array:
            second = np.exp(wide)
            found = taus(second, thickness(second))
            return found[1] - found[2]

        second = np.exp(bisected(across, -1.6 * h - 1e-9, 0.3 * h + 1e-9))
    elif mode in ("shear", "biaxial"):
        second = first if mode == "biaxial" else np.ones_like(first)
    else:
        raise ValueError(f"no cloth of this set is tested in {mode}")
    third = thickness(second)
    found = taus(second, third)
    return Table(first, (found[0] - found[2]) / first, second, third)
