"""A costly forward run as a smooth function through runs at chosen settings: what is known between them, and beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.loop.emulator import Axis
from hyperfab.loop.problem import Array

#: Length of the correlation, in reaches of the axes: on sheets over balls and torsos 1 to 3 did equally well.
_LENGTH = 2.0
#: What keeps two runs at one place from contradicting each other, as a share of the variance.
_NUGGET = 1e-9


@dataclass(frozen=True)
class Kriged:
    """Values (t, k) of runs at the scaled ``sites`` (t, d) of the axes, and the ``weights`` (t, k) of the correlations
    with them; about the first run.

    A Gaussian process with the Matern 5/2 correlation of the distance between settings: C. E. Rasmussen and C. K. I.
    Williams, Gaussian Processes for Machine Learning (2006), eqs. 2.19 and 4.17.
    """

    axes: tuple[Axis, ...]
    sites: Array
    values: Array
    weights: Array

    def __call__(self, settings: Array) -> Array:
        """Return the values (k,) at ``settings`` (d,), or (b, k) at b of them (b, d)."""
        return np.asarray(self.values[0] + _matern(_scaled(self.axes, settings), self.sites) @ self.weights)

    def with_runs(self, settings: Array, values: Array) -> Kriged:
        """Return the function that meets further runs too: ``values`` (r, k) at ``settings`` (r, d)."""
        sites = np.vstack([self.sites, _scaled(self.axes, settings)])
        return _through(self.axes, sites, np.vstack([self.values, values]))


def krige(axes: Sequence[Axis], settings: Array, values: Array) -> Kriged:
    """Return the function through ``values`` (t, k) of runs at ``settings`` (t, d).

    >>> axis = Axis("a", 0.0, 1.0)
    >>> at = np.linspace(0.0, 1.0, 9)[:, None]
    >>> found = krige([axis], at, np.sin(2.0 * at))
    >>> bool(abs(found(np.array([0.33]))[0] - np.sin(0.66)) < 1e-3)
    True
    """
    return _through(tuple(axes), _scaled(axes, settings), values)


def _through(axes: tuple[Axis, ...], sites: Array, values: Array) -> Kriged:
    near = _matern(sites, sites) + _NUGGET * np.eye(len(sites))
    return Kriged(axes, sites, values, np.linalg.solve(near, values - values[0]))


def _scaled(axes: Sequence[Axis], settings: Array) -> Array:
    columns = np.moveaxis(np.asarray(settings, dtype=np.float64), -1, 0)
    return np.stack([(v - axis.base) / axis.up for axis, v in zip(axes, columns, strict=True)], axis=-1)


def _matern(places: Array, sites: Array) -> Array:
    """Return the correlations (..., t) of scaled places (..., d) with the sites (t, d)."""
    away = np.sqrt(5.0 * np.sum((places[..., None, :] - sites) ** 2, axis=-1)) / _LENGTH
    return np.asarray((1.0 + away + away**2 / 3.0) * np.exp(-away))
