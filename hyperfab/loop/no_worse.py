"""No model with names is kept that misses stresses by more than the one without: what is done about one that does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter

import numpy as np

from hyperfab.loop.belief import explains, surprise
from hyperfab.loop.fitting import Descent, Fit, descent
from hyperfab.loop.judge import Candidate
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MOST, TOLD

#: Where more was read than stresses, sums of squares that differ by less are the same, but for how far a fit was led.
_ALIKE = 1.0 + 1e-6
#: How many times noisier what was read beside the stresses counts, where these would be missed by more for it.
_LOOSER = (3.0, 10.0, 30.0)
#: How far a fitted model misses readings that take no part.
Apart = Callable[[Fit], float]


def none_apart(fitted: Fit) -> float:
    """Return how far a model misses none: by nothing."""
    return 0.0


def no_worse(search: Search, base: Candidate, best: Candidate, apart: Apart) -> Candidate:
    """Return the model, or, where it misses more than the one without names (the data, each test left out, those set
    apart), the best with no other names that does not.

    That may be one of the same names in other forms, or one of simpler forms. What is left then has to pay anew. Where
    none is left, other names that explain the data may stand, the likeliest first.
    """
    had = bool(best.ids)
    while best.ids:
        same = of_same_names(search, base, best, apart)
        if same is not None:
            return same
        fewer = [search.without(best, name) for name in best.ids]
        simpler = [state for state in search.states if state.ids and {*state.ids} <= {*best.ids}]
        by_cost = sorted([*simpler, *fewer], key=lambda state: state.fit.cost)
        good = next((state for state in by_cost if is_no_worse(base, state, apart)), None)
        best = pruned(search, good or min(fewer, key=lambda state: state.fit.cost))
    return (_of_other_names(search, base, apart) or best) if had else best


def _of_other_names(search: Search, base: Candidate, apart: Apart) -> Candidate | None:
    """Return the likeliest single name that explains the data and misses no more than the model without names, None
    where there is none."""
    alone = [state for state in search.states if len(state.ids) == 1 and explains(base, state)]
    for state in sorted(alone, key=surprise):
        same = of_same_names(search, base, state, apart)
        if same is not None and explains(base, same) and pruned(search, same).ids:
            return same
    return None


def of_same_names(search: Search, base: Candidate, best: Candidate, apart: Apart) -> Candidate | None:
    """Return the model, or one of its names that gives up some contraction for the stresses, or in richer forms leaves
    these alone; None where each misses more than the one without names."""
    found = held(search, base, best, apart)
    if is_no_worse(base, found, apart):
        return found
    if not np.any(search.problem.channel > 0):
        return None
    richer = [held(search, base, search.state(one), apart) for one in search.richer(best.fit, free=False)]
    # One whose constants the data do not tell would take the name with it.
    good = [state for state in richer if is_no_worse(base, state, apart) and pruned(search, state) is state]
    return min(good, key=lambda state: state.fit.cost, default=None)


def nearest_apart(search: Search, best: Candidate, apart: Apart) -> Candidate:
    """Return the model, or the one of its names that comes clearly nearer to readings set apart: a law that goes
    through all that was read and misses what lies between is none. Where it does, all formulas are tried."""
    if not best.ids:
        return best
    first = search.problem.channel == 0
    left = (search.problem.measured - best.fit.predicted)[first]
    for name in best.ids if apart(best.fit) > TOLD * float(np.sqrt(np.mean(left**2))) else ():
        parent, effect = search.without(best, name).fit, search.problem.effect(name)
        for form in effect.forms:
            if not form.free and (one := search.joint(parent, effect, form)) is not None:
                search.state(one)
    same = [state for state in search.of_names(best.ids) if np.isfinite(state.fit.chi2)]
    nearest = min(same, key=lambda state: apart(state.fit), default=best)
    return nearest if apart(nearest.fit) < MOST * apart(best.fit) else best


def is_no_worse(base: Candidate, state: Candidate, apart: Apart = none_apart) -> bool:
    """Whether a model misses no more than another, plainly and everywhere."""
    first, measured = state.problem.channel == 0, state.problem.measured
    alike = 1.0 if first.all() else _ALIKE
    # What is forecast takes fits, and is asked for where the rest is no worse.
    for says in (attrgetter("fit.predicted"), attrgetter("forecast.predicted")):
        old, new = says(base), says(state)
        told = first & np.isfinite(old) & np.isfinite(new)
        if np.sum((measured - new)[told] ** 2) > alike * np.sum((measured - old)[told] ** 2):
            return False
    return apart(state.fit) <= apart(base.fit)


def held(search: Search, base: Candidate, state: Candidate, apart: Apart) -> Candidate:
    """Return the model so fitted that it is no worse than another: what was read beside the stresses counts less and
    less until these are missed by no more.

    Where the terms of a fabric have no say in the stresses, the model's own constants stay as they are.
    """
    beside = state.problem.channel > 0
    if not beside.any() or not state.ids or state.says is base:
        return state
    own = state.fit.own
    as_it_was = np.concatenate([base.fit.x[:own], state.fit.x[own:]])
    kept = Descent(search.problem, search.noise, state.fit.forms, as_it_was)
    alike = np.array_equal(kept.value[~beside], base.fit.predicted[~beside])
    # Of a press, a film read after opening says as much of the model's own constants as the pressure does.
    if (alike and state.problem.describes) or kept.cost <= state.fit.cost * _ALIKE:
        state = Candidate(search.problem, search.noise, kept.fit(search.noise), says=base if alike else None)
    found, looser = state, iter(_LOOSER)
    while not is_no_worse(base, found, apart):
        if (factor := next(looser, None)) is None:
            return state
        noise = replace(search.noise, sd=np.where(beside, factor, 1.0) * search.noise.sd)
        descended = descent(search.problem, noise, state.fit.forms, [state.fit.x])
        found = Candidate(search.problem, search.noise, descended.fit(search.noise))
    return found


def pruned(search: Search, best: Candidate) -> Candidate:
    """Take out every term that no longer pays now that the others are there, the last one too."""
    while best.ids:
        worth = {name: search.without(best, name) for name in best.ids}
        evidence = {name: search.evidence(smaller, best) for name, smaller in worth.items()}
        weak = [name for name in best.ids if not evidence[name].pays()]
        if not weak:
            break
        best = worth[min(weak, key=lambda name: evidence[name].delta_bic)]
    return best
