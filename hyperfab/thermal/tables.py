"""Quantities given by a table: linear between the rows, constant beyond the first and the last."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Table:
    """A piecewise linear function y(x); ``x`` rising, both (n,). ``sd`` (n,) is one standard deviation of y, that of
    all rows together, where it is known.

    >>> t = Table(np.array([0.0, 10.0]), np.array([1.0, 3.0]))
    >>> t(np.array([-5.0, 5.0, 20.0])), t.slope(np.array([5.0, 20.0])), float(t.integral(np.array(10.0)))
    (array([1., 2., 3.]), array([0.2, 0. ]), 20.0)
    """

    x: Array
    y: Array
    sd: Array | None = None

    @staticmethod
    def constant(value: float) -> Table:
        """Return the function that is ``value`` everywhere."""
        return Table(np.array([0.0]), np.array([float(value)]))

    @property
    def spread(self) -> Table:
        """Return the standard deviation as a function of its own; zero where it is not known."""
        return Table(self.x, np.zeros_like(self.y) if self.sd is None else self.sd)

    def off(self, by: float) -> Table:
        """Return the function by so many standard deviations off."""
        return Table(self.x, self.y + by * self.spread.y, self.sd)

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same everywhere."""
        return bool(np.all(self.y == self.y[0]))

    def __call__(self, x: Array) -> Array:
        """Return y at ``x``."""
        return np.interp(x, self.x, self.y)

    def at(self, x: float) -> float:
        """Return y at one place."""
        return float(np.interp(x, self.x, self.y))

    def slope(self, x: Array) -> Array:
        """Return dy/dx; at a corner that of the piece to its right, zero beyond the ends."""
        if len(self.x) == 1:
            return np.zeros_like(x)
        piece = np.searchsorted(self.x, x, side="right")
        return self._slopes[piece]

    @cached_property
    def _slopes(self) -> Array:
        return np.concatenate([[0.0], np.diff(self.y) / np.diff(self.x), [0.0]])

    def integral(self, x: Array) -> Array:
        """Return the integral of y from 0 to ``x``."""
        return self._from_first(x) - self._from_first(np.zeros(1))[0]

    @cached_property
    def _cumulative(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(0.5 * (self.y[1:] + self.y[:-1]) * np.diff(self.x))])

    def _from_first(self, x: Array) -> Array:
        inside = np.clip(x, self.x[0], self.x[-1])
        piece = np.clip(np.searchsorted(self.x, inside, side="right") - 1, 0, max(len(self.x) - 2, 0))
        start = self.x[piece]
        within = 0.5 * (self.y[piece] + self(inside)) * (inside - start)
        below = (np.minimum(x, self.x[0]) - self.x[0]) * self.y[0]
        above = (np.maximum(x, self.x[-1]) - self.x[-1]) * self.y[-1]
        return self._cumulative[piece] + within + below + above
