"""A damped step of least squares that keeps inside bounds and linear walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hyperfab.arrays import Array, Flags

#: How often it is asked which walls a step goes along, and how little beyond one counts as on it.
_SIDES, _ON = 20, 1e-9


class Ground(NamedTuple):
    """What a step is taken from: ``gradient`` (constants,) and ``normal`` matrix of half the misfit, and by how much of
    ``size`` (constants,) each constant is damped."""

    gradient: Array
    normal: Array
    size: Array
    damping: float


class Box(NamedTuple):
    """Where constants are, ``x``, and their bounds, (constants,)."""

    x: Array
    low: Array
    high: Array

    def leaves(self, way: Array) -> Flags:
        """Return which constants at a bound a ``way`` (constants,) would carry out of it."""
        return ((self.x <= self.low) & (way < 0.0)) | ((self.x >= self.high) & (way > 0.0))


class Walls(NamedTuple):
    """What constants may not go beyond: by how much they are ``beyond`` each wall, (walls,), below 0 inside, and its
    ``slopes`` (walls, constants)."""

    beyond: Array
    slopes: Array

    def of(self, which: Flags) -> Walls:
        """Return some of them."""
        return Walls(self.beyond[which], self.slopes[which])

    @property
    def met(self) -> Walls:
        """The same as seen from where each is just met."""
        return self._replace(beyond=np.zeros_like(self.beyond))


def step_inside(ground: Ground, box: Box, walls: Walls) -> tuple[Array, Flags, Walls]:
    """Return the damped step that keeps inside ``walls``, the constants it moves, and the walls it goes along.

    These are the ones that it would else end beyond, and that push it back.

    >>> ground = Ground(np.array([2.0, 1.0]), np.eye(2), np.ones(2), 0.0)
    >>> box = Box(np.zeros(2), np.full(2, -9.0), np.full(2, 9.0))
    >>> step, _, along = step_inside(ground, box, Walls(np.array([-1.0, -5.0]), np.ones((2, 2))))
    >>> step.round(6) + 0.0, along.beyond
    (array([1., 0.]), array([-1.]))
    """
    acting, pushed = walls.beyond > _ON, np.zeros_like(box.x)
    for _ in range(_SIDES):
        along, free = walls.of(acting), ~box.leaves(ground.gradient - pushed)
        step = step_along(ground, box, along, free)
        force = ground.gradient - ground.normal @ step - ground.damping * ground.size * step
        pushes = np.zeros(len(acting))
        if np.any(acting):
            pushes[acting] = np.linalg.lstsq(along.slopes.T, force, rcond=1e-10)[0]
        pushed = walls.slopes.T @ np.maximum(pushes, 0.0)
        further = np.where(acting, pushes > 0.0, walls.beyond + walls.slopes @ step > _ON)
        if np.array_equal(further, acting):
            break
        acting = further
    return step, free, along


def step_along(ground: Ground, box: Box, walls: Walls, free: Flags) -> Array:
    """Return the damped step of ``free`` constants along ``walls``; those at a bound that it would carry out of it stay
    there."""
    step = np.zeros_like(box.x)
    for _ in range(len(step)):
        # In units of what the data tell of each constant: their own units lie many powers of ten apart.
        unit = 1.0 / np.sqrt(np.maximum(np.diag(ground.normal), ground.size)[free])
        matrix = ground.normal[free][:, free] * np.outer(unit, unit)
        matrix += np.diag(ground.damping * ground.size[free] * unit**2)
        uphill = unit * ground.gradient[free]
        step[:] = 0.0
        if len(walls.beyond):
            onto, ways = _along(walls.slopes[:, free] * unit, -walls.beyond)
            uphill = ways.T @ (uphill - matrix @ onto)
            step[free] = unit * (onto + ways @ np.linalg.lstsq(ways.T @ matrix @ ways, uphill, rcond=1e-14)[0])
        else:
            step[free] = unit * np.linalg.lstsq(matrix, uphill, rcond=1e-14)[0]
        out = box.leaves(step)
        if not np.any(out):
            break
        free = free & ~out
    return step


def _along(slopes: Array, change: Array) -> tuple[Array, Array]:
    """Return the shortest step (constants,) that makes a ``change`` (walls,) of walls with ``slopes``, and an
    orthonormal basis of those that make none."""
    left, sizes, right = np.linalg.svd(slopes)
    rank = int(np.count_nonzero(sizes > 1e-10 * np.max(sizes, initial=0.0)))
    return right[:rank].T @ (left[:, :rank].T @ change / sizes[:rank]), right[rank:].T
