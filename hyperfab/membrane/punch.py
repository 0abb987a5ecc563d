"""What is pushed into the sheet: a rigid sphere, or a rigid punch with flat facets, as seen from points of the sheet.

Facets: the distance to them is exact. Where a point is nearest to the inside of a facet the normal is the facet's own.
Near edges and corners it is the direction to the nearest point, which turns from one facet's normal to the next. The
sheet touches the facets as they are; the curvature of the surface they approximate serves Newton's stiffness alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.rounded import SHARP, Rounded
from hyperfab.surface import Surface


@dataclass(frozen=True)
class Nearness:
    """How points lie to a rigid surface.

    ``gap`` (n,) [mm], negative inside; ``normal`` (n, 3) outward at the nearest point; ``turning`` (n, 3, 3)
    [1/mm]: derivative of the normal with respect to the point. ``facet`` (n,): number of the nearest facet, where
    there are any; the normal turns from facet to facet then, and ``turning`` is its mean.
    """

    gap: Array
    normal: Array
    turning: Array
    facet: Ints | None = None

    def along(self, free: Flags) -> Nearness:
        """Return the same as seen by points that may only move in their ``free`` directions (n, 3).

        A facet that meets a symmetry plane at a slant is there the edge of a roof: its normal lies in the plane.
        """
        held = ~free.all(axis=1) & free.any(axis=1)
        if self.facet is None or not held.any():
            return self
        normal, gap, turning = self.normal.copy(), self.gap.copy(), self.turning.copy()
        way = np.where(free[held], normal[held], 0.0)
        size = np.linalg.norm(way, axis=1)
        size = np.where(size > 1e-6, size, 1.0)
        normal[held], gap[held] = way / size[:, None], gap[held] / size
        both = free[held][:, :, None] & free[held][:, None, :]
        turning[held] = np.where(both, turning[held], 0.0)
        return Nearness(gap, normal, turning, self.facet)

    def at(self, nodes: Ints, before: Ints | None = None) -> Nearness:
        """Return the same for some ``nodes`` (k,). Those still on the facet ``before`` (n,) see no turning normal."""
        turning = self.turning[nodes]
        if self.facet is None:
            return Nearness(self.gap[nodes], self.normal[nodes], turning)
        if before is not None:
            same = (self.facet[nodes] == before[nodes]) & (before[nodes] >= 0)
            turning = np.where(same[:, None, None], 0.0, turning)
        return Nearness(self.gap[nodes], self.normal[nodes], turning, self.facet[nodes])


@dataclass(frozen=True)
class Sphere:
    """A rigid sphere of ``radius`` [mm].

    >>> Sphere(40.0).near(np.array([[0.0, 0.0, 5.0]]), depth=2.0).gap
    array([3.])
    """

    radius: float

    def near(self, places: Array, depth: float) -> Nearness:
        """Return gap, normal and the normal's derivative (I - n n') / distance."""
        spoke = places - np.array([0.0, 0.0, depth - self.radius])
        distance = np.maximum(np.linalg.norm(spoke, axis=1), 1e-9 * self.radius)
        normal = spoke / distance[:, None]
        turning = (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / distance[:, None, None]
        return Nearness(distance - self.radius, normal, turning)

    def way(self, reach: float, depth: float) -> float:
        """Return the shortest way [mm] from the sphere's highest point to a point of the flat sheet's plane that is
        ``reach`` [mm] from the axis: along the sphere, and then straight.

        >>> Sphere(30.0).way(40.0, depth=0.0), round(Sphere(30.0).way(40.0, depth=30.0), 6)
        (40.0, 51.899375)
        """
        angle, straight = self._leaving(reach, depth)
        return self.radius * angle + straight

    def along(self, part: Array, reach: float, depth: float) -> Array:
        """Return distance from the axis and height (n, 2) [mm] of points at each ``part`` (n,) of that way.

        >>> Sphere(30.0).along(np.array([0.0, 1.0]), 40.0, depth=30.0).round(9) + 0.0
        array([[ 0., 30.],
               [40.,  0.]])
        """
        angle, straight = self._leaving(reach, depth)
        at = part * (self.radius * angle + straight)
        on = np.minimum(at / self.radius, angle)
        beyond = np.maximum(at - self.radius * angle, 0.0)
        out = self.radius * np.sin(on) + beyond * np.cos(on)
        return np.column_stack([out, depth - self.radius + self.radius * np.cos(on) - beyond * np.sin(on)])

    def _leaving(self, reach: float, depth: float) -> tuple[float, float]:
        """Return the angle from the axis at which the shortest way leaves the sphere, and how long it is from there."""
        far = np.hypot(reach, self.radius - depth)
        if far <= self.radius:
            return 0.0, np.inf
        angle = np.arctan2(reach, self.radius - depth) - np.arccos(self.radius / far)
        return float(angle), float(np.sqrt(far**2 - self.radius**2))

    def height(self, plane: Array, depth: float) -> Array:
        """Return the height of the upper half."""
        square = self.radius**2 - (plane**2).sum(axis=1)
        return np.where(square > 0, depth - self.radius + np.sqrt(np.maximum(square, 0.0)), -np.inf)


#: Closer to an edge or corner than this part of the punch's size the direction to it is lost in rounding.
_CLOSE = 1e-9
#: Mirrored points lie on the surface to this part of its size: what single precision in an STL file leaves.
_MIRRORED = 1e-6


@dataclass(frozen=True)
class Facets:
    """The surface of a punch in its own coordinates, moved by ``shift`` (3,) [mm], its highest point to z = 0, its
    sharp edges rounded by ``edge_radius`` [mm].

    >>> from hyperfab.surface import Surface
    >>> cone = Surface([[0, 0, 5], [9, 0, 0], [0, 9, 0], [-9, -9, 0]], [[0, 1, 2], [0, 2, 3], [0, 3, 1]])
    >>> Facets(cone, np.array([0.0, 0.0, -5.0])).near(np.array([[0.0, 0.0, 3.0]]), depth=1.0).gap
    array([2.])
    """

    surface: Surface
    shift: Array
    edge_radius: float = 0.0
    _seen: dict[int, Ints] = field(default_factory=dict, repr=False, compare=False)

    def near(self, places: Array, depth: float) -> Nearness:
        """Return how the points (n, 3) lie to the facets pushed in by ``depth`` [mm]."""
        surface = self.surface
        points = places - self.shift - np.array([0.0, 0.0, depth])
        # The same nodes come again and again, hardly moved: their facets make the search short.
        found = surface.nearest(points, hint=self._seen.get(len(points)))
        self._seen[len(points)] = found.face
        own = surface.normals[found.face]
        inner = found.feature == 0
        lost = np.abs(found.distance) < _CLOSE * self.size
        normal = np.where((inner | lost)[:, None], own, found.normal)
        gap = np.where(inner, ((points - found.point) * own).sum(axis=1), found.distance)
        if self.edge_radius == 0.0:
            return Nearness(gap, normal, self._curvature[found.face], found.face)
        turning, face = self._curvature[found.face], found.face.copy()
        at, near, along, bent = self._rounded.near(points, found.face)
        gap[at], normal[at], turning[at] = near, along, bent
        face[at] = -1
        return Nearness(gap, normal, turning, face)

    def height(self, plane: Array, depth: float) -> Array:
        """Return the height (n,) of the highest facet above points (n, 2) of the plane; minus infinity beside it."""
        high = float(self.surface.bounds[0, 5]) + 1.0
        origins = np.column_stack([plane - self.shift[:2], np.full(len(plane), high)])
        way, _ = self.surface.ray(origins, [0.0, 0.0, -1.0])
        return np.where(np.isfinite(way), high - way + self.shift[2] + depth, -np.inf)

    @cached_property
    def _rounded(self) -> Rounded:
        return Rounded(self.surface, self.edge_radius)

    @cached_property
    def _curvature(self) -> Array:
        """Shape operators (m, 3, 3) [1/mm] of what the facets stand for; zero beside edges meant to be sharp."""
        curvature = self.surface.curvature.copy()
        curvature[self._beside_edges] = 0.0
        return curvature

    @cached_property
    def sharp(self) -> Flags:
        """Which facets (m,) have a corner on an edge that is sharp."""
        return self._beside_edges & (self.edge_radius == 0.0)

    @cached_property
    def _beside_edges(self) -> Flags:
        surface = self.surface
        face, edge = np.nonzero(np.abs(surface.edge_turn) > SHARP)
        corner = np.zeros(len(surface.vertices), bool)
        corner[surface.faces[face, edge]] = corner[surface.faces[face, (edge + 1) % 3]] = True
        return np.asarray(np.any(corner[surface.faces], axis=1))

    def above(self, depth: float) -> Array:
        """Return corners (k, 3) [mm] of what rises above the sheet's plane, z = 0, when pushed in by ``depth``."""
        vertices = self.surface.vertices + self.shift + np.array([0.0, 0.0, depth])
        first = self.surface.faces.ravel()
        last = self.surface.faces[:, [1, 2, 0]].ravel()
        crossed = (vertices[first, 2] > 0.0) & (vertices[last, 2] < 0.0)
        crossed |= (vertices[first, 2] < 0.0) & (vertices[last, 2] > 0.0)
        a, b = vertices[first[crossed]], vertices[last[crossed]]
        part = a[:, 2] / (a[:, 2] - b[:, 2])
        cut = a + part[:, None] * (b - a)
        cut[:, 2] = 0.0
        return np.concatenate([vertices[vertices[:, 2] > 0.0], cut])

    def is_mirrored(self, depth: float) -> bool:
        """Whether what rises above the sheet, pushed in by ``depth`` [mm], is its own mirror image in x and in y."""
        surface = self.surface
        corners = surface.vertices[surface.faces] + self.shift + np.array([0.0, 0.0, depth])
        risen = corners[corners[:, :, 2].max(axis=1) > 0.0]
        seen = np.concatenate(
            [risen.reshape(-1, 3), risen.mean(axis=1), 0.5 * (risen + np.roll(risen, 1, axis=1)).reshape(-1, 3)]
        )
        seen = seen[seen[:, 2] > 0.0]
        limit = _MIRRORED * self.size
        return all(
            bool(np.abs(self.near(seen * mirror, depth).gap).max(initial=0.0) <= limit)
            for mirror in (np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0]))
        )

    @cached_property
    def size(self) -> float:
        """Longest side [mm] of the box around it."""
        return float((self.surface.bounds[0, 3:] - self.surface.bounds[0, :3]).max())


#: A rigid surface that is pushed up along z: at depth 0 its highest point touches the plane z = 0.
Punch = Sphere | Facets
