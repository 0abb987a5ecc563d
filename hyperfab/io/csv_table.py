"""Simple tables with named columns: film coefficients, foam curves, schedules, thermocouples, markers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, wraps
from typing import ParamSpec

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import InputError
from hyperfab.io import headings
from hyperfab.io.cells import is_clock, is_number
from hyperfab.io.csv_dialect import open_sheets, the_one
from hyperfab.io.csv_numbers import beside_clock, other_unit, quantities, seconds, settle_decimal
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import fold, is_tensor, plain, reading
from hyperfab.io.headings import Heading, is_of, meaning, suffixed
from hyperfab.io.layout import PLAIN, Layout, filled_in
from hyperfab.io.long_log import a_column_each, called_by, moments, one_under_another
from hyperfab.io.side_by_side import specimens
from hyperfab.io.tables import Fits
from hyperfab.io.units import KINDS

#: What is done to the file where no option of the command says how it is to be read.
_IN_THE_FILE = {
    "columns": "correct the heads of its columns",
    "skip-rows": "part the file",
    "decimal": "write one number with four decimals, as 1.2500",
}
_P = ParamSpec("_P")
#: Beyond so many seconds (three years) a time counts from an epoch, as Unix's: from its first row then, as a clock.
_MOMENT = 1e8
_OPTION = re.compile(rf"--({'|'.join(_IN_THE_FILE)})\b")


@dataclass(frozen=True)
class Table:
    """Columns in the unit of their kind, the source line of each row, and the metadata of the file ``name``.

    ``aside`` are the columns with cells that nothing was taken from, and nobody set aside; ``cells`` is what they hold.
    ``option`` shows the option that says what columns are, beside those already given.
    """

    name: str
    columns: dict[str, Array]
    lines: Ints
    metadata: dict[str, str]
    left_out: Mapping[str, int] = field(default_factory=dict)
    aside: tuple[Heading, ...] = ()
    cells: tuple[Sequence[str], ...] = ()
    option: Callable[[Sequence[tuple[str, str]]], str] = filled_in

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def rows(self, kept: Ints) -> Table:
        """Return the table of some rows alone, in their order."""
        columns = {name: values[kept] for name, values in self.columns.items()}
        cells = tuple([column[row] for row in kept] for column in self.cells)
        return replace(self, columns=columns, lines=self.lines[kept], cells=cells)

    def without(self, gone: Flags, reason: str) -> Table:
        """Return the table less the rows (n,) that are ``gone``, counted under ``reason``."""
        counts = Counter(self.left_out) + Counter({reason: int(np.count_nonzero(gone))})
        return replace(self.rows(np.flatnonzero(~gone)), left_out=dict(counts)) if np.any(gone) else self

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
    data: bytes | CsvSheet,
    name: str,
    columns: Mapping[str, str],
    *,
    instead: Sequence[Mapping[str, str]] = (),
    optional: Mapping[str, str] | None = None,
    increasing: str | None = None,
    rest: str | None = None,
    called: Sequence[str] = (),
    gaps: bool = False,
    whole: bool = False,
    layout: Layout | None = None,
) -> Table:
    """Read the named ``columns`` of a CSV table: name to kind of quantity or unit (see ``hyperfab.io.units.KINDS``).

    Where one of them lacks, those of the first of ``instead`` that are all there are read in their place. A ``time``
    that no column is called is the first that tells a time of day in every row, with a date or without. ``optional``
    columns are read where present. ``increasing`` names a column whose values must rise from row to row, as those of
    a curve's argument do. ``rest`` is the kind of all other columns that carry a unit of that kind (thermocouples: one
    temperature column a probe); they are found under their labels, of which some are expected (``called``), and with
    ``gaps`` a cell of theirs may be empty: nan. Names are compared without case. What ``layout`` calls minus a quantity
    is turned round. With ``whole`` rows that lack a reading are left out and counted.

    Raises InputError with file, line and column.

    Of columns that ``layout`` calls power the sum is taken.

    >>> table = read_table(b"strain [-];stress [kPa]\\n0;0\\n0,5;12,5\\n", "foam.csv",
    ...                    {"strain": "dimensionless", "stress": "stress"}, increasing="strain")
    >>> table["stress"]
    array([0.    , 0.0125])
    """
    offered, named, layout = layout is not None, {**columns, **(optional or {})}, layout or PLAIN
    if isinstance(data, CsvSheet):
        sheet = data
    else:
        fits, sought = _expected([columns, *instead], optional or {}, rest, called)
        sheets = open_sheets(data, name, fits, layout, sought)
        sheet = (one_under_another(sheets, called) if len(sheets) > 1 else None) or the_one(sheets, name)
    sheet = a_column_each(sheet, called, rest) if rest is not None and gaps else sheet
    if not all(map(sheet.find, columns)):
        columns = next((one for one in instead if all(map(sheet.find, one))), columns)
        named = {**columns, **(optional or {})}
    wanted: dict[str, tuple[Heading, str]] = {}
    added: dict[str, list[Heading]] = {}  # what several heaters draw adds up
    for column, kind in ((column, _kind(one)) for column, one in named.items()):
        drawn = [one for one in sheet.headings if one.name == column and layout.choice(one, sheet.headings)]
        if kind == "power" and len(drawn) > 1:
            wanted[column], added[column] = (drawn[0], kind), drawn[1:]
            continue
        heading = sheet.find(column) or (moments(sheet) if kind == "time" and column in columns else None)
        if heading is None and column in columns:
            raise _missing(sheet, column, columns, offered)
        if heading is not None and (column in columns or _is_meant(heading, column, kind)):
            wanted[column] = (heading, kind)
    if rest is not None:
        taken = {heading.index for heading, _ in wanted.values()}
        for heading in _others(sheet, taken, rest):
            # Of what the command line says to be of that kind the title still tells whose it is.
            told = headings.heading(heading.title, heading.index) if heading.name == rest else heading
            label = called_by(told, called)
            if label.casefold() in map(str.casefold, wanted):
                raise sheet.wrong(
                    f"is {label}, as another column is",
                    heading,
                    remedy="say which probe each is, or leave one out: "
                    + sheet.option([(f"#{heading.index + 1}", "aside")]),
                )
            wanted[label] = (heading, rest)
        probes = {fold(one) for one in called}
        bare = [one for one in _unread(sheet, wanted) if one.unit is None and fold(one.name) in probes]
        if len(wanted) == len(taken) or bare:
            raise _none_of(sheet, rest, bare, named, len(wanted) > len(taken), called)
    _check_units(sheet, wanted)
    mark = settle_decimal(sheet, [heading for heading, _ in wanted.values()], layout.decimal)
    values = {
        column: seconds(sheet, heading)
        if kind == "time" and is_clock(sheet.columns[heading.index][0])
        else quantities(sheet, heading, kind, mark, whole or (gaps and column not in named), column)
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
    unread = tuple(suffixed(one) for one in _unread(sheet, wanted) if one not in (*dates, *more_of_one))
    cells = tuple(sheet.columns[one.index] for one in unread)
    table = Table(name, values, lines, metadata, sheet.left_out, unread, cells, sheet.option)
    lacking = np.any([np.isnan(one) for one in values.values()], axis=0) if whole and values else None
    return table if lacking is None else table.without(lacking, "lacking a reading")


def read_tables(
    data: bytes, name: str, columns: Mapping[str, str], *, along: str, optional: Mapping[str, str], layout: Layout
) -> list[Table]:
    """Read columns as ``read_table`` does, whole rows alone, of each specimen whose table stands under the others or
    beside them, with a way ``along`` of its own or one that all share; each is called after its title, or numbered."""
    fits, sought = _expected([columns], optional, None, ())
    parts = [part for one in open_sheets(data, name, fits, layout, sought) for part in specimens(one, ways=(along,))]
    labels = [entry.value if (entry := one.meta("specimen")) else one.label for one in parts]
    named = len({*labels} - {""}) == len(parts)
    told = [f"{name} {label if named else number}" for number, label in enumerate(labels, 1)]
    read = partial(read_table, columns=columns, optional=optional, whole=True, layout=layout)
    return [read(one, title) for one, title in zip(parts, told if len(parts) > 1 else [name], strict=True)]


def _expected(
    columns: Sequence[Mapping[str, str]], optional: Mapping[str, str], rest: str | None, called: Sequence[str]
) -> tuple[Fits, list[str]]:
    """Return what says of headings whether they name what is due, one of several sets of columns, and the headings of
    a table that could be read."""

    def fits(heads: Sequence[Heading]) -> bool:
        names = {one.name for one in heads} | {suffixed(one).name for one in heads}
        names |= {m.name for one in heads if (m := meaning(suffixed(one))) is not None and m.name not in names}
        names |= {told for one in heads if (told := reading(suffixed(one).label)) is not None}
        names |= {"time" for one in heads if plain(one.label) in ("date time", "datetime")}
        # Where none is due, a line of words above the table has none of them.
        return any(set(one) <= names for one in columns) and (bool(columns[0]) or len(names & {*optional}) > 1)

    sought = [_titled(column, kind) for column, kind in (columns[0] or dict([*optional.items()][:4])).items()]
    return fits, [*sought, *(_titled(one, rest) for one in called if rest)]


def _is_meant(heading: Heading, column: str, kind: str) -> bool:
    """Whether a column that need not be there is what it is called: by its name, or by words beside a unit of its
    ``kind``, or none where that has none: a Leistung in W is the power, one in per cent of a rating nobody knows."""
    called = column in (heading.name, suffixed(heading).name)
    return called or is_of(heading.unit or "-", kind)


def _check_units(sheet: CsvSheet, wanted: Mapping[str, tuple[Heading, str]]) -> None:
    """InputError where several columns lack the unit of their kind, with those that are likely for all of them."""
    bare = []
    for column, (heading, kind) in wanted.items():
        if heading.unit is None and KINDS[kind].unit != "1" and not is_clock(sheet.columns[heading.index][0]):
            if (odd := headings.unread_unit(heading)) is not None:
                raise other_unit(sheet, heading, odd, kind, column)
            bare.append((heading, f"{column} [{KINDS[kind].unit}]"))
    if len(bare) > 1:
        raise sheet.wrong(
            f"{', '.join(one.title for one, _ in bare)} have no unit",
            remedy=f'write it behind the name, as in "{bare[0][1]}", or say '
            + sheet.option([(one.title, told) for one, told in bare]),
        )


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
    free = [one for one in sheet.headings if one.unit is None and one.name not in ("", "aside", *asked)]
    free = [one for one in free if any(map(is_number, sheet.columns[one.index][:5]))]
    # 101 cup, Data.T_cup, cup C
    named = [(one.title, f"{probe} [{unit}]") for one in free for probe in called
             if f" {plain(probe)} " in f" {plain(one.title)} "]  # fmt: skip
    own = own or named or [(one.title, f"{probe} [{unit}]") for one, probe in zip(free, called[:1], strict=False)]
    unsaid = [one for one in sheet.headings if one.unit is None and one.name in asked]
    unsaid = [one for one in unsaid if not is_clock(sheet.columns[one.index][0])]
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
        and (is_of(one.unit, kind) if one.unit is not None else _may_be(one, kind))
        and any(map(is_number, sheet.columns[one.index][:5]))
    ]
    settles = ""
    if perhaps and offered:  # in its own unit, one that has one first
        bare, _, likely, said = min(perhaps)
        settles = f", or say which it is, as in {sheet.option([(likely, title if bare else said)])}"
    return sheet.wrong(f"has no column {column}; its columns are {heads}", remedy=f'name it "{title}"{settles}')


def _may_be(head: Heading, kind: str) -> bool:
    """Whether a column without a unit may be of a kind: unless its words say that it is another, or none."""
    if is_tensor(head.title):
        return kind in ("dimensionless", "stress")
    found = meaning(head)
    return found is None or (found.name != "aside" and headings.KIND.get(found.name, kind) == kind)


def _titled(column: str, asked: str) -> str:
    unit = KINDS[_kind(asked)].unit
    return f"{column} [{unit if unit != '1' else '-'}]"


def _check_increasing(sheet: CsvSheet, heading: Heading, values: Array) -> None:
    back = np.flatnonzero(np.diff(values) <= 0.0)
    if back.size:
        row = int(back[0]) + 1
        cells = ((one.title, sheet.columns[one.index]) for one in sheet.headings)
        anew = [title for title, own in cells if len({*own[:row]}) == 1 < row and own[row] != own[0]]
        raise sheet.wrong(
            f"{sheet.columns[heading.index][row]} does not follow {sheet.columns[heading.index][row - 1]}: "
            "the column must increase from row to row",
            heading,
            row=row,
            remedy=f"keep the rows of one {anew[0]}" if anew else "sort the rows, each value once",
        )
