"""Which terms: refit the entries the residual points at, keep what pays in likelihood, out of sample, and in size."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.fitting import Fit, descent, fit
from hyperfab.loop.heldout import Help, help_of
from hyperfab.loop.judge import Candidate, Evidence, Level, correlation_time, structured_of_each
from hyperfab.loop.noise import Noise, with_misfit
from hyperfab.loop.problem import Effect, Form, Problem
from hyperfab.loop.replicates import is_of_few
from hyperfab.loop.score import points_at
from hyperfab.loop.screen import refining, worth_a_fit
from hyperfab.loop.thresholds import MARGIN, SHARE, SMALL, TOLD
from hyperfab.numerics.gram import inverse

#: Refinements of the terms of a model that leaves much.
_STEPS = 4
#: Share of the model's own constants that a form leaves which takes over from them.
_NEXT_TO_NOTHING = 0.02
#: Entries that are tried, forms of one, and entries of which the forms that refine them are tried too.
_ENTRIES, _FORMS, _RICH = 6, 3, 3


@dataclass
class Search:
    """Fits models with terms, each once; those of an ``earlier`` search under nearly this noise go on from there."""

    problem: Problem
    noise: Noise
    tick: Callable[[str], None] = lambda text: None
    earlier: Search | None = None
    _fits: dict[tuple, Fit] = field(default_factory=dict)
    _states: dict[tuple, Candidate] = field(default_factory=dict)
    _own_optimum: Candidate | None = None

    def under(self, other: Noise) -> Search:
        """Return a search under another noise, of which the fits go on from those of this one where it is near."""
        return Search(self.problem, other, self.tick, self if self.noise.is_near(other) else None)

    def base(self) -> Candidate:
        """Return the model as it is, with its own constants refitted."""
        fits = [fit(self.problem, self.noise, {}, start) for start in (self.problem.given, *self.problem.starts)]
        best = min(fits, key=lambda one: one.cost)
        if not np.isfinite(best.chi2) or best.cost <= TOLD**2 * len(best.residual):
            return self.state(best)
        # What the model misses counts as noise: the quietest test must not be all that it is fitted to. What a term is
        # worth is told from the model's own optimum under the noise, as that of every larger one is.
        wrong = with_misfit(self.noise, self.problem.measured - best.predicted, best.residual, self.problem.curves)
        near = fit(self.problem, wrong, {}, best.x)
        own = min(best, fit(self.problem, self.noise, {}, near.x), key=lambda one: one.cost)
        self._own_optimum = Candidate(self.problem, self.noise, own)
        state = Candidate(self.problem, self.noise, fit(self.problem, self.noise, {}, near.x, iterations=0), wrong)
        self._states[()] = state
        return state

    def state(self, fitted: Fit) -> Candidate:
        """Judge a fit."""
        key = _key(fitted.forms)
        if key not in self._states:
            self._states[key] = Candidate(self.problem, self.noise, fitted)
        return self._states[key]

    @property
    def states(self) -> list[Candidate]:
        """All models that were judged."""
        return list(self._states.values())

    def of_names(self, names: Collection[str]) -> list[Candidate]:
        """Return those of them with just these names, in whatever forms."""
        return [state for state in self.states if {*state.ids} == {*names}]

    def forget(self, first: int) -> None:
        """Take back what was judged after the ``first`` so many models: how sure a name is they have no say in."""
        for key in list(self._states)[first:]:
            del self._states[key]

    def ranking(self, state: Candidate) -> list[tuple[Effect, float]]:
        """Return the entries not in the model, the one the residual points at most first."""
        best = _greatest((one.effect.id, points_at(one)) for one in state.found)
        return [(self.problem.effect(name), best[name]) for name in sorted(best, key=lambda name: -best[name])]

    def worth(self, state: Candidate) -> dict[str, float]:
        """Return what each entry not in the model would lower BIC by, to first order: along its best signature."""
        time = correlation_time(state.fit.residual, self.problem.curves)
        penalty = float(np.log(max(len(state.fit.residual) / time, 3.0)))
        return _greatest(
            (one.effect.id, points_at(one) ** 2 / max(state.excess, 1.0) / time - len(one.form.constants) * penalty)
            for one in state.found
        )

    def with_term(self, state: Candidate, effect: Effect, families: int = 1, most: int = 99) -> Fit | None:
        """Return the best joint fit of the model with ``effect``: its forms, then those that refine them.

        ``families`` are the simple forms that are refined, the best first of those that have richer ones; ``most``
        bounds the constants of the forms that refine. Where the data cannot show the simple form, a richer one is
        tried on its own.
        """
        rank = _greatest((one.form.name, points_at(one)) for one in state.found if one.effect is effect)
        basic = sorted(
            (
                form
                for form in effect.forms
                if form.name in rank
                and (form.refines is None or len(form.constants) <= most)
                and worth_a_fit(self.problem, state.fit, form, state.found)
            ),
            key=lambda form: -rank[form.name],
        )
        fits = [found for form in basic[:_FORMS] if (found := self.joint(state.fit, effect, form)) is not None]
        if not fits:
            return None
        found = self.lowest(fits)
        refined = {name for form in effect.forms if not form.free for name in form.simpler}
        rich = [one for one in fits if one.forms[effect.id].name in refined]
        for one in sorted(rich, key=lambda one: one.chi2)[:families]:
            if not self._is_spent(found):
                found = self.lowest([found, self._refined(state.fit, effect, one, most)])
        return found

    def _refined(self, parent: Fit, effect: Effect, best: Fit, most: int) -> Fit:
        """Return the best of a fit and the forms that refine its, unless it already leaves no more than noise."""
        while not self._is_spent(best):
            richer = [
                found
                for form in refining(self.problem, self.noise, best, effect.id)
                if len(form.constants) <= most and (found := self.joint(parent, effect, form, best)) is not None
            ]
            better = self.lowest([best, *richer])
            if better is best:
                break
            best = better
        return best

    def without(self, state: Candidate, name: str) -> Candidate:
        """Return the model without one of its terms, refitted from where it is and from the base's own optimum.

        A term that carries most of the stress leaves the others far from where they do without it.
        """
        forms = {key: form for key, form in state.fit.forms.items() if key != name}
        key = _key(forms)
        if key in self._states:
            return self._states[key]
        keep = np.ones(len(state.fit.x), dtype=bool)
        keep[state.fit.place(name)] = False
        left = state.fit.x[keep]
        base = self._own_optimum or self._states.get(())
        starts = [left] if base is None else [left, np.concatenate([base.fit.x, left[state.fit.own :]])]
        fits = [fit(self.problem, self.noise, forms, start) for start in starts]
        return self.state(min(fits, key=lambda one: one.cost))

    def polished(self, state: Candidate) -> Candidate:
        """Return the model with each term in the form that suits it best now that the others are there."""
        if len(state.ids) < 2:
            return state
        for name in state.ids:
            rest = self.without(state, name)
            again = self.with_term(rest, self.problem.effect(name), _FORMS)
            if again is not None and self.lowest([state.fit, again]) is again:
                state = self.state(again)
        return state

    def plainer(self, state: Candidate) -> list[Candidate]:
        """Return the model with one of its terms in the simple form that it refines by at least three constants.

        Where laws are physics so many may stand in for a second name, which costs fewer.
        """
        found = []
        for name, form in state.fit.forms.items() if not self.problem.describes else ():
            simple = [
                one
                for one in self.problem.effect(name).forms
                if form.refines is not None and one.refines is None and len(form.constants) - len(one.constants) > 2
            ]
            keys = [_key({**state.fit.forms, name: one}) for one in simple]
            fitted = [self._fits[key] for key in keys if key in self._fits]
            if fitted:
                found.append(self.state(min(fitted, key=lambda one: one.chi2)))
        return found

    def enriched(self, state: Candidate) -> Candidate:
        """Return the model with its terms in richer forms while they pay by AIC: where much is left of what names that
        stand are to explain, the simplest law is not the aim."""
        best = self._richest(self._richest(state.fit, free=False), free=True)
        return state if best is state.fit else self.state(best)

    def freed(self, base: Candidate, ids: Sequence[str], of: Collection[str] = ()) -> Candidate | None:
        """Return the model of ``base`` with some terms, all or ``of`` some names, free where that pays; None if one has
        no fit."""
        state = base
        for name in ids:
            fitted = self.with_term(state, self.problem.effect(name))
            if fitted is None:
                return None
            state = self.state(fitted)
        return self.state(self._richest(state.fit, free=True, of=of))

    def _richest(self, best: Fit, free: bool, of: Collection[str] = ()) -> Fit:
        for _ in range(_STEPS):
            if self._is_spent(best):
                break
            if not (richer := self.richer(best, free, of)):
                break
            # A form of more constants leaves less whatever they are for: each has to earn its own here too.
            common = Level.of(richer, self.problem, self.noise)
            found = min(richer, key=lambda one: common.misfit(one) + 2.0 * len(one.x))
            level = Level.of([found], self.problem, self.noise)
            gain = level.misfit(best) - level.misfit(found)
            if gain < 2.0 * (len(found.x) - len(best.x)) or found.chi2 > 0.9 * best.chi2:
                break
            best = found
        return best

    def richer(self, best: Fit, free: bool, of: Collection[str] = ()) -> list[Fit]:
        """Return the model with one of its terms in a richer form, all of them or those ``of`` some names."""
        return [
            found
            for name in of or best.forms
            for form in refining(self.problem, self.noise, best, name, free=free)
            if (found := self._enriched(best, name, form)) is not None
        ]

    def _enriched(self, parent: Fit, name: str, form: Form) -> Fit | None:
        forms = {key: (form if key == name else one) for key, one in parent.forms.items()}
        key = _key(forms)
        if key not in self._fits:
            self.tick(name)
            given = {one: parent.x[parent.place(one)] for one in parent.forms}
            near = given | {name: form.begin(parent.forms[name], given[name])}
            # What the constants have come to beside one form may be far from what they are beside another.
            anew = given | {name: np.array(form.starts[0])}
            base = self._states[()].fit.x
            pairs = [(parent.x[: parent.own], near), (base, anew)]
            if form.takes_over:
                kept = self.problem.scaled(base, _NEXT_TO_NOTHING)
                pairs += [(kept, given | {name: np.array(one)}) for one in form.starts]
            starts = [np.concatenate([own, *parts.values()]) for own, parts in pairs]
            found = self._lowest_of(forms, form, [starts])
            if not np.isfinite(found.chi2):
                return None
            self._fits[key] = found
        return self._fits[key]

    def _is_spent(self, fitted: Fit) -> bool:
        """Whether a fit leaves no more than noise with constants as they may be: nothing richer is called for."""
        rows, strained = len(fitted.residual), self.problem.strained(fitted.x[: fitted.own], TOLD)
        return not strained and fitted.chi2 <= rows - len(fitted.x) + float(np.sqrt(2.0 * rows))

    def lowest(self, fits: Sequence[Fit]) -> Fit:
        """Return the fit of lowest BIC; a form with more constants has to earn them by half the margin."""
        level = Level.of(fits, self.problem, self.noise)
        return min(fits, key=lambda one: level.misfit(one) + level.price(one) + len(one.x) * MARGIN / 4.0)

    def joint(self, parent: Fit, effect: Effect, form: Form, simpler: Fit | None = None) -> Fit | None:
        """Return the best fit of a model with a term more; None where it has none."""
        forms = {**parent.forms, effect.id: form}
        key = _key(forms)
        if key in self._fits:
            return self._fits[key]
        self.tick(effect.id)
        if simpler is not None:
            begin = form.begin(simpler.forms[effect.id], simpler.x[simpler.place(effect.id)])
            starts = [np.concatenate([simpler.x[: len(parent.x)], begin])]
        else:
            starts = [np.concatenate([parent.x, np.array(start)]) for start in form.starts]
        if form.takes_over:
            kept, others = self.problem.scaled(parent.x[: parent.own], _NEXT_TO_NOTHING), parent.x[parent.own :]
            starts += [np.concatenate([kept, others, np.array(start)]) for start in form.starts]
        # A model that lacks much drifts far from what is known: the way back is long, or leads elsewhere.
        own = self.problem.given
        delivered = [np.concatenate([own, start[len(own) :]]) for start in starts]
        # Where a law has several optima each way is gone to its end.
        ways = [starts, delivered] if self.problem.has_valleys else [starts + self.problem.well_known * delivered]
        best = self._lowest_of(forms, form, ways)
        if not np.isfinite(best.chi2) or (form.of_each and is_of_few(best, effect.id, self.problem.curves)):
            return None
        self._fits[key] = best
        return best

    def _lowest_of(self, forms: Mapping[str, Form], new: Form, ways: Sequence[Sequence[Array]]) -> Fit:
        """Return the fit of least cost: of each way's starts the one that leads on, after a few steps, to its end.

        Of a model that was fitted under nearly this noise alone from there.
        Of all starts where the ``new`` form takes over from the law: there a few steps do not tell.
        """
        made = None if self.earlier is None else self.earlier._fits.get(_key(forms))
        if made is not None:
            ways = [[np.concatenate([made.x[: made.own], *(made.x[made.place(name)] for name in forms)])]]
        elif new.takes_over:
            ways = [[start] for way in ways for start in way]
        tries = [descent(self.problem, self.noise, forms, way, coarse=True) for way in ways]
        return min(tries, key=lambda one: one.cost).fit(self.noise)

    def evidence(self, smaller: Candidate, larger: Candidate) -> Evidence:
        """Return what the terms of ``larger`` that ``smaller`` lacks are worth, both at their own optimum."""
        if not smaller.ids and self._own_optimum is not None:
            smaller = self._own_optimum
        old, new = smaller.fit, larger.fit
        level = Level.of([new], self.problem, self.noise)
        gone = old.chi2 - new.chi2
        total = max(old.chi2 - len(old.residual), gone, 1e-9)
        known = [np.arange(c.start, c.stop) for c in self.problem.curves if c.beforehand]
        back = sum(float(np.sum(old.residual[rows] ** 2 - new.residual[rows] ** 2)) for rows in known)
        stiffness = self._share_of_stiffness(old, new)
        return Evidence(
            delta_bic=level.misfit(old) - level.misfit(new) + level.price(old) - level.price(new),
            variance_share=max(gone / total, stiffness),
            help=self._help(smaller, larger, of_stiffness=stiffness >= SHARE),
            certain=self._certain(smaller, larger),
            restores=back >= max(MARGIN, 0.5 * gone) and larger.judgement.is_noise,
        )

    def _share_of_stiffness(self, old: Fit, new: Fit) -> float:
        """Return the share that is taken of how much more specimens are off in stiffness than they scatter.

        It is one value of each way of testing, which the many readings of the rest would hide.
        """
        if not self.noise.gain_sd:
            return 0.0
        before, after = (structured_of_each(one, self.problem, self.noise)[-1] for one in (old, new))
        return float(1.0 - (after / before) ** 2) if before > SMALL else 0.0

    def _help(self, smaller: Candidate, larger: Candidate, *, of_stiffness: bool) -> Help | None:
        """Return what the terms of ``larger`` that ``smaller`` lacks do for the readings of tests left out.

        Or for how stiff the specimens of these are (``of_stiffness``), where that is more: it is one value of each,
        which what a law misses in their many readings would hide.
        """
        readings = help_of(smaller.held_out, larger.held_out, smaller.fit.residual**2 - larger.fit.residual**2)
        if readings is None or not of_stiffness:
            return readings
        old, new = (self.noise.at(one.fit.predicted) for one in (smaller, larger))
        gone = old.along_stiffness(smaller.fit.residual) ** 2 - new.along_stiffness(larger.fit.residual) ** 2
        stiffness = help_of(smaller.held_out.in_stiffness(old), larger.held_out.in_stiffness(new), gone)
        return readings if stiffness is None else max(readings, stiffness, key=lambda one: one.taken)

    def _certain(self, smaller: Candidate, larger: Candidate) -> bool:
        """Whether each new term is two standard deviations from null: some constant of it, or all of them together.

        Constants of a weft of its own can each be unsure though the weft is not. Offsets of each specimen are one
        effect only where at least half of the specimens have one.
        """
        new = larger.fit
        scale = np.sqrt(max(larger.excess, 1.0))
        for name, form in new.forms.items():
            if name in smaller.fit.forms:
                continue
            place = new.place(name)
            away, sd = new.x[place] - np.array(form.null), new.sd[place] * scale
            together = float(away @ inverse(new.covariance[place, place] * scale**2, 1e-10) @ away)
            if not np.any(np.abs(away) > TOLD * sd) and together < TOLD**2 + TOLD * len(sd):
                return False
            if form.of_each and is_of_few(new, name, self.problem.curves):
                return False
        return True

    def candidates(self, state: Candidate) -> list[tuple[Candidate, Evidence]]:
        """Return the models with one term more, those of lowest BIC first; the best of them in their richest form."""
        simple = []
        for effect, _ in self.ranking(state)[: max(self.problem.rich, _ENTRIES)]:
            fitted = self.with_term(state, effect, families=0)
            if fitted is not None:
                simple.append((effect, fitted))
        simple.sort(key=lambda pair: pair[1].chi2)
        found = []
        for place, (effect, fitted) in enumerate(simple):
            if place < (_RICH if state.ids else self.problem.rich):
                fitted = self.with_term(state, effect, _FORMS if place == 0 else 1) or fitted
            larger = self.state(fitted)
            found.append((larger, self.evidence(state, larger)))
        return sorted(found, key=lambda pair: -pair[1].delta_bic)


def _key(forms: Mapping[str, Form]) -> tuple:
    return tuple(sorted((name, form.name) for name, form in forms.items()))


def _greatest(values: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Return the greatest value of each name."""
    found: dict[str, float] = {}
    for name, value in values:
        found[name] = max(found.get(name, -np.inf), value)
    return found
