"""Cells of an Excel workbook (.xlsx), read as text: no macro runs, no link is followed, nothing unpacks without bound.

A reader of our own rather than openpyxl or python-calamine (both MIT): what counts
here is the format of a cell, 5 % is stored as 0.05, and a bound on what an archive may unpack to.
Source: ECMA-376, Office Open XML, part 1, 18.2 to 18.4, 18.8.30.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from datetime import datetime, timedelta
from decimal import Context, Decimal, InvalidOperation
from io import BytesIO
from typing import Any
from xml.parsers import expat

from hyperfab.errors import InputError
from hyperfab.io.rows import MAX_CELLS, MAX_ROWS, Row

#: A workbook may unpack to no more than this, all parts together.
MAX_UNPACKED = 256 * 2**20
_COLUMN = re.compile(r"([A-Z]{1,3})(\d{1,7})")
_NAME = re.compile(r"(.+\.xls[xm])(?::(.+))?", re.IGNORECASE | re.DOTALL)
_FIFTEEN = Context(prec=15)
#: What stands for a formula whose value the file does not hold: a program wrote it that computes none.
NOT_COMPUTED = "=(not computed)"


def split_sheet(name: str) -> tuple[str, str | None]:
    """Return the file and the sheet of ``FILE.xlsx:SHEET``.

    >>> split_sheet("a/k17.xlsx:Probe 1"), split_sheet("k17.xlsx"), split_sheet("C:k17.csv")
    (('a/k17.xlsx', 'Probe 1'), ('k17.xlsx', None), ('C:k17.csv', None))
    """
    match = _NAME.fullmatch(name)
    return (match[1], match[2]) if match else (name, None)


def is_workbook(data: bytes) -> bool:
    """Whether a file is an Excel workbook of today's kind."""
    if not data.startswith(b"PK\x03\x04"):
        return False
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            return "[Content_Types].xml" in archive.namelist() and any(
                part.startswith("xl/") for part in archive.namelist()
            )
    except (zipfile.BadZipFile, ValueError, OSError):
        return True  # said by worksheets


def worksheets(data: bytes, picked: str | None) -> list[tuple[str, list[Row]]]:
    """Return the visible sheets of a workbook, or the one called ``picked``: its title, its rows of cells as text.

    Numbers stand as they are stored, to the digit; percentages with their sign, dates in ISO form, errors by their name
    (#DIV/0!). InputError where the workbook is broken, has macros, or has no such sheet.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            return list(_sheets(_Parts(archive), picked))
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        expat.ExpatError,
        NotImplementedError,
        EOFError,
        OSError,
        KeyError,
        ValueError,
        RuntimeError,
        OverflowError,
    ) as error:
        raise InputError(
            f"is no Excel workbook that can be read ({error})", remedy="save it again as .xlsx, or as CSV"
        ) from None


class _Parts:
    """The parts of an archive, unpacked with a bound."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive, self._left = archive, MAX_UNPACKED
        names = archive.namelist()
        if any("vbaproject" in part.lower() for part in names) or b"macroEnabled" in self.read("[Content_Types].xml"):
            raise InputError("is a workbook with macros (.xlsm)", remedy="save it as .xlsx or CSV")
        self.names = set(names)

    def read(self, part: str) -> bytes:
        with self._archive.open(part) as stream:
            found = stream.read(self._left + 1)
        self._left -= len(found)
        if self._left < 0:
            raise InputError(f"unpacks to more than {MAX_UNPACKED // 2**20} MiB", remedy="thin the recording out")
        return found


def _sheets(parts: _Parts, picked: str | None) -> Iterator[tuple[str, list[Row]]]:
    titles: list[tuple[str, str, bool]] = []
    epoch = datetime(1899, 12, 30)

    def sheet(tag: str, attributes: dict[str, str]) -> None:
        nonlocal epoch
        if tag == "sheet":
            link = next((value for key, value in attributes.items() if key.endswith(":id")), "")
            titles.append((attributes.get("name", ""), link, attributes.get("state", "visible") == "visible"))
        elif tag == "workbookPr" and attributes.get("date1904") in ("1", "true"):
            epoch = datetime(1904, 1, 1)

    _parse(parts.read("xl/workbook.xml"), sheet)
    targets: dict[str, str] = {}

    def relation(tag: str, attributes: dict[str, str]) -> None:
        if tag == "Relationship" and attributes.get("TargetMode") != "External":
            target = attributes.get("Target", "").lstrip("/")
            targets[attributes.get("Id", "")] = target if target.startswith("xl/") else f"xl/{target}"

    _parse(parts.read("xl/_rels/workbook.xml.rels"), relation)
    strings = _strings(parts.read("xl/sharedStrings.xml")) if "xl/sharedStrings.xml" in parts.names else []
    formats = _formats(parts.read("xl/styles.xml")) if "xl/styles.xml" in parts.names else []
    wanted = [one for one in titles if (one[2] if picked is None else one[0].casefold() == picked.strip().casefold())]
    if not wanted:
        there = ", ".join(title for title, _, _ in titles[:8])
        raise InputError(
            f"has no sheet {picked}" if picked else "has no sheet that is not hidden", remedy=f"there is {there}"
        )
    for title, link, _ in wanted:
        part = targets.get(link, "")
        if part in parts.names and "worksheet" in part:
            yield title, _rows(parts.read(part), strings, formats, epoch)


def _parse(data: bytes, start: Any, end: Any = None, text: Any = None) -> None:
    parser = expat.ParserCreate()

    def refuse(*_: object) -> None:
        raise ValueError("a document type is declared in it")

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda tag, attributes: start(tag.rpartition(":")[2], attributes)
    if end is not None:
        parser.EndElementHandler = lambda tag: end(tag.rpartition(":")[2])
    if text is not None:
        parser.CharacterDataHandler = text
        parser.buffer_text = True
    parser.Parse(data, True)


def _strings(data: bytes) -> list[str]:
    found: list[list[str]] = []
    state = {"in": False, "sound": False}

    def start(tag: str, _: dict[str, str]) -> None:
        if tag == "si":
            found.append([])
        state["in"] = tag == "t"
        state["sound"] = state["sound"] or tag == "rPh"

    def end(tag: str) -> None:
        state["in"] = False
        state["sound"] = state["sound"] and tag != "rPh"

    def text(part: str) -> None:
        if state["in"] and not state["sound"] and found:
            found[-1].append(part)

    _parse(data, start, end, text)
    return ["".join(parts) for parts in found]


def _formats(data: bytes) -> list[str]:
    """Return what each cell style makes of a number: ``percent``, ``date`` or nothing."""
    codes: dict[str, str] = {}
    styles: list[str] = []
    state = {"cells": False}

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "numFmt":
            codes[attributes.get("numFmtId", "")] = attributes.get("formatCode", "")
        elif tag == "cellXfs":
            state["cells"] = True
        elif tag == "xf" and state["cells"]:
            styles.append(attributes.get("numFmtId", "0"))

    def end(tag: str) -> None:
        if tag == "cellXfs":
            state["cells"] = False

    _parse(data, start, end)
    return [_kind(style, codes.get(style)) for style in styles]


def _kind(style: str, code: str | None) -> str:
    if code is None:
        number = int(style) if style.isdigit() else 0
        if number in (9, 10):
            return "percent"
        return "date" if 14 <= number <= 22 or 45 <= number <= 47 else ""
    bare = re.sub(r'"[^"]*"|\\.|_.|\[(?!h|m|s)[^\]]*\]', "", code, flags=re.IGNORECASE)
    if "%" in bare:
        return "percent"
    return "date" if re.search(r"[ymdhs]", bare, re.IGNORECASE) and "General" not in bare else ""


def _rows(data: bytes, strings: list[str], formats: list[str], epoch: datetime) -> list[Row]:
    found: list[Row] = []
    count = 0
    cells: list[str] = []
    state: dict[str, Any] = {
        "row": 0,
        "column": 0,
        "kind": "n",
        "style": 0,
        "text": [],
        "in": False,
        "formula": False,
    }

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal cells
        if tag == "c":
            match = _COLUMN.fullmatch(attributes.get("r", ""))
            if match:
                number = 0
                for letter in match[1]:
                    number = 26 * number + ord(letter) - 64
                state["column"] = number - 1
            state["kind"], state["style"] = attributes.get("t", "n"), int(attributes.get("s", "0"))
            state["text"], state["formula"] = [], False
        elif tag in ("v", "t"):
            state["in"] = True
        elif tag == "f":
            state["formula"] = True
        elif tag == "row":
            state["row"] = int(attributes.get("r", state["row"] + 1))
            state["column"], cells = 0, []

    def end(tag: str) -> None:
        nonlocal count
        if tag in ("v", "t"):
            state["in"] = False
        elif tag == "c":
            place, text = state["column"], "".join(state["text"])
            if text or state["formula"]:
                if place > 16_383:
                    raise ValueError("a cell beyond the last column")
                cells.extend([""] * (place + 1 - len(cells)))
                cells[place] = _cell(text, state, strings, formats, epoch)
            state["column"] = place + 1
        elif tag == "row":
            count += len(cells)
            found.append((state["row"], cells))
            if len(found) > MAX_ROWS or count > 4 * MAX_CELLS:
                raise InputError(f"has more than {MAX_ROWS} rows", remedy="thin the recording out")

    def text(part: str) -> None:
        if state["in"]:
            state["text"].append(part)

    _parse(data, start, end, text)
    return found


def _cell(text: str, state: dict[str, Any], strings: list[str], formats: list[str], epoch: datetime) -> str:
    kind = state["kind"]
    if kind == "s":
        return strings[int(text)].strip()
    if kind == "b":
        return "TRUE" if text == "1" else "FALSE"
    if not text:
        return NOT_COMPUTED
    if kind != "n":
        return text.strip()
    style = formats[state["style"]] if state["style"] < len(formats) else ""
    if not style:
        return text
    try:
        value = Decimal(text)
    except InvalidOperation:
        return text
    if style == "percent":
        return f"{_FIFTEEN.multiply(value, Decimal(100)).normalize():f}%"
    moment = timedelta(microseconds=round(float(value) * 86400e6))
    if 0 <= float(value) < 1:
        return str(moment)
    return (epoch + moment).isoformat(sep=" ")
