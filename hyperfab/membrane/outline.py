"""Flat outlines of a sheet, discs, squares and closed polylines with corners where they turn sharply: their boundary,
their inside, and the part of them that symmetry leaves to compute."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.kernels import polygon_distance
from hyperfab.numerics.vectors import cross2


@dataclass(frozen=True)
class Arc:
    """One smooth piece of a boundary: points (n, 2) [mm] along it, and whether the sheet is clamped there.

    ``normal`` is the axis (0 or 1) that displacements may not have on a symmetry line, None on the rim.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    centre: tuple[float, float] | None = None
    normal: int | None = None

    def points(self, fraction: Array) -> Array:
        """Return the points at ``fraction`` (0 to 1) of the arc's length: a straight line or a circle."""
        first, last = np.asarray(self.start), np.asarray(self.end)
        part = np.asarray(fraction, float)[:, None]
        if self.centre is None:
            return np.asarray(first + part * (last - first))
        middle = np.asarray(self.centre)
        radius = np.hypot(*(first - middle))
        begin, sweep = self._angles()
        angle = begin + part[:, 0] * sweep
        return np.asarray(middle + radius * np.column_stack([np.cos(angle), np.sin(angle)]))

    def between(self, ends: Array) -> Array:
        """Return the points (n, 2) half-way along it between two of its points, ``ends`` (n, 2, 2)."""
        middle = ends.mean(axis=1)
        if self.centre is None:
            return np.asarray(middle)
        centre = np.asarray(self.centre)
        radius = np.hypot(*(np.asarray(self.start) - centre))
        spoke = middle - centre
        return np.asarray(centre + radius * spoke / np.linalg.norm(spoke, axis=1)[:, None])

    @property
    def length(self) -> float:
        """Length of the arc [mm]."""
        if self.centre is None:
            return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))
        radius = np.hypot(self.start[0] - self.centre[0], self.start[1] - self.centre[1])
        return float(radius * abs(self._angles()[1]))

    def _angles(self) -> tuple[float, float]:
        assert self.centre is not None
        begin = np.arctan2(self.start[1] - self.centre[1], self.start[0] - self.centre[0])
        final = np.arctan2(self.end[1] - self.centre[1], self.end[0] - self.centre[0])
        sweep = (final - begin) % (2 * np.pi)
        return float(begin), float(sweep if sweep > 1e-12 else 2 * np.pi)


@dataclass(frozen=True)
class Disc:
    """A round sheet of ``radius`` [mm]; ``quarter``: only x, y >= 0, with two symmetry lines.

    >>> [arc.normal for arc in Disc(100.0, quarter=True).arcs]
    [1, None, 0]
    """

    radius: float
    quarter: bool = False
    convex: ClassVar[bool] = True

    @property
    def arcs(self) -> tuple[Arc, ...]:
        """The rim, or the two symmetry lines and a quarter of the rim."""
        r = self.radius
        if self.quarter:
            return (
                Arc((0.0, 0.0), (r, 0.0), normal=1),
                Arc((r, 0.0), (0.0, r), centre=(0.0, 0.0)),
                Arc((0.0, r), (0.0, 0.0), normal=0),
            )
        return (Arc((r, 0.0), (-r, 0.0), centre=(0.0, 0.0)), Arc((-r, 0.0), (r, 0.0), centre=(0.0, 0.0)))

    @property
    def reach(self) -> float:
        """The radius [mm]."""
        return self.radius

    @property
    def area(self) -> float:
        """Area of the whole disc [mm²]."""
        return float(np.pi * self.radius**2)

    def inside(self, points: Array, margin: Array | float = 0.0) -> Flags:
        """Whether points lie inside by ``margin``."""
        found = np.hypot(points[:, 0], points[:, 1]) <= self.radius - margin
        return _in_quarter(found, points, margin) if self.quarter else np.asarray(found)


@dataclass(frozen=True)
class Square:
    """A square sheet of ``side`` [mm] with edges along x and y; ``quarter``: only x, y >= 0."""

    side: float
    quarter: bool = False
    convex: ClassVar[bool] = True

    @property
    def arcs(self) -> tuple[Arc, ...]:
        """The four edges, or two symmetry lines and the two halves of edges between them."""
        a = self.side / 2
        if self.quarter:
            return (
                Arc((0.0, 0.0), (a, 0.0), normal=1),
                Arc((a, 0.0), (a, a)),
                Arc((a, a), (0.0, a)),
                Arc((0.0, a), (0.0, 0.0), normal=0),
            )
        corners = [(a, -a), (a, a), (-a, a), (-a, -a)]
        return tuple(Arc(corners[i - 1], corners[i]) for i in range(4))

    @property
    def reach(self) -> float:
        """Half the side [mm]."""
        return self.side / 2

    @property
    def area(self) -> float:
        """Area of the whole square [mm²]."""
        return self.side**2

    def inside(self, points: Array, margin: Array | float = 0.0) -> Flags:
        """Whether points lie inside by ``margin``."""
        found = np.max(np.abs(points), axis=1) <= self.side / 2 - margin
        return _in_quarter(found, points, margin) if self.quarter else np.asarray(found)


def _in_quarter(found: Flags, points: Array, margin: Array | float) -> Flags:
    return np.asarray(found & (points[:, 0] >= margin) & (points[:, 1] >= margin))


#: A polyline that turns by more than this (radians) at a point has a corner there: a node of the mesh.
CORNER = 0.35
#: Mirrored points lie on the outline to this part of its size.
_MIRRORED = 1e-6


@dataclass(frozen=True, eq=False)
class Chain:
    """A smooth piece of a boundary: the polyline through ``vertices`` (k, 2) [mm]. Part of the rim: clamped."""

    vertices: Array
    normal: None = field(default=None, init=False)

    def points(self, fraction: Array) -> Array:
        """Return the points at ``fraction`` (0 to 1) of its length."""
        along = np.asarray(fraction, float) * self.length
        return np.column_stack([np.interp(along, self._reached, self.vertices[:, axis]) for axis in (0, 1)])

    @property
    def length(self) -> float:
        """Its length [mm]."""
        return float(self._reached[-1])

    def between(self, ends: Array) -> Array:
        """Return the points (n, 2) half-way along it between two of its points, ``ends`` (n, 2, 2)."""
        start, end = self._place(ends[:, 0]), self._place(ends[:, 1])
        # The last edge of a closed piece ends where the first begins.
        end = np.where(end < start, end + self.length, end)
        return self.points((0.5 * (start + end)) / self.length)

    @cached_property
    def _reached(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.vertices, axis=0), axis=1))])

    def _place(self, points: Array) -> Array:
        """Return how far along (n,) [mm] the polyline's points nearest to ``points`` lie."""
        a, b = self.vertices[:-1], self.vertices[1:]
        side = b - a
        square = (side**2).sum(axis=1)
        part = np.clip(((points[:, None] - a) * side).sum(axis=2) / square, 0.0, 1.0)
        away = np.linalg.norm(points[:, None] - a - part[..., None] * side, axis=2)
        near = np.argmin(away, axis=1)
        row = np.arange(len(points))
        return np.asarray(self._reached[near] + part[row, near] * np.sqrt(square[near]))


@dataclass(frozen=True, eq=False)
class Polygon:
    """A sheet whose rim is the closed polyline through ``vertices`` (k, 2) [mm], anticlockwise, around the origin.

    ``quarter``: only x, y >= 0 is meant, of an outline that is ``symmetric`` and convex.

    >>> cross = Polygon(np.array([[3, -1], [3, 1], [-3, 1], [-3, -1.0]]))
    >>> cross.area, cross.reach, cross.symmetric
    (12.0, 1.0, True)
    """

    vertices: Array
    quarter: bool = False

    @cached_property
    def arcs(self) -> tuple[Arc | Chain, ...]:
        """The rim from corner to corner, or its part in the quarter between the two symmetry lines."""
        if not self.quarter:
            return _pieces(self.vertices, closed=True)
        rim = self._first_quarter()
        a, b = float(rim[0, 0]), float(rim[-1, 1])
        return (
            Arc((0.0, 0.0), (a, 0.0), normal=1),
            *_pieces(rim, closed=False),
            Arc((0.0, b), (0.0, 0.0), normal=0),
        )

    @cached_property
    def reach(self) -> float:
        """Smallest distance [mm] from the origin to the rim; negative where the origin lies outside."""
        return float(self._distance(np.zeros((1, 2)))[0])

    @property
    def area(self) -> float:
        """Area [mm²] of the whole sheet."""
        return signed_area(self.vertices)

    @property
    def convex(self) -> bool:
        """Whether the outline turns left everywhere."""
        side = np.diff(np.vstack([self.vertices, self.vertices[:2]]), axis=0)
        length = np.linalg.norm(side, axis=1)
        return bool((cross2(side[:-1], side[1:]) >= -1e-9 * length[:-1] * length[1:]).all())

    @property
    def symmetric(self) -> bool:
        """Whether the outline is its own mirror image in x and in y."""
        limit = _MIRRORED * float(np.ptp(self.vertices, axis=0).max())
        seen = np.concatenate([self.vertices, 0.5 * (self.vertices + np.roll(self.vertices, 1, axis=0))])
        return all(bool(np.abs(self._distance(seen * mirror)).max() <= limit) for mirror in ([-1, 1], [1, -1]))

    def inside(self, points: Array, margin: Array | float = 0.0) -> Flags:
        """Whether points (n, 2) lie inside by at least ``margin`` [mm]."""
        found = self._distance(points) >= margin
        return _in_quarter(found, points, margin) if self.quarter else np.asarray(found)

    def _distance(self, points: Array) -> Array:
        """Return the distance (n,) [mm] to the rim, positive inside."""
        return np.asarray(polygon_distance(np.ascontiguousarray(points, float), self.vertices))

    def _first_quarter(self) -> Array:
        """Return the rim (k, 2) from the x axis to the y axis, x, y >= 0."""
        points = _cut(_cut(self.vertices, 0), 1)
        small = 1e-9 * float(np.abs(points).max())
        points[np.abs(points) < small] = 0.0
        inner = points[(points > 0.0).all(axis=1)]
        inner = inner[np.argsort(np.arctan2(inner[:, 1], inner[:, 0]))]
        first = points[(points[:, 1] == 0.0) & (points[:, 0] > 0.0)].max(axis=0)
        last = points[(points[:, 0] == 0.0) & (points[:, 1] > 0.0)].max(axis=0)
        return np.vstack([first, inner, last])


#: A flat outline around the origin, where the sphere first touches.
Outline = Disc | Square | Polygon


def signed_area(vertices: Array) -> float:
    """Return the area [mm²] of a closed polyline (k, 2), negative where it runs clockwise."""
    x, y = vertices.T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def crossing_sides(vertices: Array) -> tuple[int, int] | None:
    """Return two sides (numbers of their first points) of a closed polyline that cross or touch, or None."""
    count = len(vertices)
    a, b = vertices, np.roll(vertices, -1, axis=0)
    for i in range(count - 1):
        others = np.arange(i + 1, count)
        p, q = a[i], b[i]
        c, d = a[others], b[others]
        one, two = _side(p, q, c), _side(p, q, d)
        three, four = _side(c, d, p), _side(c, d, q)
        met = (one * two <= 0.0) & (three * four <= 0.0)
        # Neighbours share a point: they are wrong only where one folds back onto the other.
        met &= ~((others == i + 1) | ((i == 0) & (others == count - 1)))
        level = (one == 0.0) & (two == 0.0)
        apart = (np.maximum(p, q) < np.minimum(c, d)) | (np.minimum(p, q) > np.maximum(c, d))
        met &= ~(level & apart.any(axis=1))
        folded = (others == i + 1) & (_side(p, q, d) == 0.0) & (((q - p) * (d - q)).sum(axis=1) < 0.0)
        if (met | folded).any():
            return i, int(others[np.argmax(met | folded)])
    return None


def _side(p: Array, q: Array, r: Array) -> Array:
    return cross2(q - p, r - p)


def _pieces(points: Array, *, closed: bool) -> tuple[Arc | Chain, ...]:
    """Cut a polyline at its corners into straight lines and smooth pieces."""
    ring = np.vstack([points, points[:1]]) if closed else points
    side = np.diff(ring, axis=0)
    angle = np.arctan2(side[:, 1], side[:, 0])
    turn = np.diff(np.concatenate([angle, angle[:1]]) if closed else angle)
    sharp = np.abs((turn + np.pi) % (2 * np.pi) - np.pi) > CORNER
    corners = np.flatnonzero(sharp) + 1
    if closed:
        start = int(corners[0]) % len(points) if len(corners) else 0
        ring = np.vstack([np.roll(points, -start, axis=0), points[start]])
        corners = (corners - start) % len(points)
    cuts = np.unique(np.concatenate([[0], corners, [len(ring) - 1]]))
    return tuple(_piece(ring[i : j + 1]) for i, j in pairwise(cuts))


def _piece(points: Array) -> Arc | Chain:
    if len(points) > 2:
        return Chain(points)
    (x0, y0), (x1, y1) = points.tolist()
    return Arc((x0, y0), (x1, y1))


def _cut(points: Array, axis: int) -> Array:
    """Return the part of a closed polyline where the coordinate ``axis`` is not negative."""
    ahead = np.roll(points, -1, axis=0)
    kept = []
    for p, q in zip(points, ahead, strict=True):
        if p[axis] >= 0.0:
            kept.append(p)
        if p[axis] * q[axis] < 0.0:
            kept.append(p + p[axis] / (p[axis] - q[axis]) * (q - p))
    return np.array(kept)
