"""Quantities as people write them, in the units the program computes in.

Every factor is an exact fraction and every conversion is rounded once, so that ``1 inch`` is 25.4 mm to the last bit.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from hyperfab.errors import HyperfabError, InputError, UsageError
from hyperfab.io.unit_table import DIMENSIONLESS, Dimension, Unit, UnitError, parse_unit


class Toleranced(float):
    """A number known to one standard deviation ``sd``, in its own unit; in every computation it is the number alone.

    >>> Toleranced(200.0, 5.0) + 1.0, tolerance(Toleranced(200.0, 5.0)), tolerance(200.0)
    (201.0, 5.0, 0.0)
    """

    sd: float

    def __new__(cls, value: float, sd: float) -> Toleranced:
        """Return the number with its standard deviation."""
        found = super().__new__(cls, value)
        found.sd = sd
        return found

    def __getnewargs__(self) -> tuple[float, float]:  # type: ignore[override]
        """Return what a copy is made of."""
        return float(self), self.sd


def tolerance(value: object) -> float:
    """Return the standard deviation that a value states, 0 where it states none."""
    return value.sd if isinstance(value, Toleranced) else 0.0


def toleranced(value: float, sd: float) -> float:
    """Return a number with its standard deviation; the number alone where that is 0."""
    return Toleranced(value, sd) if sd else float(value)


@dataclass(frozen=True)
class Kind:
    """A kind of quantity: the unit it is computed in, and how one is written.

    ``offset`` kinds are points on a scale (a temperature); all others are amounts.
    """

    name: str
    unit: str
    example: str
    offset: bool = False


_ALL = (
    Kind("length", "mm", "60mm"),
    Kind("area", "mm^2", "400 mm^2"),
    Kind("volume", "mm^3", "1 cm^3"),
    Kind("stress", "MPa", "0.35 MPa"),
    Kind("force", "N", "500N"),
    Kind("temperature", "degC", "25 degC", offset=True),
    Kind("temperature-difference", "K", "2 K"),
    Kind("time", "s", "3600 s"),
    Kind("rate", "1/s", "0.01 1/s"),
    Kind("velocity", "mm/s", "5 mm/min"),
    Kind("mass", "kg", "1.2 kg"),
    Kind("energy", "J", "9 MJ"),
    Kind("power", "W", "3000 W"),
    Kind("heat-flux", "W/m^2", "2 W/cm^2"),
    Kind("film-coefficient", "W/m^2/K", "12 W/m^2/K"),
    Kind("density", "kg/m^3", "2702 kg/m^3"),
    Kind("conductivity", "W/m/K", "237 W/m/K"),
    Kind("specific-heat", "J/kg/K", "903 J/kg/K"),
    Kind("membrane-stress", "N/mm", "0.5 N/mm"),
    Kind("stiffness", "N/mm", "50 N/mm"),
    Kind("foundation-stiffness", "MPa/mm", "0.02 MPa/mm"),
    Kind("compliance", "mm^2/N", "0.5 mm^2/N"),
    Kind("thermal-expansion", "1/K", "23e-6 1/K"),
    Kind("mass-per-area", "g/m^2", "180 g/m^2"),
    Kind("angle", "deg", "30 deg"),
    Kind("dimensionless", "1", "0.3"),
)
KINDS: dict[str, Kind] = {kind.name: kind for kind in _ALL}

_NUMBER = r"[+-]?(?:\d{1,40}(?:\.\d{0,40})?|\.\d{1,40})(?:[eE][+-]?\d{1,3})?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.ASCII | re.DOTALL)
#: What may be a product as well as two sizes, 200x200 mm; powers of ten are neither.
_TIMES = re.compile(r"[x*×·⋅]\s*(?!10\s*[\^⁻⁺⁰¹²³⁴-⁹])\d")
#: Between a quantity and its standard deviation.
_MARK = re.compile(r"\+/-|\+-|±")
#: Kinds that scales show as weights; standard gravity [m/s^2].
_WEIGHED = ("force", "stress", "membrane-stress")
_GRAVITY = Fraction("9.80665")
_ABSOLUTE_ZERO_C = Fraction("-273.15")


def quantity(text: object, kind: str, *, option: str | None = None) -> float:
    """Return the quantity ``text`` in the unit its ``kind`` is computed in (see KINDS: mm, MPa, N, degC, s, J, ...).

    Any unit of the right kind is understood, products and prefixes included; a number alone is taken only where the
    kind has no dimension, and there ``%`` is understood too. One standard deviation may follow, ``3000 W +- 60 W`` or
    ``3000 W ± 2 %``: the quantity is then a ``Toleranced`` number.

    Raises UsageError naming the ``option``, or else InputError, with the right form.

    >>> quantity("60mm", "length"), quantity("2 W/cm^2", "heat-flux"), quantity("77 degF", "temperature")
    (60.0, 20000.0, 25.0)
    >>> tolerance(quantity("77 degF +- 9 K", "temperature")), tolerance(quantity("3 kW ± 2 %", "power"))
    (9.0, 60.0)
    >>> quantity("60", "length", option="--depth")
    Traceback (most recent call last):
    hyperfab.errors.UsageError: --depth 60: a length needs its unit; write 60mm
    """
    wanted = KINDS[kind]
    try:
        return _convert(text, wanted)
    except UnitError as error:
        raise _refusal(str(error), text, option) from None


def quantity_of(text: object, kinds: Sequence[str], *, option: str) -> tuple[str, float]:
    """Return which of ``kinds`` a quantity is of, and its number as ``quantity`` has it; of none it is refused as the
    first.

    >>> quantity_of("2 N/mm", ("stress", "membrane-stress"), option="--noise")
    ('membrane-stress', 2.0)
    """
    failure = None
    for kind in kinds:
        try:
            return kind, quantity(text, kind, option=option)
        except UsageError as error:
            failure = failure or error
    assert failure is not None
    raise failure


def column_factor(unit: str, kind: str) -> tuple[Fraction, Fraction]:
    """Return exact (a, b) so that a value in ``unit`` is ``a * value + b`` in the unit of ``kind``.

    A force that a scale shows as a weight, in g, kg or lb, is that weight's force, in kg/cm^2 too.

    Raises UnitError where ``unit`` is none of the kind.

    >>> column_factor("kPa", "stress"), column_factor("K", "temperature")
    ((Fraction(1, 1000), Fraction(0, 1)), (Fraction(1, 1), Fraction(-5463, 20)))
    """
    found, wanted = parse_unit(unit), KINDS[kind]
    if kind in _WEIGHED and found.dimension == _over_gravity(parse_unit(wanted.unit).dimension):
        return found.factor * _GRAVITY / parse_unit(wanted.unit).factor, Fraction(0)
    return _linear(found, wanted, unit)


def _over_gravity(dimension: Dimension) -> Dimension:
    """Return the dimension of a mass where ``dimension`` is that of its weight."""
    length, mass, time, temperature, angle = dimension
    return length - 1, mass, time + 2, temperature, angle


def is_unit(text: str) -> bool:
    """Whether ``text`` can be read as a unit."""
    try:
        parse_unit(text)
    except UnitError:
        return False
    return True


def worded(value: float, unit: str) -> str:
    """Return a quantity as ``quantity`` reads it, its tolerance too.

    >>> worded(25.0, "degC"), worded(Toleranced(25.0, 2.0), "degC"), worded(Toleranced(0.3, 0.05), "1")
    ('25.0 degC', '25.0 degC +- 2.0 K', '0.3 +- 0.05')
    """
    shown = "" if unit in ("", "1") else f" {unit}"
    sd, difference = tolerance(value), " K" if unit == "degC" else shown
    return f"{float(value)!r}{shown}" + (f" +- {sd!r}{difference}" if sd else "")


def _convert(value: object, kind: Kind) -> float:
    if isinstance(value, str) and (mark := _MARK.search(value)) is not None:
        stated = value[: mark.start()]
        return toleranced(_exact(stated, kind), _deviation(value[mark.end() :], stated, kind))
    return _exact(value, kind)


def _deviation(text: str, stated: str, kind: Kind) -> float:
    """Return the standard deviation ``text`` of the quantity ``stated``: in a unit of its kind, or a share of it."""
    example = f"{stated.strip()} +- 2 K" if kind.offset else f"{kind.example} +- 2 %"
    match = _QUANTITY.fullmatch(text) if len(text) <= 120 else None
    if match is None:
        raise UnitError(f"{text.strip() or 'nothing'} is no tolerance; write {example}")
    number, unit = Fraction(match[1]), match[2]
    if number < 0:
        raise UnitError(f"a standard deviation is not below 0; write {example}")
    if unit == "%":
        if kind.offset:
            raise UnitError(f"a share of a temperature means nothing; write {example}")
        if stated.rstrip().endswith("%"):
            raise UnitError("a tolerance in % of a number in % can be read two ways; write 0.05 +- 0.01")
        return float(abs(Fraction(_exact(stated, kind))) * number / 100)
    if not unit and kind.unit != "1":
        raise UnitError(f"a tolerance needs its unit, or %; write {example}")
    return float(number * _linear(parse_unit(unit) if unit else DIMENSIONLESS, kind, unit)[0])


def _exact(value: object, kind: Kind) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if kind.unit == "1":
            if abs(value) < 1e300:
                return float(value)
            raise UnitError(f"is no finite number; write it like {kind.example}")
        raise UnitError(f'{_article(kind)} needs its unit; write "{_form(repr(value), kind)}"')
    if not isinstance(value, str):
        raise UnitError(f"{_article(kind)} is written {kind.example}")
    return _of_text(value, kind)


@lru_cache(4096)
def _of_text(value: str, kind: Kind) -> float:
    match = _QUANTITY.fullmatch(value) if len(value) <= 120 else None
    if match is None or match[2].startswith(","):
        comma = ", with a decimal point" if "," in value else ""
        raise UnitError(f"is no {_noun(kind)}; write a number and its unit{comma}, as in {kind.example}")
    number, unit = match.groups()
    if not unit and kind.unit != "1":
        raise UnitError(f"{_article(kind)} needs its unit; write {_form(number, kind)}")
    if _TIMES.match(unit):
        raise UnitError(f"may be a product or two sizes; write one number, as in {kind.example}")
    factor, offset = _linear(parse_unit(unit) if unit else DIMENSIONLESS, kind, unit)
    exact = Fraction(number) * factor + offset
    if kind.offset and exact < _ABSOLUTE_ZERO_C:
        raise UnitError("is below absolute zero")
    try:
        result = float(exact)
    except OverflowError:
        raise UnitError("is larger than any number the program can hold") from None
    return result


def _linear(unit: Unit, kind: Kind, text: str) -> tuple[Fraction, Fraction]:
    """Return the exact (factor, offset) from ``unit`` to the unit of ``kind``."""
    base = parse_unit(kind.unit) if kind.unit != "1" else DIMENSIONLESS
    if unit.dimension != base.dimension:
        unit = _engineers_reading(text, unit)
    if unit.dimension != base.dimension:
        raise UnitError(f"{text or 'a number alone'} is no unit of {_noun(kind)}; write it like {kind.example}")
    factor = unit.factor / base.factor
    if not kind.offset:
        return factor, Fraction(0)
    return factor, (unit.zero - base.zero) / base.factor


def _engineers_reading(text: str, otherwise: Unit) -> Unit:
    """Read ``J/kg K`` as J/(kg K), as tables print it: tried only where the strict reading is of another kind."""
    head, slash, rest = text.partition("/")
    if not slash or "/" in rest or "(" in rest:
        return otherwise
    return parse_unit(f"{head}/({rest})")


def _refusal(message: str, text: object, option: str | None) -> HyperfabError:
    shown = text if isinstance(text, str) else repr(text)
    shown = shown if len(shown) <= 60 else shown[:57] + "..."
    if option is not None:
        return UsageError(f"{option} {shown}: {message}")
    head, _, remedy = message.rpartition("; ")
    return InputError(f"{shown}: {head or remedy}", remedy=remedy if head else None)


def _noun(kind: Kind) -> str:
    return "dimensionless number" if kind.unit == "1" else kind.name.replace("-", " ")


def _article(kind: Kind) -> str:
    noun = _noun(kind)
    return f"an {noun}" if noun[0] in "aeiou" else f"a {noun}"


def _form(number: str, kind: Kind) -> str:
    space = "" if re.search(r"\d[a-zA-Z]+$", kind.example) else " "
    unit = kind.example.split(" ", 1)[1] if space else kind.unit
    return f"{number}{space}{unit}"
