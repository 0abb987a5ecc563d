"""How a table was read, in a line: where its head stands, and what each column that was taken is."""

from __future__ import annotations

from collections.abc import Iterable

from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.headings import heading
from hyperfab.io.roles import Column
from hyperfab.io.specimen import Loading


def understood(sheet: CsvSheet, loadings: Iterable[Loading], others: Iterable[Column]) -> str:
    """Return what was understood of a table, without the file's name: files read alike say the same."""
    columns = {column.heading.index: column for loading in loadings for column in loading.used}
    columns |= {column.heading.index: column for column in others}
    told = [
        one.heading.title
        if (one.heading.name.removesuffix(" 1") == one.name and one.heading.unit is None)
        or one.heading.title == _plainly(one)
        else f"{one.heading.title or f'column {index + 1}'} is {_what(one)}"
        for index, one in sorted(columns.items())
    ]
    return f"head in line {sheet.header_line}: {', '.join(told)}"


def _plainly(column: Column) -> str:
    """Return the title a column of the contract's own form has."""
    return f"{column.name} [{column.heading.unit}]"


def _what(column: Column) -> str:
    head = column.heading
    minus = "minus " if column.minus else ""
    unit = f" [{head.unit}]" if head.unit and heading(head.title, 0).unit is None else ""
    nominal = (
        " (nominal)"
        if column.name == "stress" and head.name.startswith(("sigma", "\N{GREEK SMALL LETTER SIGMA}"))
        else ""
    )
    return f"{minus}{column.name}{unit}{nominal}"
