"""The rigid sphere: distance, normal and curvature as seen from points of the sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints


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

    def along(self, free: NDArray[np.bool_]) -> Nearness:
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
            turning = np.where((self.facet[nodes] == before[nodes])[:, None, None], 0.0, turning)
        return Nearness(self.gap[nodes], self.normal[nodes], turning, self.facet[nodes])


class Punch(Protocol):
    """A rigid surface that is pushed up along z: at depth 0 its highest point touches the plane z = 0."""

    def near(self, places: Array, depth: float) -> Nearness:
        """Return how the points (n, 3) lie to the surface pushed in by ``depth`` [mm]."""

    def height(self, plane: Array, depth: float) -> Array:
        """Return the height (n,) of the surface above points (n, 2) of the plane; minus infinity beside it."""


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

    def height(self, plane: Array, depth: float) -> Array:
        """Return the height of the upper half."""
        square = self.radius**2 - (plane**2).sum(axis=1)
        return np.where(square > 0, depth - self.radius + np.sqrt(np.maximum(square, 0.0)), -np.inf)
