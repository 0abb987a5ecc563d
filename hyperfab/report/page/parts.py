"""What a section of the page is made of, before it is HTML."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from PIL import Image, UnidentifiedImageError

from hyperfab.errors import HyperfabError, InputError
from hyperfab.report.bands import warmup
from hyperfab.report.labels import parted

#: Significant digits of a number shown to a person; the full value is a hover away.
DIGITS = 4

#: Kinds of document that have a section, and what it is called, along the line from material to press; then what was
#: learnt from measurement, and studies.
KINDS = {
    "material": "Fabric",
    "contact": "Sheet under the sphere",
    "drape": "Drape",
    "heat": "Mold heat",
    "press": "Press",
    "loop": "Model against measurement",
    "sweep": "Study",
}

Plain = Mapping[str, Any]


@dataclass(frozen=True)
class Source:
    """A document to report on: the name it was given by, its contents, and how to read what lies beside it."""

    name: str
    kind: str
    sha256: str
    data: Plain
    read_beside: Callable[[str], bytes]

    def sibling(self, ending: str, but: str = "") -> bytes | None:
        """Return the file of ``files`` with this ending; None where there is none, or it is gone.

        Of several it is the one that bears the document's own name: the shortest, but that it gave way to an input.
        """
        found = [name for name in self.data.get("files", []) if name.endswith(ending)]
        found = [name for name in found if not (but and name.endswith(but))]
        own = [name for name in found if name.endswith(f".out{ending}")] or found
        try:
            return self.read_beside(min(own, key=len)) if own else None
        except HyperfabError:
            return None


@dataclass(frozen=True)
class Cell:
    """One cell of a table: rounded for people, and the full value where rounding took something."""

    text: str
    full: str = ""
    number: bool = False


@dataclass(frozen=True)
class Table:
    """A table with its caption; the first column names the rows."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    #: Shown only when asked for: how a figure was computed, not what it is.
    folded: bool = False


@dataclass(frozen=True)
class Chart:
    """A chart for the browser: traces and layout of plotly, told in words for who cannot see it."""

    caption: str
    alt: str
    data: list[dict[str, Any]]
    layout: dict[str, Any]


@dataclass(frozen=True)
class Scene:
    """A turnable surface with one or more fields on it to switch among."""

    caption: str
    alt: str
    mesh: dict[str, Any]
    fields: list[dict[str, Any]]
    #: Where the eye stands at first, and whether lines that are parallel stay so.
    eye: tuple[float, float, float] = (1.62, -1.95, 1.4)


@dataclass(frozen=True)
class Picture:
    """A picture that a command drew, PNG."""

    caption: str
    alt: str
    data: bytes
    only_print: bool = False


@dataclass(frozen=True)
class Figure:
    """A figure for the first screen: a number with its unit, and what it is."""

    text: str
    label: str


@dataclass(frozen=True)
class Cases:
    """The table of a study, to be filtered in the page."""

    caption: str
    columns: list[str]
    rows: list[list[Any]]
    axes: list[str]
    figures: list[str]
    front: list[str]


Part = Table | Chart | Scene | Picture | Cases


@dataclass
class Section:
    """One section: what it says first, and what it shows for it. ``passed`` None: nothing to pass.

    ``claim`` is the section in one clause and ``figures`` are its own in the order of weight, for the first screen.
    """

    title: str
    passed: bool | None
    verdict: str
    parts: list[Part] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    claim: str = ""
    figures: list[Figure] = field(default_factory=list)


def warmup_cell(data: Mapping[str, Any]) -> Cell:
    """Return the time to warm-up of a heat document, rounded as everywhere; KeyError where there is none."""
    return replace(number(data["warmup_time_s"] / 60.0, "min"), text=warmup(data))


def number(value: float | int | bool | None, unit: str = "", digits: int = DIGITS) -> Cell:
    """Return a number rounded for people.

    >>> number(36.9300759586932, "N")
    Cell(text='36.93 N', full='36.9300759586932 N', number=True)
    >>> number(None).text
    'not computed'
    """
    if value is None:
        return Cell("not computed")
    if isinstance(value, bool):
        return Cell("yes" if value else "no")
    shown = rounded(value, digits)
    exact = float(shown.replace(" ", "")) == value
    return Cell(f"{shown} {unit}".strip(), "" if exact else f"{value!r} {unit}".strip(), number=True)


def rounded(value: float | int, digits: int = DIGITS) -> str:
    """Return a number with so many significant digits, without an exponent where people would write none.

    >>> rounded(3535010.372), rounded(0.00001234567), rounded(200.0), rounded(12)
    ('3 535 010', '1.235e-05', '200', '12')
    """
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    if not math.isfinite(value):
        return str(value)
    size = abs(value)
    if size >= 1000:
        return f"{value:,.0f}".replace(",", " ") if size < 1e9 else f"{value:.{digits - 1}e}"
    return f"{value:.{digits}g}"


def known(data: Plain, key: str, unit: str = "", scale: float = 1.0) -> Cell | None:
    """Return a figure of a document as ``number`` does; None where it has none."""
    return None if data.get(key) is None else number(data[key] * scale, unit)


def percent(share: float | None, digits: int = 3) -> Cell:
    """Return a share of one as per cent.

    >>> percent(0.16184).text, percent(1.0).text, percent(None).text
    ('16.2 %', '100 %', 'not computed')
    """
    return number(None if share is None else 100.0 * share, "%", digits)


def coordinates(places: Sequence[float] | None, digits: int = 1) -> str:
    """Return a place in mm: what is less than a tenth of one is nothing.

    >>> coordinates([3.0525, 2.77e-14, -0.01])
    '3.1, 0.0, 0.0'
    """
    return ", ".join(f"{round(place, digits) + 0.0:.{digits}f}" for place in places or ())


def word(text: object) -> Cell:
    """Return text as a cell."""
    return Cell(str(text))


def facts(caption: str, rows: Sequence[tuple[str, Cell | None]], folded: bool = False) -> Table:
    """Return a table of two columns; rows without a cell are left out."""
    return Table(caption, ["", ""], [[word(name), cell] for name, cell in rows if cell is not None], folded)


def asked(data: Plain) -> list[Table]:
    """Return what was asked for, folded: the document's ``setup``, each figure with its unit, if it has one."""
    rows: list[tuple[str, Cell | None]] = []

    def tell(given: Plain, before: str) -> None:
        for key, value in given.items():
            name, unit = parted(key)
            name = f"{before} {name}".strip()
            if isinstance(value, Mapping):
                tell(value, name)
            elif isinstance(value, (int, float)) or value is None:
                rows.append((name, None if value is None else number(value, unit)))
            elif isinstance(value, (list, tuple)):
                texts = [number(v).text if isinstance(v, (int, float)) else str(v) for v in value]
                rows.append((name, word(f"{', '.join(texts)} {unit}".strip()) if texts else None))
            else:
                rows.append((name, word(value) if value != "" else None))

    tell(data.get("setup") or {}, "")
    return [facts("What was asked for", rows, folded=True)] if rows else []


def computed(*rows: tuple[str, Cell]) -> Table:
    """Return how the figures were computed, folded."""
    return facts("How it was computed", rows, folded=True)


def columns(data: bytes | None, name: str) -> dict[str, list[str]]:
    """Return the columns of a CSV that hf wrote beside a document; nothing where it is not there."""
    if data is None:
        return {}
    rows = list(csv.reader(io.StringIO(data.decode("utf-8", "replace"))))
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise InputError("is no table as hf writes it", file=name)
    return {head: [row[index] for row in rows[1:]] for index, head in enumerate(rows[0])}


def floats(cells: Sequence[str]) -> list[float | None]:
    """Return cells as numbers; None for what is none."""
    found: list[float | None] = []
    for cell in cells:
        try:
            value = float(cell)
        except ValueError:
            found.append(None)
            continue
        found.append(value if math.isfinite(value) else None)
    return found


def minutes(cells: Sequence[str]) -> list[float | None]:
    """Return cells of seconds as minutes."""
    return [None if value is None else value / 60 for value in floats(cells)]


def parents(source: Source, sources: Sequence[Source]) -> list[Source]:
    """Return the documents among ``sources`` that ``source`` was made from."""
    provenance = source.data.get("provenance") or {}
    read = {item.get("sha256") for item in provenance.get("inputs", []) if isinstance(item, dict)}
    return [other for other in sources if other.sha256 in read and other is not source]


def in_order(sources: Sequence[Source]) -> list[Source]:
    """Return the documents as the line runs; within a kind, as they were given."""
    return sorted(sources, key=lambda source: list(KINDS).index(source.kind))


#: Pictures larger than this are stored with a palette: a third of the bytes, and nobody sees it.
LARGE = 60_000
#: Pixels of a picture from somewhere else that are still opened.
MAX_PIXELS = 40_000_000


def light(data: bytes) -> bytes | None:
    """Return a PNG with at most 256 colours where it was large; None where it is no picture.

    >>> light(b"no picture") is None
    True
    """
    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                return None
            if len(data) <= LARGE:
                picture.verify()
                return data
            small = picture.convert("RGB").quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return None
    buffer = io.BytesIO()
    small.save(buffer, "PNG", optimize=True)
    return min(buffer.getvalue(), data, key=len)
