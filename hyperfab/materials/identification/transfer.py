"""How far constants from one mode of test may be trusted in the others."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.identification.fit import Fit
from hyperfab.materials.kinematics import Array, Sheet
from hyperfab.materials.material import Material
from hyperfab.materials.modes import MODES, nominal_stress, second_stretch

_LEVELS = 24
#: Neo-Hookean stress of each mode over its modulus: stretch - stretch^-power.
_POWER = {"uniaxial": 2.0, "shear": 3.0, "biaxial": 5.0}


def secant_ratio(material: Material, fitted: str, I1_reach: float) -> dict[str, Array]:
    """Return the secant modulus of each other mode over that of the ``fitted`` one, at equal I1 - 3 up to the reach.

    1 throughout for a law of I1 alone. Measured elastomers stay within a factor of about two; constants that
    one mode does not pin down leave it by orders of magnitude.
    """
    found = {}
    base = None
    for mode in (fitted, *(mode for mode in MODES if mode != fitted)):
        lam = stretch_at(mode, np.linspace(0.02, 1.0, _LEVELS) * I1_reach)
        secant = nominal_stress(material, mode, lam) / (lam - lam ** -_POWER[mode])
        if base is None:
            base = secant
        else:
            with np.errstate(all="ignore"):
                found[mode] = secant / base
    return found


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
    """Return the relative error to be feared in the modes that were not tested; infinite where stress turns negative.

    It joins how far the predicted secant moduli stray from the fitted mode's beyond a factor of two, and how
    far they move when the constants move within their standard deviations.
    """
    reach = fit.problem.rows.extent.x
    ratios = secant_ratio(fit.material, fitted, reach)
    every = np.concatenate(list(ratios.values()))
    if not np.isfinite(every).all() or (every <= 0.0).any():
        return float("inf")
    stray = np.clip(np.abs(np.log(every)) - np.log(2.0), 0.0, None)
    spread = _spread(fit, fitted, ratios, reach)
    return float(np.sqrt(np.mean(stray**2) + np.mean(spread**2)))


def _spread(fit: Fit, fitted: str, ratios: dict[str, Array], reach: float) -> Array:
    """Standard deviation of the logarithm of the secant ratios, from that of the constants."""
    J = fit.jacobian
    rows, count = J.shape
    if rows <= count:
        return np.full(1, np.inf)
    length = np.sqrt((J * J).sum(axis=0))
    length = np.where(length > 0.0, length, 1.0)
    _, s, Vt = np.linalg.svd(J / length, full_matrices=False)
    noise = np.sqrt(fit.sse / (rows - count))
    problem, material = fit.problem, fit.material
    free_theta = [k for k, name in enumerate(material.law.nonlinear) if name not in material.law.held]
    base = np.log(np.concatenate(list(ratios.values())))
    total = np.zeros_like(base)
    for value, direction in zip(s, Vt, strict=True):
        move = direction / length * noise / max(value, 1e-12 * s[0])
        c, theta = list(material.c), list(material.theta)
        scale = min(1.0, 0.05 / max(np.abs(move[: len(problem.free)] / _size(c, problem.free)).max(), 1e-300))
        for k, number in enumerate(problem.free):
            c[number] += float(move[k] * scale)
        for k, number in enumerate(free_theta):
            theta[number] += float(move[len(move) - len(free_theta) + k] * scale)
        shifted = Material(material.law, tuple(c), tuple(theta))
        moved = np.concatenate(list(secant_ratio(shifted, fitted, reach).values()))
        with np.errstate(all="ignore"):
            total += ((np.log(moved) - base) / scale) ** 2
    return np.sqrt(np.nan_to_num(total, nan=np.inf))


def _size(c: list[float], free: list[int]) -> Array:
    return np.maximum(np.abs([c[number] for number in free]), 1e-12)
