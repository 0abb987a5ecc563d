"""The measurement that would tell the rivals apart, found from the models and the noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Extra, Problem
from hyperfab.loop.thresholds import clearly

_MOST_RIVALS = 3
#: A law that foretells so many times the largest reading foretells nothing: it was carried beyond its range.
_ABSURD = 1e3


@dataclass(frozen=True)
class NextMeasurement:
    """A test to do next: what to do, and how far apart the rivals' predictions then are.

    ``misfit`` is the smallest chi-squared of a rival refitted to another's prediction of the old and the new data.
    """

    text: str
    details: Mapping[str, Any]
    misfit: float

    @property
    def decisive(self) -> bool:
        """Whether it would settle the matter against the present noise."""
        return self.misfit >= clearly()


def next_measurement(problem: Problem, noise: Noise, fits: Sequence[Fit]) -> list[NextMeasurement]:
    """Return the possible tests, the most telling first, for two or more fitted rivals (the best first)."""
    chosen = list(fits)[:_MOST_RIVALS]
    if len(chosen) < 2:
        return []
    found = [
        NextMeasurement(extra.text, extra.details, _smallest_misfit(extra, noise, chosen, problem.measured))
        for extra in problem.extras()
    ]
    return sorted(found, key=lambda one: -one.misfit)


def _smallest_misfit(extra: Extra, noise: Noise, fits: Sequence[Fit], measured: Array) -> float:
    smallest, most = np.inf, _ABSURD * float(np.abs(measured).max())
    for i, truth in enumerate(fits):
        target = extra.problem.predict(truth.x[: truth.own], truth.terms)
        if not np.all(np.abs(target) < most):
            return 0.0
        wider = _extended(noise, target, len(measured), extra.problem)
        # The best against each other, both ways; two losers need not be told apart.
        for rival in fits[:1] if i else fits[1:]:
            again = fit(extra.problem, wider, dict(rival.forms), rival.x, data=target, iterations=6)
            smallest = min(smallest, again.chi2)
    return float(smallest)


def _extended(noise: Noise, target: Array, old: int, problem: Problem) -> Noise:
    """Return the noise with the rows of the new test added: as loud as the old ones, a specimen of its own."""
    new = np.arange(old, len(target))
    stress, own = problem.channel[:old] == 0, np.broadcast_to(noise.correlation, old)
    sd = np.concatenate([noise.sd, np.full(len(new), float(np.median(noise.sd[stress])))])
    common = np.pad(noise.common, ((0, len(new)), (0, 0))) if noise.common.size else noise.common
    if not (noise.gain_sd or noise.across_sd or noise.is_correlated):
        return replace(noise, sd=sd, common=common)
    return replace(
        noise,
        sd=sd,
        common=common,
        correlation=np.append(own, np.full(len(new), np.max(own[stress]))),
        starts=tuple(curve.start for curve in problem.curves),
        groups=(*noise.groups, new),
        pattern=np.concatenate([noise.pattern, target[old:]]),
        measured=np.concatenate([noise.measured, target[old:]]),
    )
