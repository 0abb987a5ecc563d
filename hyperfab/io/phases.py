"""Tables of one test that a machine writes phase by phase: each goes on where the one before it ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.io.cells import is_number
from hyperfab.io.csv_numbers import numbers
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.roles import STRETCHES, Column, roles
from hyperfab.io.settings import Entry

#: How far the grip may stand from where it was left, and must from where the test began, as shares of its way.
_NEAR, _OFF = 0.02, 0.1


def in_one(sheets: Sequence[CsvSheet], decimal: str | None) -> list[CsvSheet]:
    """Return the tables of a file with those in one that are phases of a test, the clock of each going on.

    A phase has the head of the first, and begins where the one before it left the grips, away from where the test
    began: a new specimen begins at rest. Raises InputError where a table's columns or numbers can be read in two ways.
    """
    found: list[CsvSheet] = []
    for sheet in sheets:
        if found and _goes_on(found[-1], sheet, decimal):
            found[-1] = _joined(found[-1], sheet, decimal)
        else:
            found.append(sheet)
    return found


def _goes_on(test: CsvSheet, sheet: CsvSheet, decimal: str | None) -> bool:
    if sheet.label or sheet.header_line == test.header_line:
        return False
    if [one.title for one in test.headings] != [one.title for one in sheet.headings]:
        return False
    column = roles(test).first(STRETCHES)
    if column is None:
        return False
    before, after = (_readings(one, column, decimal) for one in (test, sheet))
    if not len(before) or not len(after):
        return False
    way = float(np.ptp(before))
    return abs(after[0] - before[-1]) <= _NEAR * way < _OFF * way < abs(after[0] - before[0])


def _readings(sheet: CsvSheet, column: Column, decimal: str | None) -> Array:
    """Return the readings of a column (n,), those that are numbers."""
    cells = [cell for cell in sheet.columns[column.heading.index] if is_number(cell)]
    columns = tuple(cells if one.index == column.heading.index else [] for one in sheet.headings)
    return numbers(replace(sheet, columns=columns), column.heading, roles(sheet).decimal_mark(sheet, decimal))


def _joined(test: CsvSheet, phase: CsvSheet, decimal: str | None) -> CsvSheet:
    """Return two tables as one: what they state alike is stated, a clock that began anew goes on."""
    more = list(phase.columns)
    clock = roles(test).first(("time",))
    if clock is not None and all(map(is_number, phase.columns[clock.heading.index])):
        before, after = (_readings(one, clock, decimal) for one in (test, phase))
        if len(before) and after[0] < before[-1]:
            mark = roles(phase).decimal_mark(phase, decimal)
            more[clock.heading.index] = [f"{time:.12g}".replace(".", mark) for time in after + before[-1]]
    joined = test.with_rows_of(replace(phase, columns=tuple(more)))
    return replace(joined, metadata=_stated_alike(test.metadata, phase.metadata))


def _stated_alike(one: Mapping[str, list[Entry]], other: Mapping[str, list[Entry]]) -> dict[str, list[Entry]]:
    def values(stated: Mapping[str, list[Entry]], key: str) -> set[str]:
        return {entry.value for entry in stated.get(key, [])}

    return {key: entries for key, entries in one.items() if key not in other or values(one, key) == values(other, key)}
