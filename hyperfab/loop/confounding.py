"""Which other names could stand for a found effect.

Those that do the same on these very data; those too with which the data are nearly as likely.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial

import numpy as np
from scipy.special import chdtrc

from hyperfab.arrays import Array
from hyperfab.loop.belief import Belief, allowed, coincidence, surprise
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.judge import Candidate, common_bic
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Effect, Form, Problem
from hyperfab.loop.score import projected
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import MARGIN, ODDS, SHARE, UNLIKELY
from hyperfab.numerics.gram import orthonormal


def rivals(search: Search, best: Candidate, sure: Callable[[], Belief]) -> dict[str, dict[str, Candidate]]:
    """Return, for each found effect, the others that could stand for it, with a model of each.

    ``sure`` tells how sure the names are by all models fitted so far.
    """
    tried = {name: _tried_instead_of(search, best, name) for name in best.ids}

    @cache
    def imprint(name: str) -> float:
        return _misfit(search.problem, search.noise, best.fit, search.without(best, name).fit)

    found = {
        name: {
            other: state
            for other, state in states.items()
            if does_the_same(search, best, state, partial(imprint, name))
        }
        for name, states in tried.items()
    }
    for name, states in _as_likely(search, best, sure()).items():
        if search.problem.describes:
            found[name] = {**found[name], **states}
        else:
            found[name] = {
                **{other: one for other, one in states.items() if _payable(search, best, one)},
                **found[name],
            }
    for name, others in found.items():
        for other in _never_told_from(search.problem, name, best.fit.forms):
            if other in tried[name]:
                others.setdefault(other, tried[name][other])
        if search.problem.effect(name).of_document:
            found[name] = {**others, **_own_instead(search, best, name)}
    return found


def _payable(search: Search, best: Candidate, state: Candidate) -> bool:
    """Whether a model that is as likely has a constant or two more, and nearly pays for them by BIC too.

    A law of physics that is not quite the part's needs them for what it would leave: another may win by luck then. With
    as few constants BIC tells by the data alone; three more pass for nearly anything, a second name among it.
    """
    strained = is_strained(search.problem, state.fit) and not is_strained(search.problem, best.fit)
    more = len(state.fit.x) - len(best.fit.x)
    return 1 <= more <= 2 and _gap(search, best, state) < 2.0 * MARGIN and not strained


def _own_instead(search: Search, best: Candidate, name: str) -> dict[str, Candidate]:
    """Return the model's own constants that could stand for a found effect, with the model that has them further off.

    Without the effect they are driven to the end of what is known of them: what is left then may ask for no more than
    that the document is wrong in them, which is no less likely than that another one is.
    """
    problem, without = search.problem, search.without(best, name)
    loose = problem.loosened(without.fit.x[: without.fit.own])
    if loose is None:
        return {}
    again = fit(loose, search.noise, dict(without.fit.forms), without.fit.x)
    state = Candidate(loose, search.noise, again)
    takes = without.fit.chi2 - again.chi2 > 0.5 * (without.fit.chi2 - best.fit.chi2)
    as_good = takes and _gap(search, best, state) < MARGIN
    return dict.fromkeys(problem.strained(again.x[: again.own]), state) if as_good else {}


def _as_likely(search: Search, best: Candidate, sure: Belief) -> dict[str, dict[str, Candidate]]:
    """Return the others that are nearly as likely in place of found effects as these are without them.

    Of models none of whose names could go; each other is told beside the first of those that it stands for.
    """
    models = sure.models
    needed = {ids for ids, p in models.items() if all(p >= q for fewer, q in models.items() if fewer < ids)}
    instead: dict[tuple[str, frozenset[str]], dict[frozenset[str], Candidate]] = {}
    for state in sorted(search.states, key=surprise):
        ids = frozenset(state.ids)
        if ids in needed and (lost := frozenset(best.ids) - ids):
            for other in sorted(ids - {*best.ids}):
                instead.setdefault((other, lost), {}).setdefault(ids, state)
    found: dict[str, dict[str, Candidate]] = {name: {} for name in best.ids}
    for (other, lost), states in instead.items():
        without = sum(p for ids, p in models.items() if other not in ids and ids & lost)
        if ODDS * sum(models[ids] for ids in states) >= without:
            first = next(name for name in best.ids if name in lost)
            found[first].setdefault(other, next(iter(states.values())))
    return found


def _tried_instead_of(search: Search, best: Candidate, name: str) -> dict[str, Candidate]:
    """Return the model with each entry that could pass for an effect of ``best`` in place of that."""
    found = {}
    without = search.without(best, name)
    most = len(best.fit.forms[name].constants)
    alike = _alike(search, best, without)
    for effect, _ in search.ranking(without):
        if effect.id == name:
            continue
        free = _paying(search, best, without, effect)
        gap = _gap(search, best, free)
        if alike[effect.id] < SHARE * alike.get(name, 1.0) and gap >= MARGIN:
            continue
        # Else a rival with more constants than the found law would pass for nearly anything.
        fitted = search.with_term(without, effect, most=most)
        if fitted is not None:
            state = search.state(fitted)
            found[effect.id] = search.enriched(state) if best.fit.forms[name].free else state
        if free is not None and gap < min(MARGIN, _gap(search, best, found.get(effect.id))):
            found[effect.id] = free
    return found


def _paying(search: Search, best: Candidate, without: Candidate, effect: Effect) -> Candidate | None:
    """Return the model with an entry in a form of any number of constants that these pay for; None if none is.

    Where much is known of the own constants BIC tells whether they pay by bringing these home, and whatever a little of
    it looks like. Else those are taken that were fitted on the way, and explain the data the better by BIC.
    """
    if search.problem.well_known:
        fitted = search.with_term(without, effect)
        return None if fitted is None else search.state(fitted)
    if search.problem.describes:
        return None
    names = {*without.ids, effect.id}
    better = [state for state in search.of_names(names) if _gap(search, best, state) < 0.0]
    return min(better, key=lambda state: _gap(search, best, state), default=None)


def does_the_same(search: Search, best: Candidate, state: Candidate, imprint: Callable[[], float]) -> bool:
    """Whether a model with another entry does the same as the ``best``, though its constants are likely ones.

    It is as good by BIC, and can do most of the effect's own noise-free ``imprint`` (chi-squared) with all constants
    refitted; or, where laws are physics, all but a share.
    """
    problem = search.problem
    instead = [name for name in state.ids if name not in best.ids and state.fit.forms[name].of_each]
    if any(coincidence(state, name) > 0.5 * MARGIN for name in instead):
        # How specimens were mounted or read does not follow how they were then led: it stands for what does.
        return False
    if problem.well_known and is_strained(problem, state.fit) and not is_strained(problem, best.fit):
        return False
    as_good = _gap(search, best, state) < MARGIN
    if any(form.free for form in state.fit.forms.values()):
        # A law of free shape comes near to nearly anything: it has to be as likely too.
        as_good = as_good and 2.0 * (surprise(state) - surprise(best)) < MARGIN
    if problem.describes and not as_good:
        return False
    left = _misfit(problem, search.noise, best.fit, state.fit)
    if as_good:
        return left < 0.5 * imprint()
    return left <= SHARE * imprint() and left <= (0.5 * allowed(np.inf)) ** 2 * len(best.fit.residual)


def _gap(search: Search, best: Candidate, state: Candidate | None) -> float:
    """Return how much worse a model does on the data than the best by BIC, infinitely where it leaves much more."""
    if state is None:
        return np.inf
    bic = common_bic([best.fit, state.fit], search.problem, search.noise)
    small = np.sqrt(max(state.excess - 1.0, 0.0)) < 0.6 + np.sqrt(max(best.excess - 1.0, 0.0))
    return float(bic[state.ids] - bic[best.ids]) if small else np.inf


def _alike(search: Search, best: Candidate, without: Candidate) -> dict[str, float]:
    """Return how far the imprint of a found effect lies in what each entry can do: the greatest squared cosine.

    What one form does with all its constants together counts: a turn about one axis is little like one about both.
    """
    basis, _ = projected(without.fit)
    noise = search.noise.at(without.fit.predicted)
    imprint = np.zeros(len(basis))
    imprint[: len(noise.sd)] = noise.whiten(best.fit.by_model - without.fit.by_model)
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


def indistinguishable(
    problem: Problem, others: Mapping[str, Iterable[str]], forms: Mapping[str, Form]
) -> list[list[str]]:
    """Return, for each found effect, the set of it, its rivals, and what tests of this plan never tell from it.

    ``forms`` are those found, of each effect.
    """
    sets = [
        [name, *dict.fromkeys([*rivals_of, *_never_told_from(problem, name, forms)])]
        for name, rivals_of in others.items()
    ]
    told = {frozenset(one): one for one in reversed(sets)}
    return [one for one in sets if len(one) > 1 and told[frozenset(one)] is one]


def _never_told_from(problem: Problem, name: str, found: Mapping[str, Form]) -> list[str]:
    """Return what no tests of this plan tell from an effect, less what is found beside it unless nothing else is.

    Of two found ones that they do not tell apart each may be all there is.
    """
    alike = {one for group in problem.look_alikes(found) if name in group for one in group}
    others = alike.difference(found) or alike.difference([name])
    return [one for one in sorted(others) if not problem.effect(one).not_sought]


def is_strained(problem: Problem, found: Fit) -> bool:
    """Whether a fit puts the model's own constants, together, further off than what is known of them allows."""
    away = [
        (value - constant.value) / constant.prior_sd
        for constant, value in zip(problem.own, found.x, strict=False)
        if np.isfinite(constant.prior_sd)
    ]
    return bool(away) and float(chdtrc(len(away), np.sum(np.square(away)))) < UNLIKELY


def _misfit(problem: Problem, noise: Noise, truth: Fit, start: Fit) -> float:
    """Return chi-squared of a model refitted to the noise-free prediction of another."""
    again = fit(problem, noise, dict(start.forms), start.x, data=truth.by_model, iterations=12)
    return again.chi2
