"""The solids a mold is made of, as formulas: boxes, elliptic cylinders, ellipsoids and closed STL surfaces.

Lengths in mm. Each shape can say how far a point is from its surface, so that the faces of a mesh are tagged by
the geometry they lie on, not by names that a mesher passes on.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from hyperfab.arrays import Array, Ints

Vector = tuple[float, float, float]

#: Directions by name: ``x-`` is (-1, 0, 0).
DIRECTIONS: dict[str, Vector] = {
    "x-": (-1.0, 0.0, 0.0),
    "x+": (1.0, 0.0, 0.0),
    "y-": (0.0, -1.0, 0.0),
    "y+": (0.0, 1.0, 0.0),
    "z-": (0.0, 0.0, -1.0),
    "z+": (0.0, 0.0, 1.0),
}


@dataclass(frozen=True)
class Box:
    """A box with edges along the axes: the corner with the least coordinates, and the edge lengths [mm].

    >>> Box((0, 0, 0), (2, 2, 2)).distance(np.array([[1.0, 1.0, 1.0], [1.0, 1.0, 4.0]]))
    array([1., 2.])
    """

    origin: Vector
    size: Vector
    name: str | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest corner."""
        low = np.asarray(self.origin, dtype=float)
        return low, low + np.asarray(self.size, dtype=float)

    def distance(self, points: Array) -> Array:
        """Return the distance of each point (n, 3) from the surface, >= 0 [mm]."""
        low, high = self.bounds
        half = (high - low) / 2
        q = np.abs(points - (low + half)) - half
        outside = np.linalg.norm(np.maximum(q, 0.0), axis=1)
        return np.where(outside > 0, outside, -np.max(q, axis=1))


@dataclass(frozen=True)
class Cylinder:
    """An elliptic cylinder along an axis, from the middle of its first end; semi-axes in the order x, y, z.

    ``semi_axes`` belong to the two other directions in their cyclic order: axis z has (x, y), axis x (y, z),
    axis y (z, x).
    """

    origin: Vector
    axis: Literal["x", "y", "z"]
    length: float
    semi_axes: tuple[float, float]
    name: str | None = None

    @property
    def order(self) -> tuple[int, int, int]:
        """Return the coordinate numbers (first semi-axis, second semi-axis, axis)."""
        k = "xyz".index(self.axis)
        return (k + 1) % 3, (k + 2) % 3, k

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the bounding box."""
        i, j, k = self.order
        low = np.array(self.origin, dtype=float)
        high = low.copy()
        for index, semi in zip((i, j), self.semi_axes, strict=True):
            low[index] -= semi
            high[index] += semi
        high[k] += self.length
        return low, high

    def distance(self, points: Array) -> Array:
        """Return the distance of each point from the surface; near the wall to first order [mm]."""
        i, j, k = self.order
        x = points - np.asarray(self.origin, dtype=float)
        wall = _elliptic(x[:, [i, j]], np.asarray(self.semi_axes))
        ends = np.maximum(-x[:, k], x[:, k] - self.length)
        outside = np.hypot(np.maximum(wall, 0.0), np.maximum(ends, 0.0))
        return np.where(outside > 0, outside, -np.maximum(wall, ends))


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid with axes along x, y, z; ``half`` keeps the half on that side of its centre, as ``z+``."""

    centre: Vector
    semi_axes: Vector
    half: str | None = None
    name: str | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the bounding box."""
        low = np.asarray(self.centre, dtype=float) - np.asarray(self.semi_axes)
        high = np.asarray(self.centre, dtype=float) + np.asarray(self.semi_axes)
        if self.half is not None:
            axis = "xyz".index(self.half[0])
            (low if self.half[1] == "+" else high)[axis] = self.centre[axis]
        return low, high

    def distance(self, points: Array) -> Array:
        """Return the distance of each point from the surface, near it to first order [mm]."""
        x = points - np.asarray(self.centre, dtype=float)
        shell = _elliptic(x, np.asarray(self.semi_axes))
        if self.half is None:
            return np.abs(shell)
        flat = -x @ np.asarray(DIRECTIONS[self.half])
        outside = np.hypot(np.maximum(shell, 0.0), np.maximum(flat, 0.0))
        return np.where(outside > 0, outside, -np.maximum(shell, flat))


@dataclass(frozen=True)
class Stl:
    """A closed triangle surface: vertices (n, 3) in mm and triangles (m, 3), seen counter-clockwise from outside.

    ``fine`` is the surface of many facets that a coarser one stands for.
    """

    vertices: Array
    triangles: Ints
    name: str | None = None
    fine: Stl | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the bounding box."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def distance(self, points: Array) -> Array:
        """Return the distance of each point from the surface, or from the ``fine`` one where that is nearer [mm]."""
        from hyperfab.surface import Surface  # 0.7 s to load, with what compiles its search

        found = np.abs(Surface(self.vertices, self.triangles).nearest(points).distance)
        return found if self.fine is None else np.minimum(found, self.fine.distance(points))


Shape = Box | Cylinder | Ellipsoid | Stl


@dataclass(frozen=True)
class Body:
    """A part of the mold, or a cavity cut out of the parts: the union of its shapes.

    ``mesh_size`` [mm] where a part is meshed finer than the others.
    """

    name: str
    shapes: tuple[Shape, ...]
    mesh_size: float | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the bounding box."""
        pairs = [shape.bounds for shape in self.shapes]
        return np.min([low for low, _ in pairs], axis=0), np.max([high for _, high in pairs], axis=0)


@dataclass(frozen=True)
class Patch:
    """The faces of a part inside a box: their outline is cut into the part's faces, so that areas are exact."""

    part: str
    box: Box


@dataclass(frozen=True)
class Geometry:
    """All that is meshed: parts, cavities cut out of all of them, and face patches."""

    parts: tuple[Body, ...]
    cavities: tuple[Body, ...] = ()
    patches: tuple[Patch, ...] = field(default=())

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the bounding box of the parts."""
        pairs = [part.bounds for part in self.parts]
        return np.min([low for low, _ in pairs], axis=0), np.max([high for _, high in pairs], axis=0)


def _elliptic(x: Array, semi_axes: Array) -> Array:
    """Return the signed distance from an ellipse or ellipsoid to first order: f/|grad f|, f = |x/a| - 1."""
    scaled = x / semi_axes
    radius = np.linalg.norm(scaled, axis=1)
    gradient = np.linalg.norm(scaled / semi_axes, axis=1) / np.where(radius > 0, radius, 1.0)
    inner = -float(np.min(semi_axes))
    return np.where(radius > 0, (radius - 1.0) / np.where(gradient > 0, gradient, 1.0), inner)
