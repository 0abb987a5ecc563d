"""Softening of rubber and fabric below the largest stretch they have seen."""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from hyperfab.materials.kinematics import Array


def softened(energy: Array, greatest: Array, amount: float, scale: float, beta: float = 0.0) -> Array:
    """Return the factor ``1 - amount erf((Wm - W) / (scale + beta Wm))`` on the stress, 1 on the first pull.

    ``amount`` is 1/r. Ogden & Roxburgh (1999), Proc. R. Soc. A 455, 2861, doi:10.1098/rspa.1999.0431, with
    the ``beta`` of Mars and of Dorfmann.

    >>> softened(np.array([1.0]), np.array([1.0]), 0.5, 0.1)
    array([1.])
    """
    return np.asarray(1.0 - amount * erf(np.maximum(greatest - energy, 0.0) / (scale + beta * greatest)))


def weakened(stretch: Array, peak: Array, amount: float, power: float) -> Array:
    """Return the factor ``1 - amount (1 - (strain/peak strain)^power)``: softening measured in strain, 1 at the peak.

    A factor of strain amplification that is 1 on the first pull: Zuniga & Beatty (2002),
    doi:10.1016/S0020-7225(02)00140-4.

    >>> weakened(np.array([1.5]), np.array([1.5]), 0.3, 1.0)
    array([1.])
    """
    share = np.clip((stretch - 1.0) / np.maximum(peak - 1.0, 1e-12), 1e-12, 1.0)
    return np.asarray(1.0 - amount * (1.0 - share**power))


def damaged(peak: Array, amount: float, strain: float) -> Array:
    """Return the factor ``1 - amount (1 - exp(-(peak - 1)/strain))``: damage by the largest stretch.

    Simo (1987), Comput. Methods Appl. Mech. Eng. 60, 153, doi:10.1016/0045-7825(87)90107-1.

    >>> damaged(np.array([1.0]), 0.5, 0.3)
    array([1.])
    """
    return np.asarray(1.0 + amount * np.expm1(-(peak - 1.0) / strain))
