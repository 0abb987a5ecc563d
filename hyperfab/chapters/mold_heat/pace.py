"""How far a warm-up has come, by steps taken and steps to come: time steps grow, and start anew where a power jumps."""

from __future__ import annotations

import math

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.thermal.condition import Heater

#: A step this much shorter than the longest since the last jump follows a jump itself.
_RESTART = 0.2
#: So many steps tell nothing of the pace: the first prepares the solver, and how steps grow takes three.
_SETTLING = 3
#: Steps from jump to jump until one has been seen.
_USUAL = 15.0
#: Stretches in full before a run that switches often may go on on a reduced mold.
_BEFORE_REDUCED = 4.0


class Pace:
    """Estimates the share of its steps that a run from ``start`` (n,) [degC] has taken, measured on the way.

    How often thermostats will switch is measured too, once they have; before, it follows from the mold as one body.
    """

    def __init__(self, problem: Problem, start: Array, reducible: bool) -> None:
        self.reducible = reducible
        self.corners = [time for time in problem.corners if time > 0.0]
        self.first, self.cycle = _switching(problem, start)
        self.together = len({(id(t.sensor), t.set_point, t.band) for t in problem.thermostats})
        self.until = 0.0
        self.steps = self._since = 0
        self.jumps: list[float] = []
        self._time = self._length = self._before = self._longest = 0.0
        self._between: list[int] = []

    def done(self, time: float, until: float) -> float:
        """Count a step that ended at ``time`` of ``until`` [s]; return the share of all steps that is done.

        A run on a reduced mold that fails its check goes back: a time before the last one is where it goes on from.
        """
        self.until = until
        self.steps += 1
        length = time - self._time
        if length <= 0.0:
            self.jumps = [jump for jump in self.jumps if jump <= time]
            self._between = self._between[: len(self.jumps)]
            self._since, self._time = self._since + 1, time
            return self._share()
        if length < _RESTART * self._longest:
            self.jumps.append(self._time)
            self._between.append(self._since)
            self._since, self._longest, self._length = 0, 0.0, 0.0
        self._since += 1
        self._before, self._length = self._length, length
        self._longest = max(self._longest, length)
        self._time = time
        return self._share()

    def _share(self) -> float:
        """Return the share of all steps that is done."""
        return self.steps / (self.steps + self._left()) if self.steps > _SETTLING else 0.0

    def _left(self) -> float:
        """Return how many steps are to come."""
        ahead = [corner for corner in self.corners if self._time < corner < self.until]
        coming = float(len(ahead)) + self._switches()
        stop = min([*ahead, self.until if self.jumps else max(self.first, self._time + self._length)])
        if not coming:
            stop = self.until
        smooth = self._growing(min(stop, self.until) - self._time)
        each = float(np.mean(self._between)) if self._between else max(_USUAL, self._since + smooth)
        if self.reducible and coming > 2.0 * _BEFORE_REDUCED:
            coming = max(_BEFORE_REDUCED - len(self.jumps), 0.0) + 2.0 * math.log2(coming)
        return smooth + each * coming

    def _switches(self) -> float:
        """Return how often thermostats will switch from now on."""
        if not self.together or math.isinf(self.first):
            return 0.0
        begun = max(self._time, self.jumps[0] if self.jumps else self.first)
        cycle = self.cycle
        if len(self.jumps) > 2:
            cycle = 2.0 * (self.jumps[-1] - self.jumps[0]) / (len(self.jumps) - 1)
        return self.together * 2.0 * max(self.until - begun, 0.0) / max(cycle, 1e-9)

    def _growing(self, time: float) -> float:
        """Return the steps to go ``time`` [s] further where they go on growing as they did last."""
        growth = min(self._length / self._before, 5.0) if self._before > 0.0 else 2.0
        if time <= 0.0:
            return 0.0
        if growth < 1.05:
            return time / self._length
        return math.log1p(time * (growth - 1.0) / (self._length * growth)) / math.log(growth)


def _switching(problem: Problem, start: Array) -> tuple[float, float]:
    """Return when thermostats first switch and how long their cycles are [s], for a mold of one temperature.

    The first is infinite where the power does not carry the mold to the set point.
    """
    if not problem.thermostats:
        return math.inf, math.inf
    one = problem.thermostats[0]
    there = np.full(problem.model.size, one.set_point)
    heated = {id(t.heater): t.heater for t in problem.thermostats}
    power = sum(heater.power.at(0.0) for heater in heated.values())
    lost = -_flow(problem, there)
    capacity = problem.model.total_capacity(there)
    if power <= max(lost, 0.0):
        return math.inf, math.inf
    reach = max(one.set_point - float(start[: problem.mesh.solid].mean()), one.band)
    first = capacity * reach / (power - 0.5 * max(lost, 0.0))
    down = capacity * one.band / lost if lost > 0.0 else math.inf
    return first, capacity * one.band / (power - max(lost, 0.0)) + down


def _flow(problem: Problem, temperature: Array) -> float:
    """Return the heat that flows in through everything but heaters [W]."""
    return sum(
        problem.model.total(condition.flow(0.0, temperature))
        for condition in problem.model.conditions
        if not isinstance(condition, Heater)
    )
