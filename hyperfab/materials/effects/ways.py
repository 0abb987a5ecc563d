"""How much more of an effect there is in one direction and mode of a sheet than in another."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, SHEAR, Acts, Path, State
from hyperfab.materials.law import Array

#: The root of ``I1 - 3`` at a small strain, over that of a strip: held across, and pulled both ways.
_SHEAR, _BIAXIAL = 2.0 / np.sqrt(3.0), 2.0


def amount(path: Path, weft: float, modes: float) -> Array:
    """Return how much of an effect each row has, 1 in a strip along the warp.

    ``1 + weft s`` with the weft's share s, times the ``modes``-th power of the root of ``I1 - 3`` at a small strain
    over that of a strip: 0 for an effect that rides on the strain along the pull, 1 on the root of the energy.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> amount(uniaxial_pull(np.array([1.2]), 90.0), 0.5, 1.0)
    array([1.5])
    """
    severity = np.where(path.mode == BIAXIAL, _BIAXIAL, np.where(path.mode == SHEAR, _SHEAR, 1.0))
    return np.asarray(np.maximum(1.0 + weft * path.weft_share, 0.0) * severity**modes)


def each_way(acts: Acts) -> Acts:
    """Return the form whose change of the stress is another each way; its last two values are those of ``amount``."""

    def act(at: State, stress: Array, values: Array) -> Array:
        return np.asarray(stress + amount(at.path, *values[-2:]) * (acts(at, stress, values[:-2]) - stress))

    return act
