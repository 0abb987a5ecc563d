"""A second heated mold with an effect nobody declares: other sizes, metals, programs and laws than ``heat``.

Finite volumes on a quarter of the mold, dense matrices, two Richardson-extrapolated backward Euler steps. Each effect
comes in kinds, several of which the catalogue has as well: a lag in two stages, an emissivity that rises, a bench
that warms up, surroundings that swing, a joint that is good in the middle alone.
Units: m, W, K, s; temperatures in degC.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

KINDS = {
    "radiation": 3, "contact-resistance": 3, "sensor-lag": 3, "power-loss": 3, "base-conduction": 3,
    "property-drift": 3, "ambient-drift": 3, "convection-law": 3,
}  # fmt: skip
OUTSIDE = ("stem", "open-door", "latent", "creeping-probe")
SIDE, PLATE, BLOCK = 0.24, 0.03, 0.06
K, RHO, C, FILM, AIR = 150.0, 2700.0, 900.0, 14.0, 23.0
POWER, DURATION = 1100.0, 14000.0
_N, _LOW, _HIGH = 5, 2, 4


@dataclass
class Truth:
    """Effects, their sizes and kinds."""

    effects: tuple[str, ...]
    size: dict[str, float] = field(default_factory=dict)
    kind: dict[str, int] = field(default_factory=dict)
    shape: float = 0.5


def draw(random: Generator, effects: tuple[str, ...], kind: int | None = None) -> Truth:
    """Return a mold with effects of random size and kind; ``kind`` fixes that of the first."""
    truth = Truth(effects, shape=float(random.uniform()))
    for number, name in enumerate(effects):
        most = KINDS.get(name, 1)
        truth.size[name] = float(random.uniform(0.5, 1.5))
        truth.kind[name] = kind % most if kind is not None and number == 0 else int(random.integers(0, most))
    return truth


@dataclass(frozen=True)
class Program:
    """Another run: power [W] linear between times [s], and the means of plate and block read beside the probes."""

    times: Array
    power: Array
    means: bool = False


def schedule(time: float, poor: bool, program: Program | None = None) -> float:
    """Heat-up by a ramp and a plateau, less power, cool-down, a second heat-up [W]; poor: heat-up alone."""
    if program is not None:
        return float(np.interp(time, program.times, program.power))
    share = time / DURATION
    if poor:
        return POWER * 0.7
    knots = [0.0, 0.05, 0.3, 0.301, 0.5, 0.501, 0.8, 0.801, 1.0]
    return POWER * float(np.interp(share, knots, [0.2, 1.0, 1.0, 0.45, 0.45, 0.0, 0.0, 0.9, 0.9]))


def measure(
    truth: Truth,
    random: Generator,
    noise: float,
    rows: int = 200,
    poor: bool = False,
    program: Program | None = None,
) -> tuple[Array, Array]:
    """Return times (t,) and readings of four probes (t, 4), two in the plate and two in the block.

    Poor: two probes, both in the plate. Columns of the means follow where the program asks for them.
    """
    coarse, fine = _march(truth, rows, 3, poor, program), _march(truth, rows, 6, poor, program)
    clean = 2.0 * fine - coarse
    shown = [0, 1] if poor else [0, 1, 2, 3]
    clean = clean[:, [*shown, 4, 5] if program is not None and program.means else shown]
    times = np.linspace(0.0, DURATION if program is None else float(program.times[-1]), rows)
    return times, clean + noise * random.standard_normal(clean.shape)


def _march(truth: Truth, rows: int, substeps: int, poor: bool, program: Program | None) -> Array:
    n, layers = _N, _LOW + _HIGH
    dx = SIDE / (2 * n)
    dz = np.concatenate([np.full(_LOW, PLATE / _LOW), np.full(_HIGH, BLOCK / _HIGH)])
    index = np.arange(n * n * layers).reshape(n, n, layers)
    volume = np.broadcast_to(dx * dx * dz, index.shape).ravel()
    size, kind, count = truth.size, truth.kind, n * n * layers
    links, joint = np.zeros((count, count)), np.zeros((count, count))

    def link(matrix: Array, a: Array, b: Array, g: Array | float) -> None:
        a, b, g = a.ravel(), b.ravel(), np.broadcast_to(g, a.shape).ravel()
        for i, j, value in zip(a, b, g, strict=True):
            matrix[i, i] += value
            matrix[j, j] += value
            matrix[i, j] -= value
            matrix[j, i] -= value

    wide = np.broadcast_to(K * dz, (n - 1, n, layers))
    link(links, index[:-1], index[1:], wide)
    link(links, index[:, :-1], index[:, 1:], np.broadcast_to(K * dz, (n, n - 1, layers)))
    for layer in range(layers - 1):
        extra = np.zeros((n, n))
        if layer == _LOW - 1 and "contact-resistance" in size:
            extra += 1.0e-3 * size["contact-resistance"]
            if kind["contact-resistance"] == 1:  # pressed in the middle alone
                at = np.arange(n) + 0.5
                extra *= 0.3 + 1.4 * (at[:, None] ** 2 + at[None, :] ** 2) / (2.0 * n * n / 3.0) / 2.0
        to = joint if layer == _LOW - 1 else links
        link(
            to,
            index[:, :, layer],
            index[:, :, layer + 1],
            dx * dx / (0.5 * (dz[layer] + dz[layer + 1]) / K + extra),
        )
    area = np.zeros(index.shape)
    area[-1] += dx * dz
    area[:, -1] += dx * dz
    area[:, :, -1] += dx * dx
    film_area = area.ravel()
    below = np.zeros(index.shape)
    below[:, :, 0] = dx * dx
    bottom = below.ravel()
    steps = rows - 1
    dt = (DURATION if program is None else float(program.times[-1])) / (steps * substeps)
    now = np.full(count, AIR)
    bench = AIR
    places = [(0, 0, 0), (3, 2, 0), (0, 0, _LOW + 1), (3, 3, _LOW + 2)]
    probes = [int(index[place]) for place in places]
    look = np.zeros((6, count))
    look[np.arange(4), probes] = 1.0
    plate = np.broadcast_to(np.arange(layers) < _LOW, index.shape).ravel()
    look[4], look[5] = plate * volume / (plate @ volume), ~plate * volume / (~plate @ volume)
    shown, middle = look @ now, look @ now
    found = [shown.copy()]
    heated = bottom / bottom.sum()
    for step in range(steps * substeps):
        time = (step + 1) * dt
        air = _air(truth, time)
        guess = now
        for _ in range(2):
            capacity, matrix, source, bench_next = _balance(
                truth,
                guess,
                now,
                time,
                air,
                bench,
                bottom,
                film_area,
                volume,
                links,
                joint,
                heated,
                poor,
                dt,
                program,
            )
            guess = np.linalg.solve(matrix + np.diag(capacity / dt), capacity / dt * now + source)
        now, bench = guess, bench_next
        metal = look @ now
        if "stem" in size:
            metal[1] -= 0.06 * size["stem"] * (metal[1] - air)
        if "creeping-probe" in size:
            metal[2] += 4.0 * size["creeping-probe"] * (time / DURATION) ** 2
        lag = np.zeros(6)
        if "sensor-lag" in size:
            lag += 55.0 * size["sensor-lag"]
            if kind["sensor-lag"] == 1:
                lag *= np.array([0.6, 1.3, 0.8, 1.3, 0.6, 0.6])
        if kind.get("sensor-lag") == 0:
            middle = metal + np.exp(-dt / (0.5 * lag)) * (middle - metal)
            shown = middle + np.exp(-dt / (0.5 * lag)) * (shown - middle)
        else:
            keep = np.exp(-dt / np.maximum(lag, 1e-9)) if lag[0] else np.zeros(6)
            shown = metal + keep * (shown - metal)
        if (step + 1) % substeps == 0:
            found.append(shown.copy())
    return np.array(found)


def _air(truth: Truth, time: float) -> float:
    if "ambient-drift" not in truth.size:
        return AIR
    rise, share = 9.0 * truth.size["ambient-drift"], time / DURATION
    kind = truth.kind["ambient-drift"]
    if kind == 0:
        return AIR + rise * float(np.sin(2.0 * np.pi * share / 1.6))
    if kind == 1:
        return AIR + 1.2 * rise * (1.0 - float(np.exp(-3.0 * share)))
    return AIR + rise * min(share / 0.6, 1.0)


def _balance(
    truth: Truth, at: Array, now: Array, time: float, air: float, bench: float, bottom: Array, film_area: Array,
    volume: Array, links: Array, joint: Array, heated: Array, poor: bool, dt: float, program: Program | None,
) -> tuple[Array, Array, Array, float]:  # fmt: skip
    size, kind = truth.size, truth.kind
    away = np.maximum(np.abs(at - air), 0.1)
    h = np.full(len(at), FILM)
    if "convection-law" in size:
        grade = size["convection-law"]
        if kind["convection-law"] == 0:
            h = FILM * (away / 60.0) ** (0.25 * grade)
        elif kind["convection-law"] == 1:
            h = FILM * (1.0 - 0.5 * grade * 0.66 + 0.66 * 0.5 * grade * (away / 60.0) ** (1.0 / 3.0) * 1.3)
        else:
            h = FILM * (0.7 + 0.12 * grade * np.log1p(away))
    if "open-door" in size and 0.12 < time / DURATION < 0.2 + 0.1 * truth.shape:
        h = h * (1.0 + 2.0 * size["open-door"])
    sky, grey = air, 0.0
    if "radiation" in size:
        grey = min(0.55 * size["radiation"], 0.95)
        if kind["radiation"] == 1:
            grey = grey * (0.7 + 0.0025 * (at - 23.0))
        if kind["radiation"] == 2:
            sky = air - 6.0
    radiated = grey * 5.67e-8 * ((at + 273.15) ** 2 + (sky + 273.15) ** 2) * (at + sky + 546.3)
    loss, source = (h + radiated) * film_area, h * film_area * air + radiated * film_area * sky
    bench_next = bench
    if "base-conduction" in size:
        g = 22.0 * size["base-conduction"]
        under = g * bottom
        to = air
        if kind["base-conduction"] == 1:  # a bench of 60 kJ/K that cools to the air
            flow = float(under @ (now - bench))
            bench_next = bench + dt * (4.0 * flow - 25.0 * (bench - air)) / 60e3
            to = bench
        elif kind["base-conduction"] == 2:  # feet: under the middle alone
            under = under * (np.arange(len(at)) < len(at) // 2) * 2.0
        loss, source = loss + under, source + under * to
    # The mean over the step: a ramp or a jump inside it counts from where it is.
    power = float(np.mean([schedule(time - dt * (i + 0.5) / 10, poor, program) for i in range(10)])) / 4.0
    if "power-loss" in size:
        hot, grade = float(heated @ at) - AIR, size["power-loss"]
        if kind["power-loss"] == 0:
            power *= 1.0 - 0.12 * grade - 0.0012 * grade * hot
        elif kind["power-loss"] == 1:  # a wire at constant voltage
            power /= 1.0 + 0.0025 * grade * hot
        else:  # heat into the back of the heater: grows with what is above the air
            power -= 0.25 * grade * hot / 4.0 * (1.0 if power > 0.0 else 0.0)
    rate, conducts = np.ones(len(at)), 1.0
    if "property-drift" in size:
        grade, warm = size["property-drift"], at - AIR
        if kind["property-drift"] == 0:
            rate = 1.0 + 0.0012 * grade * warm
        elif kind["property-drift"] == 1:
            rate = 1.0 + 0.25 * grade * (1.0 - np.exp(-warm / 120.0))
        else:
            rate = 1.0 + 5e-6 * grade * warm**2
    if "latent" in size:
        rate = rate + 1.2 * size["latent"] * np.exp(-(((at - 95.0) / 6.0) ** 2))
    if kind.get("contact-resistance") == 2:
        conducts = 1.0 + 0.003 * (float(np.mean(at)) - AIR)
    return (
        RHO * C * volume * rate,
        links + conducts * joint + np.diag(loss),
        source + power * heated,
        bench_next,
    )


def mold_toml(poor: bool = False) -> tuple[str, str]:
    """Return the mold document an engineer would write, without any effect, and its power table."""
    half, plate, top = 1e3 * SIDE / 2, 1e3 * PLATE, 1e3 * (PLATE + BLOCK)
    dx, dl, dh = half / _N, 1e3 * PLATE / _LOW, 1e3 * BLOCK / _HIGH
    probes = [
        (0.5 * dx, 0.5 * dx, 0.5 * dl), (3.5 * dx, 2.5 * dx, 0.5 * dl),
        (0.5 * dx, 0.5 * dx, plate + 1.5 * dh), (3.5 * dx, 3.5 * dx, plate + 2.5 * dh),
    ]  # fmt: skip
    text = f"""format = "hyperfab.mold/1"
[material.alloy]
density = "{RHO} kg/m^3"
conductivity = "{K} W/m/K"
specific_heat = "{C} J/kg/K"
[[part]]
name = "plate"
material = "alloy"
box = {{ origin = ["0 mm", "0 mm", "0 mm"], size = ["{half} mm", "{half} mm", "{plate} mm"] }}
[[part]]
name = "block"
material = "alloy"
box = {{ origin = ["0 mm", "0 mm", "{plate} mm"], size = ["{half} mm", "{half} mm", "{top - plate} mm"] }}
[[heater]]
on = "plate.z-"
schedule = "power.csv"
[[insulated]]
on = ["plate.x-", "plate.y-", "block.x-", "block.y-"]
[[convection]]
on = "exposed"
h = "{FILM} W/m^2/K"
ambient = "{AIR} degC"
[run]
start = "{AIR} degC"
until = "{DURATION} s"
mesh_size = "30 mm"
"""
    for number, (x, y, z) in enumerate(probes[: 2 if poor else 4], start=1):
        text += f'[[probe]]\nname = "T{number}"\nat = ["{x:.6g} mm", "{y:.6g} mm", "{z:.6g} mm"]\n'
    knots = [0.0, 0.05, 0.3, 0.301, 0.5, 0.501, 0.8, 0.801, 1.0] if not poor else [0.0, 1.0]
    rows = [f"{DURATION * share},{schedule(DURATION * share, poor) / 4.0}" for share in knots]
    return text, "time [s],power [W]\n" + "\n".join(rows) + "\n"
