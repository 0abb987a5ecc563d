"""Noise by what a model leaves: louder than neighbours tell, or alike in them; told from single curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from hyperfab.arrays import Array
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve, Problem
from hyperfab.loop.replicates import moving, replicates
from hyperfab.loop.thresholds import FEWEST, MARGIN, MOST, TOLD

#: What is smooth along a way up or down is a polynomial of this degree at most, of one for so many readings.
_DEGREE, _EACH = 8, 5
#: Correlations of neighbours that are tried.
TRIED = np.round(np.arange(0.0, 0.95, 0.05), 2)


def wandering(problem: Problem, noise: Noise, left: Array, channel: int) -> Noise:
    """Return the noise with what neighbouring readings of a kind have in common, and as loud as it is, where that is
    clear and no replicates have told it.

    ``left`` (rows) is what a model leaves, or the readings where they are smooth themselves. What wanders by more than
    neighbours differ by is no effect: it does so in each test in another way, and faster than any law bends. Beside a
    polynomial along each way up or down it is an autoregression of first order, told by restricted likelihood
    (Patterson & Thompson 1971, doi:10.1093/biomet/58.3.545), in most of the curves. Where neighbours have nothing in
    common it may still be louder than they tell: of long tails most of their differences know nothing.
    """
    if replicates(problem.curves, channel):
        return noise
    own = problem.channel == channel
    curves = [curve for curve in problem.curves if curve.channel == channel]
    each = [one for curve in curves if (one := _likelihood(curve, left, noise.sd)) is not None]
    if not each:
        return noise
    rest, unlikely, free, rows, terms = (np.array(part) for part in zip(*each, strict=True))
    variance = rest.sum(axis=0) / free.sum()
    every = free.sum() * np.log(variance) + unlikely.sum(axis=0)
    # What reaches farther than such a polynomial bends is no longer told from it.
    best = int(np.argmin(np.where(np.exp(-terms.sum() / rows.sum()) >= TRIED, every, np.inf)))
    alone = free[:, None] * np.log(rest) + unlikely
    agree = free @ (alone[:, best] < alone[:, 0])
    if every[0] - every[best] >= MARGIN and agree >= MOST * free.sum():
        louder = variance[best]
    else:
        # By themselves readings that are far off are rare: half of the curves are as loud.
        level, best = rest[:, 0] / free, 0
        order = np.argsort(level)
        louder = level[order][np.searchsorted(np.cumsum(free[order]), 0.5 * free.sum())]
    if louder <= 1.0 + TOLD * np.sqrt(2.0 / free.sum() + 2.0 / noise.dof):
        return noise
    sd = np.where(own, np.sqrt(louder) * noise.sd, noise.sd)
    source = f"{noise.source}, neighbours alike" if channel == 0 and best else noise.source
    return replace(noise, sd=sd, correlation=np.where(own, TRIED[best], noise.correlation), source=source)


def _likelihood(curve: Curve, left: Array, sd: Array) -> tuple[Array, Array, int, int, int] | None:
    """Return, for each correlation that is tried, what polynomials leave of a curve (sum of squares, in units of the
    noise) and the rest of minus twice the logarithm of the likelihood; degrees of freedom, readings and terms."""
    ways = [piece for piece in moving(curve) if piece.stop - piece.start >= FEWEST]
    rest, unlikely, rows, terms = np.zeros(len(TRIED)), np.zeros(len(TRIED)), 0, 0
    for piece in ways:
        along = curve.places[piece.start - curve.start : piece.stop - curve.start]
        middle, half = 0.5 * (np.max(along) + np.min(along)), 0.5 * np.ptp(along) or 1.0
        count = len(along)
        smooth = chebvander((along - middle) / half, min(count // _EACH, _DEGREE))
        own, odds = restricted(smooth / sd[piece, None], left[piece] / sd[piece])
        rest, unlikely = rest + own, unlikely + odds
        rows, terms = rows + count, terms + smooth.shape[1]
    return (rest, unlikely, rows - terms, rows, terms) if ways and np.all(rest > 0.0) else None


def restricted(smooth: Array, values: Array) -> tuple[Array, Array]:
    """Return, for each correlation that is tried, what columns (n, k) leave of values (n,), as sum of squares, and the
    rest of minus twice the logarithm of the restricted likelihood."""
    both, rest, unlikely = np.column_stack([smooth, values]), np.empty(len(TRIED)), np.empty(len(TRIED))
    for j, rho in enumerate(TRIED):
        told = both.copy()
        told[1:] = (both[1:] - rho * both[:-1]) / np.sqrt(1.0 - rho**2)
        size = np.abs(np.diag(np.asarray(np.linalg.qr(told, mode="r"))))
        rest[j] = size[-1] ** 2
        unlikely[j] = (len(values) - 1) * np.log(1.0 - rho**2) + 2.0 * np.sum(np.log(size[:-1]))
    return rest, unlikely
