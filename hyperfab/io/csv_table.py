"""Simple tables with named columns: film coefficients, foam curves, schedules, thermocouples, markers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import ParamSpec

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import InputError
from hyperfab.io import headings
from hyperfab.io.cells import is_clock, is_number
from hyperfab.io.csv_dialect import open_sheet
from hyperfab.io.csv_numbers import beside_clock, quantities, seconds, settle_decimal
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import BRACKETS, Meaning, fold, plain, reading
from hyperfab.io.headings import Heading, is_of, meaning, suffixed
from hyperfab.io.layout import PLAIN, Layout
from hyperfab.io.units import KINDS

#: What is done to the file where no option of the command says how it is to be read.
_IN_THE_FILE = {
    "columns": "correct the heads of its columns",
    "skip-rows": "part the file",
    "decimal": "write one number with four decimals, as 1.2500",
}
_P = ParamSpec("_P")
#: How a logger makes one value of those it read since the last.
_ONE_VALUE = re.compile(r"[ _.](?:ave|avg|average|mean|last|mittel|mittelwert)\.?$", re.IGNORECASE)
#: What reads a probe, with its number, before the name: 101 cup, PT100_cup, TC3 cup; and what names one in brackets.
_READ_BY = re.compile(
    r"^(?:(?:ch|tc|pt|ai|t|temp|rtd|thermocouple|sensor|probe|channel|kanal)\.?[ _]?)?\d{0,4}[ _:.-]+", re.I
)
_NAMED = re.compile(r"(?:^|, *)(?:lbl|label|name|tag) *[:=] *([^,]+)", re.IGNORECASE)
#: Beyond so many seconds (three years) a time counts from an epoch, as Unix's: from its first row then, as a clock.
_MOMENT = 1e8
_OPTION = re.compile(rf"--({'|'.join(_IN_THE_FILE)})\b")


@dataclass(frozen=True)
class Table:
    """Columns in the unit of their kind, the source line of each row, and the metadata of the file ``name``.

    ``aside`` are the titles of the columns with cells that nothing was taken from, and nobody set aside; ``shares``
    those of them in per cent.
    """

    name: str
    columns: dict[str, Array]
    lines: Ints
    metadata: dict[str, str]
    left_out: Mapping[str, int] = field(default_factory=dict)
    aside: tuple[str, ...] = ()
    shares: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def refuse(self, wrong: Flags, why: str, *, column: str, remedy: str) -> None:
        """Raise InputError at the first row that is ``wrong`` (n,), if any is; ``{:g}`` in ``why`` is its value."""
        for row in np.flatnonzero(wrong)[:1]:
            said = why.format(self.columns[column][row]) if column in self else why
            raise InputError(said, file=self.name, line=int(self.lines[row]), column=column, remedy=remedy)


def _in_the_file(read: Callable[_P, Table]) -> Callable[_P, Table]:
    """Let errors show a way out in the file where no ``layout`` is given: of a table that a document names, no option
    says how it is to be read."""

    @wraps(read)
    def without_options(*given: _P.args, **named: _P.kwargs) -> Table:
        try:
            return read(*given, **named)
        except InputError as error:
            option = _OPTION.search(error.remedy or "")
            if named.get("layout") is not None or error.remedy is None or option is None:
                raise
            words, otherwise, _ = error.remedy[: option.start()].partition(", or say ")
            remedy = words if otherwise else _IN_THE_FILE[option[1]]
            raise InputError(
                error.message, file=error.file, line=error.line, column=error.column, remedy=remedy
            ) from None

    return without_options


@_in_the_file
def read_table(
    data: bytes,
    name: str,
    columns: Mapping[str, str],
    *,
    optional: Mapping[str, str] | None = None,
    increasing: str | None = None,
    rest: str | None = None,
    called: Sequence[str] = (),
    gaps: bool = False,
    layout: Layout | None = None,
) -> Table:
    """Read the named ``columns`` of a CSV table: name to kind of quantity or unit (see ``hyperfab.io.units.KINDS``).

    A ``time`` that no column is called is the first that tells a time of day in every row, with a date or without.
    ``optional`` columns are read where present. ``increasing`` names a column whose values must rise from row to
    row, as the argument of a curve does. ``rest`` is the kind of all other columns that carry a unit of that kind
    (thermocouples: one temperature column a probe); they are found under their labels, of which some are expected
    (``called``), and with ``gaps`` a cell of theirs may be empty: nan. Names are compared without case. What ``layout``
    calls minus a quantity is turned round.

    Raises InputError with file, line and column.

    Of columns that ``layout`` calls power the sum is taken.

    >>> table = read_table(b"strain [-];stress [kPa]\\n0;0\\n0,5;12,5\\n", "foam.csv",
    ...                    {"strain": "dimensionless", "stress": "stress"}, increasing="strain")
    >>> table["stress"]
    array([0.    , 0.0125])
    """

    def fits(heads: Sequence[Heading]) -> bool:
        names = {one.name for one in heads} | {suffixed(one).name for one in heads}
        names |= {m.name for one in heads if (m := meaning(suffixed(one))) is not None and m.name not in names}
        names |= {told for one in heads if (told := reading(suffixed(one).label)) is not None}
        names |= {"time" for one in heads if plain(one.label) in ("date time", "datetime")}
        # Where none is due, a line of words above the table has none of them.
        return set(columns) <= names and (bool(columns) or len(names & {*(optional or {})}) > 1)

    offered = layout is not None
    layout = layout or PLAIN
    sought = [_titled(column, kind) for column, kind in (columns or dict([*(optional or {}).items()][:4])).items()]
    sheet = open_sheet(data, name, layout, fits, [*sought, *(_titled(one, rest) for one in called if rest)])
    sheet = _a_column_each(sheet, called, rest) if rest is not None and gaps else sheet
    wanted: dict[str, tuple[Heading, str]] = {}
    added: dict[str, list[Heading]] = {}  # what several heaters draw adds up
    for column, asked in {**columns, **(optional or {})}.items():
        kind = _kind(asked)
        drawn = [one for one in sheet.headings if one.name == column and layout.choice(one, sheet.headings)]
        if kind == "power" and len(drawn) > 1:
            wanted[column], added[column] = (drawn[0], kind), drawn[1:]
            continue
        heading = sheet.find(column) or (_moments(sheet) if kind == "time" and column in columns else None)
        if heading is None and column in columns:
            raise _missing(sheet, column, columns, offered)
        if heading is not None and (column in columns or _is_meant(heading, column, kind)):
            wanted[column] = (heading, kind)
    if rest is not None:
        taken = {heading.index for heading, _ in wanted.values()}
        for heading in _others(sheet, taken, rest):
            # Of what the command line says to be of that kind the title still tells whose it is.
            told = headings.heading(heading.title, heading.index) if heading.name == rest else heading
            label = _called_by(told, called)
            if label.casefold() in map(str.casefold, wanted):
                raise sheet.wrong(
                    f"is {label}, as another column is",
                    heading,
                    remedy="name one for another, or leave one out with =aside",
                )
            wanted[label] = (heading, rest)
        probes = {fold(one) for one in called}
        bare = [one for one in _unread(sheet, wanted) if one.unit is None and fold(one.name) in probes]
        if len(wanted) == len(taken) or bare:
            raise _none_of(sheet, rest, bare, {**columns, **(optional or {})}, len(wanted) > len(taken), called)
    _check_units(sheet, wanted)
    mark = settle_decimal(sheet, [heading for heading, _ in wanted.values()], layout.decimal)
    named = {**columns, **(optional or {})}
    values = {
        column: seconds(sheet, heading)
        if kind == "time" and is_clock(sheet.columns[heading.index][0])
        else quantities(sheet, heading, kind, mark, gaps and column not in named, column)
        for column, (heading, kind) in wanted.items()
    }
    for column, (heading, _) in wanted.items():
        choice = layout.choice(heading, sheet.headings)
        if choice is not None and choice.minus:
            values[column] = -values[column]
    for column, (_, kind) in wanted.items():
        if kind == "power":
            more = added.get(column, ())
            values[column] = values[column] + sum(quantities(sheet, one, kind, mark, name=column) for one in more)
        elif kind == "time" and len(values[column]) and abs(values[column][0]) > _MOMENT:
            values[column] = values[column] - values[column][0]
    if increasing is not None:
        _check_increasing(sheet, wanted[increasing][0], values[increasing])
    metadata = {key: entries[0].value for key, entries in sheet.metadata.items()}
    lines = np.array(sheet.lines, dtype=np.int64)
    clocks = [heading for heading, kind in wanted.values() if kind == "time"]
    dates = [one for head in clocks if (one := beside_clock(sheet, head)) is not None]
    more_of_one = [one for several in added.values() for one in several]
    unread = [one for one in _unread(sheet, wanted) if one not in (*dates, *more_of_one)]
    shares = tuple(one.title for one in unread if one.unit == "%")
    return Table(name, values, lines, metadata, sheet.left_out, tuple(one.title for one in unread), shares)


def _a_column_each(sheet: CsvSheet, called: Sequence[str], rest: str) -> CsvSheet:
    """Return a log with a row for each reading, whose probe a column names, as one with a column for each probe."""
    clock = sheet.find("time") or _moments(sheet)
    known = {fold(one): one for one in called}
    cells = {one.index: {*map(fold, sheet.columns[one.index])} for one in sheet.headings}
    told = [one for one in sheet.headings if len(cells[one.index] & {*known}) > 1]
    read = [one for one in map(suffixed, sheet.headings) if one.unit is not None and is_of(one.unit, rest)]
    if clock is None or len(told) != 1 or len(read) != 1 or read[0].index == told[0].index:
        return sheet
    names = {one: probe for one, probe in known.items() if one in cells[told[0].index]}
    rows: dict[str, dict[str, str]] = {}
    first: list[int] = []
    beside = (sheet.columns[one.index] for one in (clock, told[0], read[0]))
    for line, time, probe, cell in zip(sheet.lines, *beside, strict=True):
        first += [] if time in rows else [line]
        there = rows.setdefault(time, {})
        if fold(probe) not in names or fold(probe) in there:
            return sheet  # one that nobody knows, or read twice at once
        there[fold(probe)] = cell
    heads = [
        replace(clock, index=0),
        *(Heading(names[one], names[one], read[0].unit, k + 1) for k, one in enumerate(names)),
    ]
    columns = ([*rows], *([there.get(one, "") for there in rows.values()] for one in names))
    return replace(sheet, headings=tuple(heads), columns=columns, lines=first)


def _called_by(head: Heading, called: Sequence[str]) -> str:
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


def _is_meant(heading: Heading, column: str, kind: str) -> bool:
    """Whether a column that need not be there is what it is called: by its name, or by words beside a unit of its
    ``kind``: a Leistung in W is the power, one in per cent of a rating nobody knows."""
    called = column in (heading.name, suffixed(heading).name)
    return called or (heading.unit is not None and is_of(heading.unit, kind))


def _check_units(sheet: CsvSheet, wanted: Mapping[str, tuple[Heading, str]]) -> None:
    """InputError where several columns lack the unit of their kind, with those that are likely for all of them."""
    bare = [
        (heading, f"{column} [{KINDS[kind].unit}]")
        for column, (heading, kind) in wanted.items()
        if heading.unit is None and KINDS[kind].unit != "1" and not is_clock(sheet.columns[heading.index][0])
    ]
    if len(bare) > 1:
        raise sheet.wrong(
            f"{', '.join(one.title for one, _ in bare)} have no unit",
            remedy=f'write it behind the name, as in "{bare[0][1]}", or say '
            + sheet.option([(one.title, told) for one, told in bare]),
        )


def _moments(sheet: CsvSheet) -> Heading | None:
    """Return the first column that tells a time of day in every row, whatever it is called: a logger's clock."""
    for one in sheet.headings:
        cells = sheet.columns[one.index]
        if one.name != "aside" and cells and all(re.search(r"\d ?[:hm]", cell) and is_clock(cell) for cell in cells):
            return one
    return None


def _unread(sheet: CsvSheet, wanted: Mapping[str, tuple[Heading, str]]) -> list[Heading]:
    """Return the columns with cells that nothing is taken from, and nobody set aside."""
    taken = {heading.index for heading, _ in wanted.values()}
    heads = [one for one in sheet.headings if one.index not in taken and one.name not in ("", "aside")]
    return [one for one in heads if any(sheet.columns[one.index])]


def _kind(asked: str) -> str:
    """Return the kind for a kind or a canonical unit: ``MPa`` is a stress."""
    if asked in KINDS:
        return asked
    by_unit = {"-": "dimensionless", **{kind.unit: kind.name for kind in reversed(KINDS.values())}}
    return by_unit[asked]


def _others(sheet: CsvSheet, taken: set[int], kind: str) -> Sequence[Heading]:
    found = []
    for heading in sheet.headings:
        if heading.index in taken or heading.name in ("", "aside"):
            continue
        resolved = suffixed(heading)
        if is_of(resolved.unit or "-", kind):
            found.append(resolved)
    return found


def _none_of(
    sheet: CsvSheet, rest: str, bare: Sequence[Heading], asked: Mapping[str, str], some: bool, called: Sequence[str]
) -> InputError:
    """Return the error that no column is of a kind, or, where ``some`` are, that those called as expected are ``bare``
    of a unit: with their unit filled in."""
    unit = KINDS[rest].unit
    own = [(one.title, f"{rest} [{unit}]") for one in bare]
    own += [
        (one.title, f"{probe} [{unit}]") for one in sheet.headings for probe in called
        if one.unit is None and fold(one.title) in (f"{fold(probe)} c", f"{fold(probe)} degc")
    ]  # fmt: skip
    unsaid = [one for one in sheet.headings if one.unit is None and one.name in asked]
    others = [(one.title, f"{one.name} [{KINDS[_kind(asked[one.name])].unit}]") for one in unsaid]
    return sheet.wrong(
        f"has no column of a {rest}" if not some else f"{own[0][0]} has no unit of a {rest}, which others have",
        remedy=f"say {sheet.option([*others, *own])}" if own else f'name one a probe, as in "T1 [{unit}]"',
    )


def _missing(sheet: CsvSheet, column: str, columns: Mapping[str, str], offered: bool) -> InputError:
    """Return the error that a column lacks; with the option that says which it is, where the command has that."""
    heads = ", ".join(heading.title or '""' for heading in sheet.headings[:8])
    kind, title = _kind(columns[column]), _titled(column, columns[column])
    perhaps = [
        (one.unit is None, one.index, one.title.strip() or f"#{one.index + 1}", f"{column} [{one.unit}]")
        for one in sheet.headings
        if one.name not in columns
        and (is_of(one.unit, kind) if one.unit is not None else meaning(one) != Meaning("aside"))
        and any(map(is_number, sheet.columns[one.index][:5]))
    ]
    settles = ""
    if perhaps and offered:  # in its own unit, one that has one first
        bare, _, likely, said = min(perhaps)
        settles = f", or say which it is, as in {sheet.option([(likely, title if bare else said)])}"
    return sheet.wrong(f"has no column {column}; its columns are {heads}", remedy=f'name it "{title}"{settles}')


def _titled(column: str, asked: str) -> str:
    unit = KINDS[_kind(asked)].unit
    return f"{column} [{unit if unit != '1' else '-'}]"


def _check_increasing(sheet: CsvSheet, heading: Heading, values: Array) -> None:
    back = np.flatnonzero(np.diff(values) <= 0.0)
    if back.size:
        row = int(back[0]) + 1
        raise sheet.wrong(
            f"{sheet.columns[heading.index][row]} does not follow {sheet.columns[heading.index][row - 1]}: "
            "the column must increase from row to row",
            heading,
            row=row,
            remedy="sort the rows, each value once",
        )
