"""Half a torso: a chest with two domes and the valley between them, closed below; a mold that is concave somewhere.

Its surface is z = 34 b(x/150, y/105) + 40 [b((x - 42)/46, (y + 8)/46) + b((x + 42)/46, (y + 8)/46)], with the bump
b(u, v) = (1 - u^2 - v^2)^3 where that is positive: smooth to the second derivative, and of sums and products alone, so
that the file has the same bytes everywhere. Lengths in mm.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.samples.cup import Solid, closed_below

BACK_MM = -30.0
_HALF_X, _HALF_Y = 130.0, 95.0
_CHEST = (34.0, 0.0, 0.0, 150.0, 105.0)
_DOMES = ((40.0, 42.0, -8.0, 46.0, 46.0), (40.0, -42.0, -8.0, 46.0, 46.0))


def torso(cells_x: int = 52, cells_y: int = 38) -> Solid:
    """Return the mold as a watertight solid; its mounting face is z = -30 mm.

    >>> torso(8, 8).vertices[:, 2].min()
    np.float64(-30.0)
    """
    x = np.arange(cells_x + 1) * (2.0 * _HALF_X / cells_x) - _HALF_X
    y = np.arange(cells_y + 1) * (2.0 * _HALF_Y / cells_y) - _HALF_Y
    grid = np.stack([*np.meshgrid(x, y, indexing="ij")], axis=-1)
    return closed_below(np.concatenate([grid, height(grid[..., 0], grid[..., 1])[..., None]], axis=-1), BACK_MM)


def height(x: Array, y: Array) -> Array:
    """Return the height (...) [mm] of the chest at ``x``, ``y``.

    >>> float(height(np.array(150.0), np.array(0.0)))
    0.0
    """
    found = np.zeros(np.broadcast(x, y).shape)
    for top, at_x, at_y, wide, long in (_CHEST, *_DOMES):
        u, v = (x - at_x) / wide, (y - at_y) / long
        left = np.maximum(0.0, 1.0 - u * u - v * v)
        found = found + top * left * left * left
    return found
