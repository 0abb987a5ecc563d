"""Is it the log that is wrong? Probes of a mold that were plugged in crosswise, its clock, one probe alone at fault."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.belief import allowed
from hyperfab.loop.catalogue.heat import CLOCK
from hyperfab.loop.confounding import is_strained
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import Descent, Fit, fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.judge import Candidate, common_bic, structured
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Curve, Form, split
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MARGIN, MOST, SHARE, SMALL
from hyperfab.numerics.gram import orthonormal

#: Steps of a fit to a log put right: it either leaves noise soon or is not right.
_STEPS = 12
#: How far a log's clock may be off, as a share of the run (where it begins) and of itself (how fast it goes), and one
#: standard deviation of that.
_OFF, _OFF_SD = 0.3, 0.1
_LATE, _FAST = "log.late_s", "log.fast"
#: Pairs of probes that are tried exchanged.
_PAIRS = 5
#: A log begins with the run where it does within this share of it; it begins elsewhere where it is off by so many
#: standard deviations of what is known of the start.
_SOON, _FAR = 0.01, 9.0
#: Ways a probe alone may be off, where that is more and where it is less than it ought to be.
_WAYS = (
    ("reads {:.3g} K too much throughout", "reads {:.3g} K too little throughout"),
    ("follows {:.3g} s late", "is {:.3g} s early"),
    (
        "reads {:.2g} of what it is above the air too much",
        "reads {:.2g} of what it is above the air too little",
    ),
)


class Log:
    """A mold's log, looked through before the catalogue is, and after it."""

    def __init__(self, problem: HeatProblem) -> None:
        self.problem = problem
        self._right: dict[bytes, tuple[_Crossed | None, Clock | None]] = {}
        self._nearest: dict[bytes, _Crossed | None] = {}

    def explains(self, search: Search, before: Candidate) -> bool:
        """Whether the log put right leaves noise with nothing added, and no single entry does as well.

        What a second name could do beside it need not be sought then.
        """
        crossed, clock = self._put_right(before, search.noise)
        right = crossed.fit if crossed is not None else clock.fit if clock is not None else None
        if right is None:
            return False
        for effect, _ in search.ranking(before):
            named = search.with_term(before, effect, families=0)
            if named is not None:
                bic = common_bic([right, named], self.problem, search.noise)
                if bic[tuple(named.forms)] < bic[()] + MARGIN:
                    return False
        return True

    def looked_through(self, found: Finding) -> tuple[Finding, list[str]]:
        """Return the finding, and what is told of the log itself where the model without effects does not explain it.

        Where two probes exchanged leave noise, with nothing added and the constants where they may be, nothing is
        named: an effect would only stand in for them. Nor where nothing explains the log but a clock put right.
        Sensors that follow late are not sure where a log that was begun before the run explains as much.
        """
        if found.verdict == "noise":
            return found, []
        problem = self.problem
        was = _rms(problem.measured - found.before.fit.predicted)
        bare = replace(
            found, verdict="unexplained", after=found.before, added={}, indistinguishable=[], measurements=[]
        )
        crossed, clock = self._put_right(found.before, found.noise)
        if crossed is not None and self._is_better(crossed.fit, found):
            return bare, [
                f"{crossed.one} and {crossed.other} look exchanged: with the columns of the two the other way round "
                f"the model misses by {_rms(crossed.left):.3g} K with nothing added, {was:.3g} K as they are; "
                "check which probe is where, and exchange them"
            ]
        if clock is not None and (found.put_right or found.verdict == "unexplained"):
            return bare, [
                f"the log's clock looks wrong: {clock.told}: with its times put right the model misses by "
                f"{_rms(problem.measured - clock.fit.predicted):.3g} K with nothing added, {was:.3g} K as they are; "
                "check its clock, and when it was started"
            ]
        if found.verdict == "unexplained":
            return found, [*_begun(problem), *_alone(problem, found), *self._nearer_exchanged(found)]
        if "sensor-lag" not in found.after.ids:
            return found, []
        return _or_late(problem, found)

    def _put_right(self, before: Candidate, noise: Noise) -> tuple[_Crossed | None, Clock | None]:
        """Return the probes exchanged, and the clock put right, that leave noise."""
        key = noise.sd.tobytes()
        if key not in self._right:
            problem = self.problem
            small = structured(before.fit, problem, noise) <= SMALL
            crossed = self._exchanged(before, noise)
            if crossed is not None and not crossed.leaves_noise(problem, noise):
                crossed = None
            clock = None if small or crossed is not None else wrong_clock(problem, noise)
            self._right[key] = crossed, clock
        return self._right[key]

    def _exchanged(self, before: Candidate, noise: Noise) -> _Crossed | None:
        """Return the two probes that, exchanged, leave least."""
        key = noise.sd.tobytes()
        if key not in self._nearest:
            self._nearest[key] = _crossed(self.problem, noise, before.fit)
        return self._nearest[key]

    def _nearer_exchanged(self, found: Finding) -> Iterator[str]:
        """Yield the two probes that, exchanged, take most of what is missed, though something else lacks as well."""
        crossed, fit = self._exchanged(found.before, found.noise), found.after.fit
        if crossed is not None and _rms(crossed.fit.residual) <= (1.0 - MOST) * _rms(fit.residual):
            yield (
                f"{crossed.one} and {crossed.other} may be exchanged, or the heaters beside them: with the columns of "
                f"the two the other way round the model misses by {_rms(crossed.left):.3g} K with nothing added, "
                f"{_rms(self.problem.measured - fit.predicted):.3g} K as they are; check which is where"
            )

    def _is_better(self, right: Fit, found: Finding) -> bool:
        """Whether a log put right is likelier than what was found, or nothing was."""
        if found.verdict == "unexplained" or not found.after.ids:
            return True
        bic = common_bic([right, found.after.fit], self.problem, found.noise)
        return bic[found.after.ids] >= bic[()]


def _or_late(problem: HeatProblem, found: Finding) -> tuple[Finding, list[str]]:
    """Return the finding, with a clock told beside the lag of sensors that it may stand for."""
    late = instead_of_lag(problem, found.noise, found.after.fit)
    if late is None:
        return found, []
    sets = [[*one, *([CLOCK] if "sensor-lag" in one else [])] for one in found.indistinguishable]
    if not any(CLOCK in one for one in sets):
        sets.append(["sensor-lag", CLOCK])
    return replace(found, verdict="ambiguous", indistinguishable=sets), [
        f"{late.told} would do as well as sensor-lag: with its times put right the model misses by "
        f"{_rms(problem.measured - late.fit.predicted):.3g} K, with the lag by "
        f"{_rms(problem.measured - found.after.fit.predicted):.3g} K; check when it was started"
    ]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


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


@dataclass(frozen=True)
class _Crossed:
    """Two probes exchanged: their names, the model fitted then, and what is left [K]."""

    one: str
    other: str
    fit: Fit
    left: Array

    def leaves_noise(self, problem: HeatProblem, noise: Noise) -> bool:
        """Whether noise is left, with the constants where they may be."""
        return not is_strained(problem, self.fit) and structured(self.fit, problem, noise) <= SMALL


def _crossed(problem: HeatProblem, noise: Noise, start: Fit) -> _Crossed | None:
    """Return the two probes that, exchanged, leave least, and less than they do as they are."""
    best: _Crossed | None = None
    for one, other in _likeliest_pairs(problem, noise):
        data = _exchanged(problem, one, other)
        again = fit(problem, noise, {}, problem.given, data=data, iterations=_STEPS)
        if again.cost < (start if best is None else best.fit).cost:
            best = _Crossed(one.name, other.name, again, data - again.predicted)
    return best


def _likeliest_pairs(problem: HeatProblem, noise: Noise) -> list[tuple[Curve, Curve]]:
    """Return the few pairs of probes that, exchanged, leave least to a model that is linear in its constants.

    The model is the same for all pairs, and its constants are near what the document says where one is right.
    """
    pairs = [
        (one, other) for one, other in combinations(problem.curves, 2) if np.array_equal(one.abscissa, other.abscissa)
    ]
    if len(pairs) <= _PAIRS:
        return pairs
    near = Descent(problem, noise, {}, problem.given)
    near.ask()
    held = np.diag(np.sqrt(near.weight))
    slopes = np.vstack([near.jacobian, held])
    left = np.zeros((len(slopes), len(pairs)))
    rows = len(near.left)
    left[:rows] = np.stack([near.metric.whiten(_exchanged(problem, *pair) - near.value) for pair in pairs], axis=1)
    basis = orthonormal(slopes)
    misfit = np.sum((left - basis @ (basis.T @ left)) ** 2, axis=0)
    return [pairs[i] for i in np.argsort(misfit)[:_PAIRS]]


def _exchanged(problem: HeatProblem, one: Curve, other: Curve) -> Array:
    data = problem.measured.copy()
    data[one.rows], data[other.rows] = problem.measured[other.rows], problem.measured[one.rows]
    return data


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
        again = fit(timed, noise, {}, timed.given, data=problem.measured, iterations=_STEPS)
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
    again = fit(timed, noise, forms, start, data=problem.measured, iterations=_STEPS)
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
