"""How sure the names are: the probability of each entry, and of something else, from what each model leaves.

A right name has a law that is nearly right: what it leaves of the misfit has a standard deviation of its own, half of
what the loop lets pass as explained. Something else leaves anything up to all. Beforehand nothing is as likely as not,
every entry and something else are alike, and so is each further name beside the first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.loop.candidate import Candidate
from hyperfab.loop.judge import structured
from hyperfab.loop.thresholds import ENOUGH, EXPLAINED, SMALL


@dataclass(frozen=True)
class Belief:
    """Probabilities: that each entry is part of it, that nothing lacks, that something else does."""

    of: Mapping[str, float]
    nothing: float
    something_else: float


def allowed(before: float) -> float:
    """Return how much structure a right name may leave of ``before``, both in standard deviations of the noise.

    >>> allowed(100.0), round(allowed(1.0), 3)
    (0.66, 0.224)
    """
    return float(min(ENOUGH, np.sqrt(1.0 - EXPLAINED) * before))


def explains(base: Candidate, state: Candidate) -> bool:
    """Whether what a model leaves is noise, or so little beside what was there that its terms are what was lacking."""
    left = state.judgement
    return left.is_small or left.structured <= allowed(base.judgement.structured)


def belief(base: Candidate, models: Iterable[Candidate], entries: int) -> Belief:
    """Return how sure each entry is, given all ``models`` that were fitted; ``entries`` is how many could be it."""
    before = structured(base.fit, base.problem)
    least: dict[frozenset[str], float] = {}
    for model in models:
        if model.ids and np.isfinite(model.fit.chi2):
            left = structured(model.fit, model.problem)
            least[frozenset(model.ids)] = min(left, least.get(frozenset(model.ids), np.inf))
    each = 1.0 / (entries + 2.0)
    # One standard deviation is half of what passes: as `explains` has it, two are the most.
    sd = max(0.5 * max(allowed(before), SMALL), 1e-9)
    weights = {ids: each ** len(ids) * _half_normal(left, sd) for ids, left in least.items()}
    nothing = 0.5 * _half_normal(before, 0.5 * SMALL)
    other = each / max(before, SMALL)
    total = sum(weights.values()) + nothing + other
    names = sorted({name for ids in weights for name in ids})
    of = {name: sum(weight for ids, weight in weights.items() if name in ids) / total for name in names}
    return Belief(of, nothing / total, other / total)


def _half_normal(left: float, sd: float) -> float:
    return float(np.sqrt(2.0 / np.pi) / sd * np.exp(-0.5 * (left / sd) ** 2))
