"""Cells to numbers: the decimal mark that all cells agree on, then every cell to the nearest double."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from datetime import date
from decimal import Decimal
from fractions import Fraction

import numpy as np

from hyperfab.arrays import Array
from hyperfab.errors import InputError
from hyperfab.io.cells import INSTEAD, MOMENT, NO_READING, SPELLED, plain_values
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.headings import COUNTED, Heading, unit_of
from hyperfab.io.rows import CELL
from hyperfab.io.unit_table import UnitError
from hyperfab.io.units import KINDS, column_factor

#: What instruments of SCPI (1999, volume 1, 7.2.1) send for infinity, and from there on for no number.
_NONE = 9.89e37
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?", re.ASCII)
#: float() also takes nan, inf, 1_000 and digits of other scripts; a column that has none of these is parsed at once.
_NOT_PLAIN = re.compile(r"[^0-9eE+\-.\n]")
#: One mark and three digits after one to three digits that do not start with 0: decimal mark or thousands separator?
_UNDECIDED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
_GROUPED = {
    ".": re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+", re.ASCII),
    ",": re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", re.ASCII),
}
_MARKED = re.compile(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?", re.ASCII)
_SPACES = re.compile(r"(?<=\d)[ \u00a0\u202f'](?=\d{3}(?:\D|$))", re.ASCII)
_OTHER = {".": ",", ",": "."}

#: A time that begins between these is a date of a spreadsheet, in days since 1900: 1954 to 2119.
_DAYS = (2e4, 8e4)


def settle_decimal(sheet: CsvSheet, headings: Iterable[Heading], given: str | None = None) -> str:
    """Return the decimal mark, ``.`` or ``,``, of the numbers under ``headings``.

    ``given`` (the option ``--decimal``) decides; otherwise the cells do. Raises InputError where they disagree, or
    where every cell can be read both ways, such as 1,234.

    >>> from hyperfab.io.csv_dialect import open_sheets
    >>> [sheet] = open_sheets(b"stretch;stress [MPa]\\n1,125;0,25\\n", "a.csv", lambda heads: True)
    >>> settle_decimal(sheet, sheet.headings)
    ','
    """
    known = given or sheet.mark
    if known is not None:
        return known
    seen: dict[str, tuple[str, int, Heading]] = {}  # what speaks for a mark, and for a grouping mark
    undecided: dict[str, tuple[str, int, Heading]] = {}
    headings = list(headings)
    mixed = all(any(mark in cell for heading in headings for cell in sheet.columns[heading.index]) for mark in ".,")
    for heading in headings:
        cells = sheet.columns[heading.index]
        joined = "\n".join(cells)
        if "," not in joined and (sheet.separator == "," or "." not in joined):
            if "." in joined:
                seen.setdefault(".", ("a dot where commas separate", sheet.header_line, heading))
            continue
        for cell, line in zip(cells, sheet.lines, strict=True):
            if "," not in cell and "." not in cell:
                continue
            mark = _speaks_for(_SPACES.sub("", cell.rstrip(" %")))
            if mark in _OTHER:
                if mark not in seen or (_groups(cell) and not _groups(seen[mark][0])):
                    seen[mark] = (cell, line, heading)
            elif mark:
                undecided.setdefault(mark[1], (cell, line, heading))
            if seen and not mixed:  # nothing can contradict; a cell that does not fit is found when it is read
                return next(iter(seen))
    return _verdict(sheet, seen, undecided)


def _verdict(
    sheet: CsvSheet, seen: dict[str, tuple[str, int, Heading]], undecided: dict[str, tuple[str, int, Heading]]
) -> str:
    if "," in seen and "." in seen:
        comma, dot = seen[","], seen["."]
        raise InputError(
            f"{comma[0]} has a decimal comma, but line {dot[1]} has {dot[0]}",
            file=sheet.name,
            line=comma[1],
            column=comma[2].title,
            remedy="write all numbers with one decimal mark",
        )
    if not seen and undecided:
        cell, line, heading = next(iter(undecided.values()))
        raise InputError(
            f"{cell} can be read both ways, as can every number of the file",
            file=sheet.name,
            line=line,
            column=heading.title,
            remedy=f'say which is the decimal mark: --decimal "{_mark_in(cell)}" or "{_OTHER[_mark_in(cell)]}"',
        )
    if not seen:
        return "."
    mark = next(iter(seen))
    if _OTHER[mark] in undecided and not _groups(seen[mark][0]):
        cell, line, heading = undecided[_OTHER[mark]]
        raise InputError(
            f"is {cell} a thousand or not? line {seen[mark][1]} has {seen[mark][0]}",
            file=sheet.name,
            line=line,
            column=heading.title,
            remedy=f'export without thousands separators, or say --decimal "{mark}"',
        )
    return mark


def _speaks_for(cell: str) -> str:
    """Return the mark that must be the decimal one, ``?`` and the mark if that is open, or nothing."""
    if not _MARKED.fullmatch(cell):
        return ""
    if _both(cell):
        return max(".,", key=cell.rfind)
    mark = _mark_in(cell)
    if cell.count(mark) > 1:
        return _OTHER[mark] if _GROUPED[mark].fullmatch(cell) else ""
    return f"?{mark}" if _UNDECIDED.fullmatch(cell) else mark


def _groups(cell: str) -> bool:
    """Whether the cell itself shows that the file separates thousands."""
    return _both(cell) or cell.count(".") > 1 or cell.count(",") > 1


def _both(cell: str) -> bool:
    return "." in cell and "," in cell


def _mark_in(cell: str) -> str:
    return "," if "," in cell else "."


def numbers(sheet: CsvSheet, heading: Heading, decimal: str, shift: int = 0, gaps: bool = False) -> Array:
    """Return the cells under ``heading``, times ten to the power ``shift``, each the nearest double to what is written.

    Raises InputError naming line and column for a cell that is empty, text, NaN, infinite or too large; with ``gaps`` a
    cell that is empty or says that there is no reading is nan.
    """
    cells = sheet.columns[heading.index]
    joined = "\n".join(cells)
    if "%" in joined:
        cells = [cell.removesuffix("%").rstrip() for cell in cells]
        joined = "\n".join(cells)
    grouped = decimal == "," and "." in joined  # 1.600 is a thousand and more
    if decimal == ",":
        joined = joined.replace(",", ".")
    if shift:
        joined = joined.replace("\n", f"e{shift}\n") + f"e{shift}"
    values = None
    if not grouped and not _NOT_PLAIN.search(joined):
        with contextlib.suppress(ValueError):
            values = np.array(list(map(float, joined.split("\n"))))
    if values is None:
        values = np.array(
            [
                np.nan
                if gaps and (not cell or NO_READING.fullmatch(cell.strip("+-") or cell))
                else _number(cell, sheet, heading, row, decimal, shift)
                for row, cell in enumerate(cells)
            ]
        )
    if gaps:
        values[np.isfinite(values) & (np.abs(values) >= _NONE * 10.0**shift)] = np.nan
    unfit = np.isinf(values) if gaps else ~np.isfinite(values)
    if unfit.any():
        row = int(np.flatnonzero(unfit)[0])
        raise _bad_cell("is larger than any double", cells[row], sheet, heading, row)
    return values


def quantities(
    sheet: CsvSheet, heading: Heading, kind: str, decimal: str, gaps: bool = False, name: str | None = None
) -> Array:
    """Return the numbers under ``heading`` in the unit of ``kind`` (see ``hyperfab.io.units.KINDS``), ``gaps`` as nan.

    Raises InputError where the heading has no unit though the kind has one, or a unit of another kind.
    """
    wanted = KINDS[kind]
    if wanted.unit == "1" and heading.unit in (None, "-", "1") and _all_percent(sheet.columns[heading.index]):
        heading = replace(heading, unit="%")
    if heading.unit is None and wanted.unit != "1":
        told = plain_values(sheet.columns[heading.index])
        # A workbook keeps a time of day as a share of the day.
        days = (
            kind == "time"
            and bool(told)
            and (_DAYS[0] < told[0] < _DAYS[1] or (sheet.separator == CELL and 0.0 <= min(told) <= max(told) < 1.0))
        )
        unit = "d" if days else wanted.unit
        raise sheet.wrong(
            "has no unit",
            heading,
            remedy=f'write it behind the name, as in "{heading.title} [{unit}]", or say '
            + sheet.option([(heading.title, f"{name or heading.name} [{unit}]")]),
        )
    try:
        factor, offset = column_factor(heading.unit or "-", kind)
    except UnitError as error:
        message, _, _ = str(error).partition("; ")
        raise other_unit(sheet, heading, heading.unit or "-", kind, name or heading.name, message) from None
    shift = _power_of_ten(factor)
    values = numbers(sheet, heading, decimal, shift or 0, gaps)
    if shift is None:
        values = values * float(factor)
    return values + float(offset) if offset else values


def other_unit(sheet: CsvSheet, heading: Heading, unit: str, kind: str, name: str, message: str = "") -> InputError:
    """Return the error that a column's unit is none of its kind, with what to say where the numbers are in a known one.

    What stands beside a name may also be an amount: the range of a load cell, or what each number counts for.
    """
    own = KINDS[kind].unit

    def option(unit: str) -> str:
        return sheet.option([(heading.title, f"{name} [{unit}]")])

    counted = COUNTED.fullmatch(unit)
    if counted and unit_of(counted[2]):
        return sheet.wrong(
            f"{unit} is an amount and no unit",
            heading,
            remedy=f"if the numbers are in {counted[2]}, say {option(counted[2])}; if each counts for {unit}, "
            f"{option(f'x{counted[1]} {counted[2]}')}",
        )
    known = f"write it in a known one ({_KNOWN[kind]}); " if kind in _KNOWN else ""
    return sheet.wrong(
        message or f"{unit} is no unit that is known",
        heading,
        remedy=f"{known}only if the numbers are in {'shares of 1' if own == '1' else own}, say "
        f"{option('-' if own == '1' else own)}",
    )


#: Units to choose from, by the kind of quantity.
_KNOWN = {
    "force": "N, kN, kgf, lbf", "stress": "MPa, kPa, N/mm^2, kgf/cm^2, psi", "length": "mm, m, in",
    "membrane-stress": "N/mm, N/m, N/5cm, lbf/in", "dimensionless": "%, -, mm/mm",
}  # fmt: skip


def _all_percent(cells: Sequence[str]) -> bool:
    return bool(cells) and cells[0].endswith("%") and all(cell.endswith("%") for cell in cells if cell)


def seconds(sheet: CsvSheet, heading: Heading) -> Array:
    """Return a column of times of day, durations or moments as seconds from its first row, past midnight too.

    A column of several dates beside a clock without tells its days.
    Of two parts, 12:30, the first are hours or minutes as the title says (``mm:ss``, a unit ``min``) or other cells do.

    Raises InputError naming the cell that is none, or the first that counts up from 0:00 where nothing says which.
    """
    cells = sheet.columns[heading.index]
    if (dates := beside_clock(sheet, heading)) is not None:
        cells = [f"{day} {cell}" for day, cell in zip(sheet.columns[dates.index], cells, strict=True)]
    minutes_first: bool | None = None
    days_of = _days({match["date"] for cell in cells if (match := MOMENT.fullmatch(cell)) and match["date"]})
    found: list[float] = []
    for row, cell in enumerate(cells):
        match = MOMENT.fullmatch(cell) or SPELLED.fullmatch(cell)
        if match is None or match["m"] is None:
            raise _bad_cell("is no time", cell, sheet, heading, row)
        told = match.groupdict()
        parts = [int(told["h"] or 0), int(told["m"]), int(told["s"] or 0)]
        if told["s"] is None:
            if minutes_first is None:
                minutes_first = _minutes_first(sheet, heading)
            parts = [0, *parts[:2]] if minutes_first else parts
        if told.get("half"):
            parts[0] = parts[0] % 12 + (12 if told["half"][0] in "pP" else 0)
        days = days_of.get(told.get("date") or "", 0)
        hours, minutes, whole = parts
        moment = 86400.0 * days + 3600.0 * hours + 60.0 * minutes + whole + float(f"0.{(told['part'] or '.0')[1:]}")
        found.append(moment - _zone(told.get("zone")))
    moments = np.array(found)
    if not any("-" in cell or "/" in cell for cell in cells[:1]):
        moments = moments + 86400.0 * np.concatenate([[0.0], np.cumsum(np.diff(moments) < -43200.0)])
    return np.asarray(moments - moments[0])


def beside_clock(sheet: CsvSheet, heading: Heading) -> Heading | None:
    """Return the first column of dates, not all one day, beside one of times of day that have none, or None."""
    # One of dates begins with one: of a long log no other column is looked through.
    likely = [
        one for one in sheet.headings if one.name != "aside" and all(map(_day_alone, sheet.columns[one.index][:1]))
    ]
    if not likely or any(
        (match := MOMENT.fullmatch(cell)) is None or match["date"] for cell in sheet.columns[heading.index]
    ):
        return None
    for one in likely:
        days = set(sheet.columns[one.index])
        if len(days) > 1 and all(map(_day_alone, days)):
            return one
    return None


def _day_alone(cell: str) -> bool:
    match = MOMENT.fullmatch(cell)
    return match is not None and match["date"] is not None and match["m"] is None


def _minutes_first(sheet: CsvSheet, heading: Heading) -> bool:
    """Return whether a clock of two parts tells minutes and seconds, not hours and minutes."""
    titled = re.search(r"\b(hh?:m(?:m|in)?|m(?:m|in)?:s(?:s|ec)?)\b(?!:)", heading.title.casefold())
    if heading.unit in ("h", "min") or (titled and heading.title[titled.start() - 1 : titled.start()] != ":"):
        return heading.unit == "min" or (titled is not None and titled[1].startswith("m"))
    matches = [match for cell in sheet.columns[heading.index] if (match := MOMENT.fullmatch(cell))]
    # Seconds have a fraction, and a clock that goes on as 1:00:00 had minutes before; a day and its halves have hours.
    if any(match["part"] or match["s"] for match in matches):
        return True
    if any(match["date"] or match["half"] or match["zone"] for match in matches) or int(matches[0]["h"] or 1) > 0:
        return False
    options = [sheet.option([(heading.title, f"time [{unit}]")]) for unit in ("h", "min")]
    raise sheet.wrong(
        f"{sheet.columns[heading.index][-1]}: hours and minutes, or minutes and seconds?",
        heading,
        remedy=f"say {options[0]} for hours, {options[1]} for minutes first",
    )


def _zone(text: str | None) -> float:
    """Return the seconds that a zone, as +02:00, is ahead."""
    if text is None:
        return 0.0
    hours, minutes = int(text[1:3]), int(text[-2:])
    return (3600.0 * hours + 60.0 * minutes) * (-1.0 if text[0] == "-" else 1.0)


def _days(dates: Collection[str]) -> dict[str, int]:
    """Return the number of the day of each date, 0 of none. Of 3/4/2026 the day or the month comes first in all of
    them, whichever makes them lie closer together: a log past midnight goes on by a day, not by a month.

    >>> days = _days({"03/01/2024", "03/02/2024"})
    >>> days["03/02/2024"] - days["03/01/2024"]
    1
    """
    options = [{text: _day(text, month_first) for text in dates} for month_first in (False, True)]
    known = [found for found in options if all(found.values())]
    return min(known or options, key=lambda found: max(found.values(), default=0) - min(found.values(), default=0))


def _day(text: str, month_first: bool) -> int:
    """Return the number of a day, 0 where the date is none."""
    parts = [int(part) for part in re.split(r"[-./]", text)]
    year, month, day = parts if parts[0] > 31 else (parts[2], parts[1], parts[0])
    if month_first and parts[0] <= 31:
        month, day = day, month
    try:
        return date(year, month, day).toordinal()
    except ValueError:
        return 0


def _power_of_ten(factor: Fraction) -> int | None:
    """Return n where ``factor`` is ten to the n: such a unit moves the decimal mark and rounds nothing."""
    for power in range(-12, 13):
        if factor == Fraction(10) ** power:
            return power
    return None


def _number(cell: str, sheet: CsvSheet, heading: Heading, row: int, decimal: str, shift: int) -> float:
    """The slow way, for cells with thousands separators or worse."""
    text = _SPACES.sub("", cell)
    text = text[:-1].rstrip() if text.endswith("%") else text
    other = _OTHER[decimal]
    if other in text:
        whole, mark, rest = text.partition(decimal)
        if _GROUPED[other].fullmatch(whole) and other not in rest:
            text = whole.replace(other, "") + mark + rest
    if decimal == ",":
        text = text.replace(".", "?").replace(",", ".")
    if _NUMBER.fullmatch(text):
        return float(text) if not shift else float(Decimal(text).scaleb(shift))
    if not cell:
        raise _bad_cell("is empty", "", sheet, heading, row)
    if NO_READING.fullmatch(cell.strip("+-") or cell) or cell.casefold().strip("+-") == "infinity":
        raise _bad_cell("is no reading", cell, sheet, heading, row)
    raise _bad_cell("is no number", cell, sheet, heading, row)


def _bad_cell(what: str, cell: str, sheet: CsvSheet, heading: Heading, row: int) -> InputError:
    shown = cell if len(cell) <= 40 else cell[:37] + "..."
    remedy = next((told for form, told in INSTEAD if form.fullmatch(cell)), "correct the cell or delete the row")
    return sheet.wrong(f"{shown or 'the cell'} {what}", heading, row=row, remedy=remedy)
