"""How large the noise is, what is alike in it, how well that is known: from replicates and neighbouring readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations

import numpy as np
from scipy.special import chdtrc, chdtri

from hyperfab.arrays import Array, Ints
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve, Problem
from hyperfab.loop.replicates import CLOTH_COUNTS, difference, is_set, moving, of_correlated, replicates, told_apart
from hyperfab.loop.thresholds import FEWEST, MACHINE, MARGIN, MOST, ONE_CLOTH, TOLD, UNLIKELY
from hyperfab.loop.wandering import TRIED, restricted, wandering

#: Of a normal distribution: standard deviation over median absolute deviation.
MAD = 1.4826
#: Smoothed third differences count for about this many independent readings each, their median for less.
_WORTH = 0.3
#: What is taken for noise where too few readings lie together to tell, of the largest of them, and what is said of it.
USUAL = 4.0 * MACHINE
ASSUMED = f"assumed: {100.0 * USUAL:g} % of the largest reading, for too few in a row to tell"
#: Ratios tried of the noise in proportion, at the largest reading, to that at zero; misfits that are hardly apart.
_RATIOS = (0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 30.0, 50.0, 100.0)
_HARDLY = 2.0
#: Specimens that scatter by less do not.
_ALIKE = 2e-3
#: Passes in which readings far off are drawn in: each is nearer to the fit without them.
_ROBUST = 3


def estimate_noise(problem: Problem, stated: float | None = None) -> Noise:
    """Return the noise of the measured rows.

    In this order: ``stated`` (one value for the first channel), the data's own standard deviations, the median of third
    differences along each smooth piece. Where curves are replicates of each other, their scatter is split into
    white noise, noise alike in neighbouring rows, and stiffness that differs from specimen to specimen.
    """
    y = problem.measured
    sd, dof, source, louder, raised = np.empty(len(y)), np.inf, "", np.ones(len(y)), np.ones(len(y))
    for channel in sorted({curve.channel for curve in problem.curves}):
        curves = [curve for curve in problem.curves if curve.channel == channel]
        rows = np.concatenate([np.arange(curve.start, curve.stop) for curve in curves])
        if stated is not None and channel == 0:
            sd[rows], how = stated, "stated"
        elif problem.stated_sd is not None and np.all(np.isfinite(problem.stated_sd[rows])):
            sd[rows], how = problem.stated_sd[rows], "standard deviations in the data"
        else:
            sd[rows], known, how, louder[rows] = _from_differences(y, curves, rows)
            dof = min(dof, known)
            if not replicates(problem.curves, channel):
                raised[rows] = np.maximum(problem.least_noise * _peaks(y, curves) / sd[rows], 1.0)
                sd[rows] *= raised[rows]
                if np.any(raised[rows] > 1.0):
                    how = f"{how}, {100.0 * problem.least_noise:g} % of each peak at least"
        source = source or how
    free = stated is None and problem.stated_sd is None
    sd, across_sd, rho = _across(problem, sd, louder)
    (groups, alike), (across, alike_across) = (_specimens(problem, channel) for channel in (0, 1))
    starts = tuple(curve.start for curve in problem.curves)
    plain = Noise(
        sd,
        dof,
        source,
        correlation=np.where(problem.channel == 1, rho, 0.0),
        across_sd=across_sd,
        starts=starts,
        groups=groups,
        across=across,
        alike=alike,
        alike_across=alike_across,
        pattern=np.where(problem.channel == 1, 1.0 - y, y),
        measured=y.copy(),
        least=problem.least_noise if free else 0.0,
        raised=float(np.min(raised)),
        common=problem.common,
        estimated=free,
    )
    if free:
        # No law bends a width as fast as it wanders; of stresses that is not known.
        plain = wandering(problem, plain, y, 1)
    return _with_replicates(problem, plain, louder, free)


def among_specimens(problem: Problem, noise: Noise) -> Noise:
    """Return the noise with how much specimens that were tested alike scatter in stiffness; as it is without such."""
    groups, alike = _specimens(problem, 0)
    if not groups:
        return noise
    y = problem.measured
    starts = tuple(curve.start for curve in problem.curves)
    told = replace(noise, starts=starts, groups=groups, alike=alike, pattern=y.copy(), measured=y.copy())
    found = _with_replicates(problem, told, np.ones_like(y), free=False)
    return found if found.gain_sd else noise


def _specimens(problem: Problem, channel: int) -> tuple[tuple[Ints, ...], tuple[tuple[int, ...], ...]]:
    """Return the rows of each specimen in a channel, and which of them were tested in each way."""
    curves = [curve for curve in problem.curves if curve.channel == channel and curve.specimen]
    groups: list[Ints] = []
    ways: dict[tuple[str, ...], list[int]] = {}
    for key in dict.fromkeys(curve.specimen for curve in curves):
        own = [curve for curve in curves if curve.specimen == key]
        ways.setdefault(tuple(sorted(curve.setup or key for curve in own)), []).append(len(groups))
        groups.append(np.concatenate([np.arange(curve.start, curve.stop) for curve in own]))
    return tuple(groups), tuple(tuple(one) for one in ways.values())


def _peaks(y: Array, curves: Sequence[Curve]) -> Array:
    """Return, row by row, the largest reading of its curve, of a transverse stretch how far it is from rest."""
    return np.concatenate(
        [np.full(c.stop - c.start, float(np.max(np.abs(y[c.rows] - (c.channel != 0)), initial=0.0))) for c in curves]
    )


def third_differences(y: Array, curve: Curve) -> tuple[Array, Array]:
    """Return normalised third differences along the smooth pieces of a curve, and the level where each was taken.

    They vanish on quadratics for any spacing and have the variance of the noise.
    """
    found, level = [np.empty(0)], [np.empty(0)]
    for piece in moving(curve):
        values, place = y[piece], curve.abscissa[piece.start - curve.start : piece.stop - curve.start]
        keep = np.concatenate([[True], np.abs(np.diff(place)) > 1e-12])
        values, place = values[keep], place[keep]
        if len(values) < 5:
            continue
        x = np.stack([place[i : len(place) - 3 + i] for i in range(4)])
        v = np.stack([values[i : len(values) - 3 + i] for i in range(4)])
        weights = np.ones_like(x)
        for i, j in permutations(range(4), 2):
            gap = x[i] - x[j]
            weights[i] /= np.where(np.abs(gap) > 1e-12, gap, 1e-12)
        weights /= np.sqrt(np.sum(weights**2, axis=0))
        found.append(np.sum(weights * v, axis=0))
        level.append(np.mean(np.abs(v), axis=0))
    return np.concatenate(found), np.concatenate(level)


def _from_differences(y: Array, curves: Sequence[Curve], rows: Array) -> tuple[Array, float, str, Array | float]:
    """Return sd = sqrt(a^2 + (b y)^2) of each row, b only where the data ask for it, its degrees of freedom and source,
    and by how much it is louder than in all curves.

    Of too few readings in a row to tell, a usual one is taken, and said to be.
    """
    parts = [third_differences(y, curve) for curve in curves]
    found = np.concatenate([part[0] for part in parts])
    level = np.concatenate([part[1] for part in parts])
    size = float(np.max(np.abs(y[rows]), initial=0.0)) or 1.0
    told = [y[curve.rows] for curve in curves if not is_set(y[curve.rows])]
    floor = max(rounding(np.concatenate([np.empty(0), *told])), 1e-9 * size)
    if len(found) < 4:
        return np.full(len(rows), max(USUAL * size, floor)), 2.0, ASSUMED, 1.0
    edges = np.cumsum([len(part[0]) for part in parts])[:-1]
    tried = []
    for ratio in _RATIOS:
        shape = np.sqrt(1.0 + (ratio * level / size) ** 2)
        scaled = np.abs(found) / shape
        a = max(MAD * float(np.median(scaled)), floor)
        alike = np.ones(len(parts))
        for each in (alike, _of_each(np.split(scaled / a, edges))):
            spread = a * np.repeat(each, [len(part[0]) for part in parts])
            # Winsorised: a corner the pieces do not know of must not speak for a louder noise.
            misfit = 2.0 * float(np.sum(np.log(spread * shape)))
            misfit += float(np.sum(np.minimum(scaled / spread, 3.0) ** 2))
            misfit += MARGIN * ((ratio > 0.0) + (0 if each is alike else len(parts) - 1))
            tried.append((misfit, a, a * ratio / size, each))
    # Of what the data hardly tell apart, the least in proportion: rows near zero must not pass for surer than they are.
    least = min(misfit for misfit, *_ in tried)
    a, b, louder = next(one[1:] for one in tried if one[0] <= least + _HARDLY)
    sd = np.sqrt(a**2 + (b * y[rows]) ** 2)
    times = np.concatenate([np.full(c.stop - c.start, one) for c, one in zip(curves, louder, strict=True)])
    return np.maximum(sd * times, floor), max(_WORTH * len(found), 2.0), "local differences", times


def _of_each(scaled: Sequence[Array]) -> Array:
    """Return by how much the noise of each curve is louder than that of all, 1 where they do not clearly differ.

    Machines read some tests in other ranges, or with a noise in proportion to the peak. The levels are drawn together
    by what they scatter by chance (James and Stein).
    """
    worth = np.array([_WORTH * len(one) for one in scaled])
    level = np.array([MAD * float(np.median(one)) if len(one) >= FEWEST else 0.0 for one in scaled])
    known = level > 0.0
    factor = np.ones(len(scaled))
    if np.count_nonzero(known) < 2:
        return factor
    size, weight = np.log(level[known]), 2.0 * worth[known]
    middle = float(np.average(size, weights=weight))
    apart, free = float(weight @ (size - middle) ** 2), len(size) - 1
    if chdtrc(free, apart) > UNLIKELY:
        return factor
    between = max(apart / free - 1.0, 0.0) / float(np.mean(weight))
    kept = between / (between + 1.0 / weight)
    factor[known] = np.exp(middle + kept * (size - middle))
    factor[~known] = np.exp(middle)
    return factor


def rounding(values: Array) -> float:
    """Return the standard deviation of what rounding to the digits that readings (n,) are told in takes from them: no
    reading is surer, though those of a smooth surface near each other are rounded alike.

    >>> round(12.0**0.5 * rounding(np.array([3.0, 1.0, 1.0, 7.0])), 6), rounding(np.array([0.1, 0.2, 0.37123]))
    (2.0, 0.0)
    """
    sizes = np.diff(np.unique(values))
    sizes = sizes[sizes > 1e-12 * np.max(np.abs(values), initial=1e-300)]
    if len(sizes) == 0:
        return 0.0
    step = float(np.min(sizes))
    even = np.allclose(sizes / step, np.round(sizes / step), atol=1e-3)
    return step / float(np.sqrt(12.0)) if even else 0.0


@dataclass(frozen=True)
class _Compared:
    """What pairs of replicates differ by, in units of the noise (pairs,): the square of the gain, less what chance
    makes of it, and less what a doubt does.

    Of the rest, for each correlation of neighbours that is tried (pairs, tried): ``rests`` is half its sum of squares,
    ``unlikely`` the rest of minus twice the logarithm of its likelihood, ``free`` (pairs,) its degrees of freedom;
    ``expected`` (pairs, tried, 2) are its variance, and what neighbours of it have in common, were that the correlation
    of noise of unit variance. ``count`` readings were compared; ``misfit`` is minus twice the logarithm of their
    likelihood with one level of noise in all pairs.
    """

    gains: Array
    sure: Array
    rests: Array
    unlikely: Array
    free: Array
    expected: Array
    count: int
    misfit: float

    @cached_property
    def correlation(self) -> float:
        """Between neighbouring rows of one curve, where it is clearly one: by restricted likelihood."""
        alone = self.free[:, None] * np.log(self.rests + 1e-300) + self.unlikely
        every = np.sum(alone, axis=0)
        best = int(np.argmin(every))
        # Interpolating one replicate onto the other correlates a little: that claims nothing. Nor does one pair that
        # differs as a smooth curve does, beside others that do not.
        clear = float(np.interp(self._alike[0], TRIED, every)) - every[best] > TOLD**2
        clear = clear and self.free @ (alone[:, best] < alone[:, 0]) >= MOST * np.sum(self.free)
        return float(np.interp(TRIED[best], self._alike, TRIED)) if clear and TRIED[best] > self._alike[0] else 0.0

    def times(self, dof: float) -> float:
        """Return how many times the variance, known with ``dof``, that of the readings is, 1 where not clearly more."""
        lag = float(np.interp(self.correlation, TRIED, self._alike))
        left, one = (
            np.array([float(np.interp(x, TRIED, row)) for row in rows])
            for x, rows in ((lag, self.rests), (self.correlation, self.expected[..., 0]))
        )
        times = float(np.mean(left / self.free / one))
        return times if times > 1.0 + TOLD * np.sqrt(2.0 / self.count + 2.0 / dof) else 1.0

    @property
    def _alike(self) -> Array:
        """What neighbours differ by alike, for each correlation of the readings."""
        return np.asarray(np.mean(self.expected[..., 1] / self.expected[..., 0], axis=0))


def _compared(problem: Problem, sd: Array, channel: int) -> _Compared | None:
    found, of_rest, expected = [], [], []
    for first, second in replicates(problem.curves, channel):
        apart, level, slope, spread, between = difference(problem.measured, sd, first, second)
        if len(apart) < FEWEST:
            continue
        # A transverse stretch is in proportion to how much narrower the specimen becomes.
        shapes = (level / spread, (1.0 / spread, slope / spread)) if channel == 0 else ((1.0 - level) / spread, ())
        apart = apart / spread
        values = apart
        for _ in range(_ROBUST):
            coefficients, variance, left = told_apart(values, *shapes)
            # A spike in one of them is neither its stiffness nor noise of all.
            values = values - left + winsorised(apart - values + left)
        gain = float(coefficients[0]) ** 2 / 2.0
        found.append((gain - variance, gain - TOLD**2 * variance, len(values), 2.0 * float(np.sum(np.log(spread)))))
        # How they may have been mounted is no noise of readings, though it is not told from their stiffness.
        smooth = np.stack([shapes[0], *shapes[1]], axis=1)
        rest, unlikely = restricted(smooth, values)
        of_rest.append((0.5 * rest, unlikely, np.full(len(TRIED), len(values) - smooth.shape[1])))
        expected.append([of_correlated(between, float(rho)) for rho in TRIED])
    if not found:
        return None
    gains, sure, counts, likely = np.array(found).T
    rests, unlikely, free = np.array(of_rest).transpose(1, 0, 2)
    misfit = float(np.sum(likely) + np.sum(counts) * np.log(np.sum(rests[:, 0]) / np.sum(free[:, 0]) + 1e-300))
    return _Compared(gains, sure, rests, unlikely, free[:, 0], np.array(expected), int(np.sum(counts)), misfit)


def _likelier(problem: Problem, sd: Array, louder: Array, channel: int) -> tuple[_Compared | None, Array]:
    """Return what replicates of a channel differ by, and the noise that is compared with.

    Whether that is ``louder`` in some curves than in others, as neighbouring readings have it, is for what replicates
    differ by to tell: steps of a hand are no noise.
    """
    own = problem.channel == channel
    found = _compared(problem, sd, channel)
    if found is None or np.all(louder[own] == 1.0):
        return found, sd
    evenly = np.where(own, sd / louder, sd)
    even = _compared(problem, evenly, channel)
    specimens = {curve.specimen for curve in problem.curves if curve.channel == channel and curve.specimen}
    if even is not None and even.misfit < found.misfit + MARGIN * (len(specimens) - 1):
        return even, evenly
    return found, sd


def _with_replicates(problem: Problem, noise: Noise, louder: Array, free: bool) -> Noise:
    """Compare replicates: scatter of stiffness between specimens, correlated noise, and a white level if ``free``."""
    found, sd = _likelier(problem, noise.sd, louder if free else np.ones_like(louder), 0)
    if found is None:
        return noise
    noise = noise if sd is noise.sd else replace(noise, sd=sd)
    gain_sd = float(np.sqrt(max(float(np.mean(found.gains)), 0.0)))
    doubt = _at_most(found.sure)
    rho, count = found.correlation, found.count
    times = found.times(noise.dof)
    sd, dof = noise.sd, noise.dof
    if free and times > 1.0:
        # What stresses differ by tells nothing of other readings.
        sd = np.where(problem.channel == 0, sd * np.sqrt(times), sd)
    dof = min(dof, max(count * (1.0 - rho) / (1.0 + rho), 2.0)) if free and rho else dof
    if gain_sd < _ALIKE and not rho and sd is noise.sd:
        return noise
    return replace(
        noise,
        sd=sd,
        dof=dof,
        source=noise.source if not free else "replicates and local differences",
        gain_sd=gain_sd if gain_sd >= _ALIKE else 0.0,
        gain_doubt=doubt if gain_sd >= _ALIKE else 0.0,
        correlation=np.where(problem.channel == 0, rho, noise.correlation),
    )


def _at_most(squares: Array) -> float:
    """Return what specimens scatter by at most (19 of 20), from ``squares`` of what pairs of them differ by; 0 where
    none differ.

    A pair that agrees by chance says little of the others, and what is usual of one cloth counts beside it: a scaled
    inverse chi-squared distribution of the variance (Gelman et al., Bayesian Data Analysis, 2.6).

    >>> [round(_at_most(np.full(count, 0.03**2)), 3) for count in (1, 4, 40)]
    [0.078, 0.054, 0.036]
    """
    if np.mean(squares) <= 0.0:
        return 0.0
    usual = CLOTH_COUNTS * (0.5 * ONE_CLOTH) ** 2
    return float(np.sqrt((usual + np.sum(squares)) / chdtri(CLOTH_COUNTS + len(squares), 0.95)))


def winsorised(left: Array) -> Array:
    """Return differences, those beyond three median deviations taken as three."""
    most = 3.0 * MAD * float(np.median(np.abs(left)))
    return np.clip(left, -most, most)


def _across(problem: Problem, sd: Array, louder: Array) -> tuple[Array, float, float]:
    """Return the noise with that of the transverse stretch as its replicates have it, how much specimens scatter in
    what they become narrower by (relative), and how neighbouring rows of it correlate."""
    found, sd = _likelier(problem, sd, louder, 1)
    if found is None:
        return sd, 0.0, 0.0
    scatter = float(np.sqrt(max(float(np.mean(found.gains)), 0.0)))
    rho = found.correlation
    wider = np.sqrt(found.times(np.inf))
    return np.where(problem.channel == 1, sd * wider, sd), scatter if scatter >= _ALIKE else 0.0, rho
