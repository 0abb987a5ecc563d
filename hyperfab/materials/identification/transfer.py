"""How far constants from one mode of test may be trusted in the others."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.identification.fit import Fit
from hyperfab.materials.identification.linear import lengths
from hyperfab.materials.law import Array, Sheet
from hyperfab.materials.material import Material
from hyperfab.materials.modes import MODES, nominal_stress, second_stretch

_LEVELS = 24
#: Part of rubbers' stiffness at rest that is the second invariant's, and its standard deviation. Treloar's and
#: Kawabata's have 0.39 and 0.29 (gent-gent, all three modes); `trials/unseen.py` measures what comes of it elsewhere.
SHARE, SHARE_SD = 0.3, 0.3
#: What stays untold of the states between two ways that were both tested. Grey matter pressed and pulled by 10 %: 0.12
#: with what the laws miss is feared in shear, which they miss by 0.16 to 0.18 (data of Budday et al. 2017).
_BETWEEN = 0.2
#: Constants are moved by this part of themselves to see what follows.
_SMALL = 1e-5
#: Neo-Hookean stress of each mode over its modulus: stretch - stretch^-power.
_POWER = {"uniaxial": 2.0, "shear": 3.0, "biaxial": 5.0}


def stretch_at(mode: str, x: Array) -> Array:
    """Return the stretch above 1 of ``mode`` at which I1 - 3 is ``x``.

    >>> stretch_at("shear", np.array([2.25])).round(9)
    array([2.])
    """
    low, high = np.ones_like(x), np.full_like(x, 2.0)
    while (grow := _x(mode, high) < x).any():
        high = np.where(grow, 2.0 * high, high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = _x(mode, middle) < x
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(0.5 * (low + high))


def _x(mode: str, lam: Array) -> Array:
    return Sheet.of(lam, second_stretch(mode, lam)).x


def transfer_risk(fit: Fit, fitted: str) -> float:
    """Return the relative error to be feared in the modes that were not tested, up to the I1 that was.

    One mode does not tell how much of the stress is the second invariant's. Of rubbers' stiffness at rest a part of
    about ``SHARE`` is, in the form C2 ln(I2/3), give or take ``SHARE_SD``. The risk joins how far the secant moduli
    that the law predicts are from those of such a rubber with the same fitted mode, how far that rubber's own move
    with the part, and how far the law's move with its constants' standard deviations. Up to an I1 that was reached
    both pressed and pulled the law need not be near such a rubber, beyond it by what is beyond alone. Infinite where
    stress turns negative.
    """
    x = np.linspace(0.02, 1.0, _LEVELS) * fit.problem.rows.extent.x
    # Of every law and all its neighbours the same: to look for them each time would be half of a whole fit.
    at = {mode: stretch_at(mode, x) for mode in MODES}
    found = _log_ratios(fit.material, fitted, at)
    if not np.isfinite(found).all():
        return float("inf")
    rise = _rise_of_second_invariant(fit.material, fitted, at)
    # Pressed, a specimen stretches both ways across: with a pull as far that tells whether it is such a rubber.
    untold = np.tile(np.maximum(1.0 - _pressed_and_pulled(fit) / x, _BETWEEN), len(MODES) - 1)
    parts = (untold * (found - SHARE * rise), SHARE_SD * rise, _spread(fit, fitted, at))
    with np.errstate(over="ignore"):
        return float(np.sqrt(sum(np.mean(part**2) for part in parts)))


def _pressed_and_pulled(fit: Fit) -> float:
    """Return the largest I1 - 3 that uniaxial tests reached both pressed and pulled."""
    rows = fit.problem.rows
    x = rows.sheet(0.5).x
    return min(float(x[rows.uniaxial & side].max(initial=0.0)) for side in (rows.stretch < 1.0, rows.stretch > 1.0))


def _log_ratios(material: Material, fitted: str, at: dict[str, Array]) -> Array:
    """Return the logarithm of the secant modulus of each other mode over that of the fitted one, at equal I1.

    ``at`` are the stretches of each mode at these I1.
    """
    with np.errstate(all="ignore"):
        base = np.log(_secant(material, fitted, at[fitted]))
        return np.concatenate([np.log(_secant(material, mode, at[mode])) - base for mode in MODES if mode != fitted])


def _secant(material: Material, mode: str, lam: Array) -> Array:
    return np.asarray(nominal_stress(material, mode, lam) / (lam - lam ** -_POWER[mode]))


def _rise_of_second_invariant(material: Material, fitted: str, at: dict[str, Array]) -> Array:
    """Return by how much the logarithms of the ratios rise for each part of the stiffness at rest that is I2's.

    The term C2 ln(I2/3) has the secant 2 C2 f/I2, f the squared in-plane stretch across the load; what it has in the
    fitted mode is taken from I1, which all modes share.
    """

    def of(mode: str) -> Array:
        lam = at[mode]
        sheet = Sheet.of(lam, second_stretch(mode, lam))
        return np.asarray(3.0 / (3.0 + sheet.y) * sheet.l2**2)

    secant = _secant(material, fitted, at[fitted])
    over = secant[0] / secant
    return np.concatenate([(of(mode) - of(fitted)) * over for mode in MODES if mode != fitted])


def _spread(fit: Fit, fitted: str, at: dict[str, Array]) -> Array:
    """Standard deviation of the logarithms of the ratios, from that of the constants, linearised."""
    J = fit.jacobian
    rows, count = J.shape
    if rows <= count:
        return np.full(1, np.inf)
    length = lengths(J)
    _, s, Vt = np.linalg.svd(J / length, full_matrices=False)
    noise = np.sqrt(fit.sse / (rows - count))
    size = _size(fit)
    # The constants of the first group of rows, and those that all share.
    linear = len(fit.problem.free)
    own = [*range(linear), *range(count - (len(size) - linear), count)]
    total = np.zeros(2 * len(at[fitted]))
    for value, direction in zip(s, Vt, strict=True):
        move = (direction / length)[own]
        step = _SMALL / max(np.abs(move / size).max(), 1e-300)
        up, down = (_log_ratios(_moved(fit, sign * step * move), fitted, at) for sign in (1.0, -1.0))
        total += ((up - down) / (2.0 * step) * noise / max(value, 1e-12 * s[0])) ** 2
    return np.sqrt(np.nan_to_num(total, nan=np.inf))


def _moved(fit: Fit, move: Array) -> Material:
    """Return the material with its free constants, linear ones first, moved."""
    problem, law = fit.problem, fit.material.law
    c, theta = list(fit.material.c), list(fit.material.theta)
    free = [k for k, name in enumerate(law.nonlinear) if name not in law.held]
    for number, change in zip(problem.free, move[: len(problem.free)], strict=True):
        c[number] += float(change)
    for number, change in zip(free, move[len(move) - len(free) :], strict=True):
        theta[number] += float(change)
    return Material(law, tuple(c), tuple(theta))


def _size(fit: Fit) -> Array:
    """Return the size of each free constant, but no less than a thousandth (of the largest linear one)."""
    law = fit.material.law
    c = np.abs([fit.material.c[number] for number in fit.problem.free])
    theta = [abs(v) for v, name in zip(fit.material.theta, law.nonlinear, strict=True) if name not in law.held]
    return np.concatenate([np.maximum(c, 1e-3 * c.max(initial=1e-12)), np.maximum(theta, 1e-3)])
