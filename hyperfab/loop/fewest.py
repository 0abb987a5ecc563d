"""The fewest names: where a formula is not quite the fabric's, a smooth law of one effect before a second effect."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

from hyperfab.loop.belief import explains, surprise
from hyperfab.loop.candidate import Candidate, Evidence
from hyperfab.loop.search import Search

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
    """Return the likeliest model that leaves noise, of richer forms or free ones.

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
    found = {}
    if whole is not before and explains(before, whole) and no_worse(whole):
        found[frozenset(whole.ids)] = whole
    alone: dict[str, float] = {}

    def ask(*ids: str) -> None:
        state = search.freed(before, ids)
        if state is None:
            return
        if len(ids) == 1:
            alone[ids[0]] = state.judgement.structured
        if explains(before, state) and _all_pay(search, state) and no_worse(state):
            found[frozenset(ids)] = min(state, found.get(frozenset(ids), state), key=surprise)

    for name in names:
        ask(name)
    likely = sorted(alone, key=lambda name: alone[name])[:_LIKELY]
    for name in likely:
        if name != plain and plain in names:
            ask(name, plain)
    if not any(len(ids - {plain}) < 2 for ids in found):
        for ids in combinations([name for name in best.ids if name != plain], 2):
            ask(*ids)
    if not found:
        return whole
    # Of two that leave nothing at all, a formula of two names and a free law of one, the one name.
    return min(found.values(), key=lambda state: (surprise(state), len(state.ids)))


def _all_pay(search: Search, state: Candidate) -> bool:
    """Whether each term of a model helps, most tests left out too."""
    return all(search.evidence(search.without(state, name), state).accepted() for name in state.ids)
