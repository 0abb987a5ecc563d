"""Logs of probes with a row for each reading, and the names that loggers give to probes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

from hyperfab.io.cells import is_clock, is_number, plain_values
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import BRACKETS, fold, plain
from hyperfab.io.headings import Heading, is_of, suffixed
from hyperfab.io.row_states import held_down
from hyperfab.io.units import KINDS

#: How a logger makes one value of those it read since the last.
_ONE_VALUE = re.compile(r"[ _.](?:ave|avg|average|mean|value|last|mittel|mittelwert)\.?$", re.IGNORECASE)
#: What reads a probe, with its number, before the name: 101 cup, PT100_cup, TC3 cup; and what names one in brackets.
_READ_BY = re.compile(
    r"^(?:(?:ch|chan|tc|pt|ai|t|temp|rtd|thermocouple|sensor|probe|channel|kanal)\.?[ _]?)?\d{0,4}[ _:.-]+", re.I
)
_NAMED = re.compile(r"(?:^|, *)(?:lbl|label|name|tag) *[:=] *([^,]+)", re.IGNORECASE)


def a_column_each(sheet: CsvSheet, called: Sequence[str], rest: str) -> CsvSheet:
    """Return a log with a row for each reading, whose probe a column names, as one with a column for each probe.

    What names a probe is read as the title of a column is, ``PT100_cup``, and may be said to be one as a column may. A
    clock goes before a number that counts the time, which may be another's: a spreadsheet's days times a million.

    InputError where a column has names of which none or not every one is known, or nothing tells the unit.
    """
    clock = moments(sheet) or sheet.find("time")
    if clock is None or _counts_up(times := sheet.columns[clock.index]):
        return sheet
    # Words may stand in the first of their rows alone.
    columns = tuple(cells if any(map(is_number, cells)) else held_down(cells) for cells in sheet.columns)
    sheet = replace(sheet, columns=columns)
    said = {fold(one.title): one.name for one in sheet.layout.columns}
    probes = {fold(one): one for one in called}

    def probe(word: str) -> str | None:
        found = said.get(fold(word)) or called_by(Heading(word, word, None, 0), called)
        return found if found == "aside" else probes.get(fold(found))

    words = [one for one in sheet.headings if one.index != clock.index and _names(sheet.columns[one.index], times)]
    known = [one for one in words if any(map(probe, {*sheet.columns[one.index]}))]
    if len(named := known or words) != 1:
        counted = [one for one in sheet.headings if one not in words and _names(sheet.columns[one.index], times, True)]
        wide = any(fold(called_by(suffixed(one), called)) in probes for one in sheet.headings)  # else of several runs
        if not (words or wide) and len(counted) == 1 and counted[0].unit is None and len({*times}) < len(times):
            raise sheet.wrong(
                "numbers what was read at the same times",
                counted[0],
                remedy=f"write the probe in place of each number; the mold has {', '.join(called)}",
            )
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
    first: dict[str, int] = {}
    beside = (sheet.columns[one.index] for one in (clock, told, read[0]))
    for line, time, word, cell in zip(sheet.lines, *beside, strict=True):
        if own[word] == "aside":
            continue
        first.setdefault(time, line)
        if str(own[word]) in rows.setdefault(time, {}):
            return sheet  # read twice at once
        rows[time][str(own[word])] = cell
    if len(plain_values([*rows])) == len(rows):  # each probe by its own clock
        rows = dict(sorted(rows.items(), key=lambda one: plain_values([one[0]])))
    names = [one for one in dict.fromkeys(own.values()) if one not in (None, "aside")]
    heads = [replace(clock, label="time", index=0)]
    heads += [Heading(str(one), str(one), read[0].unit, k) for k, one in enumerate(names, 1)]
    columns = ([*rows], *([there.get(str(one), "") for there in rows.values()] for one in names))
    return replace(sheet, headings=tuple(heads), columns=columns, lines=[first[time] for time in rows])


def _names(cells: Sequence[str], times: Sequence[str], numbers: bool = False) -> bool:
    """Whether cells beside ``times`` name what was read: words, or ``numbers``, each at several times, that tell equal
    times apart."""
    words = {*cells}
    parts = len({*zip(times, cells, strict=True)}) == len(cells)
    return 1 < len(words) <= len(cells) // 2 and parts and all(c and is_number(c) == numbers for c in words)


def _counts_up(times: Sequence[str]) -> bool:
    """Whether no time stands there twice, nor, where all are numbers, behind a later one."""
    values = plain_values(times)
    return len({*times}) == len(times) and (len(values) < len(times) or values == sorted(values))


def one_under_another(sheets: Sequence[CsvSheet], called: Sequence[str]) -> CsvSheet | None:
    """Return tables of one probe each, which stands above it, as one with a column of their names; None where they are
    none."""
    probes = {fold(one) for one in called}
    names = [
        {entry.value for told in one.metadata.values() for entry in told if fold(entry.value) in probes}
        for one in sheets
    ]
    titles = {tuple(head.title for head in one.headings) for one in sheets}
    if len(titles) > 1 or any(len(one) != 1 for one in names):
        return None
    words = [name for one, [name] in zip(sheets, names, strict=True) for _ in one.lines]
    made = sheets[0].with_rows_of(*sheets[1:])
    heads = (*made.headings, Heading("probe", "probe", None, len(made.columns)))
    return replace(made, headings=heads, columns=(*made.columns, words))


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


def extremes(labels: Sequence[str], called: Sequence[str]) -> dict[str, list[str]]:
    """Return the labels of the least and the largest that a logger read of each of the ``called`` since the last row.

    >>> extremes(["cup Min", "cup Max.", "base Max"], ["cup", "base"])
    {'cup': ['cup Min', 'cup Max.']}
    """
    by_words = {plain(one): one for one in labels}
    pairs = {one: [f"{plain(one)} {end}" for end in ("min", "max")] for one in called}
    return {one: [by_words[end] for end in ends] for one, ends in pairs.items() if all(end in by_words for end in ends)}


def moments(sheet: CsvSheet) -> Heading | None:
    """Return the first column that tells a time of day in every row, whatever it is called: a logger's clock."""
    for one in sheet.headings:
        cells = sheet.columns[one.index]
        if one.name != "aside" and cells and all(re.search(r"\d ?[:hm]", cell) and is_clock(cell) for cell in cells):
            return one
    return None
