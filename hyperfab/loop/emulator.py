"""A costly forward run as a smooth function of its settings, what is known between runs and beside them.

A polynomial goes through runs on a sparse grid around the model as it is, a Gaussian process through any runs.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array

#: Places of an axis in the order they are taken, of its whole reach; an axis of two sides and one of one side.
_TWO_SIDED = (0.0, 1.0, -1.0, 0.5, -0.5)
_ONE_SIDED = (0.0, 0.5, 1.0, 0.2, 0.8)
#: Places an axis has at each level.
_UPTO = (1, 3, 5)
#: Length of the correlation, in reaches of the axes: on sheets over balls and torsos 1 to 3 did equally well.
_LENGTH = 2.0
#: Variance of what constants of the model, at their reach, change of the effects, as a share of the effects'; and of
#: all that has no better place.
_TOGETHER, _REST = 0.3, 0.01
#: What keeps two runs at one place from contradicting each other, as a share of the variance.
_NUGGET = 1e-9


@dataclass(frozen=True)
class Axis:
    """One setting: at ``base`` the model is as it is; it reaches to ``base - down`` and ``base + up``, or one way
    alone: down, where ``up`` is below 0.

    ``level`` 1 is a parabola along the axis, 2 a quartic. Axes that ``mixes`` have biquadratic terms with each
    other, and bilinear ones with the rest.
    """

    name: str
    base: float
    up: float
    down: float = 0.0
    level: int = 2
    mixes: bool = True

    def places(self) -> list[float]:
        """Return the scaled places of the axis, in the order they are taken."""
        return list(_TWO_SIDED if self.down > 0.0 else _ONE_SIDED)[: _UPTO[self.level]]

    def value(self, scaled: float) -> float:
        """Return the setting at a scaled place."""
        return self.base + scaled * (self.up if scaled >= 0.0 else self.down)

    def scaled(self, value: Array) -> Array:
        """Return the scaled place of settings."""
        away = np.asarray(value) - self.base
        reach = np.where(away >= 0.0, self.up, self.down if self.down > 0.0 else self.up)
        return np.asarray(away / reach)


@dataclass(frozen=True)
class Emulator:
    """The polynomial: ``powers`` (t, d) of the scaled settings and ``coefficients`` (t, k)."""

    axes: tuple[Axis, ...]
    powers: Array
    coefficients: Array

    def __call__(self, settings: Array) -> Array:
        """Return the values (k,) at ``settings`` (d,), or (b, k) at b of them (b, d)."""
        columns = np.moveaxis(np.asarray(settings, dtype=np.float64), -1, 0)
        scaled = np.stack([axis.scaled(v) for axis, v in zip(self.axes, columns, strict=True)], axis=-1)
        return np.asarray(np.prod(scaled[..., None, :] ** self.powers, axis=-1) @ self.coefficients)


def emulate(
    run: Callable[[Array], Array],
    axes: Sequence[Axis],
    tick: Callable[[float], None] = lambda share: None,
) -> Emulator:
    """Run the model on a sparse grid of settings and return the polynomial through the results.

    Source of the grid: hierarchical interpolation on a lower set; A. Chkifa, A. Cohen and C. Schwab, Found. Comput.
    Math. 14 (2014) 601.

    >>> found = emulate(lambda s: np.array([1.0 + s[0] ** 2 * s[1]]), [Axis("a", 0.0, 2.0), Axis("b", 1.0, 1.0, 1.0)])
    >>> round(float(found(np.array([1.3, 0.7]))[0]), 9)
    2.183
    """
    numbers = _lower_set(axes)
    base = np.array([axis.base for axis in axes])
    results, scaled = [], []
    for count, number in enumerate(numbers):
        at = np.array([axis.places()[i] for axis, i in zip(axes, number, strict=True)])
        setting = base if not np.any(at) else np.array([a.value(v) for a, v in zip(axes, at, strict=True)])
        results.append(run(setting))
        scaled.append(at)
        tick((count + 1) / len(numbers))
    powers = np.array(numbers, dtype=np.float64).reshape(len(numbers), len(axes))
    matrix = np.prod(np.array(scaled).reshape(powers.shape)[:, None, :] ** powers[None, :, :], axis=2)
    return Emulator(tuple(axes), powers, np.linalg.solve(matrix, np.stack(results)))


def _lower_set(axes: Sequence[Axis]) -> list[tuple[int, ...]]:
    """Return the numbers of the places of each run: along each axis, and over the first three of two that mix."""
    none = (0,) * len(axes)
    found = [none]
    for i, axis in enumerate(axes):
        found += [(*none[:i], k, *none[i + 1 :]) for k in range(1, _UPTO[axis.level])]
    for i, j in itertools.combinations(range(len(axes)), 2):
        if not (axes[i].mixes or axes[j].mixes) or not (axes[i].level and axes[j].level):
            continue
        both = axes[i].mixes and axes[j].mixes
        for a, b in itertools.product((1, 2), repeat=2):
            # Between an effect and a constant of the model the bilinear term is enough.
            if both or (a, b) == (1, 1):
                number = list(none)
                number[i], number[j] = a, b
                found.append(tuple(number))
    return found


@dataclass(frozen=True)
class Kriged:
    """Values (t, k) of runs at the scaled ``sites`` (t, d) of the axes: the first, the ``base``; a parabola along each
    axis that does not mix, the model's own constants (``trend``, (2 d, k)); and a Gaussian process for the rest,
    ``weights`` (t, k) of the correlations with the sites.

    Effects and what constants change of them are zero where no effect is: so no constant can show what none did. The
    correlation is Matern's of order 5/2: C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine
    Learning (2006), eqs. 2.19, 2.42 and 4.17.
    """

    axes: tuple[Axis, ...]
    sites: Array
    values: Array
    trend: Array
    weights: Array

    def __call__(self, settings: Array) -> Array:
        """Return the values (k,) at ``settings`` (d,), or (b, k) at b of them (b, d)."""
        scaled = _scaled(self.axes, settings)
        near = _alike(self.axes, scaled, self.sites) @ self.weights
        return np.asarray(self.values[0] + _powers(scaled) @ self.trend + near)

    def with_runs(self, settings: Array, values: Array) -> Kriged:
        """Return the function that meets further runs too: ``values`` (r, k) at ``settings`` (r, d)."""
        sites = np.vstack([self.sites, _scaled(self.axes, settings)])
        return _through(self.axes, sites, np.vstack([self.values, values]), self.trend)


def krige(axes: Sequence[Axis], settings: Array, values: Array) -> Kriged:
    """Return the function through ``values`` (t, k) of runs at ``settings`` (t, d), the first at the base.

    >>> axes = [Axis("own", 1.0, 0.3, 0.3, mixes=False), Axis("a", 0.0, 1.0)]
    >>> at = np.array([[1.0, 0.0], [0.7, 0.0], [1.3, 0.0], *([1.0, a / 8.0] for a in range(1, 9))])
    >>> found = krige(axes, at, at[:, :1] ** 2 + np.sin(2.0 * at[:, 1:]))
    >>> bool(abs(found(np.array([1.1, 0.33]))[0] - 1.21 - np.sin(0.66)) < 1e-3)
    True
    """
    scaled = _scaled(axes, settings)
    trend = np.zeros((2 * len(axes), values.shape[1]))
    for i, axis in enumerate(axes):
        alone = np.flatnonzero((np.delete(scaled, i, axis=1) == 0.0).all(axis=1) & (scaled[:, i] != 0.0))
        if not axis.mixes and len(alone):
            rows = _powers(scaled[alone])[:, [i, len(axes) + i]]
            trend[[i, len(axes) + i]] = np.linalg.lstsq(rows, values[alone] - values[0], rcond=None)[0]
    return _through(tuple(axes), scaled, values, trend)


def _through(axes: tuple[Axis, ...], sites: Array, values: Array, trend: Array) -> Kriged:
    near = _alike(axes, sites, sites) + _NUGGET * np.eye(len(sites))
    left = values - values[0] - _powers(sites) @ trend
    return Kriged(axes, sites, values, trend, np.linalg.solve(near, left))


def _scaled(axes: Sequence[Axis], settings: Array) -> Array:
    columns = np.moveaxis(np.asarray(settings, dtype=np.float64), -1, 0)
    return np.stack([(v - axis.base) / axis.up for axis, v in zip(axes, columns, strict=True)], axis=-1)


def _powers(scaled: Array) -> Array:
    return np.concatenate([scaled, scaled**2], axis=-1)


def _alike(axes: Sequence[Axis], places: Array, sites: Array) -> Array:
    """Return the correlations (..., t) of scaled places (..., d) with the sites (t, d)."""
    own = np.array([not axis.mixes for axis in axes])
    here, there = places[..., ~own], sites[:, ~own]
    none = np.zeros((1, here.shape[-1]))
    effects = _matern(here, there) - _matern(here, none) * _matern(there, none)[:, 0]
    return np.asarray(effects * (1.0 + _TOGETHER * places[..., own] @ sites[:, own].T) + _REST * _matern(places, sites))


def _matern(places: Array, sites: Array) -> Array:
    away = np.sqrt(5.0 * np.sum((places[..., None, :] - sites) ** 2, axis=-1)) / _LENGTH
    return np.asarray((1.0 + away + away**2 / 3.0) * np.exp(-away))
