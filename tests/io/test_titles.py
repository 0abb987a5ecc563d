"""What names and titles tell of a test: the direction it was cut in and how warm it was."""

from __future__ import annotations

import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.kinds_of_tests import named_test

BELOW = "strain [-];stress [MPa]\n0;0\n0.1;1\n0.2;3\n"


def read(text: str, name: str = "a.csv", test: str | None = "uniaxial") -> list[TestData]:
    return read_tests(text.encode(), name, test=test)


def told(found: TestData) -> tuple[float | None, float | None]:
    return found.direction, None if found.temperature_degC is None else float(found.temperature_degC[0])


@pytest.mark.parametrize(
    ("title", "expected"),
    [
        ("Zugversuch Maschenware K7, Querrichtung, 80 °C", (90.0, 80.0)),
        ("Tensile test of knit K7 - course direction - 105 C", (90.0, 105.0)),
        ("Knit K7 WALE @ 176 °F", (0.0, 80.0)),
        ("# Uniaxial tension of a knit (K7), wale direction, 23 degC.", (0.0, 23.0)),
        ("Specimen label;K7 weft 2", (90.0, None)),
        ("引張試験 ニット タテ方向 23℃", (0.0, 23.0)),
        ("拉伸试验;纬向;温度 80℃", (90.0, 80.0)),
        ("Tensile test of a warp knitted fabric, washed at 60 °C", (None, None)),
        ("Tensile test, textile course 3, weft yarn 78 dtex", (None, None)),
        ("Strip test 10 K/min, 100 C and 80 C", (None, None)),
    ],
)
def test_a_line_above_a_table_tells_the_direction_and_the_temperature(
    title: str, expected: tuple[float | None, float | None]
) -> None:
    """Neither was read, without a word: six files became one cloth at no temperature."""
    [found] = read(f"{title}\n\n{BELOW}")
    assert told(found) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("K7_course_105C_01.csv", (90.0, 105.0)),
        ("warp-23C.csv", (0.0, 23.0)),
        ("weft_-20degC.csv", (90.0, -20.0)),
        ("wale_washed_60C.csv", (0.0, None)),
        ("K7_3C.csv", (None, None)),
        ("K7.xlsx:course 80 °C", (90.0, 80.0)),
    ],
)
def test_a_name_tells_the_temperature(name: str, expected: tuple[float | None, float | None]) -> None:
    """Files of three temperatures were one cloth, and accepted."""
    from hyperfab.io.csv_sheet import CsvSheet
    from hyperfab.io.layout import PLAIN
    from hyperfab.io.titles import direction_told, temperature_told

    sheet = CsvSheet(name, ";", (), 1, (), (), {}, {}, (), PLAIN, ".", None)
    assert (direction_told(sheet), temperature_told(sheet)) == expected


def test_what_a_file_states_goes_before_its_name_and_the_room_behind_it() -> None:
    assert told(read(f"Test temperature;80;°C\n{BELOW}", "warp_23C.csv")[0]) == (0.0, 80.0)
    assert told(read(f"Room temperature;23;°C\n{BELOW}", "warp_105C.csv")[0]) == (0.0, 105.0)


def test_a_title_that_gainsays_the_name_of_its_file_is_refused() -> None:
    with pytest.raises(InputError, match="says weft here and is called warp") as caught:
        read(f"Tensile test, weft\n{BELOW}", "warp_1.csv")
    assert caught.value.line == 1
    [found] = read(f"# direction: weft\nTensile test, weft\n{BELOW}", "warp_1.csv")
    assert found.direction == 90.0


@pytest.mark.parametrize("head", ["dir", "Loading direction", "Cut"])
def test_a_column_of_words_of_directions_is_the_direction_whatever_it_is_called(head: str) -> None:
    """``dir`` was left aside and both directions were one cloth; a loading direction was asked for load or unload."""
    rows = [f"{way};{x};{y}\n" for way in ("wale", "course") for x, y in ((0, 0), (0.1, 1), (0.2, 3))]
    found = read(f"{head};strain [-];stress [MPa]\n{''.join(rows)}")
    assert [one.direction for one in found] == [0.0, 90.0]


def test_a_loading_direction_of_branches_is_the_branch_still() -> None:
    [found] = read("Loading direction;strain [-];stress [MPa]\nup;0;0\nup;0.1;1\ndown;0.05;0.4\n")
    assert found.branch is not None
    assert found.branch.tolist() == [1, 1, -1]


def test_specimens_under_titles_over_each_of_their_columns_have_their_directions() -> None:
    """As pandas writes columns of two levels: the directions were lost, and the fit of both together accepted."""
    names = ("course_1", "course_2", "wale_1")
    head = "specimen," + ",".join(f"{name},{name}" for name in names)
    text = f"{head}\nquantity{',strain [-],stress [MPa]' * 3}\nindex,,,,,,\n"
    text += "".join(f"{k},{','.join([f'{0.1 * k:.1f},{k * k}'] * 3)}\n" for k in range(4))
    found = read(text, "uniaxial.csv", test=None)
    assert [(one.specimen, one.direction) for one in found] == [
        ("course_1", 90.0), ("course_2", 90.0), ("wale_1", 0.0),
    ]  # fmt: skip


def test_foams_are_sheared_and_pressed_by_their_standards() -> None:
    """A quadruple shear was planar tension; a width is cut across."""
    kinds = ("ISO 1827 quadruple shear", "ISO 3386-1", "ISO 1798")
    assert [named_test(one).kind for one in kinds if named_test(one)] == ["simple-shear", "compression", "uniaxial"]  # type: ignore[union-attr]
    assert read(f"Direction;width\n{BELOW}")[0].direction == 90.0


def test_columns_of_two_directions_in_a_file_called_uniaxial_are_of_two_specimens() -> None:
    found = read("Strain [-];Wale stress [MPa];Course stress [MPa]\n0;0;0\n0.1;2;1\n0.2;5;3\n", "uniaxial K7.csv", None)
    assert [(one.mode, one.direction) for one in found] == [("uniaxial", 0.0), ("uniaxial", 90.0)]


def test_names_of_specimens_tell_the_temperature_where_all_do() -> None:
    rows = "".join(
        f"{name};{x};{y}\n" for name in ("wale_80C_1", "wale_23C_1") for x, y in ((0, 0), (0.1, 1), (0.2, 3))
    )
    found = read(f"specimen;strain [-];stress [MPa]\n{rows}")
    assert [told(one) for one in found] == [(0.0, 80.0), (0.0, 23.0)]
    found = read(f"specimen;strain [-];stress [MPa]\n{rows.replace('23C', 'RT')}")
    assert [told(one) for one in found] == [(0.0, 80.0), (0.0, 23.0)]
    [*_, last] = read(f"specimen;strain [-];stress [MPa]\n{rows.replace('23C', 'x')}")
    assert told(last) == (0.0, None)


def test_the_next_title_of_a_table_of_results_is_no_name_of_a_specimen() -> None:
    text = "Results\n;Specimen label;Width;Thickness\n;;mm;mm\n1;K7;50;1\n2;K8;50;1\n\n"
    assert read(text + BELOW)[0].specimen is None
    assert read("Direction;width\n" + BELOW)[0].direction == 90.0
