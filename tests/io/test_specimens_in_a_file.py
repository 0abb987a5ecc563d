"""Several specimens in one file, however labelled, and what is proposed where a heading does not say what it holds."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.cells import shape
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import layout
from hyperfab.io.specimen import Geometry

STRAIN = np.linspace(0.0, 1.2, 13)
PULLS = [gain * (1.0 - np.exp(-2.0 * STRAIN)) for gain in (1.0, 1.1, 0.95)]


def table(heads: str, columns: list[np.ndarray], counts: list[int] | None = None) -> bytes:
    """Return rows of columns; a column with fewer readings ends in empty cells."""
    counts = counts or [len(STRAIN)] * len(columns)
    rows = [
        ",".join(f"{column[k]:.6g}" if k < count else "" for column, count in zip(columns, counts, strict=True))
        for k in range(len(STRAIN))
    ]
    return "\n".join([heads, *rows, ""]).encode()


def pairs() -> list[np.ndarray]:
    return [one for pull in PULLS for one in (STRAIN, pull)]


def same(found: list[TestData], counts: tuple[int, ...] = (13, 13, 13)) -> None:
    assert [len(part.stretch) for part in found] == list(counts)
    for part, pull, count in zip(found, PULLS, counts, strict=False):
        assert part.stretch == pytest.approx(1.0 + STRAIN[:count], rel=1e-5)
        assert part.stress == pytest.approx(pull[:count], rel=1e-5, abs=1e-12)
    assert len({part.specimen for part in found}) == len(found)


@pytest.mark.parametrize(
    "heads",
    [
        "Strain_1,Stress_1 [MPa],Strain_2,Stress_2 [MPa],Strain_3,Stress_3 [MPa]",
        "strain A,stress A [MPa],strain B,stress B [MPa],strain C,stress C [MPa]",
        "Dehnung 1,Spannung 1 [MPa],Dehnung 2,Spannung 2 [MPa],Dehnung 3,Spannung 3 [MPa]",
        "Sample A strain,Sample A stress [MPa],Sample B strain,Sample B stress [MPa],Sample C strain,"
        "Sample C stress [MPa]",
    ],
)
def test_pairs_of_columns_are_specimens_and_may_end_early(heads: str) -> None:
    same(read_tests(table(heads, pairs()), "a.csv", test="uniaxial"))
    short = table(heads, pairs(), [13, 13, 9, 9, 11, 11])
    same(read_tests(short, "a.csv", test="uniaxial"), (13, 9, 11))


@pytest.mark.parametrize(
    "heads",
    [
        "Strain,Stress 1 [MPa],Stress 2 [MPa],Stress 3 [MPa]",
        "Strain,Stress A [MPa],Stress B [MPa],Stress C [MPa]",
        "Strain,Sample A stress [MPa],Sample B stress [MPa],Sample C stress [MPa]",
    ],
)
def test_stresses_of_several_specimens_share_a_strain(heads: str) -> None:
    same(read_tests(table(heads, [STRAIN, *PULLS]), "a.csv", test="uniaxial"))


def test_two_numbers_are_axes_unless_the_test_has_one() -> None:
    data = table("strain 1,stress 1 [MPa],strain 2,stress 2 [MPa]", pairs()[:4])
    [both] = read_tests(data, "a.csv")
    assert both.mode == "biaxial-general"
    same(read_tests(data, "a.csv", test="uniaxial"), (13, 13))
    same(read_tests(b"# test: uniaxial\n" + data, "a.csv"), (13, 13))


def test_symbols_of_axes_are_no_specimens() -> None:
    data = table("strain,sigma 1 [MPa],sigma 2 [MPa],sigma 3 [MPa]", [STRAIN, *PULLS])
    with pytest.raises(InputError, match="say which"):
        read_tests(data, "a.csv", test="uniaxial")


def test_what_is_stated_above_the_first_table_holds_for_those_below() -> None:
    head = "Richtung;Schuss\nPrüfung;Zugversuch\nBreite;40;mm\nEinspannlänge;80;mm\n"
    tables = ""
    for number, pull in enumerate(PULLS, 1):
        rows = "".join(f"{80.0 * e:.4f};{40.0 * s:.6f}\n" for e, s in zip(STRAIN, pull, strict=True))
        tables += f"\nProbe {number}\nWeg;Standardkraft\nmm;N\n{rows}".replace(".", ",")
    found = read_tests((head + tables).encode(), "a.csv")
    assert [part.direction_name for part in found] == ["weft"] * 3
    assert [part.specimen for part in found] == ["1", "2", "3"]
    for part, pull in zip(found, PULLS, strict=True):
        assert part.mode == "uniaxial"
        assert part.stress == pytest.approx(pull, rel=1e-5, abs=1e-7)
        assert part.stretch == pytest.approx(1.0 + STRAIN, rel=1e-5)


def test_what_stands_above_a_later_table_is_that_ones_own() -> None:
    tables = "".join(
        f"Width: {width} mm\nstrain,force [N]\n" + "".join(f"{e:.3f},{width * e:.4f}\n" for e in STRAIN)
        for width in (10, 20)
    )
    one, two = read_tests(tables.encode(), "a.csv", test="uniaxial")
    assert (one.width_mm, two.width_mm) == (10.0, 20.0)
    assert one.stress == pytest.approx(two.stress, rel=1e-4)


def pasted(data: bytes, name: str, **options: object) -> list[TestData]:
    """Read what is refused with the option that its message shows, until it is read; the last readings."""
    said: list[str] = []
    for _ in range(3):
        try:
            return read_tests(data, name, columns=layout(said), **options)  # type: ignore[arg-type]
        except InputError as error:
            [option] = re.findall(r"--columns (\"[^\"]*\"|'[^']*')", str(error))
            said = shlex.split(option)
    raise AssertionError(said)


@pytest.mark.parametrize("form", ["%.6f,%.6f", "%.6e,%.6e"])
def test_a_stretch_without_a_heading_is_proposed_as_one_though_a_compression_began_it(form: str) -> None:
    stretch = np.linspace(0.5, 2.1, 17)
    stress = stretch - stretch**-2
    data = "".join(form % row + "\n" for row in zip(stretch, stress, strict=True)).encode()
    [found] = pasted(data, "a.txt", test="uniaxial")
    assert found.stretch == pytest.approx(stretch)


def test_a_strain_without_a_heading_stays_one() -> None:
    stress = [f"{0.1 * k:.2f}" for k in range(1, 30)]
    assert shape([f"{0.04 * k:.4f}" for k in range(1, 30)], stress=stress) == "strain [-]"


@pytest.mark.parametrize(
    "heads",
    ["l1,l2,P1 (MPa),P2 (MPa)", "lambda_1,lambda_2,P_11,P_22", "λ1,λ2,t1 [MPa],t2 [MPa]"],
)
def test_what_is_proposed_for_two_axes_is_read_when_pasted(heads: str) -> None:
    l1, l2 = np.full(13, 1.3), np.linspace(0.9, 1.3, 13)
    data = table(heads, [l1, l2, l1 - 0.9, l2 - 0.8])
    [found] = pasted(data, "a.csv")
    assert found.mode == "biaxial-general"
    assert found.stretch2 == pytest.approx(l2, rel=1e-5)
    assert found.stress2 == pytest.approx(l2 - 0.8, rel=1e-4)


def test_a_unit_that_lacks_is_proposed_beside_those_already_given() -> None:
    data = table("lambda_1,lambda_2,P_11,P_22", [STRAIN + 1.0, STRAIN + 1.0, *PULLS[:2]])
    said = layout(["P_11=stress [kPa],P_22=stress 2"])
    with pytest.raises(InputError, match=re.escape('--columns "P_11=stress [kPa],P_22=stress 2 [MPa]"')):
        read_tests(data, "a.csv", columns=said)


def test_a_stretch_that_is_called_a_strain_is_told_for_what_it_is() -> None:
    data = table("strain,stress [MPa]", [1.0 + STRAIN, PULLS[0]])
    with pytest.raises(InputError, match=re.escape('say --columns "strain=stretch"')):
        read_tests(data, "a.csv", test="uniaxial")
    [found] = read_tests(data, "a.csv", test="uniaxial", columns=layout(["strain=strain [-]"]))
    assert found.stretch[0] == 2.0


@pytest.mark.parametrize(("most", "unit"), [(0.3, "-"), (15.0, "%")])
def test_a_strain_is_proposed_as_a_share_or_in_per_cent_by_its_size(most: float, unit: str) -> None:
    rows = "".join(f"{most * k / 10:.3f},{0.1 * k:.2f}\n" for k in range(11))
    with pytest.raises(InputError, match=re.escape(f'--columns "Strain=strain [{unit}],Tx=stress [MPa]"')):
        read_tests(f"Strain,Tx\n{rows}".encode(), "a.csv", test="uniaxial")


@pytest.mark.parametrize(
    ("heads", "ways"),
    [
        ("Strain,Course stress [MPa],Wale stress [MPa]", ["weft", "warp"]),
        ("Dehnung,Spannung Kette [MPa],Spannung (Schuss) [MPa]", ["warp", "weft"]),
        ("strain,stress_45deg [MPa],stress_90deg [MPa]", ["45 deg", "weft"]),
        ("strain,warp_stress_MPa,weft_stress_MPa", ["warp", "weft"]),
        ("strain,stress_warp_MPa,stress_weft_MPa", ["warp", "weft"]),
        ("strain,Warp 1 stress [MPa],Warp 2 stress [MPa]", ["warp", "warp"]),
        ("strain,stress MD1 [MPa],stress CD1 [MPa]", ["warp", "weft"]),
        ("strain,Weft 1 [MPa],Weft 2 [MPa]", ["weft", "weft"]),
    ],
)
def test_a_title_tells_the_direction_of_its_specimen(heads: str, ways: list[str]) -> None:
    data = table(heads, [STRAIN, *PULLS[:2]])
    found = read_tests(data, "a.csv", test="uniaxial")
    same(found, (13, 13))
    assert [part.direction_name for part in found] == ways
    with pytest.raises(InputError, match="does not say which test it is"):
        read_tests(data, "a.csv")


def test_forces_of_strips_cut_in_two_directions_share_an_extension_and_two_load_cells_do_not() -> None:
    def read(heads: str) -> list[TestData]:
        data = table(heads, [50.0 * STRAIN, 20.0 * PULLS[0], 20.0 * PULLS[1]])
        return read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(50.0, 10.0, 2.0))

    found = read("displacement_mm,force_warp_N,force_weft_N")
    same(found, (13, 13))
    assert [part.direction_name for part in found] == ["warp", "weft"]
    for heads in ("force_1_N,force_2_N", "force_N_1,force_N_2", "Force_N,Force_N_2"):
        with pytest.raises(InputError, match=r"two columns give the force.*=aside"):
            read(f"displacement_mm,{heads}")


def test_a_number_behind_the_unit_is_that_of_the_specimen() -> None:
    """Of Force_N_1, Force_N_2 the second was left aside, as a force in N/2."""
    columns = [50.0 * STRAIN, 20.0 * PULLS[0], 50.0 * STRAIN, 20.0 * PULLS[1]]
    data = table("Extension_mm_1,Force_N_1,Extension_mm_2,Force_N_2", columns)
    found = read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(50.0, 10.0, 2.0))
    same(found, (13, 13))
    assert [part.stress[-1] for part in found] == pytest.approx([PULLS[0][-1], PULLS[1][-1]], rel=1e-4)


def test_directions_of_a_biaxial_test_are_its_axes() -> None:
    data = table("strain weft,stress weft [MPa],strain warp,stress warp [MPa]", pairs()[:4])
    [found] = read_tests(data, "a.csv", test="biaxial")
    assert found.mode == "biaxial-general"
    assert found.stress == pytest.approx(PULLS[1], rel=1e-5, abs=1e-12)
    assert found.stress2 == pytest.approx(PULLS[0], rel=1e-5, abs=1e-12)
    named = read_tests(data, "uniaxial.csv", test="uniaxial")
    assert [part.direction_name for part in named] == ["weft", "warp"]


@pytest.mark.parametrize(
    ("heads", "field", "values"),
    [
        (
            "Strain,Stress -20C [MPa],Stress 20 °C [MPa],Stress 60degC [MPa]",
            "temperature_degC",
            [-20, 20, 60],
        ),
        ("Strain,Stress 0.01/s [MPa],Stress 0.1 1/s [MPa],Stress 1/s [MPa]", "rate_1_s", [0.01, 0.1, 1.0]),
    ],
)
def test_a_title_tells_the_temperature_or_the_rate(heads: str, field: str, values: list[float]) -> None:
    found = read_tests(table(heads, [STRAIN, *PULLS]), "a.csv", test="uniaxial")
    same(found)
    assert [float(getattr(part, field)[0]) for part in found] == values


def test_a_column_may_state_tests_by_the_letters_that_papers_give_them() -> None:
    rows = "".join(
        f"{mode},{1.0 + e:.3f},{s:.4f}\n" for mode in ("UT", "PS", "ET") for e, s in zip(STRAIN, PULLS[0], strict=True)
    )
    found = read_tests(f"mode,stretch,stress_MPa\n{rows}".encode(), "a.csv")
    assert [part.mode for part in found] == ["uniaxial", "shear", "biaxial"]


TESTS_ABOVE = "Uniaxial tension,,Equibiaxial tension,,Pure shear,\n"


def test_titles_above_pairs_of_columns_say_which_test_each_is() -> None:
    data = TESTS_ABOVE.encode() + table(",".join(["Strain,Stress (MPa)"] * 3), pairs())
    found = read_tests(data, "a.csv")
    same(found)
    assert [part.mode for part in found] == ["uniaxial", "biaxial", "shear"]
    # A file of several tests is not one test because an option says so.
    with pytest.raises(InputError, match=r"line 1.*biaxial, but it was given as uniaxial.*without the option"):
        read_tests(data, "a.csv", test="uniaxial")


def test_points_read_off_a_diagram_need_one_word_for_all_pairs() -> None:
    data = TESTS_ABOVE.encode() + table("X,Y,X,Y,X,Y", pairs())
    with pytest.raises(InputError) as refused:
        read_tests(data, "a.csv")
    (told,) = re.findall(r'--columns "(.+)"', str(refused.value))
    found = read_tests(data, "a.csv", columns=layout([told]))
    same(found)
    assert [part.mode for part in found] == ["uniaxial", "biaxial", "shear"]


def test_titles_above_pairs_of_columns_say_how_warm_each_was() -> None:
    data = b"Warm 23C,,80 \xc2\xb0C,,105 degC,\n" + table(",".join(["strain,stress [MPa]"] * 3), pairs())
    found = read_tests(data, "a.csv", test="uniaxial")
    same(found)
    assert [part.temperature_degC for part in found] == [
        pytest.approx(np.full(len(STRAIN), warm)) for warm in (23.0, 80.0, 105.0)
    ]


def test_titles_above_pairs_of_columns_say_how_fast_each_was() -> None:
    data = b"10 mm/min,,100 mm/min,,1000 mm/min,\n" + table(",".join(["Extension (mm),stress [MPa]"] * 3), pairs())
    found = read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(gauge_length=50.0))
    assert [part.rate_1_s for part in found] == [
        pytest.approx(np.full(len(STRAIN), speed / 60.0 / 50.0)) for speed in (10.0, 100.0, 1000.0)
    ]


@pytest.mark.parametrize(
    "line", ["Width: 10 mm; Thickness: 2 mm; Gauge length: 50 mm", '"L0 = 50,0 mm, b0 = 10 mm, a0 = 2 mm"']
)
def test_sizes_may_stand_in_one_line(line: str) -> None:
    force = [50.0 * STRAIN, 20.0 * PULLS[0]]
    data = f"{line}\n".encode() + table("Extension (mm),Load (N)", force)
    (found,) = read_tests(data, "a.csv", test="uniaxial")
    assert found.stretch == pytest.approx(1.0 + STRAIN)
    assert found.stress == pytest.approx(PULLS[0], rel=1e-5, abs=1e-12)


def test_a_length_of_the_specimen_is_no_gauge_length_but_fills_in_the_option() -> None:
    sizes = b"Specimen Width,10 mm\nSpecimen Thickness,2 mm\nSpecimen Length,120 mm\n"
    data = sizes + table("Extension (mm),Load (N)", [50.0 * STRAIN, 20.0 * PULLS[0]])
    with pytest.raises(InputError, match=r"line 3 has a length of 120 mm: .* --gauge-length 120mm"):
        read_tests(data, "a.csv", test="uniaxial")
    (found,) = read_tests(data, "a.csv", test="uniaxial", geometry=Geometry(gauge_length=50.0))
    assert found.stretch == pytest.approx(1.0 + STRAIN)


@pytest.mark.parametrize("mark", ["%", "#", "//", "%%"])
def test_comments_of_other_programs_tell_the_test_and_the_head(mark: str) -> None:
    rows = "\n".join(f"{a:.6g} {b:.6g}" for a, b in zip(STRAIN, PULLS[0], strict=True))
    data = f"{mark} uniaxial tension\n{mark} strain stress(MPa)\n{rows}\n".encode()
    (found,) = read_tests(data, "a.txt")
    assert found.mode == "uniaxial"
    assert found.stretch == pytest.approx(1.0 + STRAIN, rel=1e-5)
    # Too many words to be a name: nothing is made of it.
    talk = f"{mark} more of it in the biaxial test of last year\n{mark} strain stress(MPa)\n{rows}\n".encode()
    with pytest.raises(InputError, match="which test"):
        read_tests(talk, "a.txt")


@pytest.mark.parametrize("titles", ["Warp,,Weft,", "Axis 1,,Axis 2,", "X,,Y,", "MD,,CD,"])
def test_axes_in_titles_above_a_biaxial_test_are_its_axes(titles: str) -> None:
    data = f"{titles}\n".encode() + table("Strain,Stress (MPa),Strain,Stress (MPa)", pairs()[:4])
    (found,) = read_tests(data, "a.csv", test="biaxial")
    assert found.mode == "biaxial-general"
    assert found.stretch2 == pytest.approx(found.stretch)
    assert found.stress == pytest.approx(PULLS[0], rel=1e-5, abs=1e-12)
    assert found.stress2 == pytest.approx(PULLS[1], rel=1e-5, abs=1e-12)


def test_directions_in_titles_above_are_those_of_specimens_where_the_test_has_one_axis() -> None:
    data = b"Warp,,Weft,,45 deg,\n" + table(",".join(["Strain,Stress (MPa)"] * 3), pairs())
    found = read_tests(data, "a.csv", test="uniaxial")
    same(found)
    assert [part.direction for part in found] == [0.0, 90.0, 45.0]
    # Two directions may be two specimens or two axes: only who tested knows.
    two = b"Warp,,Weft,\n" + table("Strain,Stress (MPa),Strain,Stress (MPa)", pairs()[:4])
    with pytest.raises(InputError, match="which test"):
        read_tests(two, "a.csv")


@pytest.mark.parametrize("name", ["S 1", "S", "Max", "Total", "N 2"])
@pytest.mark.parametrize("preamble", ["# test: uniaxial\n", "Tensile test\nOperator,Meier\n\n"])
def test_a_specimen_called_as_a_closing_row_is_begins_is_read(name: str, preamble: str) -> None:
    """A mean stands in one row; what stands in row after row is a size, an operator, a sample."""
    rows = "".join(f"{who},{10 * k},{k / 10}\n" for who in ("A 1", name) for k in (1, 2, 3, 4))
    text = f"{preamble}Sample,Strain (%),Stress (MPa)\n{rows}Mean,25,0.25\nS,12,0.1\nMax,40,0.4\n"
    found = read_tests(text.encode(), "k17.csv")
    assert [(one.specimen, one.stress.tolist()) for one in found] == [
        ("A 1", [0.1, 0.2, 0.3, 0.4]), (name, [0.1, 0.2, 0.3, 0.4])
    ]  # fmt: skip
    assert set(found[0].left_out) == {"closing row, no reading"}


@pytest.mark.parametrize("names", [("S", "M", "L"), ("M", "S", "L"), ("Anna", "Max"), ("M", "N")])
def test_specimens_of_two_rows_may_be_called_as_closing_rows_begin(names: tuple[str, ...]) -> None:
    rows = "".join(f"{name},{strain},{strain / 100}\n" for name in names for strain in (20, 40))
    found = read_tests(f"# test: uniaxial\nSample,Strain (%),Stress (MPa)\n{rows}".encode(), "a.csv")
    assert [part.specimen for part in found] == list(names)


@pytest.mark.parametrize("closing", [("Max", "Mean"), ("Mean", "Max"), ("Max", "Min")])
def test_two_closing_rows_of_each_kind_stay_closing_rows(closing: tuple[str, ...]) -> None:
    names = ("A", "B", *closing)
    rows = "".join(f"{name},{strain},{strain / 100}\n" for name in names for strain in (20, 40))
    found = read_tests(f"# test: uniaxial\nSample,Strain (%),Stress (MPa)\n{rows}".encode(), "a.csv")
    assert [part.specimen for part in found] == ["A", "B"]


def test_two_closing_rows_below_longer_specimens_stay_closing_rows() -> None:
    rows = "A,20,0.1\nA,40,0.2\nA,60,0.3\nMean,40,0.2\nMean,50,0.3\nMax,60,0.3\n"
    [found] = read_tests(f"# test: uniaxial\nSample,Strain (%),Stress (MPa)\n{rows}".encode(), "a.csv")
    assert (len(found.stretch), found.left_out) == (3, {"closing row, no reading": 3})


def test_what_was_said_of_columns_by_number_is_not_proposed_again_without_a_title() -> None:
    rows = b"0.0,0.0\n0.1,0.2\n0.2,0.5\n0.3,0.9\n"
    with pytest.raises(InputError, match="no column gives a shear strain") as caught:
        read_tests(rows, "a.csv", test="simple-shear", columns=layout(["1=stretch,2=stress [kPa]"]))
    assert '--columns "1=stretch,2=stress [kPa]' not in str(caught.value)
    assert '"shear strain"' in str(caught.value)


def long(names: list[str], clock: bool, anew: bool, title: str = "File_ID") -> bytes:
    """Specimens one under another in one table, told apart by a column of words alone, and what they are cut of."""
    rows, time = [], 0
    for name, pull in zip(names, PULLS, strict=False):
        for a, b in zip(STRAIN, pull, strict=True):
            rows.append(f"{time},{a:.6f},{b:.6g},{name},{name.split('_')[0]}" if clock else f"{a:.6f},{b:.6g},{name},x")
            time += 1
        time = 0 if anew else time
    head = "Time [s],Strain,Stress [MPa]," if clock else "Strain,Stress [MPa],"
    return f"{head}{title},Material\n{chr(10).join(rows)}\n".encode()


@pytest.mark.parametrize("clock", [True, False])
def test_a_column_of_words_names_the_specimens_where_each_begins_at_rest_and_its_clock_anew(clock: bool) -> None:
    found = read_tests(
        long(["Jersey 0deg_1", "Jersey 0deg_2", "Jersey 90deg_1"], clock, True), "a.csv", test="uniaxial"
    )
    same(found)
    assert [part.specimen for part in found] == ["Jersey 0deg_1", "Jersey 0deg_2", "Jersey 90deg_1"]
    assert [part.direction for part in found] == [0.0, 0.0, 90.0]
    assert "File_ID names the specimens" in found[0].notes


def test_words_of_one_specimens_phases_name_none() -> None:
    phases = long(["Preload", "Pull", "Again"], clock=True, anew=False, title="Phase of it")
    (found,) = read_tests(phases, "a.csv", test="uniaxial")  # the clock goes on
    assert found.specimen is None
    pull = "".join(
        f"{k},{0.05 * k:.2f},{word}\n" for k, word in zip(range(1, 9), ["up"] * 4 + ["more"] * 4, strict=True)
    )
    (found,) = read_tests(f"Strain [%],Stress [MPa],Phase of it\n{pull}".encode(), "a.csv", test="uniaxial")
    assert found.specimen is None  # goes on where it was


def test_names_of_specimens_tell_their_directions_where_all_do() -> None:
    def ways(*names: str) -> list[float | None]:
        rows = "".join(f"{name},{1.0 + 0.1 * k:.1f},{0.1 * k:.1f}\n" for name in names for k in range(1, 5))
        return [
            one.direction
            for one in read_tests(f"specimen,stretch,stress [MPa]\n{rows}".encode(), "a.csv", test="uniaxial")
        ]

    assert ways("warp-1", "warp-2", "weft-1") == [0.0, 0.0, 90.0]
    assert ways("warp-1", "B") == [None, None]
