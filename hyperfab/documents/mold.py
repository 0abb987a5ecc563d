"""``mold.toml``: the parts of a heated mold, what they are made of, and what heats and cools them."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, WithJsonSchema, model_validator

from hyperfab.documents.base import HandWritten, MisfitError, OrShort, Section
from hyperfab.documents.mold_shapes import BodySection, BoxSection, PartSection, Point
from hyperfab.documents.quantity import (
    Conductivity,
    Density,
    Duration,
    Film,
    FilmCoefficient,
    HeatFlux,
    HeldTemperature,
    PositiveLength,
    Power,
    Share,
    SpecificHeat,
    Temperature,
    TemperatureDifference,
    Time,
    parsed,
)
from hyperfab.io.units import worded


class MaterialSection(Section):
    """What parts are made of; conductivity and specific heat may be tables against temperature."""

    density: Density
    conductivity: Conductivity
    specific_heat: SpecificHeat


class FacesInBox(Section):
    """The faces of a part that lie inside a box."""

    part: str
    box: BoxSection


Place = str | FacesInBox


def _places(value: object) -> object:
    """Take one place or a list of them; check each by hand, so that a mistake has one message."""
    items = value if isinstance(value, list) else [value]
    found: list[Place] = []
    for item in items:
        if isinstance(item, (str, FacesInBox)):
            found.append(item)
        elif isinstance(item, dict):
            found.append(FacesInBox.model_validate(item))
        else:
            raise ValueError("a place is NAME.WAY, exposed, or { part, box }, or a list of them")
    if not found:
        raise ValueError("names no face")
    return found


Places = Annotated[list[Place], BeforeValidator(_places), OrShort()]


def _schedule(value: object) -> object:
    """Take the name of a file; say how it is written where a table is given as materials and films have theirs."""
    if isinstance(value, str):
        return value
    table = value.get("table") if isinstance(value, dict) else None
    shown = table if isinstance(table, str) else "schedule.csv"
    raise ValueError(f'a schedule is the name of its file: schedule = "{shown}"')


Schedule = Annotated[str, BeforeValidator(_schedule)]


class ControlSection(Section):
    """A thermostat: off at set + band/2, on at set - band/2."""

    probe: str
    set_point: Temperature = Field(alias="set")
    band: TemperatureDifference


class HeaterSection(Section):
    """A heater on faces or in the volume of a part."""

    on: Places | None = None
    volume: str | None = None
    power: Power | None = None
    flux: HeatFlux | None = None
    schedule: Schedule | None = None
    control: ControlSection | None = None

    @model_validator(mode="after")
    def _one_source(self) -> HeaterSection:
        if (self.on is None) == (self.volume is None):
            raise ValueError("a heater is on faces or in a volume: give either on or volume")
        if self.power is not None and self.flux is not None:
            raise ValueError("a heater has either power or flux")
        if self.power is None and self.flux is None and self.schedule is None:
            raise ValueError("a heater needs power, flux or schedule")
        if self.volume is not None and self.flux is not None:
            raise ValueError("a heater in a volume has a power, not a flux")
        if self.flux is not None and self.schedule is not None:
            raise ValueError("a schedule gives the power: leave flux out")
        return self


class ConvectionSection(Section):
    """A film of air or water on faces."""

    on: Places
    h: Film
    ambient: HeldTemperature


class TemperatureSection(Section):
    """Faces held at a temperature."""

    on: Places
    value: HeldTemperature


class RadiationSection(Section):
    """Faces that radiate to large surroundings."""

    on: Places
    emissivity: Share
    ambient: HeldTemperature


class InsulatedSection(Section):
    """Faces that ``exposed`` shall leave out."""

    on: Places


class ContactSection(Section):
    """Thermal contact conductance of two parts that touch; ``schedule`` opens and closes it.

    With ``fresh`` the second part is a new piece, at that temperature, each time the contact closes.
    """

    between: tuple[str, str]
    h: FilmCoefficient
    schedule: Schedule | None = None
    fresh: Temperature | None = None

    @model_validator(mode="after")
    def _fresh_when_it_closes(self) -> ContactSection:
        if self.fresh is not None and self.schedule is None:
            raise ValueError("fresh needs a schedule: the piece is new each time the contact closes")
        return self


class ProbeSection(Section):
    """A thermometer in the mold; ``lag`` is the time constant it follows in, ``second_lag`` that of its sheath."""

    name: Annotated[str, Field(min_length=1)]
    at: Point
    lag: Duration = 0.0
    second_lag: Duration = 0.0

    @property
    def lags(self) -> tuple[float, float]:
        """The time constants [s] in which it follows, one after the other."""
        return self.lag, self.second_lag


class WorkSurfaceSection(Section):
    """The faces that must become hot, and even."""

    on: Places


class LayerSection(Section):
    """A layer of a piece, of a material of constants."""

    material: str
    thickness: PositiveLength


class OtherSideSection(Section):
    """What a piece's other face meets: the other mold, by its temperature and the conductance to it."""

    h: FilmCoefficient
    temperature: Temperature


class ProductionSection(Section):
    """Pieces laid on faces of the hot mold and taken out again, one every ``period``, each lying there for ``in``.

    ``on`` are the work surface's faces where it is left out. Each piece comes at ``temperature``; ``h`` is the
    conductance of its contact with the mold, ``layers`` what it is made of from there outward. The run has ``pieces``
    of them, or as many as it takes until each finds the mold as the one before did.
    """

    on: Places | None = None
    period: Time
    lies: Time = Field(alias="in")
    temperature: Temperature
    h: FilmCoefficient
    layers: Annotated[list[LayerSection], Field(min_length=1)]
    other: OtherSideSection | None = None
    pieces: Annotated[int, Field(ge=1)] | None = None

    @model_validator(mode="after")
    def _fits_its_period(self) -> ProductionSection:
        if self.lies > self.period:
            raise ValueError("a piece lies in the mold no longer than the period to the next")
        if self.h == 0.0:
            raise ValueError("h is the conductance from the mold to the piece: more than zero")
        return self


class EarlierField(Section):
    """The final temperatures of an earlier run."""

    document: str


def _start(value: object) -> object:
    if isinstance(value, dict):
        return EarlierField.model_validate(value)
    return value if isinstance(value, EarlierField) else parsed("temperature")(value)


class RunSection(Section):
    """How long, from where, how fine."""

    start: Annotated[
        float | EarlierField,
        PlainValidator(_start),
        PlainSerializer(
            lambda v: {"document": v.document} if isinstance(v, EarlierField) else worded(v, "degC"),
            return_type=Any,
        ),
        WithJsonSchema(
            {
                "anyOf": [
                    {"type": "string", "examples": ["25 degC"]},
                    {"type": "object", "properties": {"document": {"type": "string"}}},
                ]
            }
        ),
    ] = 25.0
    target: Temperature | None = None
    until: Time | None = None
    mesh_size: PositiveLength
    steady: bool = False
    tolerance: TemperatureDifference = 0.1
    reduced: bool | None = None


class MoldDocument(HandWritten):
    """A heated mold."""

    KIND: ClassVar[str] = "mold"

    material: Annotated[dict[str, MaterialSection], Field(min_length=1)]
    part: Annotated[list[PartSection], Field(min_length=1)]
    cavity: list[BodySection] = Field(default_factory=list)
    heater: list[HeaterSection] = Field(default_factory=list)
    convection: list[ConvectionSection] = Field(default_factory=list)
    temperature: list[TemperatureSection] = Field(default_factory=list)
    radiation: list[RadiationSection] = Field(default_factory=list)
    insulated: list[InsulatedSection] = Field(default_factory=list)
    contact: list[ContactSection] = Field(default_factory=list)
    probe: list[ProbeSection] = Field(default_factory=list)
    work_surface: WorkSurfaceSection | None = None
    production: ProductionSection | None = None
    run: RunSection

    def surfaces(self) -> list[str]:
        """Return the names of the STL files."""
        bodies = [*self.part, *self.cavity]
        return [one.stl for body in bodies for one in (body, *(body.shapes or ())) if one.stl is not None]

    def names(self) -> list[str]:
        """Return the names of all bodies, and of the shapes that have one."""
        bodies: list[BodySection] = [*self.part, *self.cavity]
        return [b.name for b in bodies] + [s.name for b in bodies for s in b.shapes or [] if s.name]

    def places(self) -> list[tuple[str, Place]]:
        """Return every place a section acts on, with the section's key."""
        found: list[tuple[str, Place]] = [
            (f"{kind}.{number}.on", place)
            for kind in ("heater", "convection", "temperature", "radiation", "insulated")
            for number, section in enumerate(getattr(self, kind))
            for place in section.on or []
        ]
        work = self.work_surface.on if self.work_surface is not None else []
        pieces = self.production.on if self.production is not None else None
        found += [("production.on", place) for place in pieces or []]
        return found + [("work_surface.on", place) for place in work]

    @model_validator(mode="after")
    def _names_fit(self) -> MoldDocument:
        for number, part in enumerate(self.part):
            if part.material not in self.material:
                known = ", ".join(self.material)
                raise MisfitError(
                    f"part.{number}.material",
                    f"part {part.name!r} is of {part.material!r}, which is no [material]; there is {known}",
                )
        names = self.names()
        for name in names:
            if names.count(name) > 1:
                raise MisfitError("name", f"the name {name!r} stands for two bodies or shapes; rename one")
        probes = [probe.name for probe in self.probe]
        for name in probes:
            if probes.count(name) > 1:
                raise MisfitError("probe", f"two probes are called {name!r}; rename one")
        for number, heater in enumerate(self.heater):
            if heater.control is not None and heater.control.probe not in probes:
                known = ", ".join(probes) or "none"
                raise MisfitError(
                    f"heater.{number}.control",
                    f"a heater's control asks probe {heater.control.probe!r}; the probes: {known}",
                )
        slow = {probe.name for probe in self.probe if any(probe.lags)}
        if any(heater.control is not None and heater.control.probe in slow for heater in self.heater):
            raise MisfitError("probe", "a thermostat's probe has no lag here: leave its lag out, or widen the band")
        if self.run.target is not None and self.work_surface is None:
            raise MisfitError("run.target", "run.target waits for the mean of [work_surface]; add that table")
        if self.production is not None:
            self._production_fits(self.production)
        elif self.run.until is None and self.run.target is None and not self.run.steady:
            raise MisfitError("run", '[run] has no end: give until = "3600 s", target, or steady = true')
        return self

    def _production_fits(self, production: ProductionSection) -> None:
        if self.run.steady or self.run.until is not None or self.run.target is not None:
            raise MisfitError(
                "run",
                "[production] ends with its pieces and begins hot: take steady, until and target out of [run], "
                'and give start = "200 degC" or start = { document = "heat.json" }, that of the warm-up',
            )
        if production.on is None and self.work_surface is None:
            raise MisfitError(
                "production.on",
                "[production] needs the faces the pieces lie on: give on, or add [work_surface]",
            )
        for number, layer in enumerate(production.layers):
            key = f"production.layers.{number}.material"
            if layer.material not in self.material:
                known = ", ".join(self.material)
                raise MisfitError(key, f"a layer is of {layer.material!r}, which is no [material]; there is {known}")
            stuff = self.material[layer.material]
            if not (isinstance(stuff.conductivity, float) and isinstance(stuff.specific_heat, float)):
                raise MisfitError(key, f"a layer is of {layer.material!r}, which has tables: pieces have constants")
        if production.pieces is None and any(heater.control is not None for heater in self.heater):
            raise MisfitError(
                "production.pieces",
                "a thermostat never brings the mold quite back: say how many, production.pieces = 20",
            )
