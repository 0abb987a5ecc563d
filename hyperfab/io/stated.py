"""What lines above a table state of the specimen and the test, taken where it can be read one way."""

from __future__ import annotations

import re
from dataclasses import replace

from hyperfab.errors import InputError
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import setting
from hyperfab.io.headings import is_of
from hyperfab.io.settings import Entry
from hyperfab.io.units import quantity


def stated(sheet: CsvSheet, key: str, axis: str = "") -> Entry | None:
    """Return what the file says under ``key``: a line ``# key: value`` first, else the only value of a preamble.

    With an ``axis`` what it says of that one. InputError where two lines of the contract's form gainsay each other.
    """
    entries = [entry for entry in sheet.metadata.get(key, []) if axis in ("", entry.axis)]
    sure = [entry for entry in entries if entry.sure]
    if sure:
        if len({entry.value for entry in sure}) > 1:
            return sheet.meta(key)  # raises
        return sure[0]
    return entries[0] if len({entry.value for entry in entries}) == 1 else None


def amount(sheet: CsvSheet, key: str, kind: str, decimal: str, notes: list[str], axis: str = "") -> float | None:
    """Return a stated quantity in the unit of its ``kind``, or None; ``notes`` tells what was not taken and why.

    InputError where a line of the contract's own form, ``# key: value``, cannot be read.
    """
    entry = stated(sheet, key, axis)
    if entry is None:
        entries = [] if axis else sheet.metadata.get(key, [])
        alone = [replace(sheet, metadata={key: [one]}) for one in entries]
        if len({value := amount(one, key, kind, decimal, []) for one in alone}) == 1:
            return value  # 50 mm and 5.0 cm
        if entries and not all(one.axis for one in entries):
            lines = ", ".join(str(one.line) for one in entries[:4])
            notes.append(f"{key}: lines {lines} differ, none is taken")
        return None
    try:
        return quantity(dotted(entry.value, decimal), kind)
    except InputError as error:
        if entry.sure:
            raise InputError(error.message, line=entry.line, key=key, remedy=error.remedy) from None
        notes.append(
            f"{key}, line {entry.line}: {entry.value[:40]} is not taken "
            f"({error.message.partition(': ')[2] or error.message})"
        )
        return None


def conflicting(sheet: CsvSheet, decimal: str) -> None:
    """InputError where a gauge length and another distance of the grips are stated: which one an extension is over?"""
    gauge, grips = (amount(sheet, key, "length", decimal, []) for key in ("gauge length", "grip distance"))
    if gauge is None or grips is None or abs(gauge - grips) <= 0.01 * gauge:
        return
    one, two = stated(sheet, "gauge length"), stated(sheet, "grip distance")
    raise InputError(
        f"states a gauge length of {gauge:g} mm and, in line {two.line if two else 0}, {grips:g} mm between the grips",
        line=one.line if one else None,
        remedy=f"say which the extension is over: --gauge-length {gauge:g}mm for an extensometer, "
        f"--gauge-length {grips:g}mm for the crosshead",
    )


def untaken(sheet: CsvSheet, key: str, decimal: str) -> InputError | None:
    """Return the error that a size is stated and cannot be taken, with the option that gives it; None where it can."""
    entries = sheet.metadata.get(key, [])
    if not entries or amount(sheet, key, "length", decimal, []) is not None:
        return None
    option = "--gauge-length" if key == "grip distance" else f"--{key.replace(' ', '-')}"
    values = list(dict.fromkeys(dotted(one.value, decimal) for one in entries))
    sizes = [re.fullmatch(r"(?:[^\d]*[:=])?\s*(\d+(?:\.\d+)?)\s*([^\d\s]*)", value) for value in values]
    if not all(size and (not size[2] or is_of(size[2], "length")) for size in sizes):
        options = f"{option} 50mm"
    else:
        options = " or ".join(f"{option} {size[1]}{size[2] or 'mm'}" for size in sizes if size)
    told = " and ".join(value[:40] for value in values)
    bare = all(sizes) and not any(size[2] for size in sizes if size)
    return InputError(
        f"states {told}" if len(values) > 1 else f"{told}: is no length that can be taken for sure",
        line=entries[0].line,
        key=key,
        remedy=("write the unit behind it, or, if it is in mm, " if bare else "") + f"give {options}",
    )


def perhaps_gauge_length(sheet: CsvSheet, decimal: str, pressed: bool) -> str:
    """Return how to say the gauge length that a file lacks, filled in where it states a length of the specimen.

    A block that is pressed stands on its length and width: its height, or else its thickness, is pressed.
    """
    for key in ("height", "thickness") if pressed else ():
        entry, height = stated(sheet, key), amount(sheet, key, "length", decimal, [])
        if entry is not None and height is not None:
            return f"line {entry.line} has a {key} of {height:g} mm: if that is pressed, --gauge-length {height:g}mm"
    entry, length = stated(sheet, "specimen length"), amount(sheet, "specimen length", "length", decimal, [])
    if entry is None or length is None:
        others = _lengths_of_no_known_name(sheet, decimal)
        if len(others) == 1:
            [(name, (line, length))] = others.items()
            return f"line {line} says {name}: {length:g} mm; if that is it, --gauge-length {length:g}mm"
        return 'give --gauge-length 50mm, or add a line "# gauge length: 50 mm" on top'
    return f"line {entry.line} has a length of {length:g} mm: if that is between the grips, --gauge-length {length:g}mm"


def _lengths_of_no_known_name(sheet: CsvSheet, decimal: str) -> dict[str, tuple[int, float]]:
    """Return line and length [mm] of what a file states under a name nobody knows, in one way."""
    found = {}
    for name, entries in sheet.metadata.items():
        if setting(name) is None and stated(sheet, name) is not None:
            length = amount(sheet, name, "length", decimal, [])
            if length is not None and length > 0.0:
                found[name] = entries[0].line, length
    return found


def dotted(text: str, decimal: str) -> str:
    """Return ``12,5 mm`` as ``12.5 mm`` where the comma is a decimal mark for sure, or that of the file."""
    match = re.match(r"([+-]?\d+),(\d+)(?![\d,.])", text.strip())
    if match and (decimal == "," or len(match[2]) != 3 or match[1].lstrip("+-") == "0"):
        return f"{match[1]}.{match[2]}{text.strip()[match.end() :]}"
    return text
