"""Faces by name: which facets of the mesh ``mold.z+``, ``pocket.all`` or the faces inside a box are.

A facet belongs to a body because it lies on the body's formula, so the names do not depend on the mesher.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array, Flags
from hyperfab.errors import InputError
from hyperfab.numerics.vectors import cross2
from hyperfab.thermal.elements import facet_weights
from hyperfab.thermal.geometry import DIRECTIONS, Body, Box, Geometry, Shape, Stl
from hyperfab.thermal.mesh import HeatMesh

#: A face looks a way where its normal has at least this component in it (edge-on faces do not).
FACING = 0.01
#: A curved face looks a way only if it does so clearly somewhere.
CURVED_FACING = 0.4

#: The middle of a flat facet on a curved surface may be this share of its size away from the surface.
SAGITTA = 0.08
#: ... and on an STL surface that was meshed anew, where small balls have few facets.
SAGITTA_STL = 0.25


@dataclass(frozen=True)
class FaceSet:
    """Facets of one name: ``mask`` (f,) over the mesh's facets, ``flip`` where the far side is the named one."""

    name: str
    mask: Flags
    flip: Flags

    def near(self, outer: Flags) -> FaceSet:
        """Return the facets of the set that are outer faces."""
        return FaceSet(self.name, self.mask & outer, self.flip)


class Faces:
    """The faces of a meshed geometry.

    ``mesh`` must be the mesh of ``geometry`` (lengths in m, the geometry's in mm).
    """

    def __init__(self, mesh: HeatMesh, geometry: Geometry) -> None:
        self.mesh = mesh
        self.geometry = geometry
        nodes = mesh.points[mesh.facet_nodes(np.ones(len(mesh.facets.element), dtype=bool))] * 1e3
        self._corners = nodes[:, :3]
        #: Value at the centre of a six-node triangle: -1/9 of the corners plus 4/9 of the edges.
        self._centre = (4 * nodes[:, 3:].sum(axis=1) - nodes[:, :3].sum(axis=1)) / 9
        cross = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
        self._size = np.sqrt(np.linalg.norm(cross, axis=1))
        self._normal = cross / np.linalg.norm(cross, axis=1)[:, None]
        low, high = geometry.bounds
        self._tight = 1e-6 * float(np.linalg.norm(high - low))

    @cached_property
    def areas(self) -> Array:
        """Area of each facet [m^2]."""
        everything = np.ones(len(self.mesh.facets.element), dtype=bool)
        return facet_weights(self.mesh.points[self.mesh.facet_nodes(everything)]).sum(axis=1)

    def area(self, found: FaceSet) -> float:
        """Return the area of a set of facets [m^2]."""
        return float(self.areas[found.mask].sum())

    @cached_property
    def cavity(self) -> Flags:
        """Facets on the walls of cavities."""
        found = np.zeros(len(self.mesh.facets.element), dtype=bool)
        for body in self.geometry.cavities:
            found |= self._on_body(body)
        return found

    @cached_property
    def closed_in(self) -> Flags:
        """Outer facets that no way leads to from outside: the walls of voids, which look away from the material."""
        outer = np.flatnonzero(self.mesh.facets.outer)
        corners = self._corners[outer]
        # By place: at a joint that may jump in temperature each side has nodes of its own.
        _, node = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        node = node.reshape(-1, 3)
        ends = node[:, :2].ravel(), node[:, 1:].ravel()
        graph = coo_matrix((np.ones(len(ends[0])), ends), shape=(int(node.max()) + 1,) * 2)
        wall = connected_components(graph, directed=False)[1][node[:, 0]]
        around = corners - corners.mean(axis=(0, 1))
        volumes = np.bincount(wall, np.linalg.det(around))
        found = np.zeros(len(self.mesh.facets.element), dtype=bool)
        found[outer] = volumes[wall] < 0.0
        return found

    @cached_property
    def names(self) -> list[str]:
        """All names faces can be called by, without the direction."""
        bodies = (*self.geometry.parts, *self.geometry.cavities)
        return [body.name for body in bodies] + [s.name for b in bodies for s in b.shapes if s.name]

    def named(self, text: str) -> FaceSet:
        """Return the facets called ``text`` (``plate.z+``, ``pocket.all``).

        Raises InputError with the nearest names where there is no such face, or no facet is left of it.
        """
        name, _, way = text.rpartition(".")
        if not name or way not in (*DIRECTIONS, "all"):
            ways = ", ".join((*DIRECTIONS, "all"))
            raise InputError(f"{text!r} names no face", remedy=f"write NAME.WAY with WAY one of {ways}")
        if name not in self.names:
            near = difflib.get_close_matches(name, self.names, 3, 0.4) or self.names
            offered = ", ".join(f"{other}.{way}" for other in near[:8])
            raise InputError(f"there is no face {text!r}", remedy=f"the nearest names are {offered}")
        mask, flip = self._of(name)
        if way != "all":
            mask = self._that_way(mask, flip, np.asarray(DIRECTIONS[way]))
        if not mask.any():
            raise InputError(
                f"no face of {name!r} looks {way}" if way != "all" else f"{name!r} has no face",
                remedy="it is covered or open there; name another face",
            )
        return FaceSet(text, mask, flip)

    def inside(self, part: str, box: Box) -> FaceSet:
        """Return the facets of a part, walls of cavities included, that lie inside a box."""
        mask, flip = self._of_part(self._number(part))
        low, high = box.bounds
        within = (self._centre >= low - self._tight) & (self._centre <= high + self._tight)
        mask &= within.all(axis=1)
        if not mask.any():
            raise InputError(f"no face of part {part!r} lies inside the box", remedy="move or enlarge the box")
        return FaceSet(f"{part} in a box", mask, flip)

    def interface(self, first: str, second: str) -> FaceSet:
        """Return the facets where two parts touch; the near side is the first part's."""
        i, j = self._number(first), self._number(second)
        f = self.mesh.facets
        near_part = self.mesh.parts[f.element]
        far_part = np.where(f.outer, -1, self.mesh.parts[f.other])
        mask = ((near_part == i) & (far_part == j)) | ((near_part == j) & (far_part == i))
        if not mask.any():
            raise InputError(f"parts {first!r} and {second!r} do not touch", remedy="check their places")
        return FaceSet(f"{first}/{second}", mask, near_part == j)

    def _number(self, part: str) -> int:
        names = [body.name for body in self.geometry.parts]
        if part not in names:
            near = ", ".join(difflib.get_close_matches(part, names, 3, 0.4) or names[:8])
            raise InputError(f"there is no part {part!r}", remedy=f"the nearest names are {near}")
        return names.index(part)

    def _of(self, name: str) -> tuple[Flags, Flags]:
        """Return the facets of a part, cavity or shape, and where its outside is the facet's far side."""
        never = np.zeros(len(self.mesh.facets.element), dtype=bool)
        for number, body in enumerate(self.geometry.parts):
            if body.name == name:
                mask, flip = self._of_part(number)
                return mask & ~self.cavity, flip
            for shape in body.shapes:
                if shape.name == name:
                    mask, flip = self._of_part(number)
                    return mask & ~self.cavity & self._on_shape(shape), flip
        for body in self.geometry.cavities:
            if body.name == name:
                return self._on_body(body), never
            for shape in body.shapes:
                if shape.name == name:
                    return self._on_body(body) & self._on_shape(shape), never
        raise InputError(f"there is no face {name!r}")

    def _of_part(self, number: int) -> tuple[Flags, Flags]:
        f = self.mesh.facets
        near = self.mesh.parts[f.element] == number
        far = ~f.outer & (self.mesh.parts[f.other] == number)
        return near | far, far & ~near

    def _on_body(self, body: Body) -> Flags:
        found = np.zeros(len(self.mesh.facets.element), dtype=bool)
        for shape in body.shapes:
            found |= self._on_shape(shape)
        return found & self.mesh.facets.outer

    def _on_shape(self, shape: Shape) -> Flags:
        at_centre = shape.distance(self._centre)
        at_corners = shape.distance(self._corners.reshape(-1, 3)).reshape(-1, 3)
        sagitta = SAGITTA_STL if isinstance(shape, Stl) else SAGITTA
        exact: Flags = at_centre <= self._tight
        curved: Flags = (at_corners <= self._tight).all(axis=1) & (at_centre <= sagitta * self._size)
        return exact | curved

    def _that_way(self, mask: Flags, flip: Flags, way: Array) -> Flags:
        """Keep facets that look ``way`` with nothing of the same body in front of them."""
        inward = np.zeros(len(mask), dtype=bool)
        on_cavity = self.cavity & mask
        inward[on_cavity] = True  # a cavity's outside is the part's inside
        facing = (self._normal @ way) * np.where(flip ^ inward, -1.0, 1.0)
        candidates = np.flatnonzero(mask & (facing > FACING) & self._not_edge_on(mask, facing))
        height = self._centre @ way
        blockers = np.flatnonzero(mask & (facing < -FACING))
        if len(candidates) == 0:
            return np.zeros_like(mask)
        blockers = blockers[(self._corners[blockers] @ way).max(axis=1) > height[candidates].min()]
        across = [axis for axis in range(3) if way[axis] == 0]
        hidden = _covered(
            self._centre[candidates][:, across],
            height[candidates] + 1e-3 * self._size[candidates],
            self._corners[blockers][:, :, across],
            height[blockers],
        )
        kept = np.zeros_like(mask)
        kept[candidates[~hidden]] = True
        return kept

    def _not_edge_on(self, mask: Flags, facing: Array) -> Flags:
        """Leave out curved faces that only seem to look that way: flat facets on an upright wall lean a little."""
        face = self.mesh.facets.face
        known = mask & (face >= 0)
        count = int(face.max()) + 1
        most, least = np.full(count, -1.0), np.full(count, 1.0)
        np.maximum.at(most, face[known], facing[known])
        np.minimum.at(least, face[known], facing[known])
        real = (most > CURVED_FACING) | (most - least < 1e-6)
        return (face < 0) | real[np.maximum(face, 0)] if count else np.ones_like(mask)


def _covered(points: Array, heights: Array, triangles: Array, triangle_heights: Array) -> Flags:
    """Whether a triangle (t, 3, 2) stands higher and over each point (p, 2)."""
    covered = np.zeros(len(points), dtype=bool)
    for start in range(0, len(triangles), 256):
        t = triangles[start : start + 256]
        inside = np.ones((len(points), len(t)), dtype=bool)
        turn = cross2(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
        for i in range(3):
            edge = t[:, (i + 1) % 3] - t[:, i]
            inside &= cross2(edge[None], points[:, None] - t[None, :, i]) * np.sign(turn) > 0
        higher = triangle_heights[start : start + 256][None] > heights[:, None]
        covered |= (inside & higher).any(axis=1)
    return covered
