"""Readings at scattered places: their noise from neighbours, and their order along a path through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import chdtrc

from hyperfab.arrays import Array, Ints
from hyperfab.loop.noise_estimate import ASSUMED, USUAL, third_differences, winsorised
from hyperfab.loop.problem import Curve
from hyperfab.loop.thresholds import FEWEST, MARGIN, UNLIKELY

#: Neighbours a plane is laid through.
_NEIGHBOURS = 9
#: Degrees of freedom that a usual noise counts for.
_KNOWN = 4.0
#: Two readings nearer than this share of the cloud's size are repeats of each other.
_SAME = 1e-6


@dataclass(frozen=True)
class Guess:
    """How loud readings seem: their standard deviation, its degrees of freedom, and where that is from.

    ``found`` (k,) are differences that have the variance of the noise, ``level`` (k,) the size of the readings there;
    None where noise in proportion to the reading is not asked for. ``rows`` (n,) is that of each reading, where they
    are not alike.
    """

    size: float
    dof: float
    source: str
    found: Array | None = None
    level: Array | None = None
    rows: Array | None = None

    @property
    def is_assumed(self) -> bool:
        """Whether nothing but what is usual stands behind it."""
        return self.source == ASSUMED

    def sized(self, ratio: float, top: float) -> float:
        """Return the constant part where noise in proportion is ``ratio`` times that at the reading ``top``."""
        if self.found is None or self.level is None or ratio == 0.0:
            return self.size
        return max(_size(self.found / np.hypot(1.0, ratio * self.level / top)), 1e-9 * top)


#: Noise in proportion to the reading, over the constant part at the largest; how many independent
#: differences one counts for.
_RATIOS, _WORTH = (0.0, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0), 0.4


def loudness(guesses: Sequence[Guess], top: float) -> tuple[Array, float]:
    """Return the constant part of each guess (n,), and how loud noise in proportion is at the reading ``top``, over it.

    Where the data do not decide between noise that is even and noise in proportion, each counts by its probability:
    what is taken for even has the largest readings drawn in, and they would be missed by more than noise.

    >>> y = np.linspace(1.0, 100.0, 200)
    >>> d = 0.01 * y * np.random.default_rng(0).standard_normal(200)
    >>> loudness([Guess(0.6, 80.0, "", d, y)], 100.0)[1] >= 10.0
    True
    >>> loudness([Guess(1.0, 80.0, "", d / y, y)], 100.0)[1] < 0.3
    True
    """
    ratios, chance = np.array(_RATIOS), likely_ratios(guesses, top)
    squares = np.array([[guess.sized(ratio, top) ** 2 for ratio in _RATIOS] for guess in guesses])
    mean = squares @ chance
    whole = float(np.sum(squares * ratios**2 @ chance))
    return np.sqrt(mean), float(np.sqrt(whole / max(np.sum(mean), 1e-300)))


def levels(measured: Array, group: Sequence[tuple[Ints, Guess]]) -> list[tuple[Ints, Array, float]]:
    """Return rows, standard deviation of each, and its degrees of freedom for files of one kind, by their guesses.

    Files whose noise differs by no more than chance have one.
    """
    every = np.concatenate([rows for rows, _ in group])
    top = float(np.max(np.abs(measured[every]), initial=0.0))
    sizes, ratio = loudness([guess for _, guess in group], top)
    dof = np.array([guess.dof for _, guess in group])

    def shaped(rows: Ints, size: float) -> Array:
        return np.asarray(size * np.hypot(1.0, ratio * measured[rows] / max(top, 1e-300)))

    if alike(sizes, dof):
        size = float(np.sqrt(np.average(sizes**2, weights=dof)))
        return [(every, shaped(every, size), float(dof.sum()))]
    return [(rows, shaped(rows, size), guess.dof) for (rows, guess), size in zip(group, sizes, strict=True)]


def alike(sizes: Array, dof: Array) -> bool:
    """Return whether standard deviations (n,), known with ``dof`` degrees of freedom, differ by no more than chance.

    Bartlett (1937), Proc. R. Soc. A 160, 268.

    >>> alike(np.array([1.0, 1.1, 0.9]), np.array([20.0, 20.0, 20.0]))
    True
    >>> alike(np.array([1.0, 5.0]), np.array([20.0, 20.0]))
    False
    """
    if len(sizes) < 2:
        return False
    whole = float(dof.sum())
    gap = whole * np.log(np.average(sizes**2, weights=dof)) - float(dof @ np.log(sizes**2))
    share = 1.0 + (float(np.sum(1.0 / dof)) - 1.0 / whole) / (3.0 * (len(sizes) - 1.0))
    return float(chdtrc(len(sizes) - 1.0, gap / share)) > UNLIKELY


def likely_ratios(guesses: Sequence[Guess], top: float) -> Array:
    """Return the probability of each of ``_RATIOS``: the first, even noise, is the likelier by ``MARGIN`` before."""
    even = np.eye(len(_RATIOS))[0]
    known = [(one.found, one.level) for one in guesses if one.found is not None and one.level is not None]
    if len(known) < len(guesses) or min((len(found) for found, _ in known), default=0) < FEWEST or top <= 0.0:
        return even
    misfits = []
    for ratio in _RATIOS:
        misfit = MARGIN * (ratio > 0.0)
        for found, level in known:
            shape = np.hypot(1.0, ratio * level / top)
            size = max(_size(found / shape), 1e-9 * top)
            left = np.minimum(np.abs(found) / (size * shape), 3.0)
            misfit += _WORTH * float(np.sum(2.0 * np.log(size * shape) + left**2))
        misfits.append(misfit)
    chance = np.exp(-0.5 * (np.array(misfits) - min(misfits)))
    return np.asarray(chance / chance.sum())


def guess_of_cloud(places: Array, values: Array, level: Array | None = None) -> Guess:
    """Return the noise of readings (n,) at ``places`` (n, d); ``level`` (n,) is their size where it is not their own.

    From repeats at the same place where there are six or more, else from what each reading misses the plane through
    its neighbours by.

    >>> x = np.random.default_rng(1).uniform(0.0, 1.0, (400, 2))
    >>> y = 3.0 * x[:, 0] + 0.1 * np.random.default_rng(2).standard_normal(400)
    >>> abs(guess_of_cloud(x, y).size - 0.1) < 0.02
    True
    """
    source = "neighbouring readings"
    size = float(np.max(np.ptp(places, axis=0), initial=0.0)) or 1.0
    level = np.abs(values) if level is None else level
    top = float(np.max(np.abs(values), initial=0.0)) or 1.0
    from scipy.spatial import cKDTree  # 0.08 s to load: tests of a fabric are curves, not scattered

    tree = cKDTree(places)
    pairs = tree.query_pairs(_SAME * size, output_type="ndarray")
    if len(pairs) >= 6:
        apart = (values[pairs[:, 0]] - values[pairs[:, 1]]) / np.sqrt(2.0)
        # The same file under two names is no measure of noise.
        spread = max(float(np.sqrt(np.mean(apart**2))), 1e-6 * top)
        return Guess(spread, float(len(pairs)), source, apart, 0.5 * (level[pairs[:, 0]] + level[pairs[:, 1]]))
    count = min(_NEIGHBOURS, len(values) - 1)
    if count < 5:
        return usual_noise(level)
    _, near = tree.query(places, count + 1)
    left = np.empty(len(values))
    for i, (mine, others) in enumerate(zip(near[:, 0], near[:, 1:], strict=True)):
        away = places[others] - places[mine]
        design = np.hstack([np.ones((count, 1)), _plan(away)])
        weights = np.linalg.pinv(design)[0]
        left[i] = (values[mine] - weights @ values[others]) / np.sqrt(1.0 + weights @ weights)
    return Guess(max(_size(left), 1e-6 * top), max(0.5 * len(values), 2.0), source, left, level[near[:, 0]])


def usual_noise(level: Array) -> Guess:
    """Return the noise that is taken of too few readings to tell, ``level`` (n,) being their size.

    Of what was read, never of what a model misses: a share of a misfit is less than the misfit whatever the model.
    It is known by so much that five times as loud an instrument, one of a tenth of its largest reading, is no chance.
    """
    return Guess(USUAL * (float(np.max(np.abs(level), initial=0.0)) or 1.0), _KNOWN, ASSUMED)


def _size(left: Array) -> float:
    """Return the standard deviation of differences, those far off drawn in: their rms."""
    return float(np.sqrt(np.mean(winsorised(left) ** 2)))


def _plan(away: Array) -> Array:
    """Return coordinates (k, 2) in the plane the neighbours lie in."""
    if away.shape[1] <= 2:
        return away
    _, _, axes = np.linalg.svd(away - away.mean(axis=0), full_matrices=False)
    return np.asarray(away @ axes[:2].T)


def patches(places: Array, most: int = 8, least: int = 12) -> list[Ints]:
    """Cut a cloud (n, d) into patches of neighbours, halving the widest; rows of each in order along a path.

    >>> [len(p) for p in patches(np.random.default_rng(0).uniform(0.0, 1.0, (96, 2)))]
    [12, 12, 12, 12, 12, 12, 12, 12]
    """
    found = [np.arange(len(places))]
    while len(found) < most:
        widths = [float(np.max(np.ptp(places[p], axis=0))) if len(p) >= 2 * least else -1.0 for p in found]
        widest = int(np.argmax(widths))
        if widths[widest] < 0.0:
            break
        part = found.pop(widest)
        axis = int(np.argmax(np.ptp(places[part], axis=0)))
        order = part[np.argsort(places[part, axis], kind="stable")]
        found += [order[: len(order) // 2], order[len(order) // 2 :]]
    return [_path(places, part) for part in found]


def _path(places: Array, rows: Ints) -> Ints:
    """Order rows so that each is near the one before: always on to the nearest that is left."""
    left = list(rows[np.argsort(places[rows, 0], kind="stable")])
    path = [left.pop(0)]
    while left:
        gaps = np.sum((places[left] - places[path[-1]]) ** 2, axis=1)
        path.append(left.pop(int(np.argmin(gaps))))
    return np.array(path, dtype=np.int64)


def guess_of_curve(
    values: Array,
    abscissa: Array,
    time_s: Array | None = None,
    level: Array | None = None,
    state: Array | None = None,
) -> Guess:
    """Return the noise of readings (n,) along a smooth curve; ``level`` (n,) is their size where it is not their own.

    Readings at one place of it, as where a press holds, are smooth in time where that is known. Those taken in turn at
    a few levels of a ``state`` (n,), as of a temperature, lie on a curve for each: what that does is no noise.
    """
    source = "local differences"
    order = np.lexsort((abscissa if time_s is None else time_s, abscissa))
    level = values if level is None else level
    groups = np.zeros(len(order)) if state is None else np.round(state[order])
    levels = np.unique(groups)
    if len(order) < FEWEST * len(levels):
        levels, groups = np.zeros(1), np.zeros(len(order))
    parts = [(order[groups == one], abscissa) for one in levels]
    if time_s is not None:
        same = np.diff(abscissa[order]) <= _SAME * max(float(np.ptp(abscissa)), 1e-12)
        starts = np.concatenate([[0], np.flatnonzero(~same) + 1, [len(order)]])
        parts += [(order[a:b], time_s) for a, b in pairwise(starts) if b - a > 4]
    found, sizes = [], []
    for rows, along in parts:
        curve = Curve("", 0, len(rows), along[rows])
        found.append(third_differences(values[rows], curve)[0])
        sizes.append(third_differences(level[rows], curve)[1])
    left = np.concatenate(found)
    top = float(np.max(np.abs(values), initial=0.0)) or 1.0
    if len(left) < 4:
        return usual_noise(level)
    return Guess(max(_size(left), 1e-6 * top), max(0.4 * len(left), 2.0), source, left, np.concatenate(sizes))
