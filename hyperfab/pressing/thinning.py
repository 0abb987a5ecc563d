"""How thick the sandwich is at each place of the mold: a sheet that was stretched, a foam that varies over the plan."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.curved import barycentric
from hyperfab.surface import Surface


def thinning_at(points: Array, nodes: Array, quads: Ints, factor: Array) -> Array:
    """Return the thinning (n,) at ``points`` (n, 3) [mm]: that of the sheet's nearest place.

    ``nodes`` (k, 3) [mm] and ``quads`` (m, 4) are the draped sheet, ``factor`` (m,) its thickness over that of the
    flat sheet in each quad. Between the middles of the quads it is interpolated.

    >>> import numpy as np
    >>> nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> thinning_at(np.array([[0.3, 0.3, 5.0]]), nodes, np.array([[0, 1, 2, 3]]), np.array([0.5])).tolist()
    [0.5]
    """
    count = np.bincount(quads.ravel(), minlength=len(nodes))
    total = np.bincount(quads.ravel(), weights=np.repeat(factor, 4), minlength=len(nodes))
    at_node = total / np.maximum(count, 1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    sheet = Surface(nodes, triangles)
    near = sheet.nearest(points)
    weights = barycentric(sheet, near.face, near.point)
    return np.asarray((weights * at_node[triangles[near.face]]).sum(axis=1))


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
