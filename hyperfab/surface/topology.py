"""Edges, neighbours, angles and areas of a triangle mesh, in whole arrays."""

from __future__ import annotations

import numpy as np

from .bvh import Floats, Ints


def face_geometry(vertices: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Unit normals (m, 3), zero where a facet has no area, and areas (m,)."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    return cross / np.where(double == 0.0, 1.0, double)[:, None], 0.5 * double


def corner_angles(vertices: Floats, faces: Ints) -> Floats:
    """Angles (m, 3) in radians at the corners of each facet."""
    out = np.empty(faces.shape)
    for k in range(3):
        p = vertices[faces[:, k]]
        u = vertices[faces[:, (k + 1) % 3]] - p
        v = vertices[faces[:, (k + 2) % 3]] - p
        out[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(1))
    return out


def twin_edges(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Neighbours over edges.

    Returns:
        (m, 3) facet across each edge ab, bc, ca, or -1 at a border or an edge of more than two facets;
        (m, 3) number of facets at each edge;
        (m, 3) 1 where the two facets of an edge run along it in the same sense (one of them is flipped), else 0.
    """
    m = len(faces)
    tail = faces.ravel()
    head = faces[:, [1, 2, 0]].ravel()
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    order = np.lexsort((high, low))
    new = np.ones(3 * m, bool)
    new[1:] = (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)
    group = np.cumsum(new) - 1
    size = np.bincount(group)
    first = np.flatnonzero(new)
    pairs = np.flatnonzero(size == 2)
    one, two = order[first[pairs]], order[first[pairs] + 1]
    twin = np.full(3 * m, -1)
    twin[one], twin[two] = two // 3, one // 3
    same = np.zeros(3 * m, np.int64)
    same[one] = same[two] = tail[one] == tail[two]
    number = np.empty(3 * m, np.int64)
    number[order] = size[group]
    return twin.reshape(m, 3), number.reshape(m, 3), same.reshape(m, 3)
