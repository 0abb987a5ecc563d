"""Sharp edges of a punch, rounded: what a ball that rolls inside its surface can reach.

The sheet meets an edge in a line. Nodes meet it only by chance, the elements between them cut through it. An edge that
is rounded is a surface like another. The rounded body is all balls of one radius that have room in the sharp one: near
an edge the half-spaces behind the planes that meet there, moved inward by the radius, and then a ball around each of
their points (the opening of J. Serra, Image Analysis and Mathematical Morphology, 1982).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.surface import Surface
from hyperfab.surface.topology import compact

#: An edge that turns by more than this (radians) is meant to be sharp: its facets stand for no curved surface.
SHARP = 0.45
#: Farther from an edge than so many radii nothing is rounded.
_REACH = 3.0
#: Planes that meet at a corner, at most.
_MOST = 5


@dataclass(frozen=True)
class Rounded:
    """Sharp convex edges of a ``surface``, rounded by a ``radius`` [mm].

    >>> from hyperfab.surface import Surface
    >>> wedge = Surface([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 0, -9], [9, 0, -9]], [[0, 1, 2], [1, 0, 3], [1, 3, 4]])
    >>> at, gap, normal, _ = Rounded(wedge, 1.0).near(np.array([[8.0, 0.0, 0.0]]), np.array([0]))
    >>> float(gap[0].round(6)), normal[0].round(6).tolist()  # the edge is sqrt(2) - 1 off the ball
    (0.414214, [0.0, -0.707107, 0.707107])
    """

    surface: Surface
    radius: float
    _seen: dict[tuple[int, int], Ints] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def _sides(self) -> tuple[Ints, Array]:
        """Return on which side (m,) of sharp edges each facet is, and which sides (k, k) meet in convex edges alone."""
        turn, twins = self.surface.edge_turn, self.surface.twins
        face, edge = np.nonzero((np.abs(turn) <= SHARP) & (twins >= 0))
        joined = coo_array((np.ones(len(face)), (face, twins[face, edge])), shape=(len(turn), len(turn)))
        count, side = connected_components(joined, directed=False)
        meet = np.zeros((count, count), dtype=bool)
        for bent, rounded in ((turn > SHARP, True), (turn < -SHARP, False)):
            face, edge = np.nonzero(bent)
            meet[side[face], side[twins[face, edge]]] = rounded
        np.fill_diagonal(meet, False)
        return side, meet

    @cached_property
    def _edges(self) -> cKDTree:
        """Places along the convex sharp edges, no farther apart than the radius."""
        surface = self.surface
        face, edge = np.nonzero(surface.edge_turn > SHARP)
        a, b = surface.vertices[surface.faces[face, edge]], surface.vertices[surface.faces[face, (edge + 1) % 3]]
        count = int(np.ceil(np.linalg.norm(b - a, axis=1).max(initial=0.0) / self.radius)) + 1
        return cKDTree(np.concatenate([a + part * (b - a) for part in np.linspace(0.0, 1.0, count)]))

    @cached_property
    def _parts(self) -> list[tuple[int, Surface]]:
        """The sides with an edge to round: number and surface."""
        side, meet = self._sides
        faces, vertices = self.surface.faces, self.surface.vertices
        edged = np.flatnonzero(meet.any(axis=1))
        return [(int(number), Surface(*compact(vertices, faces[side == number]))) for number in edged]

    def near(self, points: Array, face: Ints) -> tuple[Ints, Array, Array, Array]:
        """Return which of the ``points`` (n, 3), next to the facets ``face`` (n,), see rounded edges, their gaps (k,),
        normals (k, 3) and how these turn (k, 3, 3) [1/mm]."""
        far, _ = self._edges.query(points, distance_upper_bound=_REACH * self.radius)
        close = np.flatnonzero(np.isfinite(far))
        side, meet = self._sides
        away = np.full((len(close), max(len(self._parts), _MOST)), -np.inf)
        normals = np.zeros((*away.shape, 3))
        for k, (number, part) in enumerate(self._parts):
            own = side[face[close]]
            seen = np.flatnonzero((own == number) | meet[own, number])
            hint = self._seen.get((k, len(seen)))
            found = part.nearest(points[close[seen]], hint=hint)
            self._seen[k, len(seen)] = found.face
            normal = part.normals[found.face]
            level = ((points[close[seen]] - found.point) * normal).sum(axis=1)
            beside = np.abs(found.distance) <= _REACH * self.radius
            away[seen[beside], k] = level[beside] + self.radius
            normals[seen, k] = normal
        order = np.argsort(-away, axis=1)[:, :_MOST]
        away = np.take_along_axis(away, order, axis=1)
        chosen = np.flatnonzero(away[:, 1] > 0.0)
        normals = np.take_along_axis(normals, order[:, :, None], axis=1)[chosen]
        off, active = _behind(away[chosen], normals)
        length = np.linalg.norm(off, axis=1)
        told = length > 0.0
        close, off, active, length = close[chosen[told]], off[told], active[told], length[told, None]
        normal = off / length
        turning = (active - normal[:, :, None] * normal[:, None, :]) / length[:, :, None]
        return close, length[:, 0] - self.radius, normal, turning


def _behind(away: Array, normals: Array) -> tuple[Array, Array]:
    """Return the way (n, 3) to points from the nearest place behind planes, which lie ``away`` (n, k) along ``normals``
    (n, k, 3), and the projector (n, 3, 3) on the normals of those planes that the place is on.

    The way is zero where no three of the planes tell that place.
    """
    way, active = np.zeros((len(away), 3)), np.zeros((len(away), 3, 3))
    left = np.ones(len(away), bool)
    for size in (1, 2, 3):
        for planes in combinations(range(away.shape[1]), size):
            some = np.flatnonzero(left & (away[:, planes] > 0.0).all(axis=1))
            n = normals[some][:, planes]
            gram = np.einsum("nik,njk->nij", n, n)
            sound = np.linalg.det(gram) > 1e-6
            some, n = some[sound], n[sound]
            inverse = np.linalg.inv(gram[sound])
            share = np.einsum("nij,nj->ni", inverse, away[some][:, planes])
            off = np.einsum("ni,nik->nk", share, n)
            beyond = away[some] - np.einsum("nik,nk->ni", normals[some], off)
            good = (share >= 0.0).all(axis=1) & (beyond <= 1e-9 * away[some, :1]).all(axis=1)
            at = some[good]
            way[at], left[at] = off[good], False
            active[at] = np.einsum("nik,nij,njl->nkl", n[good], inverse[good], n[good])
    return way, active
