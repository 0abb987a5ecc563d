"""Two directions with constants of their own."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, GENERAL, SHEAR, Path
from hyperfab.materials.kinematics import Array


def weft_share(path: Path) -> Array:
    """Return how much of the weft's answer a row has: sin^2 of the angle from the warp; half in an equibiaxial test."""
    angle = np.radians(path.angle_deg)
    share = np.where(path.mode == BIAXIAL, 0.5, np.sin(angle) ** 2)
    # Rows without a direction answer like the warp.
    share = np.where(np.isfinite(share), share, 0.0)
    # sin(90 deg) squared is 1 to rounding; the weft is the weft.
    return np.asarray(np.where(np.abs(share - 1.0) < 1e-12, 1.0, share))


def fibres(path: Path, stretch: Array, warp: float, weft: float, growth: float) -> tuple[Array, Array]:
    """Return stress [MPa] and energy of fibres along warp and weft: ``sum k/(2 g) (exp(g <I4 - 1>^2) - 1)``.

    ``warp`` and ``weft`` are their stiffness k [MPa], ``growth`` g how they stiffen; they bear tension only. The ground
    contracts as if it were alone. Holzapfel, Gasser & Ogden (2000), doi:10.1023/A:1010835316564; at ``growth`` 0 the
    standard reinforcing model.
    """
    share = weft_share(path)
    across = np.where(path.mode == GENERAL, path.across, np.where(path.mode == SHEAR, 1.0, stretch**-0.5))
    across = np.where(path.mode == BIAXIAL, stretch, across)
    stress, energy = np.zeros_like(stretch), np.zeros_like(stretch)
    for stiffness, along in ((warp, 1.0 - share), (weft, share)):
        strain = np.maximum(stretch**2 * along + across**2 * (1.0 - along) - 1.0, 0.0)
        grown = np.exp(np.minimum(growth * strain**2, 300.0))
        stress = stress + 2.0 * stiffness * along * stretch * strain * grown
        shape = np.expm1(np.minimum(growth * strain**2, 300.0)) / growth if growth else strain**2
        energy = energy + 0.5 * stiffness * shape
    return stress, energy
