"""Is a triangle mesh a sound solid? Counts of what is wrong, with a place for each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from hyperfab.arrays import Array, Ints

from .topology import face_geometry, twin_edges


@dataclass(frozen=True)
class Soundness:
    """Findings on a mesh; each ``*_facets`` array lists the facets concerned.

    ``volume_mm3`` is signed: negative for a closed mesh whose facets face inward. ``bodies`` counts pieces
    connected over edges.
    """

    open_edges: int
    open_facets: Ints
    crowded_edges: int
    crowded_facets: Ints
    flipped_edges: int
    flipped_facets: Ints
    degenerate_facets: Ints
    duplicate_facets: Ints
    bodies: int
    volume_mm3: float

    @property
    def closed(self) -> bool:
        """Every edge has exactly two facets."""
        return self.open_edges == 0 and self.crowded_edges == 0

    @property
    def consistent(self) -> bool:
        """Neighbouring facets agree on which side is outside."""
        return self.flipped_edges == 0

    @property
    def sound(self) -> bool:
        """Closed, consistently wound, facing outward, without empty or doubled facets."""
        return (
            self.closed
            and self.consistent
            and self.volume_mm3 > 0.0
            and not len(self.degenerate_facets)
            and not len(self.duplicate_facets)
        )


def soundness(vertices: Array, faces: Ints) -> Soundness:
    """Examine a mesh of ``vertices`` (n, 3) and ``faces`` (m, 3).

    >>> corner = soundness(np.eye(3), np.array([[0, 1, 2]]))
    >>> corner.open_edges, corner.closed, corner.bodies
    (3, False, 1)
    """
    twin, number, same = twin_edges(faces)
    _, area = face_geometry(vertices, faces)
    scale = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    key = np.sort(faces, axis=1)
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    duplicate = np.flatnonzero(first[inverse.ravel()] != np.arange(len(faces)))
    a, b, c = (vertices[faces[:, k]] - vertices[faces[0, 0]] for k in range(3))
    volume = float((a * np.cross(b, c)).sum() / 6.0)
    return Soundness(
        open_edges=int((number == 1).sum()),
        open_facets=np.flatnonzero((number == 1).any(1)),
        crowded_edges=int((1.0 / number[number > 2]).sum().round()),
        crowded_facets=np.flatnonzero((number > 2).any(1)),
        flipped_edges=int(same.sum()) // 2,
        flipped_facets=np.flatnonzero(same.any(1)),
        degenerate_facets=np.flatnonzero(area <= 1e-14 * scale * scale),
        duplicate_facets=duplicate,
        bodies=bodies(twin)[0],
        volume_mm3=volume,
    )


def bodies(twin: Ints) -> tuple[int, Ints]:
    """Return how many pieces are connected over edges, given ``twin_edges``, and which each facet is of (m,)."""
    count, label = connected_components(_adjacency(twin), directed=False)
    return int(count), label


def consistently_wound(faces: Ints) -> tuple[Ints, Ints]:
    """Faces with one winding in every connected piece, and the facets turned to get there.

    In each piece the fewer facets are turned; which side is then outside is left to the caller (the sign of
    ``Soundness.volume_mm3`` tells for a closed piece).
    """
    twin, _, same = twin_edges(faces)
    graph = _adjacency(twin)
    pieces, label = bodies(twin)
    turned = np.zeros(len(faces), bool)
    for piece in range(pieces if same.any() else 0):
        members = np.flatnonzero(label == piece)
        if not same[members].any():
            continue
        order, parent = breadth_first_order(graph, members[0], directed=False)
        for face in order[1:]:
            up = parent[face]
            edge = int(np.flatnonzero(twin[face] == up)[0])
            turned[face] = turned[up] ^ bool(same[face, edge])
        if turned[members].sum() * 2 > len(members):
            turned[members] = ~turned[members]
    out = faces.copy()
    out[turned] = faces[turned][:, ::-1]
    return out, np.flatnonzero(turned)


def inside_out(vertices: Array, faces: Ints) -> Ints:
    """Return the facets of those pieces of a closed mesh that face inward and lie in no other piece: the inner side of
    a hollow faces inward by right.

    ``vertices`` (n, 3) and ``faces`` (m, 3), wound alike within each piece.
    """
    pieces, label = bodies(twin_edges(faces)[0])
    corners = vertices[faces]
    volume = np.bincount(label, np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    turned = np.zeros(len(faces), bool)
    for piece in np.flatnonzero(volume < 0.0) if pieces > 1 else ():
        mine = label == piece
        seen = np.bincount(label, _solid_angles(corners, corners[mine][0, 0]), pieces)
        seen[piece] = 0.0
        # Seen from within, a closed piece fills the whole sphere of 4 pi; from outside nothing.
        if not (np.abs(seen) > 2.0 * np.pi).any():
            turned |= mine
    return np.flatnonzero(turned)


def _solid_angles(corners: Array, point: Array) -> Array:
    """Return the signed solid angles (m,) that triangles (m, 3, 3) fill as seen from a point (Van Oosterom, Strackee,
    IEEE Trans. Biomed. Eng. 30 (1983) 125)."""
    a, b, c = (corners[:, k] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    triple = np.einsum("fi,fi->f", a, np.cross(b, c))
    beside = (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.asarray(2.0 * np.arctan2(triple, la * lb * lc + beside))


def _adjacency(twin: Ints) -> coo_array:
    m = len(twin)
    face, other = np.repeat(np.arange(m), 3), twin.ravel()
    pair = other >= 0
    return coo_array((np.ones(pair.sum(), np.int8), (face[pair], other[pair])), shape=(m, m)).tocsr()
