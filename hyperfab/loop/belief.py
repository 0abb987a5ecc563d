"""How sure the names are: the probability of each entry, and of something else, from what each model leaves.

A model with the right names still misses the truth by a smooth discrepancy, whose scale is not known: about half of
what is too small to matter, however much there was to explain, for a law is made richer until it leaves no more. That
nothing lacks is such a model too. Given an inverse-gamma distribution of that scale the marginal likelihood of what is
left is Student's. Kennedy & O'Hagan (2001), doi:10.1111/1467-9868.00294.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import fdtrc

from hyperfab.arrays import Array
from hyperfab.loop.judge import Candidate, structured_of_each
from hyperfab.loop.replicates import pulls
from hyperfab.loop.thresholds import FEWEST, MARGIN, MOST, SHARE, SMALL


@dataclass(frozen=True)
class Belief:
    """Probabilities: of each choice of names, that nothing lacks, that something else does."""

    models: Mapping[frozenset[str], float]
    nothing: float
    something_else: float

    @cached_property
    def of(self) -> dict[str, float]:
        """How sure it is of each entry that it is part of what lacks."""
        names = sorted({name for ids in self.models for name in ids})
        return {name: sum(p for ids, p in self.models.items() if name in ids) for name in names}

    def against(self, odds: Mapping[str, float]) -> Belief:
        """Return what is believed where something else may stand in the place of names, each with its ``odds``.

        >>> doubted = Belief({frozenset({"rate"}): 0.9}, 0.0, 0.1).against({"rate": 0.25})
        >>> round(doubted.of["rate"], 6), round(doubted.something_else, 6)
        (0.18, 0.82)
        """
        found = dict.fromkeys(self.models, 0.0)
        for ids, p in self.models.items():
            kept = p * float(np.prod([odds[name] / (1.0 + odds[name]) for name in ids.intersection(odds)]))
            found[ids] += kept
            rest = ids.difference(odds)
            found[rest] = found.get(rest, 0.0) + p - kept
        something_else = self.something_else + found.pop(frozenset(), 0.0)
        return replace(self, models=found, something_else=something_else)


def allowed(before: float) -> float:
    """Return how much structure a right name may leave of ``before``, both in standard deviations of the noise.

    >>> allowed(100.0), round(allowed(2.5), 3), allowed(1.0)
    (0.675, 0.559, 0.45)
    """
    return float(np.clip(np.sqrt(SHARE) * before, SMALL, 1.5 * SMALL))


def explains(base: Candidate, state: Candidate) -> bool:
    """Whether what a model leaves is noise, or so little beside what was there that its terms are what was lacking."""
    left = state.judgement
    return left.is_small or left.beside_machine <= allowed(base.judgement.beside_machine)


def outweighs_something_else(base: Candidate, state: Candidate) -> bool:
    """Whether a model leaves less of the first kind of reading than something else would in place of its names.

    Both in standard deviations of the noise: see ``belief``. What lacks in another kind says nothing against them.
    """
    left, before = (structured_of_each(one.fit, one.problem, one.noise)[0] for one in (state, base))
    return bool(left <= (1.0 - MOST) * before)


def surprise(state: Candidate, least: Array | float = 0.0) -> float:
    """Return minus the logarithm of what the data and what is known beforehand say for a model with some names.

    What is left counts by Student's distribution, each kind of reading (stresses, contraction) apart, whatever number
    of constants the law has, but for the ``least`` that passes for noise; each name after the first counts for odds of
    fifty to one, and so does each law of free shape but those that are never quite the fabric's (``inexact``); what
    each specimen has of its own costs by ``coincidence``.
    """
    forms = state.fit.forms
    free = sum(form.free for name, form in forms.items() if name not in state.problem.inexact)
    agreed = sum(coincidence(state, name) for name, form in forms.items() if form.of_each)
    return _student(_left(state, least)) + 0.5 * MARGIN * (len(state.ids) - 1 + free) + agreed


def coincidence(state: Candidate, name: str) -> float:
    """Return minus the logarithm of the odds that what each specimen has of a term agrees by chance among those led
    alike, ``MARGIN`` at most.

    How a specimen was mounted or read has to do with its size, not with how it is then led: constants that follow the
    temperature or the direction stand for something that rides on these. By the F-test of the variance between set-ups
    of specimens of one size and within; odds from a p-value: Sellke, Bayarri & Berger (2001),
    doi:10.1198/000313001300339950.
    """
    form = state.fit.forms[name]
    curves = pulls(state.problem.curves)
    each = state.fit.x[state.fit.place(name)][: len(form.each)].copy()
    each[1:] += each[0]
    if len(each) != len(curves):
        return 0.0
    of_setup, setup = _means(each, [curve.setup for curve in curves])
    of_size, size = _means(each, [curve.size for curve in curves])
    between, within = setup - size, len(each) - setup
    apart, spread = float(np.sum((of_setup - of_size) ** 2)), float(np.sum((each - of_setup) ** 2))
    if between == 0 or within == 0:
        return 0.0
    p = max(float(fdtrc(between, within, apart * within / max(spread * between, 1e-300))), 1e-300)
    odds = -p * np.log(p) * np.exp(1.0)
    return float(min(-np.log(odds), MARGIN)) if p < np.exp(-1.0) else 0.0


def _means(values: Array, names: Sequence[str]) -> tuple[Array, int]:
    """Return of each value the mean of all that have its name, and how many names there are."""
    _, of = np.unique(names, return_inverse=True)
    means = np.bincount(of, values) / np.bincount(of)
    return means[of], len(means)


def belief(base: Candidate, models: Iterable[Candidate], entries: int, *, is_noise: bool = False) -> Belief:
    """Return how sure each entry is, given all ``models`` that were fitted.

    Beforehand nothing is as likely as any of the ``entries`` or something else, and these are alike. How large the
    noise is nobody knows so well: as much as the likeliest model leaves counts as none in all of them if it passes for
    noise; where the verdict ``is_noise``, as the model without names does.
    """
    named = [model for model in models if model.ids and np.isfinite(model.fit.chi2)]
    likeliest = base if is_noise else min(named, key=surprise, default=base)
    least = _left(likeliest) if is_noise or likeliest.judgement.is_noise else 0.0
    before = _left(base, least)
    surprises: dict[frozenset[str], float] = {}
    for model in named:
        ids = frozenset(model.ids)
        surprises[ids] = min(surprise(model, least), surprises.get(ids, np.inf))
    weights = {ids: float(np.exp(-one)) for ids, one in surprises.items()}
    nothing = (entries + 1.0) * float(np.exp(-_student(before)))
    other = float(np.exp(-_student((1.0 - MOST) * before)))
    total = sum(weights.values()) + nothing + other
    return Belief({ids: one / total for ids, one in weights.items()}, nothing / total, other / total)


def _left(state: Candidate, least: Array | float = 0.0) -> Array:
    """Return what a model leaves of each kind of reading, in standard deviations of the noise, beyond ``least``."""
    left = structured_of_each(state.fit, state.problem, state.noise)
    return np.sqrt(np.maximum(left**2 - np.square(least), 0.0))


def _student(left: Array) -> float:
    return float(np.sum(0.5 * FEWEST * np.log1p((left / (0.5 * SMALL)) ** 2)))
