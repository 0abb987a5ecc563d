"""The loop: noise, residual, trace, verdict. The same for every domain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.loop.belief import Belief, belief, explains, outweighs_something_else, surprise
from hyperfab.loop.confounding import indistinguishable, rivals
from hyperfab.loop.dependence import dependence, suggestion
from hyperfab.loop.design import NextMeasurement, next_measurement
from hyperfab.loop.doubt import (
    likeliest_scatter,
    perhaps_hidden,
    scatter_of_one_cloth,
    undoubted,
    with_hidden,
    without_names,
)
from hyperfab.loop.fewest import fewest, likeliest
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import Candidate, Evidence, common_bic
from hyperfab.loop.no_worse import Apart, held, is_no_worse, nearest_apart, no_worse, none_apart, of_same_names, pruned
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Problem
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import FEWEST, MARGIN, ODDS, TOLD
from hyperfab.loop.wandering import wandering

#: Terms added at most, and models carried along at each number of terms; one more where it is not told from the last.
_DEPTH, _BEAM = 3, 2
#: A model that leaves this many times more variance than the best is not carried along.
_HOPELESS = 9.0


@dataclass(frozen=True)
class Finding:
    """What the loop found.

    ``verdict`` is noise, effect, ambiguous or unexplained; ``added`` the evidence of each effect of
    ``after``, in order; ``tried`` the evidence of the entries refitted on the model as it was; ``scores`` how far its
    residual points at each entry that these data could show, ``worth`` what each would lower BIC by, to first order.
    ``doubted`` were not added because specimens may scatter as much, ``worse`` because with them some readings are
    missed by more. ``assumed`` is the scatter of specimens that was taken for what is left, though none was measured;
    ``hidden`` may be behind it, each with how much they scatter beside it and without. ``put_right``: nothing was
    sought, for the readings put right need nothing.
    """

    verdict: str
    noise: Noise
    before: Candidate
    after: Candidate
    added: dict[str, Evidence]
    tried: dict[str, Evidence]
    scores: dict[str, float]
    worth: dict[str, float]
    indistinguishable: list[list[str]] = field(default_factory=list)
    measurements: list[NextMeasurement] = field(default_factory=list)
    rides_on: dict[str, float] = field(default_factory=dict)
    suggestion: tuple[str, float] | None = None
    doubted: tuple[str, ...] = ()
    worse: tuple[str, ...] = ()
    assumed: float = 0.0
    belief: Belief | None = None
    hidden: dict[str, tuple[float, float]] = field(default_factory=dict)
    put_right: bool = False


def close(
    problem: Problem,
    *,
    noise: float | Noise | None = None,
    tick: Callable[[str], None] = lambda text: None,
    design: bool = True,
    apart: Apart = none_apart,
    put_right: Callable[[Search, Candidate], bool] = lambda search, before: False,
) -> Finding:
    """Close the loop on a problem; ``noise`` is the standard deviation of a reading or all that is known of the noise,
    else it is estimated: from what neighbours and replicates differ by, and, where something then stays unexplained, as
    readings that wander. ``apart`` returns how far a model misses readings that take no part: no effect is kept that
    makes that more. ``put_right`` tells whether the readings are wrong and, put right, leave the model as it is no more
    than noise, so that nothing is to be sought."""
    search = Search(problem, noise if isinstance(noise, Noise) else estimate_noise(problem, noise), tick)
    found = _closed(search, design=design, again=True, apart=apart, put_right=put_right)
    if found.verdict != "unexplained" or not found.noise.estimated or found.put_right:
        return found
    wanders = wandering(problem, found.noise, problem.measured - found.after.fit.predicted, 0)
    if not np.any(wanders.sd > found.noise.sd):
        return found
    more = _closed(search.under(wanders), design=design, again=True, apart=apart)
    # What is missed by far more than readings wander, all that neighbours have in common counted, is none of their
    # wandering, however few tell how far that is.
    left = (problem.measured - more.before.fit.predicted) / wanders.sd
    missed = more.verdict == "noise" and not _within_noise(problem, left)
    if more.verdict == "unexplained" or missed or apart(more.after.fit) > apart(found.after.fit):
        return found
    return more


def _closed(
    search: Search,
    *,
    design: bool,
    again: bool,
    apart: Apart,
    put_right: Callable[[Search, Candidate], bool] = lambda search, before: False,
) -> Finding:
    """Close the loop at a noise; once more (``again``) where all specimens scatter more than the replicates show."""
    problem, level, tick = search.problem, search.noise, search.tick
    before = search.base()
    if not np.isfinite(before.fit.cost):
        raise NotConverged(
            "the model has no finite prediction for all of these readings",
            remedy="fit its constants to tests that reach as far, or take a law without a limiting stretch",
        )
    scores = {effect.id: score for effect, score in search.ranking(before)}
    worth = search.worth(before)

    odds: dict[str, float] = {}

    def sure_of(is_noise: bool = False) -> Belief:
        return belief(before, search.states, problem.sought, is_noise=is_noise).against(odds)

    def under(other: Noise) -> Finding:
        """Return what is found where noise is another, in all judgements."""
        return _closed(search.under(other), design=design, again=False, apart=apart)

    def beside(less: float) -> Finding:
        """Return what is found where specimens scatter less than replicates have it, as all of them tell."""
        return under(replace(level, gain_sd=less, gain_doubt=less * (1.0 + TOLD / np.sqrt(2.0 * len(level.groups)))))

    def finding(verdict: str, after: Candidate, added: dict[str, Evidence], tried: dict[str, Evidence]) -> Finding:
        left = problem.measured - after.fit.predicted
        first = problem.channel == 0
        states = problem.states
        scattered = (left / level.sd)[first] if level.gain_sd else None
        rides_on = dependence(after.fit.residual[first], states, scattered, level.groups)
        hint = None
        if verdict == "unexplained":
            hint = suggestion(left[first], level.sd[first], states)
        return Finding(
            verdict, level, before, after, added, tried, scores, worth,
            rides_on=rides_on, suggestion=hint, belief=sure_of(verdict == "noise"),
            hidden=perhaps_hidden(search, after),
        )  # fmt: skip

    if before.judgement.is_noise or _no_more_than_noise(before):
        less = with_hidden(search, before, 1)[1] if again else np.inf
        return beside(less) if less < level.gain_sd else finding("noise", before, {}, {})
    tick("readings")
    if put_right(search, before):
        return replace(finding("unexplained", before, {}, {}), put_right=True)
    best, tried = _found(search, before, apart)
    best = nearest_apart(search, best, apart)
    helpful = no_worse(search, before, best, apart)
    worse = tuple(name for name in best.ids if name not in helpful.ids)
    best = _likely(search, before, helpful, sure_of)
    best, less = with_hidden(search, best, _DEPTH + (problem.plain in best.ids))
    if again and less < level.gain_sd:
        return beside(less)
    scatter = min(likeliest_scatter(search, best)[1], level.gain_doubt) if level.gain_doubt else 0.0
    if again and scatter > level.gain_sd:
        return under(replace(level, gain_sd=scatter))
    kept, against = undoubted(search, best)
    kept = no_worse(search, before, kept, apart)
    doubted = tuple(name for name in best.ids if name not in kept.ids)
    if again and not (kept.ids and explains(before, kept)):
        scatter = scatter_of_one_cloth(search, kept, best)
        found = under(replace(level, gain_sd=scatter)) if scatter else None
        nearer = found and (found.verdict != "unexplained" or len(found.after.ids) > len(kept.ids))
        if found and nearer and apart(found.after.fit) <= apart(kept.fit):
            still = tuple(name for name in doubted if name not in found.after.ids)
            every = tuple(dict.fromkeys((*still, *found.doubted)))
            return replace(found, assumed=found.assumed or scatter, doubted=every)
    odds |= against
    if not kept.ids:
        verdict, assumed = without_names(search, before, bool(doubted))
        return replace(finding(verdict, before, {}, tried), doubted=doubted, worse=worse, assumed=assumed)
    best = held(search, before, _ordered(search, kept), apart)
    tick("rivals")
    others = rivals(search, best, sure_of)
    while (likelier := _likelier(search, before, best, apart)) is not None:
        best = held(search, before, _ordered(search, likelier), apart)
        others = rivals(search, best, sure_of)
    sets = indistinguishable(problem, others, best.fit.forms)
    added = {name: search.evidence(search.without(best, name), best) for name in best.ids}
    if not explains(before, best) or problem.strained(best.fit.x[: best.fit.own]):
        verdict = "unexplained"
    elif sets:
        verdict = "ambiguous"
    else:
        verdict = "effect" if sure_of().something_else <= 0.5 else "unexplained"
    measurements: list[NextMeasurement] = []
    # What a constant of the model is, is measured by itself.
    stood = [state for instead in others.values() for state in instead.values() if state.problem is problem]
    alike = {id(state): state.fit for state in stood}
    if alike and design:
        tick("next measurement")
        measurements = next_measurement(problem, level, [best.fit, *alike.values()])
    return replace(
        finding(verdict, best, added, tried),
        doubted=doubted, worse=worse, indistinguishable=sets, measurements=measurements,
    )  # fmt: skip


def _found(search: Search, before: Candidate, apart: Apart) -> tuple[Candidate, dict[str, Evidence]]:
    """Return the model with the terms that pay, the fewest that do, and what each first one would be worth."""
    tried: dict[str, Evidence] = {}
    # A smooth law of one name or two comes before a third.
    best, depths = before, (2, _DEPTH, _DEPTH + 1) if search.problem.describes else (_DEPTH,)
    for depth in depths:
        if depth > _DEPTH and search.problem.plain not in best.ids:
            break  # a better law leaves room for as many effects
        best, tried = _grow(search, before, depth)
        best = pruned(search, best)
        best = of_same_names(search, before, best, apart) or best
        best = fewest(search, before, best, tried, lambda state: is_no_worse(before, state, apart))
        best = pruned(search, best)  # beside a richer form another name may have nothing left to say
        if best.ids and explains(before, best):
            break
    return best, tried


def _no_more_than_noise(base: Candidate) -> bool:
    """Whether what is left is no more in size than the noise, of each test too, though its order may not be chance's.

    How large the noise is nobody knows so well that a name could rest on less.
    """
    return base.judgement.structured == 0.0 and _within_noise(base.problem, base.fit.residual)


def _within_noise(problem: Problem, left: Array) -> bool:
    """Whether of no test more is ``left`` (rows,), in standard deviations of the noise, than readings are off by."""
    told = [curve for curve in problem.curves if curve.stop - curve.start >= FEWEST and not curve.beforehand]
    return all(np.mean(left[curve.rows] ** 2) <= TOLD**2 for curve in told)


def _grow(search: Search, base: Candidate, most: int) -> tuple[Candidate, dict[str, Evidence]]:
    """Add up to ``most`` terms, a few models side by side; return the best and what each first term would be worth."""
    beam, best = [base], base
    tried: dict[str, Evidence] = {}
    for depth in range(most):
        grown: dict[frozenset[str], Candidate] = {}
        idle: dict[frozenset[str], Candidate] = {}
        accepted: set[frozenset[str]] = set()
        for state in beam:
            for larger, evidence in search.candidates(state):
                if depth == 0:
                    tried[larger.ids[-1]] = evidence
                ids = frozenset(larger.ids)
                if evidence.delta_bic >= MARGIN:
                    grown.setdefault(ids, larger)
                elif search.problem.hiding or evidence.foretells():
                    idle.setdefault(ids, larger)
                if evidence.accepted() and _worth_a_name(base, state, larger, evidence):
                    accepted.add(ids)
        if not grown and depth == 0:  # two effects may hide each other
            grown = idle
        if not grown:
            break
        bic = common_bic([state.fit for state in grown.values()], search.problem, search.noise)
        order = sorted(grown.values(), key=lambda state: bic[state.ids])
        last = bic[order[:_BEAM][-1].ids]
        beam = order[: _BEAM + any(bic[state.ids] - last < MARGIN for state in order[_BEAM : _BEAM + 1])]
        passing = [state for state in order if frozenset(state.ids) in accepted]
        if best is not base and explains(base, best):
            # More terms, these or others, have to pay where the fewer explain what was there.
            passing = [state for state in passing if _says_more(search, best, state)]
        if passing:
            best = passing[0] if explains(base, passing[0]) else search.polished(passing[0])
            beam = [best, *[state for state in beam if frozenset(state.ids) != frozenset(best.ids)]][: len(beam)]
        done = best.judgement.is_small and len(best.ids) == depth + 1
        if done and not search.plainer(best):
            break
        beam = _to_grow_on(search, beam, done)
        # A further name would cost more than is left to take.
        if search.problem.describes and explains(base, best) and surprise(best) <= 0.5 * MARGIN * (depth + 1):
            break
    return best, tried


def _says_more(search: Search, best: Candidate, state: Candidate) -> bool:
    """Whether a model of more terms, or others, pays where one explains what was there already.

    It takes half of what is left, or stands in place of a form of many constants, which costs more by BIC.
    """
    if not state.judgement.is_small:
        return False
    if state.excess - 1.0 <= 0.5 * (best.excess - 1.0):
        return True
    bic = common_bic([best.fit, state.fit], search.problem, search.noise)
    return bool(search.plainer(best)) and bic[state.ids] <= bic[best.ids] - MARGIN


def _to_grow_on(search: Search, beam: list[Candidate], done: bool) -> list[Candidate]:
    """Return the models that further terms are added to: those with a form of many constants with a simple one as well,
    and with that alone where nothing is left to tell."""
    plainer = [search.plainer(state) for state in beam]
    # A model that misses three times as much as the best would only find its way to the same terms.
    most = _HOPELESS * max(beam[0].excess - 1.0, 0.01)
    kept = [
        state
        for state, simple in zip(beam, plainer, strict=True)
        if (not simple if done else state.excess - 1.0 <= most)
    ]
    return [*kept, *(state for simple in plainer for state in simple)]


def _worth_a_name(base: Candidate, smaller: Candidate, larger: Candidate, evidence: Evidence) -> bool:
    """Where little is left a term is named only if it explains all of that."""
    if base.judgement.is_small:
        return larger.judgement.is_noise
    if smaller is not base and explains(base, smaller):
        return evidence.variance_share >= 0.5 and larger.judgement.is_small
    if evidence.help is None and len(base.held_out.counted) > 1:
        # What no other test can foretell has to leave less than something else would.
        return larger.judgement.is_noise or outweighs_something_else(smaller, larger)
    return True


def _likely(search: Search, before: Candidate, best: Candidate, sure_of: Callable[[], Belief]) -> Candidate:
    """Take out every name that is less likely than that the others stand without it.

    The last one too, where what is left without it is small: it is to be likelier than that nothing lacks. A formula
    that is not quite the fabric's leaves more than the right name may, which a further name then takes up: the others
    keep the forms that leave no more, if there are such ones.
    """
    while len(best.ids) > (0 if before.judgement.is_small else 1):
        sure, ids = sure_of(), frozenset(best.ids)
        models = {frozenset[str](): sure.nothing} if len(ids) == 1 else sure.models
        without = {name: sum(p for fewer, p in models.items() if fewer < ids and name not in fewer) for name in ids}
        weakest = max(best.ids, key=lambda name: without[name] - sure.of[name])
        if without[weakest] <= sure.of[weakest]:
            break
        search.without(best, weakest)
        same = search.of_names(ids - {weakest})
        best = min(same, key=lambda state: (not explains(before, state), surprise(state)))
    return best


def _likelier(search: Search, before: Candidate, best: Candidate, apart: Apart) -> Candidate | None:
    """Return a model of other names that is clearly likelier, though it was fitted only as a rival; None if none is."""
    if not search.problem.describes:
        return None
    found = likeliest(search, before, lambda state: is_no_worse(before, state, apart))
    if found is None:
        return None
    found, _ = undoubted(search, found)
    clear = surprise(found) < surprise(best) - np.log(ODDS)
    return found if found.ids and {*found.ids} != {*best.ids} and clear else None


def _ordered(search: Search, best: Candidate) -> Candidate:
    """Put the terms in the order of what they take from the error, the largest first, and fit them to the end."""
    first = search.problem.channel == 0
    worth = {name: float(np.sum(search.without(best, name).fit.residual[first] ** 2)) for name in best.ids}
    order = sorted(best.ids, key=lambda name: -worth[name])
    forms = {name: best.fit.forms[name] for name in order}
    x = np.concatenate([best.fit.x[: best.fit.own], *(best.fit.x[best.fit.place(name)] for name in order)])
    again = fit(search.problem, search.noise, forms, x)
    return Candidate(search.problem, search.noise, again)
