"""Quantities inside documents that people write: text with a unit in, a number in the canonical unit kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema

from hyperfab.documents.base import Section
from hyperfab.errors import InputError
from hyperfab.io.units import KINDS, quantity, tolerance, worded


def parsed(kind: str, least: float | None = None, open_end: bool = False) -> Callable[[object], float]:
    """Return a validator that reads a quantity of ``kind`` and refuses values below ``least`` (or at it)."""

    def read(value: object) -> float:
        try:
            found = quantity(value, kind)
        except InputError as error:
            raise ValueError(f"{error.message}" + (f"; {error.remedy}" if error.remedy else "")) from None
        if least is not None and (found < least or (open_end and found == least)):
            bound = "must be greater than" if open_end else "must not be less than"
            raise ValueError(f"{value}: {bound} {least:g} {KINDS[kind].unit}")
        return found

    return read


def written(kind: str) -> PlainSerializer:
    """Return the serializer that writes the number back as text in the canonical unit."""
    unit = KINDS[kind].unit
    return PlainSerializer(
        lambda value: worded(value, unit) if unit != "1" or tolerance(value) else value, return_type=Any
    )


def _field(kind: str, least: float | None = None, open_end: bool = False, *, example: str | None = None) -> Any:
    article = "an" if kind[0] in "aeiou" else "a"
    shown = {
        "type": "string",
        "description": f"{article} {kind.replace('-', ' ')} with its unit",
        "examples": [example or KINDS[kind].example],
    }
    if kind == "dimensionless":
        shown = {"type": ["number", "string"], "description": "a number"}
    return Annotated[float, PlainValidator(parsed(kind, least, open_end)), written(kind), WithJsonSchema(shown)]


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
    said: str | None = None,
    example: str | None = None,
) -> Any:
    read = parsed(kind, least, open_end)
    unit = KINDS[kind].unit

    def validate(value: object) -> float | TableFile:
        if isinstance(value, TableFile):
            return value
        if isinstance(value, dict):
            if set(value) != {"table"} or not isinstance(value["table"], str):
                raise ValueError('a table is written { table = "file.csv" }')
            return TableFile(table=value["table"])
        return read(value)

    def write(value: float | TableFile) -> Any:
        return {"table": value.table} if isinstance(value, TableFile) else worded(value, unit)

    shown = {
        "description": said or f"a {kind.replace('-', ' ')} with its unit, or a table",
        "anyOf": [
            {"type": "string", "examples": [example or KINDS[kind].example]},
            TABLE_FILE,
        ],
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
