"""Logs of probes with a row for each reading, and the names that loggers give to probes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

from hyperfab.io.cells import is_clock, is_number
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import BRACKETS, fold
from hyperfab.io.headings import Heading, is_of, suffixed
from hyperfab.io.units import KINDS

#: How a logger makes one value of those it read since the last.
_ONE_VALUE = re.compile(r"[ _.](?:ave|avg|average|mean|last|mittel|mittelwert)\.?$", re.IGNORECASE)
#: What reads a probe, with its number, before the name: 101 cup, PT100_cup, TC3 cup; and what names one in brackets.
_READ_BY = re.compile(
    r"^(?:(?:ch|tc|pt|ai|t|temp|rtd|thermocouple|sensor|probe|channel|kanal)\.?[ _]?)?\d{0,4}[ _:.-]+", re.I
)
_NAMED = re.compile(r"(?:^|, *)(?:lbl|label|name|tag) *[:=] *([^,]+)", re.IGNORECASE)


def a_column_each(sheet: CsvSheet, called: Sequence[str], rest: str) -> CsvSheet:
    """Return a log with a row for each reading, whose probe a column names, as one with a column for each probe.

    What names a probe is read as the title of a column is, ``PT100_cup``, and may be said to be one as a column may. A
    clock goes before a number that counts the time, which may be another's: a spreadsheet's days times a million.

    InputError where a column has names of which none or not every one is known, or nothing tells the unit.
    """
    clock = moments(sheet) or sheet.find("time")
    if clock is None or len({*(times := sheet.columns[clock.index])}) == len(times):
        return sheet
    said = {fold(one.title): one.name for one in sheet.layout.columns}
    probes = {fold(one): one for one in called}

    def probe(word: str) -> str | None:
        found = said.get(fold(word)) or called_by(Heading(word, word, None, 0), called)
        return found if found == "aside" else probes.get(fold(found))

    words = [one for one in sheet.headings if one.index != clock.index and _names(sheet.columns[one.index], times)]
    known = [one for one in words if any(map(probe, {*sheet.columns[one.index]}))]
    if len(named := known or words) != 1:
        return sheet
    told, own = named[0], {word: probe(word) for word in dict.fromkeys(sheet.columns[named[0].index])}
    free = [one for one in called if one not in own.values()]
    if unknown := [word for word, one in own.items() if one is None]:
        entries = [*zip_longest(unknown, free[: len(unknown)], fillvalue="aside")]
        raise sheet.wrong(
            f"{unknown[0]} is no probe of the mold; it has {', '.join(called)}",
            told,
            remedy=f"say which probe each is, or aside, as in {sheet.option(entries)}",
        )
    numbers = [one for one in map(suffixed, sheet.headings) if one.index not in (clock.index, told.index)]
    numbers = [one for one in numbers if all(map(is_number, filter(None, sheet.columns[one.index])))]
    numbers = [one for one in numbers if one.name != "aside"]
    read = [one for one in numbers if one.unit is not None and is_of(one.unit, rest)]
    if len(read) != 1:
        likely = next(iter(read or [one for one in numbers if one.unit is None] or [told]))
        settled = [(likely.title, f"{rest} [{KINDS[rest].unit}]"), *((one.title, "aside") for one in read[1:])]
        if clock.unit is None and not is_clock(times[0]):
            settled.append((clock.title, "time [s]"))
        raise sheet.wrong(
            f"has {'several columns' if read else 'no column'} of a {rest} beside {told.title}",
            remedy=f"say {sheet.option(settled)}",
        )
    rows: dict[str, dict[str, str]] = {}
    first: list[int] = []
    beside = (sheet.columns[one.index] for one in (clock, told, read[0]))
    for line, time, word, cell in zip(sheet.lines, *beside, strict=True):
        if own[word] == "aside":
            continue
        first += [] if time in rows else [line]
        if str(own[word]) in rows.setdefault(time, {}):
            return sheet  # read twice at once
        rows[time][str(own[word])] = cell
    names = [one for one in dict.fromkeys(own.values()) if one not in (None, "aside")]
    heads = [replace(clock, label="time", index=0)]
    heads += [Heading(str(one), str(one), read[0].unit, k) for k, one in enumerate(names, 1)]
    columns = ([*rows], *([there.get(str(one), "") for there in rows.values()] for one in names))
    return replace(sheet, headings=tuple(heads), columns=columns, lines=first)


def _names(cells: Sequence[str], times: Sequence[str]) -> bool:
    """Whether cells beside ``times`` name what was read: words, each at several times, that tell equal times apart."""
    words = {*cells}
    parts = len({*zip(times, cells, strict=True)}) == len(cells)
    return 1 < len(words) <= len(cells) // 2 and parts and not any(not c or is_number(c) for c in words)


def called_by(head: Heading, called: Sequence[str]) -> str:
    """Return which of the ``called`` a column is, where its title names one in brackets, behind what reads it or before
    how the logger makes one value of several (``101 <cup> (C)``, ``PT100_cup``, ``cup Ave. (°C)``); else its label."""
    names = {fold(one): one for one in called}
    if fold(head.label) in names:
        return head.label
    inner = [part for parts in BRACKETS.findall(head.title) for part in parts if part]
    inner += [told for part in inner for told in _NAMED.findall(part)]
    before = _ONE_VALUE.sub("", head.label)
    found = {names[fold(one)] for one in (*inner, before, _READ_BY.sub("", before)) if fold(one) in names}
    return found.pop() if len(found) == 1 else head.label


def moments(sheet: CsvSheet) -> Heading | None:
    """Return the first column that tells a time of day in every row, whatever it is called: a logger's clock."""
    for one in sheet.headings:
        cells = sheet.columns[one.index]
        if one.name != "aside" and cells and all(re.search(r"\d ?[:hm]", cell) and is_clock(cell) for cell in cells):
            return one
    return None
