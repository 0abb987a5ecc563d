"""From how sure inputs are to how sure results are: the law of propagation of uncertainty, and sampling.

Sources, each a vector of numbers that err together, are taken apart into independent directions of one standard
deviation each (the columns of a root of the covariance). What a result changes along each is its *effect*. Sources:
JCGM 100:2008 (GUM), 5 and annex G; JCGM 101:2008, 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from hyperfab.arrays import Array

#: Probability that an interval is to hold the value.
LEVEL = 0.95
#: Parts of a standard deviation by which the linear answer may be off: JCGM 101, 8.1, asks for half a unit of the last
#: of one or two figures that are told of it, between 0.05 and 0.5 of it with one.
NUMERICAL = 0.25
#: Results whose changes have this cosine or more go the same way.
_SAME_WAY = 0.9
#: Directions of a covariance with less than this part of its trace, scaled to correlations, are rounding.
_ROUNDING = 1e-12
_SEED = 20


@dataclass(frozen=True)
class Source:
    """Numbers that err together: ``covariance`` (k, k), known with ``freedom`` degrees of freedom.

    Where what makes them err comes in independent ``parts``, each is a covariance with degrees of freedom of its own.
    """

    name: str
    covariance: Array
    freedom: float = inf
    parts: tuple[tuple[Array, float], ...] = ()

    @cached_property
    def root(self) -> Array:
        """Independent directions of one standard deviation each (k, r): ``root @ root.T`` is the covariance.

        >>> Source("a", np.array([[4.0, 2.0], [2.0, 1.0]])).root.shape
        (2, 1)
        """
        return np.concatenate([root for root, _ in self.blocks], axis=1)

    @cached_property
    def blocks(self) -> tuple[tuple[Array, float], ...]:
        """The directions of each part, and its degrees of freedom."""
        parts = self.parts or ((self.covariance, self.freedom),)
        return tuple((_root(covariance), freedom) for covariance, freedom in parts)


def _root(covariance: Array) -> Array:
    sd = np.sqrt(np.diag(covariance))
    scale = np.where(sd > 0.0, sd, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = values > _ROUNDING * len(sd)
    found = (vectors[:, kept] * np.sqrt(values[kept]) * scale[:, None])[:, ::-1]
    # An eigenvector's sign is the library's choice.
    sign = np.sign(found[np.abs(found).argmax(axis=0), np.arange(found.shape[1])])
    return np.asarray(found * sign)


@dataclass(frozen=True)
class Band:
    """A result's standard deviation ``sd``, the interval ``low`` to ``high`` of LEVEL, and what share of the variance
    each source has, largest first."""

    sd: float
    low: float
    high: float
    budget: tuple[tuple[str, float], ...]


def directions(sources: Sequence[Source]) -> list[tuple[int, Array]]:
    """Return all independent directions: the number of the source, and its numbers' changes (k,)."""
    return [(number, column) for number, one in enumerate(sources) for column in one.root.T]


def linear(value: float, effects: Array, sources: Sequence[Source]) -> Band:
    """Return the band of a result from its ``effects`` along ``directions(sources)``.

    With few degrees of freedom the interval is that of Student's t with the effective number of them (Welch and
    Satterthwaite; JCGM 100, G.4).

    >>> one = Source("C10", np.array([[0.01]]), freedom=2.0)
    >>> band = linear(10.0, np.array([0.5]), [one])
    >>> round(band.sd, 3), round(band.low, 3), band.budget
    (0.5, 7.849, (('C10', 1.0),))
    """
    variance = _by_source(effects, sources)
    sd = float(np.sqrt(variance.sum()))
    half = _coverage(effects, sources) * sd
    return Band(sd, value - half, value + half, _budget(variance, sources))


def draws(sources: Sequence[Source], count: int) -> Array:
    """Return ``count`` draws (count, r) of independent standard normal numbers, one a direction, always the same.

    A Latin hypercube, turned so that its covariance is the unit matrix: what goes straight with the directions then has
    the deviation and the shares that it has to all orders, and none is taken for what several do together.
    """
    from scipy.special import ndtri

    width = len(directions(sources))
    # One number in each of as many parts of equal probability, their order another one in each direction.
    rng = np.random.default_rng(_SEED)
    parts = rng.permuted(np.tile(np.arange(count), (width, 1)), axis=1).T
    drawn = np.asarray(ndtri((parts + rng.random((count, width))) / count))
    if count <= width + 1:
        return drawn
    drawn -= drawn.mean(axis=0)
    root = np.linalg.cholesky(np.atleast_2d(np.cov(drawn, rowvar=False)))
    return np.asarray(np.linalg.solve(root, drawn.T).T)


def sampled(value: float, outcomes: Array, drawn: Array, sources: Sequence[Source]) -> Band:
    """Return the band of a result from its ``outcomes`` (count,) at ``drawn`` (count, r).

    The interval is between percentiles of the outcomes, moved apart from the value where few degrees of freedom ask for
    it; a source's share is that of the variance which goes linearly with it, and what goes with none is "together".
    """
    sd = float(np.std(outcomes, ddof=1))
    away = outcomes - outcomes.mean()
    effects, *_ = np.linalg.lstsq(drawn - drawn.mean(axis=0), away, rcond=None)
    wider = _coverage(effects, sources) / _coverage(np.zeros_like(effects), sources)
    explained = _by_source(effects, sources)
    # By chance an outcome that hangs on nothing goes a little with everything.
    explained *= min(1.0, sd**2 / max(explained.sum(), 1e-300))
    low, high = np.quantile(outcomes, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL])
    rest = max(sd**2 - float(explained.sum()), 0.0)
    return Band(
        sd,
        float(min(value, value + wider * (low - value))),
        float(max(value, value + wider * (high - value))),
        _budget(explained, sources, rest),
    )


class Spread:
    """Standard deviation of fields that come one after the other (Welford), and what of them goes with each of the
    ``directions`` that are drawn: these have the unit matrix as covariance."""

    def __init__(self, directions: int) -> None:
        self._count, self._mean, self._squares = 0, np.zeros(1), np.zeros(1)
        self._along: Array = np.zeros((directions, 1))

    def add(self, values: Array, draw: Array) -> None:
        """Take another one in."""
        self._count += 1
        away = values - self._mean
        self._mean = self._mean + away / self._count
        self._squares = self._squares + away * (values - self._mean)
        if len(self._along):
            self._along = self._along + draw[:, None] * values

    @property
    def along(self) -> Array:
        """What goes along each direction (r, n), one standard deviation on."""
        return self._along / max(self._count - 1, 1)

    @property
    def sd(self) -> Array:
        """Of those so far."""
        return np.sqrt(self._squares / max(self._count - 1, 1))


def _normal_end() -> float:
    """Return how many standard deviations off its mean the interval of a normal distribution ends."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + 0.5 * LEVEL))


def ends(effects: Mapping[str, Array]) -> list[Array]:
    """Return the places (r,), over standard deviations of each direction, where results are to be asked whether they go
    straight: both ends of the interval of each result, at the most probable place that has it there.

    Those of results that go nearly the same way stand for each other.

    >>> [place.round(2).tolist() for place in ends({"force": np.array([1.0, 0.0]), "work": np.array([2.0, 0.02])})]
    [[1.96, 0.0], [-1.96, -0.0]]
    """
    ways: list[Array] = []
    for along in effects.values():
        size = float(np.linalg.norm(along))
        if size > 0.0 and all(abs(along @ way) < _SAME_WAY * size for way in ways):
            ways.append(along / size)
    return [sign * _normal_end() * way for way in ways for sign in (1.0, -1.0)]


def bent(linear_sd: float, off: Array) -> bool:
    """Whether a result is too curved for the linear answer: ``off`` is by how much it leaves the straight line where
    that has an end of its interval.

    >>> bent(1.0, np.array([0.1, -0.1])), bent(1.0, np.array([0.0, 0.4]))
    (False, True)
    """
    return bool((np.abs(off) > NUMERICAL * linear_sd).any())


def curved(value: float, band: Band, low: float, high: float) -> Band:
    """Return the ``band`` of the linear answer with its ends where the result is there: ``low`` and ``high`` off the
    straight line at the ends of the normal distribution's interval, growing with the square of how far out.

    >>> band = curved(10.0, Band(1.0, 10.0 - 1.96, 10.0 + 1.96, ()), 0.1, 0.2)
    >>> round(band.low, 2), round(band.high, 2)
    (8.14, 12.16)
    """
    normal = _normal_end() * band.sd
    if normal == 0.0:
        return band
    further = ((band.high - value) / normal) ** 2
    return replace(band, low=min(value, band.low + further * low), high=max(value, band.high + further * high))


def bowed(value: float, band: Band, along: Array, bends: Array) -> Band:
    """Return the ``band`` of the linear answer with its ends on the parabola through two runs a direction, which leave
    the straight line by ``bends`` (r,) where ``along`` (r,) goes.

    A parabola that turns back within the interval tells of a turn or of a jump, not where: the interval is then as wide
    as both.

    >>> for bend in (0.1, 0.4):  # 0.1 and 0.4 times 1.96 squared
    ...     one = bowed(10.0, Band(1.0, 10.0 - 1.96, 10.0 + 1.96, ()), np.array([1.0]), np.array([bend]))
    ...     print(round(one.low, 2), round(one.high, 2))
    8.42 12.34
    8.04 13.5
    """
    away = _normal_end() ** 2 * float(along**2 @ bends) / max(float(along @ along), 1e-300)
    found = curved(value, band, away, away)
    if abs(away) <= 0.5 * _normal_end() * band.sd:
        return found
    return replace(found, low=min(found.low, band.low), high=max(found.high, band.high))


def off_by_bends(along: Array, bends: Array) -> float:
    """Return by how much a result leaves the straight line at the ends of its interval, where it leaves it by ``bends``
    (r,) one standard deviation along each direction: as a parabola along the result's own, by its mean along others.

    >>> round(off_by_bends(np.array([1.0, 0.0]), np.array([0.1, 0.2])), 2)  # 0.1 times 1.96 squared, and 0.2
    0.58
    """
    share = along**2 / max(float(along @ along), 1e-300)
    return float(np.sum(np.abs(bends) * (1.0 + (_normal_end() ** 2 - 1.0) * share)))


def differences(
    evaluate: Callable[[int, Array], Mapping[str, float]],
    value: Mapping[str, float],
    sources: Sequence[Source],
    step: float = 1.0,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return effects and bends of results by name, from two runs a direction, ``step`` standard deviations either way.

    ``evaluate`` takes the number of a source and what its numbers change by. What bends as a cube is in the effects by
    the square of the step: what goes with the inverse of a number known to 7 % comes out 0.5 % large with a step of 1.

    >>> one = [Source("power", np.array([[0.07**2]]))]
    >>> for step in (1.0, 0.25):
    ...     effects, bends = differences(lambda k, by: {"t": 1.0 / (1.0 + by[0])}, {"t": 1.0}, one, step)
    ...     print((effects["t"] / -0.07).round(4), bends["t"].round(4))
    [1.0049] [0.0049]
    [1.0003] [0.0049]
    """
    effects: dict[str, list[float]] = {name: [] for name in value}
    bends: dict[str, list[float]] = {name: [] for name in value}
    for number, column in directions(sources):
        up, down = evaluate(number, step * column), evaluate(number, -step * column)
        for name, middle in value.items():
            a, b = up.get(name, np.nan), down.get(name, np.nan)
            effects[name].append(0.5 * (a - b) / step)
            bends[name].append((0.5 * (a + b) - middle) / step**2)
    return ({name: np.array(found) for name, found in effects.items()},
            {name: np.array(found) for name, found in bends.items()})  # fmt: skip


def _coverage(effects: Array, sources: Sequence[Source]) -> float:
    """Return the half-width of the interval over the standard deviation."""
    from scipy.special import stdtrit

    blocks = [block for one in sources for block in one.blocks]
    each = np.split(effects**2, np.cumsum([root.shape[1] for root, _ in blocks])[:-1])
    variance = [float(own.sum()) for own in each]
    below = sum(v**2 / freedom for v, (_, freedom) in zip(variance, blocks, strict=True) if np.isfinite(freedom))
    if below <= 0.0:
        return _normal_end()
    return float(stdtrit(sum(variance) ** 2 / below, 0.5 + 0.5 * LEVEL))


def _by_source(effects: Array, sources: Sequence[Source]) -> Array:
    """Return the variance that goes along each source's directions."""
    owners = [number for number, _ in directions(sources)]
    return np.bincount(np.array(owners, dtype=int), weights=effects**2, minlength=len(sources)).astype(np.float64)


def _budget(variance: Array, sources: Sequence[Source], rest: float = 0.0) -> tuple[tuple[str, float], ...]:
    alone = float(variance.sum())
    rest = rest if rest > 1e-3 * (alone + rest) else 0.0  # so little is not told, and shares make up the whole
    total = alone + rest
    if total <= 0.0:
        return ()
    named = [(one.name, float(v) / total) for one, v in zip(sources, variance, strict=True)]
    named += [("together", rest / total)] if rest > 0.0 else []
    return tuple(sorted(named, key=lambda part: -part[1]))
