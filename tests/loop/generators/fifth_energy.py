"""What the fifth set's cloths answer at rest: plain laws, yarns in two ways, and how their volume changes.

Everything is said in Kirchhoff stresses of principal stretches. No plain law is a polynomial in invariants:

- ``crimp``: logarithmic, soft until the crimp is straight and stiff from there (two moduli, a rounded corner);
- ``recruitment``: wavy fibres in all directions, taut from a stretch of their own on, which is log-normal, in a
  logarithmic ground (fibre recruitment as Hurschler et al. 1997 and later microsphere models have it);
- ``tube``: the non-affine tube of Davidson & Goulbourne, J. Mech. Phys. Solids 61 (2013) 1784;
- ``worm``: eight chains whose force is that of a worm (Marko & Siggia, Macromolecules 28 (1995) 8759).

Units: MPa.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from loop.generators.balance import Array, Table, balanced, bisected

LAWS = ("crimp", "recruitment", "tube", "worm")
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_AXIAL, _TURNS = 0.5 * (1.0 + _NODES), (np.arange(8) + 0.5) * math.pi / 16.0


def _octant() -> tuple[Array, Array]:
    """Return unit vectors (64, 3) over an octant, alike about the first axis, and their weights, which sum to one."""
    z, turn = (one.ravel() for one in np.meshgrid(_AXIAL, _TURNS, indexing="ij"))
    flat = np.sqrt(1.0 - z**2)
    return np.stack([z, flat * np.cos(turn), flat * np.sin(turn)], axis=1), np.repeat(_WEIGHTS / 16.0, 8)


SPHERE, SHARES = _octant()


class Cloth(NamedTuple):
    """A law at rest: its name, three numbers from 0 to 1, how sharply it stiffens, yarns and pores if it has them."""

    law: str
    numbers: tuple[float, float, float]
    sharp: bool = False
    yarns: Mapping[str, float] | None = None
    pores: Mapping[str, float] | None = None


def modulus(cloth: Cloth) -> float:
    """Return about the shear modulus at rest [MPa]."""
    return 0.12 + 0.2 * cloth.numbers[0]


def _crimp(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    ratio = 4.0 + 4.0 * u if cloth.sharp else 1.4 + 1.2 * u
    corner, round_ = 0.14 + 0.1 * v, 0.03 + 0.04 * u
    h = np.log(stretches)
    stiff = round_ * (np.logaddexp(0.0, (h - corner) / round_) - np.logaddexp(0.0, -corner / round_))
    taus: Array = 2.0 * modulus(cloth) * (h + (ratio - 1.0) * stiff)
    return taus


@lru_cache
def _recruited(u: float, v: float) -> tuple[Array, Array]:
    """Return stretches of a bundle and its force for a stiffness of one."""
    ranks = (np.arange(60) + 0.5) / 60.0
    taut = 1.0 + (0.15 + 0.15 * v) * np.exp((0.4 + 0.3 * u) * np.array([NormalDist().inv_cdf(q) for q in ranks]))
    grid = np.linspace(0.3, 3.0, 1500)
    return grid, np.mean(np.maximum(grid[:, None] / taut - 1.0, 0.0), axis=1)


def _recruitment(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    stiff = (30.0 + 30.0 * u if cloth.sharp else 3.0 + 5.0 * u) * modulus(cloth)
    along = np.sqrt(SPHERE**2 @ stretches**2)
    parts = stiff * (SHARES[:, None] * np.interp(along, *_recruited(u, v)) / along).T @ SPHERE**2
    taus: Array = 2.0 * modulus(cloth) * np.log(stretches) + stretches**2 * parts.T
    return taus


def _tube(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    share = 0.85 if cloth.sharp else 0.35 + 0.4 * u
    longest = 2.05 + 0.25 * v if cloth.sharp else 3.3 + 2.0 * v
    links, tubes = share * modulus(cloth), (1.0 - share) * modulus(cloth)
    room = np.maximum(3.0 * longest - np.sum(stretches**2, axis=0), 0.05)
    taus: Array = links * stretches**2 * (1.0 / 3.0 + 2.0 * longest / room) + tubes * (stretches - 1.0 / stretches)
    return taus


def _worm(cloth: Cloth, stretches: Array) -> Array:
    rest = (0.58 + 0.08 * cloth.numbers[1]) if cloth.sharp else 0.25 + 0.2 * cloth.numbers[1]

    def pull(chain: Array | float) -> Array:
        r = np.minimum(rest * np.asarray(chain), 0.97)
        per: Array = (0.25 / (1.0 - r) ** 2 - 0.25 + r) / r
        return per

    taus: Array = modulus(cloth) * stretches**2 * pull(np.sqrt(np.mean(stretches**2, axis=0))) / pull(1.0)
    return taus


_OF: Mapping[str, Callable[[Cloth, Array], Array]] = {
    "crimp": _crimp, "recruitment": _recruitment, "tube": _tube, "worm": _worm,
}  # fmt: skip


def _dispersed(d: Mapping[str, float], first: Array, second: Array, angle: float) -> tuple[Array, Array]:
    """Fibres about the warp, their angles after von Mises, pulled in proportion to their logarithmic strain."""
    theta = (np.arange(36) + 0.5) * math.pi / 36.0
    density = np.exp((1.0 + 2.5 * d["u"]) * np.cos(2.0 * theta))
    density /= np.sum(density)
    c2 = np.cos(theta - math.radians(angle))[:, None] ** 2
    square = first**2 * c2 + second**2 * (1.0 - c2)
    pull = density[:, None] * np.maximum(0.5 * np.log(square), 0.0) / square
    return np.sum(pull * c2, axis=0) * first**2, np.sum(pull * (1.0 - c2), axis=0) * second**2


def _interlaced(d: Mapping[str, float], first: Array, second: Array, angle: float) -> tuple[Array, Array]:
    """A woven unit cell as a saw-tooth: the crimp that one yarn gives up the other takes; the warp has less of it."""
    c2 = math.cos(math.radians(angle)) ** 2
    warp, weft = np.sqrt(first**2 * c2 + second**2 * (1.0 - c2)), np.sqrt(first**2 * (1.0 - c2) + second**2 * c2)
    one, two = 0.1 + 0.1 * d["u"], 0.5 + 0.2 * d["u"]
    long1, long2 = math.hypot(1.0, one), math.hypot(1.0, two)

    def strains(high: Array) -> tuple[Array, Array, Array, Array]:
        now1, now2 = np.hypot(warp, high), np.hypot(weft, one + two - high)
        return np.maximum(now1 / long1 - 1.0, 0.0), np.maximum(now2 / long2 - 1.0, 0.0), now1 * long1, now2 * long2

    low, top = np.zeros_like(warp), np.full_like(warp, one + two)
    for _ in range(32):
        high = 0.5 * (low + top)
        e1, e2, l1, l2 = strains(high)
        over = e1 * high / l1 - e2 * (one + two - high) / l2 + 0.05 * (high - one) > 0.0
        low, top = np.where(over, low, high), np.where(over, high, top)
    e1, e2, l1, l2 = strains(0.5 * (low + top))
    return (e1 * c2 / l1 + e2 * (1.0 - c2) / l2) * first**2, (e1 * (1.0 - c2) / l1 + e2 * c2 / l2) * second**2


def _taus(cloth: Cloth, first: Array, second: Array, third: Array, angle: float) -> Array:
    """Return the Kirchhoff stresses (3, n) [MPa], none at rest, before any pressure."""
    law = _OF[cloth.law]
    taus = law(cloth, np.stack([first, second, third])) - law(cloth, np.ones((3, 1)))
    if d := cloth.yarns:
        along, across = (_dispersed, _interlaced)[int(d["kind"])](d, first, second, angle)
        strength = 20.0 * d["amount"] * modulus(cloth)
        taus[0] += strength * along
        taus[1] += strength * across
    return taus


def _thickness(cloth: Cloth, first: Array, second: Array, angle: float) -> Array:
    """Return the stretch of the thickness; the volume stays unless there are pores.

    Kind 0: Poisson's ratio of logarithmic strains, which goes from one value to another as the cloth grows in area.
    Kind 1: pores against which a pressure K sinh(m ln J) / m works, which grows as they open.
    """
    area = np.log(first * second)
    d = cloth.pores
    if d is None:
        return np.exp(-area)
    if d["kind"] < 1:
        start, end = (1.0, 0.3) if d["u"] < 0.5 else (0.3, 1.0)
        nu = 0.5 - d["amount"] * (end + (start - end) * np.exp(-np.maximum(area, 0.0) / 0.15))
        return np.exp(-area * nu / (1.0 - nu))
    bulk, grows = 1.5 * modulus(cloth) * (1.0 / max(d["amount"], 1e-3) - 1.0), 2.0 + 4.0 * d["u"]

    def lateral(h: Array) -> Array:
        swelling = np.clip(grows * (area + h), -50.0, 50.0)
        return _taus(cloth, first, second, np.exp(h), angle)[2] + bulk * np.sinh(swelling) / grows

    return np.exp(bisected(lateral, -area - 0.05, 0.0 * area + 0.05))


def table(cloth: Cloth, mode: str, angle: float, furthest: float) -> Table:
    """Return what a cloth answers in uniaxial tension, planar tension or equal biaxial tension.

    Raises ValueError for another mode.
    """
    first = np.linspace(1.0, furthest, 160)
    return balanced(
        first,
        mode,
        lambda second: _thickness(cloth, first, second, angle),
        lambda second, third: _taus(cloth, first, second, third, angle),
    )
