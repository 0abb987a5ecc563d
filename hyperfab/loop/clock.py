"""Does a mold's log keep the time of the run: where its clock began, how fast it goes, and what passes for a lag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.confounding import is_strained
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.judge import common_bic, structured
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Form, split
from hyperfab.loop.thresholds import MARGIN, SMALL

#: Steps of a fit to a log put right: it either leaves noise soon or is not right.
STEPS = 12
#: How far a log's clock may be off, as a share of the run (where it begins) and of itself (how fast it goes), and one
#: standard deviation of that.
_OFF, _OFF_SD = 0.3, 0.1
_LATE, _FAST = "log.late_s", "log.fast"


@dataclass(kw_only=True)
class Timed(HeatProblem):
    """A mold with a log that keeps a time of its own: the last of its constants are by how much."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        return self._kept(own)._run(own[None, :], [terms])[0]

    def predict_many(self, own: Array, forms: Mapping[str, Form], values: Array) -> Array:
        return np.array([self.predict(one, split(rest, forms)) for one, rest in zip(own, values, strict=True)])

    def predict_near(self, x: Array, forms: Mapping[str, Form], moved: Array) -> Array:
        own = len(self.own)
        clocks = [one.name in (_LATE, _FAST) for one in self.own]
        same = np.all(moved[:, :own][:, clocks] == x[:own][clocks], axis=1)
        found = np.empty((len(moved), len(self.measured)))
        found[same] = HeatProblem.predict_near(self._kept(x[:own]), x, forms, moved[same])
        found[~same] = self.predict_many(moved[~same, :own], forms, moved[~same, own:])
        return found

    def _kept(self, own: Array) -> Timed:
        """Return the problem with its readings at the times of the run."""
        off = {constant.name: float(value) for constant, value in zip(self.own, own, strict=True)}
        runs = []
        for run in self.runs:
            times = run.times / (1.0 + off.get(_FAST, 0.0)) + off.get(_LATE, 0.0)
            # Before the run begins the mold is at rest.
            runs.append(replace(run, times=np.maximum(times, min(0.0, float(run.times[0])))))
        return replace(self, runs=runs)


@dataclass(frozen=True)
class Clock:
    """A clock that, put right, explains a log: how it is off, in words, and the model that is fitted then."""

    told: str
    fit: Fit


def wrong_clock(problem: HeatProblem, noise: Noise) -> Clock | None:
    """Return how the log's clock is off that, put right, leaves noise with nothing added.

    Under one steady power a clock that is too fast is a mold that is lighter: the constants take it.
    """
    late, fast = _constants(problem)
    for moved in ((late,), (fast,), (late, fast)):
        timed = Timed.of(problem, moved)
        again = fit(timed, noise, {}, timed.given, data=problem.measured, iterations=STEPS)
        if is_strained(timed, again) or structured(again, timed, noise) > SMALL:
            continue
        off = dict(zip((one.name for one in moved), again.x[len(problem.own) :].tolist(), strict=True))
        told = []
        if _LATE in off:
            told.append(_began(off[_LATE]))
        if _FAST in off:
            share = off[_FAST]
            told.append(f"runs {100.0 * abs(share):.3g} % too {'fast' if share > 0.0 else 'slowly'}")
        return Clock(f"it {' and '.join(told)}", again)
    return None


def instead_of_lag(problem: HeatProblem, noise: Noise, found: Fit) -> Clock | None:
    """Return the clock that explains the log as well as the ``sensor-lag`` of a fit does, the other terms kept.

    A log that was begun before the run shows all of it late by one time, and a sensor by a time of its own: where
    nothing was read while the power had just changed these are one.
    """
    forms = {name: form for name, form in found.forms.items() if name != "sensor-lag"}
    timed = Timed.of(problem, _constants(problem)[:1])
    others: Sequence[Array] = [found.x[found.place(name)] for name in forms]
    start = np.concatenate([found.x[: found.own], [0.0], *others])
    again = fit(timed, noise, forms, start, data=problem.measured, iterations=STEPS)
    if is_strained(timed, again) and not is_strained(problem, found):
        return None
    bic = common_bic([again, found], problem, noise)
    if bic[tuple(forms)] > bic[tuple(found.forms)] + MARGIN:
        return None
    return Clock(f"a log that {_began(float(again.x[len(problem.own)]))}", again)


def _constants(problem: HeatProblem) -> tuple[Constant, Constant]:
    whole = float(np.ptp(problem.runs[0].times))
    late = Constant(_LATE, 0.0, -_OFF * whole, _OFF * whole, 0.01 * whole, _OFF_SD * whole)
    return late, Constant(_FAST, 0.0, -_OFF, _OFF, 0.01, _OFF_SD)


def _began(seconds: float) -> str:
    return f"began {abs(seconds):.3g} s {'after' if seconds > 0.0 else 'before'} the run"
