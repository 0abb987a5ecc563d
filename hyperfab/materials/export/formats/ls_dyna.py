"""LS-DYNA: ``*MAT_HYPERELASTIC_RUBBER`` (077_H), ``*MAT_OGDEN_RUBBER`` (077_O), Arruda-Boyce (127), Hill foam (177).

Conventions: Ogden's energy is ``sum mu/alpha (...)`` as here; Arruda-Boyce takes the number of links N = lambda_m^2 and
the modulus G of the series; the change of volume goes by Poisson's ratio (077) or the bulk modulus (127). Hill's foam
is ``sum C/b (sum l^b - 3 + (J^(-n b) - 1)/n)`` with one n = nu/(1 - 2 nu), so C = 2 mu/alpha, b = alpha.
"""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.materials.export.card import (
    Format,
    NoCard,
    Settings,
    as_foam,
    cij,
    field,
    pairs,
    poisson,
    shear_modulus,
)
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.material import Material

#: Poisson's ratio that LS-DYNA's manual takes for rubber that keeps its volume.
_POISSON = 0.4995
#: Long format, which the plus sign after the keyword asks for: fields of 20 columns hold every digit of a constant.
_WIDTH = 20


def _row(*values: float | str) -> str:
    return "".join(field(value, _WIDTH) for value in values)


def _head(*names: str) -> str:
    return "$#" + "".join(name.rjust(_WIDTH) for name in names)[2:]


def _eight(name: str, values: Sequence[float]) -> list[str]:
    return [_head(*(f"{name}{r}" for r in range(1, 9))), _row(*values, *[0.0] * (8 - len(values)))]


def _first(material: Material, settings: Settings) -> list[str]:
    ratio = _POISSON if settings.bulk_modulus is None else poisson(material, settings.bulk_modulus)
    return [
        _head("mid", "ro", "pr", "n", "nv", "g", "sigf", "ref"),
        _row("1", settings.density, ratio, "0", "0", "0", "0", "0"),
    ]


def _rubber(material: Material, settings: Settings) -> list[str]:
    values = cij(material, "10", "01", "11", "20", "02", "30")
    return [
        "*MAT_HYPERELASTIC_RUBBER_TITLE +",
        settings.name,
        *_first(material, settings),
        _head("c10", "c01", "c11", "c20", "c02", "c30"),
        _row(*values),
    ]


def _ogden(material: Material, settings: Settings) -> list[str]:
    mus, alphas = zip(*pairs(material), strict=True)
    return [
        "*MAT_OGDEN_RUBBER_TITLE +",
        settings.name,
        *_first(material, settings),
        *_eight("mu", mus),
        *_eight("alpha", alphas),
    ]


def _arruda_boyce(material: Material, settings: Settings) -> list[str]:
    mu, lambda_m = material.c[0], material.theta[0]
    bulk = settings.bulk_modulus
    if bulk is None:
        bulk = 2.0 * shear_modulus(material) * (1.0 + _POISSON) / (3.0 * (1.0 - 2.0 * _POISSON))
    return [
        "*MAT_ARRUDA_BOYCE_RUBBER_TITLE +",
        settings.name,
        _head("mid", "ro", "k", "g", "n"),
        _row("1", settings.density, bulk, mu, lambda_m**2),
        _head("lcid", "tramp", "nt"),
        _row("0", 0.0, 0.0),
    ]


def _foam(law: Hyperfoam, settings: Settings) -> list[str]:
    if len(set(law.nu)) > 1:
        raise NoCard(
            "the terms of *MAT_HILL_FOAM have one Poisson's ratio, these have "
            + ", ".join(f"{nu:.4g}" for nu in law.nu)
        )
    cs = [2.0 * mu / alpha for mu, alpha in zip(law.mu, law.alpha, strict=True)]
    return [
        "*MAT_HILL_FOAM_TITLE +",
        settings.name,
        _head("mid", "ro", "k", "n", "mu", "lcid", "fittype", "lcsr"),
        _row("1", settings.density, law.bulk_modulus, law.beta[0], 0.1, "0", "0", "0"),
        *_eight("c", cs),
        *_eight("b", law.alpha),
    ]


FORMAT = Format(
    name="ls-dyna",
    comment=lambda line: f"$ {line}",
    foam=_foam,
    writers={
        **dict.fromkeys(("neo-hookean", "yeoh-1", "yeoh-2", "yeoh-3"), _rubber),
        **dict.fromkeys(("mooney-rivlin-2", "mooney-rivlin-3", "mooney-rivlin-5"), _rubber),
        **dict.fromkeys(("ogden-1", "ogden-2", "ogden-3"), _ogden),
        "arruda-boyce": _arruda_boyce,
        **dict.fromkeys(("blatz-ko", "blatz-ko-general"), as_foam(_foam)),
    },
)
