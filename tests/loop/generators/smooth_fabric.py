"""Fabrics whose effects go with their state variables by smooth functions drawn at random, on plain laws of other make.

No formula of an effect is written down: how a loop turns, how a stress relaxes, how much a past stretch weakens is a
random monotone curve. This is the set that the loop's smooth laws are developed on. Units: MPa, s, degC.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from loop.generators.fabric import Reading, Setup, program
from loop.generators.other_fabric import noisy, protocol
from numpy.random import Generator
from numpy.typing import NDArray

__all__ = ["KINDS", "OUTSIDE", "Truth", "draw", "measure", "protocol"]

Array = NDArray[np.float64]
Curve = Callable[[Array], Array]

#: Ways in which each effect is built of its random curves.
KINDS = {
    "anisotropy": 2, "hysteresis": 3, "rate": 3, "mullins": 2, "permanent-set": 2, "thermal-softening": 2,
    "grip-slack": 2, "load-offset": 2, "compressibility": 2, "elastic-law": 2,
}  # fmt: skip
#: A stress that depends on what other specimens have seen before, and one that swings with the stretch.
OUTSIDE = ("wear-of-the-machine", "waves")
_BASES = ("gent", "ogden", "tube", "random")


@dataclass
class Truth:
    """A plain law, its effects, and the seed of their curves."""

    effects: tuple[str, ...]
    elastic: str
    draws: dict[str, dict[str, float]] = field(default_factory=dict)
    seed: int = 0

    def of(self, effect: str) -> tuple[dict[str, float], Generator]:
        """Return the size and kind of an effect, and the source of its curves."""
        return self.draws[effect], np.random.default_rng([self.seed, *map(ord, effect)])


def rising(random: Generator, rough: float = 1.0) -> Curve:
    """Return a monotone curve from (0, 0) through (1, 1): the integral of the exponential of three cosines."""
    size, phase = rough * random.normal(size=3) / np.arange(1.0, 4.0), random.uniform(0.0, 2.0 * np.pi, 3)
    at = np.linspace(0.0, 2.0, 401)
    slope = np.exp(sum(s * np.cos(k * 2.0 * at + p) for k, s, p in zip((1, 2, 3), size, phase, strict=True)))
    value = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]))])
    value /= np.interp(1.0, at, value)
    return lambda x: np.interp(x, at, value)


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the way of the first."""
    base = _BASES[int(random.integers(len(_BASES)))]
    base = "tube" if base == "ogden" and "elastic-law" in effects else base  # invariants can be added to
    truth = Truth(tuple(effects), base, seed=int(random.integers(2**31)))
    for number, effect in enumerate(effects):
        own = int(random.integers(KINDS.get(effect, 1)))
        truth.draws[effect] = {
            "kind": float(kind if kind is not None and number == 0 else own),
            "size": float(random.uniform(0.6, 1.4)),
        }
    return truth


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests: readings with white noise of sd ``noise`` [MPa]."""
    return noisy([_answer(truth, setup, number) for number, setup in enumerate(setups)], random, noise)


def elastic(truth: Truth, mode: str, lam: Array, width: Array | None = None) -> Array:
    """Return the stress of the plain law, with ``width`` the second stretch where a sheet contracts otherwise."""
    random = np.random.default_rng([truth.seed, 1])
    mu, u = float(np.exp(random.uniform(-1.5, 0.0))), random.uniform(size=4)
    side = {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[mode]
    side = side if width is None else width
    thick = 1.0 / (lam * side)
    i1 = np.maximum(lam**2 + side**2 + thick**2 - 3.0, 0.0)
    if truth.elastic == "ogden":
        found = np.zeros_like(lam)
        for share, alpha in ((0.7, -2.0 + 3.0 * u[0]), (0.3, 3.0 + 4.0 * u[1])):
            found += 2.0 * mu * share / alpha * (lam**alpha - thick**alpha) / lam
        return found
    if truth.elastic == "gent":
        first = mu / (1.0 - i1 / (5.0 + 10.0 * u[0]))
    elif truth.elastic == "tube":
        first = mu * (0.6 + 0.4 * np.exp(-i1 / (0.1 + 0.4 * u[0])) + 0.3 * u[1] * i1)
    else:
        curve = rising(np.random.default_rng([truth.seed, 2]), 0.5)
        first = mu * (0.7 + 0.6 * u[0] * curve(i1 / 3.0))
    second = mu * 0.2 * u[2] / (1.0 + i1)
    if "elastic-law" in truth.effects:
        d, own = truth.of("elastic-law")
        if d["kind"] < 1:
            first = first * (1.0 + 2.0 * d["size"] * rising(own)(i1 / 2.0))
        else:
            second = second + mu * d["size"] * (0.3 + rising(own)(i1 / 2.0))
    return np.asarray((lam - thick**2 / lam) * (first + second * side**2))


def _answer(truth: Truth, setup: Setup, number: int) -> Reading:
    lam, t = program(setup, 4)
    e, own = lam - 1.0, truth.effects
    top = float(elastic(truth, "uniaxial", np.array([1.6]))[0])
    if "grip-slack" in own:
        d, random = truth.of("grip-slack")
        way, curve = 0.03 * d["size"], rising(random)
        e = e - way * (np.minimum(curve(e / (3.0 * way)), 1.0) if d["kind"] < 1 else curve(e / 0.5) ** 0.3)
        e = np.maximum(e, 0.0)
    if "permanent-set" in own:
        d, random = truth.of("permanent-set")
        stays = 0.05 * d["size"] * rising(random)(np.maximum.accumulate(e) / 0.6)
        if d["kind"] > 0:  # it comes with the way rather than the farthest point
            arc = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(e)))])
            stays = stays * (0.5 + 0.5 * (1.0 - np.exp(-arc)))
        e = np.maximum((1.0 + e) / (1.0 + stays) - 1.0, 0.0)
    own_lam = 1.0 + e
    width = own_lam**-0.5 if setup.mode == "uniaxial" else None
    if width is not None and "compressibility" in own:
        d, random = truth.of("compressibility")
        fall = 0.15 * d["size"] * rising(random)(np.log(own_lam) / 0.5)
        width = width * np.exp(fall * (1.0 if d["kind"] < 1 else own_lam - 0.9))
    p = elastic(truth, setup.mode, own_lam, width if "compressibility" in own else None)
    if "anisotropy" in own:
        d, random = truth.of("anisotropy")
        across = (
            math.sin(math.radians(setup.angle)) ** 2 if setup.mode == "uniaxial" else 0.5 * (setup.mode == "biaxial")
        )
        strain = own_lam**2 - 1.0
        more = top * 0.4 * d["size"] * rising(random)(strain / 1.5) * own_lam
        p = p + (across if d["kind"] < 1 else 1.0 - across) * more
    if "thermal-softening" in own:
        d, random = truth.of("thermal-softening")
        fall = 0.25 * d["size"] * rising(random)(np.array([(setup.temperature - 23.0) / 50.0]))[0]
        p = p * (1.0 - fall * (1.0 if d["kind"] < 1 else 1.3 - rising(random)(e / 0.6) * 0.6))
    if "mullins" in own:
        d, random = truth.of("mullins")
        most = np.maximum(np.maximum.accumulate(e), 1e-9)
        deep, shape = rising(random), rising(random)
        p = p * (1.0 - 0.35 * d["size"] * deep(most / 0.6) * (1.0 - shape(np.minimum(e / most, 1.0))))
        if d["kind"] > 0:  # a little is lost of the first pull too
            p = p * (1.0 - 0.15 * d["size"] * deep(most / 0.6))
    if "hysteresis" in own:
        p = p + _loop(truth, e, p, top)
    if "rate" in own:
        p = p + _viscous(truth, e, p, t)
    if "load-offset" in own:
        d, random = truth.of("load-offset")
        day = rising(random)((0.1 * number + t / 1e5) % 2.0) if d["kind"] > 0 else random.choice([-0.7, 0.7])
        p = p + 0.06 * d["size"] * top * day
    if "wear-of-the-machine" in own:
        p = p * (1.0 + 0.12 * truth.of("wear-of-the-machine")[0]["size"] * math.sqrt(number))
    if "waves" in own:
        p = p * (1.0 + 0.12 * truth.of("waves")[0]["size"] * np.sin(2.0 * np.pi * e / 0.09))
    rows = slice(None, None, 4)
    return Reading(setup, t[rows], lam[rows], p[rows], None if width is None else width[rows])


def _loop(truth: Truth, e: Array, p: Array, top: float) -> Array:
    """Play of many widths, its density and how it grows with the load drawn at random."""
    d, random = truth.of("hysteresis")
    widths = np.geomspace(0.004, 0.25, 9)
    dense = np.exp(random.normal(size=9)) * np.exp(-0.5 * (np.log(widths / 0.03) / 1.0) ** 2)
    grows, along = rising(random), (e if d["kind"] < 2 else p / top * 0.6)
    hold = (grows(np.maximum(p, 0.0) / top) if d["kind"] != 1 else 0.5 * np.minimum(e / 0.05, 1.0)) * top
    now, out = np.zeros(9), [0.0]
    for step, level in zip(np.diff(along), hold[1:], strict=True):
        now = np.clip(now + 2.0 * step / widths, -1.0, 1.0)
        out.append(float(now @ dense) * level)
    return 0.12 * d["size"] * np.array(out) / float(dense.sum())


def _viscous(truth: Truth, e: Array, p: Array, t: Array) -> Array:
    """A spectrum drawn at random; of stress, of stress that stiffens, or one that shifts with the load."""
    d, random = truth.of("rate")
    times = np.geomspace(0.5, 500.0, 13)
    dense = np.exp(1.0 * random.normal(size=13)) * np.exp(-0.5 * (np.log(times / 15.0) / 1.5) ** 2)
    dense *= 0.6 * d["size"] / dense.sum()
    drive = p * (1.0 if d["kind"] < 1 else 1.0 + random.uniform(-0.6, 0.8) * e)
    q, out, quick = np.zeros(13), [0.0], random.uniform(0.5, 3.0) if d["kind"] > 1 else 0.0
    for step, dt, load in zip(np.diff(drive), np.diff(t), p[1:] / max(float(np.max(p)), 1e-9), strict=True):
        left = np.exp(-dt * math.exp(quick * load) / times)
        q = q * left + dense * step * np.sqrt(left)
        out.append(float(q.sum()))
    return np.array(out)
