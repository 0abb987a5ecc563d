"""Corners of a surface that nearly coincide made one, as files hold them whose corners were rounded facet by facet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.surface.topology import twin_edges

#: Welding distances tried, as shares of the surface's size.
WELDS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 5e-4)
#: Corners are rounded where no edge of a facet is so few times as long as they are apart.
_FAR_BELOW = 10.0


@dataclass(frozen=True)
class Welded:
    """A surface whose corners were made one: ``vertices`` (n, 3) [mm], ``faces`` (m, 3), of which each was the one
    numbered ``kept`` (m,), less those without area and those that stood twice; how far a corner ``moved`` [mm] at most,
    of those within ``distance`` [mm].
    """

    vertices: Array
    faces: Ints
    kept: Ints
    moved: float
    distance: float


def size_of(vertices: Array) -> float:
    """Return the diagonal [mm] of the box around vertices (n, 3)."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def rim(vertices: Array, faces: Ints) -> Flags:
    """Whether a vertex lies on an open edge (n,)."""
    found = np.zeros(len(vertices), dtype=bool)
    found[open_edges(faces)[1].ravel()] = True
    return found


def open_edges(faces: Ints) -> tuple[Ints, Ints]:
    """Return the facets of open edges (e,), and the ends of these (e, 2) in the facet's sense."""
    _, number, _ = twin_edges(faces)
    face, side = np.nonzero(number == 1)
    return face, np.stack([faces[face, side], faces[face, (side + 1) % 3]], axis=1)


def welded(vertices: Array, faces: Ints, distance: float, where: Flags) -> Welded:
    """Make one, at their mean, of the vertices ``where`` (n,) that are chained by steps of ``distance`` [mm].

    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1e-7, 0], [0, 1, 0], [1, 1, 0]])
    >>> welded(corners, np.array([[0, 1, 2], [3, 5, 4]]), 1e-6, np.ones(6, bool)).faces
    array([[0, 1, 2],
           [1, 3, 2]])
    """
    if distance > 0.0:
        chosen = np.flatnonzero(where)
        pairs = chosen[cKDTree(vertices[chosen]).query_pairs(distance, output_type="ndarray")]
        graph = sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(vertices),) * 2)
        count, label = connected_components(graph, directed=False)
        weight = np.bincount(label, minlength=count)
        points = np.stack([np.bincount(label, vertices[:, i], count) / weight for i in range(3)], axis=1)
        moved = float(np.linalg.norm(points[label] - vertices, axis=1).max())
        faces = label[faces].astype(np.int64)
    else:
        points, moved = vertices, 0.0
    distinct = np.flatnonzero(
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    _, first = np.unique(np.sort(faces[distinct], axis=1), axis=0, return_index=True)
    kept = distinct[np.sort(first)]
    return Welded(points, faces[kept], kept, moved, distance)


def unrounded(vertices: Array, faces: Ints) -> Welded | None:
    """Return an open surface with the corners of its rims made one that differ by rounding, or None where none do.

    Of the distances of ``WELDS`` the smallest with which the fewest edges are open or have more than two facets, if no
    edge of a facet is nearly as short, and no facet all of whose edges are: that would be a detail of the surface.
    """
    fewest = _loose(faces)
    if fewest == 0:
        return None
    ends = vertices[faces]
    edge = np.linalg.norm(ends - np.roll(ends, -1, axis=1), axis=2)
    size, border = size_of(vertices), rim(vertices, faces)
    best = None
    for distance in (share * size for share in WELDS if share > 0.0):
        short = edge < _FAR_BELOW * distance
        if short.all(axis=1).any() or (short & (edge > distance)).any():
            continue
        one = welded(vertices, faces, distance, border)
        if one.moved > 0.0 and len(one.faces) and (loose := _loose(one.faces)) < fewest:
            best, fewest = one, loose
    return best


def _loose(faces: Ints) -> int:
    """Return of how many sides of facets the edge has not two facets."""
    return int((twin_edges(faces)[1] != 2).sum())
