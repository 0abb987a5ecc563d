"""Ten-node tetrahedra (VTK's node order): shape functions, boundary, values at the boundary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.curved import barycentric
from hyperfab.surface import Surface

#: Ends of the edges whose middles are nodes 4 to 9.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
#: Corners of the faces, and the middles of their edges ab, bc, ca.
FACES = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6))

# Fourth-order rule of eleven points: P. Keast, Comput. Meth. Appl. Mech. Eng. 55 (1986) 339.
_C, _D = 0.399403576166799, 0.100596423833201
_E, _F = 0.785714285714286, 0.071428571428571
_POINTS = np.array(
    [[0.25] * 4]
    + [[_E if k == corner else _F for k in range(4)] for corner in range(4)]
    + [[_C if k in edge else _D for k in range(4)] for edge in EDGES]
)
_WEIGHTS = np.array([-0.013155555555556] + [0.007622222222222] * 4 + [0.024888888888889] * 6)


@dataclass(frozen=True)
class TetraMesh:
    """``points`` (n, 3) [mm] and ``elements`` (m, 10)."""

    points: Array
    elements: Ints


@dataclass(frozen=True)
class Samples:
    """At 11 quadrature points of some elements: shape functions ``value`` (11, 10), their gradients ``slope``
    (m, 11, 10, 3) [1/mm], and the ``volume`` (m, 11) [mm^3] of each point."""

    value: Array
    slope: Array
    volume: Array


def merged(points: Array, elements: Ints) -> tuple[TetraMesh, Ints]:
    """Return the mesh with nodes at one place made one (parts that touch move together), and each node's number."""
    span = float(np.ptp(points, axis=0).max())
    key = np.round(points / (1e-9 * span)).astype(np.int64)
    _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    number = number.reshape(-1)
    return TetraMesh(points[first], number[elements]), number


def samples(mesh: TetraMesh, chosen: slice) -> Samples:
    """Return shape functions and gradients at the quadrature points of some elements, their sides curved or not."""
    value = shape(_POINTS)
    local = _slopes(_POINTS)
    nodes = mesh.points[mesh.elements[chosen]]
    jacobian = np.einsum("qad,mai->mqid", local, nodes)
    size = np.linalg.det(jacobian)
    slope = np.einsum("qad,mqdi->mqai", local, np.linalg.inv(jacobian))
    return Samples(value, slope, np.abs(size) * _WEIGHTS)


def shape(barycentric: Array) -> Array:
    """Return the ten shape functions (q, 10) at barycentric places (q, 4).

    >>> float(shape(np.array([[0.5, 0.5, 0.0, 0.0]]))[0, 4])
    1.0
    """
    corner = barycentric * (2.0 * barycentric - 1.0)
    middle = np.stack([4.0 * barycentric[:, a] * barycentric[:, b] for a, b in EDGES], axis=1)
    return np.concatenate([corner, middle], axis=1)


def boundary(mesh: TetraMesh) -> Ints:
    """Return the outer faces (k, 6): corners and edge middles, seen from outside counter-clockwise."""
    faces = np.concatenate([mesh.elements[:, face] for face in FACES])
    key = np.sort(faces[:, :3], axis=1)
    _, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    return faces[count[inverse.reshape(-1)] == 1]


def at_boundary(mesh: TetraMesh, faces: Ints, values: Array, places: Array) -> tuple[Array, Array]:
    """Return nodal ``values`` (n, ...) at the boundary points nearest to ``places`` (k, 3), and the distances (k,) [mm]
    of the curved sides there."""
    surface = Surface(mesh.points, faces[:, :3])
    near = surface.nearest(places)
    w = barycentric(surface, near.face, near.point)
    weights = np.concatenate([w * (2.0 * w - 1.0), 4.0 * w * np.roll(w, -1, axis=1)], axis=1)
    nodes = faces[near.face]
    away = np.einsum("ka,kad->kd", weights, mesh.points[nodes]) - places
    return np.einsum("ka,ka...->k...", weights, values[nodes]), np.linalg.norm(away, axis=1)


def _slopes(barycentric: Array) -> Array:
    """Gradients (q, 10, 3) of the shape functions over the reference tetrahedron."""
    by_corner = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corner = (4.0 * barycentric - 1.0)[..., None] * by_corner
    middle = np.stack(
        [4.0 * (barycentric[:, a, None] * by_corner[b] + barycentric[:, b, None] * by_corner[a]) for a, b in EDGES],
        axis=1,
    )
    return np.concatenate([corner, middle], axis=1)
