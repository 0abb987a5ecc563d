"""Ansys Mechanical APDL: ``TB,HYPER``.

Conventions: the neo-Hookean constant is the shear modulus, mu = 2 C10; Ogden, Arruda-Boyce and Gent are as here; the
compressibility parameter d is 2/K, and 0 keeps the volume; the five- and nine-constant Mooney-Rivlin tables run C10,
C01, C20, C11, C02, C30, C21, C12, C03, the three-constant one C10, C01, C11. Ogden's foam is
``sum mu/alpha (sum l^alpha - 3 + (J^(-alpha beta) - 1)/beta)`` with beta = nu/(1 - 2 nu), so mu = 2/alpha of ours: mu
and alpha of each term, then beta of all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hyperfab.materials.export.card import Format, Settings, Writer, as_foam, cij, number, pairs, volumetric
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.material import Material

#: Constants a TBDATA command takes.
_PER_COMMAND = 6


def _table(option: str, order: int | None, values: Sequence[float], settings: Settings) -> list[str]:
    count = "" if order is None else str(order)
    lines = [f"MP,DENS,1,{number(settings.density)}", f"TB,HYPER,1,1,{count},{option}"]
    for start in range(0, len(values), _PER_COMMAND):
        row = ",".join(number(value) for value in values[start : start + _PER_COMMAND])
        lines.append(f"TBDATA,{start + 1},{row}")
    return lines


def _of(option: str, order: int | None, values: Callable[[Material], Sequence[float]], terms: int = 1) -> Writer:
    """Return the writer of a law by its ``values``; ``terms`` are those of the change of volume."""
    return lambda material, settings: _table(option, order, [*values(material), *volumetric(settings, terms)], settings)


def _mooney(order: int, *names: str) -> Writer:
    return _of("MOONEY", order, lambda material: cij(material, *names))


def _ogden(order: int) -> Writer:
    return _of("OGDEN", order, lambda material: [value for pair in pairs(material) for value in pair], order)


def _two(option: str) -> Writer:
    return _of(option, None, lambda material: [material.c[0], material.theta[0]])


def _foam(law: Hyperfoam, settings: Settings) -> list[str]:
    if (law.alpha, law.nu) == ((-2.0,), (0.25,)):
        return _table("BLATZ", None, law.mu, settings)
    pairs = [value for mu, alpha in zip(law.mu, law.alpha, strict=True) for value in (2.0 * mu / alpha, alpha)]
    return _table("FOAM", len(law.mu), [*pairs, *map(float, law.beta)], settings)


FORMAT = Format(
    name="ansys",
    comment=lambda line: f"! {line}",
    foam=_foam,
    writers={
        **dict.fromkeys(("neo-hookean", "yeoh-1"), _of("NEO", None, lambda material: [2.0 * material.c[0]])),
        **{f"yeoh-{order}": _of("YEOH", order, lambda material: material.c, order) for order in (2, 3)},
        "mooney-rivlin-2": _mooney(2, "10", "01"),
        "mooney-rivlin-3": _mooney(3, "10", "01", "11"),
        "mooney-rivlin-5": _mooney(5, "10", "01", "20", "11", "02"),
        "mooney-rivlin-9": _mooney(9, "10", "01", "20", "11", "02", "30", "21", "12", "03"),
        **{f"ogden-{order}": _ogden(order) for order in (1, 2, 3)},
        "arruda-boyce": _two("BOYCE"),
        "gent": _two("GENT"),
        **dict.fromkeys(("blatz-ko", "blatz-ko-general"), as_foam(_foam)),
    },
)
