"""A table in cells, with what is stated above it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from hyperfab.errors import InputError
from hyperfab.io.dictionary import reading
from hyperfab.io.headings import Heading, meaning, suffixed
from hyperfab.io.layout import Layout, filled_in
from hyperfab.io.rows import Row
from hyperfab.io.settings import Entry


@dataclass(frozen=True)
class CsvSheet:
    """A table in cells: all rows have the header's number of columns, blank rows are counted and gone.

    ``columns`` holds the cells by column; ``lines`` the source line of each row. ``left_out`` counts rows that are no
    readings by reason, ``closing`` are the words they begin with. ``mark`` is the decimal mark where it is sure;
    ``over`` the row of titles above the header.
    """

    name: str
    separator: str
    headings: tuple[Heading, ...]
    header_line: int
    columns: tuple[Sequence[str], ...]
    lines: Sequence[int]
    metadata: Mapping[str, list[Entry]]
    left_out: Mapping[str, int]
    closing: tuple[str, ...]
    layout: Layout
    mark: str | None
    over: Row | None
    label: str = ""

    def find(self, *names: str) -> Heading | None:
        """Return the column of one of ``names``, or None; InputError where two columns have it.

        A column's own words come first, then its unit behind an underscore, then what the dictionary says it means.
        """
        read: tuple[Callable[[Heading], str | None], ...] = (
            lambda one: one.name,
            lambda one: suffixed(one).name,
            lambda one: m.name if (m := meaning(suffixed(one))) is not None and not m.axis else None,
            lambda one: reading(suffixed(one).label),
        )
        for name_of in read:
            found = [suffixed(one) if name_of is not read[0] else one for one in self.headings if name_of(one) in names]
            if len(found) > 1:
                raise self.two(found, names[0])
            if found:
                return found[0]
        return None

    def two(self, found: Sequence[Heading], name: str) -> InputError:
        """Return the error that two columns could be one thing, with the option that settles it."""
        first, second = found[0], found[1]
        entries = [(first.title, name if first.unit in (None, "-") else f"{name} [{first.unit}]")]
        entries += [(one.title, "aside") for one in found[1:]]
        if first.title == second.title:
            entries = [(f"#{one.index + 1}", what) for one, (_, what) in zip(found, entries, strict=True)]
        return self.wrong(
            f"two columns give the {name}: {first.title} and {second.title}",
            remedy=f"say which: {self.option(entries)}",
        )

    def option(self, entries: Sequence[tuple[str, str]]) -> str:
        """Return ``--columns`` with some entries beside those already given, ready to be pasted in its place."""
        told = dict(one.entry for one in self.layout.columns)
        return filled_in([*(told | dict(entries)).items()])

    def wrong(self, why: str, heading: Heading | None = None, *, row: int | None = None, remedy: str) -> InputError:
        """Return the error that something is wrong in a column: at a row, or in the header where none is named."""
        line = self.header_line if row is None else self.lines[row]
        column = None if heading is None else heading.title
        return InputError(why, file=self.name, line=line, column=column, remedy=remedy)

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

    def without(self, rows: Sequence[int], reason: str) -> CsvSheet:
        """Return the sheet less some rows, counted under ``reason``."""
        gone = set(rows)
        kept = self.of_rows([row for row in range(len(self.lines)) if row not in gone])
        return replace(kept, left_out={**self.left_out, reason: self.left_out.get(reason, 0) + len(gone)})

    def with_rows_of(self, *others: CsvSheet) -> CsvSheet:
        """Return the sheet with the rows of others of the same columns below its own, and what was left out there."""
        every = (self, *others)
        places = range(len(self.columns))
        return replace(
            self,
            columns=tuple([cell for one in every for cell in one.columns[place]] for place in places),
            lines=[line for one in every for line in one.lines],
            left_out=dict(sum((Counter(one.left_out) for one in every), Counter[str]())),
            closing=tuple(dict.fromkeys(word for one in every for word in one.closing)),
        )

    def of_rows(self, rows: Sequence[int]) -> CsvSheet:
        """Return the sheet with some rows alone."""
        columns = tuple([cells[row] for row in rows] for cells in self.columns)
        return replace(self, columns=columns, lines=[self.lines[row] for row in rows])
