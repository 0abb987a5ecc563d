"""What a row of a table is taken for by its cells alone: units, and readings of a stretch or a strain."""

from __future__ import annotations

import pytest

from hyperfab.io.stated import dotted
from hyperfab.io.tables import is_units, shape
from hyperfab.io.xlsx import _kind


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["mm", "N"], True),
        (["[mm]", "(kN)", ""], True),
        (["%", "MPa"], True),
        (["1", "MPa"], True),  # a stretch has the unit one
        (["mm", "2.5"], False),
        (["2", "MPa"], False),
        (["1", "1"], False),
        (["0.5", "3"], False),
        (["", ""], False),
    ],
)
def test_a_row_of_units_holds_no_number_but_one(cells: list[str], expected: bool) -> None:
    assert is_units(cells) is expected


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["1", "1.2", "1.5"], "stretch"),
        (["1,0", "1,2"], "stretch"),
        (["0", "0.2", "0.5"], "strain [-]"),
        (["0", "20", "50"], "strain [%]"),
        (["1", "20", "50"], "strain [%]"),
        (["-0.1", "1.5"], "strain [-]"),
        (["a", ""], "strain [-]"),
    ],
)
def test_a_column_of_stretches_is_told_by_where_it_begins_and_ends(cells: list[str], expected: str) -> None:
    assert shape(cells) == expected


@pytest.mark.parametrize(
    ("text", "decimal", "expected"),
    [
        ("12,5 mm", ".", "12.5 mm"),
        ("0,125 mm", ".", "0.125 mm"),
        ("-0,125 mm", ".", "-0.125 mm"),
        ("1,250 mm", ",", "1.250 mm"),
        ("1,250 mm", ".", "1,250 mm"),  # may be thousands
        ("12.5 mm", ",", "12.5 mm"),
    ],
)
def test_a_comma_is_a_decimal_mark_where_it_cannot_be_one_of_thousands(
    text: str, decimal: str, expected: str
) -> None:
    assert dotted(text, decimal) == expected


@pytest.mark.parametrize(
    ("style", "code", "expected"),
    [
        ("14", None, "date"),
        ("22", None, "date"),
        ("47", None, "date"),
        ("10", None, "percent"),
        ("2", None, ""),
        ("164", "yyyy-mm-dd", "date"),
        ("164", "[h]:mm:ss", "date"),
        ("164", "0.0%", "percent"),
        ("164", '0.00" mm"', ""),
        ("164", "General", ""),
        ("164", "[Red]0.00_d", ""),
    ],
)
def test_a_cell_of_a_workbook_is_a_date_or_a_percentage_by_its_format(
    style: str, code: str | None, expected: str
) -> None:
    assert _kind(style, code) == expected
