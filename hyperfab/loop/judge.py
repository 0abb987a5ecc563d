"""Is what is left noise? Lack of fit, autocorrelation along each curve, and the greatest score, in one judgement; a
model with some terms, fitted and judged, and the evidence for a term.

Models are compared on one scale: chi-squared with the present misfit as noise, priors that count, and BIC of both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import chdtrc, chdtri, fdtrc

from hyperfab.arrays import Array, Ints
from hyperfab.loop.fitting import Fit
from hyperfab.loop.heldout import Forecast, HeldOut, Help, forecast, leave_curves_out
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve, Problem
from hyperfab.loop.score import Signature, greatest_by_chance, signatures
from hyperfab.loop.thresholds import ALPHA, FEWEST, MARGIN, MOST, SHARE, SMALL

#: Of how large the noise may be.
_QUANTILES = 400


@dataclass(frozen=True)
class Judgement:
    """What is left after a fit, against the noise.

    ``structured`` is the rms of what is not noise, in standard deviations of the noise, of the kind of reading that is
    missed most; ``beside_machine`` the same where the noise is at least what the machine may be off, in the same way in
    all tests.
    """

    chi2_reduced: float
    structured: float
    beside_machine: float
    p_lack_of_fit: float
    p_autocorrelation: float
    p_greatest_score: float

    @property
    def is_noise(self) -> bool:
        """Whether all three tests take the residual for noise."""
        return min(self.p_lack_of_fit, self.p_autocorrelation, self.p_greatest_score) > ALPHA / 3.0

    @property
    def is_small(self) -> bool:
        """Whether what is left is noise, or so far below it that no term could matter."""
        return self.is_noise or self.beside_machine <= SMALL


def judge(problem: Problem, noise: Noise, fit: Fit, found: list[Signature]) -> Judgement:
    """Judge the residual of a fit; ``found`` are the signatures of the entries not in the model."""
    free, off = _degrees(fit), _off_in_stiffness(fit, noise)
    ratio = fit.chi2 / free
    return Judgement(
        chi2_reduced=ratio,
        structured=structured(fit, problem, noise),
        beside_machine=structured(fit, problem, noise, noise.least),
        p_lack_of_fit=min(
            _by_chance(ratio, free, noise),
            _worst_by_chance(fit, noise, problem.curves),
            float(chdtrc(len(off), off @ off)) if len(off) else 1.0,  # 1 where no two specimens scatter
        ),
        p_autocorrelation=autocorrelation(fit.residual, problem.curves),
        p_greatest_score=greatest_by_chance(found, noise),
    )


def structured(fit: Fit, problem: Problem, noise: Noise, least: float = 0.0) -> float:
    """Return the rms of what is not noise, in its standard deviations, of the kind of reading that is missed most.

    The noise counts as this share, ``least``, of the largest reading of each curve at least.
    """
    weight = _weight(fit, problem, noise, least)
    each = [*_beyond_of_each(fit, problem, weight), *_beyond_of_stiffness(fit, noise)]
    return float(np.sqrt(max(_beyond(fit, weight), *each, 0.0)))


def structured_of_each(fit: Fit, problem: Problem, noise: Noise) -> Array:
    """Return the same of each kind of reading, beside the machine: of a fabric its stresses, its contraction, how stiff
    specimens are."""
    weight = _weight(fit, problem, noise, noise.least)
    each = _beyond_of_each(fit, problem, weight)
    if len(each) == 1:
        each = [_beyond(fit, weight)]
    return np.sqrt(np.maximum([*each, *_beyond_of_stiffness(fit, noise)], 0.0))


def _weight(fit: Fit, problem: Problem, noise: Noise, least: float) -> Array:
    """Return what the square of each row's residual counts where noise is ``least`` of a curve's peak at least."""
    weight = np.ones(len(fit.residual))
    for curve in problem.curves if least else ():
        read, sd = problem.measured[curve.rows] - (curve.channel != 0), noise.sd[curve.rows]
        weight[curve.rows] = (sd / np.maximum(sd, least * np.max(np.abs(read)))) ** 2
    return weight


def _beyond(fit: Fit, weight: Array) -> float:
    """Return what all readings are missed by beyond noise, as mean square of rows with a ``weight``."""
    return float(np.sum(weight * fit.residual**2)) / _degrees(fit) - float(np.mean(weight))


def _beyond_of_stiffness(fit: Fit, noise: Noise) -> list[float]:
    """Return by how much more specimens are off in stiffness than they scatter, as mean square, less what chance does.

    That is one value of each way of testing, which their many readings would hide.
    """
    off = _off_in_stiffness(fit, noise)
    beyond = float(off @ off) - len(off) - 2.0 * float(np.sqrt(2.0 * len(off)))
    return [beyond / len(noise.groups)] if len(off) else []


def _off_in_stiffness(fit: Fit, noise: Noise) -> Array:
    """Return how far those tested alike are off in stiffness, in standard deviations; none where no two scatter."""
    return noise.at(fit.predicted).stiffness(fit.residual, SMALL) if noise.gain_sd else np.empty(0)


def _beyond_of_each(fit: Fit, problem: Problem, weight: Array) -> list[float]:
    """Return what each kind of reading is missed by beyond noise, as mean square of rows with a ``weight``, less what
    chance does to so few.

    Many readings of one kind that are met must not hide another that is missed.
    """
    read = np.ones(len(fit.residual), dtype=bool)
    for curve in problem.curves:
        read[curve.rows] = not curve.beforehand
    channel = problem.channel[read]
    share = len(fit.residual) / _degrees(fit)
    found = []
    for which in np.unique(channel):
        left, own = fit.residual[read][channel == which], weight[read][channel == which]
        noise = float(np.mean(own)) * (1.0 + 2.0 * float(np.sqrt(2.0 / len(left))))
        found.append(float(np.mean(own * left**2)) * share - noise)
    return found


def _by_chance(ratio: float, free: float, noise: Noise) -> float:
    """Return the probability of a mean square as great as ``ratio``; the noise is known with degrees of freedom."""
    if not np.isfinite(noise.dof):
        return float(chdtrc(free, ratio * free))
    if noise.raised == 1.0:
        return float(fdtrc(free, noise.dof, ratio))
    drawn = chdtri(noise.dof, (np.arange(_QUANTILES) + 0.5) / _QUANTILES)
    return float(np.mean(chdtrc(free, ratio * free / noise.louder(drawn))))


def _worst_by_chance(fit: Fit, noise: Noise, curves: Sequence[Curve]) -> float:
    """Return the probability of the test that misses most, all of them counted: what one lacks many may hide."""
    each = [
        _by_chance(float(np.mean(fit.residual[curve.rows] ** 2)), float(curve.stop - curve.start), noise)
        for curve in curves
        if not curve.beforehand and curve.stop - curve.start >= FEWEST
    ]
    return min(1.0, len(each) * min(each)) if each else 1.0


def _degrees(fit: Fit) -> float:
    """Return how many rows are free; a film's that read nothing, where the model has nothing whatever its constants
    are, tell nothing of noise."""
    told = (fit.residual != 0.0) | np.any(fit.jacobian != 0.0, axis=1)
    return float(max(int(np.count_nonzero(told)) - len(fit.x), 1))


def autocorrelation(residual: Array, curves: Sequence[Curve]) -> float:
    """Return the probability of the Ljung-Box statistic, summed over the curves, under white noise.

    Ljung & Box (1978), Biometrika 65, 297.
    """
    total, lags = 0.0, 0
    for curve in curves:
        part = residual[curve.rows]
        n = len(part)
        if n < 12:
            continue
        part = part - np.mean(part)
        power = float(part @ part)
        if power <= 0.0:
            continue
        for lag in range(1, min(6, n // 4) + 1):
            rho = float(part[lag:] @ part[:-lag]) / power
            total += n * (n + 2) * rho**2 / (n - lag)
            lags += 1
    return float(chdtrc(lags, total)) if lags else 1.0


def correlation_time(residual: Array, curves: Sequence[Curve]) -> float:
    """Return how many rows count as one: 1 + 2 sum of the autocorrelations up to the first small one."""
    power = float(residual @ residual)
    if power <= 0.0:
        return 1.0
    total = 1.0
    farthest = max(max(curve.stop - curve.start for curve in curves) // 2, 1)
    # With so many nothings between them no curve meets another.
    gap = np.zeros(farthest)
    apart = np.concatenate([part for c in curves for part in (residual[c.rows], gap)])
    for lag in range(1, farthest):
        rho = float(apart[lag:] @ apart[:-lag]) / power
        if rho < 0.05:
            break
        total += 2.0 * rho
    return total


def common_bic(fits: Sequence[Fit], problem: Problem, noise: Noise) -> Mapping[tuple[str, ...], float]:
    """Return BIC of several models, by their effects, on one scale: that of the best fit among them."""
    level = Level.of(fits, problem, noise)
    return {tuple(one.forms): level.misfit(one) + level.price(one) for one in fits}


@dataclass(frozen=True)
class Level:
    """What counts as noise where fits are compared: what the ``best`` of them leaves, ``time`` rows of it as one, in
    ``stiffness`` (chi-squared) the least that one of them does, which need not be the one that meets most readings."""

    problem: Problem
    noise: Noise
    best: Fit
    time: float
    stiffness: float

    @classmethod
    def of(cls, fits: Sequence[Fit], problem: Problem, noise: Noise) -> Level:
        """Return the level of several fits in a noise."""
        least = min(_of_stiffness(one, noise) for one in fits) if noise.gain_sd else 0.0
        best = min(fits, key=lambda one: one.chi2)
        return cls(problem, noise, best, correlation_time(best.residual, problem.curves), least)

    def misfit(self, fitted: Fit) -> float:
        """Return minus twice the logarithm of likelihood, as chi-squared, where ``time`` readings count as one.

        But for how far specimens are off in stiffness: each tells that by itself.
        """
        best, channel = self.best, self.problem.channel
        alike = scaled_chi2(fitted, best, channel) + prior_misfit(fitted, best, self.problem)
        if not self.noise.gain_sd:
            return alike / self.time
        off = _of_stiffness(fitted, self.noise)
        alike -= off / max(float(np.mean(best.residual[channel == 0] ** 2)), 1.0)
        return alike / self.time + off / max(self.stiffness / len(self.noise.groups), 1.0)

    def price(self, fitted: Fit) -> float:
        """Return what the constants cost in BIC: the logarithm of the readings each is known from.

        That are all that tell by themselves, or of a constant of each specimen its own.
        """
        count = max(len(self.best.residual) / self.time, 3.0)
        own = [len(form.each) for form in fitted.forms.values() if form.of_each]
        return float(len(fitted.x) * np.log(count) - sum(many * np.log(min(many, count)) for many in own))


def _of_stiffness(fitted: Fit, noise: Noise) -> float:
    """Return the part of chi-squared that is as another stiffness of specimens would be."""
    off = noise.at(fitted.predicted).along_stiffness(fitted.residual)
    return float(off @ off)


def prior_misfit(fitted: Fit, best: Fit, problem: Problem) -> float:
    """Return how far the constants are from what is known of them, as chi-squared, where that is to count.

    As with the readings, what ``best`` leaves counts as noise.
    """
    if not problem.well_known:
        return 0.0
    return max(fitted.cost - fitted.chi2, 0.0) / max(best.chi2 / len(best.residual), 1.0)


def scaled_chi2(fitted: Fit, best: Fit, channel: Ints) -> float:
    """Return chi-squared with each channel's noise taken as no less than what ``best`` leaves there."""
    total = 0.0
    for which in np.unique(channel):
        rows = channel == which
        left = float(np.mean(best.residual[rows] ** 2))
        total += float(np.sum(fitted.residual[rows] ** 2)) / max(left, 1.0)
    return total


@dataclass
class Candidate:
    """A model with some terms, fitted; judged when asked."""

    problem: Problem
    noise: Noise
    fit: Fit
    #: The noise it was fitted under, where that is another.
    under: Noise | None = None
    #: The model that says the same of all stresses, of tests left out too.
    says: Candidate | None = None

    @cached_property
    def found(self) -> list[Signature]:
        """What the entries that are not in the model would do to its prediction."""
        others = [
            effect for effect in self.problem.effects if effect.id not in self.fit.forms and not effect.not_sought
        ]
        return signatures(self.problem, self.noise, self.fit, others)

    @cached_property
    def judgement(self) -> Judgement:
        """Whether what is left is noise."""
        return judge(self.problem, self.noise, self.fit, self.found)

    @cached_property
    def held_out(self) -> HeldOut:
        """Each test predicted from the others."""
        return leave_curves_out(self.fit, self.problem.curves)

    @cached_property
    def forecast(self) -> Forecast:
        """Each test predicted by a fit to the others."""
        found = forecast(self.problem, self.under or self.noise, self.fit)
        if self.says is None:
            return found
        first = self.problem.channel == 0
        return replace(found, predicted=np.where(first, self.says.forecast.predicted, found.predicted))

    @property
    def excess(self) -> float:
        """Mean square of what is left, in squared standard deviations of the noise."""
        return self.fit.chi2 / max(len(self.fit.residual) - len(self.fit.x), 1)

    @property
    def ids(self) -> tuple[str, ...]:
        """The effects in it, in the order they were added."""
        return tuple(self.fit.forms)


@dataclass(frozen=True)
class Evidence:
    """Why a term was added, or not.

    ``restores``: it leaves noise, and brings the constants back to what is known of them beforehand by more than the
    margin. Readings that are predicted as well without it then say nothing against it.
    """

    delta_bic: float
    variance_share: float
    help: Help | None
    certain: bool
    restores: bool = False

    def accepted(self) -> bool:
        """Whether the term pays, and helps most of the tests that can tell, or takes most of what they miss by."""
        if self.help is None or self.restores:
            return self.pays()
        return self.pays() and max(self.help.helped, self.help.taken) >= MOST

    def foretells(self) -> bool:
        """Whether the term takes its share of what lacks, on most of the tests left out too, if by little in BIC."""
        helps = self.help is not None and self.help.helped >= MOST and self.help.taken >= SHARE
        return helps and self.certain and self.delta_bic > 0.0 and self.variance_share >= SHARE

    def pays(self) -> bool:
        """Whether the term is worth its constants: in likelihood, in size, and on tests left out."""
        pays = self.delta_bic >= MARGIN and self.variance_share >= SHARE and self.certain
        return pays and (self.help is None or self.restores or self.help.taken >= SHARE)
