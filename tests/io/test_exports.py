"""However a machine or an office writes a test, its readings are the same bits, or the message says what settles it."""

from __future__ import annotations

import re
import shlex
import zipfile
from io import BytesIO

import lab_exports
import machine_exports as exports
import numpy as np
import office_exports
import pytest
import stand_exports

from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.encoding import decode
from hyperfab.io.layout import layout
from hyperfab.io.specimen import Geometry

#: The strip, for files that do not state it.
STRIP = Geometry(gauge_length=100.0, width=50.0, thickness=0.5)
MACHINES = (
    "bluehill2",
    "bluehill3_spanish",
    "bluehill_universal",
    "testxpert2",
    "testxpert3_sheets",
    "testworks",
    "testsuite",
    "trapezium_japanese",
    "mark10",
    "statimat",
    "image_correlation",
    "gom",
    "excel_german",
    "excel_french",
    "excel_italian",
    "excel_portuguese",
    "membrane_in_5cm",
    "numpy_savetxt",
    "side_by_side",
    "stacked",
    "thousands",
    "percent_cells",
)
OTHERS = exports.others() | office_exports.office() | lab_exports.labs() | stand_exports.stands()
UNDECIDED = (
    exports.undecided() | office_exports.to_settle() | lab_exports.labs_to_settle() | stand_exports.stands_to_settle()
)


def read(data: bytes, name: str, **options: object) -> list[TestData]:
    full = name + (".xlsx" if data.startswith(b"PK") else ".csv")
    return read_tests(data, full, geometry=STRIP, clock=False, **{"test": "uniaxial", **options})  # type: ignore[arg-type]


def twins() -> list[TestData]:
    return [
        read_tests(text.encode(), "t")[0] for text in (exports.plain(), exports.plain_strain(), exports.plain_force())
    ]


def same_bits(found: list[TestData]) -> None:
    """A file in stretch, in strain and in force is each its own plain twin; mode and count are the same."""
    for part in found:
        assert any(
            part.stretch.tobytes() == twin.stretch.tobytes() and part.stress.tobytes() == twin.stress.tobytes()
            for twin in twins()
        )


@pytest.mark.parametrize("name", MACHINES)
def test_an_export_of_a_machine_is_read_as_it_is(name: str) -> None:
    found = read(getattr(exports, name)(), name)
    same_bits(found)
    assert len(found) == (2 if name in ("side_by_side", "stacked") else 1)


@pytest.mark.parametrize("name", OTHERS)
def test_files_of_other_habits_are_read_as_they_are(name: str) -> None:
    same_bits(read(OTHERS[name], name))


@pytest.mark.parametrize("name", UNDECIDED)
def test_a_guess_that_could_be_wrong_is_refused_with_the_option_that_settles_it(name: str) -> None:
    with pytest.raises(InputError) as caught:
        read(UNDECIDED[name], name)
    match = re.search(r"--columns (\"[^\"]*\"|'[^']*')", str(caught.value))
    assert match, caught.value
    [pasted] = shlex.split(match[1])
    same_bits(read(UNDECIDED[name], name, columns=layout([pasted])))


def test_properties_of_channels_that_could_be_readings_are_not_left_out() -> None:
    """Without a column of their own a row of words is refused, and a specimen named in its first row alone is data."""
    rows = [f"{k},{x},{f}" for k, (x, f) in enumerate(exports.raw())]
    with pytest.raises(InputError, match=r"line 3, .*Float is no number"):
        read(
            exports.joined(["Time,Extension,Force", "s,mm,N", "Float,Float,Float", "1,2,3", *rows]).encode(),
            "a",
        )
    named = ["Specimen,Time,Extension,Force", ",s,mm,N", f"A,{rows[0]}", *[f",{row}" for row in rows[1:]]]
    [found] = read(exports.joined(named).encode(), "b")
    assert len(found.stretch) == len(rows)
    [told] = read(stand_exports.stands()["channels_with_properties"], "c")
    assert told.left_out == {"property of the channels, no reading": 4}


@pytest.mark.parametrize(
    ("heads", "plain", "measured"),
    [
        ("eyy [1] - Lagrange,Force [N]", "green strain,force [N]", True),
        ("Exx (Lagrange),Force [N]", "green strain,force [N]", True),
        ("eyy [1] - Hencky,Force [N]", "true strain,force [N]", True),
        ("Dehnung (log) [-],Kraft [N]", "true strain,force [N]", True),
        ("strain [-],stress (Cauchy) [MPa]", "strain,true stress [MPa]", True),
        ("Dehnung [-],Spannung (wahr) [MPa]", "strain,true stress [MPa]", True),
        ("eyy [1] - engr.,Force [N]", "strain,force [N]", False),
    ],
)
def test_a_measure_of_strain_or_stress_beside_the_name_is_obeyed(heads: str, plain: str, measured: bool) -> None:
    rows = "".join(f"{e},{s}\n" for e, s in exports.PULL)
    [found] = read(f"{heads}\n{rows}".encode(), "a")
    [twin] = read(f"{plain}\n{rows}".encode(), "b")
    [engineering] = read(f"strain,{plain.split(',')[1].removeprefix('true ')}\n{rows}".encode(), "c")
    assert found.stretch.tobytes() == twin.stretch.tobytes()
    assert found.stress.tobytes() == twin.stress.tobytes()
    same = found.stretch.tobytes() + found.stress.tobytes()
    assert (same != engineering.stretch.tobytes() + engineering.stress.tobytes()) == measured


def test_a_strain_that_is_not_read_is_not_taken_for_another() -> None:
    rows = "".join(f"{e},{s}\n" for e, s in exports.PULL)
    with pytest.raises(InputError, match="no column gives a stretch") as caught:
        read(f"eyy (Almansi),Stress [MPa]\n{rows}".encode(), "a")
    assert "--columns" not in str(caught.value)


@pytest.mark.parametrize("head", ["E11 [-],Force [N]", "Eyy,Force [N]", "strain [-],S11 [MPa]", "E_xx [%],S_xx [kPa]"])
def test_the_symbol_of_a_tensor_does_not_tell_which_strain_or_stress_it_is(head: str) -> None:
    """E is Green's strain and S a Piola or Cauchy stress, as often as not: at 1.9 one for the other is twofold."""
    rows = "".join(f"{e},{s}\n" for e, s in exports.PULL)
    with pytest.raises(InputError, match="no column gives a stre") as caught:
        read(f"{head}\n{rows}".encode(), "a")
    assert "=strain" not in str(caught.value)
    assert "=stress" not in str(caught.value)
    if head.startswith("E11"):
        assert '--columns "E11 [-]=green strain [-]' in str(caught.value)


def test_the_measure_of_a_strain_is_kept_in_what_is_proposed() -> None:
    rows = "".join(f"{e},{s}\n" for e, s in exports.PULL)
    with pytest.raises(InputError, match=r"epsY_log \[-\]=true strain \[-\]"):
        read(f"epsY_log [-],Force [N]\n{rows}".encode(), "a")


def test_what_pulls_counts_positive_whatever_the_load_cell_says() -> None:
    """An extended specimen that pushes back is no material: its load cell counts pulling as negative."""
    rows = "".join(f"{x},-{f}\n" for x, f in exports.raw())
    [found] = read(f"Extension (mm),Load (N)\n0,0.01\n{rows}".encode(), "a")
    assert found.stress[1:].tobytes() == twins()[2].stress.tobytes()
    assert any("counts pushing as positive" in note for note in found.notes)
    pushes = "".join(f"-{x},-{f}\n" for x, f in exports.raw())
    [pushed] = read(f"Extension (mm),Load (N)\n{pushes}".encode(), "a")
    assert pushed.stress.max() < 0.0  # shortened and pushed: nothing is turned


def test_force_by_the_fineness_of_a_yarn_is_told_as_such() -> None:
    text = "Elongation (%),Tenacity (gf/den)\n5,0.1\n10,0.2\n"
    with pytest.raises(InputError, match=r"Tenacity \(gf/den\) is the force by the fineness of a yarn") as caught:
        read(text.encode(), "yarn")
    assert '--columns "Tenacity (gf/den)=force [gf]"' in str(caught.value)


def test_a_slip_in_a_number_at_the_end_is_no_closing_row() -> None:
    text = "Dehnung [%];Spannung [MPa]\n1;0,1\n2;0,2\n3;0,3\nO4;0,4\n"
    with pytest.raises(InputError, match=r"line 5.*O4 is no number"):
        read(text.encode(), "slip")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "bluehill3_spanish",
            {"width_mm": 50.0, "thickness_mm": 0.5, "gauge_length_mm": 100.0, "direction": 0.0},
        ),
        ("testxpert2", {"width_mm": 50.0, "thickness_mm": 0.5, "gauge_length_mm": 100.0, "direction": 0.0}),
        ("bluehill2", {"width_mm": 50.0, "gauge_length_mm": 100.0, "specimen": "A-1"}),
        ("testworks", {"width_mm": 50.0, "gauge_length_mm": 100.0}),
    ],
)
def test_a_preamble_gives_sizes_and_direction(name: str, expected: dict[str, object]) -> None:
    [found] = read_tests(getattr(exports, name)(), name, test="uniaxial", clock=False)
    assert {key: getattr(found, key) for key in expected} == expected


def test_a_machine_names_its_test_and_its_temperature() -> None:
    [found] = read_tests(exports.bluehill3_spanish(), "k17.csv")
    assert found.mode == "uniaxial"
    assert found.temperature_degC is not None
    assert found.temperature_degC.tolist() == [23.0] * 10


@pytest.mark.parametrize(
    ("name", "heads", "test"),
    [
        ("lot3-uniaxial-2.csv", "strain [-],stress [MPa]", "uniaxial"),
        ("planar tension.csv", "strain [-],stress [MPa]", "shear"),
        ("k_equibiaxial.csv", "strain [-],stress [MPa]", "biaxial"),
        ("a.csv", "shear strain [-],shear stress [MPa]", "simple-shear"),
        ("a.csv", "stretch 1,stress 1 [MPa],stretch 2,stress 2 [MPa]", "biaxial-general"),
    ],
)
def test_a_file_is_recognised_by_its_name_or_its_columns(name: str, heads: str, test: str) -> None:
    columns = heads.count(",") + 1
    rows = "".join(",".join(["1.1" if k else "1.2"] * columns) + "\n" for k in range(2))
    [found] = read_tests(f"{heads}\n{rows}".encode(), name)
    assert found.mode == test


@pytest.mark.parametrize(
    ("title", "test"),
    [
        ("Zugversuch nach ISO 13934-1", "uniaxial"),
        ("Planar tension, lot 7", "shear"),
        ("Lot 7 of March", None),
    ],
)
def test_a_file_is_recognised_by_a_title_that_stands_in_a_line_by_itself(title: str, test: str | None) -> None:
    """Also where the line is filled up with empty cells, as a spreadsheet fills it."""
    for line in (title, f"{title};;"):
        text = f"{line}\nPrüfer;Meier;\n\nDehnung [%];Spannung [MPa];Bemerkung\n10;0,2;\n20;0,4;ok\n"
        if test is None:
            with pytest.raises(InputError, match="does not say which test it is"):
                read_tests(text.encode(), "k17.csv")
        else:
            assert read_tests(text.encode(), "k17.csv")[0].mode == test


@pytest.mark.parametrize(
    "title",
    [
        "Biaxial tensile test of coated fabric, MSAJ/M-02-1995",
        "Biaxial test,knitted fabric,cruciform",
        "Biaxialer Zugversuch EN 17117-1",
    ],
)
def test_loads_and_strains_along_warp_and_fill_are_one_biaxial_test_where_a_title_says_so(title: str) -> None:
    """Without it they could as well be two strips side by side."""
    head = "Stress warp [MPa],Stress fill [MPa],Strain warp [%],Strain fill [%]"
    table = f"{head}\n1,2,0.1,0.4\n2,4,0.2,0.7\n"
    [found] = read_tests(f"{title}\n{table}".encode(), "k17.csv")
    assert found.mode == "biaxial-general"
    with pytest.raises(InputError, match="does not say which test it is"):
        read_tests(table.encode(), "k17.csv")


@pytest.mark.parametrize("line", ["Shear modulus,3,MPa", "Test speed,10,mm/min", "Tensile strength,high"])
def test_a_setting_is_no_title(line: str) -> None:
    with pytest.raises(InputError, match="does not say which test it is"):
        read_tests(f"{line}\nelongation [%],stress [MPa],note\n10,0.2,\n20,0.4,ok\n".encode(), "k17.csv")


def test_closing_rows_and_errors_of_a_spreadsheet_are_counted() -> None:
    [found] = read(OTHERS["nv_rows"], "a")
    assert found.left_out == {"no reading (#NV)": 1}
    [found] = read(exports.excel_german(), "a")
    assert sum(found.left_out.values()) == 3  # a mean, a blank row, a line of words
    [found] = read(exports.excel_portuguese(), "a")
    assert sum(found.left_out.values()) == 3


def test_columns_left_aside_are_named_and_a_temperature_is_understood() -> None:
    rows = "".join(f"{e},{s},40,55\n" for e, s in exports.PULL)
    [found] = read(f"strain [-],stress [MPa],Temp [C],humidity\n{rows}".encode(), "a")
    assert found.notes == ("columns not used: humidity",)
    assert found.temperature_degC is not None
    assert found.temperature_degC[0] == 40.0
    assert "Temp [C] is temperature" in found.understood


def test_general_biaxial_tests_may_hold_an_axis_and_shrink_along_one() -> None:
    rows = "".join(f"1,{1 + k / 10},{k / 10},{k / 5},{0 if k == 0 else 0.01}\n" for k in range(6))
    text = f"stretch 1,stretch 2,stress 1 [MPa],stress 2 [MPa],stress sd [MPa]\n{rows}"
    [found] = read_tests(text.encode(), "a.csv", test="biaxial")
    assert found.mode == "biaxial-general"
    assert found.stress_sd is not None
    assert found.stress_sd.tolist() == [0.01] * 6  # the zeroed first reading is as sure as the surest
    rows = "".join(f"{0.85 + k / 10},{1.1},{k / 10},{k / 5}\n" for k in range(6))
    [found] = read_tests(f"stretch 1,stretch 2,stress 1 [MPa],stress 2 [MPa]\n{rows}".encode(), "a.csv", test="biaxial")
    assert found.stretch.min() == pytest.approx(0.85)


def test_a_hold_in_time_is_a_test() -> None:
    text = "time [s],stretch,stress [MPa]\n0,1.5,1\n1,1.5,0.8\n5,1.5,0.7\n"
    [found] = read_tests(text.encode(), "a.csv", test="uniaxial")
    assert found.stretch.tolist() == [1.5] * 3


def test_pushing_that_counts_positive_is_turned_round() -> None:
    rows = "".join(f"{k * 10},{k}\n" for k in range(1, 6))
    expected = [0.9, 0.8, 0.7, 0.6, 0.5]
    for heads in ("Stauchung [%],Druckspannung [kPa]", "Compressive strain (%),Compressive stress (kPa)"):
        [found] = read_tests(f"{heads}\n{rows}".encode(), "a.csv", test="uniaxial")
        assert found.stretch == pytest.approx(expected)
        assert found.stress == pytest.approx([-k / 1000 for k in range(1, 6)])
    [found] = read_tests(f"# test: compression\nstrain [%],stress [kPa]\n{rows}".encode(), "a.csv")
    assert found.stretch == pytest.approx(expected)
    gap = "".join(f"{10 - k},{k}\n" for k in range(6))
    [found] = read_tests(
        f"Gap [mm]\tNormal force [N]\n{gap.replace(',', chr(9))}".encode(),
        "a.csv",
        test="uniaxial",
        geometry=Geometry(diameter=20.0),
    )
    assert found.stretch == pytest.approx([1, *expected])
    assert found.stress[-1] == pytest.approx(-5 / (np.pi * 100))


def test_a_time_that_goes_back_is_told_only_where_time_is_used() -> None:
    text = b"time [s],strain [-],stress [MPa]\n0.8,0.1,1\n0.9,0.2,2\n0.10,0.3,3\n"
    assert len(read_tests(text, "a.csv", test="uniaxial", clock=False)) == 1
    with pytest.raises(InputError, match=r"time goes back.*--columns \"time \[s\]=aside\""):
        read_tests(text, "a.csv", test="uniaxial")
    dropped = read_tests(text, "a.csv", test="uniaxial", columns=layout(["time [s]=aside"]))
    assert dropped[0].time_s is None


def test_a_clock_counts_from_its_first_row_past_midnight() -> None:
    text = "time,strain [-],stress [MPa]\n23:59:59,0.1,1\n00:00:01.5,0.2,2\n"
    [found] = read_tests(text.encode(), "a.csv", test="uniaxial")
    assert found.time_s is not None
    assert found.time_s.tolist() == [0.0, 2.5]


def test_tables_of_different_columns_are_settled_by_skip_rows() -> None:
    rows = [f"{e},{s}" for e, s in exports.PULL]
    text = "\n".join(
        [
            "strain [-],stress [MPa]",
            *rows,
            "",
            "extension [mm],force [N]",
            *[f"{x},{f}" for x, f in exports.raw()],
        ]
    )
    with pytest.raises(InputError, match=r"--skip-rows 12"):
        read(text.encode(), "a")
    same_bits(read(text.encode(), "a", columns=layout(skip_rows=12)))


def test_a_gauge_length_and_another_distance_of_the_grips_are_no_guess() -> None:
    text = exports.joined(
        [
            "Gauge length: 50 mm",
            "Grip separation: 100 mm",
            "Width: 50 mm",
            "Extension (mm),Load (N)",
            *[f"{x},{f}" for x, f in exports.raw()],
        ]
    )
    with pytest.raises(InputError, match=r"--gauge-length 50mm .* --gauge-length 100mm"):
        read_tests(text.encode(), "a.csv", test="uniaxial")
    same_bits(read(text.encode(), "a"))


@pytest.mark.parametrize(
    ("page", "text"),
    [
        ("cp1252", "Prüfzeit;Kraft [N];\u201cx\u201d \u20ac"),
        ("mac_roman", "Längenänderung [mm];Prüfkraft [N]"),
        ("cp1251", "Время;Усилие;Деформация"),
        ("cp932", "時間,試験力,ストローク"),
        ("gb18030", "力,位移,时间"),
        ("gb18030", "宽度,50,mm\n厚度,0.8,mm\n标距,100,mm\n位移(mm),力(N)\n10,2.6"),
        ("cp1252", "T [°C];stress [N/mm²];µ"),
    ],
)
def test_code_pages_are_told_by_their_words(page: str, text: str) -> None:
    assert decode(text.encode(page)) == text


def test_a_title_on_the_command_line_tells_the_code_page() -> None:
    text = exports.joined(["변위;하중", *[f"{x};{f}" for x, f in exports.raw()]]).encode("euc_kr")
    same_bits(read(text, "a", columns=layout(["변위=extension [mm],하중=force [N]"])))


def test_an_option_for_a_column_that_is_nowhere_is_refused() -> None:
    with pytest.raises(UsageError, match="write it as in"):
        layout(["Kraft"])
    with pytest.raises(UsageError, match="no unit"):
        layout(["Kraft=force [quux]"])


@pytest.mark.parametrize("title", ["Q", "Q [kPa]", "2"])
def test_a_column_is_named_with_its_unit_or_without(title: str) -> None:
    """Without it the column was read so, and then said to be in no file."""
    columns = layout([f"{title}=stress [kPa]"])
    found = read_tests(b"# test: uniaxial\nstrain [-],Q [kPa]\n0.1,100\n0.2,200\n", "a.csv", columns=columns)
    assert found[0].stress.tolist() == [0.1, 0.2]
    assert found[0].chosen == columns.columns


def workbook_with(part: str, data: bytes) -> bytes:
    stream = BytesIO(exports.percent_cells())
    with zipfile.ZipFile(stream, "a") as book:
        book.writestr(part, data)
    return stream.getvalue()


def test_a_workbook_with_macros_declarations_or_a_bomb_in_it_is_refused() -> None:
    with pytest.raises(InputError, match="macros"):
        read(workbook_with("xl/vbaProject.bin", b"x"), "a")
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w") as book:
        book.writestr("[Content_Types].xml", "<Types/>")
        book.writestr("xl/workbook.xml", '<!DOCTYPE a [<!ENTITY b "c">]><workbook/>')
    with pytest.raises(InputError, match="document type"):
        read(stream.getvalue(), "a")
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("[Content_Types].xml", "<Types/>")
        book.writestr("xl/workbook.xml", b" " * (257 * 2**20))
    with pytest.raises(InputError, match="unpacks to more than"):
        read(stream.getvalue(), "a")


def test_formulas_that_no_program_has_computed_are_named() -> None:
    """A workbook written by a script holds formulas without values: it was said that no sheet has a table."""
    rows = [["strain", "stress"], ["%", "MPa"], *[[(str(10 * i),), (str(0.06 * i),)] for i in range(1, 9)]]
    book, bare = BytesIO(exports.workbook({"Werte": rows})), BytesIO()
    with zipfile.ZipFile(book) as whole, zipfile.ZipFile(bare, "w") as copy:
        for part in whole.namelist():
            text = whole.read(part).decode()
            copy.writestr(part, re.sub(r'(<c r="B\d+">)<v>[\d.]+</v>', r"\1<f>A1*0.006</f><v></v>", text))
    with pytest.raises(InputError, match=r"k\.xlsx:Werte, line 3: has a formula whose value .* save it again"):
        read_tests(bare.getvalue(), "k.xlsx", test="uniaxial")


def test_curves_side_by_side_in_a_workbook_may_end_one_before_the_other() -> None:
    """A workbook stores no empty cells behind the last one of a row: such a row is no torn one."""
    rows: list[list[object]] = [["strain", "stress", "strain", "stress"], ["%", "MPa", "%", "MPa"]]
    for k, (e, s) in enumerate(exports.PULL):
        rows.append([(e,), (s,), (e,), (s,)] if k < len(exports.PULL) - 2 else [(e,), (s,), None, None])
    first, second = read_tests(exports.workbook({"Werte": rows}), "k.xlsx", test="uniaxial")
    assert len(first.stress) == len(exports.PULL)
    assert np.array_equal(second.stress, first.stress[:-2])


def test_sizes_on_a_sheet_without_readings_are_those_of_the_specimens() -> None:
    pull = [["extension", "force"], ["mm", "N"], *[[(x,), (f,)] for x, f in exports.raw()]]
    sizes: list[list[object]] = [
        ["Operator", "mk"], ["Gauge length", ("50",), "mm"], ["Specimen width", ("25",), "mm"], ["Date", "2025-03-02"],
    ]  # fmt: skip
    bare = read_tests(exports.workbook({"Curves": pull}), "k.xlsx", test="uniaxial", geometry=STRIP)
    [told] = read_tests(exports.workbook({"Parameters": sizes, "Curves": pull}), "k.xlsx", test="uniaxial")
    assert (told.gauge_length_mm, told.width_mm) == (50.0, 25.0)
    assert np.array_equal(told.stress, bare[0].stress)
    # What the sheet of the readings states itself comes first.
    own = exports.workbook({"Parameters": sizes, "Curves": [["Width", ("30",), "mm"], *pull]})
    [other] = read_tests(own, "k.xlsx", test="uniaxial")
    assert (other.gauge_length_mm, other.width_mm) == (50.0, 30.0)


def test_a_sheet_is_picked_by_name() -> None:
    rows = [["strain", "stress"], [None, "MPa"], *[[(e,), (s,)] for e, s in exports.PULL]]
    other = [["extension [mm]", "force [N]"], *[[(x,), (f,)] for x, f in exports.raw()]]
    book = exports.workbook({"Probe 1": rows, "roh": other})
    with pytest.raises(InputError, match=r"Probe 1"):
        read_tests(book, "k.xlsx", test="uniaxial", geometry=STRIP)
    same_bits(read_tests(book, "k.xlsx:roh", test="uniaxial", geometry=STRIP))
    with pytest.raises(InputError, match="has no sheet nein; there is Probe 1, roh"):
        read_tests(book, "k.xlsx:nein", test="uniaxial")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\xd0\xcf\x11\xe0" + bytes(20), "old Excel"),
        (b"\x89HDF\r\n", "HDF5"),
        (b"%PDF-1.7", "PDF"),
        (b"PK\x03\x04" + bytes(40), "workbook"),
    ],
)
def test_other_kinds_of_file_are_named(data: bytes, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(data, "a")
