"""``foam.toml``: the fabric-foam-fabric sandwich between the molds, and how much the molds grow."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, WithJsonSchema, model_validator

from hyperfab.documents.base import HandWritten, MisfitError, OrShort, Section, optional
from hyperfab.documents.press_terms import Poisson, PressSection, Relaxation, Variation
from hyperfab.documents.quantity import (
    ConstantConductivity,
    ConstantSpecificHeat,
    ContactConductance,
    Density,
    Expansion,
    PositiveLength,
    Rate,
    Share,
    Shrunk,
    Stress,
    TableFile,
    Temperature,
    Time,
    parsed,
)
from hyperfab.io.units import worded

Terms = Annotated[list[float], Field(min_length=1, max_length=9)]


Stresses = Annotated[list[Stress], Field(min_length=1, max_length=9)]


class Law(Section):
    """A compression law, measured at ``temperature``; its stresses are multiplied by ``factor``."""

    factor: Annotated[float, Field(gt=0.0)] = 1.0
    temperature: Temperature | None = None


class TableLaw(Law, TableFile):
    """Measured compression: strain [-], stress [MPa]."""


class MaterialLaw(Law):
    """A material document of ``hf fit --model hyperfoam-N``, its sides held; at the temperature of the press."""

    material: str


class LinearLaw(Law):
    """Stress proportional to strain."""

    law: Literal["linear"]
    modulus: Stress


class PlateauLaw(Law):
    """Plateau and densification: s (1 - exp(-E e / s)) + B (e / (1 - e))^m."""

    law: Literal["plateau"]
    plateau: Stress
    modulus: Stress
    densification: Stress
    power: Annotated[float, Field(ge=1.0, le=20.0)] = 2.0


class HyperfoamLaw(Law):
    """Ogden-Storakers foam, its sides held: one mu, alpha and nu a term."""

    law: Literal["hyperfoam"]
    mu: Stresses
    alpha: Terms
    nu: Annotated[list[Annotated[float, Field(ge=0.0, lt=0.5)]], Field(min_length=1, max_length=9)]

    @model_validator(mode="after")
    def _terms_fit(self) -> HyperfoamLaw:
        if not len(self.mu) == len(self.alpha) == len(self.nu):
            raise ValueError("mu, alpha and nu need one value a term each")
        if 0.0 in self.alpha:
            raise ValueError("alpha must not be 0")
        return self


LAWS: dict[str, type[Law]] = {"linear": LinearLaw, "plateau": PlateauLaw, "hyperfoam": HyperfoamLaw}


def _compression(value: object) -> object:
    """Choose the kind of law by its key, so that the message speaks of that law alone."""
    if not isinstance(value, dict):
        return value
    if "table" in value:
        return TableLaw.model_validate(value)
    if "material" in value:
        return MaterialLaw.model_validate(value)
    name = value.get("law")
    if name not in LAWS:
        known = ", ".join(f'"{law}"' for law in LAWS)
        raise ValueError(
            f'write {{ table = "foam.csv" }}, {{ material = "foam.json" }} or {{ law = ... }} with one of {known}'
        )
    return LAWS[str(name)].model_validate(value)


Compression = Annotated[
    TableLaw | MaterialLaw | LinearLaw | PlateauLaw | HyperfoamLaw,
    BeforeValidator(_compression),
]


def _compressions(value: object) -> object:
    """Choose the kind of law, of several by temperature the kind of each, coldest first."""
    if not isinstance(value, list):
        return _compression(value)
    laws = [law for law in map(_compression, value) if isinstance(law, Law)]
    known = {law.temperature for law in laws} - {None}
    if not laws or len(known) < len(value):
        raise ValueError('of several laws each has a temperature of its own, as temperature = "180 degC"')
    return sorted(laws, key=lambda law: law.temperature or 0.0)


Compressions = Annotated[Compression | list[Compression], BeforeValidator(_compressions), OrShort("string")]


def _molar(value: object) -> float:
    """Return an energy a mole [J/mol], above 0."""
    words = value.replace(" ", "") if isinstance(value, str) else ""
    if not words.endswith("/mol"):
        raise ValueError(f'{value} is no energy a mole; write "95 kJ/mol"')
    return parsed("energy", 0.0, open_end=True)(words.removesuffix("/mol"))


def _layer(value: object) -> object:
    if isinstance(value, str) and value.endswith(".json"):
        return value
    return parsed("length", 0.0)(value)


Layer = Annotated[
    float | str,
    PlainValidator(_layer),
    PlainSerializer(lambda v: v if isinstance(v, str) else worded(v, "mm"), return_type=Any),
    WithJsonSchema({"type": "string", "description": "a thickness, or a material document (.json)"}),
]


class Fabric(Section):
    """The fabric layers: above the foam (female side) and below it (male side).

    ``compression`` is how both give way across; without it a layer that is a hyperfoam's document does so by its law,
    any other is rigid. What carries and stores heat is the foam's where it is left out.
    """

    above: Layer = 0.0
    below: Layer = 0.0
    compression: Compression | None = None
    conductivity: ConstantConductivity | None = None
    specific_heat: ConstantSpecificHeat | None = None
    density: Density | None = None


class Shrinkage(Section):
    """What heat takes from the foam's thickness, and what it gives back when the press opens.

    The foam shrinks by ``amount`` in the end, by ``amount (1 - exp(-dwell / time))`` where a time is given. Of the
    compression under the mold it springs back by ``recovery``; where that is not given, nothing says what stays.
    """

    amount: Shrunk = 0.0
    time: Time | None = None
    dwell: Time | None = None
    recovery: Share | None = None

    @model_validator(mode="after")
    def _makes_sense(self) -> Shrinkage:
        if (self.time is None) != (self.dwell is None):
            raise ValueError("time and dwell belong together: how fast the foam shrinks, and how long it is pressed")
        return self


class MeasuredSet(Section):
    """Tests of the foam's set: temperature [degC], dwell [s] and set [-], or before, pressed and after [mm]; the two
    constants of an Arrhenius law are identified from them."""

    measured: str


class ArrheniusSet(Section):
    """1 - exp(-integral of rate exp(-activation / R T) dt)."""

    rate: Rate
    activation: Annotated[
        float,
        PlainValidator(_molar),
        PlainSerializer(lambda v: f"{v!r} J/mol", return_type=str),
        WithJsonSchema({"type": "string", "description": "an energy a mole", "examples": ["95 kJ/mol"]}),
    ]


_SETS: dict[str, type[Section]] = {
    "table": TableFile, "measured": MeasuredSet, "rate": ArrheniusSet, "activation": ArrheniusSet
}  # fmt: skip


def _set(value: object) -> object:
    """Choose the kind of set law by its key, so that the message speaks of that law alone."""
    if not isinstance(value, dict):
        return parsed("dimensionless", 0.0, most=1.0)(value) if isinstance(value, int | float | str) else value
    key = next((key for key in _SETS if key in value), None)
    if key is None:
        raise ValueError(
            'write 0.7, { table = "set.csv" }, { measured = "set.csv" } or '
            '{ rate = "3e8 1/s", activation = "95 kJ/mol" }'
        )
    return _SETS[key].model_validate(value)


class ExpansionSection(Section):
    """Linear thermal expansion of the molds; where left out, that of aluminium 6061."""

    male: Expansion | None = None
    female: Expansion | None = None
    reference: Temperature = Field(default=20.0, description="where the STL files hold", examples=["20 degC"])


def in_full(plain: dict[str, Any]) -> dict[str, Any]:
    """Return a document's plain data with short forms written out: a file's name as the foam's law, a share that
    heat takes.

    >>> in_full({"compression": "foam.json", "shrinkage": 0.02})
    {'compression': {'material': 'foam.json'}, 'shrinkage': {'amount': 0.02}}
    """
    law, taken = plain.get("compression"), plain.get("shrinkage")
    found = dict(plain)
    if isinstance(law, str):
        found["compression"] = {"material" if law.endswith(".json") else "table": law}
    if isinstance(taken, int | float | str) and not isinstance(taken, bool):
        found["shrinkage"] = {"amount": taken}
    return found


class FoamDocument(HandWritten):
    """The sandwich that is pressed."""

    KIND: ClassVar[str] = "foam"

    thickness: PositiveLength
    compression: Compressions
    conductivity: ConstantConductivity | None = None
    specific_heat: ConstantSpecificHeat | None = None
    density: Density | None = None
    temperature: Temperature | None = optional("as the sandwich is laid in; left out: expansion.reference")
    contact_conductance: ContactConductance | None = None
    fabric: Fabric = Fabric()
    set: Annotated[
        Share | TableFile | MeasuredSet | ArrheniusSet | None,
        BeforeValidator(_set),
    ] = None
    shrinkage: Annotated[Shrinkage, OrShort("number", "string")] = Shrinkage()
    relaxation: Relaxation = Relaxation()
    variation: Variation = Variation()
    expansion: ExpansionSection = ExpansionSection()
    poisson: Poisson = Poisson()
    press: PressSection = PressSection()

    @property
    def laws(self) -> list[Law]:
        """Compression laws of the foam: one, or one a temperature, rising."""
        return list(self.compression) if isinstance(self.compression, list) else [self.compression]

    @model_validator(mode="before")
    @classmethod
    def _in_full(cls, value: object) -> object:
        return in_full(value) if isinstance(value, dict) else value

    @model_validator(mode="after")
    def _one_thing_stays(self) -> FoamDocument:
        if self.set is not None and self.shrinkage.recovery is not None:
            raise MisfitError(
                "set", "set and shrinkage.recovery both say what stays when the press opens: give one of them"
            )
        return self

    @model_validator(mode="after")
    def _dwell_is_known(self) -> FoamDocument:
        dwell = self.relaxation.dwell or self.shrinkage.dwell
        if any(self.relaxation.share) and dwell is None:
            raise MisfitError(
                "relaxation.dwell", 'relaxation needs a dwell: how long the foam is held, as dwell = "40 s"'
            )
        return self
