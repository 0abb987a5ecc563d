"""Which curves were led the same way, and what two of them differ by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.special import chdtrc, stdtr

from hyperfab.arrays import Array, Ints
from hyperfab.loop.fitting import Fit
from hyperfab.loop.problem import Curve
from hyperfab.loop.thresholds import ALPHA, FEWEST, ONE_CLOTH, TOLD, UNLIKELY, clearly
from hyperfab.materials.effects.path import REVERSAL
from hyperfab.numerics.gram import inverse
from hyperfab.numerics.hygiene import sides, turns

#: Specimens that what is usual of one cloth counts for, beside those that were compared.
CLOTH_COUNTS = 2.0
#: A load was set where it has more rows than this for each of its few values: a weight hung on, and the clock read.
_HUNG = 4


def is_set(values: Array) -> bool:
    """Whether the loads of a test (n,) were set, not read: so few values, each row after row, are weights hung on it,
    and their steps no last digit.

    >>> is_set(np.repeat([0.0, 0.1, 0.2], [1, 40, 40])), is_set(np.round(np.linspace(0.0, 1.0, 60), 1))
    (True, False)
    """
    count = len(np.unique(values))
    return count < FEWEST and _HUNG * count < len(values)


def pulls(curves: Sequence[Curve]) -> list[Curve]:
    """Return the curves of the first channel that were read; where no set-up is told each has its own."""
    read = [curve for curve in curves if curve.channel == 0 and not curve.beforehand]
    return [replace(curve, setup=curve.setup or str(k)) for k, curve in enumerate(read)]


def replicates(curves: Sequence[Curve], channel: int = 0) -> list[tuple[Curve, Curve]]:
    """Return pairs of curves that were led the same way."""
    setups: dict[str, list[Curve]] = {}
    for curve in curves:
        if curve.setup and curve.channel == channel:
            setups.setdefault(curve.setup, []).append(curve)
    return [pair for members in setups.values() for pair in pairwise(members)]


def ride(groups: Sequence[tuple[Array, Array]], tried: int) -> bool:
    """Whether what specimens led alike differ by in stiffness rides on a number that each of them states.

    ``groups`` are its values (k,) and the logarithm of the stiffness (k,) of those that were led alike; it is one of so
    many numbers that are ``tried``. Its order counts, as nobody knows how a law of it bends. What is usual of one cloth
    counts for two specimens more, so that a few that scatter little do not follow it by chance: a t-test, whose
    variance has a scaled inverse chi-squared distribution.

    >>> wet, softer = np.array([30.0, 50.0, 70.0, 90.0]), np.log([1.0, 0.94, 0.87, 0.72])
    >>> ride([(wet, softer)], 1), ride([(wet, softer[[1, 3, 0, 2]])], 1), ride([(wet, 0.1 * softer)], 1)
    (True, False, False)
    """
    ranks, logs, free = [], [], -1.0
    for values, stiffness in groups:
        known = np.isfinite(values) & np.isfinite(stiffness)
        order = np.unique(values[known], return_inverse=True)[1]
        ranks.append(order - order.mean() if len(order) else np.empty(0))
        logs.append(stiffness[known] - stiffness[known].mean() if len(order) else np.empty(0))
        free += max(len(order) - 1, 0)
    order, apart = np.concatenate(ranks), np.concatenate(logs)
    if free < CLOTH_COUNTS or not np.any(order):
        return False
    taken = float(order @ apart) ** 2 / float(order @ order)
    left = CLOTH_COUNTS * (0.5 * ONE_CLOTH) ** 2 + float(apart @ apart) - taken
    t = np.sqrt(taken * (CLOTH_COUNTS + free) / left)
    return bool(2.0 * tried * stdtr(CLOTH_COUNTS + free, -t) < ALPHA)


def told_apart(apart: Array, level: Array, others: Sequence[Array]) -> tuple[Array, float, Array]:
    """Return the coefficients of what two replicates differ by, the variance of the first, and what is left.

    They differ in stiffness; or, where that explains it much better, also by an offset of the load cell or by slack.
    Those are for the loop to find: as noise they would hide.
    """

    def least(columns: Sequence[Array]) -> tuple[Array, Array, Array]:
        matrix = np.stack(columns, axis=1)
        inverse = np.asarray(np.linalg.pinv(matrix.T @ matrix, hermitian=True), dtype=np.float64)
        coefficients = inverse @ (matrix.T @ apart)
        return coefficients, inverse, apart - matrix @ coefficients

    found = stiffer = least([level])
    if others:
        best = min(((*least([other]), other) for other in others), key=lambda one: float(one[2] @ one[2]))
        if float(stiffer[2] @ stiffer[2]) - float(best[2] @ best[2]) > clearly():
            found = least([level, best[3]])
    return found[0], float(found[1][0, 0]), found[2]


def difference(y: Array, sd: Array, first: Curve, second: Curve) -> Array:
    """Return the second replicate minus the first at the second's places, their level, slope and mean sd there, and
    between which readings of the first that is, as a number of rows and a part of one, (5, places)."""
    found = [np.empty((5, 0))]
    for one, other in _paired(first, second):
        if len(one) == 0:
            continue
        x1, x2 = first.places[one - first.start], second.places[other - second.start]
        order = np.argsort(x1, kind="stable")
        inside = (x2 >= x1[order[0]]) & (x2 <= x1[order[-1]])
        there = np.interp(x2[inside], x1[order], y[one][order])
        level = (y[other][inside] + there) / 2.0
        # Of both, so that half the square of their difference is one.
        both = np.sqrt((sd[other][inside] ** 2 + np.interp(x2[inside], x1[order], sd[one][order] ** 2)) / 2.0)
        between = np.interp(x2[inside], x1[order], np.arange(len(order), dtype=np.float64)) + float(one[0])
        found.append(np.stack([y[other][inside] - there, level, _slope(x2[inside], level), both, between]))
    return np.concatenate(found, axis=1)


def of_correlated(between: Array, rho: float) -> tuple[float, float]:
    """Return the variance of what two replicates differ by, half of it, and what neighbours of it have in common, where
    the noise is an autoregression of first order of unit variance.

    ``between`` (n,) is where the first was read, in rows and parts of one: a mean of two readings is quieter than one,
    and neighbours that lie between the same two have them in common.

    >>> of_correlated(np.arange(9.0), 0.0)
    (1.0, 0.0)
    >>> of_correlated(np.arange(9.0) + 0.5, 0.0)
    (0.75, 0.125)
    """
    row = np.floor(between)
    part = between - row
    nodes = ((row, 1.0 - part), (row + 1.0, part))

    def common(lag: int) -> float:
        ahead, behind = slice(lag, None), slice(None, len(row) - lag)
        of_first = sum(
            w[ahead] * v[behind] * np.power(rho, np.abs(i[ahead] - j[behind])) for i, w in nodes for j, v in nodes
        )
        return 0.5 * (rho**lag + float(np.mean(of_first)))

    return common(0), common(1)


def moving(curve: Curve) -> list[slice]:
    """Return the smooth pieces of a curve without those in which its place stands still, unless it moves between them.

    What relaxes while a stretch is held is steep at first: differences of such readings are no noise.
    """
    pieces = curve.pieces()
    ways = [float(np.ptp(curve.places[one.start - curve.start : one.stop - curve.start])) for one in pieces]
    reach = float(np.ptp(curve.places)) if len(curve.places) else 0.0
    going = [one for one, way in zip(pieces, ways, strict=True) if way > 1e-3 * reach]
    # Pulled step by step, all but a few readings are taken in waits; one that waits throughout goes nowhere.
    return going if sum(ways) >= 0.5 * reach > 0.0 else pieces


def _paired(first: Curve, second: Curve) -> list[tuple[Ints, Ints]]:
    """Return the rows of both on each way that both were led."""
    ones, others = _ways(first), _ways(second)
    begins, begins_too = (sides(curve.places, REVERSAL)[:1] for curve in (first, second))
    if not np.array_equal(begins, begins_too):
        # Of one of them none of the first way was read: that which turns less often.
        ones, others = (ones[1:], others) if len(ones) >= len(others) else (ones, others[1:])
    return list(zip(ones, others, strict=False))


def _ways(curve: Curve) -> list[Ints]:
    """Return the rows of each way of a curve up or down, without the waits on it: another specimen waits elsewhere.

    Without that at which it turned, too: read before the turn or after it, there is no telling.
    """
    going = np.zeros(len(curve.places), dtype=bool)
    for piece in moving(curve):
        going[piece.start - curve.start : piece.stop - curve.start] = True
    ways = turns(curve.places, REVERSAL)
    for way in ways[:-1]:
        going[way.stop - 1] = False
    return [curve.start + way.start + np.flatnonzero(going[way]) for way in ways]


def _slope(place: Array, value: Array) -> Array:
    """Return the slope of a smooth piece of a curve, by a cubic through all of it."""
    if len(place) < 8 or np.ptp(place) == 0.0:
        return np.zeros_like(value)
    scaled = (place - place[0]) / np.ptp(place)
    cubic = np.polynomial.Polynomial.fit(scaled, value, 3)
    return np.asarray(cubic.deriv()(scaled) / np.ptp(place))


def is_of_few(fitted: Fit, name: str, curves: Sequence[Curve]) -> bool:
    """Whether fewer than half of the specimens differ in a term that gives each of them a constant.

    What one or two of them have is what the model lacks there, not an effect of its own; unless they differ from those
    that were led alike.
    """
    start = fitted.place(name).start
    place = slice(start, start + len(fitted.forms[name].each))
    scale = np.sqrt(max(fitted.chi2 / max(len(fitted.residual) - len(fitted.x), 1), 1.0))
    # Each further one is told by what it has more than the first: what all have may be known far worse.
    of = np.eye(place.stop - place.start)
    of[1:, 0] = 1.0
    values, covariance = of @ fitted.x[place], scale**2 * of @ fitted.covariance[place, place] @ of.T
    led = np.array([curve.setup for curve in pulls(curves)])
    alike = led[:, None] == led
    about = np.eye(len(values)) - alike / alike.sum(axis=1)
    apart = about @ values
    free = len(values) - len({*led})
    odd = float(apart @ inverse(about @ covariance @ about.T, 1e-9) @ apart)
    if free and chdtrc(free, odd) < UNLIKELY:
        return False
    order = np.argsort(values)
    about = np.eye(len(values))
    about -= about[order[(len(order) - 1) // 2 : len(order) // 2 + 1]].mean(axis=0)
    sd = np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", about, covariance, about), 0.0))
    odd = np.abs(about @ values) > TOLD * sd
    return bool(np.count_nonzero(odd) < 0.5 * len(values))
