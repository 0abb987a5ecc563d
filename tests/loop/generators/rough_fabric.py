"""Fabrics whose effects go with two state variables at once by random smooth functions, on random smooth plain laws.

Harder than ``smooth_fabric``: no amount is a function of one variable alone, tests are also cut at an angle and held,
and no specimen bears compression. Names on strangers' laws are developed on this set. Units: MPa, s, degC.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from loop.generators import smooth_fabric
from loop.generators.fabric import Reading, Setup, program
from loop.generators.other_fabric import noisy
from loop.generators.other_fabric import protocol as usual
from loop.generators.smooth_fabric import Array, elastic, rising
from numpy.random import Generator

__all__ = ["KINDS", "OUTSIDE", "Truth", "draw", "measure", "protocol"]

#: Ways in which each effect is built of its random curves.
KINDS = dict.fromkeys(
    ("anisotropy", "hysteresis", "rate", "mullins", "permanent-set", "thermal-softening", "grip-slack",
     "load-offset", "compressibility", "elastic-law"), 2,
)  # fmt: skip
#: A stiffness that comes back with rest, and a load cell that turns soft towards its end.
OUTSIDE = ("rest", "soft-cell")


class Truth(smooth_fabric.Truth):
    """A plain law, its effects, and the seed of their curves."""


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the way of the first."""
    return Truth(**vars(smooth_fabric.draw(random, effects, kind)))


def protocol(random: Generator) -> list[Setup]:
    """Return a rich protocol, often with a test cut at an angle and a hold."""
    found = usual(random)
    first, fast = found[0], found[2].rate
    turn = max(first.turns)
    if random.uniform() < 0.6:
        angle = float(random.uniform(25.0, 65.0))
        found.append(Setup(turns=(turn, 1.0), rate=first.rate, angle=angle, points=first.points))
    if random.uniform() < 0.6:
        hold = float(random.uniform(2.0, 8.0)) / first.rate
        found.append(Setup(turns=(turn, 1.0), rate=fast, hold=hold, points=first.points))
    return found


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests: readings with white noise of sd ``noise`` [MPa]."""
    return noisy([_answer(truth, setup, number) for number, setup in enumerate(setups)], random, noise)


def _answer(truth: Truth, setup: Setup, number: int) -> Reading:
    lam, t = program(setup, 4)
    e, own, hot = lam - 1.0, truth.effects, (setup.temperature - 23.0) / 50.0
    across = math.sin(math.radians(setup.angle)) ** 2
    top = float(elastic(truth, "uniaxial", np.array([1.6]))[0])
    if "grip-slack" in own:  # what is wound up in the grips gives with the load, at once or as it goes on
        d, random = truth.of("grip-slack")
        way, curve = 0.03 * d["size"], rising(random)
        load = np.maximum(elastic(truth, setup.mode, lam), 0.0) / top
        gives = np.minimum(curve(load * 4.0) if d["kind"] < 1 else curve(e / 0.1), 1.0 + 0.1 * load)
        e = np.maximum(e - way * gives, 0.0)
    if "permanent-set" in own:
        e = np.maximum((1.0 + e) / (1.0 + _set(truth, setup, e, t, top)) - 1.0, 0.0)
    own_lam = 1.0 + e
    width = own_lam**-0.5 if setup.mode == "uniaxial" else None
    if width is not None and "compressibility" in own:
        d, random = truth.of("compressibility")
        more = 1.0 if d["kind"] < 1 else 1.0 + 0.6 * across
        width = width * np.exp(0.15 * d["size"] * more * rising(random)(np.log(own_lam) / 0.5))
    p = elastic(truth, setup.mode, own_lam, width if "compressibility" in own else None)
    if "anisotropy" in own:
        p = p + _threads(truth, setup, own_lam, top)
    if "thermal-softening" in own:
        d, random = truth.of("thermal-softening")
        fall = 0.25 * d["size"] * rising(random)(np.array([hot]))[0]
        p = p * (1.0 - fall * (1.2 - 0.5 * rising(random)(e / 0.6))) if hot > 0.0 else p
        p = p + (fall * 0.1 * top * np.tanh(e / 0.05) if d["kind"] > 0 else 0.0)  # entropy: a little stiffer at first
    if "mullins" in own:
        d, random = truth.of("mullins")
        energy = np.maximum(np.concatenate([[0.0], np.cumsum(0.5 * (p[1:] + p[:-1]) * np.diff(lam))]), 0.0)
        most = np.maximum(np.maximum.accumulate(e), 1e-9)
        worst = np.maximum(np.maximum.accumulate(energy if d["kind"] < 1 else np.abs(p)), 1e-9)
        level = np.minimum(e / most, 1.0)
        deep, shape = rising(random), rising(random)
        p = p * (1.0 - 0.35 * d["size"] * deep(worst / (0.25 * top if d["kind"] < 1 else top)) * (1.0 - shape(level)))
    if "hysteresis" in own:
        p = p + _loop(truth, e, p, top, across)
    if "rate" in own or "rest" in own:
        p = _relaxing(truth, e, p, t, top)
    p = np.maximum(p, 0.0)
    if "soft-cell" in own:
        d, random = truth.of("soft-cell")
        p = p / (1.0 + 0.2 * d["size"] * (p / top) ** 3)
    if "load-offset" in own:
        d, random = truth.of("load-offset")
        day = rising(random)(0.15 * number + 0.5 * t / t[-1]) if d["kind"] > 0 else 0.6 + rising(random)(t / 5e3 % 2.0)
        p = p + 0.05 * d["size"] * top * day
    rows = slice(None, None, 4)
    return Reading(setup, t[rows], lam[rows], p[rows], None if width is None else width[rows])


def _set(truth: Truth, setup: Setup, e: Array, t: Array, top: float) -> Array:
    """A set that flows towards what the load of the moment asks for, in its time or at once and on with the way."""
    d, random = truth.of("permanent-set")
    asks, quick = rising(random), float(np.exp(random.uniform(1.0, 5.0)))
    load = np.maximum(elastic(truth, setup.mode, 1.0 + e), 0.0) / top
    aim = 0.08 * d["size"] * asks(load)
    if d["kind"] > 0:
        return np.asarray(np.maximum.accumulate(aim) * (0.6 + 0.4 * asks(np.maximum.accumulate(e) / 0.6)))
    now, out = 0.0, [0.0]
    for dt, goal in zip(np.diff(t), aim[1:], strict=True):
        now += max(goal - now, 0.0) * -math.expm1(-dt / quick)
        out.append(now)
    return np.array(out)


def _threads(truth: Truth, setup: Setup, lam: Array, top: float) -> Array:
    """Threads that lie around a direction: what they bear rides on their own stretch, and scissors a little."""
    d, random = truth.of("anisotropy")
    middle, spread, bears = (
        float(random.choice([0.0, 90.0])),
        float(random.uniform(5.0, 30.0)),
        rising(random),
    )
    side = {"uniaxial": lam**-0.5, "shear": np.ones_like(lam), "biaxial": lam}[setup.mode]
    found = np.zeros_like(lam)
    for turn in np.linspace(-2.0, 2.0, 9):
        angle = math.radians(middle + turn * spread - setup.angle)
        i4 = (lam * math.cos(angle)) ** 2 + (side * math.sin(angle)) ** 2
        weight = math.exp(-0.5 * turn**2) / 4.0
        slope = bears(np.maximum(i4 - 1.0, 0.0) / 1.5)
        found += (
            weight
            * slope
            * (lam * math.cos(angle) ** 2 - 0.5 * (setup.mode == "uniaxial") * math.sin(angle) ** 2 / lam**2)
        )
    return np.asarray(0.5 * d["size"] * top * found)


def _loop(truth: Truth, e: Array, p: Array, top: float, across: float) -> Array:
    """Play of many widths, which grow with the strain, held by the load of the moment and by a constant part."""
    d, random = truth.of("hysteresis")
    widths = np.geomspace(0.005, 0.2, 8)
    dense = np.exp(random.normal(size=8)) * np.exp(-0.5 * (np.log(widths / 0.03) / 1.0) ** 2)
    grows = rising(random)
    hold = 0.3 * np.minimum(e / 0.05, 1.0) + grows(np.maximum(p, 0.0) / top) * (
        1.0 if d["kind"] < 1 else 0.7 + 0.6 * across
    )
    now, out = np.zeros(8), [0.0]
    for step, level, far in zip(np.diff(e), hold[1:], e[1:], strict=True):
        now = np.clip(now + 2.0 * step / (widths * (1.0 + far)), -1.0, 1.0)
        out.append(float(now @ dense) * level * top)
    return np.asarray(0.12 * d["size"] * np.array(out) / float(dense.sum()))


def _relaxing(truth: Truth, e: Array, p: Array, t: Array, top: float) -> Array:
    """A random spectrum whose share goes with the strain; or a stiffness that a pull takes and rest gives back."""
    if "rest" in truth.effects:
        d, random = truth.of("rest")
        now, out = 0.0, [0.0]
        for dt, load in zip(np.diff(t), p[1:] / top, strict=True):
            now += (0.3 * d["size"] * load - now) * -math.expm1(-dt / 60.0) if load > 0.2 else -now * dt / 90.0
            out.append(now)
        return p * (1.0 - np.clip(out, 0.0, 0.6))
    d, random = truth.of("rate")
    times = np.geomspace(0.5, 500.0, 13)
    dense = np.exp(1.0 * random.normal(size=13)) * np.exp(-0.5 * (np.log(times / 15.0) / 1.5) ** 2)
    dense *= 0.6 * d["size"] / dense.sum()
    drive = np.concatenate([[0.0], np.cumsum(np.diff(p) * (0.4 + rising(random, 0.5)(e[1:] / 0.6)))])
    q, out, quick = np.zeros(13), [0.0], random.uniform(0.5, 2.0) if d["kind"] > 0 else 0.0
    for step, dt, size in zip(np.diff(drive), np.diff(t), np.abs(p[1:]) / top, strict=True):
        left = np.exp(-dt * math.exp(quick * size) / times)
        q = q * left + dense * step * np.sqrt(left)
        out.append(float(q.sum()))
    return np.asarray(p + np.array(out))
