"""What a run waits for, what it has gone through, and temperatures between its steps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.ledger import Ledger
from hyperfab.thermal.step import along
from hyperfab.thermal.trail import Trail


@dataclass(frozen=True)
class Target:
    """``sensor`` (n,) weighs nodal temperatures into the watched mean; ``value`` [degC] is waited for."""

    sensor: Array
    value: float


@dataclass(frozen=True)
class Reduced:
    """How much of a run was followed on a reduced mold, and how far that may be off.

    ``error`` [K] is an upper estimate at any watched place and time: what the checked stretches were off by at their
    ends, anywhere in the mold, summed over all stretches, and what they were off by on the way at watched places.
    """

    unknowns: int
    begun: float
    stretches: int
    checks: int
    error: float
    returns: int


@dataclass
class History:
    """All accepted states, the largest residual of a stage on the way [K], and the account of heat.

    ``jumps`` are the states at which a power, a schedule or a part jumped; ``reduced`` tells of a reduced mold where
    one was tried.
    """

    states: Trail
    ledger: Ledger
    residual: float = 0.0
    reached: int | None = None
    rejected: int = 0
    settled: bool = False
    switches: list[float] = field(default_factory=list)
    jumps: list[int] = field(default_factory=list)
    reduced: Reduced | None = None

    @property
    def reached_time(self) -> float | None:
        """Time at which the target was reached [s]."""
        return None if self.reached is None else self.states[self.reached].time

    def cut(self, count: int, switches: int) -> None:
        """Forget all but the first ``count`` states and what they had, the first ``switches`` among it."""
        del self.switches[switches:]
        self.jumps = [jump for jump in self.jumps if jump < count]
        self.states.cut(count)
        self.ledger.cut(count - 1)
        if self.reached is not None and self.reached >= count:
            self.reached = None


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
            rise = values[i] - values[i - 1]
            begin = 2.0 * rise - length * end if known is None else length * known
            risen, _ = along(rise, begin, length * end, (times[inside] - t0) / length)
            result[inside] = values[i - 1] + risen
        known = None if i in jumps else end
    return result
