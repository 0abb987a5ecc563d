"""Quantities inside documents that people write: text with a unit in, a number in the canonical unit kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema

from hyperfab.documents.base import Section
from hyperfab.errors import InputError
from hyperfab.io.units import KINDS, quantity, tolerance, worded


def parsed(
    kind: str, least: float | None = None, open_end: bool = False, most: float | None = None
) -> Callable[[object], float]:
    """Return a validator that reads a quantity of ``kind`` and refuses values below ``least`` (or at it) and above
    ``most``."""

    def read(value: object) -> float:
        try:
            found = quantity(value, kind)
        except InputError as error:
            raise ValueError(f"{error.message}" + (f"; {error.remedy}" if error.remedy else "")) from None
        if least is not None and (found < least or (open_end and found == least)):
            bound = "must be greater than" if open_end else "must not be less than"
            raise ValueError(f"{value}: {bound} {_shown(least, kind)}")
        if most is not None and found > most:
            raise ValueError(f"{value}: must not be more than {_shown(most, kind)}")
        return found

    return read


def _shown(bound: float, kind: str) -> str:
    return f"{bound:g} {KINDS[kind].unit}".removesuffix(" 1")


def _text(kind: str) -> Callable[[float], Any]:
    """Return what writes a number back: text in the canonical unit, a number where there is none."""
    unit = KINDS[kind].unit
    return lambda value: worded(value, unit) if unit != "1" or tolerance(value) else value


def written(kind: str) -> PlainSerializer:
    """Return the serializer that writes the number back as text in the canonical unit."""
    return PlainSerializer(_text(kind), return_type=Any)


def _schema(kind: str, least: float | None, open_end: bool, most: float | None, example: str | None) -> dict[str, Any]:
    if kind != "dimensionless":
        return {"type": "string", "examples": [example or KINDS[kind].example]}
    bounds = {"exclusiveMinimum" if open_end else "minimum": least, "maximum": most}
    known = {name: bound for name, bound in bounds.items() if bound is not None}
    return {"type": ["number", "string"], **known, "examples": [0.3, "0.3 +- 0.05"]}


def _field(
    kind: str,
    least: float | None = None,
    open_end: bool = False,
    *,
    most: float | None = None,
    example: str | None = None,
) -> Any:
    article = "an" if kind[0] in "aeiou" else "a"
    said = f"{article} {kind.replace('-', ' ')} with its unit" if kind != "dimensionless" else "a number, or text"
    shown = {"description": said, **_schema(kind, least, open_end, most, example)}
    return Annotated[float, PlainValidator(parsed(kind, least, open_end, most)), written(kind), WithJsonSchema(shown)]


class TableFile(Section):
    """A table in a CSV file beside the document."""

    table: str


#: What the schema says of it.
TABLE_FILE = {"type": "object", "properties": {"table": {"type": "string"}}, "required": ["table"]}


def _value_or_table(
    kind: str,
    least: float | None = None,
    open_end: bool = False,
    *,
    most: float | None = None,
    said: str | None = None,
    example: str | None = None,
) -> Any:
    read, text = parsed(kind, least, open_end, most), _text(kind)

    def validate(value: object) -> float | TableFile:
        if isinstance(value, TableFile):
            return value
        if isinstance(value, dict):
            if set(value) != {"table"} or not isinstance(value["table"], str):
                raise ValueError('a table is written { table = "file.csv" }')
            return TableFile(table=value["table"])
        return read(value)

    def write(value: float | TableFile) -> Any:
        return {"table": value.table} if isinstance(value, TableFile) else text(value)

    shown = {
        "description": said or f"a {kind.replace('-', ' ')} with its unit, or a table",
        "anyOf": [_schema(kind, least, open_end, most, example), TABLE_FILE],
    }
    return Annotated[
        float | TableFile,
        PlainValidator(validate),
        PlainSerializer(write, return_type=Any),
        WithJsonSchema(shown),
    ]


Length = _field("length")
PositiveLength = _field("length", 0.0, open_end=True)
Temperature = _field("temperature")
TemperatureDifference = _field("temperature-difference", 0.0, open_end=True)
Time = _field("time", 0.0, open_end=True)
Duration = _field("time", 0.0)
Power = _field("power", 0.0)
HeatFlux = _field("heat-flux", 0.0)
FilmCoefficient = _field("film-coefficient", 0.0)
Density = _field("density", 0.0, open_end=True)
Angle = _field("angle", example="0.05 deg")
Shift = _field("length", example="0.2 mm")
Rate = _field("rate", 0.0, open_end=True)
Stress = _field("stress", 0.0, open_end=True)
Stiffness = _field("stiffness", 0.0, open_end=True, example="50 kN/mm")

#: Numbers without a unit, as 0.8, or as text, which may state a standard deviation: "0.8 +- 0.05".
Share = _field("dimensionless", 0.0, most=1.0)
FoamRatio = _field("dimensionless", -1.0, True, most=0.5)
MoldRatio = _field("dimensionless", 0.0, most=0.49)

ConstantConductivity = _field("conductivity", 0.0, open_end=True)
ConstantSpecificHeat = _field("specific-heat", 0.0, open_end=True)

Conductivity = _value_or_table("conductivity", 0.0, True)
SpecificHeat = _value_or_table("specific-heat", 0.0, True)
Film = _value_or_table("film-coefficient", 0.0)
HeldTemperature = _value_or_table("temperature")
ContactConductance = _value_or_table(
    "film-coefficient",
    0.0,
    True,
    said="between mold and sandwich, or a table: pressure [MPa], conductance [W/m^2/K]",
    example="500 W/m^2/K",
)
Expansion = _value_or_table(
    "thermal-expansion",
    0.0,
    said="mean coefficient from the reference temperature on, or a table of it against temperature",
)
Shrunk = _value_or_table(
    "dimensionless",
    0.0,
    most=0.9,
    said="share of the thickness, or a table: temperature [degC], shrinkage [-]",
)
