"""A plate and a block on it, heated: finite volumes on a regular grid, none of hyperfab's own code.

Units: m, W, K, s; temperatures in degC. The plate (lower part) is heated from below, both lose heat to the air.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]

IDS = (
    "radiation", "contact-resistance", "sensor-lag", "power-loss", "base-conduction", "property-drift", "ambient-drift",
    "convection-law",
)  # fmt: skip
SIDE, PLATE, BLOCK = 0.2, 0.03, 0.05
K, RHO, C, FILM, AIR = 60.0, 7800.0, 460.0, 15.0, 25.0
POWER, DURATION = 1200.0, 12000.0


@dataclass
class Truth:
    """Effects and their sizes."""

    effects: tuple[str, ...]
    size: dict[str, float] = field(default_factory=dict)


def draw(random: Generator, effects: tuple[str, ...]) -> Truth:
    """Return a mold with effects of random size."""
    return Truth(effects, {name: float(random.uniform(0.5, 1.5)) for name in effects})


def schedule(time: float) -> float:
    """Heat-up, a plateau at less power, cool-down, a second heat-up [W]."""
    share = time / DURATION
    return POWER * (1.0 if share < 0.25 else 0.4 if share < 0.45 else 0.0 if share < 0.8 else 0.8)


def measure(truth: Truth, random: Generator, noise: float, rows: int = 200) -> tuple[Array, Array]:
    """Return times (t,) and readings of four probes (t, 4): two in the plate, two in the block.

    The probes sit on the axis and at (60, 60) mm from it, in the middle of the plate's and of the block's height.
    """
    clean = 2.0 * _march(truth, rows, 8) - _march(truth, rows, 4)
    times = np.linspace(0.0, DURATION, rows)
    return times, clean + noise * random.standard_normal(clean.shape)


def _march(truth: Truth, rows: int, substeps: int) -> Array:
    """Return the probes' readings (t, 4) by backward Euler, its coefficients at the extrapolated temperature."""
    n, low, high = 6, 3, 5
    dx, dz = SIDE / (2 * n), np.concatenate([np.full(low, PLATE / low), np.full(high, BLOCK / high)])
    shape = (n, n, low + high)
    index = np.arange(np.prod(shape)).reshape(shape)
    volume = np.broadcast_to(dx * dx * dz, shape).ravel()
    size = truth.size
    rows_, columns, values = [], [], []

    def link(a: Array, b: Array, g: Array) -> None:
        a, b, g = a.ravel(), b.ravel(), np.broadcast_to(g, a.shape).ravel()
        rows_.extend([a, b, a, b])
        columns.extend([b, a, a, b])
        values.extend([g, g, -g, -g])

    side = np.broadcast_to(K * dz * dx / dx, (n - 1, n, low + high))
    link(index[:-1], index[1:], side)
    link(index[:, :-1], index[:, 1:], np.broadcast_to(K * dz * dx / dx, (n, n - 1, low + high)))
    for layer in range(low + high - 1):
        resistance = 0.5 * (dz[layer] + dz[layer + 1]) / K
        if layer == low - 1:
            resistance += 1.5e-3 * size.get("contact-resistance", 0.0)
        link(index[:, :, layer], index[:, :, layer + 1], np.full((n, n), dx * dx / resistance))
    area = np.zeros(shape)
    area[-1, :, :] += dx * dz
    area[:, -1, :] += dx * dz
    area[:, :, -1] += dx * dx
    film_area = area.ravel()
    bottom = np.zeros(shape)
    bottom[:, :, 0] = dx * dx
    bottom = bottom.ravel()
    lap = sparse.csc_matrix(
        (np.concatenate(values), (np.concatenate(rows_), np.concatenate(columns))), shape=(len(volume),) * 2
    )
    steps = rows - 1
    dt = DURATION / (steps * substeps)
    temperature = np.full(len(volume), AIR)
    earlier = temperature
    places = [(0, 0, 1), (3, 3, 1), (0, 0, low + 2), (3, 3, low + 2)]
    probes = [int(index[place]) for place in places]
    shown = temperature[probes].copy()
    found = [shown.copy()]
    lag = 60.0 * size.get("sensor-lag", 0.0)
    heated = bottom / bottom.sum()
    for step in range(steps * substeps):
        time = (step + 1) * dt
        air = AIR
        if "ambient-drift" in size:
            air += 12.0 * size["ambient-drift"] * np.sin(0.5 * np.pi * time / DURATION)
        ahead = 2.0 * temperature - earlier
        away = ahead - air
        h = np.full(len(volume), FILM)
        if "convection-law" in size:
            h = FILM * (0.5 + 0.5 * (np.maximum(away, 0.1) / 60.0) ** 0.33 * size["convection-law"] * 1.2)
        if "radiation" in size:
            grey = min(0.6 * size["radiation"], 1.0) * 5.67e-8
            h = h + grey * ((ahead + 273.15) ** 2 + (air + 273.15) ** 2) * (ahead + air + 546.3)
        loss = h * film_area + 25.0 * size.get("base-conduction", 0.0) * bottom
        # The mean over the step: a jump inside it counts from where it is.
        power = float(np.mean([schedule(time - dt * (i + 0.5) / 10) for i in range(10)])) / 4.0
        if "power-loss" in size:
            hot = float(np.mean(ahead[bottom > 0.0])) - AIR
            power *= 1.0 - 0.1 * size["power-loss"] - 0.0015 * size["power-loss"] * hot
        rate = 1.0 + 0.0012 * size.get("property-drift", 0.0) * (ahead - AIR)
        capacity = RHO * C * volume * rate / dt
        matrix = sparse.diags(capacity + loss) - lap
        earlier, past = temperature, capacity * temperature
        temperature = splu(sparse.csc_matrix(matrix)).solve(past + loss * air + power * heated)
        keep = np.exp(-dt / lag) if lag > 0.0 else 0.0
        shown = temperature[probes] + keep * (shown - temperature[probes])
        if (step + 1) % substeps == 0:
            found.append(shown.copy())
    return np.array(found)


def mold_toml() -> tuple[str, str]:
    """Return the mold document an engineer would write, without any effect, and its power table."""
    half, plate, top = 1e3 * SIDE / 2, 1e3 * PLATE, 1e3 * (PLATE + BLOCK)
    dx = half / 6
    near, far = dx / 2, 3.5 * dx
    low, high = 1e3 * PLATE / 3 * 1.5, plate + 1e3 * BLOCK / 5 * 2.5
    probes = [(near, near, low), (far, far, low), (near, near, high), (far, far, high)]
    text = f"""format = "hyperfab.mold/1"
[material.steel]
density = "{RHO} kg/m^3"
conductivity = "{K} W/m/K"
specific_heat = "{C} J/kg/K"
[[part]]
name = "plate"
material = "steel"
box = {{ origin = ["0 mm", "0 mm", "0 mm"], size = ["{half} mm", "{half} mm", "{plate} mm"] }}
[[part]]
name = "block"
material = "steel"
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
    for number, (x, y, z) in enumerate(probes, start=1):
        text += f'[[probe]]\nname = "T{number}"\nat = ["{x:.6g} mm", "{y:.6g} mm", "{z:.6g} mm"]\n'
    knots = [0.0, 0.25, 0.2501, 0.45, 0.4501, 0.8, 0.8001, 1.0]
    levels = [1.0, 1.0, 0.4, 0.4, 0.0, 0.0, 0.8, 0.8]
    rows = [f"{DURATION * t},{POWER / 4.0 * p}" for t, p in zip(knots, levels, strict=True)]
    return text, "time [s],power [W]\n" + "\n".join(rows) + "\n"
