"""What a CSV file is written in: encoding, separator, metadata, header, units row. Numbers come later."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from hyperfab.errors import InputError
from hyperfab.io.units import is_unit

#: Recordings are thinned before they are fitted; these bounds keep any file within a second and 400 MB.
MAX_BYTES = 32 * 2**20
MAX_ROWS = 400_000
MAX_COLUMNS = 256
MAX_LINE = 32_768
MAX_CELLS = 4_000_000

_BOMS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f]")
_BRACKETED = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))", re.DOTALL)
#: Anything that starts like a number: enough to tell a row of data from a row of words.
NUMBER_LIKE = re.compile(r"[+-]?[.,]?\d[\d.,eE+-]*", re.ASCII)
_NAMES = {"\t": "tab", ";": "semicolon", ",": "comma"}


@dataclass(frozen=True)
class Heading:
    """One column's heading: ``title`` as written, its ``label`` without the unit, ``unit`` or None, its place."""

    title: str
    label: str
    unit: str | None
    index: int

    @property
    def name(self) -> str:
        """The label as it is compared."""
        return fold(self.label)


@dataclass(frozen=True)
class Entry:
    """A line of metadata: its value and where it stands."""

    value: str
    line: int


@dataclass(frozen=True)
class Sheet:
    """A CSV file in cells: all rows have the header's number of columns, blank rows are counted and gone.

    ``columns`` holds the cells by column; ``lines`` the source line of each row.
    """

    name: str
    separator: str
    headings: tuple[Heading, ...]
    header_line: int
    columns: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    metadata: dict[str, list[Entry]] = field(default_factory=dict)
    blank_rows: int = 0

    def find(self, *names: str) -> Heading | None:
        """Return the column of one of ``names``, or None; InputError where two columns have it."""
        found = [heading for heading in self.headings if heading.name in names]
        found = found or [heading for heading in map(suffixed, self.headings) if heading.name in names]
        if len(found) > 1:
            raise InputError(
                f"two columns are a {names[0]}: {found[0].title} and {found[1].title}",
                file=self.name,
                line=self.header_line,
                remedy="rename or delete one of them",
            )
        return found[0] if found else None

    def meta(self, *keys: str) -> Entry | None:
        """Return the metadata under one of ``keys``, or None; InputError where the file says two things."""
        entries = [entry for key in keys for entry in self.metadata.get(key, [])]
        if len({entry.value for entry in entries}) > 1:
            raise InputError(
                f"says {entries[0].value} here and {entries[1].value} in line {entries[1].line}",
                file=self.name,
                line=entries[0].line,
                key=keys[0],
                remedy="keep one of them",
            )
        return entries[0] if entries else None


def open_sheet(data: bytes, name: str) -> Sheet:
    """Split a CSV file into header, metadata and cells.

    Comma, semicolon or tab; UTF-8 with or without byte-order mark, UTF-16, Latin-1; any line ends; ``# key: value``
    lines; ``name [unit]`` or ``name (unit)`` headings, or their units in a row of their own.

    Raises InputError naming the line where the rows do not fit the header, the file is no text, or too large.

    >>> sheet = open_sheet(b"# test: shear\\nstretch;stress [MPa]\\n1,1;0,2\\n", "shear.csv")
    >>> sheet.separator, sheet.columns, sheet.meta("test").value, sheet.headings[1].unit
    (';', (('1,1',), ('0,2',)), 'shear', 'MPa')
    """
    lines = _lines(decode(data, name), name)
    metadata, body, separator = _preamble(lines)
    if not body:
        raise InputError(
            "has no header and no rows", file=name, remedy="a table with a header line is expected"
        )
    separator = separator or _separator([text for _, text in body[:21]])
    rows = list(_split(body, separator, name))
    header_line, header = rows[0]
    if len(header) > MAX_COLUMNS:
        raise InputError(
            f"has {len(header)} columns", file=name, line=header_line, remedy="export fewer channels"
        )
    if all(NUMBER_LIKE.fullmatch(cell) for cell in header if cell):
        raise InputError(
            "starts with numbers, there is no header",
            file=name,
            line=header_line,
            remedy='name the columns, as in "stretch,stress [MPa]"',
        )
    headings = tuple(_heading(cell, index) for index, cell in enumerate(header))
    rows, blank = _fitting(rows[1:], header, separator, name)
    if rows and _is_units_row(rows[0][1]):
        headings = _with_units(headings, rows[0], name)
        rows = rows[1:]
    if not rows:
        raise InputError(
            "has a header but no rows", file=name, line=header_line, remedy="export the readings too"
        )
    columns = tuple(zip(*(cells for _, cells in rows), strict=True))
    numbers = tuple(number for number, _ in rows)
    return Sheet(name, separator, headings, header_line, columns, numbers, metadata, blank)


def decode(data: bytes, name: str) -> str:
    """Return the text of a file in UTF-8, UTF-16 (with or without byte-order mark) or Latin-1.

    >>> decode("µ;°".encode("latin-1"), "a.csv"), decode("µ".encode("utf-16"), "a.csv")
    ('µ;°', 'µ')
    """
    if len(data) > MAX_BYTES:
        raise InputError(
            f"is larger than {MAX_BYTES // 2**20} MiB", file=name, remedy="thin the recording out"
        )
    if not data.strip():
        raise InputError("is empty", file=name, remedy="a table with a header line is expected")
    text = _decoded(data, name).removeprefix("\ufeff")
    found = _CONTROL.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise InputError(
            f"is no text (character 0x{ord(found[0]):02X})",
            file=name,
            line=line,
            remedy="export it as CSV text",
        )
    return text


def _decoded(data: bytes, name: str) -> str:
    encoding = next((encoding for bom, encoding in _BOMS if data.startswith(bom)), None)
    if encoding is None and data[1::2].count(0) > 0.4 * (len(data) // 2) and len(data) >= 4:
        encoding = "utf-16-le"
    if encoding is None and data[::2].count(0) > 0.4 * (len(data) // 2) and len(data) >= 4:
        encoding = "utf-16-be"
    try:
        return data.decode(encoding or "utf-8")
    except UnicodeDecodeError as error:
        if encoding in (None, "utf-8-sig"):  # some machines put the mark of UTF-8 in front of Latin-1
            return data.removeprefix(codecs.BOM_UTF8).decode("latin-1")
        raise InputError(
            f"is no {encoding.upper()[:6].rstrip('-')} text though it starts like it (byte {error.start})",
            file=name,
            remedy="export it again, as UTF-8",
        ) from None


def _lines(text: str, name: str) -> list[str]:
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MAX_ROWS + 1000:
        raise InputError(f"has more than {MAX_ROWS} rows", file=name, remedy="thin the recording out")
    lines = text.split("\n")
    long = next((number for number, line in enumerate(lines, 1) if len(line) > MAX_LINE), None)
    if long is not None:
        raise InputError(
            f"is longer than {MAX_LINE} characters",
            file=name,
            line=long,
            remedy="is this a table with line ends?",
        )
    return lines


def _preamble(lines: list[str]) -> tuple[dict[str, list[Entry]], list[tuple[int, str]], str | None]:
    """Take out metadata, comments and empty lines; what is left is header and rows with their line numbers."""
    metadata: dict[str, list[Entry]] = {}
    body: list[tuple[int, str]] = []
    separator = None
    for number, line in enumerate(lines, 1):
        stripped = line.strip()
        if not stripped:
            continue
        if stripped.startswith(("#", '"#')):
            key, colon, value = stripped.strip(";,\t").strip('"').lstrip("#").partition(":")
            if colon and not body:
                name = _heading(key.strip(), 0)  # also "# width [mm]: 25"
                stated = f"{value.strip()} {name.unit}" if name.unit else value.strip()
                metadata.setdefault(name.name, []).append(Entry(stated, number))
        elif not body and re.fullmatch(r'"?sep=[;,\t]"?', stripped or line):
            separator = line.strip(' "\r\n')[4:5]
        else:
            body.append((number, line))
    return metadata, body, separator


def _separator(sample: list[str]) -> str:
    """Choose the separator of the header that also cuts the first rows into as many cells."""
    header = re.sub(r'"[^"]*"|\[[^\]]*\]|\([^)]*\)', "", sample[0])
    candidates = [mark for mark in "\t;," if mark in header]
    for mark in candidates:
        count = _count(sample[0], mark)
        if all(_count(line, mark) == count for line in sample[1:]):
            return mark
    return candidates[0] if candidates else ","


def _count(line: str, mark: str) -> int:
    return re.sub(r'"[^"]*"', "", line).count(mark)


def _split(body: list[tuple[int, str]], separator: str, name: str) -> Iterable[tuple[int, list[str]]]:
    if not any('"' in text for _, text in body):
        for number, text in body:
            yield number, [cell.strip() for cell in text.split(separator)]
        return
    for number, text in body:
        try:
            cells = next(csv.reader([text], delimiter=separator, strict=True, skipinitialspace=True))
        except csv.Error as error:
            raise InputError(
                f"a quoted cell is not closed in its line ({error})",
                file=name,
                line=number,
                remedy="mend the quotes",
            ) from None
        yield number, [cell.strip() for cell in cells]


def _fitting(
    rows: list[tuple[int, list[str]]], header: list[str], separator: str, name: str
) -> tuple[list[tuple[int, list[str]]], int]:
    """Return the rows that hold something, each as wide as the header, and how many were blank."""
    width = len(header)
    if len(rows) * width > MAX_CELLS:
        raise InputError(
            f"has more than {MAX_CELLS} cells", file=name, remedy="thin it out or export fewer channels"
        )
    kept: list[tuple[int, list[str]]] = []
    for number, cells in rows:
        if len(cells) != width and not (len(cells) > width and not any(cells[width:])):
            if not any(cells):
                continue
            raise InputError(
                f"has {len(cells)} cells, the header has {width}",
                file=name,
                line=number,
                remedy=_ragged_remedy(len(cells), width, separator),
            )
        if any(cells):
            kept.append((number, cells[:width]))
    return kept, len(rows) - len(kept)


def _ragged_remedy(count: int, width: int, separator: str) -> str:
    if separator == "," and width < count <= 2 * width:
        return "decimal commas between separating commas? export with semicolons as separator"
    return f"complete the row (the separator is a {_NAMES[separator]})"


def _heading(title: str, index: int) -> Heading:
    match = _BRACKETED.fullmatch(title) if len(title) <= 200 else None
    if match is None:
        return Heading(title, title, None, index)
    unit = match[2] if match[2] is not None else match[3]
    if match[2] is None and not is_unit(unit):  # a remark in parentheses
        return Heading(title, match[1], None, index)
    return Heading(title, match[1].strip(), unit.strip() or "-", index)


def fold(text: str) -> str:
    """Return a name as it is compared: lower case, single spaces for ``_`` and ``-``.

    >>> fold("Gauge_Length ")
    'gauge length'
    """
    return " ".join(text.casefold().replace("_", " ").replace("-", " ").split())


def suffixed(heading: Heading) -> Heading:
    """Read ``membrane_stress_N_mm``, the way this program names columns, as ``membrane stress [N/mm]``."""
    parts = heading.title.split("_")
    for cut in range(1, len(parts)):
        unit = "/".join(parts[cut:])
        if heading.unit is None and not unit.isdigit() and is_unit(unit):
            return Heading(heading.title, "_".join(parts[:cut]), unit, heading.index)
    return heading


def _is_units_row(cells: list[str]) -> bool:
    bare = [cell.strip("[]() ") for cell in cells]
    if any(NUMBER_LIKE.fullmatch(cell) for cell in cells) or not any(bare):
        return False
    return all(is_unit(cell) for cell in bare)


def _with_units(headings: tuple[Heading, ...], row: tuple[int, list[str]], name: str) -> tuple[Heading, ...]:
    number, cells = row
    found = []
    for heading, cell in zip(headings, cells, strict=True):
        unit = cell.strip("[]() ") or None
        if unit is not None and heading.unit not in (None, unit):
            raise InputError(
                f"the unit is {unit} here and {heading.unit} in the header",
                file=name,
                line=number,
                column=heading.title,
                remedy="keep one of them",
            )
        found.append(Heading(heading.title, heading.label, heading.unit or unit, heading.index))
    return tuple(found)
