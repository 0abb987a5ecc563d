"""Nearest points and normal hits on the other mold: by walks, checked against the exact tree, which mends them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hyperfab.surface import Nearest, Surface
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

    def nearest(self, points: Array, directions: Array) -> Nearest:
        """Return the nearest point of the surface to each of ``points`` (n, 3), with the sign its normal gives.

        ``directions`` (n, 3) point roughly there.
        """
        if self.distrusted:
            return self.surface.nearest(points)
        found = self.walker.nearest(points, directions)
        lost = np.flatnonzero(found.hit < 0)
        checked = np.unique(np.concatenate([lost, _some(len(points))]))
        exact = self.surface.nearest(points[checked])
        wrong = np.abs(np.sqrt(found.distance2[checked]) - np.abs(exact.distance)) > self._tolerance
        if (wrong & (found.hit[checked] >= 0)).any():
            self.distrusted = True
            return self.surface.nearest(points)
        self.mended += len(lost)
        distance, normal = self._signed(points, found)
        result = Nearest(distance, found.point, normal, found.face, found.feature)
        result.distance[checked], result.point[checked] = exact.distance, exact.point
        result.normal[checked], result.face[checked] = exact.normal, exact.face
        result.feature[checked] = exact.feature
        return result

    def along(self, points: Array, directions: Array) -> tuple[Array, Ints]:
        """Return the distance (n,) to the surface along ``directions`` (n, 3) and the facet hit from its front.

        NaN and -1 where none is hit. Points behind the surface get a negative distance.
        """
        if self.distrusted:
            return self._rays(points, directions)
        found = self.walker.nearest(points, directions)
        lost = np.flatnonzero(found.hit < 0)
        checked = np.unique(np.concatenate([lost, _some(len(points))]))
        exact, face = self._rays(points[checked], directions[checked])
        wrong = np.abs(found.along[checked] - exact) > 1e3 * self._tolerance
        if (wrong & (found.hit[checked] >= 0)).any():
            self.distrusted = True
            return self._rays(points, directions)
        found.along[checked], found.hit[checked] = exact, face
        return found.along, found.hit

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
        cosine = -side * (self.surface.normals[face] * directions).sum(axis=1)
        right = (face >= 0) & (cosine > 0.0)
        return np.where(right, t, np.nan), np.where(right, face, -1)

    def _signed(self, points: Array, found: Found) -> tuple[Array, Array]:
        """Signed distances and directions: the normal of face, edge or vertex decides on which side a point is."""
        surface = self.surface
        away = points - found.point
        length = np.sqrt(found.distance2)
        normal = surface.normals[found.face]
        edge = np.flatnonzero((found.feature >= 1) & (found.feature <= 3))
        other = self.walker.twins[found.face[edge], found.feature[edge] - 1]
        normal[edge] += np.where((other >= 0)[:, None], surface.normals[other], 0.0)
        vertex = np.flatnonzero(found.feature >= 4)
        if len(vertex):
            normal[vertex] = surface.vertex_normals[
                surface.faces[found.face[vertex], found.feature[vertex] - 4]
            ]
        distance = np.where((away * normal).sum(axis=1) < 0.0, -length, length)
        clear = length > 1e-9
        normal[clear] = away[clear] / distance[clear, None]
        return distance, normal


def _some(count: int) -> Ints:
    """Places spread over a list, the same in every run."""
    return np.unique(np.linspace(0, count - 1, min(_CHECKED, count)).astype(np.int64))
