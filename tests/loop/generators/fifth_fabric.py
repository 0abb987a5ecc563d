"""A fifth set of stretch fabrics, written apart from the loop and from the other sets: two to four ways of each effect.

The ways are those of the literature of elastomers, knits, wovens and of testing practice that are not each effect's
first formula; none of the plain laws (``fifth_energy``) is a polynomial. Nothing is tuned to this set. Noise is a floor
and a part in proportion to the reading, together of the sd that is asked for. Units: MPa, s, degC.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist

import numpy as np
from loop.generators.fabric import Reading, Setup, program
from loop.generators.fifth_energy import LAWS, SHARES, SPHERE, Array, Cloth, Table, table
from numpy.random import Generator

__all__ = ["KINDS", "OUTSIDE", "Truth", "draw", "measure", "protocol"]

KINDS = {
    "anisotropy": 2, "hysteresis": 3, "rate": 3, "mullins": 4, "permanent-set": 3, "thermal-softening": 3,
    "grip-slack": 2, "load-offset": 2, "compressibility": 2, "elastic-law": 4,
}  # fmt: skip
#: A cloth as stiff as the air of the room is dry, which swings; stitches that run, each at a load of its own.
OUTSIDE = ("humidity", "stitch-run")
_ROOM, _KELVIN, _GAS, _FINE = 23.0, 273.15, 8.314, 3
#: Beyond these amounts a way would be no cloth's any more.
_MOST = {"thermal-softening": 0.7, "compressibility": 0.42, "permanent-set": 0.6, "mullins": 0.5, "grip-slack": 0.3}


@dataclass
class Truth:
    """A plain law, its effects, and the numbers drawn for them; ``top`` is about its greatest stress [MPa]."""

    effects: tuple[str, ...]
    cloth: Cloth
    draws: dict[str, dict[str, float]] = field(default_factory=dict)
    top: float = 1.0
    seed: int = 0

    def of(self, effect: str) -> dict[str, float] | None:
        """Return the numbers of an effect, None where the fabric lacks it."""
        return self.draws[effect] if effect in self.effects else None

    def rest(self) -> Cloth:
        """Return what it is made of, time, cycles and warmth apart."""
        if (d := self.of("elastic-law")) is not None:
            own = self.cloth._replace(law=LAWS[int(d["kind"])], sharp=True)
        else:
            own = self.cloth
        return own._replace(yarns=self.of("anisotropy"), pores=self.of("compressibility"))

    def alone(self, number: int, setup: Setup) -> Generator:
        """Return the chances of one specimen, the same whenever that specimen is measured."""
        return np.random.default_rng([self.seed, number, len(setup.turns), round(1e7 * setup.rate)])


def protocol(random: Generator) -> list[Setup]:
    """Draw a programme: cycles in two or three steps, rates, temperatures, both ways of the cloth, another mode."""
    furthest, points = random.uniform(0.35, 0.6), int(random.integers(45, 66))
    slow = 10.0 ** random.uniform(-2.8, -2.2)
    fast, hot = slow * random.uniform(8.0, 30.0), _ROOM + random.uniform(25.0, 45.0)
    steps = (0.6, 0.6, 1.0, 1.0) if random.random() < 0.5 else (0.4, 0.7, 1.0, 1.0)
    turns = tuple(float(one) for step in steps for one in (1.0 + step * furthest, 1.0))
    hold = random.uniform(120.0, 600.0) if random.random() < 0.5 else 0.0
    base = Setup(turns=turns, rate=slow, hold=hold, points=points)
    whole = replace(base, turns=turns[-4:])
    setups = [base, base, replace(base, rate=fast), replace(base, temperature=hot), replace(base, angle=90.0)]
    setups.append(replace(whole, angle=90.0, rate=fast, temperature=hot))
    setups.append(replace(whole, rate=math.sqrt(slow * fast), temperature=0.5 * (_ROOM + hot), hold=0.0))
    if random.random() < 0.5:
        setups.append(replace(whole, angle=45.0))
    setups.append(replace(whole, mode="biaxial" if random.random() < 0.5 else "shear", hold=0.0))
    return setups


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the kind of the first.

    Each is of 2 to 5 % of the peak (rms) over one programme, without what another plain law could take of it: a change
    in proportion to the stress and to one and two powers of the strain. An amount stops where a way would be no
    cloth's any more.
    """
    numbers = (float(random.random()), float(random.random()), float(random.random()))
    cloth = Cloth(LAWS[int(random.integers(len(LAWS)))], numbers)
    truth = Truth(tuple(effects), cloth, {}, 1.0, int(random.integers(2**31)))
    truth.top = float(np.interp(1.5, *table(cloth, "uniaxial", 0.0, 1.6)[:2]))
    usual = [replace(one, points=14) for one in protocol(np.random.default_rng(11))]
    readings = _clean(replace(truth, effects=()), usual)
    plain = np.concatenate([one.stress for one in readings])
    strain = np.concatenate([one.stretch for one in readings]) - 1.0
    takes = np.linalg.qr(plain[:, None] * strain[:, None] ** np.arange(3))[0]
    for number, effect in enumerate(effects):
        own = kind if kind is not None and number == 0 else int(random.integers(KINDS.get(effect, 1)))
        size = float(random.uniform(0.02, 0.05)) * float(np.max(plain))
        d = {"kind": float(own), "u": float(random.random()), "v": float(random.random()), "amount": 0.1}
        truth.draws[effect] = d
        if effect == "elastic-law":
            continue
        for _ in range(6):
            having = np.concatenate([one.stress for one in _clean(replace(truth, effects=(effect,)), usual)])
            gap = having - plain
            gap = gap - takes @ (takes.T @ gap)
            grown = d["amount"] * size / max(float(np.sqrt(np.mean(gap**2))), 1e-9)
            d["amount"] = float(np.clip(grown, 0.25 * d["amount"], min(4.0 * d["amount"], _MOST.get(effect, 1.0))))
    return truth


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests: noise of sd ``noise`` [MPa] over all rows, more where the load is more; 0.002 of widths."""
    readings = _clean(truth, setups)
    square = float(np.mean(np.concatenate([one.stress**2 for one in readings])))
    for number, one in enumerate(readings):
        sd = noise * np.sqrt(0.6 + 0.4 * one.stress**2 / square)
        one.stress = one.stress + sd * random.standard_normal(len(one.stress))
        if one.transverse is not None:
            one.transverse = one.transverse + 0.002 * random.standard_normal(len(one.stress))
        one.specimen = f"s{number}"
    return readings


def _clean(truth: Truth, setups: Sequence[Setup]) -> list[Reading]:
    furthest = 1.02 * max(max(one.turns) for one in setups)
    ways = {(one.mode, one.angle if "anisotropy" in truth.effects else 0.0) for one in setups}
    tables = {way: table(truth.rest(), *way, furthest) for way in sorted(ways)}
    own = "anisotropy" in truth.effects
    return [_answer(truth, one, number, tables[one.mode, own * one.angle]) for number, one in enumerate(setups)]


def _answer(truth: Truth, setup: Setup, number: int, still: Table) -> Reading:
    lam, t = program(setup, _FINE)
    held = _gripped(truth, setup, number, lam, still)
    longer = _lengthened(truth, setup, held, t, still)
    warm = longer * _expanded(truth, setup)
    own = np.maximum(held / warm, 1.0)
    p = np.interp(own, still.stretch, still.stress) / warm
    p = p * _damage(truth, own, p, still) * _warmth(truth, setup, own)
    p = p * _elsewhere(truth, setup, number, own, t)
    p = np.maximum(p + _friction(truth, own, p) + _flow(truth, own, p, t), 0.0)
    p = p + _zero(truth, setup, number, p, t)
    rows = slice(None, None, _FINE)
    width = np.interp(own, still.stretch, still.width) * warm / longer / np.sqrt(longer)
    return Reading(setup, t[rows], lam[rows], p[rows], width[rows] if setup.mode == "uniaxial" else None)


def _gripped(truth: Truth, setup: Setup, number: int, lam: Array, still: Table) -> Array:
    """Return the stretch between the jaws' ends.

    Kind 0: cloth comes out of the jaws as they seat themselves, exponentially in the load, and stays out.
    Kind 1: a dead travel of each specimen's own, gamma distributed, and grips that give in proportion to the load.
    """
    if (d := truth.of("grip-slack")) is None:
        return lam
    chance = truth.alone(number, setup)
    if d["kind"] < 1:
        most = 0.2 * d["amount"] * math.exp(0.25 * chance.standard_normal())
        out = most * (1.0 - np.exp(-still.stress / ((0.05 + 0.25 * d["u"]) * truth.top)))
        so_far = np.maximum.accumulate(lam)
        return lam - (so_far - np.interp(so_far, still.stretch + out, still.stretch))
    travel = 0.15 * d["amount"] * float(chance.gamma(3.0)) / 3.0
    gives = still.stretch + travel + (0.03 + 0.07 * d["u"]) * d["amount"] * still.stress / truth.top
    return np.interp(lam, gives, still.stretch)


def _lengthened(truth: Truth, setup: Setup, held: Array, t: Array, still: Table) -> Array:
    """Return the natural length that a specimen has got.

    Kind 0: yarns locked by friction up to an elastic strain, which hardens with the square root of the slip.
    Kind 1: a flow by the load, activated by temperature, towards a limit.
    Kind 2: ratchetting: each unit of way leaves a share of what lacks to a set that follows from the greatest strain.
    """
    if (d := truth.of("permanent-set")) is None:
        return np.ones_like(held)
    h = np.log(np.maximum(held, 1.0))
    if d["kind"] < 1:
        hard = 0.1 * (1.0 / max(d["amount"], 1e-3) - 1.0)
        over = np.maximum(np.maximum.accumulate(h) - (0.03 + 0.09 * d["u"]), 0.0)
        return np.exp(0.25 * (np.sqrt(hard**2 + 4.0 * over) - hard) ** 2)
    if d["kind"] < 2:
        kelvin = setup.temperature + _KELVIN
        quicker = math.exp((1.5e4 + 2e4 * d["u"]) / _GAS * (1.0 / (_ROOM + _KELVIN) - 1.0 / kelvin))
        load = np.interp(held, still.stretch, still.stress) / truth.top
        pace = quicker / (100.0 + 300.0 * d["v"]) * load**1.5
        done = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(t))])
        return np.exp(0.5 * d["amount"] * (1.0 - np.exp(-done)))
    aim = 0.6 * d["amount"] * np.maximum.accumulate(h) ** 1.5
    return np.exp(_led(aim, np.abs(np.diff(h)) / (0.2 + 0.6 * d["v"])))


def _led(aim: Array, shares: Array) -> Array:
    """Return what follows an aim, by a share of the gap in each step, and never goes back."""
    value, found = 0.0, [0.0]
    for where, share in zip(aim[1:], shares, strict=True):
        value += max(where - value, 0.0) * -math.expm1(-share)
        found.append(value)
    return np.array(found)


def _expanded(truth: Truth, setup: Setup) -> float:
    """Return the growth of the natural length with the temperature: 1 to 2.5e-4 per degree, of kind 1."""
    d = truth.of("thermal-softening")
    if d is None or int(d["kind"]) != 1:
        return 1.0
    return 1.0 + (1e-4 + 1.5e-4 * d["v"]) * (setup.temperature - _ROOM)


def _warmth(truth: Truth, setup: Setup, own: Array) -> Array:
    """Return how stiff the cloth is in this warmth.

    Kind 0: chains that pull in proportion to the temperature beside bonds in two states (enthalpy against entropy).
    Kind 1: towards a melting point, as a power of what lacks to it; the length grows beside.
    Kind 2: crystals that stretching makes, which melt about a transition: the more stretched, the more is lost.
    """
    if (d := truth.of("thermal-softening")) is None:
        return np.ones_like(own)
    kelvin, room = setup.temperature + _KELVIN, _ROOM + _KELVIN
    if d["kind"] < 1:
        heat, middle = (6e4 + 6e4 * d["u"]) / _GAS, 318.0 + 25.0 * d["v"]
        bound, then = (1.0 / (1.0 + math.exp(heat * (1.0 / middle - 1.0 / one))) for one in (kelvin, room))
        return np.full_like(own, (1.0 - d["amount"]) * kelvin / room + d["amount"] * bound / then)
    if d["kind"] < 2:
        melts = 390.0 + 60.0 * d["u"]
        return np.full_like(own, (max(melts - kelvin, 2.0) / (melts - room)) ** (4.0 * d["amount"]))
    lost, before = (1.0 / (1.0 + math.exp((38.0 + 10.0 * d["v"] + _KELVIN - one) / 6.0)) for one in (kelvin, room))
    gone = (lost - before) / (1.0 - before)
    crystals: Array = 1.0 - np.exp(-(((own - 1.0) / (0.1 + 0.2 * d["u"])) ** 2))
    return 1.0 - d["amount"] * gone * crystals


def _damage(truth: Truth, own: Array, p: Array, still: Table) -> Array:
    """Return what a stretch before has left of the stress.

    Kind 0: chains of each direction of space, softened by the greatest stretch of that direction (after Diani).
    Kind 1: bonds that survive the greatest load by Weibull's law, beside chains that do not break.
    Kind 2: driven by cycles: each unit of way breaks a share of what the greatest stretch can break.
    Kind 3: pseudo-elastic: lost below the greatest energy by a hyperbola of what lacks to it, whole again at it.
    """
    if (d := truth.of("mullins")) is None:
        return np.ones_like(own)
    scale = 0.1 + 0.3 * d["u"]
    if d["kind"] < 1:
        wide = np.interp(own, still.stretch, still.width)
        squares = SPHERE**2 @ np.stack([own, wide, np.interp(own, still.stretch, still.thickness)]) ** 2
        worst = np.maximum.accumulate(np.sqrt(np.maximum(squares, 1.0)), axis=1)
        weights = SHARES[:, None] * SPHERE[:, :1] ** 2 * (np.maximum(squares - 1.0, 0.0) + 1e-6)
        broken = d["amount"] * (1.0 - np.exp(-(worst - 1.0) / scale))
        return 1.0 - np.sum(weights * broken, axis=0) / np.sum(weights, axis=0)
    if d["kind"] < 2:
        worst = np.maximum.accumulate(p) / ((0.3 + 0.5 * d["v"]) * truth.top)
        return 1.0 - d["amount"] * (1.0 - np.exp(-(worst ** (1.0 + 1.5 * d["u"]))))
    if d["kind"] < 3:
        aim = d["amount"] * (1.0 - np.exp(-(np.maximum.accumulate(own) - 1.0) / scale))
        return 1.0 - _led(aim, np.abs(np.diff(own)) / (0.2 + 0.8 * d["v"]))
    steps = 0.5 * (still.stress[1:] + still.stress[:-1]) * np.diff(still.stretch)
    energy = np.interp(own, still.stretch, np.concatenate([[0.0], np.cumsum(steps)]))
    lacks = 1.0 - energy / np.maximum(np.maximum.accumulate(energy), 1e-12)
    return 1.0 - d["amount"] * lacks / (lacks + 0.1 + 0.5 * d["v"])


def _friction(truth: Truth, own: Array, p: Array) -> Array:
    """Return what friction adds [MPa], at whatever rate.

    Kind 0: Bouc and Wen's smooth loop, tighter the more the yarns are pulled together.
    Kind 1: yarns wound around each other (Euler's rope), stuck before they slide as Dahl has it; straightening unwinds.
    Kind 2: sliders in parallel, whose slips are log-normal (Iwan).
    """
    if (d := truth.of("hysteresis")) is None:
        return np.zeros_like(own)
    length, z = 0.01 + 0.04 * d["u"], 0.0
    if d["kind"] > 1:
        ranks = [NormalDist().inv_cdf((k + 0.5) / 15.0) for k in range(15)]
        slips = 2.0 * length * np.exp((0.5 + 0.5 * d["v"]) * np.array(ranks))
        forces, state = [0.0], np.zeros(15)
        for step in np.diff(own):
            state = np.clip(state + step, -slips, slips)
            forces.append(float(np.mean(state / slips)))
        return 0.3 * d["amount"] * truth.top * np.array(forces)
    power, found = 1.0 + d["v"] * (d["kind"] < 1), [0.0]
    for step in np.diff(own):
        pieces = max(1, math.ceil(4.0 * abs(step) / length))
        for _ in range(pieces):
            way = step / pieces / length
            against = 1.0 if way * z > 0.0 else 0.2 if d["kind"] < 1 else -1.0
            z += way * (1.0 - against * abs(z) ** power)
        z = min(max(z, -1.0), 1.0)
        found.append(z)
    loop = np.array(found)
    if d["kind"] < 1:
        return 0.4 * d["amount"] * truth.top * loop * (0.1 + p / truth.top)
    wound = 1.0 - (0.3 + 0.5 * d["v"]) * np.clip(own - 1.0, 0.0, 1.0)
    return p * np.expm1(d["amount"] * wound * loop)


def _flow(truth: Truth, own: Array, p: Array, t: Array) -> Array:
    """Return what depends on the rate [MPa].

    Kind 0: a spring on Eyring's dashpot: its flow goes with the sinh of the load.
    Kind 1: a spring-pot: a fractional derivative of the plain stress, of order 0.12 to 0.35.
    Kind 2: a network whose flow goes with a power of its load and slows down as it has crept (Bergstrom & Boyce).
    """
    if (d := truth.of("rate")) is None:
        return np.zeros_like(own)
    if int(d["kind"]) == 1:
        order = 0.12 + 0.23 * d["u"]
        gaps = np.maximum(t[:, None] - t[None, :], 0.0) ** (1.0 - order)
        slopes = np.diff(p) / np.diff(t)
        return 2.0 * d["amount"] * 60.0**order / math.gamma(2.0 - order) * ((gaps[:, :-1] - gaps[:, 1:]) @ slopes)
    if d["kind"] < 1:
        least, width = 10.0 ** (-5.0 + 1.3 * d["u"]), 0.015 + 0.03 * d["v"]

        def flows(x: float, _: float) -> float:
            return least * math.sinh(min(x / width, 300.0))

    else:
        power, pace = 2.5 + 2.5 * d["u"], 10.0 ** (-3.5 + d["v"])

        def flows(x: float, crept: float) -> float:
            return pace * (x / 0.08) ** power / (math.expm1(abs(crept)) + 0.05) * 0.1

    return 6.0 * d["amount"] * truth.top * _branch(np.log(own), t, flows) / own


def _branch(h: Array, t: Array, flows: Callable[[float, float], float]) -> Array:
    """Return the elastic strain of a spring whose dashpot flows: backwards Euler, by bisection."""
    x, found = 0.0, [0.0]
    for strain, step, dt in zip(h[1:], np.diff(h), np.diff(t), strict=True):
        trial, crept = x + float(step), float(strain - step) - x
        low, high = 0.0, abs(trial)
        for _ in range(36):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if middle + dt * flows(middle, crept) > abs(trial) else (middle, high)
        x = math.copysign(0.5 * (low + high), trial)
        found.append(x)
    return np.array(found)


def _zero(truth: Truth, setup: Setup, number: int, p: Array, t: Array) -> Array:
    """Return what the load cell says beside the load [MPa].

    Kind 0: a zero that was set once and wanders as the electronics warm up, from specimen to specimen.
    Kind 1: the lower grip's weight, tared by hand for each specimen, and a cell whose gauges creep after the load.
    """
    if (d := truth.of("load-offset")) is None:
        return np.zeros_like(p)
    size = d["amount"] * truth.top
    if d["kind"] < 1:
        return 0.5 * size * (1.0 - np.exp(-(900.0 * number + t) / (1200.0 + 4000.0 * d["u"])))
    lag, creep = 100.0 + 400.0 * d["v"], [0.0]
    for load, dt in zip(p[1:], np.diff(t), strict=True):
        creep.append(creep[-1] + (load - creep[-1]) * -math.expm1(-dt / lag))
    tare = 0.3 + 0.25 * d["u"] * truth.alone(number, setup).uniform(-1.0, 1.0)
    return size * tare + 0.2 * d["amount"] * np.array(creep)


def _elsewhere(truth: Truth, setup: Setup, number: int, own: Array, t: Array) -> Array:
    """Return what is in no catalogue: the room's humidity, which swings; stitches that run at loads of their own."""
    gain = np.ones_like(own)
    if d := truth.of("humidity"):
        clock = (1300.0 * number + t) / (500.0 + 1200.0 * d["u"])
        gain = gain * (1.0 + d["amount"] * np.sin(2.0 * math.pi * (clock + d["v"])))
    if d := truth.of("stitch-run"):
        chance, so_far = truth.alone(number, setup), np.maximum.accumulate(own)
        for _ in range(int(chance.integers(0, 4))):
            at, lost = 1.0 + 0.5 * chance.uniform(0.2, 1.0), chance.uniform(0.3, 1.0)
            gain = gain * np.where(so_far >= at, 1.0 - 0.8 * d["amount"] * lost, 1.0)
    return gain
