"""What a run waits for, what it has gone through, temperatures between its steps, and its account of heat: supplied by
heaters and held faces, lost through faces, stored; the three must balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.thermal.condition import Heater
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.step import along
from hyperfab.thermal.trail import Trail

#: A body that changes by less [K] has turned no heat over that an error could be measured by.
LEAST_CHANGE = 1e-4
#: Rows of a curve over a run that the steps are filled up to.
ROWS = 200


@dataclass
class Ledger:
    """Heat since the start [J]. ``entered`` has one row a step and one column a condition (then held nodes).

    ``supplying`` marks the heaters' columns, ``held`` those of held nodes, which supply in steps in which they give
    heat. ``stored`` is the heat in the body after each step, less that at the start. ``least`` is the heat that changes
    the body by LEAST_CHANGE [J].
    """

    names: list[str]
    supplying: Flags
    held: Flags
    first_stored: float
    least: float = 0.0
    entered: list[Array] = field(default_factory=list)
    stored: list[float] = field(default_factory=list)
    moved: float = 0.0

    @staticmethod
    def begin(model: HeatModel, stored: float, exchanged: Sequence[str] = ()) -> Ledger:
        """Open the account with the heat in the body; ``exchanged`` name parts that are renewed."""
        kinds = [
            *((c.name, isinstance(c, Heater), False) for c in model.conditions),
            *((one.name, False, True) for one in model.prescribed),
            *((name, False, False) for name in exchanged),
        ]
        least = LEAST_CHANGE * float(model.lumped_capacity.sum())
        heaters, held = (np.array([kind[k] for kind in kinds], dtype=bool) for k in (1, 2))
        return Ledger([name for name, _, _ in kinds], heaters, held, stored, least)

    def add(self, heat: Array, stored: float, moved: float) -> None:
        """Enter one step: ``stored`` is in the body after it, ``moved`` went from node to node in it."""
        self.moved += moved
        self.entered.append(np.concatenate([heat, np.zeros(len(self.names) - len(heat))]))
        self.stored.append(stored - self.first_stored)

    def cut(self, steps: int) -> None:
        """Forget all but the first ``steps`` steps."""
        del self.entered[steps:], self.stored[steps:]

    def exchange(self, name: str, stored: float) -> None:
        """Enter what a renewed part brings into the body, at the time of the last step."""
        now = stored - self.first_stored
        self.entered[-1][self.names.index(name)] += now - self.stored[-1]
        self.stored[-1] = now

    @property
    def by_condition(self) -> dict[str, float]:
        """Heat that entered through each condition so far [J]; lost heat is negative."""
        total = np.sum(self.entered, axis=0) if self.entered else np.zeros(len(self.names))
        return dict(zip(self.names, total.tolist(), strict=True))

    @property
    def by_step(self) -> tuple[Array, Array]:
        """Heat that was supplied and heat that was lost in each step (steps,) [J]."""
        rows = np.array(self.entered).reshape(len(self.entered), len(self.names))
        given = np.where(self.held, np.maximum(rows, 0.0), np.where(self.supplying, rows, 0.0))
        return given.sum(axis=1), -(rows - given).sum(axis=1)

    def supplied(self, steps: int | None = None) -> float:
        """Heat given by heaters and held nodes in the first ``steps`` steps (all) [J]."""
        return float(self.by_step[0][:steps].sum())

    def lost(self, steps: int | None = None) -> float:
        """Heat that left through all other conditions, and through held nodes that took it [J]."""
        return float(self.by_step[1][:steps].sum())

    def imbalance(self) -> float:
        """Return the largest |supplied - lost - stored| after any step, over the heat turned over in the whole run.

        The heat turned over is all that passed through any condition, in or out, or moved inside the body; at
        least what changes the body's temperature by LEAST_CHANGE, or rounding would be held against nothing.
        """
        if not self.entered:
            return 0.0
        entered = np.cumsum([row.sum() for row in self.entered])
        turned = max(float(np.sum(np.abs(self.entered))), self.moved)
        open_by = float(np.abs(entered - np.array(self.stored)).max())
        scale = max(turned, float(np.abs(self.stored).max()), self.least)
        return open_by / scale if scale > 0.0 else 0.0


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


def curve_times(history: History) -> Array:
    """Return the times of all steps and evenly spaced ones between, about ``ROWS`` in all [s]."""
    steps = np.array(history.states.times)
    even = np.linspace(steps[0], steps[-1], ROWS + 1)
    near = np.abs(even[:, None] - steps[None, :]).min(axis=1) < 1e-3 * (steps[-1] - steps[0]) / ROWS
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
