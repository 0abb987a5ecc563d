"""The tetrahedra a temperature field lives on: nodes, elements, facets, and nodes doubled across a contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.surface.curve import along_a_curve

#: Local vertex numbers of the six edges, in the order of the edge nodes 4 to 9 (VTK's and scikit-fem's order).
EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])

#: Local node numbers of the four facets (three vertices, then the middles of their edges 01 12 20), seen from
#: outside counter-clockwise.
FACETS = np.array([[1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6], [0, 1, 3, 4, 8, 7], [0, 2, 1, 6, 5, 4]])


@dataclass(frozen=True)
class Facets:
    """Triangles of the mesh where something may happen: outer faces, and interfaces between parts.

    ``element`` (f,) and ``local`` (f,) name the facet's element and its number there; ``other`` and
    ``other_local`` the element on the other side of an interface, -1 on outer faces; ``face`` (f,) numbers the
    geometric faces they lie on.
    """

    element: Ints
    local: Ints
    other: Ints
    other_local: Ints
    face: Ints

    @property
    def outer(self) -> Flags:
        """Whether a facet has nothing on its other side."""
        return self.other < 0


@dataclass(frozen=True)
class HeatMesh:
    """Ten-node tetrahedra. Lengths in m.

    ``points`` (n, 3): first the ``vertices`` vertices, then the edge nodes; ``elements`` (m, 10); ``parts`` (m,)
    the part of each element; ``edge_ends`` (n - vertices, 2) the vertices an edge node lies between; ``curved``
    (m,) whether an edge node lies off the middle of its edge. Points after those are in no element: ``with_loose``.
    """

    points: Array
    elements: Ints
    parts: Ints
    vertices: int
    edge_ends: Ints
    curved: Flags
    facets: Facets

    @property
    def solid(self) -> int:
        """Number of nodes of the elements; loose ones come after them."""
        return self.vertices + len(self.edge_ends)

    def facet_nodes(self, which: Flags | Ints, other_side: bool = False) -> Ints:
        """Return the six nodes of facets (f, 6); of the ``other_side`` they are paired with the first ones."""
        f = self.facets
        nodes = self.elements[f.element[which][:, None], FACETS[f.local[which]]]
        if not other_side:
            return nodes
        far = self.elements[f.other[which][:, None], FACETS[f.other_local[which]]]
        paired = _pairing(self.points[nodes[:, :3]], self.points[far[:, :3]])
        return np.take_along_axis(far, np.concatenate([paired, _edge_of(paired)], axis=1), axis=1)


def build_mesh(
    points: Array,
    elements: Ints,
    parts: Ints,
    surface: Ints | None = None,
    surface_face: Ints | None = None,
) -> HeatMesh:
    """Number nodes and elements so that neighbours have near numbers, straighten what curves too far, find facets.

    ``points`` in m. Facets that are not in ``surface`` (three vertices each) get face number -1; without
    ``surface`` all do.
    """
    elements = oriented(points, elements)
    near = along_a_curve(points[elements[:, 0]])  # a product with a matrix of the mesh then takes two thirds
    elements, parts = elements[near], parts[near]
    elements, points, vertices, edge_ends, place = _renumber(points, elements)
    points, curved = _straightened(points, elements, edge_ends, vertices)
    facets = _facets(elements, parts)
    if surface is not None and surface_face is not None:
        facets = _with_faces(facets, elements, place[surface], surface_face)
    return HeatMesh(points, elements, parts, vertices, edge_ends, curved, facets)


def split_contacts(mesh: HeatMesh, contact: Flags) -> HeatMesh:
    """Double the nodes on the interface facets marked in ``contact``: the temperature may jump there.

    Nodes of two elements are one where a chain of facets without contact links them.
    """
    f = mesh.facets
    if not contact.any():
        return mesh
    m = len(mesh.elements)
    pairs = _interior_pairs(mesh.elements)
    parted = np.stack([f.element[contact], f.other[contact]], axis=1)
    every, broken = (np.sort(pair, axis=1) @ np.array([m, 1]) for pair in (pairs[:, [0, 2]], parted))
    pairs = pairs[~np.isin(every, broken)]
    near = pairs[:, 0, None] * 10 + FACETS[pairs[:, 1]]
    far = pairs[:, 2, None] * 10 + FACETS[pairs[:, 3]]
    order_near = np.argsort(mesh.elements.ravel()[near], axis=1)
    order_far = np.argsort(mesh.elements.ravel()[far], axis=1)
    i = np.take_along_axis(near, order_near, axis=1).ravel()
    j = np.take_along_axis(far, order_far, axis=1).ravel()
    graph = sparse.coo_matrix((np.ones(len(i), dtype=np.int8), (i, j)), shape=(10 * m, 10 * m)).tocsr()
    _, label = connected_components(graph, directed=False)
    is_vertex = np.tile(np.arange(10) < 4, m)
    _, first, dense = np.unique(np.where(is_vertex, 0, 10 * m) + label, return_index=True, return_inverse=True)
    elements = dense.reshape(m, 10).astype(np.int64)
    points = mesh.points[mesh.elements.ravel()[first]]
    vertices = int(is_vertex[first].sum())
    return HeatMesh(points, elements, mesh.parts, vertices, _edge_ends(elements, len(points), vertices), mesh.curved, f)


def oriented(points: Array, elements: Ints) -> Ints:
    """Turn elements of negative volume over."""
    flipped = elements[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    return np.where((six_volumes(points[elements]) < 0)[:, None], flipped, elements)


def six_volumes(nodes: Array) -> Array:
    """Return six times the volumes (m,) of straight elements with ``nodes`` (m, 4 or more, 3), negative where turned
    over."""
    sides = nodes[:, 1:4] - nodes[:, :1]
    return np.asarray(np.einsum("ij,ij->i", np.cross(sides[:, 0], sides[:, 1]), sides[:, 2]))


def _renumber(points: Array, elements: Ints) -> tuple[Ints, Array, int, Ints, Ints]:
    """Put vertices first, each kind along a curve, and drop points no element uses; also where each point went."""
    vertex_ids = np.unique(elements[:, :4])
    edge_ids = np.setdiff1d(np.unique(elements[:, 4:]), vertex_ids)
    order = np.concatenate([ids[along_a_curve(points[ids])] for ids in (vertex_ids, edge_ids)])
    place = np.full(len(points), -1, dtype=np.int64)
    place[order] = np.arange(len(order))
    renumbered = place[elements]
    ends = _edge_ends(renumbered, len(order), len(vertex_ids))
    return renumbered, points[order], len(vertex_ids), ends, place


def _edge_ends(elements: Ints, count: int, vertices: int) -> Ints:
    ends = np.zeros((count - vertices, 2), dtype=np.int64)
    ends[elements[:, 4:].ravel() - vertices] = elements[:, EDGES].reshape(-1, 2)
    return np.sort(ends, axis=1)


def _straightened(points: Array, elements: Ints, edge_ends: Ints, vertices: int) -> tuple[Array, Flags]:
    """Move edge nodes back to the middle where a curved element would turn inside out."""
    middle = points[edge_ends].mean(axis=1)
    length = np.linalg.norm(points[edge_ends[:, 0]] - points[edge_ends[:, 1]], axis=1)
    off = np.linalg.norm(points[vertices:] - middle, axis=1) > 1e-9 * length
    points = points.copy()
    points[vertices:][~off] = middle[~off]
    for _ in range(20):
        bent = off[elements[:, 4:] - vertices].any(axis=1)
        bad = np.flatnonzero(bent)[twisted(points[elements[bent]])]
        if len(bad) == 0:
            break
        straight = np.unique(elements[bad, 4:] - vertices)
        points[vertices + straight] = middle[straight]
        off[straight] = False
    return points, off[elements[:, 4:] - vertices].any(axis=1)


def twisted(nodes: Array) -> Flags:
    """Whether the Jacobian somewhere falls below a fifth of the straight element's (nodes (m, 10, 3))."""
    from hyperfab.thermal.elements import TETRAHEDRON

    points = np.concatenate([TETRAHEDRON.points, TETRAHEDRON.corners])
    _, gradients = TETRAHEDRON.tabulate(points)
    jacobian = np.einsum("mid,qik->mqdk", nodes, gradients)
    least: Flags = np.linalg.det(jacobian).min(axis=1) < 0.2 * six_volumes(nodes)
    return least


def _interior_pairs(elements: Ints) -> Ints:
    """Return (element, local facet, other element, its local facet) of all facets between two elements."""
    owner, local, _, start, count = _sorted_facets(elements)
    two = start[count == 2]
    return np.stack([owner[two], local[two], owner[two + 1], local[two + 1]], axis=1)


def _sorted_facets(elements: Ints) -> tuple[Ints, Ints, Ints, Ints, Ints]:
    m = len(elements)
    corners = np.sort(elements[:, FACETS[:, :3]].reshape(-1, 3), axis=1)
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    corners = corners[order]
    new = np.ones(len(corners), dtype=bool)
    new[1:] = (corners[1:] != corners[:-1]).any(axis=1)
    start = np.flatnonzero(new)
    count = np.diff(np.append(start, len(corners)))
    owner = np.repeat(np.arange(m), 4)[order]
    local = np.tile(np.arange(4), m)[order]
    return owner, local, corners, start, count


def _facets(elements: Ints, parts: Ints) -> Facets:
    owner, local, _, start, count = _sorted_facets(elements)
    one = start[count == 1]
    two = start[count == 2]
    between = two[parts[owner[two]] != parts[owner[two + 1]]]
    swap = parts[owner[between]] > parts[owner[between + 1]]
    low, high = between + swap, between + 1 - swap
    nothing = np.full(len(one), -1, dtype=np.int64)
    return Facets(
        element=np.concatenate([owner[one], owner[low]]),
        local=np.concatenate([local[one], local[low]]),
        other=np.concatenate([nothing, owner[high]]),
        other_local=np.concatenate([nothing, local[high]]),
        face=np.full(len(one) + len(between), -1, dtype=np.int64),
    )


def _with_faces(facets: Facets, elements: Ints, surface: Ints, face: Ints) -> Facets:
    corners = np.sort(elements[facets.element[:, None], FACETS[facets.local][:, :3]], axis=1)
    known = np.sort(surface, axis=1)
    size = int(max(corners.max(), known.max())) + 1
    known_key = (known[:, 0] * size + known[:, 1]) * size + known[:, 2]
    order = np.argsort(known_key, kind="stable")
    key = (corners[:, 0] * size + corners[:, 1]) * size + corners[:, 2]
    at = np.searchsorted(known_key[order], key)
    at = np.minimum(at, len(order) - 1)
    found = known_key[order][at] == key
    number = np.where(found, face[order][at], -1)
    return Facets(facets.element, facets.local, facets.other, facets.other_local, number)


def _pairing(near: Array, far: Array) -> Ints:
    """For each near corner (f, 3, 3) the number of the far corner at the same place."""
    gap = np.linalg.norm(near[:, :, None, :] - far[:, None, :, :], axis=3)
    return np.argmin(gap, axis=2)


def _edge_of(corner: Ints) -> Ints:
    """Numbers of the edge nodes 3, 4, 5 (edges 01, 12, 20) for corners permuted as ``corner`` (f, 3)."""
    table = np.array([[-1, 3, 5], [3, -1, 4], [5, 4, -1]])
    following = np.roll(corner, -1, axis=1)
    return table[corner, following]
