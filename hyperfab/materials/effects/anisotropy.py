"""Two directions with constants of their own."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, Path
from hyperfab.materials.kinematics import Array


def weft_share(path: Path, diagonal: float = 0.0) -> tuple[Array, Array]:
    """Return how much of the weft's answer a row has, and the factor on the whole: sin^2 of the angle from the warp.

    An equibiaxial test has half of each. ``diagonal`` is the share of stiffness missing half-way between
    the yarns, where a fabric shears: ``1 - diagonal sin^2(2 angle)``.
    """
    angle = np.radians(path.angle_deg)
    share = np.where(path.mode == BIAXIAL, 0.5, np.sin(angle) ** 2)
    # Rows without a direction answer like the warp.
    share = np.where(np.isfinite(share), share, 0.0)
    # sin(90 deg) squared is 1 to rounding; the weft is the weft.
    share = np.where(np.abs(share - 1.0) < 1e-12, 1.0, share)
    softer = 1.0 - diagonal * np.where(np.isfinite(angle), np.sin(2.0 * angle) ** 2, 0.0)
    return share, np.asarray(softer)
