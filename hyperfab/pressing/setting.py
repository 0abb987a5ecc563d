"""What stays of a foam's compression when the press opens: its set, from the temperature at every depth against time.

A law says how fast the share that stays grows, from that share, the temperature and the strain alone. So tests at even
temperatures tell all: a place that warms goes from one temperature's curve to the next at the share it has reached.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Ints

#: Gas constant [J/mol/K] (CODATA 2018, exact), and 0 degC [K].
GAS = 8.31446261815324
ZERO_CELSIUS = 273.15
#: Gauss points through the thickness, and through the dwell's square root: heat enters a slab by the root of time.
DEPTHS, TIMES = 6, 16
#: Foam warms to its mold's temperature but for rounding: so little below a table's lowest, over the table's range or
#: over 1 K where that is larger, is the lowest. As much counts as within what is known.
_ROUNDED = 1e-4


@dataclass(frozen=True)
class Share:
    """The same share of every strain stays."""

    share: float

    def after(self, temperature: Array, spans: Array, strain: Array) -> Array:
        """Return the share (n,) that stays of ``strain`` (n,) after ``spans`` (t,) [s], one after the other, at
        ``temperature`` (t, n) [degC]."""
        return np.full(len(strain), self.share)


@dataclass(frozen=True)
class Arrhenius:
    """One process of first order: 1 - exp(-integral of ``rate`` exp(-``activation`` / R T) dt).

    ``rate`` [1/s], ``activation`` [J/mol].

    >>> law = Arrhenius(1e9, 1e5)
    >>> law.after(np.array([[180.0], [180.0]]), np.array([20.0, 40.0]), np.ones(1)).round(6).tolist()
    [0.163383]
    """

    rate: float
    activation: float

    def after(self, temperature: Array, spans: Array, strain: Array) -> Array:
        """Return the share (n,)."""
        speed = self.rate * np.exp(-self.activation / (GAS * (temperature + ZERO_CELSIUS)))
        return -np.expm1(-np.tensordot(spans, speed, axes=1))


@dataclass(frozen=True)
class Table:
    """``shares`` (a, b, c) measured at rising ``temperatures`` (a,) [degC], ``dwells`` (b,) [s] and ``strains`` (c,).

    Linear between the rows; they never fall with the dwell. From 0 s to the first dwell a share grows evenly; beyond
    the last dwell it stays; below the lowest temperature nothing sets, above the highest it sets as there. Of strains
    the nearest end holds.
    """

    temperatures: Array
    dwells: Array
    strains: Array
    shares: Array

    def after(self, temperature: Array, spans: Array, strain: Array) -> Array:
        """Return the share (n,)."""
        # From 0 s on; then for each place the curves of its strain (a, b + 1, n).
        curves = np.concatenate([np.zeros_like(self.shares[:, :1]), self.shares], axis=1)
        low, part = _between(self.strains, strain)
        of_strain = curves[:, :, low] * (1.0 - part) + curves[:, :, _next(low, self.strains)] * part
        dwells = np.concatenate([[0.0], self.dwells])
        reached, places = np.zeros(len(strain)), np.arange(len(strain))
        lowest = self.temperatures[0] - _ROUNDED * max(float(np.ptp(self.temperatures)), 1.0)
        for span, now in zip(spans, temperature, strict=True):
            low, part = _between(self.temperatures, now)
            curve = of_strain[low, :, places] * (1.0 - part)[:, None]
            curve += of_strain[_next(low, self.temperatures), :, places] * part[:, None]
            further = _read(dwells, curve, _when(dwells, curve, reached) + span)
            reached = np.where(now >= lowest, np.maximum(further, reached), reached)
        return reached

    def at(self, temperature: ArrayLike, dwell: ArrayLike, strain: ArrayLike) -> Array:
        """Return the share after a dwell [s] at one temperature [degC]."""
        one, span, strains = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (temperature, dwell, strain)))
        found = [
            self.after(np.array([[t]]), np.array([d]), np.array([e]))[0]
            for t, d, e in zip(one.ravel(), span.ravel(), strains.ravel(), strict=True)
        ]
        return np.array(found).reshape(one.shape)


#: How much of a strain stays.
SetLaw = Share | Arrhenius | Table


def stays(
    law: SetLaw, temperature: Callable[[Array, Array], Array], dwell: float, strain: Array
) -> tuple[Array, Array]:
    """Return the share (n,) of ``strain`` (n,) that stays, mean over the foam's thickness, and the hottest (n,) [degC].

    ``temperature(times, depths)`` (d, t, n) [degC] is that of the foam at ``depths`` (d,) of 0 to 1 and ``times``
    (t,) [s] of the ``dwell``.
    """
    nodes, weights = np.polynomial.legendre.leggauss(TIMES)
    root = 0.5 * (nodes + 1.0)
    # t = dwell u^2, so dt = 2 dwell u du.
    times, spans = dwell * root**2, dwell * root * weights
    share, hottest = np.zeros(len(strain)), np.full(len(strain), -np.inf)
    depths, shares = np.polynomial.legendre.leggauss(DEPTHS)
    for at, part in zip(temperature(times, 0.5 * (depths + 1.0)), 0.5 * shares, strict=True):
        share += part * law.after(at, spans, strain)
        hottest = np.maximum(hottest, at.max(axis=0))
    return share, hottest


def identified(temperature: Array, dwell: Array, share: Array) -> tuple[Arrhenius, float]:
    """Return the Arrhenius law nearest to ``share`` (n,) after a ``dwell`` (n,) [s] at one ``temperature`` (n,) [degC]
    each, and the root of its mean square error.

    Raises ValueError where the readings cannot tell two constants.
    """
    from scipy.optimize import least_squares

    inverse = 1.0 / (GAS * (temperature + ZERO_CELSIUS))
    if len(np.unique(temperature)) < 2:
        raise ValueError("two temperatures or more tell the activation energy")
    inside = (share > 0.0) & (share < 1.0)
    if len(np.unique(temperature[inside])) < 2:
        raise ValueError("shares between 0 and 1 are needed at two temperatures or more")
    # The logarithm of the speed is a straight line in 1/RT; its middle and slope are nearly independent.
    middle = float(inverse[inside].mean())
    scale = float(np.ptp(inverse[inside]))
    speed = np.log(-np.log1p(-share[inside]) / dwell[inside])
    slope, level = np.polyfit((inverse[inside] - middle) / scale, speed, 1)

    def off(x: Array) -> Array:
        return np.asarray(-np.expm1(-dwell * np.exp(x[0] + x[1] * (inverse - middle) / scale)) - share)

    found = least_squares(off, [level, slope], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    activation = float(-found.x[1] / scale)
    law = Arrhenius(float(np.exp(found.x[0] + activation * middle)), activation)
    return law, float(np.sqrt(np.mean(off(found.x) ** 2)))


def _between(rows: Array, at: Array) -> tuple[Ints, Array]:
    """Return the row below each place, and how far (0 to 1) it is to the next; ends hold."""
    low = np.clip(np.searchsorted(rows, at, side="right") - 1, 0, max(len(rows) - 2, 0))
    if len(rows) == 1:
        return low, np.zeros(len(at))
    return low, np.clip((at - rows[low]) / (rows[low + 1] - rows[low]), 0.0, 1.0)


def _next(low: Ints, rows: Array) -> Ints:
    return np.minimum(low + 1, len(rows) - 1)


def _when(dwells: Array, curve: Array, share: Array) -> Array:
    """Return the first time (n,) at which never falling curves (n, b) have a share (n,), or the last."""
    after = (curve < share[:, None]).sum(axis=1)
    high = np.clip(after, 1, len(dwells) - 1)
    row = np.arange(len(share))
    one, two = curve[row, high - 1], curve[row, high]
    part = np.where(two > one, (share - one) / np.where(two > one, two - one, 1.0), 0.0)
    return np.where(after == 0, 0.0, dwells[high - 1] + np.clip(part, 0.0, 1.0) * (dwells[high] - dwells[high - 1]))


def _read(dwells: Array, curve: Array, at: Array) -> Array:
    """Return curves (n, b) at a time (n,) each; the last value beyond."""
    low, part = _between(dwells, at)
    row = np.arange(len(at))
    return np.asarray(curve[row, low] * (1.0 - part) + curve[row, low + 1] * part)
