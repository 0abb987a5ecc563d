"""Units that stand in the cells of a table: behind every number of a column, or in a column beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hyperfab.errors import InputError
from hyperfab.io.cells import NO_READING, is_number
from hyperfab.io.dictionary import Meaning, plain
from hyperfab.io.headings import Heading, meaning, unit_behind, unit_of
from hyperfab.io.tables import UNITS


def units_of_cells(heads: list[Heading], columns: list[list[str]], lines: Sequence[int]) -> None:
    """Give headings the unit that stands behind every number of their column, which is taken off the cells, or that a
    column of units on their right repeats; that one is set aside.

    InputError where a column is in two units, naming both lines.

    >>> heads, columns = [Heading("cup", "cup", None, 0), Heading("Unit", "Unit", None, 1)], [["71.6"], ["F"]]
    >>> units_of_cells(heads, columns, [2])
    >>> [(one.label, one.unit) for one in heads]
    [('cup', 'F'), ('aside', None)]
    """
    for index, cells in enumerate(columns[: len(heads)]):
        head, left = heads[index], heads[index - 1]
        if index and left.unit is None and _are_units(head, cells, columns[index - 1]):
            first, *others = dict.fromkeys(filter(None, cells))
            if others:
                raise _in_two_units(left, cells, lines, first, others[0])
            heads[index - 1] = replace(left, unit=unit_of(first))
            heads[index] = replace(head, label="aside")
        elif (unit := _unit_in(cells, head, lines)) is not None:
            heads[index] = replace(head, unit=unit)
            columns[index] = [cell.removesuffix(unit).rstrip() for cell in cells]


def _are_units(head: Heading, cells: Sequence[str], left: Sequence[str]) -> bool:
    """Whether a column is one of units, by the last word of its title and each cell, of numbers on its ``left``."""
    if not {plain(head.title), plain(head.title).rpartition(" ")[2]} & UNITS:
        return False
    return any(cells) and any(map(is_number, left)) and all(unit_of(cell) is not None for cell in {*cells} - {""})


def _unit_in(cells: Sequence[str], head: Heading, lines: Sequence[int]) -> str | None:
    """Return the unit that stands behind every number of a column, as in 0.5 MPa."""
    # Where a machine wrote that there is no reading, no unit is due.
    first = next((cell for cell in cells if cell and not NO_READING.fullmatch(cell)), "")
    unit = unit_behind(first)
    whole = unit is not None and all(cell.endswith(unit) or not cell or NO_READING.fullmatch(cell) for cell in cells)
    if unit is None or (head.unit in (None, unit) and whole):
        return unit
    other = next((cell for cell in cells if unit_behind(cell) not in (None, unit)), None)
    if meaning(head) in (None, Meaning("aside")) or (other is None and head.unit in (None, unit)):
        return None
    raise _in_two_units(head, cells, lines, first, other)


def _in_two_units(head: Heading, cells: Sequence[str], lines: Sequence[int], one: str, other: str | None) -> InputError:
    """Return the error that a cell is in another unit than an ``other``, or than the head."""
    than = "the head" if other is None else f"{other} in line {lines[cells.index(other)]}"
    told, line = f"{one} is in another unit than {than}", lines[cells.index(one)]
    return InputError(told, line=line, column=head.title, remedy="export the column in one unit")
