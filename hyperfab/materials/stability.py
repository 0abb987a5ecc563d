"""Drucker stability of the sheet: more strain takes more stress, in every direction of the plane.

With logarithmic strains e1, e2 and Kirchhoff stresses t1, t2 (zero across the sheet) the work of a further
strain, dt : de, is positive where the matrix dt/de is positive definite. This is the check that finite-element
programs make of hyperelastic constants.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.materials.law import Array
from hyperfab.materials.material import Material
from hyperfab.materials.modes import MODES, second_stretch

#: Stretches that are looked at, from compression to far beyond what fabrics bear.
LOWEST, HIGHEST = 0.2, 15.0
_POINTS_DOWN, _POINTS_UP = 160, 640
#: Points a side of the plane of both stretches.
_POINTS_OF_PLANE = 161
#: Rounding leaves eigenvalues of 1e-16 of the larger one with either sign.
_ROUNDING = -1e-13


@dataclass(frozen=True)
class Range:
    """The stretches around 1 over which a mode is stable, and what ends them above.

    ``ended_by`` is ``instability``, ``limit`` (of the law: the chains are stretched out) or ``scan``.
    """

    low: float
    high: float
    ended_by: str

    @property
    def first_unstable(self) -> float | None:
        """The first unstable stretch above 1, or None."""
        return self.high if self.ended_by == "instability" else None


def margin(material: Material, l1: ArrayLike, l2: ArrayLike) -> Array:
    """Return the smaller eigenvalue of dt/de over the larger, negative where unstable, nan beyond the law's limit.

    >>> from hyperfab.materials import bind
    >>> bool(margin(bind("neo-hookean", {"C10_MPa": 0.2}), 2.0, 2.0) > 0)
    True
    """
    one, two = np.asarray(l1, dtype=float), np.asarray(l2, dtype=float)
    found = material.membrane(one, two)
    with np.errstate(all="ignore"):
        d11 = one * (found.P1 + one * found.A11)
        d22 = two * (found.P2 + two * found.A22)
        d12 = one * two * found.A12
        middle, radius = 0.5 * (d11 + d22), np.hypot(0.5 * (d11 - d22), d12)
        largest = np.abs(middle) + radius
        lower = np.where(largest > 0.0, (middle - radius) / np.where(largest > 0.0, largest, 1.0), -1.0)
    return np.asarray(np.where(np.isfinite(largest), lower, np.nan))


def stable_ranges(material: Material) -> dict[str, Range]:
    """Return the stable range of each mode, its ends found to 1e-6.

    >>> from hyperfab.materials import bind
    >>> stable_ranges(bind("mooney-rivlin-2", {"C10_MPa": 0.1, "C01_MPa": 0.1}))["biaxial"].ended_by
    'scan'
    """
    up = np.geomspace(1.0, HIGHEST, _POINTS_UP)
    down = np.geomspace(1.0, LOWEST, _POINTS_DOWN)
    nu = material.law.contraction(material.theta)
    lam = np.concatenate([up, down])
    l1 = np.tile(lam, len(MODES))
    l2 = np.concatenate([second_stretch(mode, lam, nu) for mode in MODES])
    values = margin(material, l1, l2).reshape(len(MODES), -1)
    found = {}
    for mode, row in zip(MODES, values, strict=True):
        high, ended_by = _end(material, mode, up, row[: len(up)])
        low, _ = _end(material, mode, down, row[len(up) :])
        found[mode] = Range(low, high, ended_by)
    return found


def _end(material: Material, mode: str, lam: Array, row: Array) -> tuple[float, str]:
    nu = material.law.contraction(material.theta)
    good = 1.0
    reason = "scan"
    for _ in range(5):
        bad = ~(row > _ROUNDING)
        if not bad.any():
            return float(lam[-1]), reason
        first = int(np.argmax(bad))
        reason = "limit" if np.isnan(row[first]) else "instability"
        if first == 0:
            break
        good, wrong = float(lam[first - 1]), float(lam[first])
        if abs(wrong - good) <= 1e-6:
            break
        lam = np.linspace(good, wrong, 40)
        row = margin(material, lam, second_stretch(mode, lam, nu))
    return good, reason


@dataclass(frozen=True)
class Plane:
    """Stability over all pairs of stretches from ``low`` to ``high``: the stable share, the unstable pair nearest rest.

    Pairs beyond the law's limit count as neither.
    """

    low: float
    high: float
    stable_fraction: float
    first_unstable: tuple[float, float] | None


def stable_plane(material: Material, low: float, high: float) -> Plane:
    """Look at the plane of both stretches on a grid even in logarithmic strain.

    >>> from hyperfab.materials import bind
    >>> stable_plane(bind("neo-hookean", {"C10_MPa": 0.2}), 0.8, 2.0).stable_fraction
    1.0
    """
    line = np.geomspace(low, high, _POINTS_OF_PLANE)
    l1, l2 = np.meshgrid(line, line, indexing="ij")
    values = margin(material, l1, l2)
    known, wrong = ~np.isnan(values), values <= _ROUNDING
    first = None
    if wrong.any():
        distance = np.where(wrong, np.hypot(np.log(l1), np.log(l2)), np.inf)
        place = np.unravel_index(int(np.argmin(distance)), distance.shape)
        first = (float(l1[place]), float(l2[place]))
    share = float((known & ~wrong).sum() / max(int(known.sum()), 1))
    return Plane(low, high, share, first)


def stable_over(ranges: Mapping[str, Range], reach: Mapping[str, tuple[float, float]]) -> bool:
    """Say whether each mode in ``reach`` is stable from the smallest to the largest stretch given for it."""
    return all(
        ranges[mode].low <= low + 1e-9 and ranges[mode].high >= high - 1e-9
        for mode, (low, high) in reach.items()
        if mode in ranges
    )


def stable_at(material: Material, pairs: Array) -> bool:
    """Say whether every one of ``pairs`` of in-plane stretches (n, 2) is stable.

    >>> from hyperfab.materials import bind
    >>> stable_at(bind("neo-hookean", {"C10_MPa": 0.2}), np.array([[1.5, 1.2], [2.0, 0.8]]))
    True
    """
    return bool((margin(material, pairs[:, 0], pairs[:, 1]) > _ROUNDING).all())
