"""A fourth, small set of stretch fabrics, measured once the loop was done: two ways of each effect, drawn in size.

Its formulas stand in none of the other sets and not in the catalogue; none of its plain laws is a model's. What a
fabric is led through is drawn as for the third set. Units: MPa, s, degC.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from loop.generators.fabric import Reading, Setup, program
from loop.generators.other_fabric import noisy
from loop.generators.third_fabric import protocol
from numpy.random import Generator
from numpy.typing import NDArray

__all__ = ["KINDS", "OUTSIDE", "Truth", "draw", "measure", "protocol"]

Array = NDArray[np.float64]

KINDS = dict.fromkeys(
    ("anisotropy", "hysteresis", "rate", "mullins", "permanent-set", "thermal-softening", "grip-slack",
     "load-offset", "compressibility", "elastic-law"), 2,
)  # fmt: skip
#: A strip that tears at its edge little by little; a specimen that is wetted once.
OUTSIDE = ("tear", "wetting")
_BASES = ("hencky", "hart-smith", "rational")
_ROOM, _FINE = 23.0, 3


@dataclass
class Truth:
    """A plain law, its effects, and the numbers drawn for them."""

    effects: tuple[str, ...]
    elastic: str
    draws: dict[str, dict[str, float]] = field(default_factory=dict)
    seed: int = 0

    def of(self, effect: str) -> dict[str, float] | None:
        """Return the numbers of an effect, None where the fabric lacks it."""
        return self.draws[effect] if effect in self.effects else None


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects, each of 3 to 6 % of the plain law's peak (rms) over a usual programme."""
    base = _BASES[int(random.integers(len(_BASES)))]
    draws = {"elastic": {f"u{k}": float(random.random()) for k in range(3)}}
    truth = Truth(tuple(effects), base, draws, int(random.integers(2**31)))
    usual = [replace(one, points=12) for one in protocol(np.random.default_rng(5))]
    plain = _clean(replace(truth, effects=()), usual)
    peak = max(float(np.max(one.stress)) for one in plain)
    for number, effect in enumerate(effects):
        own = kind if kind is not None and number == 0 else int(random.integers(KINDS.get(effect, 1)))
        size = float(random.uniform(0.03, 0.06))
        draws[effect] = {"kind": float(own), "amount": 0.3, "u": float(random.random())}
        for _ in range(5):
            alone = _clean(replace(truth, effects=(effect,)), usual)
            gap = [one.stress - other.stress for one, other in zip(alone, plain, strict=True)]
            share = size * peak / max(float(np.sqrt(np.mean(np.concatenate(gap) ** 2))), 1e-9)
            draws[effect]["amount"] = float(np.clip(draws[effect]["amount"] * np.clip(share, 0.3, 3.0), 0.0, 0.9))
    return truth


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests: readings with white noise of sd ``noise`` [MPa]."""
    return noisy(_clean(truth, setups), random, noise)


def _clean(truth: Truth, setups: Sequence[Setup]) -> list[Reading]:
    return [_answer(truth, setup, number) for number, setup in enumerate(setups)]


def _elastic(truth: Truth, mode: str, lam: Array, width: Array) -> Array:
    """Return the nominal stress: Neff's exponential of Hencky's strain (2015), Hart-Smith's law (1966), a quotient."""
    u = truth.draws["elastic"]
    mu, thick = math.exp(u["u0"] - 1.0), 1.0 / (lam * width)
    x = np.maximum(lam**2 + width**2 + thick**2 - 3.0, 0.0)
    first, second = np.zeros_like(x), np.zeros_like(x)
    found = np.zeros_like(x)
    if truth.elastic == "hencky":
        h = [np.log(one) for one in (lam, width, thick)]
        middle = sum(h) / 3.0
        q = sum((one - middle) ** 2 for one in h)
        found = 2.0 * mu * np.exp((0.3 + 1.2 * u["u1"]) * q) * (h[0] - h[2]) / lam
    elif truth.elastic == "hart-smith":
        first = mu * np.exp((0.05 + 0.15 * u["u1"]) * x**2)
        second = 0.5 * u["u2"] * mu / (3.0 + x)
    else:
        first = mu * (1.0 + (0.5 + 2.0 * u["u1"]) * x) / (1.0 + (1.0 + 2.0 * u["u2"]) * x)
    if d := truth.of("elastic-law"):
        if d["kind"] < 1:
            first = first + 3.0 * mu * d["amount"] * x**1.5 / (0.4 + d["u"] + x)
        else:
            second = second + 3.0 * mu * d["amount"] * np.sqrt(x + 0.05) / (1.0 + x)
    return np.asarray(found + 2.0 * (lam - thick**2 / lam) * (first + second * width**2))


def _threads(d: dict[str, float], truth: Truth, setup: Setup, lam: Array, width: Array) -> Array:
    """Return what threads of one direction add: a power of their strain, or waves that are straight one by one.

    The stress along the strip is the slope of their energy with its width held.
    """
    c, s = math.cos(math.radians(setup.angle)), math.sin(math.radians(setup.angle))
    if d["u"] > 0.5:
        c, s = s, c
    stretch = np.sqrt((lam * c) ** 2 + (width * s) ** 2)
    e = np.maximum(stretch - 1.0, 0.0)
    if d["kind"] < 1:
        pull = 2.0 * e**1.5
    else:
        at = np.linspace(0.02, 0.5, 25)
        share = at * np.exp(-at / 0.12)
        pull = 4.0 * np.maximum(e[:, None] - at, 0.0) @ (share / share.sum())
    return np.asarray(pull * lam * c**2 / stretch)


def _way(truth: Truth, lam: Array) -> Array:
    """Return the stretch of the cloth: a toe that is a hyperbola, or one that dies out as the square of a quotient."""
    if (d := truth.of("grip-slack")) is None:
        return lam
    e, way = lam - 1.0, 0.1 * d["amount"]
    return 1.0 + (e**2 / (e + way) if d["kind"] < 1 else e - way * (1.0 - 1.0 / (1.0 + e / way) ** 2) / 2.0)


def _stays(truth: Truth, setup: Setup, lam: Array, t: Array, top: float) -> Array:
    """Return the strain that stays: creep with the logarithm of time, or seams that slip by the largest load."""
    if (d := truth.of("permanent-set")) is None:
        return np.zeros_like(lam)
    fine = np.linspace(1.0, 1.8, 801)
    load = _elastic(truth, setup.mode, fine, _contracted(setup.mode, fine)) / top
    if d["kind"] > 0:
        far = np.interp(np.maximum.accumulate(lam), fine, load)
        w = 0.08 + 0.1 * d["u"]
        return d["amount"] * 0.1 * w * (np.logaddexp(0.0, (far - 0.3) / w) - math.log1p(math.exp(-0.3 / w)))
    stays, out, slow = 0.0, [0.0], 0.05 * d["amount"]
    for here, dt in zip(lam[1:].tolist(), np.diff(t).tolist(), strict=True):
        p = float(np.interp(here / (1.0 + stays), fine, load))
        stays += slow * p * math.exp(-min(stays / slow, 50.0)) * dt / (5.0 + 30.0 * d["u"])
        out.append(stays)
    return np.array(out)


def _contracted(mode: str, lam: Array) -> Array:
    return {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[mode]


def _width(truth: Truth, mode: str, lam: Array) -> Array:
    """Return the second stretch: it comes to rest at once, or is a hyperbola of the first."""
    plain = _contracted(mode, lam)
    if mode != "uniaxial" or (d := truth.of("compressibility")) is None:
        return plain
    far = np.log(lam)
    if d["kind"] < 1:
        return np.asarray(plain * np.exp(0.5 * d["amount"] * far * -np.expm1(-far / (0.1 + 0.2 * d["u"]))))
    return 1.0 / (1.0 + 0.5 * (1.0 - d["amount"]) * (lam - 1.0))


def _warm(truth: Truth, degrees: float, e: Array) -> Array:
    """Return what warmth leaves: a power of the rise, or of the absolute temperature at small strain."""
    if (d := truth.of("thermal-softening")) is None:
        return np.ones_like(e)
    rise = max(degrees - _ROOM, 0.0)
    if d["kind"] < 1:
        return np.full_like(e, 1.0 - 0.5 * d["amount"] * (rise / 40.0) ** (1.3 + 0.8 * d["u"]))
    fall = ((degrees + 273.15) / (_ROOM + 273.15)) ** (-12.0 * d["amount"])
    hold = e / (e + 0.6 + d["u"])
    return (1.0 - hold) * fall + hold


def _softer(truth: Truth, lam: Array, t: Array) -> Array:
    """Return what earlier pulls leave: an exponential of a root (Zuniga & Beatty 2002), or damage that heals."""
    if (d := truth.of("mullins")) is None:
        return np.ones_like(lam)
    size = lam**2 + 2.0 / lam - 3.0
    most = np.maximum.accumulate(size)
    if d["kind"] < 1:
        return np.exp(-d["amount"] * np.sqrt(np.maximum(most - size, 0.0)))
    worn, out, far = 0.0, [0.0], 1.0
    for here, dt in zip(lam[1:].tolist(), np.diff(t).tolist(), strict=True):
        worn += 3.0 * max(here - far, 0.0) * (1.0 - worn)
        worn *= math.exp(-dt / (2000.0 + 4000.0 * d["u"]))
        far = max(far, here)
        out.append(worn)
    return 1.0 - d["amount"] * np.array(out) * np.maximum(1.0 - size / np.maximum(most, 1e-9), 0.0) ** 0.5


def _loop(truth: Truth, e: Array, p: Array, top: float) -> Array:
    """Return friction: Masing's rule on a hyperbola, or a rope's (Euler 1762) over arcs that a pull makes flat."""
    if (d := truth.of("hysteresis")) is None:
        return np.zeros_like(e)
    short, now, turn, at, sense, out = 0.01 + 0.03 * d["u"], 0.0, 0.0, 0.0, 1.0, [0.0]
    for last, here in zip(e[:-1].tolist(), e[1:].tolist(), strict=True):
        if (here - last) * sense < 0.0:
            sense, turn, at = -sense, now, last
        way = abs(here - at)
        reach = 1.0 - sense * turn
        now = turn + sense * reach * way / (way + short * reach)
        out.append(now)
    state = np.array(out)
    if d["kind"] < 1:
        return np.asarray(d["amount"] * np.sqrt(np.maximum(p, 0.0) * top) * state * np.minimum(e / 0.05, 1.0))
    return np.asarray(p * np.expm1(3.0 * d["amount"] * state / (1.0 + 4.0 * e)))


def _viscous(truth: Truth, p: Array, t: Array, top: float) -> Array:
    """Return what relaxes: by Kohlrausch's exponential (1854), or quicker with the square of the load."""
    if (d := truth.of("rate")) is None:
        return np.zeros_like(p)
    steps = np.diff(p)
    if d["kind"] < 1:
        power, time = 0.3 + 0.3 * d["u"], 10.0 ** (0.5 + 1.5 * d["u"])
        middle = 0.5 * (t[1:] + t[:-1])
        found = [float(steps[:k] @ np.exp(-(((now - middle[:k]) / time) ** power))) for k, now in enumerate(t)]
        return d["amount"] * np.array(found)
    q, out = np.zeros(2), [0.0]
    for step, dt, load in zip(steps, np.diff(t), p[1:] / top, strict=True):
        left = np.exp(-dt * (1.0 + 6.0 * load**2) / np.array([4.0, 90.0 + 200.0 * d["u"]]))
        q = q * left + 0.5 * step * np.sqrt(left)
        out.append(float(q.sum()))
    return d["amount"] * np.array(out)


def _answer(truth: Truth, setup: Setup, number: int) -> Reading:
    lam, t = program(setup, _FINE)
    ends = np.array([1.5])
    top = float(_elastic(replace(truth, effects=()), "uniaxial", ends, ends**-0.5)[0])
    cloth = _way(truth, lam)
    cloth = np.maximum(cloth / (1.0 + _stays(truth, setup, cloth, t, top)), 1.0)
    width = _width(truth, setup.mode, cloth)
    p = _elastic(truth, setup.mode, cloth, width)
    if d := truth.of("anisotropy"):
        p = p + top * d["amount"] * _threads(d, truth, setup, cloth, width)
    p = p * _softer(truth, cloth, t) * _warm(truth, setup.temperature, cloth - 1.0)
    if d := truth.of("tear"):
        p = p * (1.0 - d["amount"] * (np.arange(len(p)) / len(p)) ** 2 * (number % 3 != 0))
    if d := truth.of("wetting"):
        p = p * (1.0 - d["amount"] * (number % 4 == 1))
    p = np.maximum(p + _loop(truth, cloth - 1.0, p, top) + _viscous(truth, p, t, top), 0.0)
    if d := truth.of("load-offset"):
        own = np.random.default_rng([truth.seed, number])
        p = p + 0.3 * top * d["amount"] * (
            np.sqrt(t / 400.0) if d["kind"] < 1 else (1.0 + 0.3 * t / t[-1]) * (own.gamma(2.0) - 1.0)
        )
    rows = slice(None, None, _FINE)
    across = width[rows] if setup.mode == "uniaxial" else None
    return Reading(setup, t[rows], lam[rows], p[rows], across)
