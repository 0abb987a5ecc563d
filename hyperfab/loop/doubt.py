"""What specimens that scatter could explain as well: which names stand beside that, and what is said without any."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from hyperfab.loop.fitting import fitted_misfit, stepped_misfits
from hyperfab.loop.judge import Candidate, correlation_time
from hyperfab.loop.noise import Noise
from hyperfab.loop.replicates import CLOTH_COUNTS, replicates
from hyperfab.loop.search import Search
from hyperfab.loop.thresholds import ALPHA, MARGIN, ODDS, ONE_CLOTH, SMALL, TOLD

#: Scatters of specimens that are tried.
_SCATTERS = tuple(float(one) for one in 0.002 * 2.0 ** (np.arange(0, 17) / 2.0))
#: Entries that are tried beside a model for what the scatter of specimens hides.
_HIDDEN = 3


def undoubted(search: Search, best: Candidate) -> tuple[Candidate, dict[str, float]]:
    """Take out terms that specimens which scatter more than the few replicates show could explain as well.

    The scatter is fitted anew with and without the term, to all specimens: of many that follow a term few need be
    replicates; of one that stands alone nothing is known but what the others scatter by. Where no two were tested
    alike they may scatter as those of one cloth do. Each term taken out has its odds against that scatter, below 1.
    """
    odds: dict[str, float] = {}
    while best.ids and (search.noise.gain_doubt or _none_alike(search)):
        whole, _ = likeliest_scatter(search, best, best)
        worth = {
            name: likeliest_scatter(search, search.without(best, name), best)[0] - whole - _of_each(best, name)
            for name in best.ids
        }
        weakest = min(worth, key=lambda name: worth[name])
        if worth[weakest] >= MARGIN:
            break
        odds[weakest] = float(np.exp(0.5 * (worth[weakest] - MARGIN)))
        best = search.without(best, weakest)
    return best, odds


@dataclass(frozen=True)
class Hidden:
    """A model with one term more that specimens which scatter may hide: what that is worth in likelihood, how much they
    scatter beside it, and without."""

    beside: Candidate
    worth: float
    scatter: float
    without: float


def with_hidden(search: Search, best: Candidate, most: int) -> tuple[Candidate, float]:
    """Return a model with the terms that specimens which scatter hide, and how much they scatter beside these.

    Few replicates may differ by chance as much as an effect makes others differ: noise as large as that asks for no
    name. Beside the term all specimens scatter by so much less that it is no chance, of as many entries.
    """
    scatter = np.inf
    while len(best.ids) < most:
        found = max(_hidden(search, best), key=lambda one: one.worth, default=None)
        if found is None or found.worth <= MARGIN + _choice(search):
            break
        best, scatter = found.beside, found.scatter
    return best, scatter


def perhaps_hidden(search: Search, best: Candidate) -> dict[str, tuple[float, float]]:
    """Return entries that the scatter of specimens hides by more than ``ODDS`` to one, though it may be chance, and how
    much these scatter beside each, and without."""
    least = 2.0 * float(np.log(ODDS)) + _choice(search)
    return {one.beside.ids[-1]: (one.scatter, one.without) for one in _hidden(search, best) if one.worth > least}


def _choice(search: Search) -> float:
    """Return what the likeliest of as many entries is ahead by chance, in minus twice the logarithm of likelihood."""
    return 2.0 * float(np.log(max(search.problem.sought, 1)))


def _hidden(search: Search, best: Candidate) -> list[Hidden]:
    """Return the terms that specimens scatter less beside, where it is known of few pairs how much they do."""
    found = []
    for effect, _ in search.ranking(best)[:_HIDDEN] if search.noise.gain_doubt else ():
        fitted = search.with_term(best, effect)
        if fitted is None:
            continue
        beside = search.state(fitted)
        (alone, wide), (whole, narrow) = (likeliest_scatter(search, one, beside) for one in (best, beside))
        if narrow < wide:
            found.append(Hidden(beside, alone - whole - _of_each(beside, effect.id), narrow, wide))
    return found


def _none_alike(search: Search) -> bool:
    """Whether nothing but what specimens of one cloth do tells how much these scatter, several of them."""
    return len(search.noise.groups) > 1 and not replicates(search.problem.curves)


def _of_each(state: Candidate, name: str) -> float:
    """Return what the constants of a term cost that has one for each specimen, as a stiffness of each would.

    In minus twice the logarithm of the likelihood: each is known from the rows of its specimen.
    """
    form = state.fit.forms[name]
    if not form.of_each:
        return 0.0
    count = len(form.each)
    return count * float(np.log(max(len(state.fit.residual) / count, 1.0)))


def likeliest_scatter(search: Search, state: Candidate, best: Candidate | None = None) -> tuple[float, float]:
    """Return minus twice the logarithm of a model's likelihood for the likeliest scatter of specimens, and that.

    What ``best`` (the model itself by default) leaves though every specimen has a stiffness of its own counts as noise.
    Beside it a few that follow a term by chance, or agree by chance, must not pass for ones that do not scatter: what
    is usual counts as two specimens more (a scaled inverse chi-squared distribution of the variance), and what the
    constants of ``best`` are told from counts no more (restricted likelihood).
    """
    # No larger than replicates allow: that specimens led alike agree says that others do not scatter by any amount.
    # Where none were, than one cloth does.
    most = TOLD * search.noise.gain_doubt or ONE_CLOTH
    scatters = [scatter for scatter in _SCATTERS if scatter <= most] or [most]
    problem, beside = search.problem, best or state
    # Of each kind of reading: what lacks in the contraction makes no stress less sure. It makes readings less sure, not
    # how stiff specimens are: each tells that by itself.
    widest = search.noise.among(beside.fit.predicted, scatters[-1])
    least = fitted_misfit(problem, widest, beside.fit)
    _, which, count = np.unique(problem.channel, return_inverse=True, return_counts=True)
    # As many rows as are missed alike count as one: else specimens would scatter by what makes up for a wrong law.
    left = widest.whiten(problem.measured - beside.fit.predicted)
    level = np.maximum(least / count, 1.0) * correlation_time(left, problem.curves)
    louder = replace(search.noise, sd=search.noise.sd * np.sqrt(level[which]))

    def metrics(one: Candidate) -> list[Noise]:
        return [louder.among(one.fit.predicted, scatter) for scatter in scatters]

    own = metrics(state)
    misfit, taken = stepped_misfits(problem, own, state.fit)
    surprise = misfit + np.array([metric.entropy for metric in own])
    if best is not None:
        variance = np.array(scatters) ** 2
        taken = taken if best is state else stepped_misfits(problem, metrics(best), best.fit)[1]
        surprise += CLOTH_COUNTS * (np.log(variance) + (0.5 * ONE_CLOTH) ** 2 / variance) - taken
    fitted: set[int] = set()
    while (likeliest := int(np.argmin(surprise))) not in fitted:
        # A step to first order promises more than a fit holds where specimens are far apart.
        fitted.add(likeliest)
        held = fitted_misfit(problem, own[likeliest], state.fit)
        surprise[likeliest] += float(held.sum()) - misfit[likeliest]
    return float(surprise[likeliest]), scatters[likeliest]


def scatter_of_one_cloth(search: Search, state: Candidate, best: Candidate) -> float:
    """Return the likeliest scatter beside a model of specimens of which no two were tested alike, 0 where two were.

    What ``best`` leaves counts as noise. So they are not where they differ by what they state of themselves.
    """
    alone = _none_alike(search) and not search.problem.ridden
    return likeliest_scatter(search, state, best)[1] if alone else 0.0


def without_names(search: Search, before: Candidate, doubted: bool) -> tuple[str, float]:
    """Return the verdict where nothing is named, and the scatter of specimens it rests on.

    It is noise if specimens that scatter more than was seen could be all there is: where effects were ``doubted`` for
    that, or where no two were tested alike and they scatter no more than those of one cloth do, and in no order that
    something they state would tell.
    """
    if before.judgement.is_small:
        return "noise", 0.0
    noise = search.noise
    if not noise.groups or search.problem.ridden or (replicates(search.problem.curves) and not doubted):
        return "unexplained", 0.0
    if any(off > 0.0 for off in search.problem.forbidden(before.fit.x, {}).values()):
        # What nature does not allow is not what is left once specimens scatter.
        return "unexplained", 0.0
    assumed = max(noise.gain_doubt, likeliest_scatter(search, before)[1])
    if assumed <= noise.gain_sd:
        # So much was noise to the judgement above, which looks at the stiffness of each specimen too.
        return "unexplained", 0.0
    scattered = noise.among(before.fit.predicted, assumed)
    off = scattered.stiffness(scattered.whiten(search.problem.measured - before.fit.predicted), SMALL)
    if float(chdtrc(len(off), off @ off)) < ALPHA:
        # They are few beside their readings, among which they would hide.
        return "unexplained", 0.0
    left = float(np.sum(fitted_misfit(search.problem, scattered, before.fit)))
    rows = len(before.fit.residual) - len(before.fit.x)
    small = np.sqrt(max(left / max(rows, 1) - 1.0, 0.0)) <= SMALL
    return ("noise", assumed) if small else ("unexplained", 0.0)
