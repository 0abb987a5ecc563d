"""Sheets of any flat outline: a closed polyline, with corners where it turns sharply and smooth in between."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.kernels import polygon_distance
from hyperfab.membrane.outline import Arc

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
        turn = side[:-1, 0] * side[1:, 1] - side[:-1, 1] * side[1:, 0]
        length = np.linalg.norm(side, axis=1)
        return bool((turn >= -1e-9 * length[:-1] * length[1:]).all())

    @property
    def symmetric(self) -> bool:
        """Whether the outline is its own mirror image in x and in y."""
        limit = _MIRRORED * float(np.ptp(self.vertices, axis=0).max())
        seen = np.concatenate([self.vertices, 0.5 * (self.vertices + np.roll(self.vertices, 1, axis=0))])
        return all(
            bool(np.abs(self._distance(seen * mirror)).max() <= limit) for mirror in ([-1, 1], [1, -1])
        )

    def inside(self, points: Array, margin: Array | float = 0.0) -> Flags:
        """Whether points (n, 2) lie inside by at least ``margin`` [mm]."""
        found = self._distance(points) >= margin
        if self.quarter:
            found &= (points[:, 0] >= margin) & (points[:, 1] >= margin)
        return np.asarray(found)

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
    return np.asarray(
        (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
    )


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
