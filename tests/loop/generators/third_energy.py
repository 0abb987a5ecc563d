"""Energies of a third set of stretch fabrics, and the stress and width of a strip that follow from them.

A third set, written from the file formats alone; its formulas were chosen without looking at the catalogue.
It is never tuned to.

A strip is a membrane under plane stress with one energy W(F). A long strip pulled at an angle has free edges,
F = [[λ, g], [0, m]], and m, g (and the thickness, where it may change) make W least; the stress is ∂W/∂λ there.
"shear" is planar tension (m = 1, g = 0), "biaxial" equal stretch of a cross (m = λ), read along its first axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]
Curve = Callable[[Array], Array]

BASES = ("gent-i2", "eight-chain-i2", "davies-de-thomas", "lopez-pamies", "van-der-waals")
GRID = np.linspace(1.0, 1.65, 66)


@dataclass
class Truth:
    """One fabric: a plain law, its effects, and the constants drawn for them (`u1`… are places in a range)."""

    effects: tuple[str, ...]
    elastic: str
    draws: dict[str, dict[str, float]]
    seed: int
    laws: dict[tuple[str, float], tuple[Curve, Curve]] = field(default_factory=dict, repr=False, compare=False)

    def of(self, effect: str) -> dict[str, float] | None:
        """Return the constants of an effect, None where the fabric lacks it."""
        return self.draws[effect] if effect in self.effects and self.draws[effect]["amount"] != 0.0 else None

    def plain(self) -> Truth:
        """Return the same fabric without any effect."""
        return replace(self, effects=(), laws={})

    def law(self, mode: str, angle: float) -> tuple[Curve, Curve]:
        """Return stress and transverse stretch against stretch."""
        if (mode, angle) not in self.laws:
            self.laws[mode, angle] = relaxed(self, mode, angle)
        return self.laws[mode, angle]

    def peak(self) -> float:
        """Return the stress of the plain law in the uniaxial test at a stretch of 1.5 [MPa]."""
        if ("peak", 0.0) not in self.laws:
            self.laws["peak", 0.0] = relaxed(self.plain(), "uniaxial", 0.0)
        return float(self.laws["peak", 0.0][0](np.array([1.5]))[0])


def at(d: dict[str, float], key: str, low: float, high: float) -> float:
    return low + (high - low) * d[key]


def relaxed(truth: Truth, mode: str, angle: float) -> tuple[Curve, Curve]:
    """Minimise the energy over all that is free, at each stretch, by a guarded Newton's method of differences."""
    mu, lam = truth.draws["elastic"]["mu"], GRID
    thick = (d := truth.of("compressibility")) is not None and d["kind"] == 0
    skew = mode == "uniaxial" and truth.of("anisotropy") is not None and angle % 90.0 != 0.0
    side = {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[mode]
    free = [i for i, on in enumerate((mode == "uniaxial", skew, thick)) if on]

    def energy(x: Array, stretch: Array = lam) -> Array:
        u = np.zeros((lam.size, 3))
        u[:, free] = x
        return _energy(truth, angle, stretch, side * np.exp(u[:, 0]), u[:, 1], u[:, 2] if thick else None)

    x, h = np.zeros((lam.size, len(free))), 1e-4
    for _ in range(40 if free else 0):
        steps = h * np.eye(len(free))
        slope = np.stack([(energy(x + s / 10) - energy(x - s / 10)) / (0.2 * h) for s in steps], axis=1)
        if np.max(np.abs(slope)) < 1e-8 * mu:
            break
        bend = np.empty((lam.size, len(free), len(free)))
        for i, a in enumerate(steps):
            for j, b in enumerate(steps[: i + 1]):
                cross = energy(x + a + b) - energy(x + a - b) - energy(x - a + b) + energy(x - a - b)
                bend[:, i, j] = bend[:, j, i] = cross / (4.0 * h * h)
        value, vector = np.linalg.eigh(bend)
        along = np.einsum("kij,ki->kj", vector, slope) / np.maximum(np.abs(value), 1e-3 * mu)
        way = np.clip(-np.einsum("kij,kj->ki", vector, along), -0.1, 0.1)
        for _ in range(5):
            worse = energy(x + way) > energy(x) + 1e-14 * mu
            way[worse] *= 0.3
        x = x + way
    stress = (energy(x, lam + 1e-5) - energy(x, lam - 1e-5)) / 2e-5
    stress[0] = 0.0
    width = side * np.exp(x[:, 0]) if mode == "uniaxial" else side
    return CubicSpline(lam, stress), CubicSpline(lam, width)


def _energy(truth: Truth, angle: float, lam: Array, m: Array, g: Array, ln_j: Array | None) -> Array:
    c11, c12, c22 = lam**2, lam * g, g**2 + m**2
    ln_j, stored = _volume(truth, np.log(lam * m), ln_j)
    cut = np.exp(-2.0 / 3.0 * ln_j)
    c33 = np.exp(2.0 * ln_j) / (lam * m) ** 2
    i1 = cut * (c11 + c22 + c33)
    i2 = cut**2 * (c11 * c22 - c12**2 + c33 * (c11 + c22))
    w = stored + _base(truth, i1, i2)
    if d := truth.of("elastic-law"):
        w = w + truth.draws["elastic"]["mu"] * d["amount"] * _richer(d, i1, i2, c11, c12, c22, c33, cut)
    if d := truth.of("anisotropy"):
        w = w + truth.draws["elastic"]["mu"] * d["amount"] * _directed(d, angle, c11, c12, c22, c33)
    return w


def _base(truth: Truth, i1: Array, i2: Array) -> Array:
    """Return the plain law.

    Gent 1996 (10.5254/1.3538357) with the logarithm of I2 of Pucci and Saccomandi 2002; Arruda and Boyce 1993
    (10.1016/0022-5096(93)90013-6) with the root of I2 of Carroll 2011 (10.1007/s10659-010-9279-0); Davies, De and
    Thomas 1994; Lopez-Pamies 2010 (10.1016/j.crme.2009.12.007); Kilian 1981, with both invariants.
    """
    d = truth.draws["elastic"]
    mu = d["mu"]
    if truth.elastic == "gent-i2":
        limit = at(d, "u1", 6.0, 20.0)
        return mu * (-0.5 * limit * np.log(1.0 - (i1 - 3.0) / limit) + at(d, "u2", 0.15, 0.6) * np.log(i2 / 3.0))
    if truth.elastic == "eight-chain-i2":
        n = at(d, "u1", 2.8, 6.0)
        return mu * (n * _langevin_energy(i1 / 3.0 / n) + at(d, "u2", 0.3, 1.2) * (np.sqrt(i2) - math.sqrt(3.0)))
    if truth.elastic == "davies-de-thomas":
        power, soft = 1.0 - at(d, "u1", 0.2, 0.5) / 2.0, at(d, "u2", 0.005, 0.05)
        stiff = at(d, "u3", 0.02, 0.08)
        return mu * (
            ((i1 - 3.0 + soft) ** power - soft**power) / (2.0 * power) + stiff * np.maximum(i1 - 3.0, 0.0) ** 2
        )
    if truth.elastic == "lopez-pamies":
        w = np.zeros_like(i1)
        for a, share in ((at(d, "u1", -2.0, 0.5), 0.8), (at(d, "u2", 2.5, 5.0), at(d, "u3", 0.1, 0.3))):
            w = w + mu * share * 3.0 ** (1.0 - a) / (2.0 * a) * (i1**a - 3.0**a)
        return w
    mix = at(d, "u1", 0.6, 0.95)
    limit = at(d, "u2", 5.0, 12.0)  # λm² - 3
    x = np.maximum(mix * i1 + (1.0 - mix) * i2 - 3.0, 0.0)
    eta = np.sqrt(x / limit)
    return mu * (-limit * (np.log1p(-eta) + eta) - 2.0 / 3.0 * at(d, "u3", 0.1, 0.25) * (x / 2.0) ** 1.5)


def _langevin_energy(x2: Array) -> Array:
    """Return ∫ L⁻¹ dx by the approximant x (3 - x²)/(1 - x²) of Cohen 1991, from the square of x."""
    return 0.5 * x2 - np.log(1.0 - x2)


def _richer(
    d: dict[str, float], i1: Array, i2: Array, c11: Array, c12: Array, c22: Array, c33: Array, cut: Array
) -> Array:
    """Return what the plain law lacks.

    Worm-like chains (Marko and Siggia 1995, 10.1021/ma00130a008) in eight directions; yarns of two segments, the
    second of which locks, in all directions; Mooney 1940 (10.1063/1.1712836) with the cube of I2; the tube's
    constraint (Kaliske and Heinrich 1999).
    """
    if d["kind"] == 0:
        x = np.sqrt(i1 / 3.0) * at(d, "u1", 0.4, 0.6)
        return 1.0 / (4.0 * (1.0 - x)) - x / 4.0 + x**2 / 2.0
    if d["kind"] == 1:
        lock, s = at(d, "u1", 1.12, 1.25), at(d, "u2", 0.05, 0.1)
        x, start = (
            _at_angles(c11, c12, c22, 24) - lock,
            1.0 - lock,
        )  # a hinge with a round corner, from no pull at rest
        root = np.sqrt(x**2 + s**2)
        store = 0.25 * (x**2 + x * root + s**2 * np.arcsinh(x / s))
        return 4.0 * np.mean(store - 0.5 * (start + math.hypot(start, s)) * x, axis=1)
    if d["kind"] == 2:
        return 0.1 * (i2 - 3.0) + at(d, "u1", 0.01, 0.06) * (i2 - 3.0) ** 3
    mean, gap = (c11 + c22) / 2.0, np.sqrt(((c11 - c22) / 2.0) ** 2 + c12**2)
    power = at(d, "u1", 0.8, 2.5) / 2.0
    return sum(((cut * c) ** -power - 1.0 for c in (mean + gap, mean - gap, c33)), np.zeros_like(i1)) / power


def _at_angles(c11: Array, c12: Array, c22: Array, count: int) -> Array:
    a = (np.arange(count) + 0.5) * np.pi / count
    c, s = np.cos(a), np.sin(a)
    return np.sqrt(np.outer(c11, c * c) + 2.0 * np.outer(c12, c * s) + np.outer(c22, s * s))


def _directed(d: dict[str, float], angle: float, c11: Array, c12: Array, c22: Array, c33: Array) -> Array:
    """Return the energy of the directions of the cloth, warp and weft its axes of symmetry.

    Two dispersed families (Holzapfel, Gasser and Ogden 2000, 10.1023/A:1010835316564; Gasser, Ogden and Holzapfel
    2006, 10.1098/rsif.2005.0073); an exponential of Green's strains (Fung, Fronek and Patitucci 1979); fibres about
    the warp by von Mises' density; generalised invariants of Itskov and Aksel 2004 (10.1016/j.ijsolstr.2004.02.027).
    """
    turn = math.radians(angle)
    c, s = math.cos(turn), math.sin(turn)
    if d["u5"] > 0.5:  # the stronger direction is the weft
        c, s = -s, c
    warp = c11 * c * c - 2.0 * c12 * c * s + c22 * s * s
    weft = c11 * s * s + 2.0 * c12 * c * s + c22 * c * c
    cross = (c11 - c22) * c * s + c12 * (c * c - s * s)
    if d["kind"] == 0:
        kappa, spread = at(d, "u1", 0.03, 0.18), math.radians(at(d, "u2", 8.0, 30.0))
        w = np.zeros_like(c11)
        for lean in (spread, -spread):
            i4 = warp * math.cos(lean) ** 2 + weft * math.sin(lean) ** 2 + 2.0 * cross * math.sin(lean) * math.cos(lean)
            e = np.maximum(kappa * (c11 + c22 + c33 - 3.0) + (1.0 - 3.0 * kappa) * (i4 - 1.0), 0.0)
            w = w + np.expm1(at(d, "u3", 0.1, 0.5) * e**2)
        return w
    if d["kind"] == 1:
        e1, e2, e12 = (warp - 1.0) / 2.0, (weft - 1.0) / 2.0, cross / 2.0
        a1, a2 = at(d, "u1", 0.8, 1.5), at(d, "u2", 0.1, 0.4)
        q = a1 * e1**2 + a2 * e2**2 + 2.0 * 0.5 * math.sqrt(a1 * a2) * e1 * e2 + at(d, "u3", 0.2, 2.0) * e12**2
        return np.expm1(q)
    if d["kind"] == 2:
        a = (np.arange(36) + 0.5) * np.pi / 36
        dense = np.exp(at(d, "u1", 1.0, 4.0) * np.cos(2.0 * a))
        ca, sa = np.cos(a), np.sin(a)
        lam = np.sqrt(np.outer(warp, ca**2) + np.outer(weft, sa**2) + 2.0 * np.outer(cross, ca * sa))
        pull = np.maximum(lam - 1.0, 0.0)
        return (pull**2 + at(d, "u2", 0.5, 3.0) * pull**3) @ (dense / dense.sum())
    w1, w2 = at(d, "u1", 0.6, 0.9), at(d, "u2", 0.02, 0.1)
    area = warp * weft - cross**2
    i = w1 * warp + w2 * weft + (1.0 - w1 - w2) * c33
    k = w1 * weft / area + w2 * warp / area + (1.0 - w1 - w2) / c33
    alpha, beta = at(d, "u3", 1.0, 2.5), at(d, "u4", 0.6, 1.5)
    return ((i**alpha - 1.0) / alpha + (k**beta - 1.0) / beta) / 2.0


def _volume(truth: Truth, area: Array, ln_j: Array | None) -> tuple[Array, Array]:
    """Return the logarithm of the volume, and the energy that it stores, from the logarithm of the area.

    Hill 1978 and Storakers 1986 (10.1016/0022-5096(86)90033-5); a thickness that goes with a power of the area
    (after Beatty and Stalnaker 1986); loops of a knit that contract at first and then no more; pores that open at
    once, so that the width grows at the start, and are open then.
    """
    d, zero = truth.of("compressibility"), np.zeros_like(area)
    if d is None:
        return zero, zero
    if d["kind"] == 0 and ln_j is not None:
        bulk, beta = 3.0 * truth.draws["elastic"]["mu"] / d["amount"], at(d, "u1", 0.5, 6.0)
        return ln_j, bulk / beta**2 * (np.expm1(-beta * ln_j) + beta * ln_j)
    if d["kind"] == 1:
        return d["amount"] * area, zero
    k = at(d, "u1", 0.08, 0.2)
    if d["kind"] == 2:
        return d["amount"] * area**2 / (k + np.abs(area)), zero
    k = 0.3 * d["amount"]
    return at(d, "u2", 0.7, 0.95) * k * np.tanh(area / k), zero
