"""Fabric tests as machines export them: every dialect gives the same numbers, and nothing is read by guesswork."""

from __future__ import annotations

import codecs
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import layout
from hyperfab.io.specimen import Geometry
from hyperfab.numerics.hygiene import branches

PLAIN = (
    "# test: uniaxial\nstretch [-],stress [MPa],temperature [degC]\n"
    "1.05,0.0821,23.5\n1.1,0.1473,23.5\n1.275,0.31,23.6\n2.004,1.0123,23.6\n"
)
#: The same readings as a German machine exports them.
EXPORT = (
    "# Test: uniaxial\r\n# Prüfer: Jörg Weiß\r\nTemperatur-Nr;Stress;STRETCH;Temperature\r\n;[MPa];[-];(°C)\r\n"
    "1;0,0821;1,05;23,5\r\n2;0,1473;1,1;23,5\r\n3;0,31;1,275;23,6\r\n4;1,0123;2,004;23,6\r\n"
)


def one(text: str | bytes, **options: object) -> TestData:
    data = text if isinstance(text, bytes) else text.encode()
    [found] = read_tests(data, "a.csv", **options)  # type: ignore[arg-type]
    return found


def same(first: TestData, second: TestData) -> None:
    for name in ("stretch", "stress", "temperature_degC"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("ends", ["\r\n", "\n", "\r"])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_an_export_gives_the_bits_of_its_plain_twin(encoding: str, ends: str, separator: str) -> None:
    text = EXPORT.replace("\r\n", ends).replace(";", separator)
    found = one(text.encode(encoding))
    same(found, one(PLAIN))
    assert found.metadata["prüfer"] == "Jörg Weiß"
    assert found.notes == ("columns not used: Temperatur-Nr",)


def test_the_mark_of_utf_8_in_front_of_latin_1_is_read() -> None:
    found = one(codecs.BOM_UTF8 + EXPORT.encode("latin-1"))
    same(found, one(PLAIN))
    assert found.metadata["prüfer"] == "Jörg Weiß"


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace(",", "\t"),
        PLAIN.replace(",", ";"),
        PLAIN.replace("stretch [-],stress [MPa],temperature [degC]", "STRETCH,Stress (N/mm²),Temperature (°C)"),
        PLAIN.replace("\n", ",,\n").replace("#", "  #"),
        PLAIN.replace("1.05,0.0821", " 1.05 , 8.21E-02"),
        PLAIN.replace("1.05,0.0821", '"1.05","0.0821"'),
        PLAIN.replace("1.05,0.0821", '"1,05","0,0821"').replace("1.1,0.1473,23.5", '"1,1","0,1473","23,5"')
        .replace("1.275,0.31,23.6", '"1,275","0,31","23,6"').replace("2.004,1.0123,23.6", '"2,004","1,0123","23,6"')
        .replace("8,23.5", '8,23.5').replace('"0,0821",23.5', '"0,0821","23,5"'),
        PLAIN.replace("stretch [-],stress [MPa],temperature [degC]", "stretch,stress_MPa,temperature_degC"),
        "sep=,\n" + PLAIN,
        PLAIN + "\n,,\n\n",
        PLAIN.replace("# test: uniaxial\n", "# test: uniaxial\n# test: uniaxial\n\n"),
    ],
)  # fmt: skip
def test_each_dialect_gives_the_same_bits(text: str) -> None:
    same(one(text), one(PLAIN))


def test_strain_and_prefixes_move_the_decimal_mark_without_rounding() -> None:
    kilo = "# test: uniaxial\nstretch [%],stress [kPa]\n105,82.1\n110,147.3\n127.5,310\n200.4,1.0123e3\n"
    found = one(kilo)
    assert found.stretch.tobytes() == one(PLAIN).stretch.tobytes()
    assert found.stress.tobytes() == one(PLAIN).stress.tobytes()
    percent = one("# test: uniaxial\nstrain [%],stress [MPa]\n5,1\n10,2\n")
    assert percent.stretch.tobytes() == one("# test: uniaxial\nstrain,stress [MPa]\n.05,1\n.1,2\n").stretch.tobytes()


def test_psi_and_inches_agree_to_1e_12() -> None:
    metric = one(
        "# test: uniaxial\n# gauge length: 50.8 mm\n# width: 25.4 mm\n# thickness: 0.508 mm\n"
        "extension [mm],force [N]\n2.54,4.4482216152605\n5.08,11.12055403815125\n"
    )
    inches = one(
        "# test: uniaxial\n# Gauge_Length [in]: 2\n# width: 1 in\n# thickness: 20 mil\n"
        "force [lbf],extension [in]\n1,0.1\n2.5,0.2\n"
    )
    assert inches.stretch == pytest.approx(metric.stretch, rel=1e-14)
    assert inches.stress == pytest.approx(metric.stress, rel=1e-14)
    psi = one("# test: uniaxial\nstretch,stress [psi]\n1.05,50\n1.1,125\n")
    assert psi.stress == pytest.approx(metric.stress, rel=1e-14)  # 1 lbf on 1 x 0.02 in is 50 psi
    assert metric.stretch == pytest.approx([1.05, 1.1], rel=1e-15)


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("stretch;stress [MPa]\n1,234;0,5\n2,5;1\n", [1.234, 2.5]),  # 0,5 settles it
        ("stretch;stress [kPa]\n1,5;1.234,5\n2,5;2.345,0\n", [1.5, 2.5]),  # both marks in one cell
        ("stretch;stress [kPa]\n1,5;1.234.567\n2,5;2.345\n", [1.5, 2.5]),  # two groups
        ("stretch;stress [MPa]\n1.25;1,234.5\n2.5;2,345.5\n", [1.25, 2.5]),
        ("stretch;stress [kPa]\n1;500\n2;1000\n", [1.0, 2.0]),  # no mark at all
        ("stretch;stress [kPa]\n1,5;1 234,5\n2,5;2 345,0\n", [1.5, 2.5]),  # spaces as thousands separators
        ("stretch\tstress [MPa]\n1.234\t0.5\n1.5\t0.75\n", [1.234, 1.5]),
        (
            "stretch,stress [MPa]\n1.234,2.345\n1.345,3.456\n",
            [1.234, 1.345],
        ),  # commas separate, so dots are decimal
        ("stretch;stress [kPa]\n1,234E0;1,5\n2;3\n", [1.234, 2.0]),
    ],
)
def test_the_decimal_mark_follows_from_all_cells(text: str, answer: list[float]) -> None:
    assert one(text, test="uniaxial").stretch.tolist() == answer


@pytest.mark.parametrize("last", ["remark", "operator", "Bemerkung"])
def test_a_row_may_end_before_columns_that_no_law_needs(last: str) -> None:
    text = f"stretch,stress [MPa],{last}\n1.1,0.1,first\n1.2,0.2\n1.3,0.3,\n"
    assert one(text, test="uniaxial").stress.tolist() == [0.1, 0.2, 0.3]
    with pytest.raises(InputError, match="has 1 cells, the header has 3"):
        one(text.replace("1.2,0.2", "1.2"), test="uniaxial")


def test_thousands_are_read_where_the_file_shows_them() -> None:
    text = "stretch;stress [kPa]\n1,5;1.234.567,5\n2,5;2.345\n"
    assert one(text, test="uniaxial").stress.tolist() == [1234.5675, 2.345]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("stretch;stress [MPa]\n1,234;2,345\n1,345;3,456\n", 'read both ways.*--decimal "," or "."'),
        ("stretch;stress [MPa]\n1.234;2.345\n1.345;3.456\n", 'read both ways.*--decimal "." or ","'),
        ("stretch\tstress [kPa]\n1\t2,345\n2\t3,456\n", "line 2.*read both ways"),
        ("stretch;stress [MPa]\n1,25;0.5\n1,5;0.75\n", "one decimal mark"),
        ("stretch;stress [MPa]\n1,5;0,5\n2,5;1.234\n", "line 3.*thousand or not"),
    ],
)
def test_what_can_be_read_both_ways_is_refused_naming_the_option(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        one(text, test="uniaxial")


def test_the_option_settles_it() -> None:
    text = "stretch;stress [kPa]\n1;2,345\n2;3,456\n"
    assert one(text, test="uniaxial", columns=layout(decimal=",")).stress.tolist() == [0.002345, 0.003456]
    assert one(text, test="uniaxial", columns=layout(decimal=".")).stress.tolist() == [2.345, 3.456]
    with pytest.raises(UsageError, match="--decimal"):
        one(text, test="uniaxial", columns=layout(decimal="x"))


def test_true_stress_becomes_nominal_stress() -> None:
    for kind in ("uniaxial", "shear", "biaxial"):
        found = one(f"# test: {kind}\nstretch,true stress [MPa],stress sd [MPa]\n1.25,1,0.1\n2,4,0.2\n")
        assert found.stress.tolist() == [0.8, 2.0]
        assert found.stress_sd is not None
        assert found.stress_sd.tolist() == [0.08, 0.1]
        assert "true stress" in found.notes[0]


def test_force_and_extension_become_stress_by_the_specimen() -> None:
    body = "extension [mm],force [N]\n5,10\n10,20\n"
    strip = one(f"# gauge length: 50 mm\n# width: 25 mm\n# thickness: 0.8 mm\n{body}", test="shear")
    assert strip.stretch.tolist() == [1.1, 1.2]
    assert strip.stress.tolist() == [10 / 25 / 0.8, 20 / 25 / 0.8]
    assert (strip.membrane, strip.thickness_mm) == (False, 0.8)
    disc = one(f"# diameter: 100 mm\n# thickness: 0.5 mm\n{body}", test="biaxial")
    assert disc.stretch.tolist() == [1.05, 1.1]
    assert disc.stress == pytest.approx([10 / (math.pi * 50), 20 / (math.pi * 50)], rel=1e-15)
    option = one(body, test="uniaxial", geometry=Geometry(gauge_length=50.0, width=20.0))
    assert option.stress.tolist() == [0.5, 1.0]
    assert (option.membrane, option.stress_unit) == (True, "N/mm")


def test_membrane_stress_stays_force_per_width_until_a_thickness_is_known() -> None:
    text = "stretch,membrane stress [N/mm]\n1.1,0.5\n1.2,0.75\n"
    found = one(text, test="uniaxial")
    assert (found.stress.tolist(), found.membrane, found.stress_unit) == ([0.5, 0.75], True, "N/mm")
    found = one("# thickness: 0.5 mm\n" + text, test="uniaxial")
    assert (found.stress.tolist(), found.membrane, found.stress_unit) == ([1.0, 1.5], False, "MPa")
    found = one("# thickness: 0.5 mm\n" + text, test="uniaxial", geometry=Geometry(thickness=0.25))
    assert found.stress.tolist() == [2.0, 3.0]


@pytest.mark.parametrize("line", ["#\twidth: 25 mm", "# width\t: 25 mm", "#\twidth [mm]\t: 25", '"# width\t: 25 mm";;'])
def test_a_line_of_metadata_may_be_set_with_tabs(line: str) -> None:
    text = f"# test: uniaxial\n{line}\n# thickness: 0.8 mm\nstretch [-];force [N]\n1.1;2\n1.2;4\n"
    assert one(text).stress.tolist() == pytest.approx([0.1, 0.2])


def test_what_is_known_of_a_row_comes_from_columns_or_metadata() -> None:
    text = (
        "# temperature: 296.65 K\n# rate: 60 %/min\n"
        "specimen;direction;cycle;branch;time [min];stretch;stress [MPa];stretch 2\n"
        "A;warp;1;load;0;1,05;0,1;0,97\nA;warp;1;unload;0,5;1,02;0,05;0,98\n"
        "B;Weft;2;Load;1;1,05;0,2;0,96\nC;45;1;load;2;1,05;0,3;0,96\nC;45 deg;1;load;3;1,06;0,31;0,96\n"
    )
    warp, weft, bias = read_tests(text.encode(), "a.csv", test="uniaxial")
    assert (warp.specimen, warp.direction, warp.direction_name) == ("A", 0.0, "warp")
    assert (weft.specimen, weft.direction, weft.direction_name) == ("B", 90.0, "weft")
    assert (bias.direction, bias.direction_name, len(bias.stretch)) == (45.0, "45 deg", 2)
    for array, values in (
        (warp.branch, [1, -1]),
        (warp.cycle, [1, 1]),
        (warp.time_s, [0.0, 30.0]),
        (warp.temperature_degC, [23.5, 23.5]),
        (warp.rate_1_s, [0.01, 0.01]),
        (warp.stretch2, [0.97, 0.98]),
        (warp.lines, [4, 5]),
        (weft.lines, [6]),
    ):
        assert array is not None
        assert array.tolist() == pytest.approx(values, rel=1e-15, abs=1e-13)


def test_both_directions_measured_make_a_general_biaxial_test() -> None:
    text = "stretch 1,stretch 2,stress 1 [MPa],stress 2 [MPa]\n1.1,1.05,0.2,0.1\n1.2,1.1,0.3,0.2\n"
    found = one(text, test="biaxial")
    assert found.mode == "biaxial-general"
    assert found.stress2 is not None
    assert found.stress2.tolist() == [0.1, 0.2]
    assert one(text, test="biaxial-general").mode == "biaxial-general"


def test_several_tests_in_one_file_are_told_apart_by_their_column() -> None:
    text = "test,stretch,stress [MPa]\nuniaxial,1.1,0.1\nshear,1.1,0.15\nuniaxial,1.2,0.2\n"
    uniaxial, shear = read_tests(text.encode(), "a.csv")
    assert (uniaxial.mode, uniaxial.lines.tolist()) == ("uniaxial", [2, 4])
    assert (shear.mode, shear.lines.tolist()) == ("shear", [3])
    with pytest.raises(InputError, match=r"line 3.*given as uniaxial.*--shear"):
        read_tests(text.encode(), "a.csv", test="uniaxial")


def test_a_volumetric_test_is_volume_ratio_and_mean_stress() -> None:
    found = one("# test: volumetric\nvolume ratio,stress [MPa]\n0.99,-20\n0.98,-41\n")
    assert found.stretch.tolist() == [0.99, 0.98]


def test_a_pressure_beside_a_volume_ratio_is_a_mean_stress_that_pushes() -> None:
    found = one("volume ratio,pressure [MPa]\n1,0\n0.99,20\n0.98,41\n")
    assert found.mode == "volumetric"
    assert found.stress.tolist() == [0.0, -20.0, -41.0]
    with pytest.raises(InputError, match="no column gives a stress"):  # of a bulge, say, it is no stress
        one("stretch,pressure [MPa]\n1,0\n1.1,20\n1.2,41\n")


def test_no_row_is_dropped_in_silence() -> None:
    found = one(PLAIN + ",,\n,,\n1,0,23\n0.99,-0.001,23\n")
    assert len(found.stretch) == 6  # also the rows a relative objective cannot use
    assert found.left_out == {"blank row": 2}
    assert found.lines.tolist() == [3, 4, 5, 6, 9, 10]


ROWS = "stretch,stress [MPa]\n1.1,0.1\n1.2,0.2\n"


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("", "a.csv", "is empty"),
        ("\n\n\n", "a.csv", "is empty"),
        ("# test: uniaxial\n", "a.csv", "no header"),
        ("stretch,stress [MPa]\n", "line 1", "no rows"),
        ("stretch,stress [MPa]\n-,MPa\n", "line 1", "no rows"),
        ("1.1,0.1\n1.2,0.2\n", "line 1", "there is no header"),
        ("strecth,stress [MPa]\n1.1,0.1\n", "line 1", "no column gives a stretch; the columns are strecth"),
        ("stretch,stres [MPa]\n1.1,0.1\n", "line 1", "no column gives a stress"),
        ("stretch,stress\n1.1,0.1\n", 'line 1, column "stress"', "has no unit"),
        ("stretch,stress [degC]\n1.1,0.1\n", 'line 1, column "stress [degC]"', "no unit of stress"),
        ("stretch [mm],stress [MPa]\n1.1,0.1\n", "line 1", "no unit of dimensionless number"),
        ("stretch,stress [MPa]\n-,kPa\n1.1,0.1\n", "line 2", "keep one"),
        ("stretch,stress [MPa],Stress (kPa)\n1.1,0.1,1\n", "line 1", "two columns"),
        ("stretch,stress [MPa]\n1.1,0.1\n", "line 2", "has one row"),
        ("stretch,stress [MPa]\n1.1,0.1\n1.2\n", "line 3", "has 1 cells, the header has 2"),
        ("stretch,stress [MPa]\n1.1,0.1\n1.2,0.2,0.3\n", "line 3", "has 3 cells"),
        ("stretch,stress [MPa]\n1,1,0,1\n1,2,0,2\n", "line 2", "export with semicolons"),
        ("stretch,stress [MPa]\n1.1,NaN\n1.2,0.2\n", 'line 2, column "stress [MPa]"', "NaN is no reading"),
        ("stretch,stress [MPa]\n1.1,inf\n1.2,0.2\n", "line 2", "inf is no reading"),
        ("stretch,stress [MPa]\n1.1,1e999\n1.2,0.2\n", "line 2", "larger than any double"),
        ("stretch,stress [MPa]\n1.1,\n1.2,0.2\n", "line 2", "the cell is empty"),
        ("stretch,stress [MPa]\n1.1,0.1\n1.2,broken\n", "line 3", "broken is no number"),
        ("stretch,stress [MPa]\n1.1,1_0\n1.2,0.2\n", "line 2", "1_0 is no number"),
        ("stretch,stress [MPa]\n1.1,١\n1.2,0.2\n", "line 2", "is no number"),
        ("stretch,stress [MPa]\n1.1,0x10\n1.2,0.2\n", "line 2", "0x10 is no number"),
        ("stretch,stress [MPa]\n1.1,1.2.3\n1.2,0.2\n", "line 2", "1.2.3 is no number"),
        ('stretch,stress [MPa]\n"1.1,0.1\n1.2,0.2\n', "line 2", "quote"),
        ("stretch,stress [MPa]\n1.1,0.1\n1.1,0.2\n", "line 2", "is 1.1 in all 2 rows"),
        ("stretch,stress [MPa]\n0.0255,1.02\n0.13,1.12\n", "line 2", "swapped"),
        ("stretch,stress [MPa]\n-0.1,0.1\n1.1,0.2\n", "line 2", "impossible"),
        ("strain,stress [MPa]\n10,0.1\n80,0.2\n", 'line 3, column "strain"', "strain [%]"),
        ("extension [mm],force [N]\n1,1\n2,2\n", "extension", "gauge length"),
        ("# gauge length: 50 mm\nextension [mm],force [N]\n1,1\n2,2\n", "force", "# width: 25 mm"),
        (
            "# gauge length: 50\nextension [mm],force [N]\n1,1\n2,2\n",
            "line 1, key gauge length",
            "write 50mm",
        ),
        ("# thickness: -1 mm\n" + ROWS, "line 1", "not positive"),
        ("# thickness: 1 mm\n# thickness: 2 mm\n" + ROWS, "line 1", "and 2 mm in line 2"),
        ("# test: shear\n" + ROWS, "line 1", "given as uniaxial"),
        ("# test: twist\n" + ROWS, "line 1", "twist is no test"),
        ("# direction: up\n" + ROWS, "line 1", "warp, weft or degrees"),
        ("# temperature: 20\n" + ROWS, "line 1, key temperature", "write 20 degC"),
        ("stretch,stress [MPa],direction\n1.1,0.1,warp\n1.2,0.2,wrap\n", "line 3", "wrap is no direction"),
        ("stretch,stress [MPa],branch\n1.1,0.1,load\n1.2,0.2,\n", "line 3", "load or unload"),
        ("stretch,stress [MPa],cycle\n1.1,0.1,1\n1.2,0.2,1.5\n", "line 3", "no cycle number"),
        ("stretch,stress [MPa],stress sd [MPa]\n1.1,0.1,0\n1.2,0.2,1\n", "line 2", "standard deviation of 0"),
        ("time [s],stretch,stress [MPa]\n0,1.1,0.1\n2,1.2,0.2\n1,1.3,0.3\n", "line 4", "time goes back"),
        ("stretch,stress [MPa]\n1.1,0.1\x00\n1.2,0.2\n", "line 2", "is no text"),
    ],
)
def test_what_cannot_be_read_in_one_way_is_refused_with_place_and_remedy(text: str, place: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        read_tests(text.encode(), "a.csv", test="uniaxial")
    assert str(caught.value).startswith("a.csv")
    assert place in str(caught.value)
    assert said in str(caught.value)
    assert caught.value.remedy


def test_a_file_that_names_no_test_is_asked_for_one() -> None:
    with pytest.raises(InputError, match="# test: uniaxial"):
        read_tests(ROWS.encode(), "a.csv")


@given(
    st.lists(
        st.tuples(st.floats(1.0, 9.0), st.floats(1e-6, 1e4)),
        min_size=2,
        max_size=9,
    ).filter(lambda rows: len({row[0] for row in rows}) > 1),
    st.sampled_from([(";", ","), ("\t", ","), (";", "."), ("\t", "."), (",", ".")]),
    st.sampled_from(["utf-8", "utf-8-sig", "latin-1", "utf-16"]),
    st.sampled_from(["\n", "\r\n", "\r"]),
)
def test_every_double_survives_every_dialect(
    rows: list[tuple[float, float]], dialect: tuple[str, str], encoding: str, ends: str
) -> None:
    separator, mark = dialect
    cells = [[repr(a).replace(".", mark), repr(b).replace(".", mark)] for a, b in rows]
    text = ends.join(separator.join(row) for row in [["stretch", "stress [MPa]"], *cells]) + ends
    found = one(text.encode(encoding), test="uniaxial", columns=layout(decimal=mark))
    assert np.array_equal(found.stretch, [a for a, _ in rows])
    assert np.array_equal(found.stress, [b for _, b in rows])


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1.2,2e300", "line 3: no fabric carries 2e\\+300 MPa"),
        ("1.2,90000", "line 3: no fabric carries 90000 MPa"),
        ("1e100,1", "line 3: no fabric reaches a stretch of 1e\\+100"),
        ("1e-100,-1", "line 3: no fabric reaches a stretch of 1e-100"),
    ],
)
def test_what_no_fabric_ever_showed_is_a_wrong_unit(row: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        one(f"stretch,stress [MPa]\n1.1,0.1\n{row}\n", test="uniaxial")


def test_a_table_from_its_far_end_through_rest_is_read_from_the_other() -> None:
    """Nothing in it unloads; where times stand beside it, it is what was done."""
    rows = [(-0.2, -0.54), (-0.1, -0.15), (0.05, 0.06), (0.1, 0.13), (0.19, 0.5)]

    def read(rows: list[tuple[float, ...]], head: str) -> TestData:
        text = f"# test: simple-shear\n{head}\n" + "".join(",".join(map(str, row)) + "\n" for row in rows)
        [found] = read_tests(text.encode(), "shear.csv")
        return found

    head = "shear strain [-],shear stress [kPa]"
    found = read(rows, head)
    assert found.stretch.tolist() == [-0.19, -0.1, -0.05, 0.1, 0.2]  # the farther way is the positive one
    assert found.lines.tolist() == [7, 6, 5, 4, 3]
    assert branches(found.principal).tolist() == [1, 1, 1, 1, 1]
    assert any("other end" in note for note in found.notes)
    timed = read([(*row, 1.0 + k) for k, row in enumerate(rows)], head + ",time [s]")
    assert timed.lines.tolist() == [3, 4, 5, 6, 7]
    assert branches(timed.principal).tolist() == [-1, -1, -1, 1, 1]
    there_and_back = read([*rows, (0.0, 0.0), (-0.2, -0.5)], head)
    assert there_and_back.lines.tolist() == [3, 4, 5, 6, 7, 8, 9]


def test_of_several_specimens_in_a_file_each_is_turned_by_itself() -> None:
    rows = [("a", 1.4, 0.3), ("a", 1.1, 0.1), ("a", 0.8, -0.2), ("b", 1.1, 0.1), ("b", 1.4, 0.3)]
    text = "# test: uniaxial\nspecimen,stretch [-],stress [MPa]\n" + "".join(f"{n},{x},{y}\n" for n, x, y in rows)
    turned, as_read = read_tests(text.encode(), "both.csv")
    assert (turned.lines.tolist(), as_read.lines.tolist()) == ([5, 4, 3], [6, 7])
    assert [any("other end" in note for note in one.notes) for one in (turned, as_read)] == [True, False]
