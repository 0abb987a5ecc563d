"""Rows of cells to tables: where each head stands, and what is above it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby, takewhile

import numpy as np

from hyperfab.errors import InputError
from hyperfab.io.cells import NO_READING, is_clock, is_number, plain_values
from hyperfab.io.dictionary import is_closing, plain, setting, words
from hyperfab.io.heading_words import NAMES
from hyperfab.io.headings import Heading, heading, meaning, unit_behind, unit_of
from hyperfab.io.layout import Layout, named
from hyperfab.io.rows import Row
from hyperfab.io.settings import Entry, settings, tabled
from hyperfab.io.unit_table import parse_unit
from hyperfab.io.units import is_unit

#: Says of headings whether they make the table that is looked for.
Fits = Callable[[Sequence[Heading]], bool]

#: What a row of units is called in its first cell, below the head, or above it beside other rows that tell of channels.
UNITS = words(
    "unit; units; einheit; einheiten; unidad; unidades; unite; unites; unita; unidade; unit label; y unit label"
)
_BLANK_UNITS = frozenset(("", "-", "--", "#", "count", "counts", "text", "none", "n", "no", "[]", "()", "1")) | UNITS
#: How a unit that is none of ours may be written: V, Ohm, l/min, counts/s.
_FOREIGN = re.compile(r"[^\W\d_]{1,3}|\w{1,6}(?:[./*]\w{1,4})+")
#: How the cells of a clock or a date are written, in the place of its unit: hh:mm:ss, TT.MM.JJJJ, h:min:s.
_CLOCK = re.compile(r"(?:[dtjyahms]{1,4}|min)(?:[:./\- ](?:[dtjyahms]{1,4}|min|[0fx]{1,6}))+", re.IGNORECASE)
#: In so many rows above a head a logger tells of its channels.
_ABOVE = 60
#: What stands above one table of several is that one's own.
_OF_ONE = ("specimen", "cycle", "branch")
#: Below so many rows a table beside a long one is a summary of it.
_FEW = 12
#: More columns than these that have no names are cells of a sensor or a picture.
_SENSOR = 7
#: So many rows that begin alike are readings of one specimen.
_RUN = 3


@dataclass
class Block:
    """One table: the line of its head, its headings, its rows or, where they are plain throughout, its columns.

    ``over`` is the row above its head where that holds titles of several columns, ``head`` the rows of the head itself.
    """

    head_line: int
    headings: tuple[Heading, ...]
    rows: list[Row] = field(default_factory=list)
    metadata: dict[str, list[Entry]] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    words: list[str] = field(default_factory=list)
    columns: list[list[str]] | None = None
    lines: list[int] = field(default_factory=list)
    over: Row | None = None
    head: Sequence[Row] = ()


def is_data(cells: Sequence[str], named: bool = False) -> bool:
    """Whether a row holds readings: two numbers, or one and a time or a gap; no mean, unless one is ``named`` so."""
    numbers = sum(map(is_number, cells))
    if numbers == 1:
        numbers += sum(1 for cell in cells if cell and (is_clock(cell) or NO_READING.fullmatch(cell)))
    return numbers >= 2 and (named or not is_closing(next(filter(None, cells), "")))


def _is_amounts(cells: Sequence[str]) -> bool:
    """Whether a row holds numbers and nothing but their units behind them, as 12.5 N: readings, or titles."""
    filled = [cell for cell in cells if cell]
    if len(filled) > 2 and not is_number(filled[0]) and setting(filled[0]) is None:
        filled = filled[1:]  # the specimen's name
    return len(filled) > 1 and all(is_number(cell) or unit_behind(cell) is not None for cell in filled)


def of_specimens(rows: Sequence[Row]) -> frozenset[int]:
    """Return the rows that begin as closing ones do, as S or Max, row after row: a mean is one row, a specimen many.

    Two rows are a specimen under a name that one may have, beside another of two rows and no closing row.

    >>> sorted(of_specimens([(k, [name, "1", "2"]) for k, name in enumerate(["S", "S", "S", "Max", "Mean", "S"])]))
    [0, 1, 2]
    """
    found: set[int] = set()
    place = 0
    firsts = groupby(next(filter(None, cells), "") for _, cells in rows)
    runs = [("", 0), *((first, sum(1 for _ in run)) for first, run in firsts), ("", 0)]
    for before, (first, count), after in zip(runs, runs[1:], runs[2:], strict=False):
        pair = count == 2 in (before[1], after[1]) and all(
            plain(one) in words(NAMES) or not is_closing(one) for one in (before[0], first, after[0])
        )
        if (count >= _RUN or pair) and is_closing(first):
            found.update(range(place, place + count))
        place += count
    return frozenset(found)


def is_label(cells: Sequence[str]) -> bool:
    """Whether a row names the specimen whose readings follow, and nothing else: ``Specimen 2``, ``Probe;2``."""
    told = [cell for cell in cells if cell]
    return 0 < len(told) <= 2 and setting(" ".join(told).rstrip(":")) == "specimen"


def find(rows: Sequence[Row], fits: Fits, layout: Layout) -> list[Block]:
    """Return the tables among ``rows`` whose headings fit, each with what stands above it; empty where none does."""
    named = of_specimens(rows)
    data = [is_data(cells, k in named) for k, (_, cells) in enumerate(rows)]
    amounts = [not one and _is_amounts(cells) for one, (_, cells) in zip(data, rows, strict=True)]
    # Row after row: titles, as 10 mm/min over one specimen and 20 mm/min over the next, stand in one.
    data = [one or (amounts[k] and any(amounts[k - 1 : k] + amounts[k + 1 : k + 2])) for k, one in enumerate(data)]
    starts = [k for k in range(len(rows)) if data[k] and (k == 0 or not data[k - 1])]
    found: list[Block] = []
    heads: list[tuple[int, int]] = []  # first row of the head, first row of data
    for start in starts:
        head = _head(rows, data, start, fits, layout)
        if head is None and found and is_label(rows[start - 1][1]):  # the next specimen, under the same head
            head = start - 1, found[-1].headings
        if head is not None:
            first, headings = head
            heads.append((first, start))
            found.append(Block(rows[min(first, start)][0], headings, head=rows[first:start]))
    for number, (block, (first, start)) in enumerate(zip(found, heads, strict=True)):
        before = heads[number - 1][1] if number else 0
        above = [row for row, one in zip(rows[before:first], data[before:first], strict=True) if not one]
        block.metadata = {**tabled(rows[before:first]), **settings(above)}
        if above and above[-1] is rows[first - 1] and sum(map(bool, above[-1][1])) > 1:
            block.over = above[-1]
        end = heads[number + 1][0] if number + 1 < len(heads) else len(rows)
        while (
            number + 1 < len(heads) and not data[end - 1] and not is_closing(next(filter(None, rows[end - 1][1]), ""))
        ):
            end -= 1  # what stands above the next head belongs to it
        block.rows = list(rows[start:end])
    # What stands above the first table, and not again above another, holds for that too.
    for block in found[1:]:
        common = {key: told for key, told in found[0].metadata.items() if key not in _OF_ONE}
        block.metadata = {**common, **block.metadata}
    return found


def _head(
    rows: Sequence[Row], data: Sequence[bool], start: int, fits: Fits, layout: Layout
) -> tuple[int, tuple[Heading, ...]] | None:
    """Return where the head above row ``start`` begins and its headings: one row or two, and perhaps one of units."""
    width = max(len(cells) for _, cells in rows[start : start + 3])
    above: list[int] = []
    for k in range(start - 1, max(start - 6, -1), -1):
        if data[k]:
            break
        if any(rows[k][1]):
            above.append(k)
    of_channels = _units_of_channels([cells for _, cells in rows[max(start - _ABOVE, 0) : start]], width)
    options: list[tuple[tuple[bool, int, int, int, int], int, tuple[Heading, ...]]] = []
    for place in range(min(len(above), 3)):
        if is_recorders(told := rows[above[place]][1]) or (plain(told[0]) in UNITS and is_units(["", *told[1:]])):
            continue
        below = [k for k in above[:place] if is_units(rows[k][1])]
        for units in below or (None, *above[place + 1 : place + 2]):
            if units is not None and not is_units(rows[units][1]):
                continue
            for upper in (None, *above[place + 1 : place + 2]):
                if upper is not None and (upper == units or len(rows[upper][1]) < 2):
                    continue
                titles = _joined(rows, above[place], upper, width)
                made = headings(titles, layout)
                if units is not None:
                    made = with_units(made, rows[units][1])
                made = _with_missing(made, of_channels)
                known = sum(1 for one in made if (m := meaning(one)) is not None and m.name != "aside")
                units_known = sum(1 for one in made if one.unit is not None)
                cost = place + 2 * (upper is not None)
                first = min(k for k in (above[place], units, upper) if k is not None)
                apart = len({*titles}) if units_known > 1 > known else 0  # Min, Max under the name of each channel
                options.append(((fits(made), known, units_known, apart, -cost), first, made))
    fitting = [option for option in options if option[0][0]]
    if not fitting and layout.columns:  # by number, where no line names the columns
        blank = [Heading("", "", None, index) for index in range(width)]
        chosen = [layout.choice(one, blank) for one in blank]
        made = tuple(one if c is None else named(c, one) for one, c in zip(blank, chosen, strict=True))
        return (start, made) if fits(made) else None
    if not fitting:
        return None
    _, first, made = max(fitting, key=lambda option: option[0])
    return first, made


def _units_of_channels(above: Sequence[Sequence[str]], width: int) -> list[str]:
    """Return the units (width,) of the last row above a table that is called so, each over its column: loggers tell
    sensor, range and unit of their channels there; empty cells where there is none.

    >>> _units_of_channels([["Unit", "", "degF"], ["Sensor", "", "K"], ["Date", "Time", "CH1"]], 3)
    ['', '', 'degF']
    """
    for cells in reversed(above):
        if cells and len(cells) <= width and plain(cells[0]) in UNITS and is_units(told := ["", *cells[1:]]):
            return [*told, *[""] * (width - len(told))]
    return [""] * width


def refuse_grid(rows: Sequence[Row], sought: Sequence[str]) -> None:
    """InputError where readings stand in a grid: under one coordinate and beside the other, or cell by cell as those of
    a sensor or a picture."""
    at_places = "x [mm]" in sought
    for start, (line, cells) in enumerate(rows):
        width = len(cells)
        if width < 3 or not is_data(cells) or (start and sum(map(bool, rows[start - 1][1])) > width // 2):
            continue  # columns have names there
        sized = (len(one) == width and all(map(is_number, one)) and one for _, one in rows[start + 1 :])
        below = [one for one in takewhile(bool, sized) if one]
        over, beside = plain_values(cells[1:]), plain_values([one[0] for one in below])
        if len(below) < 2:
            continue
        placed = at_places and len(over) == width - 1 and _goes_one_way(over) and _goes_one_way(beside)
        if placed or (width > max(_SENSOR, len(sought)) and not _goes_one_way([*plain_values(cells[:1]), *beside])):
            raise InputError(
                "is a grid of readings, "
                + ("one coordinate above and one beside it" if placed else "cell beside cell"),
                line=line,
                remedy=f'write a row for each {"place" if at_places else "reading"}: "{",".join(sought)}"',
            )


def _goes_one_way(values: Sequence[float]) -> bool:
    steps = np.diff(values)
    return len(steps) > 0 and bool(np.all(steps > 0.0) or np.all(steps < 0.0))


def transposed(rows: Sequence[Row]) -> list[Row]:
    """Return rows as columns, where each begins with a title, perhaps a unit, and numbers follow; else nothing."""
    taken = []
    for line, cells in rows:
        numbers = [cell for cell in cells[1:] if is_number(cell)]
        if len(numbers) >= 3 and cells[0] and not is_number(cells[0]):
            unit = unit_of(cells[1].strip("[](){} ")) if not is_number(cells[1]) else None
            taken.append((line, f"{cells[0]} [{unit}]" if unit else cells[0], cells[2 if unit else 1 :]))
    if len(taken) < 2:
        return []
    width = max(len(cells) for _, _, cells in taken)
    line = taken[0][0]
    columns = [[*cells, *[""] * (width - len(cells))] for _, _, cells in taken]
    return [
        (line, [title for _, title, _ in taken]),
        *((line, list(cells)) for cells in zip(*columns, strict=True)),
    ]


def _joined(rows: Sequence[Row], place: int, upper: int | None, width: int) -> list[str]:
    """Return the titles of a head, of two rows where one stands over the other (merged cells reach to the next)."""
    lower = [*rows[place][1], *[""] * width][: max(width, len(rows[place][1]))]
    if upper is None:
        return lower
    over, last = [], ""
    for cell, below in zip([*rows[upper][1], *[""] * len(lower)], lower, strict=False):
        last = cell or last
        over.append(last if below else cell)  # the comma that ends a line makes no column
    return [f"{one} {two}".strip() for one, two in zip(over, lower, strict=True)]


def headings(titles: Sequence[str], layout: Layout) -> tuple[Heading, ...]:
    """Return the headings of titles, those that ``--columns`` names under the names it gives."""
    trimmed = len(titles)
    while trimmed and not titles[trimmed - 1]:
        trimmed -= 1
    cleaned = [
        re.sub(r"^(?:%|//|!|\*|#)\s*", "", title) if k == 0 else title for k, title in enumerate(titles[:trimmed])
    ]
    made = [heading(title, index) for index, title in enumerate(cleaned)]
    chosen = [layout.choice(one, made) for one in made] if layout.columns else [None] * len(made)
    return tuple(one if choice is None else named(choice, one) for one, choice in zip(made, chosen, strict=True))


def is_recorders(cells: Sequence[str]) -> bool:
    """Whether a row of units is a recorder's, which says again in it what has none: ``NO., Time, ms, degC, A123``."""
    return len(cells) > 2 and plain(cells[0]) == "no" and sum(unit_of(cell) is not None for cell in cells[1:]) > 1


def is_units(cells: Sequence[str]) -> bool:
    """Whether a row below a head holds units: each cell one or empty, at least one real.

    A channel beside them may be in a unit that is none of ours, a word no column is called, and a clock's may say how
    its cells are written.

    >>> is_units(["hh:mm:ss", "degC"]), is_units(["hh:mm:ss", "plate"]), is_units(["NO.", "Time", "ms", "degC"])
    (True, False, True)
    """
    if is_recorders(cells):
        cells = [cell if unit_of(cell) else "" for cell in cells]
    bare = ["" if _is_clock(cell) else cell for cell in _bare(cells)]
    if any(is_number(cell) for cell in bare) and not any(unit_of(cell) for cell in bare if not is_number(cell)):
        return False
    if any(is_number(cell) and cell != "1" for cell in bare):
        return False
    units = [unit_of(cell) for cell in bare]
    real = sum(
        1 for cell, unit in zip(bare, units, strict=True) if unit is not None and cell.casefold() not in _BLANK_UNITS
    )
    odd = [
        cell for cell, unit, whole in zip(bare, units, cells, strict=True)
        if unit is None and cell.casefold() not in _BLANK_UNITS and whole[:1] not in "[({<"
    ]  # fmt: skip
    foreign = all(_FOREIGN.fullmatch(cell) and meaning(heading(cell, 0)) is None for cell in odd)
    return (not odd or (foreign and len(odd) <= real)) and (
        real > 0 or (any(cells) and all(cell.strip() in ("-", "[-]", "(-)", "", "[]") for cell in cells))
    )


def with_units(heads: Sequence[Heading], cells: Sequence[str], line: int = 0) -> tuple[Heading, ...]:
    """Return headings with the units of a row of their own; where it gainsays the head both stand, to be refused.

    InputError at once where the ``line`` is given.
    """
    found = []
    for one, cell in zip(heads, [*cells, *[""] * len(heads)][: len(heads)], strict=True):
        [bare] = _bare([cell])
        unit = unit_of(bare) or (
            bare if bare.casefold() not in _BLANK_UNITS else "-" if bare in ("-", "--", "1") else None
        )
        if _is_clock(bare):  # of two parts 12:30 it tells which come first
            unit = "h" if re.fullmatch("hh?.(?:mm?|min)", bare.casefold()) else "min" if bare[0] in "mM" else None
        gainsaid = one.unit not in (None, "-") and unit is not None and not _are_same(str(one.unit), unit)
        if line and gainsaid:
            raise InputError(
                f"the unit is {unit} here and {one.unit} in the header",
                line=line,
                column=one.title,
                remedy="keep one of them",
            )
        told = f"{one.unit} or {unit}" if gainsaid and unit != "-" else one.unit or unit  # which is no unit
        found.append(Heading(one.title, one.label, told, one.index))
    return tuple(found)


def with_units_above(heads: tuple[Heading, ...], above: Sequence[Sequence[str]]) -> tuple[Heading, ...]:
    """Return headings, those without a unit with that of the row of units among what stands ``above``, if any."""
    return _with_missing(heads, _units_of_channels(above, len(heads)))


def _with_missing(heads: tuple[Heading, ...], units: Sequence[str]) -> tuple[Heading, ...]:
    return with_units(heads, ["" if one.unit else cell for one, cell in zip(heads, units, strict=False)])


def _bare(cells: Sequence[str]) -> list[str]:
    return [cell.strip("[](){}<> ") for cell in cells]


def _is_clock(cell: str) -> bool:
    return _CLOCK.fullmatch(cell) is not None and unit_of(cell) is None


def _are_same(one: str, two: str) -> bool:
    """Whether two units are one, as MPa and N/mm^2."""
    return one == two or (is_unit(one) and is_unit(two) and parse_unit(one) == parse_unit(two))


def understood(blocks: Sequence[Block]) -> list[Block]:
    """Return the tables that belong together: stacked specimens, or the long one beside its summaries.

    Raises InputError where several could be meant.
    """
    if len(blocks) < 2:
        return list(blocks)
    titles = {tuple(plain(one.title) for one in block.headings) for block in blocks}
    if len(titles) == 1:
        return list(blocks)
    size = max(len(block.rows) for block in blocks)
    long = [block for block in blocks if len(block.rows) * 5 >= size or len(block.rows) > _FEW]
    if len({tuple(plain(one.title) for one in block.headings) for block in long}) == 1:
        return long
    lines = " and ".join(str(block.head_line) for block in long[:4])
    raise InputError(
        f"has tables of different columns, in lines {lines}",
        line=long[1].head_line,
        remedy=f"say which: --skip-rows {long[0].head_line - 1} takes the first of them alone"
        if len(long) == 1
        else f"take the last with --skip-rows {long[-1].head_line - 1}, or part the file",
    )


def best(options: Iterator[tuple[str, list[Block]]]) -> tuple[str, list[Block]] | None:
    """Return the separator whose tables hold the most readings, the first of those that hold as many."""
    found: tuple[str, list[Block]] | None = None
    size = 0
    for separator, blocks in options:
        count = sum(len(block.rows) for block in blocks)
        if count > size:
            found, size = (separator, blocks), count
    return found
