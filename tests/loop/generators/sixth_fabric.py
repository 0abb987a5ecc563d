"""A sixth set of stretch fabrics, written apart from the loop: two to four ways of each effect that no other set has.

A laboratory logs at a constant time step and thins its holds, so rows differ from specimen to specimen; it may store
the turns or miss them, test each condition twice or once, and rest the cloth between cycles. Noise has a few outliers,
a short memory (an amplifier's filter) and a converter's steps. Nothing is tuned to this set; its plain laws
(``sixth_energy``) are no polynomials. Units: MPa, s, degC.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from loop.generators.fabric import Reading, Setup
from loop.generators.sixth_energy import LAWS, Array, Cloth, Table, table
from loop.generators.sixth_loss import damage, flow, friction, less_amplified, most_so_far
from numpy.random import Generator

__all__ = ["KINDS", "OUTSIDE", "Run", "Truth", "draw", "measure", "protocol"]

KINDS = {
    "anisotropy": 3, "hysteresis": 3, "rate": 4, "mullins": 3, "permanent-set": 3, "thermal-softening": 3,
    "grip-slack": 3, "load-offset": 3, "compressibility": 2, "elastic-law": 4,
}  # fmt: skip
#: A crosshead that trembles at a beat with the logger; threads that snag and let go.
OUTSIDE = ("vibration", "snag")
_ROOM, _KELVIN = 20.0, 273.15
#: Beyond these amounts a way would be no cloth's any more.
_MOST = {
    "thermal-softening": 0.8, "compressibility": 0.5, "permanent-set": 0.8, "mullins": 0.7, "hysteresis": 0.7,
    "grip-slack": 0.6,
}  # fmt: skip


@dataclass
class Run(Setup):
    """What is done to one specimen, and how it is logged: ``step`` and ``rest`` (at each return) in s."""

    step: float = 0.0
    rest: float = 0.0
    stores_turns: bool = True


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
        own = self.cloth
        if (d := self.of("elastic-law")) is not None:
            own = own._replace(law=LAWS[int(d["kind"])], sharp=True)
        return own._replace(yarns=self.of("anisotropy"), pores=self.of("compressibility"))

    def alone(self, number: int, setup: Setup) -> Generator:
        """Return the chances of one specimen, the same whenever that specimen is measured."""
        return np.random.default_rng([self.seed, number, len(setup.turns), round(1e7 * setup.rate)])


def protocol(random: Generator) -> list[Setup]:
    """Draw a programme as laboratories of stretch fabrics have it: the machine's speed, cycles, climates, directions.

    The cycles climb in steps or go five times to one elongation, as standards on elasticity ask; there is a slow or a
    fast speed beside, a hold, one or two climates more, and a cross or a wide strip. Each condition is tested twice,
    or each once.
    """
    far, usual = random.uniform(0.3, 0.52), 10.0 ** random.uniform(-2.2, -1.4)
    other = usual * random.uniform(8.0, 25.0) ** (1.0 if random.random() < 0.3 else -1.0)
    hot, twice = random.uniform(45.0, 65.0), random.random() < 0.4
    climbs = tuple(float(one) for share in (0.35, 0.7, 0.7, 1.0, 1.0) for one in (1.0 + share * far, 1.0))
    five, once = (1.0 + far, 1.0) * 4, (1.0 + far, 1.0, 1.0 + far, 1.0)
    rest = random.uniform(20.0, 120.0) if random.random() < 0.5 else 0.0
    base = Run(turns=climbs, rate=usual, temperature=_ROOM, rest=rest)
    runs = [
        base, replace(base, turns=five), replace(base, rate=other, turns=climbs[2:]), replace(base, angle=90.0),
        replace(base, temperature=hot, turns=climbs[2:]),
        replace(base, turns=once, rate=max(usual, other), hold=random.uniform(90.0, 600.0)),
    ]  # fmt: skip
    if random.random() < 0.5:
        runs.append(replace(base, turns=once, angle=45.0))
    if random.random() < 0.5 or not twice:
        middle = 0.5 * (_ROOM + hot)
        runs.append(replace(base, turns=once, angle=90.0, rate=other, temperature=middle))
    gentle = 1.0 + random.uniform(0.6, 0.75) * far
    mode = "biaxial" if random.random() < 0.6 else "shear"
    runs.append(replace(base, mode=mode, turns=(gentle, 1.0, gentle, 1.0)))
    runs = [one for one in runs for _ in range(1 + twice)]
    stores, rows = random.random() < 0.5, (22.0, 34.0) if twice else (36.0, 60.0)
    found: list[Setup] = []
    for one in runs:
        way = float(np.mean(np.abs(np.diff((1.0, *one.turns)))))
        step = way / one.rate / random.uniform(*rows)
        found.append(replace(one, step=float(f"{step:.2g}"), stores_turns=stores))
    return found


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Return a fabric with these effects; ``kind`` fixes the kind of the first.

    Each is of 2 to 5 % of the peak (rms) over one programme, without what another plain law could take of it: a change
    in proportion to the stress and to one and two powers of the strain. An amount stops where a way would be no
    cloth's any more.
    """
    numbers = (float(random.random()), float(random.random()), float(random.random()))
    cloth = Cloth(LAWS[int(random.integers(len(LAWS)))], numbers)
    truth = Truth(tuple(effects), cloth, {}, 1.0, int(random.integers(2**31)))
    truth.top = float(table(cloth, "uniaxial", 0.0, 1.45).stress[-1])
    runs = [one for one in protocol(np.random.default_rng(7)) if isinstance(one, Run)]
    usual: list[Setup] = [replace(one, step=3.0 * one.step) for one in runs]
    readings = _clean(replace(truth, effects=()), usual)
    plain = np.concatenate([one.stress for one in readings])
    strain = np.concatenate([one.stretch for one in readings]) - 1.0
    takes = np.linalg.qr(plain[:, None] * strain[:, None] ** np.arange(3))[0]
    for number, effect in enumerate(effects):
        own = kind if kind is not None and number == 0 else int(random.integers(KINDS.get(effect, 1)))
        size = float(random.uniform(0.02, 0.05)) * float(np.max(plain))
        d = {"kind": float(own), "u": float(random.random()), "v": float(random.random())}
        truth.draws[effect] = d | {"w": float(random.random()), "amount": 0.1}
        if effect == "elastic-law":
            continue
        d = truth.draws[effect]
        for _ in range(6):
            having = np.concatenate([one.stress for one in _clean(replace(truth, effects=(effect,)), usual)])
            gap = having - plain
            gap = gap - takes @ (takes.T @ gap)
            grown = d["amount"] * size / max(float(np.sqrt(np.mean(gap**2))), 1e-9)
            d["amount"] = float(np.clip(grown, 0.25 * d["amount"], min(4.0 * d["amount"], _MOST.get(effect, 2.0))))
    return truth


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Carry out the tests; without ``noise`` [MPa], the sd of the stress over all rows, specimens are alike too.

    Specimens differ in stiffness by 0.2 to 1 % (of one lab, drawn). Widths are read with an sd of 0.002.
    """
    readings, lab = _clean(truth, setups), np.random.default_rng([truth.seed, 3])
    memory, scatter, step = lab.uniform(0.0, 0.3), lab.uniform(0.002, 0.01), lab.uniform(0.2, 0.8) * noise
    for number, one in enumerate(readings):
        one.specimen = f"strip {number + 1}"
        white = random.standard_t(7, len(one.stress) + 4) * math.sqrt(5.0 / 7.0)
        for k in range(1, len(white)):
            white[k] = memory * white[k - 1] + math.sqrt(1.0 - memory**2) * white[k]
        wide = random.standard_normal(len(one.stress))
        if noise > 0.0:
            one.stress = one.stress * (1.0 + scatter * float(np.clip(random.standard_normal(), -2.0, 2.0)))
            sd = math.sqrt(noise**2 - step**2 / 12.0)
            one.stress = np.round((one.stress + sd * white[4:]) / step) * step
        if one.transverse is not None:
            one.transverse = one.transverse + 0.002 * wide
    return readings


def _clean(truth: Truth, setups: Sequence[Setup]) -> list[Reading]:
    furthest = 1.02 * max(max(one.turns) for one in setups)
    own = "anisotropy" in truth.effects
    ways = {(one.mode, own * one.angle) for one in setups}
    tables = {way: table(truth.rest(), *way, furthest) for way in sorted(ways)}
    return [_answer(truth, one, number, tables[one.mode, own * one.angle]) for number, one in enumerate(setups)]


def _path(setup: Setup) -> tuple[Array, Array, Array]:
    """Return the machine's stretches and their times, finely, and the times of the rows.

    A hold at the first turn, rests at each return to the start; a hold is logged at up to 30 rows.
    """
    run = setup if isinstance(setup, Run) else Run(**vars(setup))
    step = run.step or float(np.mean(np.abs(np.diff((1.0, *run.turns))))) / run.rate / run.points
    lam, t, rows, here, now = [np.array([1.0])], [np.array([0.0])], [0.0], 1.0, 0.0
    for number, turn in enumerate(run.turns):
        waits = run.hold if number == 0 else run.rest if turn <= 1.0 and number + 1 < len(run.turns) else 0.0
        for to, lasts in ((float(turn), abs(turn - here) / run.rate), (float(turn), waits)):
            if lasts <= 0.0:
                continue
            count = 24 if to == here else max(8, math.ceil(abs(to - here) / 0.004))
            shares = np.arange(1, count + 1) / count
            lam.append(here + (to - here) * shares)
            t.append(now + lasts * (shares**3 if to == here else shares))
            logged = step * np.arange(math.floor(now / step) + 1, math.floor((now + lasts) / step) + 1)
            if run.stores_turns:  # in place of a row just beside
                logged = logged[(logged > now + 0.05 * step) & (logged < now + lasts - 0.05 * step)]
            rows.extend(logged[:: 1 + len(logged) // 30] if to == here else logged)
            here, now = to, now + lasts
            rows.extend([now] if run.stores_turns else [])
    return np.concatenate(lam), np.concatenate(t), np.array(rows)


def _answer(truth: Truth, setup: Setup, number: int, still: Table) -> Reading:
    lam, t, rows = _path(setup)
    held = _gripped(truth, setup, number, lam, still)
    longer = _lengthened(truth, held, t, still)
    own = np.maximum(held / longer, 1.0)
    p = _reformed(truth, held, still.at(less_amplified(truth.of("mullins"), own)) / longer, still)
    p = p * damage(truth.of("mullins"), own, still, truth.top) * _warmth(truth, setup, own)
    p = np.maximum(
        p + friction(truth.of("hysteresis"), own, p, truth.top) + flow(truth.of("rate"), own, p, t, truth.top), 0.0
    )
    p = p + _zero(truth, setup, number, t)
    width = np.interp(own, still.stretch, still.width) / np.sqrt(longer)
    lam, own, p, width = (np.interp(rows, t, one) for one in (lam, own, p, width))
    p = p + _elsewhere(truth, setup, number, own, p, rows)
    return Reading(setup, rows, lam, p, width if setup.mode == "uniaxial" else None)


def _gripped(truth: Truth, setup: Setup, number: int, lam: Array, still: Table) -> Array:
    """Return the stretch of the cloth between the jaws.

    Kind 0: rubber faces that the load draws in to the power of 2/3 (Hertz), each clamped as tightly as a hand does;
    a part comes back with the load, a part of the greatest load's stays until the jaws are opened.
    Kind 1: cloth wound about bollards, which lengthens there too, the load dying out by Euler's rope; as the load
    falls, friction keeps the wound part long.
    Kind 2: strips mounted askew, each by its own amount (Rayleigh), so that one edge is taut before the other.
    """
    if (d := truth.of("grip-slack")) is None:
        return lam
    if d["kind"] < 1:
        loose = 0.12 * d["amount"] * math.exp(0.3 * truth.alone(number, setup).standard_normal())
        gives, stays = loose * (still.stress / truth.top) ** (2.0 / 3.0), 0.35 + 0.4 * d["u"]
        out = np.interp(np.interp(most_so_far(lam), still.stretch + gives, still.stretch), still.stretch, gives)
        return np.interp(lam - stays * out, still.stretch + (1.0 - stays) * gives, still.stretch)
    if d["kind"] > 1:
        askew = 0.2 * d["amount"] * float(truth.alone(number, setup).rayleigh(0.8))
        late = still.stretch[:, None] - askew * (np.arange(40) + 0.5) / 40.0
        mean = np.mean(np.interp(late, still.stretch, still.stress), axis=1)
        return np.interp(np.interp(lam, still.stretch, mean), still.stress, still.stretch)
    e, load = still.stretch - 1.0, np.maximum(still.stress, 1e-9)
    per = e[1:] / load[1:]
    wound = np.concatenate([[0.0], np.cumsum(0.5 * (per + np.concatenate([per[:1], per[:-1]])) * np.diff(load))])
    wound, held, most, last = 0.35 * d["amount"] * wound, np.ones_like(lam), 0.0, 1.0
    pulled = np.interp(lam, still.stretch + wound, still.stretch)
    # Each way back starts from the greatest load since the cloth last hung free.
    backs: dict[float, Array] = {}
    for k, (here, loaded) in enumerate(zip(lam, pulled, strict=True)):
        most = 0.0 if here <= 1.0 else most
        if here >= last:
            most = max(most, float(np.interp(loaded, still.stretch, still.stress)))
            held[k] = loaded
        else:
            if most not in backs:
                backs[most] = 2.0 * np.interp(np.sqrt(load * most), load, wound) - wound
            held[k] = min(float(np.interp(here, still.stretch + backs[most], still.stretch)), held[k - 1])
        last = here
    return held


def _lengthened(truth: Truth, held: Array, t: Array, still: Table) -> Array:
    """Return the natural length that a specimen has got.

    Kind 0: see ``_reformed``.
    Kind 1: flow by the load above a yield load that grows with the flow (Perzyna, Adv. Appl. Mech. 9 (1966) 243).
    Kind 2: growth with the logarithm of the number of cycles, as knits are tested for bagging.
    """
    d = truth.of("permanent-set")
    if d is None or d["kind"] < 1:
        return np.ones_like(held)
    if d["kind"] > 1:
        e = held - 1.0
        most = most_so_far(e)
        cycles = np.cumsum(np.abs(np.diff(e, prepend=0.0))) / (2.0 * np.maximum(most, 1e-6))
        grows = most**2 / (most + 0.1 + 0.3 * d["u"]) * (0.4 + (0.3 + 0.5 * d["v"]) * np.log1p(cycles))
        return 1.0 + most_so_far(0.4 * d["amount"] * grows)
    yields, hard, power = 0.08 + 0.2 * d["u"], 1.5 / max(d["amount"], 1e-3), 1.5 + 1.5 * d["v"]
    stays, found = 0.0, [0.0]
    loads = np.interp(held, still.stretch, still.stress) / truth.top
    for load, dt in zip(loads[1:], np.diff(t), strict=True):
        over = load - yields - hard * stays
        if over > 0.0:
            stays += min(0.3 * dt / 60.0 / hard * (over / 0.3) ** power * 6.0, over / hard)
        found.append(stays)
    return 1.0 + np.array(found)


def _reformed(truth: Truth, held: Array, p: Array, still: Table) -> Array:
    """Return the stress where bonds break and form anew in the stretched cloth, at rest in that stretch.

    They do above a stretch (Wineman & Rajagopal, Arch. Mech. 42 (1990) 53; Tobolsky's second network).
    """
    d = truth.of("permanent-set")
    if d is None or d["kind"] > 0:
        return p
    begins, slow = 1.02 + 0.08 * d["u"], 0.2 + 0.3 * d["v"]
    levels = begins + (np.arange(24) + 0.5) / 24.0 * 0.6
    each = 0.6 * d["amount"] / 24.0 / slow * np.exp(-(levels - begins) / slow)
    most = most_so_far(held)
    formed = np.clip((most[:, None] - levels) * 40.0 + 0.5, 0.0, 1.0) * each
    anew = still.at(held[:, None] / levels) / levels
    return p * (1.0 - np.sum(formed, axis=1)) + np.sum(formed * anew, axis=1)


def _warmth(truth: Truth, setup: Setup, own: Array) -> Array:
    """Return how stiff the cloth is in this warmth.

    Kind 0: bonds that give way as Weibull's strengths do (Mahieux & Reifsnider, Polymer 42 (2001) 3281).
    Kind 1: hard domains that fill the soft ones (Guth 1945) and dissolve in the warmth.
    Kind 2: entanglements that grow fewer, so that chains grow longer (Raha & Bowden, Polymer 13 (1972) 174).
    """
    if (d := truth.of("thermal-softening")) is None:
        return np.ones_like(own)
    kelvin, room = setup.temperature + _KELVIN, _ROOM + _KELVIN
    if d["kind"] < 1:
        at, power = 318.0 + 20.0 * d["u"], 12.0 + 16.0 * d["v"]
        lives = math.exp((room / at) ** power - (kelvin / at) ** power)
        return np.full_like(own, 1.0 - d["amount"] + d["amount"] * lives)
    if d["kind"] < 2:
        fill = 0.2 + 0.15 * d["u"]
        now = fill * max(1.0 - d["amount"] * (kelvin - room) / 35.0, 0.0)
        stiff, fresh = (1.0 + 2.5 * one + 14.1 * one**2 for one in (now, fill))
        return np.full_like(own, stiff / fresh)
    gone = math.expm1((1.5e4 + 2e4 * d["u"]) / 8.314 * (1.0 / room - 1.0 / kelvin))
    left, squares = max(1.0 - 0.3 * d["amount"] * gone, 0.2), (own**2 + 2.0 / own) / 3.0
    chain = 2.2 + 2.0 * d["v"]
    long, short = (squares / one for one in (chain / left, chain))
    return left * (3.0 - long) / (1.0 - long) * (1.0 - short) / (3.0 - short)


def _zero(truth: Truth, setup: Setup, number: int, t: Array) -> Array:
    """Return what the load cell says beside the load [MPa].

    Kind 0: a zero that runs away evenly and is set back every few specimens.
    Kind 1: a zero that follows the warmth of the chamber below the cell, beside a part that is always there.
    Kind 2: a cell that is tared when the strip hangs under its pretension, log-normal, so that it says too little,
    and whose zero goes to and fro as the climate's two-point control switches.
    """
    if (d := truth.of("load-offset")) is None:
        return np.zeros_like(t)
    size, sign = d["amount"] * truth.top, -1.0 if d["v"] < 0.5 else 1.0
    if d["kind"] < 1:
        return sign * size * (((1200.0 * number + t) / (4000.0 + 4000.0 * d["u"])) % 1.0)
    if d["kind"] < 2:
        soaked = (setup.temperature - _ROOM) / 35.0 * (1.0 - 0.5 * np.exp(-t / (60.0 + 200.0 * d["u"])))
        return sign * size * (0.3 + soaked)
    tare = math.exp(0.5 * truth.alone(number, setup).standard_normal())
    swings = np.abs(2.0 * ((d["w"] + (1200.0 * number + t) / (300.0 + 900.0 * d["u"])) % 1.0) - 1.0)
    return size * (swings - 0.6 * tare)


def _elsewhere(truth: Truth, setup: Setup, number: int, own: Array, p: Array, t: Array) -> Array:
    """Return what is in no catalogue [MPa]: a crosshead that trembles; threads that snag and let go."""
    found = np.zeros_like(own)
    if d := truth.of("vibration"):
        tight = truth.top * np.minimum((own - 1.0) / 0.1, 1.0)
        found = found + d["amount"] * tight * np.sin(2.0 * math.pi * (t / (3.0 + 9.0 * d["u"]) + number * d["v"]))
    if d := truth.of("snag"):
        chance, so_far = truth.alone(number, setup), np.cumsum(np.abs(np.diff(own, prepend=1.0)))
        for _ in range(int(chance.integers(1, 5))):
            since = so_far - float(so_far[-1]) * chance.uniform()
            found = found + np.where(since > 0.0, d["amount"] * p * np.exp(-since / 0.05), 0.0)
    return found
