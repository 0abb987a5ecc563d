"""A second, independent set of fabrics with an effect nobody declares: other laws and other protocols than ``fabric``.

Each effect comes in several kinds, of which some are forms of the catalogue too (test_generators counts them):
hysteresis as Bouc-Wen, as a Masing loop or as play operators (Prandtl-Ishlinskii); rate as a power law, a springpot or
a Norton dashpot; damage that runs on with cycles; a set exponential in the largest strain; a toe as tanh.
Units: MPa, s, degC, degrees from the warp.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from loop.generators.fabric import Reading, Setup, program
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Effects and how many kinds of each there are.
KINDS = {
    "anisotropy": 4, "hysteresis": 5, "rate": 5, "mullins": 5, "permanent-set": 4, "thermal-softening": 4,
    "grip-slack": 4, "load-offset": 3, "compressibility": 3, "elastic-law": 4,
}  # fmt: skip
OUTSIDE = ("late-yield", "healing", "wrong-gauge", "saturation", "humid-air")


@dataclass
class Truth:
    """A fabric nobody declared."""

    effects: tuple[str, ...]
    elastic: Callable[[str, Array], Array]
    draws: dict[str, dict[str, float]] = field(default_factory=dict)
    seed: int = 0


def protocol(random: Generator) -> list[Setup]:
    """Return a rich protocol, its turns, rates, temperatures, rows and modes drawn at random."""
    turn, rate = float(random.uniform(1.3, 1.8)), float(10.0 ** random.uniform(-2.5, -1.3))
    hot, fast = float(random.uniform(55.0, 90.0)), float(random.choice([10.0, 16.0, 50.0])) * rate
    middle, rows = 1.0 + float(random.uniform(0.45, 0.7)) * (turn - 1.0), int(random.integers(45, 80))
    steps = (middle, 1.0, middle, 1.0, turn, 1.0, turn, 1.0)
    found = [
        Setup(turns=steps, rate=rate, points=rows),
        Setup(turns=steps, rate=rate, points=rows),
        Setup(turns=steps, rate=fast, points=rows),
        Setup(turns=steps, rate=rate, temperature=hot, points=rows),
        Setup(turns=steps, rate=rate, angle=90.0, points=rows),
        Setup(mode=str(random.choice(["shear", "biaxial"])), turns=(turn, 1.0), rate=rate, points=rows),
    ]
    if random.uniform() < 0.5:
        found.append(Setup(turns=(turn, 1.0), rate=rate, temperature=0.5 * (hot + 23.0), points=rows))
    if random.uniform() < 0.5:
        found.append(Setup(turns=(turn, 1.0, turn, 1.0), rate=fast, angle=90.0, hold=5.0 / rate, points=rows))
    return found


def elastic_law(random: Generator, kind: str) -> Callable[[str, Array], Array]:
    """Return nominal stress of (mode, stretch) from dW/dI1 and dW/dI2."""
    a = float(random.uniform(0.05, 0.6))
    second = 0.0
    if kind == "plain":
        b, c = a * random.uniform(0.05, 0.25), a * random.uniform(0.02, 0.1)

        def first(i: Array) -> Array:
            return a + b * i + c * i * i

    elif kind == "chain":  # Langevin chains by their Pade approximant
        limit = float(random.uniform(1.25, 1.6)) ** 2

        def first(i: Array) -> Array:
            y = np.minimum((i + 3.0) / 3.0 / limit, 0.97)
            return a * (3.0 - y) / (1.0 - y) / 3.0

    elif kind == "toe":  # a fabric whose yarns straighten
        at, wide = float(random.uniform(0.2, 0.6)), float(random.uniform(0.08, 0.2))

        def first(i: Array) -> Array:
            return a * (0.3 + 1.5 / (1.0 + np.exp(-(i - at) / wide)))

    elif kind == "second-invariant":
        second = a * float(random.uniform(0.3, 0.8))

        def first(i: Array) -> Array:
            return a + 0.0 * i

    else:
        b = float(random.uniform(1.0, 2.5))

        def first(i: Array) -> Array:
            return a * np.exp(b * i) * (1.0 + 0.3 * i)

    def stress(mode: str, lam: Array) -> Array:
        other = {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[mode]
        thick = 1.0 / (lam * other)
        i1 = lam**2 + other**2 + thick**2 - 3.0
        pull = lam - thick**2 / lam
        return pull * (first(i1) + second * other**2)

    return stress


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the kind of the first."""
    base = "plain"
    truth_kind = {}
    for number, effect in enumerate(effects):
        most = KINDS.get(effect, 1)
        truth_kind[effect] = kind % most if kind is not None and number == 0 else int(random.integers(0, most))
    if "elastic-law" in effects:
        base = ("chain", "toe", "second-invariant", "exponential")[truth_kind["elastic-law"]]
    truth = Truth(tuple(effects), elastic_law(random, base), seed=int(random.integers(0, 2**31)))
    for effect in effects:
        truth.draws[effect] = {
            "kind": float(truth_kind[effect]),
            "size": float(random.uniform(0.5, 1.5)),
            "shape": float(random.uniform(0.0, 1.0)),
        }
    return truth


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests: readings with white noise of sd ``noise`` [MPa]."""
    return noisy([_answer(truth, setup, number) for number, setup in enumerate(setups)], random, noise)


def noisy(readings: list[Reading], random: Generator, noise: float) -> list[Reading]:
    """Return readings of one specimen each with white noise of sd ``noise`` [MPa], and 0.002 of the width."""
    for number, reading in enumerate(readings):
        reading.stress = reading.stress + noise * random.standard_normal(len(reading.stress))
        if reading.transverse is not None:
            reading.transverse = reading.transverse + 0.002 * random.standard_normal(len(reading.stress))
        reading.specimen = f"s{number}"
    return readings


def _answer(truth: Truth, setup: Setup, number: int) -> Reading:
    fine = 4
    lam, t = program(setup, fine)
    d = truth.draws
    own = lam
    if "grip-slack" in d:
        own = _slack(own, d["grip-slack"], truth.seed, number)
    if "permanent-set" in d:
        own = _set(own, d["permanent-set"])
    own = np.maximum(own, 1.0)
    p, transverse = truth.elastic(setup.mode, own), None
    if "compressibility" in d:
        p, transverse = _volume(truth, setup.mode, own, d["compressibility"])
    if "anisotropy" in d:
        p = _two_ways(p, own, setup, d["anisotropy"])
    if "thermal-softening" in d:
        p = p * _warm(own, setup.temperature, d["thermal-softening"])
    if "mullins" in d:
        p = p * _damage(own, d["mullins"])
    if "hysteresis" in d:
        p = _loops(own, p, d["hysteresis"])
    if "rate" in d:
        p = _viscous(p, own, t, setup, d["rate"])
    if "load-offset" in d:
        p = _offset(truth, p, t, d["load-offset"], number)
    p = _outside(truth, p, lam, t, number)
    keep = slice(None, None, fine)
    return Reading(setup, t[keep], lam[keep], p[keep], None if transverse is None else transverse[keep])


def _slack(lam: Array, draw: dict[str, float], seed: int, number: int) -> Array:
    strain, slack = lam - 1.0, 0.03 * draw["size"]
    kind = int(draw["kind"])
    if kind == 0:  # a toe as tanh
        w = slack * (0.7 + draw["shape"])
        return 1.0 + strain - slack * np.tanh(strain / w)
    if kind == 1:  # each specimen mounted with a slack of its own
        slack *= float(np.random.default_rng([seed, number]).uniform(0.3, 1.7))
        return 1.0 + np.maximum(strain - slack, 0.0)
    if kind == 2:  # yarns tighten: an exponential approach to the full slope
        return 1.0 + strain - slack * (1.0 - np.exp(-strain / slack))
    return 1.0 + np.where(strain < 2.0 * slack, strain**2 / (4.0 * slack), strain - slack)


def _set(lam: Array, draw: dict[str, float]) -> Array:
    kind, size, shape = int(draw["kind"]), draw["size"], draw["shape"]
    peak = np.maximum.accumulate(lam)
    if kind == 0:  # exponential in the largest strain, as flow
        b = 1.5 + 2.0 * shape
        return lam - 0.06 * size * np.expm1(b * (peak - 1.0)) / np.expm1(0.5 * b)
    if kind == 1:  # a multiplicative plastic stretch that begins at a yield stretch
        begins = 1.0 + 0.1 * shape
        return lam / np.maximum(peak / begins, 1.0) ** (0.15 * size)
    if kind == 2:  # more with every cycle: Armstrong-Frederick like creep of the rest length
        rest, most = np.zeros_like(lam), 0.15 * size
        for i in range(1, len(lam)):
            pace = 3.0 * (most * (peak[i] - 1.0) - rest[i - 1])
            rest[i] = rest[i - 1] + max(pace, 0.0) * max(lam[i] - lam[i - 1], 0.0)
        return lam - rest
    # A set seen on the way down and after, linear there, in the power 1.3 of the peak.
    kept = 0.12 * size * (peak - 1.0) ** 1.3
    share = np.clip((lam - 1.0 - kept) / np.maximum(peak - 1.0 - kept, 1e-9), 0.0, None)
    return np.where(lam >= peak, lam, 1.0 + share * (peak - 1.0))


def _two_ways(p: Array, lam: Array, setup: Setup, draw: dict[str, float]) -> Array:
    kind, size, shape = int(draw["kind"]), draw["size"], draw["shape"]
    c2 = 0.5 if setup.mode == "biaxial" else math.cos(math.radians(setup.angle)) ** 2
    s2, e = 1.0 - c2, lam - 1.0
    if kind == 0:  # the weft softer and straighter
        return p * (c2 + s2 / (1.0 + 0.5 * size) * (1.0 + shape * e) / (1.0 + shape * 0.3))
    if kind == 1:  # dispersed fibres along the warp (Gasser, Ogden, Holzapfel)
        kappa = 0.05 + 0.2 * shape
        other = 1.0 if setup.mode == "shear" else (lam if setup.mode == "biaxial" else lam**-0.5)
        i1 = lam**2 + other**2 + (lam * other) ** -2.0
        i4 = c2 * lam**2 + s2 * other**2
        strain = np.maximum(kappa * (i1 - 3.0) + (1.0 - 3.0 * kappa) * (i4 - 1.0), 0.0)
        pull = kappa + (1.0 - 3.0 * kappa) * c2
        return p + 0.5 * size * float(np.max(p)) / 0.5 * strain * np.exp(0.4 * strain**2) * pull * lam * 0.4
    if kind == 2:  # the weft stiffens late
        return p * c2 + s2 * p * (0.5 + 0.5 / (1.0 + np.exp(-(e - 0.25) / 0.07)) * size)
    return p * (c2 + s2 * (1.0 + 0.6 * size))


def _warm(lam: Array, temperature: float, draw: dict[str, float]) -> Array:
    kind, size = int(draw["kind"]), draw["size"]
    rise, kelvin = temperature - 23.0, temperature + 273.15
    if kind == 0:
        return np.full_like(lam, math.exp(700.0 * size * (1.0 / kelvin - 1.0 / 296.15)))
    if kind == 1:  # a glass-like step
        return np.full_like(lam, 1.0 - 0.35 * size * 0.5 * (1.0 + math.tanh((temperature - 50.0) / 20.0)))
    if kind == 2:  # the stiffening at large strain softens less than the start
        return 1.0 - 0.004 * size * rise * (1.0 - 0.5 * np.clip((lam - 1.0) / 0.6, 0.0, 1.0))
    return np.full_like(lam, 1.0 / (1.0 + 0.005 * size * rise))


def _damage(lam: Array, draw: dict[str, float]) -> Array:
    kind, size, shape = int(draw["kind"]), draw["size"], draw["shape"]
    peak = np.maximum.accumulate(lam)
    below = np.where(peak > 1.0, (lam - 1.0) / np.maximum(peak - 1.0, 1e-12), 1.0)
    if kind == 0:  # exponential in the distance to the peak
        return 1.0 - 0.35 * size * (1.0 - np.exp(-(peak - lam) / (0.05 + 0.2 * shape)))
    if kind == 1:  # more with every cycle
        turns = np.concatenate([[0.0], np.cumsum((np.diff(lam, append=lam[-1])[1:] < 0) & (np.diff(lam) >= 0))])
        runs = 1.0 - 0.6 ** np.maximum(turns, 0.0)
        return 1.0 - 0.5 * size * runs * (1.0 - below**1.5)
    if kind == 2:  # damage of the whole curve by the largest stretch, saturating
        return 1.0 - 0.45 * size * (1.0 - np.exp(-(((peak - 1.0) / (0.3 + 0.3 * shape)) ** 2)))
    if kind == 3:  # a share of the network broken: sqrt of the difference of first invariants
        i, im = lam**2 + 2.0 / lam - 3.0, peak**2 + 2.0 / peak - 3.0
        return np.exp(-0.35 * size * np.sqrt(np.maximum(im - i, 0.0)))
    w, wm = (lam - 1.0) ** 2, (peak - 1.0) ** 2
    return 1.0 - 0.4 * size * np.minimum((wm - w) / (0.02 + wm), 1.0) ** (0.6 + 0.8 * shape)


def _loops(lam: Array, p: Array, draw: dict[str, float]) -> Array:
    kind, size, shape = int(draw["kind"]), draw["size"], draw["shape"]
    top, n = float(np.max(p)), len(lam)
    if kind == 0:  # Bouc-Wen
        z, found, most, stiff = 0.0, p.copy(), 0.08 * size * top, 0.08 * size * top / (0.02 + 0.06 * shape)
        for i in range(1, n):
            step = lam[i] - lam[i - 1]
            z += stiff * (step - 0.5 * abs(step) * z / most - 0.5 * step * abs(z) / most)
            found[i] += z
        return found
    if kind == 1:  # stop operators with a density of widths, on the stress (Prandtl-Ishlinskii)
        found = p.copy()
        for width, weight in zip(0.3 * size * top * np.array([0.1, 0.25, 0.5]), (0.5, 0.3, 0.3), strict=True):
            y = 0.0
            for i in range(n):
                y = min(max(y, p[i] - width), p[i] + width)
                found[i] += weight * (p[i] - y)
        return found
    if kind == 2:  # the way down an exponential of its own between turn and rest
        found, k = p.copy(), 1.0 + 2.0 * size
        high, at = 0.0, 1.0
        for i in range(1, n):
            if lam[i] >= lam[i - 1]:
                high, at = p[i], lam[i]
            elif at > 1.0:
                share = (lam[i] - 1.0) / (at - 1.0)
                mine = 0.5 * share * high * math.exp(-k * (1.0 - share)) + 0.5 * p[i]
                found[i] = min(mine, p[i])
        return found
    if kind == 3:  # yarn friction in proportion to tension (capstan), turning over a strain
        sign, found, wide = 0.0, p.copy(), 0.01 + 0.05 * shape
        for i in range(1, n):
            step = lam[i] - lam[i - 1]
            sign += (math.copysign(1.0, step) - sign) * min(abs(step) / wide, 1.0) if step else 0.0
            found[i] = p[i] * math.exp(0.12 * size * sign)
        return found
    # A Masing loop of a Ramberg-Osgood spring beside the elastic one.
    found, stiff, yields = p.copy(), 1.5 * size * top * 0.15 / 0.1, 0.02 + 0.04 * shape
    from_lam, from_q, q, way = 1.0, 0.0, 0.0, 1.0
    for i in range(1, n):
        step = lam[i] - lam[i - 1]
        if step and math.copysign(1.0, step) != way:
            way, from_lam, from_q = math.copysign(1.0, step), lam[i - 1], q
        twice = 1.0 if from_q == 0.0 and from_lam == 1.0 else 2.0
        x = (lam[i] - from_lam) / twice
        q = from_q + twice * stiff * yields * math.tanh(x / yields)
        found[i] += q
    return found


def _viscous(p: Array, lam: Array, t: Array, setup: Setup, draw: dict[str, float]) -> Array:
    kind, size, shape = int(draw["kind"]), draw["size"], draw["shape"]
    top, n = max(float(np.max(p)), 1e-12), len(p)
    if kind == 0:  # a power law of the rate
        return p * (setup.rate / 0.03) ** (0.06 * size)
    if kind == 1:  # a springpot (Grunwald-Letnikov on a log-spaced sum of exponentials would be Prony: direct sum)
        order = 0.15 + 0.25 * shape
        found, step = p.copy(), np.diff(t)
        slope = np.where(step > 0.0, np.diff(p) / np.where(step > 0.0, step, 1.0), 0.0)
        for i in range(1, n):
            ago, near = t[i] - t[:i], t[i] - t[1 : i + 1]
            found[i] += 0.5 * size * float(slope[:i] @ (ago ** (1.0 - order) - near ** (1.0 - order))) * 3.0**order
        return found
    if kind == 2:  # a Maxwell element on the strain, not the stress
        tau, stiff, q, found = 10.0 ** (0.3 + 1.3 * shape), 0.5 * size * top, 0.0, p.copy()
        for i in range(1, n):
            dt = t[i] - t[i - 1]
            q = (q + stiff * (lam[i] - lam[i - 1])) / (1.0 + dt / tau)
            found[i] += q
        return found
    if kind == 3:  # a Norton dashpot of power 3 in series with a spring that follows the stress
        tau, level, q, found = 10.0 ** (0.3 + 1.0 * shape), 0.1 * top, 0.0, p.copy()
        for i in range(1, n):
            dt = t[i] - t[i - 1]
            q += 0.5 * size * (p[i] - p[i - 1])
            for _ in range(20):
                q -= dt / 20.0 * q / tau * min((q / level) ** 2, 20.0 * tau / dt * 0.5)
            found[i] += q
        return found
    # A Zener solid whose branch stiffens with stretch.
    tau, q, found = 10.0 ** (0.5 + shape), 0.0, p.copy()
    for i in range(1, n):
        dt = t[i] - t[i - 1]
        q = q * math.exp(-dt / tau) + 0.4 * size * (p[i] * lam[i] - p[i - 1] * lam[i - 1])
        found[i] += q / lam[i]
    return found


def _offset(truth: Truth, p: Array, t: Array, draw: dict[str, float], number: int) -> Array:
    top = float(truth.elastic("uniaxial", np.array([1.6]))[0])
    sign = 1.0 if draw["shape"] < 0.5 else -1.0
    size, kind = sign * 0.05 * draw["size"] * top, int(draw["kind"])
    if kind == 0:
        return p + size
    if kind == 1:  # zeroed anew before each specimen, a little wrong each time
        return p + size * float(np.random.default_rng([truth.seed, number, 1]).uniform(0.4, 1.6))
    return p + size * (0.6 + 0.8 * (1.0 - np.exp(-t / 60.0)))  # an amplifier that warms up


def _volume(truth: Truth, mode: str, lam: Array, draw: dict[str, float]) -> tuple[Array, Array | None]:
    """A contraction of its own; the law's slope on what is left of the driving stretch."""
    kind = int(draw["kind"])
    nu = 0.5 - 0.2 * draw["size"]
    if mode == "uniaxial":
        if kind == 0:
            across = lam**-nu
        elif kind == 1:
            across = 1.0 - nu * (lam - 1.0) / (1.0 + 0.3 * draw["shape"] * (lam - 1.0))
        else:
            across = lam ** -(nu + 0.1 * draw["shape"] * (1.0 - 1.0 / lam))
        thick, other = across, across
    else:
        other = np.ones_like(lam) if mode == "shear" else lam
        thick = (lam * other) ** (-nu / (1.0 - nu))
    old_other = {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[mode]
    old = lam - 1.0 / (lam**3 * old_other**2)
    slope = np.where(lam > 1.0 + 1e-9, truth.elastic(mode, lam) / np.where(old > 0.0, old, 1.0), 1.0)
    return slope * (lam - thick**2 / lam), other if mode == "uniaxial" else None


def _outside(truth: Truth, p: Array, lam: Array, t: Array, number: int) -> Array:
    """What no catalogue has."""
    d, top = truth.draws, float(np.max(p))
    if "late-yield" in d:
        at = 1.0 + (0.55 + 0.2 * d["late-yield"]["shape"]) * (float(np.max(lam)) - 1.0)
        p = p - 0.15 * d["late-yield"]["size"] * top * np.exp(-(((lam - at) / 0.015) ** 2))
    if "healing" in d:
        p = p * (1.0 + 0.15 * d["healing"]["size"] * np.sin(2.1 * number + 6.0 * d["healing"]["shape"]))
    if "wrong-gauge" in d and number in (1, 4):
        p = np.interp(1.0 + (lam - 1.0) * (1.0 - 0.12 * d["wrong-gauge"]["size"]), np.sort(lam), np.sort(p))
    if "saturation" in d:
        level = (0.75 - 0.2 * d["saturation"]["shape"]) * top
        p = np.minimum(p, level)
    if "humid-air" in d:
        p = p * (1.0 + 0.1 * d["humid-air"]["size"] * np.sin(2.0 * np.pi * t / (0.13 * float(t[-1]) + 1e-9)))
    return p
