"""Surfaces for the page: the outside of a grid, its fields, and fewer triangles where there are too many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.io.vtu_read import Grid

#: A view of more triangles than this turns slowly on a phone, and weighs on the page.
MAX_TRIANGLES = 24_000

# Corners of the faces of a tetrahedron.
_FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@dataclass(frozen=True)
class Surface:
    """Triangles to show: ``points`` (n, 3) [mm], ``triangles`` (m, 3), ``origin`` (n,) the grid's node of each point.

    ``cells`` (m,) is the grid's cell of each triangle. ``moved_mm`` is how far thinning out moved a point at most
    (0: every point is where the grid has it).
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    origin: NDArray[np.int64]
    cells: NDArray[np.int64]
    moved_mm: float = 0.0
    whole: int = 0


def outside(grid: Grid) -> Surface:
    """Return the triangles of a grid of triangles, quads or tetrahedra (of these the outer faces)."""
    triangles, cells, start = [], [], 0
    for kind, nodes in grid.cells.items():
        own = np.arange(start, start + len(nodes))
        start += len(nodes)
        if kind == "triangle6":
            for part in ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]):
                triangles.append(nodes[:, part])
                cells.append(own)
        elif kind == "triangle":
            triangles.append(nodes)
            cells.append(own)
        elif kind == "quad":
            triangles += [nodes[:, [0, 1, 2]], nodes[:, [0, 2, 3]]]
            cells += [own, own]
        elif kind in ("tetra", "tetra10"):
            faces = nodes[:, :4][:, _FACES].reshape(-1, 3)
            _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
            outer = np.sort(first[count == 1])
            triangles.append(faces[outer])
            cells.append(own[outer // 4])
    if not triangles:
        raise ValueError("the grid has no surface to show")
    faces = np.concatenate(triangles)
    used, compact = np.unique(faces, return_inverse=True)
    return Surface(grid.points[used], compact.reshape(-1, 3), used, np.concatenate(cells), whole=len(faces))


def thinned(surface: Surface, most: int = MAX_TRIANGLES) -> Surface:
    """Return a surface of at most ``most`` triangles: points that share a cube of space become one of them.

    It is the one nearest to their mean: every point that stays has the field's own values on it.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> flat = Surface(corners, np.array([[0, 1, 2]]), np.arange(3), np.zeros(1, int))
    >>> thinned(flat) is flat
    True
    """
    if len(surface.triangles) <= most:
        return surface
    size = float(np.ptp(surface.points, axis=0).max()) * (1.0 / np.sqrt(most))
    while True:
        thin = _clustered(surface, size)
        if len(thin.triangles) <= most:
            return thin
        size *= 1.15


def _clustered(surface: Surface, size: float) -> Surface:
    places = np.floor((surface.points - surface.points.min(axis=0)) / size).astype(np.int64)
    _, cluster = np.unique(places, axis=0, return_inverse=True)
    cluster = cluster.ravel()
    count = np.bincount(cluster)
    mean = np.stack([np.bincount(cluster, surface.points[:, axis]) / count for axis in range(3)], axis=1)
    distance = np.linalg.norm(surface.points - mean[cluster], axis=1)
    order = np.lexsort((distance, cluster))
    keep = order[np.r_[True, np.diff(cluster[order]) > 0]]
    moved = float(np.linalg.norm(surface.points - surface.points[keep][cluster], axis=1).max())
    triangles = cluster[surface.triangles]
    real = (
        (triangles[:, 0] != triangles[:, 1])
        & (triangles[:, 1] != triangles[:, 2])
        & (triangles[:, 2] != triangles[:, 0])
    )
    _, first = np.unique(np.sort(triangles[real], axis=1), axis=0, return_index=True)
    chosen = np.flatnonzero(real)[np.sort(first)]
    return Surface(
        surface.points[keep],
        triangles[chosen],
        surface.origin[keep],
        surface.cells[chosen],
        moved,
        surface.whole,
    )
