"""Edges, neighbours, angles and areas of a triangle mesh, in whole arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part


def face_geometry(vertices: Array, faces: Ints) -> tuple[Array, Array]:
    """Unit normals (m, 3), zero where a facet has no area, and areas (m,)."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    return cross / np.where(double == 0.0, 1.0, double)[:, None], 0.5 * double


def corner_angles(vertices: Array, faces: Ints) -> Array:
    """Angles (m, 3) in radians at the corners of each facet."""
    out = np.empty(faces.shape)
    for k in range(3):
        p = vertices[faces[:, k]]
        u = vertices[faces[:, (k + 1) % 3]] - p
        v = vertices[faces[:, (k + 2) % 3]] - p
        out[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(1))
    return out


def sides(faces: Ints, vertices: int) -> tuple[Ints, Ints]:
    """Return the ends (e, 2) of the edges of faces (m, 3), in rising order, and which are ab, bc, ca of each (m, 3).

    >>> ends, number = sides(np.array([[0, 1, 2], [2, 1, 3]]), 4)
    >>> ends.tolist(), number.tolist()
    ([[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]], [[0, 2, 1], [2, 3, 4]])
    """
    ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, number = np.unique(ends @ np.array([vertices, 1]), return_inverse=True)
    return np.stack(np.divmod(keys, vertices), axis=1), number.reshape(-1, 3)


def compact(vertices: Array, faces: Ints) -> tuple[Array, Ints]:
    """Return the vertices that faces (m, 3) use, in rising order, and the faces among them.

    >>> points, faces = compact(np.eye(3)[[0, 0, 1, 2]], np.array([[3, 0, 2]]))
    >>> len(points), faces.tolist()
    (3, [[2, 0, 1]])
    """
    used, small = np.unique(faces, return_inverse=True)
    return vertices[used], small


def incidence(faces: Ints, vertices: int) -> tuple[Ints, Ints]:
    """Facets at vertex v, in rising order: ``facets[first[v] : first[v + 1]]`` of (first, facets).

    >>> first, facets = incidence(np.array([[0, 1, 2], [2, 1, 3]]), 4)
    >>> facets[first[1] : first[2]].tolist()
    [0, 1]
    """
    first: Ints = np.zeros(vertices + 1, np.int64)
    facets = np.empty(faces.size, np.int64)
    _incidence(faces, first, facets)
    return first, facets


@kernel
def _incidence(faces: Ints, first: Ints, facets: Ints) -> None:
    for f in range(faces.shape[0]):
        for k in range(3):
            first[faces[f, k] + 1] += 1
    for v in range(1, len(first)):
        first[v] += first[v - 1]
    place = first.copy()
    for f in range(faces.shape[0]):
        for k in range(3):
            v = faces[f, k]
            facets[place[v]] = f
            place[v] += 1


def twin_edges(faces: Ints, around: tuple[Ints, Ints] | None = None) -> tuple[Ints, Ints, Ints]:
    """Neighbours over edges; ``around`` is the facets' ``incidence``, if it is known.

    Returns:
        (m, 3) facet across each edge ab, bc, ca, or -1 at a border or an edge of more than two facets;
        (m, 3) number of facets at each edge;
        (m, 3) 1 where the two facets of an edge run along it in the same sense (one of them is flipped), else 0.
    """
    first, facets = incidence(faces, int(faces.max(initial=-1)) + 1) if around is None else around
    twin, number, same = (
        np.full(faces.shape, -1),
        np.zeros(faces.shape, np.int64),
        np.zeros(faces.shape, np.int64),
    )
    _twin_edges(np.ascontiguousarray(faces), first, facets, twin, number, same)
    return twin, number, same


@kernel
def _twin_edges(faces: Ints, first: Ints, facets: Ints, twin: Ints, number: Ints, same: Ints) -> None:
    for f in range(faces.shape[0]):
        for k in range(3):
            number[f, k], twin[f, k], same[f, k] = across(faces, first, facets, f, k)


@part
def across(faces: Ints, first: Ints, facets: Ints, f: int, k: int) -> Any:
    """Number of facets at edge ``k`` of facet ``f``; the other where there are two, else -1; whether it is flipped."""
    a, b = faces[f, k], faces[f, (k + 1) % 3]
    number, other, same = 0, -1, 0
    for i in range(first[a], first[a + 1]):
        g = facets[i]
        if i > first[a] and g == facets[i - 1]:
            continue  # a facet that has the vertex twice
        for e in range(3):
            tail, head = faces[g, e], faces[g, (e + 1) % 3]
            if (tail == a and head == b) or (tail == b and head == a):
                number += 1
                if g != f or e != k:
                    other, same = g, 1 if tail == a else 0
    if number != 2:
        return number, -1, 0
    return number, other, same


@part
def feature_normal(vertices: Array, faces: Ints, first: Ints, facets: Ints, f: int, feature: int) -> Any:
    """Mean normal of a feature of facet ``f`` (see ``Nearest``), not of unit length.

    That of the face, the mean of the edge's two, or the angle-weighted mean around the vertex, with which the sign of
    a distance is right there too (Baerentzen and Aanaes, IEEE TVCG 11 (2005) 243).
    """
    if feature <= 3:
        x, y, z, _ = _unit_normal(vertices, faces, f, 0)
        if feature >= 1:
            other = across(faces, first, facets, f, feature - 1)[1]
            if other >= 0:
                u, v, w, _ = _unit_normal(vertices, faces, other, 0)
                x, y, z = x + u, y + v, z + w
        return x, y, z
    vertex = faces[f, feature - 4]
    x, y, z = 0.0, 0.0, 0.0
    for i in range(first[vertex], first[vertex + 1]):
        g = facets[i]
        corner = 0 if faces[g, 0] == vertex else (1 if faces[g, 1] == vertex else 2)
        u, v, w, angle = _unit_normal(vertices, faces, g, corner)
        x, y, z = x + angle * u, y + angle * v, z + angle * w
    return x, y, z


@part
def _unit_normal(vertices: Array, faces: Ints, f: int, corner: int) -> Any:
    """Unit normal of facet ``f``, zero where it has no area, and its angle at a corner."""
    a, b, c = faces[f, corner], faces[f, (corner + 1) % 3], faces[f, (corner + 2) % 3]
    ux, uy, uz = (
        vertices[b, 0] - vertices[a, 0],
        vertices[b, 1] - vertices[a, 1],
        vertices[b, 2] - vertices[a, 2],
    )
    vx, vy, vz = (
        vertices[c, 0] - vertices[a, 0],
        vertices[c, 1] - vertices[a, 1],
        vertices[c, 2] - vertices[a, 2],
    )
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    angle = np.arctan2(size, ux * vx + uy * vy + uz * vz)
    size = size if size > 0.0 else 1.0
    return nx / size, ny / size, nz / size, angle


@kernel
def signed(
    points: Array,
    closest: Array,
    face: Ints,
    feature: Ints,
    vertices: Array,
    faces: Ints,
    first: Ints,
    facets: Ints,
    touching: float,
    distance: Array,
    normal: Array,
) -> None:
    """Fill signed ``distance`` (n,) and ``normal`` (n, 3) of points whose nearest points are known (see ``Nearest``).

    Nearer than ``touching`` the feature's normal stands for the direction.
    """
    for i in range(len(points)):
        x, y, z = feature_normal(vertices, faces, first, facets, face[i], feature[i])
        dx, dy, dz = points[i, 0] - closest[i, 0], points[i, 1] - closest[i, 1], points[i, 2] - closest[i, 2]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        distance[i] = -length if dx * x + dy * y + dz * z < 0.0 else length
        if length > touching:
            x, y, z, size = dx, dy, dz, distance[i]
        else:
            size = np.sqrt(x * x + y * y + z * z)
            size = size if size > 0.0 else 1.0
        normal[i, 0], normal[i, 1], normal[i, 2] = x / size, y / size, z / size
