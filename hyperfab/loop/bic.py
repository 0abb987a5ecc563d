"""Models compared on one scale: chi-squared with the present misfit as noise, priors that count, and BIC of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hyperfab.loop.fitting import Fit
from hyperfab.loop.judge import correlation_time
from hyperfab.loop.problem import Problem


def common_bic(fits: Sequence[Fit], problem: Problem) -> Mapping[tuple[str, ...], float]:
    """Return BIC of several models, by their effects, on one scale: that of the best fit among them."""
    best = min(fits, key=lambda one: one.chi2)
    channel = problem.channel
    time = correlation_time(best.residual, problem.curves)
    count = max(len(best.residual) / time, 3.0)
    return {
        tuple(one.forms): (scaled_chi2(one, best, channel) + prior_misfit(one, best, problem)) / time
        + len(one.x) * float(np.log(count))
        for one in fits
    }


def prior_misfit(fitted: Fit, best: Fit, problem: Problem) -> float:
    """Return how far the constants are from what is known of them, as chi-squared, where that is to count.

    As with the readings, what ``best`` leaves counts as noise.
    """
    if not problem.well_known:
        return 0.0
    return max(fitted.cost - fitted.chi2, 0.0) / max(best.chi2 / len(best.residual), 1.0)


def scaled_chi2(fitted: Fit, best: Fit, channel: NDArray[np.int64]) -> float:
    """Return chi-squared with each channel's noise taken as no less than what ``best`` leaves there."""
    total = 0.0
    for which in np.unique(channel):
        rows = channel == which
        left = float(np.mean(best.residual[rows] ** 2))
        total += float(np.sum(fitted.residual[rows] ** 2)) / max(left, 1.0)
    return total
