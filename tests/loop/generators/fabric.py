"""Fabric tests with an effect that nobody declares: written down from textbooks, not from hyperfab's own laws.

Units: MPa, s, degC, degrees from the warp. A specimen is led along a program of turns; what it answers is computed by
plain loops over fine steps and then read at the rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDS = (
    "anisotropy", "hysteresis", "rate", "mullins", "permanent-set", "thermal-softening", "grip-slack", "load-offset",
    "compressibility", "elastic-law",
)  # fmt: skip
OUTSIDE = ("ripple", "one-gain", "stick-slip", "fatigue-stiffening")


@dataclass
class Setup:
    """What is done to one specimen."""

    mode: str = "uniaxial"
    angle: float = 0.0
    rate: float = 0.01
    temperature: float = 23.0
    turns: Sequence[float] = ()
    hold: float = 0.0
    points: int = 60


@dataclass
class Reading:
    """What is read of one specimen: rows of time, stretch, stress, and transverse stretch where it was measured."""

    setup: Setup
    time: Array
    stretch: Array
    stress: Array
    transverse: Array | None = None
    specimen: str = ""


@dataclass
class Truth:
    """A fabric nobody declared: an elastic law and the effects on it."""

    effects: tuple[str, ...]
    elastic: Callable[[str, Array], Array]
    draws: dict[str, dict[str, float]] = field(default_factory=dict)


def rich(turn: float, rate: float, hot: float) -> list[Setup]:
    """Two directions, two rates, two temperatures, cycles to two amplitudes, a second mode, a replicate."""
    middle = 1.0 + 0.55 * (turn - 1.0)
    steps = (middle, 1.0, middle, 1.0, turn, 1.0, turn, 1.0)
    return [
        Setup(turns=steps, rate=rate),
        Setup(turns=steps, rate=rate),
        Setup(turns=steps, rate=16.0 * rate),
        Setup(turns=steps, rate=rate, temperature=hot),
        Setup(turns=steps, rate=rate, angle=90.0),
        Setup(turns=(turn, 1.0, turn, 1.0), rate=16.0 * rate, angle=90.0, temperature=hot),
        Setup(mode="shear", turns=(turn, 1.0), rate=rate),
    ]


def poor(turn: float, rate: float, hot: float) -> list[Setup]:
    """One rate, one cycle, one direction, one temperature."""
    return [Setup(turns=(turn, 1.0), rate=rate), Setup(turns=(turn, 1.0), rate=rate)]


def elastic_law(random: Generator, kind: str) -> Callable[[str, Array], Array]:
    """Return nominal stress of (mode, stretch): Rivlin-type, Ogden in principal stretches, or a limited chain."""
    level = float(random.uniform(0.1, 0.6))
    if kind == "plain":
        a, b, c = level, level * random.uniform(0.05, 0.3), level * random.uniform(0.02, 0.15)

        def energy_slope(i: Array) -> Array:
            return a + b * i + c * i * i

    elif kind == "limited":
        limit = random.uniform(1.6, 3.0)

        def energy_slope(i: Array) -> Array:
            return level / (1.0 - np.minimum(i / limit, 0.98))

    else:
        b = random.uniform(1.2, 3.0)

        def energy_slope(i: Array) -> Array:
            return level * np.exp(b * i)

    def stress(mode: str, lam: Array) -> Array:
        if mode == "uniaxial":
            i = lam**2 + 2.0 / lam - 3.0
            return (lam - lam**-2.0) * energy_slope(i)
        if mode == "shear":
            i = lam**2 + lam**-2.0 - 2.0
            return (lam - lam**-3.0) * energy_slope(i)
        i = 2.0 * lam**2 + lam**-4.0 - 3.0
        return (lam - lam**-5.0) * energy_slope(i)

    return stress


def draw(random: Generator, effects: Sequence[str], strength: float = 1.0) -> Truth:
    """Return a fabric with these effects, their kind and size drawn at random."""
    kind = "plain"
    if "elastic-law" in effects:
        kind = str(random.choice(["limited", "exponential"]))
    truth = Truth(tuple(effects), elastic_law(random, kind))
    for effect in effects:
        truth.draws[effect] = {
            "size": strength * float(random.uniform(0.5, 1.5)),
            "shape": float(random.uniform(0.0, 1.0)),
            "kind": float(random.integers(0, 3)),
        }
    return truth


def measure(
    truth: Truth, setups: Sequence[Setup], random: Generator, noise: float, scatter: float = 0.0
) -> list[Reading]:
    """Carry out the tests: readings with white noise of sd ``noise`` [MPa] and a stiffness per specimen."""
    found = []
    for number, setup in enumerate(setups):
        reading = _answer(truth, setup, number)
        gain = 1.0 + scatter * float(random.standard_normal())
        reading.stress = gain * reading.stress + noise * random.standard_normal(len(reading.stress))
        if reading.transverse is not None:
            reading.transverse = reading.transverse + 0.002 * random.standard_normal(len(reading.stress))
        reading.specimen = f"s{number}"
        found.append(reading)
    return found


def _answer(truth: Truth, setup: Setup, number: int) -> Reading:
    fine = 4
    lam, t = program(setup, fine)
    d = truth.draws
    strain = lam - 1.0
    if "grip-slack" in d:
        slack = 0.03 * d["grip-slack"]["size"]
        if d["grip-slack"]["kind"] < 1:  # a round toe
            w = 0.5 * slack
            strain = w * np.logaddexp(0.0, (strain - slack) / w) - w * math.log1p(math.exp(-slack / w))
        else:
            strain = np.maximum(strain - slack, 0.0)
    if "permanent-set" in d:
        strain = _with_set(strain, d["permanent-set"])
    own = 1.0 + np.maximum(strain, 0.0)
    p = truth.elastic(setup.mode, own)
    transverse = None
    if "compressibility" in d:
        p, transverse = _foam_like(truth, setup.mode, own, 0.5 - 0.2 * d["compressibility"]["size"])
    if "anisotropy" in d:
        p = _fibres(p, own, setup.angle, d["anisotropy"])
    if "thermal-softening" in d:
        p = p * _warm(setup.temperature, d["thermal-softening"])
    if "mullins" in d:
        p = p * _mullins(own, d["mullins"])
    if "hysteresis" in d:
        p = _loop(own, p, d["hysteresis"])
    if "rate" in d:
        p = p + _viscous(p, t, d["rate"])
    if "load-offset" in d:
        top = float(np.max(truth.elastic("uniaxial", np.array([1.6]))))
        p = p + 0.05 * d["load-offset"]["size"] * top * (1.0 if d["load-offset"]["shape"] < 0.5 else -1.0)
    p = _outside(truth, p, lam, t, number)
    keep = slice(None, None, fine)
    return Reading(setup, t[keep], lam[keep], p[keep], None if transverse is None else transverse[keep])


def program(setup: Setup, fine: int) -> tuple[Array, Array]:
    """Return the stretches the machine drives and their times [s]: the protocol, whatever the material does."""
    lam, t = [np.array([1.0])], [np.array([0.0])]
    for number, turn in enumerate(setup.turns):
        here, now = float(lam[-1][-1]), float(t[-1][-1])
        way = np.linspace(here, turn, setup.points * fine + 1)[1:]
        lam.append(way)
        t.append(now + np.abs(way - here) / setup.rate)
        if number == 0 and setup.hold > 0.0:
            lam.append(np.full(setup.points * fine, turn))
            t.append(float(t[-1][-1]) + setup.hold * np.linspace(0.0, 1.0, setup.points * fine + 1)[1:] ** 3)
    return np.concatenate(lam), np.concatenate(t)


def _with_set(strain: Array, draw: dict[str, float]) -> Array:
    """Plastic strain: a power of the largest strain that shows when let go, or flow above a yield strain."""
    peak = np.maximum.accumulate(strain)
    if draw["kind"] < 1:
        kept = 0.12 * draw["size"] * peak ** (1.0 + 0.4 * draw["shape"])
        return np.where(strain >= peak, strain, (strain - kept) * peak / np.maximum(peak - kept, 1e-9))
    begins = 0.05 * draw["shape"]
    return strain - 0.1 * draw["size"] * np.maximum(peak - begins, 0.0)


def _foam_like(truth: Truth, mode: str, lam: Array, nu: float) -> tuple[Array, Array | None]:
    """A one-term compressible Ogden (hyperfoam) sheet, alpha 2: lateral stretch lam^-nu, pressure in closed form."""
    level = float(truth.elastic("uniaxial", np.array([1.0 + 1e-4]))[0]) / 3e-4
    beta = nu / (1.0 - 2.0 * nu)
    rise = truth.elastic("uniaxial", lam) / np.where(lam > 1.0, level * (lam - lam**-2.0), 1.0)
    rise = np.where(lam > 1.0, rise, 1.0)
    if mode == "uniaxial":
        j = lam ** (1.0 - 2.0 * nu)
        return level * rise * (lam - j ** (-2.0 * beta) / lam), lam**-nu
    other = 1.0 if mode == "shear" else lam
    thick = (lam * other) ** (-nu / (1.0 - nu))
    j = lam * other * thick
    rise = truth.elastic(mode, lam) / np.where(
        lam > 1.0, level * (lam - 1.0 / (lam**3 * (other if mode == "shear" else lam) ** 2)), 1.0
    )
    rise = np.where(lam > 1.0, rise, 1.0)
    return level * rise * (lam - j ** (-2.0 * beta) / lam), None


def _fibres(p: Array, lam: Array, angle: float, draw: dict[str, float]) -> Array:
    """A second family: weaker by a factor, or without the exponential fibres that the warp has."""
    along = math.cos(math.radians(angle)) ** 2
    if draw["kind"] < 1:
        return p * (along + (1.0 - along) / (1.0 + 0.6 * draw["size"]))
    e = lam**2 - 1.0
    fibre = e * np.exp(0.3 * draw["shape"] * e**2) * lam
    size = 0.3 * draw["size"] * float(np.max(p)) / max(float(np.max(fibre)), 1e-12)
    return p + along * size * fibre


def _warm(temperature: float, draw: dict[str, float]) -> float:
    if draw["kind"] < 1:
        return 1.0 - 0.004 * draw["size"] * (temperature - 23.0)
    kelvin = temperature + 273.15
    return math.exp(500.0 * draw["size"] * (1.0 / kelvin - 1.0 / 296.15))


def _mullins(lam: Array, draw: dict[str, float]) -> Array:
    peak = np.maximum.accumulate(lam)
    share = np.where(peak > 1.0, (lam - 1.0) / np.maximum(peak - 1.0, 1e-12), 1.0)
    if draw["kind"] < 1:
        return 1.0 - 0.4 * draw["size"] * (1.0 - share ** (0.7 + draw["shape"])) * np.minimum((peak - 1.0) / 0.3, 1.0)
    wm, w = peak**2 + 2.0 / peak - 3.0, lam**2 + 2.0 / lam - 3.0
    return 1.0 - 0.4 * draw["size"] * np.tanh((wm - w) / (0.15 + 0.3 * wm))


def _loop(lam: Array, p: Array, draw: dict[str, float]) -> Array:
    """Five Jenkins sliders in parallel (Iwan), stronger where the fabric is loaded; or a bent way down."""
    top = float(np.max(p))
    if draw["kind"] < 2:
        found = p.copy()
        for yields in np.geomspace(0.01, 0.12, 5):
            force, before = 0.0, 1.0
            for i in range(len(lam)):
                limit = 0.04 * draw["size"] * (p[i] if draw["kind"] < 1 else 0.5 * top)
                force = min(max(force + limit * (lam[i] - before) / yields, -limit), limit)
                before = lam[i]
                found[i] += force
        return found
    found = p.copy()
    turn, high = 1.0, 0.0
    power = 1.0 + 0.5 * draw["size"]
    for i in range(1, len(lam)):
        if lam[i] >= lam[i - 1]:
            turn, high = lam[i], p[i]
        elif high > 0.0 and turn > 1.0:
            found[i] = high * (max(p[i], 0.0) / high) ** power
    return found


def _viscous(p: Array, t: Array, draw: dict[str, float]) -> Array:
    """A Maxwell element with an Eyring dashpot (explicit steps), or a spectrum of four relaxation times."""
    whole = float(t[-1])
    if draw["kind"] < 1:
        tau, softer = 10.0 ** (0.3 + 1.2 * draw["shape"]), 0.15 * float(np.max(p))
        q = np.zeros_like(p)
        for i in range(1, len(p)):
            q[i] = q[i - 1] + 0.5 * draw["size"] * (p[i] - p[i - 1])
            left = t[i] - t[i - 1]
            while left > 0.0:
                pace = softer / tau * math.sinh(min(abs(q[i]) / softer, 20.0))
                step = min(left, 0.2 * abs(q[i]) / pace if pace > 0.0 else left)
                q[i] -= math.copysign(pace * step, q[i])
                left -= max(step, 1e-9 * whole)
        return q
    found = np.zeros_like(p)
    taus = np.geomspace(1.0, 100.0, 4) if draw["kind"] < 2 else [10.0 ** (0.5 + draw["shape"])]
    for tau in taus:
        h = 0.0
        for i in range(1, len(p)):
            dt = t[i] - t[i - 1]
            pull = 0.5 * draw["size"] / len(taus) * (p[i] - p[i - 1])
            if dt < tau:  # the trapezoidal rule
                h = (h + pull) * (2.0 * tau - dt) / (2.0 * tau + dt)
            else:
                h = h * math.exp(-dt / tau) + pull * tau / dt * (1.0 - math.exp(-dt / tau))
            found[i] += h
    return found


def _outside(truth: Truth, p: Array, lam: Array, t: Array, number: int) -> Array:
    """What no catalogue has."""
    top = float(np.max(p))
    d = truth.draws
    if "ripple" in d:
        p = p + 0.06 * d["ripple"]["size"] * top * np.sin(2.0 * np.pi * (lam - 1.0) / 0.06 + d["ripple"]["shape"])
    if "one-gain" in d and number in (2, 4):
        p = p * (
            1.0
            + (0.25 if number == 2 else -0.2) * d["one-gain"]["size"] * (1.0 if d["one-gain"]["shape"] < 0.5 else -1.0)
        )
    if "stick-slip" in d:
        phase = (lam - 1.0) / (0.04 + 0.02 * d["stick-slip"]["shape"])
        p = p + 0.08 * d["stick-slip"]["size"] * top * (phase - np.floor(phase) - 0.5)
    if "fatigue-stiffening" in d:
        turns = np.cumsum(np.concatenate([[0.0], (np.diff(lam)[1:] > 0) & (np.diff(lam)[:-1] < 0), [0.0]]))[: len(p)]
        p = p * (1.0 + 0.15 * d["fatigue-stiffening"]["size"] * np.sqrt(turns))
    return p
