"""Is it the log that is wrong? Probes of a mold that were plugged in crosswise, its clock, one probe alone at fault."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.belief import allowed
from hyperfab.loop.confounding import is_strained
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.judge import common_bic, structured
from hyperfab.loop.problem import Constant, Curve, Form, split
from hyperfab.loop.thresholds import SHARE, SMALL

#: Steps of a fit to a log put right: it either leaves noise soon or is not right.
_STEPS = 12
#: A log begins with the run where it does within this share of it; it begins elsewhere where it is off by so many
#: standard deviations of what is known of the start.
_SOON, _FAR = 0.01, 9.0
#: How far a log's clock may be off, as a share of the run (where it begins) and of itself (how fast it goes), and one
#: standard deviation of that.
_OFF, _OFF_SD = 0.3, 0.1
#: Ways a probe alone may be off, where that is more and where it is less than it ought to be.
_WAYS = (
    ("reads {:.3g} K too much throughout", "reads {:.3g} K too little throughout"),
    ("follows {:.3g} s late", "is {:.3g} s early"),
    (
        "reads {:.2g} of what it is above the air too much",
        "reads {:.2g} of what it is above the air too little",
    ),
)


def looked_through(problem: HeatProblem, found: Finding) -> tuple[Finding, list[str]]:
    """Return the finding, and what is told of the log itself where the model without effects does not explain it.

    Where two probes exchanged leave noise, with nothing added and the constants where they may be, nothing is named: an
    effect would only stand in for them. Nor where nothing explains the log but a clock put right.
    """
    if found.verdict == "noise":
        return found, []
    was = _rms(problem.measured - found.before.fit.predicted)
    bare = replace(found, verdict="unexplained", after=found.before, added={}, indistinguishable=[], measurements=[])
    crossed = _crossed(problem, found)
    if crossed is not None:
        one, other, better = crossed
        return bare, [
            f"{one} and {other} look exchanged: with the columns of the two the other way round the model misses by "
            f"{_rms(better):.3g} K with nothing added, {was:.3g} K as they are; "
            "check which probe is where, and exchange them"
        ]
    if found.verdict != "unexplained":
        return found, []
    clock = _clock(problem, found)
    if clock is not None:
        return bare, [
            f"{clock[0]}: with its times put right the model misses by {_rms(clock[1]):.3g} K with nothing added, "
            f"{was:.3g} K as they are; check its clock, and when it was started"
        ]
    return found, [*_begun(problem), *_alone(problem, found)]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(kw_only=True)
class _Timed(HeatProblem):
    """A mold with a log that keeps a time of its own: the last of its constants are by how much."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        off = {constant.name: float(value) for constant, value in zip(self.own, own, strict=True)}
        runs = []
        for run in self.runs:
            times = run.times / (1.0 + off.get("log.fast", 0.0)) + off.get("log.late_s", 0.0)
            # Before the run begins the mold is at rest.
            runs.append(replace(run, times=np.maximum(times, min(0.0, float(run.times[0])))))
        return replace(self, runs=runs)._run(own[None, :], [terms])[0]

    def predict_many(self, own: Array, forms: Mapping[str, Form], values: Array) -> Array:
        return np.array([self.predict(one, split(rest, forms)) for one, rest in zip(own, values, strict=True)])


def _clock(problem: HeatProblem, found: Finding) -> tuple[str, Array] | None:
    """Return how the log's clock is off that, put right, leaves noise, and what is left [K] then.

    Under one steady power a clock that is too fast is a mold that is lighter: the constants take it.
    """
    if structured(found.before.fit, problem, found.noise) <= SMALL:
        return None
    whole = float(np.ptp(problem.runs[0].times))
    late = Constant("log.late_s", 0.0, -_OFF * whole, _OFF * whole, 0.01 * whole, _OFF_SD * whole)
    fast = Constant("log.fast", 0.0, -_OFF, _OFF, 0.01, _OFF_SD)
    for moved in ((late,), (fast,), (late, fast)):
        timed = _Timed.of(problem, moved)
        again = fit(timed, found.noise, {}, timed.given, data=problem.measured, iterations=_STEPS)
        if is_strained(timed, again) or structured(again, timed, found.noise) > SMALL:
            continue
        off = dict(zip((one.name for one in moved), again.x[len(problem.own) :].tolist(), strict=True))
        told = []
        if "log.late_s" in off:
            seconds = off["log.late_s"]
            told.append(f"began {abs(seconds):.3g} s {'after' if seconds > 0.0 else 'before'} the run")
        if "log.fast" in off:
            share = off["log.fast"]
            told.append(f"runs {100.0 * abs(share):.3g} % too {'fast' if share > 0.0 else 'slowly'}")
        return f"the log's clock looks wrong: it {' and '.join(told)}", problem.measured - again.predicted
    return None


def _begun(problem: HeatProblem) -> Iterator[str]:
    """Yield by how much the log begins warmer or colder than the document, where that is more than it may be."""
    clock, known = problem.runs[0].clock[0], problem.own[problem.kinds.index("start")]
    first = np.array([curve.start for curve in problem.curves if curve.abscissa[0] <= _SOON * clock[-1]], dtype=int)
    off = (problem.measured - problem.delivered)[first]
    if len(off) and np.min(np.abs(off)) > _FAR * known.prior_sd and np.ptp(np.sign(off)) == 0.0:
        which = "warmer" if off[0] > 0.0 else "colder"
        yield (
            f"the log begins {abs(float(np.mean(off))):.3g} K {which} than the document says; "
            "give run.start what the probes read then"
        )


def _crossed(problem: HeatProblem, found: Finding) -> tuple[str, str, Array] | None:
    """Return the two probes that, exchanged, leave noise, and what is left [K] then."""
    start, best = found.before.fit, None
    for one, other in combinations(problem.curves, 2):
        if not np.array_equal(one.abscissa, other.abscissa):
            continue
        data = problem.measured.copy()
        data[one.rows], data[other.rows] = problem.measured[other.rows], problem.measured[one.rows]
        again = fit(problem, found.noise, {}, problem.given, data=data, iterations=_STEPS)
        if again.cost < (start if best is None else best[0]).cost:
            best = (again, one.name, other.name, data - again.predicted)
    if best is None or is_strained(problem, best[0]) or structured(best[0], problem, found.noise) > SMALL:
        return None
    bic = common_bic([best[0], found.after.fit], problem, found.noise) if found.after.ids else {}
    if bic and found.verdict != "unexplained" and bic[found.after.ids] < bic[()]:
        return None
    return best[1:]


def _alone(problem: HeatProblem, found: Finding) -> Iterator[str]:
    """Yield of a probe without which the model explains all others how it is off, and by how much.

    It explains them where it leaves as little as a named effect may.
    """
    if len(problem.curves) < 3:
        return
    tried, most = [], allowed(found.before.judgement.structured)
    for curve in problem.curves:
        silent = found.noise.plain.sd.copy()
        silent[curve.rows] = np.inf
        again = fit(problem, replace(found.noise.plain, sd=silent), {}, problem.given, iterations=_STEPS)
        free = len(again.residual) - (curve.stop - curve.start) - len(again.x)
        beyond = again.chi2 / max(free, 1) - 1.0
        if beyond <= most**2 and not is_strained(problem, again):
            tried.append((again.cost, curve, again))
    if tried:
        _, curve, again = min(tried, key=lambda one: one[0])
        yield _of_one(problem, curve, again)


def _of_one(problem: HeatProblem, curve: Curve, fitted: Fit) -> str:
    """Return what is told of the probe that the others foretell otherwise."""
    shown = fitted.predicted[curve.rows]
    off = problem.measured[curve.rows] - shown
    rms = float(np.sqrt(np.mean(off**2)))
    shapes = [np.ones(len(off)), -np.gradient(shown, curve.abscissa)]
    if "above ambient_K" in problem.states:
        shapes.append(problem.states["above ambient_K"][curve.rows])
    sizes = [float(shape @ off) / max(float(shape @ shape), 1e-300) for shape in shapes]
    left = [float(np.sum((off - size * shape) ** 2)) for size, shape in zip(sizes, shapes, strict=True)]
    way = int(np.argmin(left))
    told = f"{curve.name} alone is at odds with the model, which explains all the others and misses it by {rms:.3g} K"
    if left[way] < 2.0 * SHARE * float(off @ off):
        told += f"; it {_WAYS[way][sizes[way] < 0.0].format(abs(sizes[way]))}"
    return f"{told}; check this probe, its place and its channel"
