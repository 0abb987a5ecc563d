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
from collections.abc import Callable, Iterable, Sequence
from xml.sax.saxutils import escape, quoteattr

from hyperfab.materials.export.card import (
    Format,
    NoCard,
    Settings,
    Writer,
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


def _of(kind: str, values: Callable[[Material], Iterable[tuple[str, float]]]) -> Writer:
    """Return the writer of a law that is uncoupled, by its ``values``."""

    def write(material: Material, settings: Settings) -> list[str]:
        bulk = _bulk(settings, shear_modulus(material))
        return _element(kind, [("density", settings.density), *values(material), ("k", bulk)], settings)

    return write


def _bulk(settings: Settings, stiffness: float) -> float:
    return _STIFF * stiffness if settings.bulk_modulus is None else settings.bulk_modulus


def _counted(values: Iterable[float]) -> list[tuple[str, float]]:
    return [(f"c{k}", value) for k, value in enumerate(values, 1)]


def _terms(pairs: Iterable[tuple[float, float]]) -> list[tuple[str, float]]:
    return [one for k, (c, m) in enumerate(pairs, 1) for one in ((f"c{k}", c), (f"m{k}", m))]


def _element(kind: str, rows: Sequence[tuple[str, float]], settings: Settings) -> list[str]:
    return [
        f'<material id="1" name={quoteattr(settings.name)} type={quoteattr(kind)}>',
        *(f"  <{tag}>{number(value)}</{tag}>" for tag, value in rows),
        "</material>",
    ]


def _foam(law: Hyperfoam, settings: Settings) -> list[str]:
    if any(law.nu):
        raise NoCard(
            "febio has no law of a foam that contracts: its Ogden unconstrained is a hyperfoam where nu is 0, not "
            + ", ".join(f"{nu:.4g}" for nu in law.nu)
        )
    terms = _terms((2.0 * mu, alpha) for mu, alpha in zip(law.mu, law.alpha, strict=True))
    return _element("Ogden unconstrained", [("density", settings.density), *terms, ("cp", 0.0)], settings)


def _sheet(law: Orthotropic, settings: Settings) -> list[str]:
    base = ground(law)
    bulk = _bulk(settings, shear_modulus(base) + sum(one.k1 for one in families(law)))
    rows = [
        f'<material id="1" name={quoteattr(settings.name)} type="uncoupled solid mixture">',
        f"  <density>{number(settings.density)}</density>",
        f"  <k>{number(bulk)}</k>",
        '  <solid type="Yeoh">',
        f"    <density>{number(settings.density)}</density>",
        *(f"    <{tag}>{number(c)}</{tag}>" for tag, c in _counted(base.c)),
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


FORMAT = Format(
    name="febio",
    foam=_foam,
    sheet=_sheet,
    comment=lambda line: f"<!-- {re.sub('-(?=-)', '- ', escape(line))} -->",
    writers={
        **dict.fromkeys(
            ("neo-hookean", "yeoh-1", "mooney-rivlin-2"),
            _of("Mooney-Rivlin", lambda material: _counted([*material.c, 0.0][:2])),
        ),
        **dict.fromkeys(("yeoh-2", "yeoh-3"), _of("Yeoh", lambda material: _counted(material.c))),
        **dict.fromkeys(
            ("ogden-1", "ogden-2", "ogden-3"),
            _of("Ogden", lambda material: _terms((mu * alpha, alpha) for mu, alpha in pairs(material))),
        ),
        "arruda-boyce": _of("Yeoh", lambda material: _counted(series_as_powers(material.c[0], material.theta[0]))),
        "gent": _of("Gent", lambda material: [("G", material.c[0]), ("Jm", material.theta[0])]),
    },
)
