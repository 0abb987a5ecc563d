"""Fabric tests as testing machines export them, read into stretch and nominal stress."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hyperfab.arrays import Ints
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError, placed
from hyperfab.io.cells import NO_READING, is_number
from hyperfab.io.csv_dialect import open_sheets
from hyperfab.io.csv_numbers import numbers
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.headings import is_gauged, is_on_specimen
from hyperfab.io.impossible import refuse_impossible
from hyperfab.io.kinds_of_tests import TESTS, names_of, said, tests_of_rows
from hyperfab.io.layout import PLAIN, Choice, Layout
from hyperfab.io.loading import Loading, read_loading
from hyperfab.io.named_tests import kind_named
from hyperfab.io.other_tests import READINGS, RESULTS, is_result
from hyperfab.io.phases import in_one
from hyperfab.io.role_words import no_test, understood
from hyperfab.io.roles import STRESSES, STRETCHES, Roles, fits, roles, with_names
from hyperfab.io.row_states import directions, held_down, of_each_row, words_or_stated
from hyperfab.io.side_by_side import may_be_specimens, specimens
from hyperfab.io.sizes_of_rows import of_own_rows, parted_by_sizes
from hyperfab.io.specimen import Geometry, read_specimen
from hyperfab.io.stated import stated

#: Rows that tell how far two readings are apart, and how many times that the first may be.
_SHORT, _STALE = 10, 5.0
#: A stress of fewer different values than this share of those of the force beside it was rounded.
_ROUNDED = 0.25
#: A way of which this share leads from end to end does not turn.
_ONE_WAY = 0.8


@dataclass(frozen=True)
class TestData(TestCurve):
    """A measured curve with what its file tells beside: every row, in the file's order.

    ``understood`` says in a line how the file was read, ``chosen`` which columns that was told of, ``left_out`` counts
    rows by the reason for which they were left out. ``area_mm2`` or ``diameter_mm`` is the section where so stated.
    """

    lines: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    understood: str = ""
    chosen: tuple[Choice, ...] = ()
    left_out: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    area_mm2: float | None = None
    diameter_mm: float | None = None


def read_tests(
    data: bytes,
    name: str,
    *,
    test: str | None = None,
    geometry: Geometry | None = None,
    columns: Layout | None = None,
    clock: bool = True,
) -> list[TestData]:
    """Read the tests of one file: one TestData a test, direction and specimen, in the order of the file.

    ``test`` is what the command line says the file is; a file that says otherwise is refused. ``geometry`` holds
    the specimen's sizes given as options, which take precedence over the file's own, ``columns`` how its table is to be
    read. Every row with a reading is kept; ``left_out`` counts the others by reason. Without ``clock`` the times
    are not used, and not judged.

    Raises InputError with file, line and column where the file cannot be understood in exactly one way, or tells
    what no test can have shown.

    >>> [found] = read_tests(b"# test: shear\\nstrain [%],stress [kPa]\\n10,120\\n20,210\\n", "shear.csv")
    >>> found.mode, found.stretch, found.stress
    ('shear', array([1.1, 1.2]), array([0.12, 0.21]))
    """
    told = columns or PLAIN
    found: list[TestData] = []
    sheets = []
    for sheet in open_sheets(data, name, fits, told):
        with placed(sheet.name):
            kind = said(sheet, test) or next(
                (one for one in map(kind_named, names_of(name)) if one == "uniaxial"), None
            )
            parts = specimens(sheet, one_axis=kind is not None and not kind.startswith("biaxial"))
            if kind is None and len(parts) == 1 and may_be_specimens(sheet):
                raise no_test(sheet, TESTS)
            sheets += [one for part in parts for one in parted_by_sizes(part)]
    sheets = of_own_rows(sheets)
    sheets = in_one(sheets, told.decimal) if len(sheets) > 1 else sheets
    names = {entry.value if (entry := stated(sheet, "specimen")) else "" for sheet in sheets}
    for number, sheet in enumerate(sheets, 1):
        label = sheet.label or (str(number) if len(sheets) > 1 else "")
        label = f"{next(iter(names))} {label}".strip() if len(sheets) > len(names) == 1 else label  # of one sample
        with placed(sheet.name):
            found += _read_sheet(sheet, test, geometry or Geometry(), told.decimal, clock, label)
    if sum(len(part.stretch) for part in found) < 2:
        raise InputError(
            "has one row, a curve needs at least two",
            file=name,
            line=sheets[0].lines[0] if sheets[0].lines else None,
            remedy="export the whole test",
        )
    results = any(is_result(one.label) for one in sheets[0].headings)
    if results and all(len(part.stretch) == 1 and part.specimen for part in found):
        raise InputError(f"has {RESULTS}", file=name, line=sheets[0].lines[0], remedy=READINGS)
    return found


def _read_sheet(
    sheet: CsvSheet, test: str | None, geometry: Geometry, decimal: str | None, clock: bool, label: str
) -> list[TestData]:
    columns = roles(sheet)
    sheet = _with_readings(sheet, columns)
    if not sheet.lines:
        raise sheet.wrong("has no row with readings", remedy="export the readings too")
    mark = columns.decimal_mark(sheet, decimal)
    sheet = _without_stale_row(sheet, columns, mark)
    notes: list[str] = []
    columns = with_names(sheet, columns, mark, notes)
    kinds, pressed = tests_of_rows(sheet, columns, test)
    strip = read_specimen(sheet, geometry, mark, notes)
    sizes = strip.sizes
    ways = directions(sheet, columns)
    named = held_down(words_or_stated(sheet, columns, "specimen"))
    own = [one for one in dict.fromkeys(named) if one]
    numbered = [label] * len(sheet.lines) if label and all(label.startswith(f"{one} ") for one in own) else named
    groups = _groups(kinds, ways, numbered)
    loadings = {kind: read_loading(strip, columns, kind, pressed) for kind in sorted({one for one, _, _ in groups})}
    known: dict[str, Any] = of_each_row(sheet, columns, sizes, mark, clock, notes)
    metadata = {key: entries[0].value for key, entries in sheet.metadata.items()}
    lines = np.array(sheet.lines, dtype=np.int64)
    gauge = stated(sheet, "gauge")
    marked = gauge is not None and is_on_specimen(gauge.value)
    aside = [*columns.aside, *_set_aside(columns, loadings.values())]
    if aside:
        notes.append(f"columns not used: {', '.join(aside[:12])}")
    notes += _coarser(sheet, columns, loadings.values())
    found = []
    for (kind, direction, specimen), rows in groups.items():
        loading = loadings[kind]
        curve = replace(loading.curve, lines=lines, **known).take(rows)
        turned: tuple[str, ...] = ()
        if _is_table_from_its_end(curve):
            curve = curve.take(slice(None, None, -1))
            turned = ("a table from its longest stretch through rest, without a time: read from its other end",)
        part = TestData(
            **{
                **vars(curve),
                "source": sheet.name,
                "direction": direction,
                "specimen": specimen,
                "thickness_mm": sizes.thickness,
                "width_mm": sizes.width,
                "gauge_length_mm": sizes.gauge_length,
                "aspect": sizes.aspect if loading.extended else None,
                "on_specimen": is_gauged(loading.used[0].heading) or marked,
            },
            left_out=sheet.left_out,
            notes=(*loading.notes, *turned, *notes),
            metadata=metadata,
            area_mm2=sizes.area,
            diameter_mm=sizes.diameter,
        )
        odd = refuse_impossible(part, sheet, columns, clock)
        found.append(replace(part, notes=(*part.notes, *odd)))
    rows_of = [
        one for name, one in columns.columns.items() if name in _OF_A_ROW and known.get(_OF_A_ROW[name]) is not None
    ]
    used = [column for loading in loadings.values() for column in loading.used]
    line = understood(sheet, [*used, *rows_of])
    chosen = tuple(one for head in sheet.headings if (one := sheet.layout.choice(head, sheet.headings)) is not None)
    return [replace(part, understood=line, chosen=chosen) for part in found]


def _is_table_from_its_end(curve: TestCurve) -> bool:
    """Whether rows fall through rest, once, with no word of when they were read: no test begins where it is stretched
    most."""
    if curve.mode == "biaxial-general" or any(one is not None for one in (curve.time_s, curve.branch, curve.cycle)):
        return False
    way = curve.principal
    falls = way[0] - way[-1] > _ONE_WAY * float(np.abs(np.diff(way)).sum())
    return bool(falls and way[0] > 1.0 > way[-1])


#: Columns that tell something of a row, by the field they fill.
_OF_A_ROW = {
    "time": "time_s",
    "temperature": "temperature_degC",
    "chamber": "temperature_degC",
    "rate": "rate_1_s",
    "cycle": "cycle",
    "branch": "branch",
}


#: A cell that is empty or holds more than a number.
_ODD = re.compile(r"^$|[^\d\s.,+\-eE%']|^[^\d]*$", re.MULTILINE)


def _without_stale_row(sheet: CsvSheet, columns: Roles, decimal: str) -> CsvSheet:
    """Leave out the first row where it is what the machine still had from before.

    It then stands the way of the pull from the second, by several times more than any other two rows are apart.
    """
    column = columns.first(STRETCHES, "")
    if column is None or len(sheet.lines) < _SHORT:
        return sheet
    steps = np.diff(numbers(sheet, column.heading, decimal, gaps=True))
    pull, most = float(np.sum(steps[1:])), float(np.max(np.abs(steps[1:])))
    if not -steps[0] * np.sign(pull) > _STALE * most:
        return sheet
    reason = f"the first row, {column.heading.title} is still that of before"
    return sheet.without([0], reason)


def _with_readings(sheet: CsvSheet, columns: Roles) -> CsvSheet:
    """Leave out rows where a machine or a spreadsheet wrote that there is no reading, each counted by reason."""
    reasons: dict[str, list[int]] = {}
    seen: set[int] = set()
    count = len(sheet.lines)
    pairs = [(names, place) for names in (STRETCHES, STRESSES) for place in ("", " 2")]
    needed = [
        sheet.columns[one.heading.index] for names, place in pairs if (one := columns.first(names, place)) is not None
    ]
    for cells in needed:
        if not _ODD.search("\n".join(cells)):
            continue
        last = max((row for row in range(count) if is_number(cells[row])), default=-1)
        for row, cell in enumerate(cells):
            if row in seen or (cell and not NO_READING.fullmatch(cell)):
                continue
            word = cell.casefold().strip("+-")
            if not cell and any(other[row] for other in needed):
                continue  # a file cut in a cell is no whole test
            if row > last or (cell and word not in ("nan", "inf", "none", "null")):
                seen.add(row)
                reasons.setdefault(f"no reading ({cell or 'empty'})", []).append(row)
    for reason, rows in reasons.items():
        sheet = replace(sheet, left_out={**sheet.left_out, reason: len(rows)})
    return sheet if not seen else replace(sheet.without(sorted(seen), "-"), left_out=sheet.left_out)


def _set_aside(columns: Roles, loadings: Iterable[Loading]) -> list[str]:
    """Return the titles of columns that are understood and not used: an extension beside a strain, a second force."""
    used = {column.heading.index for loading in loadings for column in loading.used}
    rows = ("time", "temperature", "chamber", "rate", "cycle", "branch", "direction", "specimen", "test")
    return [
        one.heading.title for name, one in columns.columns.items() if one.heading.index not in used and name not in rows
    ]


def _coarser(sheet: CsvSheet, columns: Roles, loadings: Iterable[Loading]) -> list[str]:
    """Tell a stress that the machine rounded to a few values, where the force beside it is as it was read."""
    stress = next((one for loading in loadings for one in loading.used if one.name in STRESSES[:-1]), None)
    force = columns.columns.get("force")
    if stress is None or force is None:
        return []
    few, many = (len(set(sheet.columns[one.heading.index])) for one in (stress, force))
    if few >= _ROUNDED * many:
        return []
    title = stress.heading.title
    return [
        f"{title} has {few} different values, {force.heading.title} {many}: {sheet.option([(title, 'aside')])} takes "
        "the force, over the sizes of the specimen"
    ]


def _groups(
    tests: Sequence[str], directions: Sequence[float | None], specimens: Sequence[str | None]
) -> dict[tuple[str, float | None, str | None], Ints]:
    found: dict[tuple[str, float | None, str | None], list[int]] = {}
    for row, key in enumerate(zip(tests, directions, specimens, strict=True)):
        found.setdefault(key, []).append(row)
    return {key: np.array(rows, dtype=np.int64) for key, rows in found.items()}
