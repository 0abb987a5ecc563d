"""What rows of a table of tests tell beside stretch and stress: direction, time, temperature, rate, cycle, branch."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.io.cells import is_clock
from hyperfab.io.csv_numbers import numbers, quantities, seconds
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import word_for
from hyperfab.io.headings import Heading, is_of
from hyperfab.io.role_words import no_unit
from hyperfab.io.roles import Column, Roles
from hyperfab.io.specimen import Geometry
from hyperfab.io.stated import amount, stated
from hyperfab.io.titles import DEGREES_OF, direction_told, in_name, temperature_told, warmth

#: A cycle and which part of it a machine was in: 1-Preload, 2-Stretch, 2-Recover; or its number behind a word: Cycle 2.
_PART = re.compile(r"(\d{1,9}) ?[-_:] ?[^\W\d][\w ]*")
_COUNTED = re.compile(
    r"(?:cycle|cycl|cyc|zyklus|ciclo|loop|c|n)[ _.:-]*(\d{1,9})|(\d{1,9})(?:st|nd|rd|th|\.)?(?: ?cycle)?", re.IGNORECASE
)
_SIDES = {"load": 1, "unload": -1}
_Name = TypeVar("_Name", bound=str | None)


def directions(sheet: CsvSheet, columns: Roles) -> list[float | None]:
    """Return the direction of each row in degrees from the warp, None where it is not told."""
    column = columns.columns.get("direction")
    if column is None:
        entry = stated(sheet, "direction")
        value = direction_told(sheet) if entry is None else None
        if entry is not None:
            value = _direction(entry.value, None, sheet, entry.line) if entry.sure else _degrees(entry.value)
        if entry is None and value is None and "specimen" in columns.columns:
            named = held_down(words_or_stated(sheet, columns, "specimen"))
            own = {name: in_name(name or "") for name in named}
            if None not in own.values():  # warp-1, warp-2, weft-1
                return [own[name] for name in named]
        return [value] * len(sheet.lines)
    texts = sheet.columns[column.heading.index]
    known = {}
    for text, line in zip(texts, sheet.lines, strict=True):
        if text not in known:
            known[text] = _direction(text, column.heading, sheet, line)
    return [known[text] for text in texts]


def _degrees(text: str) -> float | None:
    """Return the angle from the warp that a word or a number tells, or None."""
    named = word_for(text, "DIRECTIONS")
    if named is not None:
        return DEGREES_OF[named]
    match = re.fullmatch(
        r"(?:\u00b1|\+/-)?\s*([+-]?\d{1,3}(?:\.\d{1,6})?)\s*(?:deg|degrees|°|grad|grados|gradi|degres|graus)?",
        text.strip().casefold(),
        re.ASCII,
    )
    return float(match[1]) if match and abs(float(match[1])) <= 360.0 else None


def _direction(text: str, column: Heading | None, sheet: CsvSheet, line: int) -> float:
    found = _degrees(text)
    if found is not None:
        return found
    other = "branch" if word_for(text, "BRANCHES") else "aside"
    raise InputError(
        f"{text[:40] or 'an empty cell'} is no direction",
        line=line,
        column=column.title if column else None,
        key=None if column else "direction",
        remedy="write warp, weft or degrees from the warp"
        + (f", or say {sheet.option([(column.title, other)])}" if column else ""),
    )


def words_or_stated(sheet: CsvSheet, columns: Roles, name: str) -> list[str | None]:
    """Return the words of a column of a row each, or what the file states for all, None where it is not told."""
    column = columns.columns.get(name)
    if column is not None:
        return [text or None for text in sheet.columns[column.heading.index]]
    entry = stated(sheet, name)
    return [entry.value or None if entry else None] * len(sheet.lines)


def held_down(told: Sequence[_Name]) -> list[_Name]:
    """Names that stand in the first of their rows alone, as merged cells have them, down to the next.

    >>> held_down(["A", None, None, "B", None]), held_down([None, "A"]), held_down(["A", None, "A"])
    (['A', 'A', 'A', 'B', 'B'], [None, 'A'], ['A', None, 'A'])
    """
    found, once = list(told), [text for text in told if text]
    if found and found[0] and len(set(once)) == len(once):
        for row in range(1, len(found)):
            found[row] = found[row] or found[row - 1]
    return found


def of_each_row(
    sheet: CsvSheet, columns: Roles, sizes: Geometry, decimal: str, clock: bool, notes: list[str]
) -> dict[str, Any]:
    """Return the columns of a curve that are numbers of each row, by the field they fill; None where not told."""
    return {
        "time_s": _times(sheet, columns, decimal, clock, notes),
        "temperature_degC": _temperature(sheet, columns, decimal, notes),
        "rate_1_s": _rate(sheet, columns, sizes, decimal, notes),
        "cycle": _cycles(sheet, columns, decimal, notes),
        "branch": _branches(sheet, columns),
    }


def _times(sheet: CsvSheet, columns: Roles, decimal: str, clock: bool, notes: list[str]) -> Array | None:
    column = columns.columns.get("time")
    if column is None:
        return None
    head = column.heading
    try:
        if is_clock(sheet.columns[head.index][0]):
            return seconds(sheet, head)
        return quantities(sheet, head, "time", decimal, name="time")
    except InputError as error:
        if clock:
            raise
        notes.append(f"{head.title} is not used: {error.message}")
        return None


def _temperature(sheet: CsvSheet, columns: Roles, decimal: str, notes: list[str]) -> Array | None:
    column = columns.columns.get("temperature") or columns.columns.get("chamber")
    if column is None:
        value = amount(sheet, "temperature", "temperature", decimal, notes)
        if "temperature" not in sheet.metadata:  # the room is what a test is at where nothing else tells
            value = temperature_told(sheet)
            named = held_down(words_or_stated(sheet, columns, "specimen")) if "specimen" in columns.columns else []
            own = {name: warmth(name or "") for name in named}
            if value is None and own and None not in own.values():  # wale_80C_1, wale_23C_1
                return np.array([own[name] for name in named], dtype=float)
            value = amount(sheet, "room temperature", "temperature", decimal, notes) if value is None else value
        return None if value is None else np.full(len(sheet.lines), value)
    if column.heading.unit is None:
        raise no_unit(sheet, column, columns, "temperature [degC]")
    return quantities(sheet, column.heading, "temperature", decimal, name="temperature")


def _rate(sheet: CsvSheet, columns: Roles, sizes: Geometry, decimal: str, notes: list[str]) -> Array | None:
    """Return the strain rate of each row: as stated, or the speed of the crosshead over the gauge length."""
    column = columns.columns.get("rate")
    length = sizes.gauge_length
    if column is None:
        entry = stated(sheet, "rate")
        if entry is not None and is_of(entry.value.lstrip("+-0123456789.,eE "), "velocity"):
            speed = amount(sheet, "rate", "velocity", decimal, notes)
            if length is None or speed is None:
                notes.append(f"rate, line {entry.line}: a speed without a gauge length is no strain rate")
                return None
            notes.append(f"rate, line {entry.line}: {entry.value} over the gauge length")
            return np.full(len(sheet.lines), speed / length)
        value = amount(sheet, "rate", "rate", decimal, notes)
        return None if value is None else np.full(len(sheet.lines), value)
    head = column.heading
    if head.unit is not None and is_of(head.unit, "velocity"):
        if length is None:
            notes.append(f"{head.title} is not used: a speed without a gauge length is no strain rate")
            return None
        return quantities(sheet, head, "velocity", decimal, name="rate") / length
    if head.unit is None:
        raise no_unit(sheet, column, columns, "rate [1/s]")
    return quantities(sheet, head, "rate", decimal, name="rate")


def _cycles(sheet: CsvSheet, columns: Roles, decimal: str, notes: list[str]) -> Ints | None:
    column = columns.columns.get("cycle")
    entry = stated(sheet, "cycle")
    if column is not None:
        parts = [_PART.fullmatch(cell) for cell in sheet.columns[column.heading.index]]
        if parts and all(parts):
            notes.append(f"{column.heading.title} tells a cycle and its part: the number is taken")
            return np.array([int(part[1]) for part in parts if part], dtype=np.int64)
        counted = [_COUNTED.fullmatch(cell) for cell in sheet.columns[column.heading.index]]
        if counted and all(counted):
            return np.array([int(one[1] or one[2]) for one in counted if one], dtype=np.int64)
        values = numbers(sheet, column.heading, decimal)
        # Machines count those done, from nought, in halves and quarters: 0.5 where the first turns back.
        from_nought = len(values) > 0 and float(values.min()) == 0.0
        if from_nought and np.any(values != np.round(values)) and np.all(4.0 * values == np.round(4.0 * values)):
            notes.append(f"{column.heading.title} counts parts of cycles: the whole ones done are taken")
            values = np.floor(values)
    elif entry is not None and re.fullmatch(r"\d{1,9}", entry.value, re.ASCII):
        values = np.full(len(sheet.lines), float(entry.value))
    elif entry is not None and entry.sure:
        raise InputError(f"{entry.value[:40]} is no cycle number", line=entry.line, remedy="write # cycle: 1")
    else:
        return None
    wrong = np.flatnonzero((values != np.round(values)) | (np.abs(values) > 1e9))
    if wrong.size:
        raise InputError(
            f"{values[wrong[0]]:g} is no cycle number",
            line=sheet.lines[int(wrong[0])],
            column="cycle",
            remedy="number the cycles 1, 2, 3" + _or_aside(sheet, column),
        )
    return values.astype(np.int64)


def _or_aside(sheet: CsvSheet, column: Column | None) -> str:
    return f", or say {sheet.option([(column.heading.title, 'aside')])}" if column else ""


def _branches(sheet: CsvSheet, columns: Roles) -> Ints | None:
    texts = words_or_stated(sheet, columns, "branch")
    if all(text is None for text in texts):
        return None
    known: dict[str | None, int] = {}
    for text, line in zip(texts, sheet.lines, strict=True):
        if text in known:
            continue
        side = word_for(text or "", "BRANCHES")
        if side is None:
            raise InputError(
                f"{text or 'an empty cell'} is no branch",
                line=line,
                column="branch",
                remedy="write load or unload" + _or_aside(sheet, columns.columns.get("branch")),
            )
        known[text] = _SIDES[side]
    return np.array([known[text] for text in texts], dtype=np.int64)
