"""What a row of a table is taken for by its cells alone: units, and readings of a stretch or a strain."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.cells import shape
from hyperfab.io.csv_table import read_table
from hyperfab.io.csv_tests import read_tests
from hyperfab.io.layout import PLAIN, layout
from hyperfab.io.specimen import Geometry
from hyperfab.io.stated import dotted
from hyperfab.io.tables import is_units
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
def test_a_comma_is_a_decimal_mark_where_it_cannot_be_one_of_thousands(text: str, decimal: str, expected: str) -> None:
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


def test_columns_without_a_reading_are_left_for_those_with_readings() -> None:
    rows = "".join(f"{k / 50}, {5.0 + k:.2f}, N/A, , {k / 10:.3f}, 1\n" for k in range(1, 30))
    data = "\n\nTime (sec), Load (N), Stress (KPa), Strain (mm), Position (mm), Cycle\n" + rows
    [found] = read_tests(
        data.encode(),
        "a.csv",
        test="uniaxial",
        geometry=Geometry(gauge_length=100.0, width=10.0, thickness=1.0),
    )
    assert found.stretch[-1] == pytest.approx(1.028)
    assert found.stress[-1] == pytest.approx(3.4)
    assert any("Strain (mm), Stress (KPa)" in note for note in found.notes)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("mark", [".", ","])
def test_a_first_row_of_before_is_left_out(way: float, mark: str) -> None:
    x = [0.9, *(0.02 + 0.03 * k for k in range(20))]
    rows = "".join(f"{way * at:.3f};{way * (0.1 + at):.3f}\n".replace(".", mark) for at in x)
    data = f"extension [mm];stress [MPa]\n{rows}".encode()
    [found] = read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(gauge_length=10.0))
    assert found.stretch[0] == pytest.approx(1.0 + way * 0.002)
    assert found.left_out == {"the first row, extension [mm] is still that of before": 1}


@pytest.mark.parametrize("first", [0.0, 0.1, -0.9])
def test_a_first_row_that_could_be_the_test_stays(first: float) -> None:
    """By little, or on the way to what comes."""
    x = [first, *(0.02 + 0.03 * k for k in range(20))]
    data = ("extension [mm],stress [MPa]\n" + "".join(f"{at:.3f},{0.1 + at:.3f}\n" for at in x)).encode()
    [found] = read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(gauge_length=10.0))
    assert len(found.stretch) == 21


def test_a_strain_in_a_column_that_is_called_a_stretch_is_told_for_what_it_is() -> None:
    data = b"stretch_uni,stress_uni\n" + b"".join(b"%.2f,%.2f\n" % (0.05 + k / 4, 0.4 + k) for k in range(20))
    with pytest.raises(InputError, match=re.escape('--columns "stretch_uni=strain [-],stress_uni=stress [MPa]"')):
        read_tests(data, "a.csv", test="uniaxial")
    said = layout(["stretch_uni=stretch,stress_uni=stress [MPa]"])
    option = '--columns "stretch_uni=strain [-],stress_uni=stress [MPa]"'
    with pytest.raises(InputError, match=re.escape(f"is it a strain? then say {option}")):
        read_tests(data, "a.csv", test="uniaxial", columns=said)


@pytest.mark.parametrize(
    ("table", "option"),
    [
        ("-0.9 0.6\n-0.4 0.8\n0 1.0\n0.3 1.4\n", "1=stress [MPa],2=stretch"),
        ("0 1.0\n0.3 1.4\n0.5 1.9\n", "1=stress [MPa],2=stretch"),
        ("1.0 0\n1.4 0.3\n1.9 0.5\n", "1=stretch,2=stress [MPa]"),
        ("0 0\n0.1 0.9\n0.2 1.1\n", "1=strain [-],2=stress [MPa]"),
    ],
)
def test_of_a_table_without_a_head_the_column_that_is_one_where_nothing_pulls_is_the_stretch(
    table: str, option: str
) -> None:
    with pytest.raises(InputError, match="there is no header") as caught:
        read_tests(table.encode(), "k3.txt", test="uniaxial")
    assert f'--columns "{option}"' in str(caught.value)


def test_of_a_log_without_a_head_time_and_probes_are_asked_for() -> None:
    log = b"24.0 24.9 0.0\n30.2 24.9 127.0\n31.0 25.1 127.0\n"
    with pytest.raises(InputError, match="there is no header") as caught:
        read_table(log, "run.txt", {"time": "time"}, rest="temperature", called=["nozzle"], layout=PLAIN)
    assert '--columns "1=time [s],2=nozzle [degC]"' in str(caught.value)


#: A compression test as a stand writes it: what was pressed stands below the readings.
FOOT = (
    "Direction:, COMPRESSION\nControl Rate:, 5.0 mm/min\nSpecimen Length (mm):, 10\nSpecimen Diameter (mm):, 20\n"
    "\nStatus:, PASS\n"
)


@pytest.mark.parametrize("gap", ["", "\n"])
def test_what_stands_below_the_readings_is_known_as_if_it_stood_above(gap: str) -> None:
    table = "Time (sec), Load (N), Position (mm)\n" + "".join(f"{k}, {3 * k}, {0.5 * k}\n" for k in range(6))
    with pytest.raises(InputError, match="--gauge-length 10mm"):
        read_tests(f"{table}{gap}{FOOT}".encode(), "gel 1.csv")
    [found] = read_tests(f"{table}{gap}{FOOT}".encode(), "gel 1.csv", geometry=Geometry(gauge_length=10.0))
    assert found.mode == "uniaxial"
    assert (found.stretch[-1], found.stress[-1]) == pytest.approx((0.75, -15.0 / (100.0 * math.pi)))
    # Means below the readings state nothing.
    [plain] = read_tests(f"# test: compression\n# diameter: 20 mm\n{table}mean, 8, 1\nsd, 2, 0.3\n".encode(), "g.csv",
                         geometry=Geometry(gauge_length=10.0))  # fmt: skip
    assert plain.stress == pytest.approx(found.stress)


def test_a_load_cell_that_is_knocked_in_a_push_is_no_wrong_column() -> None:
    rows = [f"{k},{2 * k}" for k in range(30)]
    head = "# test: compression\n# gauge length: 50 mm\n# diameter: 20 mm\nextension [mm],force [N]\n"
    [found] = read_tests("\n".join([head.rstrip(), *rows, "29,-40", "29,55"]).encode(), "gel.csv")
    assert np.count_nonzero(found.stress > 0.0) == 1
    with pytest.raises(InputError, match="below 1"):
        read_tests("\n".join([head.rstrip(), *rows, *["29,-40"] * 6]).encode(), "gel.csv")


@pytest.mark.parametrize("title", ["Crosshead (mm)", "Displacement [mm]"])
def test_a_crosshead_that_tells_where_it_stands_is_counted_from_its_first_row(title: str) -> None:
    head = f"# test: uniaxial\n# gauge length: 25 mm\n# width: 5 mm\n# thickness: 1 mm\n{title},Load (N)\n"
    pulled = head + "".join(f"{25.79 + 0.5 * k},{0.1 + 0.4 * k}\n" for k in range(9))
    [found] = read_tests(pulled.encode(), "pleura.txt")
    assert found.stretch[[0, -1]] == pytest.approx([1.0, 1.16])
    assert any("counted from its first row" in note for note in found.notes)
    # A hold that was exported without its pull begins with its load, and stands at its stretch.
    held = head + "".join(f"{40 + 1e-4 * (k % 2)},{2.0 / (1 + k)}\n" for k in range(9))
    [found] = read_tests(held.encode(), "hold.txt")
    assert found.stretch[0] == pytest.approx(2.6)


def test_a_stress_that_was_rounded_is_told_beside_the_force_it_was_made_of() -> None:
    head = "# test: uniaxial\n# gauge length: 10 mm\n# diameter: 20 mm\nLoad (N),Stress (kPa),Position (mm)\n"
    forces = [0.017 * k for k in range(60)]

    def notes(digits: int) -> list[str]:
        rows = "".join(f"{f:.3f},{f / 0.314:.{digits}f},{0.1 * k:.1f}\n" for k, f in enumerate(forces))
        [found] = read_tests(f"{head}{rows}".encode(), "gel.csv")
        return [one for one in found.notes if "different values" in one]

    [told] = notes(0)
    assert "Stress (kPa) has 4 different values, Load (N) 60" in told
    assert '--columns "Stress (kPa)=aside"' in told
    assert notes(2) == []


def test_few_rows_of_tension_in_a_push_are_told() -> None:
    """They were refused, then taken without a word where the rows stand too far apart to tell a glitch by."""
    rows = [f"{-0.02 * k:g},{-0.06 * k * (-1 if k == 15 else 1):g}" for k in range(26)]
    [found] = read_tests("\n".join(["strain [-],stress [MPa]", *rows]).encode(), "a.csv", test="uniaxial")
    assert "tension below a stretch of 1 in 1 of 26 rows, first line 17" in found.notes
