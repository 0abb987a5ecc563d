"""A disc with a sphere pushed in, by shooting along a meridian: none of hyperfab's own code.

mm, N, MPa. The sheet is a Yeoh solid of two terms. On the sphere and off it the meridional pull N1 and the hoop pull N2
(per undeformed width) obey d(R N1)/dR = N2 cos psi + rub and N1 R dpsi/dR + N2 sin psi = pressure.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDS = ("frame-compliance", "friction", "pretension", "thermal-softening", "rim-slip")
#: What no entry of the catalogue says: a ripple of the punch's drive, a seam that tears, a load cell that saturates.
OUTSIDE = ("ripple", "torn-seam", "saturated-cell")
C10, C20, THICK, RADIUS, SPHERE, ROOM = 0.06, 0.02, 1.0, 100.0, 40.0, 23.0


@dataclass
class Truth:
    """Effects with their sizes, and how the sheet differs from its document within what is known of it."""

    effects: tuple[str, ...]
    size: dict[str, float] = field(default_factory=dict)
    soft: tuple[float, float] = (1.0, 1.0)


def draw(random: Generator, effects: tuple[str, ...], off: float = 0.013, larger: float = 1.0) -> Truth:
    """Return a sheet with effects of random size, ``larger`` than usual, its constants ``off`` by so much (one
    standard deviation)."""
    soft = 1.0 + off * random.standard_normal(2)
    return Truth(
        effects,
        {name: larger * float(random.uniform(0.4, 1.0)) for name in effects},
        (float(soft[0]), float(soft[1])),
    )


def pulls(l1: Array, l2: Array, c10: float, c20: float) -> tuple[Array, Array]:
    """Return N1, N2 [N/mm] at the stretches."""
    l3 = 1.0 / (l1 * l2)
    rise = l1**2 + l2**2 + l3**2 - 3.0
    slope = 2.0 * (c10 + 2.0 * c20 * rise) * THICK
    return slope * (l1 - l3**2 / l1), slope * (l2 - l3**2 / l2)


def stretch_for(n1: Array, l2: Array, guess: Array, c10: float, c20: float) -> Array:
    """Return the meridional stretch that pulls with ``n1``."""
    l1 = guess
    for _ in range(4):
        value = pulls(l1, l2, c10, c20)[0]
        more = pulls(l1 + 1e-6, l2, c10, c20)[0]
        l1 = np.clip(l1 - (value - n1) / ((more - value) / 1e-6), 0.5, 5.0)
    return l1


def shoot(pole: Array, edge: Array, c10: float, c20: float, mu: float) -> tuple[Array, ...]:
    """Return r, depth, force and N1 at the rim for stretches at the pole and undeformed radii of the contact edge."""

    def slope(R: Array, state: Array, on: bool) -> tuple[Array, Array]:
        psi, pull, r = state[0], state[1] / R, state[2]
        l2 = r / R
        l1 = stretch_for(pull, l2, last[0], c10, c20)
        last[0] = l1
        n2 = pulls(l1, l2, c10, c20)[1]
        turn = l1 / SPHERE if on else -n2 * np.sin(psi) / (pull * R)
        rub = mu * (pull * R * turn + n2 * np.sin(psi)) if on else 0.0
        return np.stack([turn, n2 * np.cos(psi) + rub, l1 * np.cos(psi), l1 * np.sin(psi)]), l1

    start = 1e-3 * edge
    first = pulls(pole, pole, c10, c20)[0]
    state = np.stack([pole * start / SPHERE, start * first, pole * start, 0.0 * edge])
    last = [pole]
    for on, begin, end, count in ((True, start, edge, 30), (False, edge, np.full_like(edge, RADIUS), 45)):
        # Steps that grow from the pole outward.
        share = np.linspace(0.0, 1.0, count + 1)
        places = begin * (end / begin) ** share[:, None] if on else begin + (end - begin) * share[:, None]
        for here, there in pairwise(places):
            h = there - here
            k1, _ = slope(here, state, on)
            k2, _ = slope(here + 0.5 * h, state + 0.5 * h * k1, on)
            k3, _ = slope(here + 0.5 * h, state + 0.5 * h * k2, on)
            k4, _ = slope(there, state + h * k3, on)
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    psi, pull, r, depth = state
    return r, depth, 2.0 * np.pi * pull * np.sin(psi), pull / RADIUS


def curve(c10: float, c20: float, mu: float, stretch: float, slip: float) -> tuple[Array, Array]:
    """Return depths and forces of the disc."""
    edge = np.concatenate([np.geomspace(0.6, 10.0, 14), np.linspace(12.0, 46.0, 30)])
    low, high = np.full_like(edge, 1.0 + 1e-7), np.full_like(edge, 2.2)
    with np.errstate(all="ignore"):
        for _ in range(34):
            middle = 0.5 * (low + high)
            r, _, _, pull = shoot(middle, edge, c10, c20, mu)
            over = ~(r - stretch * RADIUS + slip * pull < 0.0)
            high, low = np.where(over, middle, high), np.where(over, low, middle)
        r, depth, force, pull = shoot(0.5 * (low + high), edge, c10, c20, mu)
    good = np.isfinite(depth) & (np.abs(r - stretch * RADIUS + slip * pull) < 1e-3)
    # The flattest shots are lost in rounding, the deepest may end on another branch.
    good &= (depth > 0.5) & (depth < 0.78 * RADIUS)
    good &= (force > 0.0) & (pull > 0.0)
    deeper = np.maximum.accumulate(np.where(good, depth, -np.inf))
    good &= depth >= deeper
    return depth[good], force[good]


@cache
def _curve(c10: float, c20: float, mu: float, stretch: float, slip: float) -> tuple[Array, Array]:
    return curve(c10, c20, mu, stretch, slip)


def measure(truth: Truth, random: Generator, noise: float, protocol: str) -> list[tuple[Array, Array, Array]]:
    """Return files of depth, force, temperature: ``rich`` at three temperatures, ``poor`` one at room temperature,
    ``warm`` at two in turn, ``often`` five times as many readings, ``begin`` the first fifth read ten times finer,
    ``oiled`` where nothing rubs; ``share`` as rich, each reading off by 1 % of it.

    ``noise`` is in 0.2 % of the largest force.
    """
    size = truth.size
    found = []
    slips = 60.0 * size.get("rim-slip", 0.0)
    hot = {"rich": (0.0, 30.0, 60.0), "share": (0.0, 30.0, 60.0), "warm": (0.0, 40.0)}.get(protocol, (0.0,))
    for warmer in hot:
        # Linear, with a little of the square: no exponential.
        rise = size.get("thermal-softening", 0.0) * warmer / 60.0
        weak = 1.0 - 0.30 * rise + 0.05 * rise**2
        made = weak if slips else 1.0
        coefficient = 0.0 if protocol == "oiled" else min(0.45 * size.get("friction", 0.0), 0.7)
        depth, force = _curve(
            C10 * truth.soft[0] * made, C20 * truth.soft[1] * made, coefficient,
            1.0 + min(0.03 * size.get("pretension", 0.0), 0.08), slips,
        )  # fmt: skip
        # Without a clamp that gives, the force goes with the modulus.
        force = force * weak / made
        # The machine reads what it yields by as depth too.
        depth = depth + 0.4 * size.get("frame-compliance", 0.0) * force
        deepest = min(60.0, float(depth[-1]))
        at = np.linspace(max(3.0, float(depth[0])), deepest, 300 if protocol == "often" else 60)
        if protocol == "begin":
            at = np.linspace(max(0.6, float(depth[0])), 0.2 * deepest, 40)
        forces = _smooth(depth, force)(at)
        sd: float | Array = 0.002 * noise * float(force[depth <= 60.0].max())
        if "ripple" in size:
            forces = forces * (1.0 + 0.02 * size["ripple"] * np.sin(at * 2.0 * np.pi / 7.0))
        if "torn-seam" in size:
            forces = np.where(at > 0.6 * deepest, forces * (1.0 - 0.08 * size["torn-seam"]), forces)
        if "saturated-cell" in size:
            most = (1.0 - 0.25 * size["saturated-cell"]) * float(forces.max())
            forces = np.minimum(forces, most + 0.15 * (forces - most))
        sd *= 0.1 if protocol == "begin" else 1.0
        if protocol == "share":
            sd = 0.01 * noise * forces
        found.append((at, forces + sd * random.standard_normal(len(at)), np.full(len(at), ROOM + warmer)))
    return found


def _smooth(depth: Array, force: Array):  # type: ignore[no-untyped-def]
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(depth, force / depth)
    return lambda at: at * spline(at)
