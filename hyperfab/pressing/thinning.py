"""How much thinner the stretched sandwich is at each place of the mold it was draped on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hyperfab.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    corner = triangles[near.face]
    a, b, c = (nodes[corner[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    double = np.maximum((normal * normal).sum(axis=1), 1e-300)
    wb = (np.cross(near.point - a, c - a) * normal).sum(axis=1) / double
    wc = (np.cross(b - a, near.point - a) * normal).sum(axis=1) / double
    weights = np.stack([1.0 - wb - wc, wb, wc], axis=1)
    return np.asarray((weights * at_node[corner]).sum(axis=1))
