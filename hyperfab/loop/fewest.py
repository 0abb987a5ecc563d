"""The fewest names: where a formula is not quite the fabric's, a smooth law of one effect before a second effect."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import combinations

import numpy as np

from hyperfab.loop.belief import allowed, explains, surprise
from hyperfab.loop.judge import Candidate, Evidence, structured
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import ODDS, TOLD

#: Names beside which the plain law is made richer.
_LIKELY = 2
#: First terms of which a smooth law is tried.
_FIRST = 4


def fewest(
    search: Search,
    before: Candidate,
    best: Candidate,
    tried: dict[str, Evidence],
    no_worse: Callable[[Candidate], bool],
) -> Candidate:
    """Return the likeliest model that leaves noise, of richer forms or free ones; where none does, the nearest.

    A further name may only make up for a formula that is not quite the fabric's, and where no name could be found none
    may have had the right one. The name is what a smooth law of it explains; each further one has to pay. A model that
    misses some readings by more than the one without names may lack the plain law's terms beside its name.
    """
    explained = best is not before and explains(before, best)
    if explained and len(best.ids) == 1 and no_worse(best):
        return best
    whole = best if best is before or explained else search.enriched(best)
    if not search.problem.describes:
        return whole
    plain = search.problem.plain
    first = sorted(tried, key=lambda name: -tried[name].delta_bic)[:_FIRST]
    names = dict.fromkeys([*best.ids, *first, plain])
    alone = {name: state for name in names if (state := search.freed(before, [name])) is not None}
    for name in sorted(alone, key=lambda name: structured(alone[name].fit, search.problem, search.noise))[:_LIKELY]:
        if name != plain and plain in names:
            search.freed(before, [name, plain])
    found = likeliest(search, before, no_worse)
    if found is None or len({*found.ids} - {plain}) > 1:
        named = dict.fromkeys([*best.ids, *(() if found is None else found.ids)])
        twos = [ids for state in sorted(search.states, key=surprise) if len(ids := _beside(plain, state.ids)) == 2]
        pairs = {frozenset(ids): ids for ids in (*combinations(_beside(plain, named), 2), *twos[:_LIKELY])}
        for ids in pairs.values():
            search.freed(before, ids)
        found = likeliest(search, before, no_worse)
        if found is not None and sum(form.free for form in found.fit.forms.values()) > 1:
            # Freed one by one, the first took up what a formula of the other says beside its free law.
            search.polished(found)
            found = likeliest(search, before, no_worse)
    if found is None and 0 < len(whole.ids) < 3:
        # What formulas leave may hide a further name, which shows beside their smooth laws.
        judged = len(search.states)
        base = min([whole, *search.of_names(whole.ids)], key=lambda state: state.excess)
        for effect, _ in search.ranking(base)[:_FIRST]:
            # One for which a too poor law could pass stays a formula.
            search.freed(base, [effect.id], of=whole.ids if effect.smooth else ())
        found = likeliest(search, before, no_worse)
        if found is None and len(whole.ids) == 1:
            # A second name that leaves no noise either is not given: nor may it pass for sure.
            search.forget(judged)
    return found or _nearer(search, whole, best, alone.values(), no_worse) or whole


def _nearer(
    search: Search,
    whole: Candidate,
    best: Candidate,
    alone: Iterable[Candidate],
    no_worse: Callable[[Candidate], bool],
) -> Candidate | None:
    """Return the model of one name that comes clearly nearer where none leaves noise; None if none does.

    It is told by what it rides on, before one that a formula met. What richer forms cost there says nothing against the
    names whose formulas came as near. What each specimen has of its own may take up how they differ in stiffness, and
    leave the more of their curves: that comes no nearer.
    """

    def leaves_no_more(state: Candidate) -> bool:
        left, before = (structured(one.fit, search.problem, search.noise) for one in (state, told))
        return left <= before or not any(form.of_each for form in state.fit.forms.values())

    told = min(whole, best, key=surprise)
    clear = [one for one in alone if surprise(one) < surprise(told) - np.log(ODDS) and leaves_no_more(one)]
    paying = (one for one in sorted(clear, key=surprise) if len(one.ids) <= max(len(whole.ids), 1))
    return next((one for one in paying if _pays(search, one) and no_worse(one)), None)


def _beside(plain: str, names: Iterable[str]) -> tuple[str, ...]:
    return tuple(name for name in names if name != plain)


def _pays(search: Search, state: Candidate) -> bool:
    """Whether each name of a model helps, most tests left out too."""
    return all(search.evidence(search.without(state, name), state).accepted() for name in state.ids)


def likeliest(search: Search, before: Candidate, no_worse: Callable[[Candidate], bool]) -> Candidate | None:
    """Return the likeliest of all models fitted that leaves noise, each of its names needed; None if none does."""
    least = search.noise.least
    limit = allowed(structured(before.fit, search.problem, search.noise, least))
    # Of few readings noise itself may leave more.
    limit = max(limit, TOLD * (2.0 / len(before.fit.residual)) ** 0.25)
    found, seen = None, 0
    while len(search.states) > seen:  # what a model's names are held against, and so is fitted, may be the likelier
        seen = len(search.states)
        near = [
            state
            for state in search.states
            if state.ids
            and np.isfinite(state.fit.chi2)
            and structured(state.fit, search.problem, search.noise, least) <= limit
        ]
        # Of two that leave nothing at all, a formula of two names and a free law of one, the one name; of as many names
        # the fewer constants.
        near.sort(key=lambda one: (surprise(one), len(one.ids), len(one.fit.x)))
        paying = (one for one in near if explains(before, one) and _pays(search, one) and no_worse(one))
        found = next(paying, None)
        if found is not None:
            fewer = sorted((one for one in search.states if one.ids and {*one.ids} < {*found.ids}), key=surprise)
            enough = (one for one in fewer if one.judgement.is_small and _pays(search, one) and no_worse(one))
            found = next(enough, found)  # what is noise beside fewer names leaves nothing to a further one
    return found
