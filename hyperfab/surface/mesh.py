"""A triangle surface: exact nearest point with its feature and normal, first hit of a ray, curvature."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.threads import in_blocks
from hyperfab.numerics.vectors import rows

from . import bvh
from .batch import nearest_in_turn, oriented_boxes
from .curve import along_a_curve
from .soundness import Soundness, soundness
from .topology import corner_angles, face_geometry, incidence, signed, twin_edges

#: Queries are answered in blocks, side by side on the cores there are; a signal is seen between them.
BLOCK = 5_000


@dataclass(frozen=True)
class Nearest:
    """Nearest points of a surface to n given points.

    ``distance`` (n,) mm, negative inside; ``point`` (n, 3) on the surface; ``normal`` (n, 3) unit, outward: the
    direction from the surface to the point, or on the surface itself the mean normal of the feature; ``face`` (n,)
    index of a facet; ``feature`` (n,) 0 in the face, 1 2 3 on its edge ab, bc, ca, 4 5 6 at its vertex a, b, c.
    """

    distance: Array
    point: Array
    normal: Array
    face: Ints
    feature: Ints


class Surface:
    """Triangle surface with a search tree.

    Facets are seen from outside when their corners turn counter-clockwise. Equal corners must share one vertex
    index (``read_stl`` merges them), else shared edges are not known as shared.

    Args:
        vertices: (n, 3) float, mm.
        faces: (m, 3) int, indices of the corners.

    >>> tetra = Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> near = tetra.nearest([[0.2, 0.2, -0.5], [0.1, 0.1, 0.2]])
    >>> near.distance.round(3).tolist(), near.normal[0].round(9).tolist()
    ([0.5, -0.1], [0.0, 0.0, -1.0])
    >>> t, face = tetra.ray([[0.1, 0.1, 9.0]], [[0, 0, -1.0]])
    >>> round(float(t[0]), 6), int(face[0])
    (8.2, 3)
    """

    def __init__(self, vertices: object, faces: object) -> None:
        self.vertices: Array = np.ascontiguousarray(vertices, dtype=float)
        self.faces: Ints = np.ascontiguousarray(faces, dtype=np.int64)
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise ValueError("vertices must be an array of shape (n, 3)")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3 or not len(self.faces):
            raise ValueError("faces must be a non-empty array of shape (m, 3)")
        corners = rows(self.vertices, self.faces)
        self.order, self.bounds, self.right, self.start, self.count = bvh.build(corners)
        self.corners: Array = rows(corners, self.order)
        self.slot_of_face: Ints = np.empty(len(self.order), np.int64)
        self.slot_of_face[self.order] = np.arange(len(self.order))

    @property
    def tree(self) -> tuple[Array, Array, Ints, Ints, Ints]:
        """Arrays the compiled searches take: corners in tree order, boxes, right children, leaf ranges."""
        return self.corners, self.bounds, self.right, self.start, self.count

    @cached_property
    def normals(self) -> Array:
        """Unit normals of the facets, (m, 3); zero for a facet without area."""
        return face_geometry(self.vertices, self.faces)[0]

    @cached_property
    def areas(self) -> Array:
        """Areas of the facets, (m,) mm^2."""
        return face_geometry(self.vertices, self.faces)[1]

    @cached_property
    def twins(self) -> Ints:
        """(m, 3) facet across each edge ab, bc, ca; -1 at a border or where more than two facets meet."""
        return twin_edges(self.faces, self.incident)[0]

    @cached_property
    def vertex_normals(self) -> Array:
        """Angle-weighted mean normals of the vertices, (n, 3), unit.

        With them the sign of the distance is exact at vertices too (Baerentzen and Aanaes, IEEE TVCG 11, 2005).
        """
        weighted = self.normals[:, None, :] * corner_angles(self.vertices, self.faces)[:, :, None]
        total = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(total, self.faces[:, corner], weighted[:, corner])
        return _unit(total)

    @cached_property
    def feature_normals(self) -> Array:
        """(m, 7, 3) unit mean normal of each facet's face, three edges and three vertices (order of ``feature``)."""
        out = np.empty((len(self.faces), 7, 3))
        out[:, 0] = self.normals
        for e in range(3):
            other = self.twins[:, e]
            across = np.where((other >= 0)[:, None], self.normals[other], self.normals)
            out[:, 1 + e] = _unit(self.normals + across)
            out[:, 4 + e] = self.vertex_normals[self.faces[:, e]]
        return out

    @cached_property
    def edge_turn(self) -> Array:
        """(m, 3) angle in radians by which the normal turns across each edge: positive where the surface is convex."""
        out = np.zeros((len(self.faces), 3))
        for e in range(3):
            other = self.twins[:, e]
            a, b = self.vertices[self.faces[:, e]], self.vertices[self.faces[:, (e + 1) % 3]]
            outward = np.cross(b - a, self.normals)  # in the facet's plane, away from it
            sine = np.linalg.norm(np.cross(self.normals, self.normals[other]), axis=1)
            angle = np.arctan2(sine, (self.normals * self.normals[other]).sum(1))
            sign = np.sign((self.normals[other] * outward).sum(1))
            out[:, e] = np.where(other >= 0, sign * angle, 0.0)
        return out

    @cached_property
    def incident(self) -> tuple[Ints, Ints]:
        """Facets at vertex v: ``facets[first[v] : first[v + 1]]`` of (first, facets)."""
        return incidence(self.faces, len(self.vertices))

    @cached_property
    def _oriented(self) -> Array:
        return oriented_boxes(self.corners, self.bounds, self.right, self.start, self.count)

    def nearest(self, points: object, *, hint: Ints | None = None, order: Ints | None = None) -> Nearest:
        """Nearest point of the surface to each of ``points`` (n, 3), proven: no triangle has a nearer one.

        Of facets that are equally near, the one that comes first in the tree is told. ``hint`` (n,) names a facet near
        each point (-1: none), ``order`` (n,) is one in which neighbours follow each other (that of ``along_a_curve``
        where it is not given): both make the search faster, never different. The sign of the distance is right for a
        closed, consistently wound surface.
        """
        pts = np.asarray(points, dtype=float).reshape(-1, 3)
        n = len(pts)
        order = along_a_curve(pts) if order is None else order
        pts = rows(pts, order)
        hints = np.full(n, -1)
        if hint is not None:
            hints = np.where(hint >= 0, self.slot_of_face[hint], -1)[order]
        closest, slots, features = np.empty((n, 3)), np.empty(n, np.int64), np.empty(n, np.int64)
        distance, normal, face = np.empty(n), np.empty((n, 3)), np.empty(n, np.int64)
        tree = (self.corners, self._oriented, self.right, self.start, self.count)
        first, facets = self.incident
        touching = np.abs(self.bounds[0]).max() * 1e-12

        def search(start: int, end: int) -> None:
            s = slice(start, end)
            nearest_in_turn(pts[s], hints[s], *tree, closest[s], slots[s], features[s])
            np.take(self.order, slots[s], out=face[s])
            where = (closest[s], face[s], features[s], self.vertices, self.faces, first, facets)
            signed(pts[s], *where, touching, distance[s], normal[s])

        in_blocks(search, n, BLOCK)
        back = np.empty(n, np.int64)
        back[order] = np.arange(n)
        return Nearest(
            rows(distance, back),
            rows(closest, back),
            rows(normal, back),
            rows(face, back),
            rows(features, back),
        )

    def ray(self, origins: object, directions: object, *, order: Ints | None = None) -> tuple[Array, Ints]:
        """First facet hit by each ray, from either side.

        Returns t (n,), with origin + t direction on the surface, and the facet (n,); inf and -1 where none is hit.
        ``order`` (n,), in which neighbours follow each other, makes it faster.
        """
        o = np.asarray(origins, dtype=float).reshape(-1, 3)
        d = np.broadcast_to(np.asarray(directions, dtype=float), o.shape)
        order = along_a_curve(o) if order is None else order
        o, d = rows(o, order), rows(d, order)
        t, slots = np.empty(len(o)), np.empty(len(o), np.int64)

        def search(start: int, end: int) -> None:
            s = slice(start, end)
            bvh.ray_many(o[s], d[s], *self.tree, t[s], slots[s])

        in_blocks(search, len(o), BLOCK)
        back = np.empty(len(o), np.int64)
        back[order] = np.arange(len(o))
        t, slots = rows(t, back), rows(slots, back)
        return t, np.where(slots >= 0, self.order[slots], -1)

    def along(self, points: Array, directions: Array, *, order: Ints | None = None) -> tuple[Array, Ints]:
        """Distance (n,) along ``directions`` (n, 3) to the first facet, if it is met from its front.

        Points behind the surface get a negative distance, to the front that the opposite ray leaves through first.
        Returns it and the facet (n,); NaN and -1 where none is hit.
        """
        ahead, face = self._met(points, directions, 1.0, order)
        missed = np.flatnonzero(face < 0)
        if len(missed):
            back, behind = self._met(points[missed], -directions[missed], -1.0, None)
            ahead[missed], face[missed] = -back, behind
        return ahead, face

    def _met(self, points: Array, directions: Array, side: float, order: Ints | None) -> tuple[Array, Ints]:
        t, face = self.ray(points, directions, order=order)

        def look(start: int, end: int) -> None:
            s = slice(start, end)
            a, b, c = np.take(self.vertices, np.take(self.faces, face[s], axis=0).T, axis=0)
            wrong = ~(side * (np.cross(b - a, c - a) * directions[s]).sum(axis=1) < 0.0)
            face[s][wrong] = -1

        in_blocks(look, len(t), BLOCK)
        t[face < 0] = np.nan
        return t, face

    @cached_property
    def curvature(self) -> Array:
        """(m, 3, 3) mean shape operator over each facet, 1/mm: d normal = curvature @ d point, positive where convex.

        Least-squares fit of the vertex normals' change along the three sides (Rusinkiewicz, 3DPVT 2004).
        """
        n = self.normals
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        na, nb, nc = (self.vertex_normals[self.faces[:, k]] for k in range(3))
        u = _unit(b - a)
        v = np.cross(n, u)
        sides = np.stack([b - a, c - b, a - c], 1)
        turns = np.stack([nb - na, nc - nb, na - nc], 1)
        x, y = (sides * u[:, None]).sum(2), (sides * v[:, None]).sum(2)
        p, q = (turns * u[:, None]).sum(2), (turns * v[:, None]).sum(2)
        xx, xy, yy = (x * x).sum(1), (x * y).sum(1), (y * y).sum(1)
        normal_matrix = np.zeros((len(n), 3, 3))  # unknowns: the operator's uu, uv, vv entries
        normal_matrix[:, 0, 0], normal_matrix[:, 0, 1] = xx, xy
        normal_matrix[:, 1, 0], normal_matrix[:, 1, 1], normal_matrix[:, 1, 2] = xy, xx + yy, xy
        normal_matrix[:, 2, 1], normal_matrix[:, 2, 2] = xy, yy
        right = np.stack([(x * p).sum(1), (y * p + x * q).sum(1), (y * q).sum(1)], 1)
        trace = xx + yy + (xx + yy == 0.0)
        normal_matrix += (1e-9 * trace)[:, None, None] * np.eye(3)
        s = np.linalg.solve(normal_matrix, right[..., None])[..., 0]
        uv = u[:, :, None] * v[:, None, :]
        return (
            s[:, 0, None, None] * u[:, :, None] * u[:, None, :]
            + s[:, 1, None, None] * (uv + uv.transpose(0, 2, 1))
            + s[:, 2, None, None] * v[:, :, None] * v[:, None, :]
        )

    def soundness(self) -> Soundness:
        """What is wrong with the mesh: open and crowded edges, inconsistent winding, facets without area."""
        return soundness(self.vertices, self.faces)


def _unit(v: Array) -> Array:
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray(v / np.where(length == 0.0, 1.0, length))
