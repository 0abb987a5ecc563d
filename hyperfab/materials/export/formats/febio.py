"""FEBio: materials of the ``<Material>`` section.

Conventions: Ogden's energy is ``sum c/m^2 (...)``, so c = our mu alpha; Yeoh's constants are c1 to c6; Gent's limit is
Jm. The Arruda-Boyce series is written as the Yeoh polynomial it is: FEBio's own law takes the series' coefficients
times their order, and would be too stiff. The bulk modulus is always needed: a thousand shear moduli where none is
known.

A foam is unconstrained, all else uncoupled. Ogden's unconstrained energy ``sum c/m^2 (sum l^m - 3 - m ln J) +
cp/2 (J - 1)^2`` is a hyperfoam where nu is 0, with c = 2 mu and cp = 0.

An orthotropic sheet is an uncoupled mixture of Yeoh's law and of threads ``fiber-exp-pow-uncoupled``, whose energy
``ksi/(alpha beta) (exp(alpha (I - 1)^beta) - 1)`` is ours with ksi = k1, alpha = k2, beta = 2, in tension alone;
theta is their angle from the first material axis, the warp. Versions differ in whether the mixture's bulk modulus is
its own or that of its parts: it stands at both.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.sax.saxutils import escape, quoteattr

from hyperfab.materials.export.card import (
    Format,
    NoCard,
    Settings,
    families,
    ground,
    number,
    pairs,
    series_as_powers,
    shear_modulus,
)
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.material import Material
from hyperfab.materials.orthotropic import Orthotropic

_STIFF = 1000.0


def _material(kind: str, values: Sequence[tuple[str, float]], material: Material, settings: Settings) -> list[str]:
    bulk = settings.bulk_modulus
    if bulk is None:
        bulk = _STIFF * shear_modulus(material)
    rows = [("density", settings.density), *values, ("k", bulk)]
    return _element(kind, rows, settings)


def _element(kind: str, rows: Sequence[tuple[str, float]], settings: Settings) -> list[str]:
    return [
        f'<material id="{settings.number}" name={quoteattr(settings.name)} type={quoteattr(kind)}>',
        *(f"  <{tag}>{number(value)}</{tag}>" for tag, value in rows),
        "</material>",
    ]


def _foam(law: Hyperfoam, settings: Settings) -> list[str]:
    if any(law.nu):
        raise NoCard(
            "febio has no law of a foam that contracts: its Ogden unconstrained is a hyperfoam where nu is 0, not "
            + ", ".join(f"{nu:.4g}" for nu in law.nu)
        )
    terms = [
        pair
        for k, (mu, alpha) in enumerate(zip(law.mu, law.alpha, strict=True), 1)
        for pair in ((f"c{k}", 2.0 * mu), (f"m{k}", alpha))
    ]
    return _element("Ogden unconstrained", [("density", settings.density), *terms, ("cp", 0.0)], settings)


def _sheet(law: Orthotropic, settings: Settings) -> list[str]:
    base = ground(law)
    bulk = settings.bulk_modulus
    if bulk is None:
        bulk = _STIFF * (shear_modulus(base) + sum(one.k1 for one in families(law)))
    rows = [
        f'<material id="{settings.number}" name={quoteattr(settings.name)} type="uncoupled solid mixture">',
        f"  <density>{number(settings.density)}</density>",
        f"  <k>{number(bulk)}</k>",
        '  <solid type="Yeoh">',
        f"    <density>{number(settings.density)}</density>",
        *(f"    <c{k}>{number(c)}</c{k}>" for k, c in enumerate(base.c, 1)),
        f"    <k>{number(bulk)}</k>",
        "  </solid>",
    ]
    for one in families(law):
        rows += [
            '  <solid type="fiber-exp-pow-uncoupled">',
            f"    <ksi>{number(one.k1)}</ksi>",
            f"    <alpha>{number(one.k2)}</alpha>",
            "    <beta>2</beta>",
            '    <mat_axis type="angles">',
            f"      <theta>{number(one.angle_deg)}</theta>",
            "      <phi>90</phi>",
            "    </mat_axis>",
            "  </solid>",
        ]
    return [*rows, "</material>"]


def _mooney(material: Material, settings: Settings) -> list[str]:
    c = [*material.c, 0.0]
    return _material("Mooney-Rivlin", [("c1", c[0]), ("c2", c[1])], material, settings)


def _yeoh(material: Material, settings: Settings) -> list[str]:
    return _material("Yeoh", [(f"c{k}", c) for k, c in enumerate(material.c, 1)], material, settings)


def _series(material: Material, settings: Settings) -> list[str]:
    powers = series_as_powers(material.c[0], material.theta[0])
    return _material("Yeoh", [(f"c{k}", c) for k, c in enumerate(powers, 1)], material, settings)


def _ogden(material: Material, settings: Settings) -> list[str]:
    values = [
        pair for k, (mu, alpha) in enumerate(pairs(material), 1) for pair in ((f"c{k}", mu * alpha), (f"m{k}", alpha))
    ]
    return _material("Ogden", values, material, settings)


def _gent(material: Material, settings: Settings) -> list[str]:
    return _material("Gent", [("G", material.c[0]), ("Jm", material.theta[0])], material, settings)


FORMAT = Format(
    name="febio",
    suffix=".feb",
    foam=_foam,
    sheet=_sheet,
    comment=lambda line: f"<!-- {re.sub('-(?=-)', '- ', escape(line))} -->",
    writers={
        **dict.fromkeys(("neo-hookean", "yeoh-1", "mooney-rivlin-2"), _mooney),
        **dict.fromkeys(("yeoh-2", "yeoh-3"), _yeoh),
        **dict.fromkeys(("ogden-1", "ogden-2", "ogden-3"), _ogden),
        "arruda-boyce": _series,
        "gent": _gent,
    },
)
