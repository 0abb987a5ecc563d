"""Ansys Mechanical APDL: ``TB,HYPER``.

Conventions: the neo-Hookean constant is the shear modulus, mu = 2 C10; Ogden, Arruda-Boyce and Gent are as here; the
compressibility parameter d is 2/K, and 0 keeps the volume; the five- and nine-constant Mooney-Rivlin tables run C10,
C01, C20, C11, C02, C30, C21, C12, C03, the three-constant one C10, C01, C11.
"""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.materials.export.card import Format, NoCard, Settings, Writer, cij, number, pairs, volumetric
from hyperfab.materials.material import Material

#: Constants a TBDATA command takes.
_PER_COMMAND = 6


def _table(option: str, order: int | None, values: Sequence[float], settings: Settings) -> list[str]:
    count = "" if order is None else str(order)
    lines = [
        f"MP,DENS,{settings.number},{number(settings.density)}",
        f"TB,HYPER,{settings.number},1,{count},{option}",
    ]
    for start in range(0, len(values), _PER_COMMAND):
        row = ",".join(number(value) for value in values[start : start + _PER_COMMAND])
        lines.append(f"TBDATA,{start + 1},{row}")
    return lines


def _neo(material: Material, settings: Settings) -> list[str]:
    return _table("NEO", None, [2.0 * material.c[0], *volumetric(settings)], settings)


def _mooney(order: int, *names: str) -> Writer:
    def write(material: Material, settings: Settings) -> list[str]:
        return _table("MOONEY", order, [*cij(material, *names), *volumetric(settings)], settings)

    return write


def _yeoh(order: int) -> Writer:
    def write(material: Material, settings: Settings) -> list[str]:
        return _table("YEOH", order, [*material.c, *volumetric(settings, order)], settings)

    return write


def _ogden(material: Material, settings: Settings) -> list[str]:
    order = len(material.c)
    values = [value for pair in pairs(material) for value in pair]
    return _table("OGDEN", order, [*values, *volumetric(settings, order)], settings)


def _two(option: str) -> Writer:
    def write(material: Material, settings: Settings) -> list[str]:
        return _table(option, None, [material.c[0], material.theta[0], *volumetric(settings)], settings)

    return write


def _blatz(material: Material, settings: Settings) -> list[str]:
    first, second = material.c
    nu = material.theta[0]
    if first == 0.0 and nu == 0.25:
        return _table("BLATZ", None, [second], settings)
    # Ogden's compressible foam, sum mu/alpha (...): alpha = 2 for the bracket of I1, -2 for that of I2.
    beta = nu / (1.0 - 2.0 * nu)
    terms = [(mu, alpha) for mu, alpha in ((first, 2.0), (-second, -2.0)) if mu != 0.0]
    if not terms:
        raise NoCard("mu is zero")
    values = [value for term in terms for value in term] + [beta] * len(terms)
    return _table("FOAM", len(terms), values, settings)


FORMAT = Format(
    name="ansys",
    suffix=".inp",
    comment=lambda line: f"! {line}",
    writers={
        "neo-hookean": _neo,
        "yeoh-1": _neo,
        "yeoh-2": _yeoh(2),
        "yeoh-3": _yeoh(3),
        "mooney-rivlin-2": _mooney(2, "10", "01"),
        "mooney-rivlin-3": _mooney(3, "10", "01", "11"),
        "mooney-rivlin-5": _mooney(5, "10", "01", "20", "11", "02"),
        "mooney-rivlin-9": _mooney(9, "10", "01", "20", "11", "02", "30", "21", "12", "03"),
        "ogden-1": _ogden,
        "ogden-2": _ogden,
        "ogden-3": _ogden,
        "arruda-boyce": _two("BOYCE"),
        "gent": _two("GENT"),
        "blatz-ko": _blatz,
        "blatz-ko-general": _blatz,
    },
)
