"""A third set of stretch fabrics with undeclared effects.

A third set, written from the file formats alone; its formulas were chosen without looking at the catalogue.
It is never tuned to.

The energies stand in `third_energy`, what the history, the warmth and the machine do to the stress stands here.
A fabric carries no compression: the tension is cut at zero before what the load cell adds. The amount of every
effect is a factor that leaves the plain law at zero and is set such that the effect is of practical size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from loop.generators.fabric import Reading, Setup, program
from loop.generators.third_energy import BASES, GRID, Array, Curve, Truth, at
from numpy.random import Generator

KINDS: dict[str, int] = {
    "anisotropy": 4, "hysteresis": 4, "rate": 4, "mullins": 4, "permanent-set": 4, "thermal-softening": 4,
    "grip-slack": 4, "load-offset": 4, "compressibility": 4, "elastic-law": 4,
}  # fmt: skip
OUTSIDE: tuple[str, ...] = ("moisture", "yarn-breaks", "ageing", "gauge-slip")
ROOM = 23.0
_CAPS = {"hysteresis": 0.6, "mullins": 1.0, "compressibility": 1.0, "yarn-breaks": 0.5, "moisture": 0.6}
_EXTENT = {("mullins", 0): 6.0, ("mullins", 1): 4.0, ("compressibility", 0): 4.0}


def protocol(random: Generator) -> list[Setup]:
    """Draw a rich programme of tests: directions, rates, temperatures, amplitudes, another mode, a replicate."""
    turn, points = random.uniform(0.4, 0.6), int(random.integers(45, 81))
    rate = 10.0 ** random.uniform(-3.0, -2.3)
    fast = rate * random.uniform(10.0, 40.0)
    hot = ROOM + random.uniform(30.0, 45.0)
    mode = "shear" if random.random() < 0.5 else "biaxial"
    oblique = [30.0, 45.0, 60.0][int(random.integers(3))] if random.random() < 0.5 else None
    hold = random.uniform(200.0, 900.0) if random.random() < 0.5 else 0.0
    return _programme(turn, points, rate, fast, hot, mode, oblique, hold)


def _programme(
    turn: float,
    points: int,
    rate: float,
    fast: float,
    hot: float,
    mode: str,
    oblique: float | None,
    hold: float,
) -> list[Setup]:
    small, big = 1.0 + round(0.55 * turn, 3), 1.0 + round(turn, 3)
    cycles, once, wide = (small, 1.0, small, 1.0, big, 1.0, big, 1.0), (big, 1.0, big, 1.0), 1.0 + 0.7 * turn
    tests = [
        Setup("uniaxial", 0.0, rate, ROOM, cycles, points=points),
        Setup("uniaxial", 0.0, rate, ROOM, cycles, points=points),
        Setup("uniaxial", 90.0, rate, ROOM, cycles, points=points),
        Setup("uniaxial", 0.0, fast, ROOM, cycles, points=points),
        Setup("uniaxial", 90.0, fast, ROOM, once, points=points),
        Setup("uniaxial", 0.0, rate, hot, cycles, points=points),
        Setup("uniaxial", 90.0, rate, hot, once, points=points),
        Setup(mode, 0.0, rate, ROOM, (wide, 1.0, wide, 1.0), points=points),
    ]
    if oblique is not None:
        tests.append(Setup("uniaxial", oblique, rate, ROOM, once, points=points))
    if hold > 0.0:
        tests.append(Setup("uniaxial", 0.0, fast, ROOM, (big, 1.0), hold=hold, points=points))
    return tests


def draw(random: Generator, effects: Sequence[str], kind: int | None = None) -> Truth:
    """Draw a fabric, every effect of 3–5 % (Mullins' 4–6 %) of the plain law's peak, rms over a usual programme."""
    draws = {"elastic": {"mu": float(np.exp(random.uniform(-1.2, 0.7)))} | _places(random)}
    elastic = BASES[int(random.integers(len(BASES)))]
    truth = Truth(tuple(effects), elastic, draws, int(random.integers(2**31)))
    usual = _programme(0.5, 12, 0.003, 0.06, 60.0, "shear", None, 0.0)
    usual[-1:] = [usual[-1], replace(usual[-1], mode="biaxial")]
    for effect in effects:
        number = kind if kind is not None else int(random.integers(KINDS.get(effect, 1)))
        size = random.uniform(0.03, 0.05) * (1.2 if effect == "mullins" else 1.0)
        draws[effect] = {"kind": float(number), "amount": 0.3} | _places(random)
        cap = _EXTENT.get((effect, number), _CAPS.get(effect, 5.0))
        alone = replace(truth, effects=(effect,), laws={})
        for _ in range(6):
            share = size / max(departure(alone, usual, fine=2), 1e-9)
            draws[effect]["amount"] = min(draws[effect]["amount"] * min(max(share, 0.2), 5.0), cap)
            alone.laws.clear()
            if abs(share - 1.0) < 0.1:
                break
    return truth


def departure(truth: Truth, setups: Sequence[Setup], fine: int = 4) -> float:
    """Return the rms distance of the readings from the plain law at their own stretch, of the law's peak."""
    plain, gaps, peak = truth.plain(), [], 0.0
    for number, setup in enumerate(setups):
        read = _answer(truth, setup, number, fine)
        calm = plain.law(setup.mode, setup.angle)[0](np.maximum(read.stretch, 1.0))
        gaps.append(read.stress - calm)
        peak = max(peak, float(np.max(calm)))
    return float(np.sqrt(np.mean(np.concatenate(gaps) ** 2)) / peak)


def measure(truth: Truth, setups: Sequence[Setup], random: Generator, noise: float) -> list[Reading]:
    """Test one specimen after another; what is drawn here does not depend on the effects of the fabric."""
    readings = []
    for number, setup in enumerate(setups):
        read = _answer(truth, setup, number, 4)
        scatter = 1.0 + 0.0025 * float(np.clip(random.normal(), -2.0, 2.0))
        read.stress = read.stress * scatter + noise * random.normal(size=read.stress.size)
        wobble = 0.002 * random.normal(size=read.stress.size)
        read.transverse = None if read.transverse is None else read.transverse + wobble
        readings.append(read)
    return readings


def _answer(truth: Truth, setup: Setup, number: int, fine: int) -> Reading:
    """Return what is read of one specimen, without noise."""
    lam, t = program(setup, fine)
    own = np.random.default_rng([truth.seed, number])
    clock, top = 2400.0 * number + t, truth.peak()
    stress_of, width_of = truth.law(setup.mode, setup.angle)
    inside = _gripped(truth.of("grip-slack"), lam, stress_of, top)
    lasting = 1.0 + _lasting(truth.of("permanent-set"), inside, t, stress_of, top)
    taut = np.maximum(inside / lasting, 1.0)
    p = stress_of(taut) * _softened(truth.of("mullins"), setup.mode, taut)
    p = p * _warm(truth.of("thermal-softening"), setup.temperature, taut) * _drifted(truth, inside, clock, number)
    p = p + _loop(truth.of("hysteresis"), taut, p, top) + _viscous(truth.of("rate"), p, t, top)
    p = np.maximum(p, 0.0) + top * _cell(truth, setup, number, clock)
    width = width_of(taut) / np.sqrt(lasting) if setup.mode == "uniaxial" else None
    read = lam
    if d := truth.of("gauge-slip"):  # the feelers of the strain gauge slide once, as the stretch passes a point
        place, way = own.uniform(1.1, 1.4), 0.05 * d["amount"] * own.uniform(0.5, 1.5)
        read = lam - way * (np.maximum.accumulate(lam) > place)
    rows = slice(None, None, fine)
    return Reading(setup, t[rows], read[rows], p[rows], None if width is None else width[rows], f"strip {number + 1}")


def _places(random: Generator) -> dict[str, float]:
    return {f"u{i}": float(random.random()) for i in range(1, 6)}


def _gripped(d: dict[str, float] | None, lam: Array, stress_of: Curve, top: float) -> Array:
    """Return the stretch of the cloth from the way of the machine.

    Crimp that is pulled out first (after Peirce 1937, 10.1080/19447023708658809); wedges that yield with the load;
    a way without load with a soft end; jaws from which the cloth creeps for good above a load.
    """
    if d is None:
        return lam
    way, e = 0.03 * d["amount"], lam - 1.0
    if d["kind"] == 0:
        return lam - way * -np.expm1(-e / way)
    if d["kind"] == 2:
        s = way * at(d, "u1", 0.15, 0.4)
        return 1.0 + s * (np.logaddexp(0.0, (e - way) / s) - math.log1p(math.exp(-way / s)))
    fine = np.linspace(1.0, GRID[-1], 2001)
    load = stress_of(fine) / top
    if d["kind"] == 1:
        return np.interp(lam, fine + way * np.tanh(load / at(d, "u1", 0.2, 0.8)), fine)
    slip = way * np.maximum(load - at(d, "u1", 0.1, 0.4), 0.0) ** 1.5
    return lam - np.interp(np.maximum.accumulate(lam), fine + slip, slip)


def _lasting(d: dict[str, float] | None, lam: Array, t: Array, stress_of: Curve, top: float) -> Array:
    """Return the strain that stays.

    A yield limit on the true stress with linear hardening (Drucker 1951); flow along the arc of the strain (after
    Lion 1996); a power of the stress that saturates (Norton 1929); a cube root of time (Andrade 1910,
    10.1098/rspa.1910.0050).
    """
    if d is None:
        return np.zeros_like(lam)
    fine = np.linspace(1.0, GRID[-1], 1301)
    curve = stress_of(fine) / top
    if d["kind"] == 0:
        limit, harden = at(d, "u1", 0.05, 0.3), at(d, "u2", 10.0, 30.0) / d["amount"]
        low, high = np.ones_like(fine), fine.copy()
        for _ in range(40):
            mid = 0.5 * (low + high)
            over = np.interp(fine / mid, fine, curve * fine) > limit + harden * (mid - 1.0)
            low, high = np.where(over, mid, low), np.where(over, high, mid)
        return np.interp(np.maximum.accumulate(lam), fine, low - 1.0)
    table, power, most = [*curve.tolist(), float(curve[-1])], at(d, "u1", 1.0, 3.0), at(d, "u2", 0.05, 0.12)
    stays, worn, out = 0.0, 0.0, [0.0]
    way, wait = np.abs(np.diff(lam)).tolist(), (np.diff(t) / 300.0).tolist()
    for here, arc, dt in zip(lam[1:].tolist(), way, wait, strict=True):
        place = max(here / (1.0 + stays) - 1.0, 0.0) * 2000.0
        k = min(int(place), 1300)
        load = table[k] + (place - k) * (table[min(k + 1, 1301)] - table[k])
        if d["kind"] == 1:
            stays += d["amount"] * 0.05 * arc * load * (1.0 - stays / most)
        elif d["kind"] == 2:
            stays += (most - stays) * -math.expm1(-d["amount"] * load**power * dt)
        else:
            worn += load**power * dt
            stays = 0.02 * d["amount"] * worn ** (1.0 / 3.0)
        out.append(stays)
    return np.array(out)


def _softened(d: dict[str, float] | None, mode: str, lam: Array) -> Array:
    """Return the share of the virgin stress that is left.

    Chains that lengthen and grow fewer (Marckmann et al. 2002, 10.1016/S0022-5096(01)00136-3); a soft phase that
    grows (Qi and Boyce 2004, 10.1016/j.jmps.2004.04.008), driven by the stretch amplified as at first; yarns worn in
    their own direction (Diani, Brieu and Vacherand 2006); damage by the largest stretch and by the arc (Miehe 1995).
    """
    if d is None:
        return np.ones_like(lam)
    most = np.maximum.accumulate(lam)
    i1 = {
        "uniaxial": lambda x: x**2 + 2 / x,
        "shear": lambda x: x**2 + 1 + x**-2,
        "biaxial": lambda x: 2 * x**2 + x**-4,
    }
    chain, past = i1[mode](lam) / 3.0, i1[mode](most) / 3.0
    if d["kind"] == 0:
        n = at(d, "u1", 3.0, 7.0)
        longer = n * (1.0 + d["amount"] * (np.sqrt(past) - 1.0))
        return (3.0 - chain / longer) / (1.0 - chain / longer) / (3.0 - chain / n) * (1.0 - chain / n) * n / longer
    if d["kind"] == 1:
        root, soft = at(d, "u1", 4.0, 6.0), at(d, "u2", 0.35, 0.5)

        def carried(v: Array) -> Array:
            x = 1.0 + 3.5 * (1.0 - v) + 18.0 * (1.0 - v) ** 2
            big = (x * (chain - 1.0) + 1.0) / root**2
            return v * x * (3.0 - big) / (1.0 - big)

        stiff = 1.0 + 3.5 * (1.0 - soft) + 18.0 * (1.0 - soft) ** 2
        far = np.sqrt(stiff * (past - 1.0) + 1.0)
        v = 0.85 - (0.85 - soft) * np.exp(-d["amount"] * (far - 1.0) / (root - far))
        return carried(v) / carried(np.full_like(v, soft))
    if d["kind"] == 2:
        a = (np.arange(18) + 0.5) * np.pi / 36
        width = {"uniaxial": -0.5, "shear": 0.0, "biaxial": 1.0}[mode]

        def along(x: Array) -> Array:
            return np.sqrt(np.outer(x**2, np.cos(a) ** 2) + np.outer(x ** (2.0 * width), np.sin(a) ** 2))

        safe = np.maximum(lam, 1.0 + 1e-6)
        pull = np.maximum(along(safe) - 1.0, 0.0) * np.maximum(along(safe + 1e-4) - along(safe), 0.0)
        worn = d["amount"] * -np.expm1(-np.maximum(along(most) - 1.0, 0.0) / at(d, "u1", 0.1, 0.4))
        return np.sum((1.0 - worn) * pull, axis=1) / np.sum(pull, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(lam)))])
    first = -np.expm1(-(most - 1.0) / at(d, "u1", 0.1, 0.4))
    return 1.0 - 0.7 * d["amount"] * (first + 0.3 * -np.expm1(-arc / at(d, "u2", 0.5, 2.0)))


def _warm(d: dict[str, float] | None, degrees: float, lam: Array) -> Array | float:
    """Return the share of the stress that is left in the warmth.

    Vogel, Fulcher and Tammann's shift of a glassy part, and rubber's entropy; crystals that melt about a point, felt
    most at small stretch; a line and a step; the shift of Williams, Landel and Ferry 1955 (10.1021/ja01619a008).
    """
    if d is None:
        return 1.0
    a, rise = d["amount"], degrees - ROOM
    if d["kind"] == 0:
        cold = ROOM - at(d, "u1", 80.0, 150.0)
        b = at(d, "u2", 60.0, 200.0)
        glass = math.exp(b / (degrees - cold) - b / (ROOM - cold)) - 1.0
        return 1.0 + a * (0.3 * rise / (ROOM + 273.15) + 2.0 * glass)
    if d["kind"] == 1:
        point, wide = at(d, "u1", 35.0, 50.0), at(d, "u2", 3.0, 9.0)
        melt = [1.0 / (1.0 + math.exp(-(x - point) / wide)) for x in (ROOM, degrees)]
        return 1.0 - a * (melt[1] - melt[0]) * (0.5 + 0.5 * np.exp(-(lam - 1.0) / 0.3))
    if d["kind"] == 2:
        step = 0.5 * (1.0 + math.tanh((degrees - at(d, "u1", 32.0, 48.0)) / 1.5))
        return 1.0 - a * (at(d, "u2", 0.003, 0.01) * rise + 0.5 * step)
    shift = -at(d, "u1", 5.0, 12.0) * rise / (at(d, "u2", 80.0, 160.0) + rise)
    return 1.0 + 2.0 * a * (10.0 ** (at(d, "u3", 0.05, 0.2) * shift) - 1.0)


def _loop(d: dict[str, float] | None, lam: Array, p: Array, top: float) -> Array:
    """Return the friction, of no rate, that vanishes with the load.

    Bouc 1967 and Wen 1976, the friction growing with stretch; Preisach 1935 (10.1007/BF01349418), relays of
    crossings that snap; the bristles of Canudas de Wit et al. 1995 (10.1109/9.376053) without rate, the break-away
    dying out with the way (Dahl 1968); Iwan 1966 with sliders that the tension presses.
    """
    if d is None:
        return np.zeros_like(lam)
    a, out, now, run, sense = d["amount"], [0.0], 0.0, 0.0, 1.0
    steps, load = np.diff(lam).tolist(), p[1:].tolist()
    short = at(d, "u1", 0.015, 0.05)
    if d["kind"] == 0:
        n, gamma = at(d, "u2", 1.0, 2.0), at(d, "u3", 0.5, 0.8)
        for step in steps:
            hard = gamma + (1.0 - gamma) * math.copysign(1.0, step * now)
            now = min(max(now + step / short * (1.0 - abs(now) ** n * hard), -1.0), 1.0)
            out.append(now)
        grows = 1.0 + at(d, "u4", 0.0, 1.0) * (lam - 1.0)
        return a * p * grows * np.array(out) / (1.0 + 0.8 * d["u4"])
    if d["kind"] == 1:
        mean, half = np.meshgrid(np.linspace(1.0, 1.6, 41), np.geomspace(0.004, 0.2, 16))
        middle, wide = at(d, "u2", 1.15, 1.35), at(d, "u3", 0.1, 0.25)
        weigh = np.exp(-0.5 * ((mean - middle) / wide) ** 2 - 0.5 * (np.log(half / short) / 0.8) ** 2)
        keep = (mean - half >= 1.0) & (weigh > 1e-3)
        on, off, weigh = (mean + half)[keep], (mean - half)[keep], weigh[keep]
        state = np.zeros_like(on)
        for here in lam[1:].tolist():  # a crossing drags until it lets go, and holds back until it falls in again
            state[on <= here] = 1.0
            state[off >= here] = 0.0
            out.append(float((1.0 - 2.0 * state) @ (weigh * ((off < here) & (here < on)))))
        widest = max(float(weigh @ ((off < x) & (x < on))) for x in GRID)
        return a * top * np.array(out) / widest
    if d["kind"] == 2:
        extra, fade = at(d, "u2", 0.1, 0.6), at(d, "u3", 0.03, 0.1)
        for step, pull in zip(steps, load, strict=True):
            if step * sense < 0.0:
                run, sense = 0.0, math.copysign(1.0, step)
            run += abs(step)
            most = max(pull, 0.0) * (1.0 + extra * math.exp(-run / fade)) / (1.0 + extra)
            now = now + (step - abs(step) * now / most) * top / short * 0.3 if most > 1e-9 else 0.0
            now = min(max(now, -most), most)
            out.append(now)
        return a * np.array(out)
    grip = np.geomspace(0.02, at(d, "u2", 0.3, 0.8), 12)
    slide = np.zeros_like(grip)
    for step, pull in zip(np.diff(p).tolist(), load, strict=True):
        slide = np.maximum(np.minimum(slide + step, grip * max(pull, 0.0)), -grip * max(pull, 0.0))
        out.append(float(slide.mean()))
    return a * np.array(out) / float(grip.mean())


def _viscous(d: dict[str, float] | None, p: Array, t: Array, top: float) -> Array:
    """Return the overstress that fades with time.

    The fractional solid of Zener by its exact spectrum (Koeller 1984, 10.1115/1.3167616); a dashpot of Eyring 1936
    (10.1063/1.1749836) that the tension eases; reptation (Doi and Edwards 1978); a log-normal spectrum of relaxation.
    """
    if d is None:
        return np.zeros_like(p)
    tau = 10.0 ** at(d, "u1", 0.5, 1.8)
    if d["kind"] == 1:
        unit, ease, now, out = at(d, "u2", 0.05, 0.15) * top, at(d, "u3", 0.2, 1.0) / top, 0.0, [0.0]
        for step, dt, pull in zip(np.diff(p).tolist(), np.diff(t).tolist(), p[1:].tolist(), strict=True):
            flow = dt / (30.0 * tau) * math.exp(ease * pull)
            to = (now + step) / unit
            x = min(abs(to), math.asinh(abs(to) / flow))
            for _ in range(12):
                x -= (x + flow * math.sinh(x) - abs(to)) / (1.0 + flow * math.cosh(x))
            now = unit * math.copysign(x, to)
            out.append(now)
        return d["amount"] * np.array(out)
    if d["kind"] == 0:
        alpha, log_rate = at(d, "u2", 0.35, 0.7), np.linspace(-9.0, 9.0, 31)
        r = np.exp(log_rate)
        weigh = r**alpha * math.sin(math.pi * alpha) / (r ** (2 * alpha) + 2 * r**alpha * math.cos(math.pi * alpha) + 1)
        rates = r / tau
    elif d["kind"] == 2:
        odd = np.arange(1.0, 40.0, 2.0)
        weigh, rates = odd**-2.0, odd**2 / (8.0 * tau)
    else:
        spread = np.linspace(-2.5, 2.5, 21)
        weigh, rates = np.exp(-0.5 * spread**2), np.exp(-spread * at(d, "u2", 0.8, 2.0)) / tau
    beat = np.outer(np.diff(t), rates)
    fade, gain = np.exp(-beat), -np.expm1(-beat) / beat
    state, total, steps = np.zeros_like(rates), [0.0], np.diff(p)
    for keep, take, step in zip(fade, gain, steps, strict=True):
        state = state * keep + take * step
        total.append(float(state @ weigh))
    return d["amount"] * np.array(total) / float(weigh.sum())


def _cell(truth: Truth, setup: Setup, number: int, clock: Array) -> Array | float:
    """Return what the load cell adds, as a share of the peak.

    An amplifier that follows the temperature of the day; the weight of the hanging grip; an amplifier that warms up; a
    zero set anew with each specimen.
    """
    if (d := truth.of("load-offset")) is None:
        return 0.0
    if d["kind"] == 0:
        return d["amount"] * np.sin(2.0 * np.pi * (clock / 86400.0 * at(d, "u1", 1.0, 2.0) + d["u2"]))
    sign = 1.0 if d["u1"] > 0.4 else -1.0
    if d["kind"] == 1:
        return sign * d["amount"] * {"uniaxial": 1.0, "shear": 0.6, "biaxial": 0.0}[setup.mode]
    if d["kind"] == 2:
        return sign * d["amount"] * np.exp(-clock / at(d, "u2", 4000.0, 12000.0))
    return d["amount"] * float(np.random.default_rng([truth.seed, 7, number]).uniform(-1.0, 1.0))


def _drifted(truth: Truth, lam: Array, clock: Array, number: int) -> Array:
    """Return the share of the stress left by what no list names: moisture of the day, broken yarns, age."""
    share = np.ones_like(lam)
    if d := truth.of("moisture"):  # regain that rises through the day makes the yarns soft
        share = share * (1.0 + d["amount"] * np.expm1(-clock / at(d, "u1", 5000.0, 15000.0)))
    if d := truth.of("yarn-breaks"):  # yarns of a specimen break one by one, at stretches of their own
        own = np.random.default_rng([truth.seed, 11, number])
        for place, size in zip(own.uniform(1.1, 1.5, 3), own.uniform(0.2, 1.0, 3), strict=True):
            share = share * (1.0 - d["amount"] * size * (np.maximum.accumulate(lam) > place))
    if d := truth.of("ageing"):  # days pass between the tests, and the elastane stiffens
        days = float(np.cumsum(np.random.default_rng([truth.seed, 13]).uniform(0.3, 4.0, number + 1))[-1])
        share = share * (1.0 + d["amount"] * math.log1p(days))
    return share
