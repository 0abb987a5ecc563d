"""Which rivals could pass for a found effect on these very data, whatever BIC says of the noise that happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from hyperfab.arrays import Array
from hyperfab.loop.candidate import Candidate
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.judge import common_bic
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Problem
from hyperfab.loop.score import orthonormal, projected
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MARGIN, SHARE, UNLIKELY


@dataclass(frozen=True)
class Rival:
    """An entry in place of a found effect.

    ``share`` is how much of the effect's own noise-free imprint it reproduces with all constants refitted, ``left``
    the rms it misses then, in standard deviations of the noise; ``delta_bic`` how much worse it does on the data;
    ``state`` the model with it.
    """

    effect: str
    instead_of: str
    share: float
    left: float
    delta_bic: float
    state: Candidate | None

    def passes(self, limit: float, most_left: float) -> bool:
        """Whether the data cannot tell it from the found effect."""
        close = bool(self.delta_bic < MARGIN and self.share > 0.5)
        return (self.share >= limit and self.left <= most_left) or close


def rivals(search: Search, best: Candidate) -> list[Rival]:
    """Return every entry that could stand in place of each effect of ``best``, with how well it would."""
    found = []
    for name in best.ids:
        without = search.without(best, name)
        most = len(best.fit.forms[name].constants)
        imprint = _misfit(search.problem, search.noise, best.fit, without.fit)
        alike = _alike(search, best, without)
        for effect, _ in search.ranking(without):
            if effect.id == name:
                continue
            # Where much is known of the own constants BIC tells whether a law with more constants pays for them by
            # bringing these home, and whatever a little of it looks like.
            free = search.with_term(without, effect) if search.problem.well_known else None
            gap = np.inf if free is None else _gap(search, best, search.state(free))
            if alike[effect.id] < SHARE * alike.get(name, 1.0) and gap >= MARGIN:
                continue
            # Else a rival with more constants than the found law would pass for nearly anything.
            fitted = search.with_term(without, effect, most=most)
            if fitted is not None and best.fit.forms[name].free:
                fitted = search.enriched(search.state(fitted)).fit
            one = None if fitted is None else _rival(search, best, name, effect.id, fitted, imprint)
            if (
                free is not None
                and free is not fitted
                and gap < min(MARGIN, one.delta_bic if one else np.inf)
            ):
                one = _rival(search, best, name, effect.id, free, imprint)
            if one is not None:
                found.append(one)
    return sorted(found, key=lambda rival: -rival.share)


def _rival(search: Search, best: Candidate, name: str, effect: str, fitted: Fit, imprint: float) -> Rival:
    left = _misfit(search.problem, search.noise, best.fit, fitted)
    share = 1.0 - left / imprint if imprint > 0.0 else 0.0
    state = search.state(fitted)
    rest = float(np.sqrt(left / len(best.fit.residual)))
    return Rival(effect, name, share, rest, _gap(search, best, state), state)


def _gap(search: Search, best: Candidate, state: Candidate) -> float:
    """Return how much worse a model does on the data than the best by BIC, infinitely where it leaves much more."""
    bic = common_bic([best.fit, state.fit], search.problem)
    small = np.sqrt(max(state.excess - 1.0, 0.0)) < 0.6 + np.sqrt(max(best.excess - 1.0, 0.0))
    return float(bic[state.ids] - bic[best.ids]) if small else np.inf


def _alike(search: Search, best: Candidate, without: Candidate) -> dict[str, float]:
    """Return how far the imprint of a found effect lies in what each entry can do: the greatest squared cosine.

    What one form does with all its constants together counts: a turn about one axis is little like one about both.
    """
    basis, _ = projected(without.fit)
    noise = search.noise.at(without.fit.predicted)
    imprint = np.zeros(len(basis))
    imprint[: len(noise.sd)] = noise.whiten(best.fit.predicted - without.fit.predicted)
    imprint -= basis @ (basis.T @ imprint)
    power = max(float(imprint @ imprint), 1e-300)
    directions: dict[tuple[str, str], list[Array]] = {}
    for signature in without.found:
        directions.setdefault((signature.effect.id, signature.form.name), []).append(signature.direction)
    found: dict[str, float] = {}
    for (name, _), ways in directions.items():
        cosine = float(np.sum((orthonormal(np.stack(ways, axis=1)).T @ imprint) ** 2)) / power
        found[name] = max(found.get(name, 0.0), cosine)
    return found


def indistinguishable(problem: Problem, found: Sequence[Rival], best: Candidate) -> list[list[str]]:
    """Return, for each found effect, the set of it and the rivals the data cannot tell from it."""
    sets = []
    strained = is_strained(problem, best.fit)
    most = 1.0 - SHARE if strained else 1.0
    for name in best.ids:
        effect = problem.effect(name)
        # Of the sets the plan cannot tell apart, those that are in the model already are no alternatives.
        alike = [
            other for group in problem.look_alikes if name in group for other in sorted(group - {*best.ids})
        ]
        same = [
            rival.effect
            for rival in found
            if rival.instead_of == name
            and rival.passes(min(effect.confounded_share, most), effect.mimic_left)
            and (strained or not _is_impossible(problem, rival))
        ]
        same += [other for other in alike if other not in same and not problem.effect(other).not_sought]
        if same:
            sets.append([name, *same])
    return sets


def _is_impossible(problem: Problem, rival: Rival) -> bool:
    if not problem.well_known or rival.state is None:
        return False
    return is_strained(problem, rival.state.fit)


def is_strained(problem: Problem, found: Fit) -> bool:
    """Whether a fit puts the model's own constants, together, further off than what is known of them allows.

    ``least`` is the probability below which they are.
    """
    away = [
        (value - constant.value) / constant.prior_sd
        for constant, value in zip(problem.own, found.x, strict=False)
        if np.isfinite(constant.prior_sd)
    ]
    return bool(away) and float(chdtrc(len(away), np.sum(np.square(away)))) < UNLIKELY


def _misfit(problem: Problem, noise: Noise, truth: Fit, start: Fit) -> float:
    """Return chi-squared of a model refitted to the noise-free prediction of another."""
    again = fit(problem, noise, dict(start.forms), start.x, data=truth.predicted, iterations=12)
    return again.chi2
