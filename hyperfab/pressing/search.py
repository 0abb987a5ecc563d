"""Nearest points and normal hits on the other mold: by walks, checked against the exact tree, which mends them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hyperfab.surface import Nearest, Surface
from hyperfab.surface.bvh import nearest_many
from hyperfab.surface.walk import Found, Walker

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: So many points of every search are looked up in the tree as well.
_CHECKED = 200
#: Walks and tree agree to this share of the surface's size; beyond it the tree does all of the work.
_AGREE = 1e-11


class Search:
    """Searches on one surface.

    ``mended`` counts the points whose walk was lost and that the tree found; ``distrusted`` is true once a sample
    has shown a walk that ended in the wrong place: from then on the tree is asked for every point.
    """

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self.walker = Walker(surface.vertices, surface.faces)
        self.mended = 0
        self.distrusted = False
        self._tolerance = _AGREE * float(np.ptp(surface.vertices, axis=0).max())

    def nearest(self, points: Array, directions: Array, order: Ints | None = None) -> Nearest:
        """Return the nearest point of the surface to each of ``points`` (n, 3), with the sign its normal gives.

        ``directions`` (n, 3) point roughly there; in ``order`` (n,), if it is known, neighbours follow each other.
        """
        return self.both(points, directions, order)[0]

    def along(self, points: Array, directions: Array) -> tuple[Array, Ints]:
        """Return the distance (n,) to the surface along ``directions`` (n, 3) and the facet hit from its front.

        NaN and -1 where none is hit. Points behind the surface get a negative distance.
        """
        return self.both(points, directions)[1:]

    def both(
        self, points: Array, directions: Array, order: Ints | None = None
    ) -> tuple[Nearest, Array, Ints]:
        """Return what ``nearest`` and ``along`` do, at the price of one."""
        if self.distrusted:
            return self.surface.nearest(points), *self._rays(points, directions)
        found = self.walker.nearest(points, directions, order)
        lost = np.flatnonzero(found.hit < 0)
        sample = _some(len(points))
        sample = sample[found.hit[sample] >= 0]
        exact, _, _, _ = self._tree(points[sample])
        ray, _ = self._rays(points[sample], directions[sample])
        wrong = np.abs(np.sqrt(found.distance2[sample]) - exact) > self._tolerance
        # Along a slanted ray the same facets leave a little more rounding.
        if wrong.any() or (np.abs(found.along[sample] - ray) > 1e3 * self._tolerance).any():
            self.distrusted = True
            return self.surface.nearest(points), *self._rays(points, directions)
        if len(lost):
            self.mended += len(lost)
            distance, found.point[lost], found.face[lost], found.feature[lost] = self._tree(points[lost])
            found.distance2[lost], found.side[lost] = distance**2, 0.0
            found.along[lost], found.hit[lost] = self._rays(points[lost], directions[lost])
        distance, normal = self._signed(points, found)
        return Nearest(distance, found.point, normal, found.face, found.feature), found.along, found.hit

    def _tree(self, points: Array) -> tuple[Array, Array, Ints, Ints]:
        """Distance, point, face and feature of the exact search; no normals."""
        n, points = len(points), np.ascontiguousarray(points)
        point, slot, feature = np.empty((n, 3)), np.empty(n, np.int64), np.empty(n, np.int64)
        nearest_many(points, np.full(n, -1), *self.surface.tree, point, slot, feature)
        return np.linalg.norm(points - point, axis=1), point, self.surface.order[slot], feature

    def _rays(self, points: Array, directions: Array) -> tuple[Array, Ints]:
        ahead, face = self._first(points, directions, 1.0)
        missed = np.flatnonzero(face < 0)
        if len(missed):
            # From behind: a ray the other way leaves the material through a facet's front.
            back, behind = self._first(points[missed], -directions[missed], -1.0)
            ahead[missed], face[missed] = -back, behind
        return ahead, face

    def _first(self, points: Array, directions: Array, side: float) -> tuple[Array, Ints]:
        t, face = self.surface.ray(points, directions)
        a, b, c = (self.surface.vertices[self.surface.faces[face, k]] for k in range(3))
        right = (face >= 0) & (side * (np.cross(b - a, c - a) * directions).sum(axis=1) < 0.0)
        return np.where(right, t, np.nan), np.where(right, face, -1)

    def _signed(self, points: Array, found: Found) -> tuple[Array, Array]:
        """Signed distances and directions: the normal of face, edge or vertex decides on which side a point is."""
        away = points - found.point
        length = np.sqrt(found.distance2)
        side = found.side
        # Points that the tree found have no side yet.
        open_question = np.flatnonzero(side == 0.0)
        normal = np.empty_like(away)
        if len(open_question):
            face, feature = found.face[open_question], found.feature[open_question]
            normal[open_question] = self._feature_normal(face, feature)
            inside = (away[open_question] * normal[open_question]).sum(axis=1) < 0.0
            side[open_question] = np.where(inside, -1.0, 1.0)
        distance = side * length
        clear = length > 1e-9
        normal[clear] = away[clear] / distance[clear, None]
        on_it = np.flatnonzero(~clear)
        if len(on_it):
            normal[on_it] = self._feature_normal(found.face[on_it], found.feature[on_it])
        return distance, normal

    def _feature_normal(self, face: Ints, feature: Ints) -> Array:
        """Mean normals (n, 3) of faces, edges and vertices."""
        surface = self.surface
        normal = surface.normals[face]
        edge = np.flatnonzero((feature >= 1) & (feature <= 3))
        other = self.walker.twins[face[edge], feature[edge] - 1]
        normal[edge] += np.where((other >= 0)[:, None], surface.normals[other], 0.0)
        vertex = np.flatnonzero(feature >= 4)
        if len(vertex):
            normal[vertex] = surface.vertex_normals[surface.faces[face[vertex], feature[vertex] - 4]]
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return np.asarray(normal / np.where(length > 0.0, length, 1.0))


def _some(count: int) -> Ints:
    """Places spread over a list, the same in every run."""
    return np.unique(np.linspace(0, count - 1, min(_CHECKED, count)).astype(np.int64))
