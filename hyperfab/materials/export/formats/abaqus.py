"""Abaqus: ``*HYPERELASTIC`` and ``*HYPERFOAM``.

Conventions that differ from ours: Ogden's energy is ``sum 2 mu/alpha^2 (...)``, so mu = our mu alpha/2; D1 = 2/K, and
0 keeps the volume. Hyperfoam is as here: mu and alpha of each term, then nu of all. Laws of I1 that Abaqus lacks go in
as Marlow's law: a uniaxial curve, which is exact for them.

An orthotropic sheet goes in as the law of Holzapfel, Gasser and Ogden without dispersion (kappa 0), whose ground is
neo-Hookean and whose families of threads are all alike; their directions stand in the section's orientation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.materials.export.card import (
    Format,
    NoCard,
    Settings,
    Writer,
    as_foam,
    cij,
    families,
    number,
    pairs,
    poisson,
    refuse,
    volumetric,
)
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.law import Array
from hyperfab.materials.material import Material
from hyperfab.materials.orthotropic import Orthotropic

#: Values a data line takes.
_PER_LINE = 8
#: Characters a name may have.
_LABEL = 80
_MARLOW_POINTS = 60
#: Points in the first five steps of those, ever closer to rest.
_NEAR_REST = 30
#: A curve ends at this part of the way from rest to the stretch at which chains lock.
_TO_LIMIT = 0.98
#: The exponent k2 of threads must be above zero; this one adds a millionth at a squared stretch of 2.
_LEAST = 1e-6


def _lines(values: Sequence[float]) -> list[str]:
    return [
        ", ".join(number(value) for value in values[start : start + _PER_LINE])
        for start in range(0, len(values), _PER_LINE)
    ]


def _card(keyword: str, values: Sequence[float], settings: Settings) -> list[str]:
    return [f"*MATERIAL, NAME={settings.name}", "*DENSITY", number(settings.density), keyword, *_lines(values)]


def _polynomial(form: str, order: int, *names: str) -> Writer:
    def write(material: Material, settings: Settings) -> list[str]:
        return _card(f"*HYPERELASTIC, {form}", [*cij(material, *names), *volumetric(settings, order)], settings)

    return write


def _ogden(material: Material, settings: Settings) -> list[str]:
    order = len(material.c)
    values = [value for mu, alpha in pairs(material) for value in (0.5 * mu * alpha, alpha)]
    return _card(f"*HYPERELASTIC, OGDEN, N={order}", [*values, *volumetric(settings, order)], settings)


def _arruda_boyce(material: Material, settings: Settings) -> list[str]:
    return _card("*HYPERELASTIC, ARRUDA-BOYCE", [material.c[0], material.theta[0], *volumetric(settings, 1)], settings)


def _foam(law: Hyperfoam, settings: Settings) -> list[str]:
    if len(law.mu) == 1:  # CalculiX, which reads these cards, ends without a word where N is 1: two halves
        law = Hyperfoam((0.5 * law.mu[0],) * 2, law.alpha * 2, law.nu * 2)
    pairs = [value for term in zip(law.mu, law.alpha, strict=True) for value in term]
    return _card(f"*HYPERFOAM, N={len(law.mu)}", [*pairs, *law.nu], settings)


def _marlow(material: Material, settings: Settings) -> list[str]:
    stretch = np.union1d(_way(material, 0.5), _way(material, 15.0))
    stress = material.uniaxial(stretch).P
    rows = [f"{number(P)}, {number(lam - 1.0)}" for lam, P in zip(stretch, stress, strict=True)]
    bulk = settings.bulk_modulus
    ratio = "" if bulk is None else f", POISSON={number(poisson(material, bulk))}"
    return [*_card(f"*HYPERELASTIC, MARLOW{ratio}", [], settings), "*UNIAXIAL TEST DATA", *rows]


def _sheet(law: Orthotropic, settings: Settings) -> list[str]:
    why = "the ground of *ANISOTROPIC HYPERELASTIC, HOLZAPFEL is neo-Hookean"
    refuse("abaqus", law, {"C20_MPa": why, "C30_MPa": why})
    threads = families(law)
    if len({(one.k1, one.k2) for one in threads}) > 1:
        raise NoCard(
            "abaqus cannot hold this orthotropic sheet: all threads of *ANISOTROPIC HYPERELASTIC, HOLZAPFEL have one "
            "k1 and k2, and *FABRIC takes the curves of warp, weft and shear each by itself, not one energy"
        )
    angles = np.deg2rad([one.angle_deg for one in threads])
    ways = [f"{number(np.cos(one))}, {number(np.sin(one))}, 0." for one in angles]
    values = [law.parameters["C10_MPa"], *volumetric(settings, 1), threads[0].k1, max(threads[0].k2, _LEAST), 0.0]
    keyword = f"*ANISOTROPIC HYPERELASTIC, HOLZAPFEL, LOCAL DIRECTIONS={len(threads)}"
    axes = f"{settings.name[: _LABEL - 5]}-axes"
    return [
        f"** the section takes ORIENTATION={axes}; its x is the warp, its y the weft",
        f"*ORIENTATION, NAME={axes}, LOCAL DIRECTIONS={len(threads)}",
        "1., 0., 0., 0., 1., 0.",
        "3, 0.",
        *ways,
        *_card(keyword, values, settings),
    ]


def _way(material: Material, end: float) -> Array:
    """Return stretches from rest to ``end``, or most of the way to where the law's chains lock."""
    last, locking = end, np.empty(0)
    if not np.isfinite(material.uniaxial(end).P):
        reached, beyond = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (reached + beyond)
            inside = np.isfinite(material.uniaxial(1.0 + middle * (end - 1.0)).P)
            reached, beyond = (middle, beyond) if inside else (reached, middle)
        way = reached * (end - 1.0)
        last = 1.0 + _TO_LIMIT * way
        # The stress there goes as one over what is left of the way: straight lines between these are within 0.5 %.
        locking = 1.0 + way - (1.0 - _TO_LIMIT) * way * np.geomspace(1.0, 12.0, 24)
    far = np.geomspace(1.0, last, _MARLOW_POINTS)
    # A straight line from rest is less steep than the law by the part of its own length: the first ones are short.
    near = 1.0 + 5.0 * (far[1] - 1.0) * np.geomspace(2e-4, 1.0, _NEAR_REST)
    return np.concatenate([far, near, locking])


FORMAT = Format(
    name="abaqus",
    foam=_foam,
    sheet=_sheet,
    curve=_marlow,
    comment=lambda line: f"** {line}",
    writers={
        **dict.fromkeys(("neo-hookean", "yeoh-1"), _polynomial("NEO HOOKE", 1, "10")),
        "yeoh-2": _polynomial("REDUCED POLYNOMIAL, N=2", 2, "10", "20"),
        "yeoh-3": _polynomial("REDUCED POLYNOMIAL, N=3", 3, "10", "20", "30"),
        "mooney-rivlin-2": _polynomial("POLYNOMIAL, N=1", 1, "10", "01"),
        **dict.fromkeys(
            ("mooney-rivlin-3", "mooney-rivlin-5"), _polynomial("POLYNOMIAL, N=2", 2, "10", "01", "20", "11", "02")
        ),
        "mooney-rivlin-9": _polynomial("POLYNOMIAL, N=3", 3, "10", "01", "20", "11", "02", "30", "21", "12", "03"),
        **dict.fromkeys(("ogden-1", "ogden-2", "ogden-3"), _ogden),
        "arruda-boyce": _arruda_boyce,
        **dict.fromkeys(("blatz-ko", "blatz-ko-general"), as_foam(_foam)),
        **dict.fromkeys(("gent", "arruda-boyce-langevin"), _marlow),
    },
)
