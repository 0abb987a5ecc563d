"""Flat outlines of a sheet: their boundary, their inside, and the part of them that symmetry leaves to compute."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array


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


class Piece(Protocol):
    """One smooth piece of a boundary, between corners or symmetry lines."""

    @property
    def normal(self) -> int | None:
        """The axis (0 or 1) that displacements may not have on a symmetry line, None on the rim."""

    @property
    def length(self) -> float:
        """Its length [mm]."""

    def points(self, fraction: Array) -> Array:
        """Return the points at ``fraction`` (0 to 1) of its length."""

    def between(self, ends: Array) -> Array:
        """Return the points (n, 2) half-way along it between two of its points, ``ends`` (n, 2, 2)."""


class Outline(Protocol):
    """A flat outline around the origin, where the sphere first touches."""

    @property
    def quarter(self) -> bool:
        """Whether only x, y >= 0 is meant, the rest being its mirror image."""

    @property
    def arcs(self) -> tuple[Piece, ...]:
        """The boundary in smooth pieces, anticlockwise."""

    @property
    def convex(self) -> bool:
        """Whether a straight line between any two of its points stays inside."""

    @property
    def reach(self) -> float:
        """Smallest distance [mm] from the origin to the rim."""

    @property
    def area(self) -> float:
        """Area [mm²] of the whole sheet, also where a quarter is computed."""

    def inside(self, points: Array, margin: Array | float = 0.0) -> NDArray[np.bool_]:
        """Whether points (n, 2) lie inside by at least ``margin`` [mm]."""


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

    def inside(self, points: Array, margin: Array | float = 0.0) -> NDArray[np.bool_]:
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

    def inside(self, points: Array, margin: Array | float = 0.0) -> NDArray[np.bool_]:
        """Whether points lie inside by ``margin``."""
        found = np.max(np.abs(points), axis=1) <= self.side / 2 - margin
        return _in_quarter(found, points, margin) if self.quarter else np.asarray(found)


def _in_quarter(found: NDArray[np.bool_], points: Array, margin: Array | float) -> NDArray[np.bool_]:
    return np.asarray(found & (points[:, 0] >= margin) & (points[:, 1] >= margin))
