"""Temperatures between the time steps: cubic pieces with the rates of change that the steps found."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.history import History


def curve_times(history: History, rows: int = 200) -> Array:
    """Return the times of all steps and evenly spaced ones between, about ``rows`` in all [s]."""
    steps = np.array(history.states.times)
    even = np.linspace(steps[0], steps[-1], rows + 1)
    near = np.abs(even[:, None] - steps[None, :]).min(axis=1) < 1e-3 * (steps[-1] - steps[0]) / rows
    return np.sort(np.concatenate([steps, even[~near]]))


def curve(history: History, sensor: Array, times: Array) -> Array:
    """Return what a probe reads at ``times`` [degC]; ``sensor`` (n,) weighs the nodes.

    At the times of the steps the values are the steps' own. In a first step, or after a jump of the power, the
    piece is a parabola: its slope at the start is not known.
    """
    at = np.array(history.states.times)
    readings = [state.reading(sensor) for state in history.states]
    values = np.array([value for value, _ in readings])
    result = np.interp(times, at, values)
    jumps = set(history.jumps)
    known: float | None = None
    for i, (_, end) in enumerate(readings):
        if i == 0 or end is None:
            continue
        t0, t1 = at[i - 1], at[i]
        length = t1 - t0
        inside = (times > t0) & (times < t1)
        if inside.any():
            s = (times[inside] - t0) / length
            rise = values[i] - values[i - 1]
            start = 2.0 * rise / length - end if known is None else known
            cubic = length * (start * s * (1 - s) ** 2 - end * s**2 * (1 - s))
            result[inside] = values[i - 1] + rise * s**2 * (3 - 2 * s) + cubic
        known = None if i in jumps else end
    return result
