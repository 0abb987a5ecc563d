"""What the sixth set's cloths answer at rest: plain laws, yarns in three ways, and pores in two.

Everything is said in Kirchhoff stresses of principal stretches. No plain law is a polynomial in invariants:

- ``slip-link``: chains between links that slide (Edwards & Vilgis, Polymer 27 (1986) 483);
- ``junctions``: a phantom network whose junctions are hindered (Flory & Erman, Macromolecules 15 (1982) 800);
- ``separable``: one function of each principal stretch (Shariff, Rubber Chem. Technol. 73 (2000) 1);
- ``exp-log``: an exponential and a logarithm of the first invariant (Khajehsaeid, Arghavani & Naghdabadi,
  Eur. J. Mech. A 38 (2013) 144).

Units: MPa.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from loop.generators.balance import Array, Table, balanced, bisected

LAWS = ("slip-link", "junctions", "separable", "exp-log")


class Cloth(NamedTuple):
    """A law at rest: its name, three numbers from 0 to 1, how far from a Gaussian network, yarns and pores if any."""

    law: str
    numbers: tuple[float, float, float]
    sharp: bool = False
    yarns: Mapping[str, float] | None = None
    pores: Mapping[str, float] | None = None


def modulus(cloth: Cloth) -> float:
    """Return the shear modulus at rest, without yarns [MPa]."""
    return 0.08 * 6.0 ** cloth.numbers[0]


def _slip_link(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    alpha2 = 0.15 + 0.03 * u if cloth.sharp else 0.04 + 0.07 * u
    slides, squares = 0.2 + 0.4 * v, stretches**2
    room = np.maximum(1.0 - alpha2 * np.sum(squares, axis=0), 0.03)
    loose = 1.0 + slides * squares
    fixed = squares * ((1.0 - alpha2) / room**2 - alpha2 / room)
    shared = np.sum(squares / loose, axis=0) * alpha2 * squares / room**2
    links = (1.0 + slides) * (1.0 - alpha2) * (squares / loose**2 / room + shared)
    links = links + slides * squares / loose - alpha2 * squares / room
    taus: Array = 0.4 * fixed + 0.6 * links
    return taus


def _junctions(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    kappa = 10.0 + 10.0 * u if cloth.sharp else 2.0 + 6.0 * u
    free = 0.12 if cloth.sharp else 0.35 + 0.4 * v
    x = stretches**2
    b = kappa**2 * (x - 1.0) / (x + kappa) ** 2
    grows = kappa**2 * (kappa + 2.0 - x) / (x + kappa) ** 3
    d, rises = x * b / kappa, (b + x * grows) / kappa
    hindered = b * grows / (1.0 + b) + d * rises / (1.0 + d)
    taus: Array = x * (free + 1.6 * (1.0 - free) * hindered)
    return taus


def _separable(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    first, second = (0.2, 1.8 + 0.8 * u) if cloth.sharp else (0.2 + 0.6 * v, 0.2 + 0.8 * u)
    parts = 2.0 / 3.0 * np.log(stretches) + first * (np.exp(1.0 - stretches) + stretches - 2.0)
    parts = parts + second * (np.exp(stretches - 1.0) - stretches) + 0.5 * (stretches - 1.0) ** 3 / stretches**3.6
    return np.asarray(parts)


def _exp_log(cloth: Cloth, stretches: Array) -> Array:
    _, u, v = cloth.numbers
    a, b = (1.1 + 0.5 * u, 0.4 + 0.3 * v) if cloth.sharp else (0.15 + 0.3 * u, 0.1 + 0.35 * v)
    x = np.maximum(np.sum(stretches**2, axis=0) - 3.0, 0.0)
    taus: Array = stretches**2 * (np.exp(a * x) - b * np.log1p(x))
    return taus


_OF: Mapping[str, Callable[[Cloth, Array], Array]] = {
    "slip-link": _slip_link, "junctions": _junctions, "separable": _separable, "exp-log": _exp_log,
}  # fmt: skip


def _pulls(d: Mapping[str, float]) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Return the Kirchhoff stress of the stronger and the weaker family of yarns over their stretch.

    Kind 0: yarns of limited extension (Horgan & Saccomandi, J. Mech. Phys. Solids 53 (2005) 1985).
    Kind 1: powers of the yarn's stretch, which also resist being pushed (after deBotton, Hariton & Socolsky 2006).
    Kind 2: straight pieces that turn on springs at the crossings and stretch as they come into line (Leaf & Kandil,
    J. Text. Inst. 71 (1980) 1), the second family with more crimp.
    """
    if d["kind"] < 1:
        limit, share = 3.6 + 4.0 * d["u"], 0.25 * d["v"]

        def limited(stretch: Array) -> Array:
            longer = np.clip(stretch**2 - 1.0, 0.0, 0.97 * math.sqrt(limit))
            return stretch**2 * longer / (1.0 - longer**2 / limit)

        return limited, lambda stretch: share * limited(stretch)
    if d["kind"] < 2:
        power, share = 1.5 + 3.5 * d["u"], 0.4 * d["v"]

        def powers(stretch: Array) -> Array:
            return (stretch**power - stretch ** (-0.5 * power)) / power

        return powers, lambda stretch: share * powers(stretch)

    def crimped(start: float) -> Callable[[Array], Array]:
        angle = np.linspace(start, 0.01, 400)
        force = (start - angle) / np.sin(angle) / 3.0
        length = (1.0 + 0.15 * force * np.cos(angle)) * np.cos(angle) / math.cos(start)
        return lambda stretch: stretch * np.interp(stretch, length, force)

    start = math.radians(25.0 + 10.0 * d["u"])
    return crimped(start), crimped(start + math.radians(8.0 + 10.0 * d["v"]))


def _taus(cloth: Cloth, first: Array, second: Array, third: Array, angle: float) -> Array:
    """Return the Kirchhoff stresses (3, n) [MPa], none at rest, before any pressure."""
    law = _OF[cloth.law]
    rest, bit = law(cloth, np.ones((3, 1))), law(cloth, np.exp([[0.005], [0.0], [-0.005]]))
    taus = (law(cloth, np.stack([first, second, third])) - rest) * (0.02 * modulus(cloth) / (bit[0] - bit[2]))
    if d := cloth.yarns:
        # The stronger yarns are the warp's in two of three cloths.
        for pull, turn in zip(_pulls(d), (0.0, 90.0) if d["w"] < 0.67 else (90.0, 0.0), strict=True):
            c2 = math.cos(math.radians(angle - turn)) ** 2
            square = first**2 * c2 + second**2 * (1.0 - c2)
            bears = 5.0 * d["amount"] * modulus(cloth) * pull(np.sqrt(square)) / square
            taus[0] += bears * first**2 * c2
            taus[1] += bears * second**2 * (1.0 - c2)
    return taus


def _thickness(cloth: Cloth, first: Array, second: Array, angle: float) -> Array:
    """Return the stretch of the thickness; the volume stays unless there are pores.

    Kind 0: a pressure K (J² - 1) / 2 (Simo & Miehe, Comput. Methods Appl. Mech. Eng. 98 (1992) 41).
    Kind 1: hollow spheres of a Gaussian network, which open (Hou & Abeyaratne, J. Mech. Phys. Solids 40 (1992) 571).
    """
    area = np.log(first * second)
    d = cloth.pores
    if d is None:
        return np.exp(-area)
    stiff = 1.5 * modulus(cloth)
    voids = 0.05 + 0.9 * d["amount"]

    def swells(volume: Array) -> Array:
        if d["kind"] < 1:
            return stiff * (1.0 / max(d["amount"], 1e-3) - 1.0) * 0.5 * (volume**2 - 1.0)
        outer = np.cbrt(volume)
        inner = np.cbrt(np.maximum((volume - 1.0 + voids) / voids, 1e-3))
        return stiff * volume * (2.0 / outer + 0.5 / outer**4 - 2.0 / inner - 0.5 / inner**4)

    def lateral(h: Array) -> Array:
        return _taus(cloth, first, second, np.exp(h), angle)[2] + swells(np.exp(area + h))

    return np.exp(bisected(lateral, -area - 0.05, 0.0 * area + 0.05))


def table(cloth: Cloth, mode: str, angle: float, furthest: float) -> Table:
    """Return what a cloth answers in uniaxial tension, planar tension or equal biaxial tension.

    Raises ValueError for another mode.
    """
    first = np.linspace(1.0, furthest, 140)
    return balanced(
        first,
        mode,
        lambda second: _thickness(cloth, first, second, angle),
        lambda second, third: _taus(cloth, first, second, third, angle),
    )
