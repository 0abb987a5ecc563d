"""Foam that is not equally thick everywhere: a plane or a quadric over the plan of the male."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def thickness_factor(points: Array, terms: Mapping[str, float]) -> Array:
    """Return the foam's thickness (n,) at ``points`` (n, 3) [mm], as a share of its nominal one.

    ``terms`` are the coefficients of a polynomial in the coordinates, each scaled to -1 to 1 over the points: a term
    is named by its coordinates, as ``x`` or ``xy``.

    >>> import numpy as np
    >>> thickness_factor(np.array([[0, 0, 0], [10, 4, 0.0]]), {"x": 0.05, "xy": -0.01}).tolist()
    [0.94, 1.04]
    """
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.5 * (high - low)
    scaled = (points - 0.5 * (low + high)) / np.where(half > 0.0, half, 1.0)
    factor = np.ones(len(points))
    for name, coefficient in terms.items():
        factor += coefficient * np.prod([scaled[:, "xyz".index(axis)] for axis in name], axis=0)
    return factor
