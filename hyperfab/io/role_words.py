"""What is said of a table's columns: how they were understood, and what to say where they cannot be."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Sequence

from hyperfab.errors import InputError
from hyperfab.io.cells import is_length, is_number, plain_values, shape
from hyperfab.io.csv_numbers import other_unit
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import Meaning, looked_up, measured, plain
from hyperfab.io.headings import KIND, Heading, heading, in_unit, is_of, is_unread, meaning, unit_of, unread_unit
from hyperfab.io.other_tests import BULGED, READINGS, RESULTS, is_bulge, is_result
from hyperfab.io.roles import BY_KIND, STRESSES, STRETCHES, STRONGEST, Column, Roles, state_of
from hyperfab.io.units import is_unit

#: Units to propose where a column has none.
_USUAL = {
    "strain": "%", "true strain": "-", "green strain": "-", "shear strain": "-", "stretch": "-",
    "volume ratio": "-", "extension": "mm",
    "length": "mm", "position": "mm", "stress": "MPa", "true stress": "MPa", "shear stress": "MPa",
    "stress sd": "MPa", "membrane stress": "N/mm",
    "force": "N", "time": "s", "temperature": "degC", "chamber": "degC", "rate": "1/s",
}  # fmt: skip
#: Force by the fineness of a yarn.
_FINENESS = re.compile(r"(\w+)\s*/\s*(?:d?k?tex|den|denier)", re.IGNORECASE)


class UnknownTest(InputError):
    """A file does not say which test it is, and its columns do not tell."""


def no_test(sheet: CsvSheet, tests: Sequence[str]) -> UnknownTest:
    """Return the error that a file does not say which test it is, with the option that does."""
    return UnknownTest(
        "does not say which test it is",
        file=sheet.name,
        remedy=f"give it as --uniaxial {shlex.quote(sheet.name)} (or --shear, --biaxial), or add a first "
        f'line "# test: uniaxial" '
        f"({', '.join(tests)})",
    )


def no_stress(sheet: CsvSheet, found: Roles) -> InputError:
    """Return the error that no column gives a stress."""
    names = '"stress [MPa]", "true stress [MPa]", "membrane stress [N/mm]" or "force [N]"'
    return missing(sheet, found, "a stress", names)


def missing(sheet: CsvSheet, found: Roles, what: str, names: str) -> InputError:
    """Return the error that no column gives ``what``, with the option filled in as the units suggest."""
    titles = ", ".join(one.title or '""' for one in sheet.headings[:8])
    fine = next((one.title for one in sheet.headings if _FINENESS.fullmatch(one.unit or "")), None)
    remark = f"; {fine} is the force by the fineness of a yarn, a sheet has none" if fine else ""
    told = [sheet.name, *(one.value for one in sheet.metadata.get("test", []))]
    labels = [one.label for one in sheet.headings]
    if sum(map(is_result, labels)) > 1:
        return sheet.wrong(f"no column gives {what}; the columns are {titles}: {RESULTS}", remedy=READINGS)
    bulge = is_bulge(labels, told)
    remark += f"; {BULGED}" if bulge else ""
    entries = [] if bulge else proposed(sheet, found)
    settles = f", or say what they are, as in {sheet.option(entries)}" if entries else ""
    return sheet.wrong(f"no column gives {what}; the columns are {titles}{remark}", remedy=f"name one {names}{settles}")


def proposed(sheet: CsvSheet, found: Roles) -> list[tuple[str, str]]:
    """Return what the columns most likely are, for a message: known ones as known, others by unit, then by place."""
    entries: dict[int, tuple[str, str]] = {}
    have: set[str] = set()
    for name, column in found.columns.items():
        unit = column.heading.unit or _likely_unit(sheet, column)
        have.add(name)
        if sheet.layout.choice(column.heading, sheet.headings) is not None:
            continue  # the command line says it
        if column.heading.unit is None and name.removesuffix(" 2") in _USUAL and not unread_unit(column.heading):
            entries[column.heading.index] = (column.heading.title, f"{name} [{unit}]")
    numeric = [
        one for one in sheet.headings
        if one.index not in entries and one.title and any(map(is_number, sheet.columns[one.index][:5]))
        and not any(column.heading.index == one.index for column in found.columns.values())
        and not is_unread(one) and not _is_aside(one)
    ]  # fmt: skip
    numeric = [one for one in numeric if not _gainsaid(one)]
    rest = [one for one in numeric if not ((own := _own_unit(one)) and is_unit(own))]
    places = ("", " 2") if _two_axes(sheet, have, rest) else ("",)
    for one in numeric:
        own = _own_unit(one)
        kind = next((name for kind, name in BY_KIND.items() if own and is_of(own, kind)), None)
        kind = kind and measured(kind, one.title)  # of a true stress the nominal one is not proposed
        if (yarn := _FINENESS.fullmatch(one.unit or "")) and not have & set(STRESSES):
            have.add("force")
            entries[one.index] = (one.title, f"force [{yarn[1]}]")
        if kind is None and one.unit is not None and unit_of(one.unit) and is_of(one.unit, "dimensionless"):
            kind = measured("strain", one.title)  # epsY_log is a logarithmic one
            if have & set(STRETCHES) and kind not in have:
                continue  # beside an extension: a set point, a count
        if kind == "extension" and is_length(sheet.columns[one.index]):
            kind = "length"
        named = next((f"{kind}{place}" for place in places if f"{kind}{place}" not in have), None)
        if kind and named:
            have.add(named)
            entries[one.index] = (one.title, f"{named} [{own}]")
    rest = [one for one in rest if one.index not in entries]
    for names in (STRETCHES, STRESSES):
        for place in places:
            if rest and not any(name + place in have for name in names):
                one = rest.pop(_likeliest(rest, names))
                told = shape(sheet.columns[one.index], one.title) if names is STRETCHES else "stress [MPa]"
                name, gap, unit = told.partition(" [")
                name = measured(name, one.title) or name
                entries[one.index] = (one.title, f"{name}{place}{gap}{unit}")
                if names is STRESSES and state_of(one.title):  # warp, weft: of each its own
                    alike = [other for other in rest if state_of(other.title)]
                    entries |= {other.index: (other.title, f"{name}{place}{gap}{unit}") for other in alike}
    return [entries[index] for index in sorted(entries)]


def _likeliest(heads: Sequence[Heading], names: Sequence[str]) -> int:
    """Return the place of the first head that holds one of ``names``, as StrainEngMD_02 does, or of the first."""
    words = [name for name in names if " " not in name]
    return next((at for at, one in enumerate(heads) if any(word in one.title.lower() for word in words)), 0)


def _own_unit(head: Heading) -> str | None:
    """Return a column's unit; a head may be of units alone, but l1 is a letter of an axis, L a length and F a force."""
    return head.unit or (None if re.fullmatch(r"[A-Za-z]_?\d|[FLl]", head.title) else unit_of(head.title))


def _gainsaid(head: Heading) -> bool:
    """Whether a column's words, or letter, and its unit are of two things: E' in MPa is a modulus."""
    told = [made for one in looked_up(plain(head.label)) if (made := in_unit(one, head.unit)) is not None]
    kinds = [KIND[one.name] for one in told if one.name in KIND]
    return head.unit is not None and bool(kinds) and not any(is_of(head.unit, kind) for kind in kinds)


def _two_axes(sheet: CsvSheet, have: set[str], rest: Sequence[Heading]) -> bool:
    """Whether a table is likely one of a general biaxial test: two stretches stand in it, known or by their size,
    or two forces."""
    if any(name.endswith(" 2") and name.removesuffix(" 2") in STRESSES for name in have):
        return True
    if any(name.removesuffix(" 2") in STRETCHES for name in have):
        return any(name.endswith(" 2") and name.removesuffix(" 2") in STRETCHES for name in have)
    return len(rest) > 1 and all(shape(sheet.columns[one.index], one.title) == "stretch" for one in rest[:2])


def _is_aside(head: Heading) -> bool:
    """Whether a column is known to be neither stretch nor stress, as a modulus is; a letter, as X, may be either."""
    yarn = _FINENESS.fullmatch(head.unit or "")
    return len(head.title) > 1 and meaning(head) == Meaning("aside") and not yarn


def unitless(sheet: CsvSheet, columns: Sequence[Column]) -> str:
    """Return the option that gives every column of ``columns`` that has no unit its likely one."""
    entries = [
        (one.heading.title, f"{one.name} [{_likely_unit(sheet, one)}]")
        for one in columns
        if one.heading.unit is None and KIND.get(one.name.removesuffix(" 2")) not in (None, "dimensionless")
    ]
    return sheet.option(entries)


def no_unit(sheet: CsvSheet, column: Column, roles: Roles, example: str = "") -> InputError:
    """Return the error that a column lacks its unit, with an ``example`` of it, or its title with the unit that is
    likely, and the option that gives it."""
    name = column.name.removesuffix(" 2")
    if (unit := unread_unit(column.heading)) is not None:
        return other_unit(sheet, column.heading, unit, KIND[name], column.name)
    example = example or f"{column.heading.title} [{_likely_unit(sheet, column)}]"
    return sheet.wrong(
        "has no unit",
        column.heading,
        remedy=f'write it behind the name, as in "{example}", or say {unitless(sheet, [*roles.columns.values()])}',
    )


def _likely_unit(sheet: CsvSheet, column: Column) -> str:
    if column.name in ("temperature", "chamber"):
        cell = next((one for one in sheet.columns[column.heading.index] if is_number(one)), "0").replace(",", ".")
        return "K" if re.fullmatch(r"\d+\.?\d*", cell) and float(cell) > 180.0 else "degC"
    name = column.name.removesuffix(" 2")
    cells = sheet.columns[column.heading.index]
    if name == "strain":  # per cent, or a share: by its size
        return "%" if shape(cells) == "strain [%]" else "-"
    if _USUAL.get(name) == "MPa" and max(map(abs, plain_values(cells)), default=0.0) > STRONGEST:
        return "Pa"
    return _USUAL.get(name, "-")


def understood(sheet: CsvSheet, taken: Iterable[Column]) -> str:
    """Return what was understood of a table and columns that were taken, without the file's name.

    Files read alike say the same.
    """
    columns = {column.heading.index: column for column in taken}
    told = [
        one.heading.title if _is_plain(one) else f"{one.heading.title or f'column {index + 1}'} is {_what(one)}"
        for index, one in sorted(columns.items())
    ]
    return f"head in line {sheet.header_line}: {', '.join(told)}"


def _is_plain(column: Column) -> bool:
    """Whether a title says what its column is taken for: the name alone, or as the contract's own form has it."""
    head = column.heading
    if head.unit is None:
        return head.title.casefold().removesuffix(" 1") == column.name
    return head.title == f"{column.name} [{head.unit}]"


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
