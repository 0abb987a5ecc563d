"""Every form of every fabric effect against the formula that docs/close-loop-laws.md states, worked out row by row.

The reference goes through each curve in plain Python, one reading after the other, as the page says it; the program
works on whole columns. The two share nothing but the page.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path as File

import numpy as np
import pytest
from scipy.optimize import brentq

from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import BIAXIAL, SHEAR, UNIAXIAL, Path, uniaxial_pull
from hyperfab.materials.registry import law

#: Two curves: (time [s], stretch). The second begins loaded, and stands still once.
CURVES = (
    ((0.0, 1.0), (2.0, 1.2), (5.0, 1.5), (7.0, 1.3), (9.0, 1.1), (12.0, 1.4), (16.0, 1.8), (17.0, 1.6)),
    ((0.0, 1.1), (1.0, 1.3), (3.0, 1.3), (4.0, 1.4), (8.0, 1.15), (9.0, 1.35)),
)
ANGLES, TEMPERATURES, REFERENCE = (0.0, 30.0), (23.0, 60.0), 20.0
C = (0.2, 0.03, 0.01)


class Row:
    """A reading with its history: all that the page's letters stand for."""

    def __init__(self, number: int, curve: int, before: Row | None) -> None:
        pairs = CURVES[curve]
        self.t, self.l = pairs[number]
        self.curve, self.before, self.number = curve, before, number
        self.angle, self.temperature = math.radians(ANGLES[curve]), TEMPERATURES[curve]
        #: Where the pull stands at rest before the first reading, at the pace of the first step.
        pace = (pairs[1][0] - pairs[0][0]) / abs(pairs[1][1] - pairs[0][1])
        self.dt = self.t - before.t if before else pace * (self.l - 1.0)
        self.from_l = before.l if before else 1.0
        self.up = self.l > self.from_l or (self.l == self.from_l and (before is None or before.up))
        self.lm: float = max(self.l, before.lm if before else 1.0)
        self.returns: int = (before.returns if before else 0) + (before is not None and before.up and not self.up)
        self.turn: Row = self if self.up or before is None else before.turn
        # Largest stretch of the pulls before this one.
        self.earlier: float = before.earlier if before else 1.0
        if before is not None and self.up and not before.up:
            self.earlier = before.lm

    @property
    def e(self) -> float:
        return self.l - 1.0

    @property
    def em(self) -> float:
        return self.lm - 1.0


def all_rows() -> list[Row]:
    found: list[Row] = []
    for curve, pairs in enumerate(CURVES):
        before = None
        for number in range(len(pairs)):
            before = Row(number, curve, before)
            found.append(before)
    return found


ROWS = all_rows()


def P(l: float, c: tuple[float, ...] = C) -> float:
    """Yeoh's law in a uniaxial test, incompressible."""
    x = l * l + 2.0 / l - 3.0
    return 2.0 * (l - l**-2) * (c[0] + 2.0 * c[1] * x + 3.0 * c[2] * x * x)


def spline(values: tuple[float, ...], x: float) -> float:
    """The natural cubic spline that is 0 at 0 and has ``values`` at even parts of 1, by Thomas's elimination."""
    y, n = (0.0, *values), len(values)
    # Second derivatives m, over h^2: m[i-1] + 4 m[i] + m[i+1] = 6 (y[i-1] - 2 y[i] + y[i+1]), 0 at both ends.
    up, m = [0.0] * (n + 1), [0.0] * (n + 1)
    for i in range(1, n):
        pivot = 4.0 - up[i - 1]
        up[i] = 1.0 / pivot
        m[i] = (6.0 * (y[i - 1] - 2.0 * y[i] + y[i + 1]) - m[i - 1]) / pivot
    for i in range(n - 1, 0, -1):
        m[i] -= up[i] * m[i + 1]
    if x > 1.0:
        slope = n * (y[n] - y[n - 1] + m[n - 1] / 6.0)
        return y[n] + slope * (x - 1.0)
    i = min(int(x * n), n - 1)
    b = x * n - i
    a = 1.0 - b
    return a * y[i] + b * y[i + 1] + ((a**3 - a) * m[i] + (b**3 - b) * m[i + 1]) / 6.0


def W(l: float, c: tuple[float, ...] = C) -> float:
    x = l * l + 2.0 / l - 3.0
    return c[0] * x + c[1] * x * x + c[2] * x**3


def gripped(read: float, give: Callable[[float], float]) -> float:
    """The stretch of a specimen that is read together with what the grips ``give`` under its load."""
    return float(brentq(lambda l: l + give(P(l)) - read, 1.0, read, xtol=1e-13)) if read > 1.0 else read


def slipped(row: Row, give: Callable[[float], float]) -> float:
    """The same where the grips do not take back what they gave."""
    return max(row.l - row.lm + gripped(row.lm, give), 1.0)


def driven(drive: Callable[[Row], float], step: Callable[[Row, float, float], float]) -> Callable[[Row], float]:
    """A state that follows ``drive`` from rest: ``step(row, state before, change of the drive)``."""

    def state(row: Row) -> float:
        if row.before is None:
            return step(row, 0.0, drive(row))
        return step(row, state(row.before), drive(row) - drive(row.before))

    return state


def maxwell(
    drive: Callable[[Row], float], g: float, tau: float, quick: Callable[[Row], float] = lambda row: 1.0
) -> Callable[[Row], float]:
    """``dq = g dP - q/tau dt``, exact where the drive is linear in time between readings; a jump where time stands.

    Time goes ``quick`` times as fast up to each reading.
    """

    def step(row: Row, q: float, change: float) -> float:
        if row.dt == 0.0:
            return q + g * change
        gone = row.dt * quick(row)
        grown = g * change / gone * tau
        return grown + (q - grown) * math.exp(-gone / tau)

    return driven(drive, step)


def clock(row: Row) -> float:
    """The material's own, shifted by 0.05/K that falls off over 90 K."""
    return math.exp(0.05 * (row.temperature - REFERENCE) / (1.0 + (row.temperature - REFERENCE) / 90.0))


def branches(pairs: Sequence[tuple[float, float]], bend: float = 0.0) -> Callable[[Row], float]:
    """The law with branches by that clock, driven by ``P l^bend``."""
    return lambda r: P(r.l) + sum(maxwell(lambda q: P(q.l) * q.l**bend, g, t, clock)(r) for g, t in pairs)


def spectrum(
    ends: tuple[float, float], bend: float, quick: float, shares: Sequence[float], own: Callable[[Row], float]
) -> Callable[[Row], float]:
    """The law with branches evenly spread in logarithm between two times, which strain and ``own`` shorten."""
    ratio = (ends[1] / ends[0]) ** (1.0 / (len(shares) - 1))
    return lambda r: (
        P(r.l)
        + sum(
            maxwell(lambda q: P(q.l) * q.l**bend, g, ends[0] * ratio**k, lambda q: math.exp(quick * q.e) * own(q))(r)
            for k, g in enumerate(shares)
        )
    )


def slide(
    level: Callable[[Row], float], scale: float, along: Callable[[Row], float], rest: float
) -> Callable[[Row], float]:
    """``dF = (+-S - F) dl/scale`` with S of the reading that the step ends at."""

    def force(row: Row) -> float:
        way = abs(along(row) - (along(row.before) if row.before else rest))
        before = force(row.before) if row.before else 0.0
        sign = 1.0 if row.up else -1.0
        found = sign * level(row) + (before - sign * level(row)) * math.exp(-way / scale)
        # A test begins without friction but for what the way from rest brought.
        return found

    return force


def damage(amount: float, strain: float, power: float, way: float) -> Callable[[Row], float]:
    """Damage that nears that of the largest strain by the way led, never back."""

    def state(row: Row) -> float:
        if row.before is None:
            return 0.0
        aim = amount * (1.0 - math.exp(-((row.em / strain) ** power)))
        last = state(row.before)
        return last + (1.0 - math.exp(-abs(row.l - row.from_l) / way)) * max(aim - last, 0.0)

    return state


def eyring(drive: Callable[[Row], float], g: float, tau: float, flow: float) -> Callable[[Row], float]:
    """Half of each step at rest before the jump, half after: tanh(q/(2 flow)) falls by exp(-dt/(2 tau)) in each."""

    def half(q: float, dt: float) -> float:
        return 2.0 * flow * math.atanh(math.exp(-0.5 * dt / tau) * math.tanh(q / (2.0 * flow)))

    return driven(drive, lambda row, q, change: half(half(q, row.dt) + g * change, row.dt))


def norton(g: float, tau: float, power: float, size: float, strain: float) -> Callable[[Row], float]:
    """``dq/dt = -(q/tau)(|q|/size)^(power-1) (e + 0.05)^strain`` at rest, solved by hand, half before, half after."""

    def half(row: Row, q: float) -> float:
        rate = (row.e + 0.05) ** strain / tau
        less = 1.0 + (power - 1.0) * 0.5 * row.dt * rate * (abs(q) / size) ** (power - 1.0)
        return q * less ** (-1.0 / (power - 1.0))

    return driven(lambda row: P(row.l), lambda row, q, change: half(row, half(row, q) + g * change))


def speed(row: Row) -> float:
    return (row.l - row.before.l) / row.dt if row.before and row.dt else 0.0


MOVING = [abs(speed(row)) for row in ROWS if speed(row)]
PACE = math.exp(sum(map(math.log, MOVING)) / len(MOVING))
#: Strain rates told with the readings, for the logarithmic law.
TOLD = [0.01 * (1.0 + number) for number in range(len(ROWS))]
MEAN_RATE = math.exp(sum(map(math.log, TOLD)) / len(TOLD))


def passed(row: Row, tau: float = math.inf) -> float:
    """How far what settles by ``tau`` has come in its test's time, 0 to 1."""
    times = [one.t for one in ROWS if one.curve == row.curve]
    since, whole = row.t - min(times), max(times) - min(times)
    return since / whole if math.isinf(tau) else (1.0 - math.exp(-since / tau)) / (1.0 - math.exp(-whole / tau))


def share(row: Row) -> float:
    return math.sin(row.angle) ** 2


def anisotropic(c: tuple[float, ...]) -> Callable[[Row], float]:
    weft = tuple(a + b for a, b in zip(C, c, strict=True))
    return lambda row: P(row.l) + share(row) * (P(row.l, weft) - P(row.l))


def sin2(row: Row) -> float:
    return math.sin(2.0 * row.angle) ** 2


#: Four functions of the stretch, each by its value at rest and what it is more at thirds.
TURNED = (0.1, -0.2, 0.3, 0.1, -0.3, 0.1, 0.2, -0.1, 0.2, 0.1, -0.1, 0.3, 0.1, 0.2, 0.1, -0.2)


def turned(count: int) -> Callable[[Row], float]:
    def stress(row: Row) -> float:
        at = math.log(1.0 + 20.0 * math.log(row.l)) / math.log(1.0 + 20.0 * math.log(1.8))
        bias = sin2(row)
        ways = (share(row), bias, bias * math.cos(2.0 * row.angle), math.sin(4.0 * row.angle) ** 2)[:count]
        each = [TURNED[4 * k : 4 * k + 4] for k in range(count)]
        return P(row.l) * math.exp(sum(h * (g[0] + spline(g[1:], at)) for h, g in zip(ways, each, strict=True)))

    return stress


def fibre(row: Row, k1: float, k2: float, along: float) -> float:
    """Slope of ``k1/(2 k2) (exp(k2 <I4 - 1>^2) - 1)``; the sheet contracts as an incompressible one."""
    I4 = row.l**2 * along + (1.0 - along) / row.l
    strain = max(I4 - 1.0, 0.0)
    return 2.0 * k1 * along * row.l * strain * math.exp(k2 * strain**2)


def rest_length(form: str, v: tuple[float, ...], em: float) -> float:
    if "power" in form:
        return v[0] * em * (2.0 * em) ** (v[1] - 1.0) if em else 0.0
    if "bent" in form:
        return v[0] * (1.0 - math.exp(-v[1] * em)) / v[1]
    return v[0] * em


def unslack(l: float, s: float, added: bool) -> float:
    return max(l - s if added else l / (1.0 + s), 1.0)


def set_of(form: str, v: tuple[float, ...]) -> Callable[[Row], float]:
    added = form.endswith("-added")
    takes = 2 if form.startswith(("crept", "cycles")) or "power" in form or "bent" in form else 1
    contraction = v[takes] if len(v) > takes else 0.0

    def over(row: Row, s: float) -> float:
        return P(unslack(row.l, s, added)) * (1.0 if added else (1.0 + s) ** -contraction)

    def crept(row: Row) -> float:
        before = crept(row.before) if row.before else 0.0
        pulled = max(row.l - row.from_l, 0.0)
        return v[0] * row.em + (before - v[0] * row.em) * math.exp(-pulled / v[1])

    def stress(row: Row) -> float:
        if form.startswith("returned"):
            return set_shown(row, rest_length(form, v, row.em))
        if form.startswith("network"):
            power = v[1] if len(v) > 1 else 1.0
            c = v[0] * (2.0 * row.em) ** power
            return max((1.0 - c) * P(row.l) + c * P(row.l / row.lm) / row.lm, 0.0)
        if form.startswith("crept"):
            return over(row, crept(row))
        if form.startswith("cycles"):
            s = v[0] * row.em * row.returns ** v[1] if row.returns else 0.0
            return over(row, s)
        em = (row.earlier if form.startswith("next-pull") else row.lm) - 1.0
        return over(row, rest_length(form, v, em))

    return stress


def set_shown(row: Row, s: float) -> float:
    """The law over a set ``s`` that the first pull does not show."""
    return P(row.l) if row.l >= row.lm else P(1.0 + max((row.e - s) * row.em / (row.em - s), 0.0))


def on_the_way_down(factor: Callable[[Row, Row], float]) -> Callable[[Row], float]:
    return lambda row: P(row.l) if row.up else factor(row, row.turn)


def richer(slope: Callable[[float, float], tuple[float, float]]) -> Callable[[Row], float]:
    """``slope(x, y)`` is (dW/dI1, dW/dI2) of what is added."""

    def stress(row: Row) -> float:
        x, y = row.l**2 + 2.0 / row.l - 3.0, 2.0 * row.l + row.l**-2 - 3.0
        one, two = slope(x, y)
        return P(row.l) + 2.0 * (row.l - row.l**-2) * (one + two / row.l)

    return stress


def power_term(mu: float, alpha: float) -> Callable[[Row], float]:
    return lambda row: P(row.l) + mu * (row.l ** (alpha - 1.0) - row.l ** (-0.5 * alpha - 1.0))


def plus(one: Callable[[Row], float], other: Callable[[Row], float]) -> Callable[[Row], float]:
    """Both of what two forms add."""
    return lambda row: one(row) + other(row) - P(row.l)


def contracting(
    nu: float, *, slope: bool = False, weft: float | None = None, bend: float = 0.0, between: float = 0.0
) -> Callable[[Row], float]:
    def stress(row: Row) -> float:
        own = nu if weft is None else nu + share(row) * (weft - nu)
        own += between * sin2(row)
        l3 = row.l ** -(own + bend * math.log(row.l))
        l2 = row.l**-0.5 if slope else 1.0 / (row.l * l3)
        x = row.l**2 + l2**2 + (row.l * l2) ** -2 - 3.0
        return 2.0 * (row.l - l3**2 / row.l) * (C[0] + 2.0 * C[1] * x + 3.0 * C[2] * x * x)

    return stress


def logistic(x: float, at: float, width: float) -> float:
    return 1.0 / (1.0 + math.exp(-(x - at) / width))


def in_series(modulus: float, tau: float) -> Callable[[Row], float]:
    """A neo-Hookean spring in series with a dashpot, by a thousand small steps between two readings."""

    def dashpot(row: Row | None) -> float:
        if row is None:
            return 0.0
        log = dashpot(row.before)
        for k in range(1000):
            # The middle of a step, from half a step of Euler's.
            spring = math.exp(2.0 * (math.log(row.from_l) + k / 1000.0 * math.log(row.l / row.from_l) - log))
            middle = log + 0.0005 * row.dt * (spring - spring**-0.5) / (3.0 * tau)
            spring = math.exp(2.0 * (math.log(row.from_l) + (k + 0.5) / 1000.0 * math.log(row.l / row.from_l) - middle))
            log += 0.001 * row.dt * (spring - spring**-0.5) / (3.0 * tau)
        return log

    def stress(row: Row) -> float:
        spring = row.l / math.exp(dashpot(row))
        return modulus * (spring**2 - 1.0 / spring) / row.l

    return stress


LOG = richer(lambda x, y: (0.0, 0.05 / (y + 3.0)))
p, weft = (lambda row: P(row.l)), (-0.1, 0.02, 0.005)

#: Effect, form, its constants in the order of the form, and the stress of a reading as the page has it.
STATED: list[tuple[str, str, tuple[float, ...], Callable[[Row], float]]] = [
    ("anisotropy", "ratio", (0.4,), lambda r: P(r.l) * (1.0 - 0.6 * share(r))),
    ("anisotropy", "ratios", (0.4, -0.2), lambda r: P(r.l) * (1.0 - 0.6 * share(r) - 0.2 * sin2(r))),
    *(("anisotropy", f"smooth-{count}", (0.8, *TURNED[: 4 * count]), turned(count)) for count in range(1, 5)),
    ("anisotropy", "constants", weft, anisotropic(weft)),
    ("anisotropy", "warp-fibres", (0.3, 0.8), lambda r: P(r.l) + fibre(r, 0.3, 0.8, 1.0 - share(r))),
    ("anisotropy", "weft-fibres", (0.3, 0.8), lambda r: P(r.l) + fibre(r, 0.3, 0.8, share(r))),
    ("anisotropy", "constants-fibres", (*weft, 0.3, 0.2, 0.8),
     lambda r: anisotropic(weft)(r) + fibre(r, 0.3, 0.8, 1.0 - share(r)) + fibre(r, 0.2, 0.8, share(r))),
    ("hysteresis", "friction", (0.1, 0.2),
     lambda r: P(r.l) + slide(lambda q: 0.1 * P(q.l), 0.2, lambda q: q.l, 1.0)(r)),
    ("hysteresis", "dry", (0.02, 0.2), lambda r: P(r.l) + slide(lambda q: 0.02, 0.2, lambda q: q.l, 1.0)(r)),
    ("hysteresis", "friction-dry", (0.1, 0.2, 0.02, 0.1),
     lambda r: P(r.l) + slide(lambda q: 0.1 * P(q.l), 0.2, lambda q: q.l, 1.0)(r)
     + slide(lambda q: 0.02, 0.1, lambda q: q.l, 1.0)(r)),
    ("hysteresis", "friction-two", (0.1, 0.2, 0.05, 0.1),
     lambda r: P(r.l) + slide(lambda q: 0.1 * P(q.l), 0.2, lambda q: q.l, 1.0)(r)
     + slide(lambda q: 0.05 * P(q.l), 0.1, lambda q: q.l, 1.0)(r)),
    ("hysteresis", "dry-two", (0.02, 0.2, 0.01, 0.1),
     lambda r: P(r.l) + slide(lambda q: 0.02, 0.2, lambda q: q.l, 1.0)(r)
     + slide(lambda q: 0.01, 0.1, lambda q: q.l, 1.0)(r)),
    ("hysteresis", "stop", (0.02, 0.2), lambda r: P(r.l) + slide(lambda q: 0.02, 0.2, p, 0.0)(r)),
    ("hysteresis", "stop-two", (0.02, 0.2, 0.01, 0.1),
     lambda r: P(r.l) + slide(lambda q: 0.02, 0.2, p, 0.0)(r) + slide(lambda q: 0.01, 0.1, p, 0.0)(r)),
    ("hysteresis", "pseudo-elastic", (0.3, 0.05),
     on_the_way_down(lambda r, t: P(r.l) * (1.0 - 0.3 * math.erf((W(t.l) - W(r.l)) / 0.05)))),
    ("hysteresis", "returning", (0.3, 1.5),
     on_the_way_down(lambda r, t: P(r.l) * (1.0 - 0.3 * (1.0 - (r.e / t.e) ** 1.5)))),
    ("hysteresis", "bent", (0.4,), on_the_way_down(lambda r, t: P(t.l) * (P(r.l) / P(t.l)) ** 1.4)),
    ("rate", "prony-1", (0.3, 4.0), lambda r: P(r.l) + maxwell(p, 0.3, 4.0)(r)),
    ("rate", "prony-2", (0.3, 4.0, 0.2, 30.0), lambda r: P(r.l) + maxwell(p, 0.3, 4.0)(r) + maxwell(p, 0.2, 30.0)(r)),
    ("rate", "prony-3", (0.3, 4.0, 0.2, 30.0, 0.1, 1.0),
     lambda r: P(r.l) + maxwell(p, 0.3, 4.0)(r) + maxwell(p, 0.2, 30.0)(r) + maxwell(p, 0.1, 1.0)(r)),
    ("rate", "prony-bent", (0.3, 4.0, -0.7), lambda r: P(r.l) + maxwell(lambda q: P(q.l) * q.l**-0.7, 0.3, 4.0)(r)),
    ("rate", "prony-2-bent", (0.3, 4.0, -0.7, 0.2, 30.0),
     lambda r: P(r.l) + maxwell(lambda q: P(q.l) * q.l**-0.7, 0.3, 4.0)(r)
     + maxwell(lambda q: P(q.l) * q.l**-0.7, 0.2, 30.0)(r)),
    ("rate", "prony-3-bent", (0.3, 4.0, -0.7, 0.2, 30.0, 0.1, 1.0),
     lambda r: P(r.l) + sum(maxwell(lambda q: P(q.l) * q.l**-0.7, g, t)(r)
     for g, t in ((0.3, 4.0), (0.2, 30.0), (0.1, 1.0)))),
    ("rate", "prony-measure", (0.3, 4.0, 1.0), lambda r: P(r.l) + maxwell(lambda q: P(q.l) * q.l, 0.3, 4.0)(r) / r.l),
    ("rate", "prony-2-measure", (0.3, 4.0, -1.0, 0.2, 30.0),
     lambda r: P(r.l) + r.l * (maxwell(lambda q: P(q.l) / q.l, 0.3, 4.0)(r)
     + maxwell(lambda q: P(q.l) / q.l, 0.2, 30.0)(r))),
    ("rate", "thinning", (0.3, 4.0, 0.05), lambda r: P(r.l) + eyring(p, 0.3, 4.0, 0.05)(r)),
    ("rate", "thinning-bent", (0.3, 4.0, 0.05, 0.6),
     lambda r: P(r.l) + eyring(lambda q: P(q.l) * q.l**0.6, 0.3, 4.0, 0.05)(r)),
    ("rate", "thinning-prony", (0.3, 4.0, 0.05, 0.2, 30.0),
     lambda r: P(r.l) + eyring(p, 0.3, 4.0, 0.05)(r) + maxwell(p, 0.2, 30.0)(r)),
    ("rate", "flow", (0.3, 4.0, 3.0, 0.05), lambda r: P(r.l) + norton(0.3, 4.0, 3.0, 0.05, 0.0)(r)),
    ("rate", "flow-strain", (0.3, 4.0, 3.0, 0.05, -0.5), lambda r: P(r.l) + norton(0.3, 4.0, 3.0, 0.05, -0.5)(r)),
    ("rate", "finite", (0.1, 4.0), lambda r: P(r.l) + in_series(0.1, 4.0)(r)),
    ("rate", "finite-2", (0.1, 4.0, 0.2, 30.0),
     lambda r: P(r.l) + in_series(0.1, 4.0)(r) + in_series(0.2, 30.0)(r)),
    ("rate", "prony-1-shifted", (0.3, 4.0, 0.05, 90.0), branches([(0.3, 4.0)])),
    ("rate", "prony-2-shifted", (0.3, 4.0, 0.2, 30.0, 0.05, 90.0), branches([(0.3, 4.0), (0.2, 30.0)])),
    ("rate", "prony-3-shifted", (0.3, 4.0, 0.2, 30.0, 0.1, 1.0, 0.05, 90.0),
     branches([(0.3, 4.0), (0.2, 30.0), (0.1, 1.0)])),
    ("rate", "prony-2-bent-shifted", (0.3, 4.0, -0.7, 0.2, 30.0, 0.05, 90.0),
     branches([(0.3, 4.0), (0.2, 30.0)], -0.7)),
    ("rate", "prony-3-bent-shifted", (0.3, 4.0, -0.7, 0.2, 30.0, 0.1, 1.0, 0.05, 90.0),
     branches([(0.3, 4.0), (0.2, 30.0), (0.1, 1.0)], -0.7)),
    ("rate", "smooth", (1.0, 30.0, 0.5, 0.8, 0.1, 0.0, 0.2, 0.05, 0.1, 0.3),
     spectrum((1.0, 30.0), 0.5, 0.8, (0.1, 0.0, 0.2, 0.05, 0.1, 0.3), lambda q: 1.0)),
    ("rate", "smooth-shifted", (1.0, 30.0, 0.5, 0.8, 0.1, 0.0, 0.2, 0.05, 0.1, 0.3, 0.2, 0.1, 0.05, 90.0),
     spectrum((1.0, 30.0), 0.5, 0.8, (0.1, 0.0, 0.2, 0.05, 0.1, 0.3, 0.2, 0.1), clock)),
    ("rate", "viscous", (0.02, 0.5),
     lambda r: P(r.l) + math.copysign(0.02, speed(r)) * (abs(speed(r)) / PACE) ** 0.5 if speed(r) else P(r.l)),
    ("rate", "log-rate", (0.05,), lambda r: P(r.l) * (1.0 + 0.05 * math.log(TOLD[ROWS.index(r)] / MEAN_RATE))),
    ("rate", "log-rate-smooth", (0.02, 0.5, 0.1, 0.15, 0.3),
     lambda r: P(r.l) * (1.0 + spline((0.1, 0.15, 0.3), math.log(TOLD[ROWS.index(r)] / 0.02) / math.log(25.0)))),
    ("mullins", "pseudo-elastic", (0.4, 0.1), lambda r: P(r.l) * (1.0 - 0.4 * math.erf((W(r.lm) - W(r.l)) / 0.1))),
    ("mullins", "pseudo-elastic-beta", (0.4, 0.1, 0.7),
     lambda r: P(r.l) * (1.0 - 0.4 * math.erf((W(r.lm) - W(r.l)) / (0.1 + 0.7 * W(r.lm))))),
    ("mullins", "strain", (0.4, 1.5), lambda r: P(r.l) * (1.0 - 0.4 * (1.0 - (r.e / r.em) ** 1.5)) if r.em else 0.0),
    ("mullins", "strain-shape", (0.4, 1.5, 0.8, 0.6),
     lambda r: P(r.l) * (1.0 - 0.4 * (2.0 * r.em) ** 0.6 * (1.0 - (r.e / r.em) ** 1.5) ** 0.8) if r.em else 0.0),
    ("mullins", "strain-cycles", (0.4, 1.5, 0.3),
     lambda r: P(r.l) * (1.0 - 0.4 * (1.0 - 0.3**r.returns) * (1.0 - (r.e / r.em) ** 1.5)) if r.em else 0.0),
    ("mullins", "damage", (0.4, 0.3), lambda r: P(r.l) * (1.0 - 0.4 * (1.0 - math.exp(-r.em / 0.3)))),
    ("mullins", "damage-power", (0.4, 0.3, 1.7),
     lambda r: P(r.l) * (1.0 - 0.4 * (1.0 - math.exp(-((r.em / 0.3) ** 1.7))))),
    ("mullins", "damage-way", (0.4, 0.3, 1.7, 0.5), lambda r: P(r.l) * (1.0 - damage(0.4, 0.3, 1.7, 0.5)(r))),
    *(("permanent-set", form, values, set_of(form, values)) for form, values in (
        ("returned", (0.2,)), ("flow", (0.2,)), ("next-pull", (0.2,)), ("returned-power", (0.2, 1.4)),
        ("flow-power", (0.2, 1.4)), ("next-pull-power", (0.2, 1.4)), ("returned-bent", (0.2, 1.5)),
        ("flow-bent", (0.2, 1.5)),
        ("crept", (0.3, 0.4)), ("cycles", (0.05, 0.5)), ("flow-added", (0.2,)),
        ("next-pull-added", (0.2,)),
        ("crept-added", (0.3, 0.4)), ("cycles-added", (0.05, 0.5)), ("flow-power-added", (0.2, 1.4)),
        ("flow-bent-added", (0.2, 1.5)), ("network", (0.2,)), ("network-power", (0.2, 1.4)),
        # What flowed left the section narrower; what is unfolded, or shows on the way down alone, did not.
        ("flow", (0.21, 1.0)), ("flow-power", (0.21, 1.4, 0.6)), ("flow-bent", (0.21, 1.5, 1.0)),
        ("next-pull", (0.21, 0.6)), ("next-pull-power", (0.21, 1.4, 1.0)), ("crept", (0.31, 0.4, 1.0)),
        ("cycles", (0.06, 0.5, 1.0)), ("flow-added", (0.21, 1.0)), ("returned", (0.21, 1.0)),
    )),
    ("permanent-set", "smooth-returned", (0.7, 0.01, 0.03, 0.06, 0.09, 0.12, 1.0),
     lambda r: set_shown(r, spline((0.01, 0.03, 0.06, 0.09, 0.12), r.em / 0.7))),
    ("permanent-set", "smooth-returned-load-each-way", (1.4, 0.01, 0.03, 0.06, 0.09, 0.12, 0.5, 1.3, 1.0),
     lambda r: set_shown(
         r, (1.0 + 0.5 * math.sin(r.angle) ** 2) * spline((0.01, 0.03, 0.06, 0.09, 0.12), (r.lm - r.lm**-2) / 1.4))),
    ("thermal-softening", "exponential", (0.004,), lambda r: P(r.l) * math.exp(-0.004 * (r.temperature - REFERENCE))),
    ("thermal-softening", "curved", (0.004, 5e-5),
     lambda r: P(r.l) * math.exp(-0.004 * (r.temperature - REFERENCE) - 5e-5 * (r.temperature - REFERENCE) ** 2)),
    ("thermal-softening", "glass", (0.004, 1.5, 10.0, 8.0),
     lambda r: P(r.l) * math.exp(1.5 * (1.0 / (1.0 + math.exp((r.temperature - 10.0) / 8.0))
     - 1.0 / (1.0 + math.exp((REFERENCE - 10.0) / 8.0))) - 0.004 * (r.temperature - REFERENCE))),
    ("grip-slack", "play", (0.06,), lambda r: P(max(r.l - 0.06, 1.0))),
    ("grip-slack", "play", (-0.06,), lambda r: P(r.l + 0.06)),
    ("grip-slack", "toe", (0.06, 0.04), lambda r: P(1.0 + 0.5 * (r.e - 0.06 + math.hypot(r.e - 0.06, 0.04)))),
    ("grip-slack", "each", (0.06, 0.03), lambda r: P(max(r.l - (0.06, 0.09)[r.curve], 1.0))),
    ("grip-slack", "each-toe", (0.06, 0.03, 0.04),
     lambda r: P(1.0 + 0.5 * (r.e - (0.06, 0.09)[r.curve] + math.hypot(r.e - (0.06, 0.09)[r.curve], 0.04)))),
    ("grip-slack", "each-toe", (-0.06, 0.09, 0.04),
     lambda r: P(r.l + 0.06 if r.curve == 0 else 1.0 + 0.5 * (r.e - 0.03 + math.hypot(r.e - 0.03, 0.04)))),
    ("grip-slack", "each-askew", (-0.06, 0.09, 0.8),
     lambda r: P(r.l + 0.06 if r.curve == 0 else 1.0 + 0.5 * (r.e - 0.03 + math.hypot(r.e - 0.03, 0.024)))),
    ("load-offset", "constant", (0.03,), lambda r: P(r.l) + 0.03),
    ("load-offset", "drift", (0.03, -0.002), lambda r: P(r.l) + 0.03 - 0.002 * r.t),
    ("load-offset", "settling", (0.03, -0.002, 6.0), lambda r: P(r.l) + 0.03 - 0.012 * (1.0 - math.exp(-r.t / 6.0))),
    ("load-offset", "each", (0.03, 0.01), lambda r: P(r.l) + (0.03, 0.04)[r.curve]),
    ("load-offset", "each-drift", (0.03, 0.01, -0.02, 0.05),
     lambda r: P(r.l) + (0.03, 0.04)[r.curve] + (-0.02, 0.05)[r.curve] * passed(r)),
    ("load-offset", "each-settling", (0.03, 0.01, -0.02, 0.05, 6.0),
     lambda r: P(r.l) + (0.03, 0.04)[r.curve] + (-0.02, 0.05)[r.curve] * passed(r, 6.0)),
    ("compressibility", "uniform", (0.3,), contracting(0.3)),
    ("compressibility", "slope", (0.3,), contracting(0.3, slope=True)),
    ("compressibility", "width", (0.3,), lambda r: P(r.l)),
    ("compressibility", "width-bent", (0.3, 0.2), lambda r: P(r.l)),
    ("compressibility", "width-directions", (0.3, 0.4), lambda r: P(r.l)),
    ("compressibility", "directions", (0.3, 0.4), contracting(0.3, weft=0.4)),
    ("compressibility", "slanted", (0.3, 0.4, 0.2), contracting(0.3, weft=0.4, between=0.2)),
    ("compressibility", "uniform-bent", (0.3, 0.2), contracting(0.3, bend=0.2)),
    ("compressibility", "slope-bent", (0.3, 0.2), contracting(0.3, slope=True, bend=0.2)),
    ("compressibility", "directions-bent", (0.3, 0.4, 0.2), contracting(0.3, weft=0.4, bend=0.2)),
    ("elastic-law", "powers", (0.02, 0.01), richer(lambda x, y: (0.04 * x + 0.03 * x * x, 0.0))),
    ("elastic-law", "powers-log", (0.02, 0.01, 0.05), plus(richer(lambda x, y: (0.04 * x + 0.03 * x * x, 0.0)), LOG)),
    ("elastic-law", "high-powers", (0.02, 0.05), plus(richer(lambda x, y: (0.08 * x**3, 0.0)), LOG)),
    ("elastic-law", "second-invariant", (0.02, 0.01, 0.03),
     richer(lambda x, y: (0.01 * y, 0.02 + 0.01 * x + 0.06 * y))),
    ("elastic-law", "second-invariant-log", (0.02, 0.01, 0.03, 0.05),
     plus(richer(lambda x, y: (0.01 * y, 0.02 + 0.01 * x + 0.06 * y)), LOG)),
    ("elastic-law", "powers-mixed", (0.02, 0.01, 0.04, 0.03),
     richer(lambda x, y: (0.04 * x + 0.03 * x * x + 0.03 * y, 0.04 + 0.03 * x))),
    ("elastic-law", "ogden", (0.05, 3.5), power_term(0.05, 3.5)),
    ("elastic-law", "ogden-log", (0.05, 3.5, 0.05), plus(power_term(0.05, 3.5), LOG)),
    ("elastic-law", "exponential", (0.05, 0.8), richer(lambda x, y: (0.05 * math.exp(0.8 * x), 0.0))),
    ("elastic-law", "exponential-log", (0.05, 0.8, 0.05),
     plus(richer(lambda x, y: (0.05 * math.exp(0.8 * x), 0.0)), LOG)),
    ("elastic-law", "straightening", (0.05, 0.4, 0.1), richer(lambda x, y: (0.05 * logistic(x, 0.4, 0.1), 0.0))),
    ("elastic-law", "straightening-log", (0.05, 0.4, 0.1, 0.05),
     plus(richer(lambda x, y: (0.05 * logistic(x, 0.4, 0.1), 0.0)), LOG)),
]  # fmt: skip
#: What grips give, at sixths.
GIVES = (0.004, 0.01, 0.02, 0.03, 0.035, 0.05)


def given_freely(load: float) -> float:
    """What grips give by a smooth law that is told up to 0.5 MPa."""
    return spline(GIVES, math.log1p(20.0 * load / 0.5) / math.log(21.0))


#: Verified where they are told: by differences of its own energy (tests/loop/test_effects.py), and as strips that find
#: their width and shear (tests/materials/test_threads.py).
STATED += [
    (
        "mullins",
        "smooth",
        (0.8, 1.4, 0.7, 0.6, 0.2, 0.3, 0.35, 0.05, 0.08, 0.1),
        lambda row: (
            P(row.l)
            * (
                1.0
                - spline((0.05, 0.08, 0.1), row.em / 0.8)
                - (
                    spline((0.2, 0.3, 0.35), row.em / 0.8)
                    * (1.0 - 0.6 ** max(row.returns, 1))
                    * (1.0 - (row.e / row.em) ** 1.4) ** 0.7
                    if row.e < row.em
                    else 0.0
                )
            )
        ),
    ),
    (
        "mullins",
        "smooth-energy",
        (W(1.8), 1.4, 0.7, 0.6, 0.2, 0.3, 0.35, 0.05, 0.08, 0.1),
        lambda row: (
            P(row.l)
            * (
                1.0
                - spline((0.05, 0.08, 0.1), math.sqrt(W(row.lm) / W(1.8)))
                - (
                    spline((0.2, 0.3, 0.35), math.sqrt(W(row.lm) / W(1.8)))
                    * (1.0 - 0.6 ** max(row.returns, 1))
                    * (1.0 - math.sqrt(W(row.l) / W(row.lm)) ** 1.4) ** 0.7
                    if row.e < row.em
                    else 0.0
                )
            )
        ),
    ),
    (
        "grip-slack",
        "smooth",
        (0.8, *GIVES),
        lambda row: P(1.0 + max(row.e - spline(GIVES, math.log1p(25.0 * row.e) / math.log(21.0)), 0.0)),
    ),
    ("grip-slack", "yields", (0.5, 0.025), lambda row: P(gripped(row.l, lambda load: 0.05 * load))),
    (
        "grip-slack",
        "yields-curved",
        (0.5, 0.025, 2.0),
        lambda row: P(gripped(row.l, lambda load: 0.025 * (1.0 - math.exp(-4.0 * load)) / (1.0 - math.exp(-2.0)))),
    ),
    (
        "grip-slack",
        "slips",
        (0.5, 0.05, 0.3),
        lambda row: P(slipped(row, lambda load: 0.1 * max(load - 0.3, 0.0))),
    ),
    ("grip-slack", "smooth-force", (0.5, *GIVES), lambda row: P(gripped(row.l, given_freely))),
    ("grip-slack", "smooth-slip", (0.5, *GIVES), lambda row: P(slipped(row, given_freely))),
    (
        "load-offset",
        "smooth",
        (20.0, 0.03, 0.01, 0.02, -0.01),
        lambda row: P(row.l) + 0.03 + spline((0.01, 0.02, -0.01), row.t / 20.0),
    ),
    (
        "thermal-softening",
        "smooth",
        (0.8, 0.004, 1e-5, 0.002, 0.003),
        lambda row: (
            P(row.l)
            * math.exp(
                -(row.temperature - REFERENCE) * (0.004 + spline((0.002, 0.003), row.e / 0.8))
                - 1e-5 * (row.temperature - REFERENCE) ** 2
            )
        ),
    ),
    (
        "thermal-softening",
        "smooth-heat",
        (0.8, 20.0, 80.0, 0.002, 0.003, 0.1, 0.4, 0.6),
        lambda row: (
            P(row.l)
            * math.exp(
                -spline((0.1, 0.4, 0.6), (row.temperature - 20.0) / 60.0)
                - (row.temperature - REFERENCE) * spline((0.002, 0.003), row.e / 0.8)
            )
        ),
    ),
]


def weft_more(plain: Callable[[Row], float]) -> Callable[[Row], float]:
    """Return the stress of an effect of which the weft has half as much again; all rows are of strips."""
    return lambda row: P(row.l) + (1.0 + 0.5 * math.sin(row.angle) ** 2) * (plain(row) - P(row.l))


STATED += [
    (effect, f"{form}-each-way", (*values, 0.5, 1.3), weft_more(plain))
    for effect, form, values, plain in STATED
    if (effect, form) in {("mullins", "smooth"), ("mullins", "smooth-energy"), ("rate", "smooth")}
]
#: Forms that go from reading to reading by steps, on both sides, or find the load of a specimen between such.
BY_STEPS = ("finite", "finite-2", "yields", "yields-curved", "slips", "smooth-force", "smooth-slip")
ELSEWHERE = (
    {("compressibility", "split")}
    | {("anisotropy", form) for form in ("threads", "threads-each", "bias-threads", "bias-threads-nearest", "sheet")}
    | {("elastic-law", form) for form in ("term-2", "term-3", "terms-2-3")}  # tests/loop/test_foams.py
)
#: Smooth laws that are not worked out here; of the energy tests/loop/test_smooth.py has limits.
NOT_HERE = {
    ("hysteresis", "smooth"), ("permanent-set", "smooth"), ("elastic-law", "smooth"),
    ("elastic-law", "smooth-close"), ("elastic-law", "smooth-mixed"), ("elastic-law", "smooth-each-way"),
    ("elastic-law", "smooth-close-each-way"), ("elastic-law", "smooth-strain-each-way"),
    ("elastic-law", "smooth-strain"),
    ("permanent-set", "smooth-flow"),
    ("compressibility", "uniform-smooth"), ("compressibility", "slope-smooth"),
    ("compressibility", "directions-smooth"), ("compressibility", "slanted-smooth"),
    ("compressibility", "width-smooth"), ("compressibility", "width-directions-smooth"),
    ("hysteresis", "smooth-each-way"),
    ("permanent-set", "smooth-load-each-way"), ("permanent-set", "smooth-flow-load-each-way"),
    ("permanent-set", "smooth-close"), ("permanent-set", "smooth-flow-close"),
}  # fmt: skip


def measured() -> Fabric:
    column = {name: np.array([getattr(row, name) for row in ROWS]) for name in ("l", "t", "temperature", "angle")}
    path = Path(
        starts=(0, len(CURVES[0]), len(ROWS)),
        mode=np.full(len(ROWS), UNIAXIAL),
        stretch=column["l"],
        across=np.full(len(ROWS), np.nan),
        time_s=column["t"],
        temperature_degC=column["temperature"],
        angle_deg=np.degrees(column["angle"]),
        branch=np.zeros(len(ROWS), dtype=np.int64),
    )
    return Fabric(law("yeoh-3"), path, REFERENCE, np.array(TOLD))


@pytest.mark.parametrize(
    ("effect", "form", "values", "stated"),
    STATED,
    ids=[f"{case[0]}-{case[1]}-{case[2][0]}" for case in STATED],
)
def test_a_form_is_the_law_that_the_page_states(
    effect: str, form: str, values: tuple[float, ...], stated: Callable[[Row], float]
) -> None:
    found = measured().stress(np.array(C), None, {effect: (form, np.array(values))})
    near = 1e-5 if form in BY_STEPS else 1e-9
    assert found == pytest.approx([stated(row) for row in ROWS], rel=near, abs=1e-12)


@pytest.mark.parametrize("slope", [None, 0.3])
@pytest.mark.parametrize("form", ["returned", "flow", "flow-added", "next-pull"])
@pytest.mark.parametrize("power", [None, 0.0, 0.6, 1.0])
def test_a_set_contracts_the_strip_as_the_page_states(form: str, power: float | None, slope: float | None) -> None:
    """Slack it is as wide as a strip pulled to its set, at the peak of ``returned`` as one that has none."""
    share, contracts = 0.2, lambda l: l ** -(slope or 0.5)
    terms = {"permanent-set": (form, np.array([share] if power is None else [share, power]))}
    if slope:
        terms["compressibility"] = ("uniform", np.array([slope]))
    stated = []
    for row in ROWS:
        s = share * ((row.earlier if form == "next-pull" else row.lm) - 1.0)
        elastic = unslack(row.l, s, form.endswith("-added"))
        if form == "returned":
            elastic = row.l if row.l >= row.lm else 1.0 + max((row.e - s) * row.em / (row.em - s), 0.0)
            s = s if elastic == 1.0 else row.l / elastic - 1.0
        stated.append(contracts(elastic) * contracts(1.0 + s) ** (power or 0.0))
    assert measured().across(terms) == pytest.approx(stated, rel=1e-12)


def test_every_form_of_a_fabric_on_the_page_is_worked_out_here(root: File) -> None:
    page = (root / "docs" / "close-loop-laws.md").read_text(encoding="utf-8")
    told, effect = set(), ""
    for line in page[page.index("## Fabric") : page.index("## Mold")].splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) > 3 and cells[2].startswith("`"):
            effect = cells[1].strip("`") or effect
            told |= {(effect, form) for form in re.findall(r"`([a-z0-9-]+)`", cells[2])}
    assert told - ELSEWHERE - NOT_HERE == {case[:2] for case in STATED}
    assert told >= NOT_HERE


def test_effects_act_in_the_order_of_the_page() -> None:
    """Slack changes the stretch; warmth multiplies the law; then friction on that, and the cell's offset on all."""
    terms = {
        "load-offset": ("constant", np.array([0.03])),
        "hysteresis": ("friction", np.array([0.1, 0.2])),
        "thermal-softening": ("exponential", np.array([0.004])),
        "mullins": ("damage", np.array([0.4, 0.3])),
        "grip-slack": ("play", np.array([0.06])),
    }

    def elastic(row: Row) -> float:
        warm = math.exp(-0.004 * (row.temperature - REFERENCE))
        return P(max(row.l - 0.06, 1.0)) * warm * (1.0 - 0.4 * (1.0 - math.exp(-row.em / 0.3)))

    force = slide(lambda q: 0.1 * elastic(q), 0.2, lambda q: max(q.l - 0.06, 1.0), 1.0)
    found = measured().stress(np.array(C), None, terms)
    assert found == pytest.approx([elastic(row) + force(row) + 0.03 for row in ROWS], rel=1e-9)


def test_where_directions_meet() -> None:
    """A test both ways has half of each direction; a test at 45 degrees too, and all of the softness."""
    stretch = np.array([1.3, 1.3, 1.3, 1.3])
    none = np.full(4, np.nan)
    path = Path(
        starts=(0, 1, 2, 3, 4), mode=np.array([BIAXIAL, UNIAXIAL, UNIAXIAL, SHEAR]), stretch=stretch, across=none,
        time_s=none, temperature_degC=none, angle_deg=np.array([0.0, 45.0, np.nan, 90.0]),
        branch=np.zeros(4, dtype=np.int64),
    )  # fmt: skip
    fabric = Fabric(law("neo-hookean"), path)
    both, plain, shear = 0.4 * (1.3 - 1.3**-5), 0.4 * (1.3 - 1.3**-2), 0.4 * (1.3 - 1.3**-3)
    assert fabric.stress(np.array([0.2]), None, {}) == pytest.approx([both, plain, plain, shear], rel=1e-12)
    found = fabric.stress(np.array([0.2]), None, {"anisotropy": ("constants", np.array([-0.1]))})
    assert found == pytest.approx([0.75 * both, 0.75 * plain, plain, 0.5 * shear], rel=1e-12)
    assert fabric.stress(np.array([0.2]), np.array([0.1]), {}) == pytest.approx(
        [0.75 * both, 0.75 * plain, plain, 0.5 * shear], rel=1e-12
    )


def test_the_transverse_stretch_is_the_one_stated() -> None:
    fabric, stretch = measured(), np.array([row.l for row in ROWS])
    assert fabric.across({}) == pytest.approx(stretch**-0.5, rel=1e-14)
    bent = fabric.across({"compressibility": ("directions-bent", np.array([0.3, 0.4, 0.2]))})
    nu = np.array([0.3 + 0.1 * share(row) for row in ROWS])
    assert bent == pytest.approx(stretch ** -(nu + 0.2 * np.log(stretch)), rel=1e-12)
    # Beside threads too, whose own contraction it takes the place of.
    width = {"compressibility": ("width", np.array([0.3])), "anisotropy": ("threads", np.array([0.1, 0.05, 0.2, 0.02]))}
    assert fabric.across(width, np.array(C)) == pytest.approx(stretch**-0.3, rel=1e-14)
    # Slack in the grips is no stretch of the specimen: it does not contract either.
    slack = fabric.across({"grip-slack": ("play", np.array([0.06]))})
    assert slack == pytest.approx(np.maximum(stretch - 0.06, 1.0) ** -0.5, rel=1e-14)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_the_energy_of_a_sheet_with_threads_and_an_added_law_is_the_integral_of_its_stress(
    angle: float,
) -> None:
    """Mullins' and the pseudo-elastic loop live on that energy: its slope along a pull is the nominal stress."""
    lam, h = np.linspace(1.05, 1.6, 6), 1e-4
    threads = {"anisotropy": ("threads", np.array([0.1, 0.05, 0.4, 0.03]))}

    def answer(terms: dict[str, tuple[str, np.ndarray]], stretch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        way = uniaxial_pull(stretch)
        way.angle_deg[:] = angle
        sheet = Fabric(law("neo-hookean"), way, REFERENCE)
        return sheet._of_threads(np.array([0.2]), terms, (stretch, way.across), ())[:2]

    for terms in (threads, {**threads, "elastic-law": ("powers", np.array([0.05, 0.02]))}):
        stress, energy = answer(terms, lam)
        more, less = (answer(terms, lam + d)[1] for d in (h, -h))
        # A strip at an angle is in balance to some millionths: the energy does not feel it, the stress does.
        np.testing.assert_allclose((more - less) / (2.0 * h), stress, rtol=1e-5)
        assert energy.min() > 0.0
