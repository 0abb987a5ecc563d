"""The Langevin function L(b) = coth b - 1/b of a freely jointed chain, and its inverse to machine precision."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.kinematics import Array
from hyperfab.materials.term import Value

#: Taylor coefficients of L at 0: b/3 - b^3/45 + ...; below SMALL nine of them leave an error under 1e-16.
_SERIES = (
    1 / 3, -1 / 45, 2 / 945, -1 / 4725, 2 / 93555, -1382 / 638512875, 4 / 18243225, -3617 / 162820783125,
    87734 / 38979295480125,
)  # fmt: skip
SMALL = 0.3


def langevin(b: Value) -> tuple[Array, Array]:
    """Return L(b) and its derivative.

    >>> langevin(1.0)[0].round(12)
    np.float64(0.313035285499)
    """
    b = np.asarray(b)
    small = np.abs(b) < SMALL
    near, far = np.where(small, b, 0.0), np.where(small, 1.0, b)
    value, slope = np.zeros_like(near), np.zeros_like(near)
    square = near * near
    for order in range(len(_SERIES) - 1, -1, -1):
        value = value * square + _SERIES[order]
        slope = slope * square + (2 * order + 1) * _SERIES[order]
    decay = np.exp(-2.0 * far)
    rest = -np.expm1(-2.0 * far)
    exact = (1.0 + decay) / rest - 1.0 / far
    exact_slope = 1.0 / far**2 - 4.0 * decay / rest**2
    return np.where(small, value * near, exact), np.where(small, slope, exact_slope)


def inverse_langevin(r: Value) -> Array:
    """Return b with L(b) = r for 0 <= r < 1, nan beyond; complex r near the real axis is followed.

    A rational start (Jedynak 2015, doi:10.1007/s00397-014-0802-2) and Newton's method on it.

    >>> inverse_langevin(0.313035285499331).round(12)
    np.float64(1.0)
    """
    r = np.asarray(r)
    r = np.where((r.real >= 0.0) & (r.real < 1.0), r, np.nan)
    b = r * (3.0 - 2.6 * r + 0.7 * r * r) / ((1.0 - r) * (1.0 + 0.1 * r))
    for _ in range(4):
        value, slope = langevin(b)
        b = b - (value - r) / slope
    return np.asarray(b)
