"""Sizes that stand in columns of a table, the same in all rows of a specimen."""

from __future__ import annotations

from dataclasses import replace

from hyperfab.io.cells import is_number
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import setting_along
from hyperfab.io.headings import Heading, suffixed
from hyperfab.io.roles import STRETCHES, read
from hyperfab.io.row_states import held_down
from hyperfab.io.settings import SIZES, Entry


def parted_by_sizes(sheet: CsvSheet) -> list[CsvSheet]:
    """Return a table for each set of sizes that its columns state, these among what it states; else the sheet.

    A column is one of sizes where it holds one number for each specimen, in all its rows or in the first alone; one
    that changes with the rows is a reading, and stays.
    """
    columns = [head for head in sheet.headings if _may_be_size(sheet, head)]
    if not columns:
        return [sheet]
    told = [
        held_down(sheet.columns[head.index])
        for head in sheet.headings
        if (one := read(head)) is not None and one.name in ("specimen", "direction", "test")
    ]
    specimens: dict[tuple[str, ...], list[int]] = {}
    for row in range(len(sheet.lines)):
        specimens.setdefault(tuple(cells[row] for cells in told), []).append(row)
    taken: list[Heading] = []
    sizes: list[list[str]] = [[] for _ in specimens]
    for head in columns:
        cells = sheet.columns[head.index]
        values = [{cells[row] for row in rows} - {""} for rows in specimens.values()]
        if all(len(one) == 1 and is_number(min(one)) for one in values):
            taken.append(head)
            for own, [value] in zip(sizes, values, strict=True):
                own.append(value)
    parts: dict[tuple[str, ...], list[int]] = {}
    for own, rows in zip(sizes, specimens.values(), strict=True):
        parts.setdefault(tuple(own), []).extend(rows)
    return [_part(sheet, taken, own, sorted(rows)) for own, rows in parts.items()]


def _may_be_size(sheet: CsvSheet, head: Heading) -> bool:
    """Whether a column is called as a size is that no line of the contract's form states, and gives no stretch."""
    sized = suffixed(head)
    key = setting_along(sized.label)[0]
    if sized.unit is None and len(sized.label) <= 2:
        return False  # b, w and a0 are letters of other things too
    if key not in SIZES or any(one.sure for one in sheet.metadata.get(key, [])):
        return False
    what = read(head)
    others = {one.name for other in sheet.headings if other is not head and (one := read(other)) is not None}
    free = what is None or what.name == "aside" or (what.name == "length" and bool(others & {*STRETCHES}))
    return free and sheet.layout.choice(head, sheet.headings) is None


def _part(sheet: CsvSheet, heads: list[Heading], sizes: tuple[str, ...], rows: list[int]) -> CsvSheet:
    """Return the table of some rows, whose columns ``heads`` hold one size each."""
    metadata = {key: list(entries) for key, entries in sheet.metadata.items()}
    for head, size in zip(map(suffixed, heads), sizes, strict=True):
        key, axis = setting_along(head.label)
        entry = Entry(f"{size} {head.unit or ''}".strip(), sheet.lines[rows[0]], sure=False, axis=axis)
        metadata.setdefault(str(key), []).append(entry)
    kept = tuple(head for head in sheet.headings if head not in heads)
    return replace(sheet.of_rows(rows), metadata=metadata, headings=kept)


def of_own_rows(sheets: list[CsvSheet]) -> list[CsvSheet]:
    """Return tables of several specimens, of each among what it states the sizes in its own row of a small table above.

    The row is that which is called as the specimen is; where none are, and there are as many, they stand in its order.
    """
    named = [dict.fromkeys(one.of for own in sheet.metadata.values() for one in own if one.of) for sheet in sheets]
    if len(sheets) < 2 or not named[0] or any(one != named[0] for one in named):
        return sheets
    names = list(named[0])
    labels = [sheet.label for sheet in sheets]
    if not set(labels) <= set(names):
        if len(names) != len(sheets):
            return sheets
        labels = names
    return [
        replace(
            sheet,
            metadata={key: [one for one in own if one.of in ("", label)] for key, own in sheet.metadata.items()},
        )
        for sheet, label in zip(sheets, labels, strict=True)
    ]
