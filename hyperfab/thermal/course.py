"""A run of a reduced mold between the times that it stepped to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Course:
    """A run by its coordinates (n, r) at the times ``grid`` (n,) [s] that it stepped to, and how fast they change then.

    Between two times it is the parabola through both values with the slope at the end.
    """

    grid: Array
    states: Array
    slopes: Array

    def of(self, rows: Array) -> Course:
        """Return the course of what ``rows`` (p, r) read."""
        return Course(self.grid, self.states @ rows.T, self.slopes @ rows.T)

    def at(self, times: Array) -> Array:
        """Return the coordinates (k, r) at ``times`` (k,) [s]."""
        step = np.clip(np.searchsorted(self.grid, times, side="left") - 1, 0, len(self.grid) - 2)
        length = (self.grid[step + 1] - self.grid[step])[:, None]
        back = ((times - self.grid[step + 1]) / length[:, 0])[:, None]
        end, slope = self.states[step + 1], self.slopes[step + 1] * length
        bend = self.states[step] - end + slope
        return np.asarray(end + slope * back + bend * back**2)

    def when(self, row: Array, value: float) -> float | None:
        """Return when what ``row`` (r,) reads first comes to a value [s]; None where it never does."""
        above = np.flatnonzero(self.states @ row >= value)
        if len(above) == 0 or above[0] == 0:
            return float(self.grid[0]) if len(above) else None
        length = self.grid[above[0]] - self.grid[above[0] - 1]
        before, beyond = self.states[above[0] - 1 : above[0] + 1] @ row - value
        if beyond == 0.0:  # at a peak the slope below is none
            return float(self.grid[above[0]])
        slope = length * float(self.slopes[above[0]] @ row)
        bend = before - beyond + slope
        back = 2.0 * beyond / (slope + np.sqrt(slope**2 - 4.0 * bend * beyond))
        return float(self.grid[above[0]] - length * back)
