"""Arruda-Boyce law with the exact inverse Langevin function: ``W = mu N (b r + ln(b / sinh b)) - rest``.

``N = lambda_m^2``, ``r = sqrt(I1/(3 N))``, ``b = L^-1(r)``, doi:10.1016/0022-5096(93)90013-6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.materials.law import Array, Axis, Extent, InvariantTerm, Law, Sheet, Value, log_axis, log_I2, of_I1

#: Taylor coefficients of L at 0: b/3 - b^3/45 + ...; below SMALL nine of them leave an error under 1e-16.
_SERIES = (
    1 / 3, -1 / 45, 2 / 945, -1 / 4725, 2 / 93555, -1382 / 638512875, 4 / 18243225, -3617 / 162820783125,
    87734 / 38979295480125,
)  # fmt: skip
SMALL = 0.3
#: Gauss's rule of six points on (-1, 1), right to rounding for L over a way of b of ``_SHORT``: its poles are pi away.
_GAUSS = (
    (-0.9324695142031521, 0.1713244923791704), (-0.6612093864662645, 0.3607615730481386),
    (-0.2386191860831969, 0.4679139345726910), (0.2386191860831969, 0.4679139345726910),
    (0.6612093864662645, 0.3607615730481386), (0.9324695142031521, 0.1713244923791704),
)  # fmt: skip
_SHORT = 0.5


class ArrudaBoyceLangevin(Law):
    """Eight chains that lock at I1 = 3 lambda_m^2; mu is the modulus of infinitely long chains."""

    name = "arruda-boyce-langevin"
    title = "eight chains, exact inverse Langevin function"
    source = "doi:10.1016/0022-5096(93)90013-6"
    equation = "W = mu N (b r + ln(b/sinh b)), r = sqrt(I1/3)/lambda_m, b = L^-1(r), N = lambda_m^2"
    linear: tuple[str, ...] = ("mu_MPa",)
    nonlinear: tuple[str, ...] = ("lambda_m",)

    def axes(self, extent: Extent) -> list[Axis]:
        """The locking stretch lies beyond the data's chain stretch, and above 1."""
        chain = (1.0 + extent.x / 3.0) ** 0.5
        return [log_axis(1e-4 * chain, 100.0 * chain, beyond=chain)]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """lambda_m is above 1: at rest the chains are not locked."""
        return None if parameters["lambda_m"] > 1.0 else "lambda_m is not above 1"

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the one term of mu."""
        return [chain_term(sheet, theta[0])]


class ArrudaBoyceLogI2(ArrudaBoyceLangevin):
    """The eight chains with a logarithm of I2."""

    name = "arruda-boyce-lni2"
    title = "eight chains and the second invariant"
    source = "doi:10.1016/0022-5096(93)90013-6, doi:10.1002/pol.1958.1202811814"
    equation = "W = arruda-boyce-langevin + C2 ln(I2/3)"
    linear: tuple[str, ...] = ("mu_MPa", "C2_MPa")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the terms of mu and C2."""
        return [chain_term(sheet, theta[0]), log_I2(sheet)]


def chain_term(sheet: Sheet, lambda_m: Value) -> InvariantTerm:
    """Return the energy of eight chains over mu; ``dW/dI1 = b/(6 r)``."""
    I1 = 3.0 + sheet.x
    N = lambda_m**2.0
    r = np.sqrt(I1 / (3.0 * N))
    b = inverse_langevin(r)
    ratio = b / r

    def energy() -> Value:
        # N times the integral of b over r, as b (r - r0) less that of L - r0 over b: a difference of energies would be
        # rounded as N is, and where the sheet wrinkles strains of a thousandth are told apart by it.
        r0 = 1.0 / lambda_m
        rest = inverse_langevin(r0)
        return N * (b * sheet.x / (3.0 * N * (r + r0)) - _beyond_rest(b, rest, r0))

    return of_I1(W=energy, W1=ratio / 6.0, W11=(1.0 / langevin(b)[1] - ratio) / (12.0 * I1))


def langevin(b: Value) -> tuple[Array, Array]:
    """Return the Langevin function L(b) = coth b - 1/b of a freely jointed chain, and its derivative.

    >>> langevin(1.0)[0].round(12)
    np.float64(0.313035285499)
    """
    b = np.asarray(b)
    small = np.abs(b) < SMALL
    near, far = np.where(small, b, 0.0), np.where(small, 1.0, b)
    value, slope = np.zeros_like(near), np.zeros_like(near)
    square = near * near
    for order in range(len(_SERIES) - 1, -1, -1):
        value = value * square + _SERIES[order]
        slope = slope * square + (2 * order + 1) * _SERIES[order]
    decay = np.exp(-2.0 * far)
    rest = -np.expm1(-2.0 * far)
    exact = (1.0 + decay) / rest - 1.0 / far
    exact_slope = 1.0 / far**2 - 4.0 * decay / rest**2
    return np.where(small, value * near, exact), np.where(small, slope, exact_slope)


def inverse_langevin(r: Value) -> Array:
    """Return b with L(b) = r for 0 <= r < 1, nan beyond; complex r near the real axis is followed.

    A rational start (Jedynak 2015, doi:10.1007/s00397-014-0802-2) and Newton's method on it, to machine precision.

    >>> inverse_langevin(0.313035285499331).round(12)
    np.float64(1.0)
    """
    r = np.asarray(r)
    r = np.where((r.real >= 0.0) & (r.real < 1.0), r, np.nan)
    b = r * (3.0 - 2.6 * r + 0.7 * r * r) / ((1.0 - r) * (1.0 + 0.1 * r))
    for _ in range(4):
        value, slope = langevin(b)
        b = b - (value - r) / slope
    return np.asarray(b)


def _beyond_rest(b: Array, rest: Array, r0: Value) -> Array:
    """Return the integral of L - r0 from ``rest``, where L is r0, to ``b``; over a short way by Gauss's rule."""
    way = b - rest
    short = np.abs(way) < _SHORT
    half = 0.5 * np.where(short, way, 0.0)
    near = half * sum(share * (langevin(rest + (1.0 + place) * half)[0] - r0) for place, share in _GAUSS)
    return np.where(short, near, _log_ratio(rest) - _log_ratio(b) - r0 * way)


def _log_ratio(b: Value) -> Value:
    """Return ln(b/sinh b) without overflow."""
    return np.log(2.0 * b / -np.expm1(-2.0 * b)) - b


LAWS = (ArrudaBoyceLangevin(), ArrudaBoyceLogI2())
