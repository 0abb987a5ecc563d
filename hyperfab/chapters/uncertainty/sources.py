"""What the inputs of a command say of how sure they are, and how to run the command with something else there."""

from __future__ import annotations

import copy
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from pydantic import BaseModel

from hyperfab.arrays import Array
from hyperfab.cases.case import Case, tolerances
from hyperfab.cases.place import get, put
from hyperfab.chapters.fabric import ORTHOTROPIC
from hyperfab.chapters.uncertainty.changed import CaseT, Changed, Kept, Place, inside, there
from hyperfab.documents.base import Document, parse_document
from hyperfab.documents.certainty import FitUncertainty
from hyperfab.documents.material import AtTemperature, Direction, MaterialDocument
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.inputs import Inputs
from hyperfab.io.units import Toleranced, tolerance
from hyperfab.materials.law import scaled
from hyperfab.materials.orthotropic.energy import WALLS
from hyperfab.numerics.propagation import Source
from hyperfab.thermal.tables import Table

#: Quantities of one document that are one thing where they are stated alike: the room's temperature.
_SHARED = ("ambient", "start")


class Number(Protocol):
    """One uncertain number of an input."""

    @property
    def name(self) -> str:
        """How it is called."""

    @property
    def file(self) -> str | None:
        """The file it stands in; None for one of the case."""

    def move(self, inputs: Changed[Any], change: float) -> None:
        """Change it."""


@dataclass(frozen=True)
class Setting:
    """A quantity of an option: its ``name`` is its place in ``setup``."""

    name: str
    file: str | None = None

    def move(self, inputs: Changed[Any], change: float) -> None:
        inputs.case = put(inputs.case, self.name, get(inputs.case, self.name) + change)


@dataclass(frozen=True)
class Entry:
    """A number of a document, with its ``unit`` where it is text; it has a meaning between its ``walls`` alone."""

    file: str
    place: Place
    value: float
    unit: str | None = None
    walls: tuple[float, float] = (-math.inf, math.inf)

    @property
    def name(self) -> str:
        """The file, and the key in it."""
        return f"{os.path.basename(self.file)}: {'.'.join(map(str, self.place))}"

    def move(self, inputs: Changed[Any], change: float) -> None:
        at = inside(inputs.document(self.file), self.place[:-1])
        if self.unit is None:
            at[self.place[-1]] = min(max(float(at[self.place[-1]]) + change, self.walls[0]), self.walls[1])
        else:
            at[self.place[-1]] = f"{self.value + change!r} {self.unit}".strip()


@dataclass(frozen=True)
class Stiffness:
    """A factor, less one, on the stress of a law at every stretch."""

    file: str
    places: tuple[Place, ...]
    way: str

    @property
    def name(self) -> str:
        """The file, and what is stiffer."""
        return f"{os.path.basename(self.file)}: stiffness{self.way}"

    def move(self, inputs: Changed[Any], change: float) -> None:
        """Change the constants that are stresses."""
        for place in self.places:
            constants = inside(inputs.document(self.file), place)
            constants.update(scaled(constants, 1.0 + change))


@dataclass(frozen=True)
class Along:
    """Numbers of a document at ``places`` that change together by ``column``, one standard deviation on."""

    file: str
    index: int
    places: tuple[Place, ...]
    column: tuple[float, ...]

    @property
    def name(self) -> str:
        """The file, and which of the independent directions of its constants."""
        return f"{os.path.basename(self.file)}: constants and effects, direction {self.index}"

    def move(self, inputs: Changed[Any], change: float) -> None:
        for place, by in zip(self.places, self.column, strict=True):
            at = inside(inputs.document(self.file), place[:-1])
            at[place[-1]] = float(at[place[-1]]) + change * by


@dataclass(frozen=True)
class Film:
    """By how many of its standard deviations a table of film coefficients is off, all rows together."""

    file: str
    table: Table

    @property
    def name(self) -> str:
        """The file, and its column."""
        return f"{os.path.basename(self.file)}: h"

    def move(self, inputs: Changed[Any], change: float) -> None:
        """Change all rows."""
        moved = self.table.off(change)
        # A film takes no heat from what is warmer.
        rows = zip(moved.x, np.maximum(moved.y, 0.0), strict=True)
        inputs.written[self.file] = csv_bytes(("temperature [degC]", "h [W/m^2/K]"), list(rows))


@dataclass(frozen=True)
class Origin:
    """A source of uncertainty, and the numbers it moves."""

    source: Source
    numbers: tuple[Number, ...]
    ids: tuple[str, ...] = ()


@dataclass
class Origins:
    """All that inputs say of how sure they are; ``left_out`` of it is not carried."""

    found: list[Origin] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    _kept: Kept = field(default_factory=Kept, repr=False)

    @property
    def sources(self) -> list[Source]:
        """The sources alone."""
        return [one.source for one in self.found]

    @property
    def numbers(self) -> list[Number]:
        """All numbers, source by source."""
        return [number for one in self.found for number in one.numbers]

    def amounts(self, changes: Mapping[int, Sequence[float] | Array]) -> Array:
        """Return by how much each number changes (k,), source by source."""
        each = [np.asarray(changes.get(k, np.zeros(len(one.numbers)))) for k, one in enumerate(self.found)]
        return np.concatenate(each)

    @property
    def settings(self) -> set[str]:
        """The places in the case at which options are unsure."""
        return {number.name for number in self.numbers if isinstance(number, Setting)}

    def each(self) -> Iterator[tuple[float, int, Array]]:
        """Yield, of each number, its standard deviation, the number of its source, and the unit of it alone there."""
        for index, one in enumerate(self.found):
            for sd, unit in zip(np.sqrt(np.diag(one.source.covariance)), np.eye(len(one.numbers)), strict=True):
                yield float(sd), index, unit

    def changed(self, case: CaseT, inputs: Inputs, changes: Mapping[int, Sequence[float] | Array]) -> Changed[CaseT]:
        """Return the inputs with the numbers of some sources changed: ``changes`` by the source's number."""
        moved = Changed(case, inputs, self._kept)
        for index, values in changes.items():
            for number, change in zip(self.found[index].numbers, values, strict=True):
                number.move(moved, float(change))
        return moved


def of_case(case: Case) -> Iterator[Origin]:
    """Yield what the options state; both sides of a size that are stated alike are one number."""
    for one in case.settings().values():
        stated = tolerances(getattr(case, one.name), one.key)
        alike: dict[tuple[float, float], list[str]] = {}
        for path, sd in stated.items():
            alike.setdefault((get(case, path), sd), []).append(path)
        for (_, sd), paths in alike.items():
            name = paths[0] if len(paths) == 1 else one.key
            yield together([Setting(path) for path in paths], sd, name)


def of_document(document: Document, plain: Any, file: str) -> Iterator[Origin]:
    """Yield the tolerances that a document states; rooms of one temperature are one room."""
    written = document.model_dump(mode="json", by_alias=True)
    alike: dict[Any, tuple[float, list[Entry]]] = {}
    for place, value in _stated(document):
        unit = re.split(r" \+- ", str(inside(written, place)))[0].partition(" ")[2]
        if there(plain, place[:-1]) and isinstance(inside(plain, place[:-1]), str):  # the short form of a section
            place = place[:-1]
        if not there(plain, place):
            continue
        entry = Entry(file, place, float(value), unit)
        key = (float(value), value.sd) if place[-1] in _SHARED else place
        alike.setdefault(key, (tolerance(value), []))[1].append(entry)
    for sd, entries in alike.values():
        yield together(entries, sd)


def of_material(document: MaterialDocument, file: str, asked: float | None, origins: Origins) -> None:
    """Add how sure the constants of a material document are at a temperature ``asked`` for, and the choice of law."""
    base = os.path.basename(file)
    # A law of the whole sheet is one, whatever ways its tests were cut along.
    two = document.model != ORTHOTROPIC and {"warp", "weft"} <= set(document.directions or {})
    ways = ("warp", "weft") if two else (None,)
    laws: list[tuple[float, Stiffness]] = []
    known, unknown = [], []
    for way in ways:
        part: MaterialDocument | Direction = (document.directions or {})[way] if way else document
        start: Place = ("directions", way) if way else ()
        of, told = f" of {way}" if way else "", None
        places = []
        for place, row in _rows(part, asked):
            own = row.fit.uncertainty if row.fit else None
            at = f" at {row.temperature_degC:g} degC" if isinstance(row, AtTemperature) else ""
            places.append((*start, *place, "parameters"))
            told = told or own
            if own is None:
                unknown += [f"{base}: how sure its constants are is not told"] if document.fit is not None else []
                continue
            if own.source != "specimens":
                unknown.append(f"{base}: how specimens{of}{at} scatter is not known from these tests")
            # What a law misses in one specimen's readings is no measure of how sure its constants are.
            alone = own.source == "readings" and own.degrees_of_freedom == 0
            if own.covariance is None or alone:
                continue
            walls = WALLS if document.model == ORTHOTROPIC else {}
            known.append(_constants(own, file, places[-1], f"{base}: constants{of}{at}", walls))
        spread = _law(part) or _law(document)
        if spread:
            laws.append((spread, Stiffness(file, tuple(places), of)))
    if document.joint_uncertainty is not None:
        origins.found.append(_joint(document.joint_uncertainty, file))
        if document.joint_uncertainty.source != "specimens":
            origins.left_out.append(f"{base}: how specimens scatter is not known from these tests")
        return
    origins.left_out += dict.fromkeys(unknown)
    if not known:
        origins.left_out += [f"{base}: choice of the law"] if laws else []
        return
    origins.found += known
    if laws:
        spreads, numbers = zip(*laws, strict=True)
        origins.found.append(together(numbers, np.array(spreads), f"{base}: choice of the law"))
    if document.effects:
        origins.left_out.append(f"{base}: how sure its effects are")


def of_films(tables: Mapping[str, Table]) -> Iterator[Origin]:
    """Yield the film coefficients, by the name of their file, that state how sure they are: one source a table."""
    for name, table in tables.items():
        film = Film(name, table)
        yield Origin(Source(film.name, np.eye(1)), (film,))


def origins(
    inputs: Inputs,
    case: Case,
    materials: Mapping[str, float | None] = {},
    documents: Mapping[str, type[Document]] = {},
) -> Origins:
    """Return what a case says of how sure it is, its ``materials`` at the temperature asked for, and ``documents`` that
    state tolerances; each by the name of its file."""
    found = Origins(list(of_case(case)))
    for name, asked in materials.items():
        document, plain = read_as(inputs, name, MaterialDocument)
        of_material(document, name, asked, found)
        own = [place for number in found.numbers if number.file == name for place in _places(number)]
        for place in (place for place in own if not there(plain, place)):
            key, text = ".".join(map(str, place)), "its uncertainty names this constant, which it does not have"
            raise InputError(text, file=name, key=key, remedy="name its own in order")
    for name, cls in documents.items():
        found.found += of_document(*read_as(inputs, name, cls), name)
    return found


def read_as(inputs: Inputs, name: str, cls: type[Document]) -> tuple[Any, Any]:
    """Return the document of a file, and its plain data."""
    plain = inputs.plain(name)
    return parse_document(copy.deepcopy(plain), name, cls), plain


def _rows(part: Any, asked: float | None) -> list[tuple[Place, Any]]:
    """Return what constants at a temperature are taken from: the part itself, or the rows next to the temperature."""
    table = part.temperatures
    if asked is None or not table:
        return [((), part)]
    order = sorted(range(len(table)), key=lambda k: table[k].temperature_degC)
    degrees = [table[k].temperature_degC for k in order]
    after = int(np.searchsorted(degrees, asked))
    near = {min(max(after - 1, 0), len(order) - 1), min(after, len(order) - 1)}
    if asked <= degrees[0] or asked >= degrees[-1]:
        near = {0 if asked <= degrees[0] else len(order) - 1}
    return [(("temperatures", order[k]), table[order[k]]) for k in sorted(near)]


def _constants(
    own: FitUncertainty, file: str, place: Place, name: str, walls: Mapping[str, tuple[float, float]]
) -> Origin:
    freedom = own.degrees_of_freedom if own.degrees_of_freedom > 0 else math.inf
    shown = f"{name}, {own.specimens} specimens" if own.source == "specimens" else name
    covariance = np.array(own.covariance)
    # A constant that is known, as one at its bound, is no source.
    open_ = np.flatnonzero(np.diag(covariance) > 0.0)
    free = (-math.inf, math.inf)
    numbers = tuple(Entry(file, (*place, own.order[k]), 0.0, walls=walls.get(own.order[k], free)) for k in open_)
    square = np.ix_(open_, open_)
    parts = tuple((np.array(one.covariance)[square], one.degrees_of_freedom) for one in own.parts or ())
    return Origin(Source(shown, covariance[square], freedom, parts), numbers)


def _joint(own: FitUncertainty, file: str) -> Origin:
    """Return the constants of an extended model as one source, a number each independent direction of theirs."""
    root = Source("", np.array(own.covariance)).root
    steps = [name.split(".") for name in own.order]
    places = tuple(tuple(int(step) if step.isdigit() else step for step in one) for one in steps)
    numbers = tuple(Along(file, k, places, tuple(map(float, column))) for k, column in enumerate(root.T, 1))
    freedom = own.degrees_of_freedom if own.degrees_of_freedom > 0 else math.inf
    shown = f", {own.specimens} specimens" if own.source == "specimens" else ""
    name = f"{os.path.basename(file)}: constants and effects{shown}"
    return Origin(Source(name, np.eye(len(numbers)), freedom), numbers)


def _law(part: MaterialDocument | Direction) -> float | None:
    return part.fit.uncertainty.law if part.fit is not None and part.fit.uncertainty is not None else None


def together(numbers: Sequence[Number], sd: Array | float, name: str | None = None) -> Origin:
    """Return numbers that change together by one standard deviation (k,) each, by the first's name if none is given."""
    sizes = np.broadcast_to(np.asarray(sd, dtype=np.float64), len(numbers))
    return Origin(Source(name or numbers[0].name, np.outer(sizes, sizes)), tuple(numbers))


def _stated(value: Any, place: Place = ()) -> Iterator[tuple[Place, Toleranced]]:
    """Yield every quantity below ``value`` that states a tolerance, and its place."""
    if isinstance(value, Toleranced):
        yield place, value
    elif isinstance(value, BaseModel):
        for name, info in type(value).model_fields.items():
            yield from _stated(getattr(value, name), (*place, info.alias or name))
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield from _stated(one, (*place, key))
    elif isinstance(value, (list, tuple)):
        for index, one in enumerate(value):
            yield from _stated(one, (*place, index))


def _places(number: Number) -> tuple[Place, ...]:
    """Return where a number stands in the document of a material."""
    return number.places if isinstance(number, Along) else (number.place,) if isinstance(number, Entry) else ()
