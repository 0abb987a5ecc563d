"""The fewest names: where a formula is not quite the fabric's, a smooth law of one effect before a second effect."""

from __future__ import annotations

from itertools import combinations

from hyperfab.loop.belief import explains
from hyperfab.loop.candidate import Candidate, Evidence
from hyperfab.loop.judge import common_bic
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MARGIN

#: First terms of which a smooth law is tried.
_LIKELY = 3


def fewest(
    search: Search, before: Candidate, best: Candidate, tried: dict[str, Evidence]
) -> tuple[Candidate, list[Candidate]]:
    """Return the model with the fewest names that leaves noise, of richer forms or free ones, and those as good.

    A further name may only make up for a formula that is not quite the fabric's, and where no name could be found none
    may have had the right one. The name is what a smooth law of it explains; each further one has to pay.
    """
    explained = best is not before and explains(before, best)
    if explained and len(best.ids) == 1:
        return best, []
    whole = best if best is before or explained else search.enriched(best)
    if not any(form.free for effect in search.problem.effects for form in effect.forms):
        return whole, []
    explained = whole is not before and explains(before, whole)
    likely = sorted(tried, key=lambda name: -tried[name].delta_bic)[:_LIKELY]
    names = tuple(dict.fromkeys([*best.ids, *likely, search.problem.plain]))
    found: dict[frozenset[str], Candidate] = {frozenset(whole.ids): whole} if explained else {}
    for ids in (*combinations(names, 1), *combinations(names, 2)):
        if len(ids) > 1 and any(len(one) == 1 for one in found):
            break
        if len(ids) == 1 or search.problem.plain in ids or set(ids) <= set(best.ids):
            state = search.freed(before, ids)
            if state is None or not explains(before, state) or not _all_pay(search, state):
                continue
            other = found.get(frozenset(ids), state)
            found[frozenset(ids)] = state if search.lowest([state.fit, other.fit]) is state.fit else other
    if not found:
        return whole, []
    bic = common_bic([state.fit for state in found.values()], search.problem)
    cost = {ids: bic[state.ids] + MARGIN * len(ids) for ids, state in found.items()}
    # What explains already loses names; it does not change them.
    own = {*whole.ids, search.problem.plain} if explained else set(names)
    chosen = min((ids for ids in found if ids <= own), key=lambda ids: cost[ids])
    as_good = [found[ids] for ids in found if ids != chosen and cost[ids] < cost[chosen] + MARGIN]
    return found[chosen], as_good


def or_these(sets: list[list[str]], best: Candidate, as_good: list[Candidate]) -> list[list[str]]:
    """Return the sets of look-alikes with the names of models that explain as much beside them."""
    found = {one[0]: list(one) for one in sets}
    for other in as_good:
        lost = [name for name in best.ids if name not in other.ids]
        instead = [name for name in other.ids if name not in best.ids]
        if lost and instead:
            same = found.setdefault(lost[0], [lost[0]])
            same += [name for name in instead if name not in same]
    return [found[name] for name in best.ids if name in found]


def _all_pay(search: Search, state: Candidate) -> bool:
    """Whether each term of a model helps, most tests left out too."""
    first = len(state.ids) == 1
    return all(search.evidence(search.without(state, name), state).accepted(first) for name in state.ids)
