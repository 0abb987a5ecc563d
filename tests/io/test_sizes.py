"""Sizes of a specimen that stand in columns of the table, beside it, or one for each arm of a biaxial test."""

from __future__ import annotations

import pytest
from machine_exports import workbook

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.specimen import Geometry

ROWS = [(10.0, 2.0), (20.0, 4.0), (30.0, 5.0)]
NOMINAL = [0.05, 0.1, 0.125]


def read(text: str, **options: object) -> list[TestData]:
    return read_tests(text.encode(), "a.csv", **options)  # type: ignore[arg-type]


def is_strip(found: TestData, width: float = 50.0) -> bool:
    sizes = (found.width_mm, found.thickness_mm, found.gauge_length_mm)
    return sizes == (width, 0.8, 100.0) and found.stress.tolist() == pytest.approx(NOMINAL)


@pytest.mark.parametrize(
    ("head", "sizes"),
    [
        ("width_mm,thickness_mm,gauge length [mm]", "50,0.8,100"),
        ("Breite [mm],Dicke [mm],Einspannlänge [mm]", "50,0.8,100"),
        ("Width (cm),Thickness (mm),L0 (cm)", "5,0.8,10"),
        ("Width (mm),Thickness (mm),Grip distance (mm)", "50,0.8,100"),
    ],
)
@pytest.mark.parametrize("first_alone", [False, True])
def test_sizes_stand_in_columns_of_each_row_or_of_the_first(head: str, sizes: str, first_alone: bool) -> None:
    rows = [f"{sizes if not (first_alone and k) else ',,'},{way},{force}\n" for k, (way, force) in enumerate(ROWS)]
    [found] = read(f"Tensile test\n{head},Extension [mm],Load [N]\n{''.join(rows)}")
    assert is_strip(found)
    assert not any("not used" in note for note in found.notes)


@pytest.mark.parametrize("key", ["specimen", "direction"])
def test_each_specimen_of_a_column_has_its_own_sizes(key: str) -> None:
    rows = "".join(
        f"{one},{width},0.8,100,{way},{force * width / 50}\n"
        for one, width in (("warp", 50), ("weft", 25))
        for way, force in ROWS
    )
    head = f"{key},width [mm],thickness [mm],gauge length [mm],extension [mm],force [N]"
    found = read(f"# test: uniaxial\n{head}\n{rows}")
    assert [is_strip(part, width) for part, width in zip(found, (50.0, 25.0), strict=True)] == [True, True]
    narrow = read(f"# test: uniaxial\n{head}\n{rows}", geometry=Geometry(width=10.0))
    assert [part.width_mm for part in narrow] == [10.0, 10.0]  # an option counts more


def test_a_width_that_changes_with_the_rows_is_a_reading() -> None:
    above = "# test: uniaxial\n# width: 50 mm\n# thickness: 0.8 mm\n# gauge length: 100 mm\n"
    rows = "".join(f"{way},{force},{50 - way / 10}\n" for way, force in ROWS)
    [found] = read(f"{above}Extension [mm],Load [N],Width [mm]\n{rows}")
    assert is_strip(found)
    assert found.notes == ("columns not used: Width [mm]",)


def test_a_letter_without_a_unit_is_no_size() -> None:
    above = "Tensile test\nWidth,50,mm\nThickness,0.8,mm\nGauge length,100,mm\n"
    rows = "".join(f"{way},{force},3\n" for way, force in ROWS)
    assert is_strip(*read(f"{above}Extension [mm],Load [N],b\n{rows}"))


def test_a_column_and_a_line_above_it_may_agree_and_are_asked_for_where_not() -> None:
    rows = "".join(f"50.0,{way},{force}\n" for way, force in ROWS)
    text = "Tensile test\nWidth: {} cm\nThickness: 0.8 mm\nL0: 100 mm\nWidth (mm),Extension (mm),Load (N)\n" + rows
    assert is_strip(*read(text.format(5)))
    with pytest.raises(InputError, match=r"line 2, key width: states 4 cm and 50\.0 mm; give --width 4cm or"):
        read(text.format(4))


BESIDE = {
    "a column of values": (
        [],
        [["", "Width", "50", "mm"], ["", "Thickness", "0.8", "mm"], ["", "L0", "100", "mm"]],
    ),
    "from the head on": (
        ["", "Width (mm)", "50"],
        [["", "Thickness (mm)", "0.8"], ["", "Gauge length (mm)", "100"]],
    ),
    "one cell each": ([], [["", "Width: 50 mm"], ["", "Thickness: 0.8 mm"], ["", "Gauge length: 100 mm"]]),
    "titled": (
        ["", "Property", "Value"],
        [
            ["", "Width (mm)", "50"],
            ["", "Thickness (mm)", "0.8"],
            ["", "L0 (mm)", "100"],
            ["", "Operator", "J"],
        ],
    ),
}


@pytest.mark.parametrize("kind", BESIDE)
@pytest.mark.parametrize("form", ["csv", "xlsx"])
def test_sizes_stand_to_the_right_of_the_readings(kind: str, form: str) -> None:
    head, beside = BESIDE[kind]
    left = [[str(way), str(force)] for way, force in ROWS]
    below = [["", "", *one] for one in beside[len(left) :]]
    beside = [*beside, []][: len(left)]
    rows = [["Tensile test"], ["Extension (mm)", "Load (N)", *head]]
    rows += [[*one, *other] for one, other in zip(left, beside, strict=True)] + below
    if form == "csv":
        [found] = read("".join(",".join(row) + "\n" for row in rows))
    else:
        cells = [[(one,) if one.replace(".", "").isdigit() else one or None for one in row] for row in rows]
        [found] = read_tests(workbook({"Sheet1": cells}), "a.xlsx")  # type: ignore[arg-type]
    assert is_strip(found)


def test_words_beside_the_readings_that_are_said_of_rows_state_nothing() -> None:
    above = "Tensile test\nWidth,50,mm\nThickness,0.8,mm\nGauge length,100,mm\n"
    rows = "".join(f"{way},{force},base,{k}\n" for k, (way, force) in enumerate(ROWS))
    assert is_strip(*read(f"{above}Extension (mm),Load (N),Phase,Marker\n{rows}"))
    with pytest.raises(InputError, match=r"key width: states 50 mm and 25 mm"):
        read(f"{above}Extension (mm),Load (N),,Width (mm),25\n10,2,,,\n20,4,,,\n")


ARMS = "Biaxial tensile test\n{}Thickness,0.8,mm\n{}\n10,{x1},24,48\n20,{x2},36,72\n"


@pytest.mark.parametrize(
    ("sizes", "head"),
    [
        ("Width X,30,mm\nWidth Y,60,mm\n", "Strain X (%),Strain Y (%),Force X (N),Force Y (N)"),
        ("Width 1,30,mm\nWidth 2,60,mm\n", "strain 1 (%),strain 2 (%),force_1_N,force_2_N"),
        (
            "Width warp,30,mm\nWidth weft,60,mm\n",
            "Strain warp (%),Strain weft (%),Force warp (N),Force weft (N)",
        ),
        ("Arm width X,30,mm\nArm width Y,60,mm\n", "Strain X (%),Strain Y (%),XForce (N),YForce (N)"),
    ],
)
def test_arms_of_a_biaxial_test_have_widths_of_their_own(sizes: str, head: str) -> None:
    [found] = read(ARMS.format(sizes, head, x1=10, x2=20))
    assert found.mode == "biaxial-general"
    assert found.stress2 is not None
    assert found.stress.tolist() == found.stress2.tolist() == pytest.approx([1.0, 1.5])
    assert [note[-22:] for note in found.notes] == [
        "is over a width of 30 mm"[-22:],
        "is over a width of 60 mm"[-22:],
    ]


def test_arms_of_a_biaxial_test_have_gauge_lengths_of_their_own() -> None:
    sizes = "Width,60,mm\nGauge length X,100,mm\nGauge length Y,50,mm\n"
    head = "Displacement X (mm),Displacement Y (mm),Force X (N),Force Y (N)"
    [found] = read(ARMS.format(sizes, head, x1=5, x2=10))
    assert found.stretch2 is not None
    assert found.stretch.tolist() == found.stretch2.tolist() == pytest.approx([1.1, 1.2])


def test_arm_widths_stand_in_columns_and_belong_to_their_force() -> None:
    text = "test,width_1_mm,width_2_mm,thickness_mm,stretch 1,stretch 2,force_1_N,force_2_N\n"
    [found] = read(text + "biaxial-general,30,60,0.8,1.1,1.1,24,48\nbiaxial-general,30,60,0.8,1.2,1.2,36,72\n")
    assert found.stress2 is not None
    assert found.stress.tolist() == found.stress2.tolist() == pytest.approx([1.0, 1.5])
    one = "# test: biaxial\nWidth X,30,mm\nWidth Y,60,mm\nThickness,0.8,mm\nStrain Y [%],Force Y [N]\n10,48\n20,72\n"
    assert read(one)[0].stress.tolist() == pytest.approx([1.0, 1.5])


def test_two_widths_of_a_strip_are_asked_for_as_before() -> None:
    text = "Tensile test\nWidth 1,50,mm\nWidth 2,40,mm\nThickness,0.8,mm\nStrain (%),Load (N)\n10,2\n20,4\n"
    with pytest.raises(InputError, match="key width: states 50 mm and 40 mm"):
        read(text)


def test_the_next_title_of_a_table_is_no_size() -> None:
    """A table of results above the readings has a length beside the largest load."""
    above = "Tensile test\n,Length (mm),Maximum load (N)\n1,100,5\n\nSpecimen 1\nLength,100,mm\nWidth,50,mm\n"
    with pytest.raises(InputError, match=r"line 6 has a length of 100 mm.*--gauge-length 100mm"):
        read(f"{above}Time,Extension,Load\ns,mm,N\n0,10,2\n1,20,4\n2,30,5\n3,40,6\n4,50,7\n5,60,8\n")


@pytest.mark.parametrize("length", ["Strain : Tensile strain (Extension) gauge length", "Specimen : Gauge length"])
def test_sizes_stand_under_their_group(length: str) -> None:
    above = f'Specimen properties : Width,"50.0",mm\nSpecimen properties : Thickness,"0.8",mm\n{length},"100.0",mm\n'
    rows = "".join(f'"{way}","{force}"\n' for way, force in ROWS)
    [found] = read(f"Type of test,Tensile\n{above}\nExtension,Load\n(mm),(N)\n{rows}")
    assert is_strip(found)


@pytest.mark.parametrize("key", ["Gauge length (Extensometer)", "Strain : Strain 1 gauge length"])
def test_the_length_of_an_extensometer_is_not_that_between_the_grips(key: str) -> None:
    above = f'Type of test,Tensile\nWidth,50,mm\nThickness,0.8,mm\n{key},"100.0",mm\n'
    rows = "".join(f"{way},{force}\n" for way, force in ROWS)
    with pytest.raises(InputError, match="gauge length"):
        read(f"{above}\nExtension,Load\n(mm),(N)\n{rows}")
    [found] = read(f"{above}\nExtensometer,Load\n(mm),(N)\n{rows}")
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2, 1.3])


@pytest.mark.parametrize(
    ("length", "width", "thickness", "head"),
    [
        (
            "L0 - course standard",
            "Largeur éprouvette",
            "Épaisseur éprouvette",
            '"Traverse absolue","Force standard","Course standard"',
        ),
        (
            "Gage length, standard travel",
            "Specimen width",
            "Specimen thickness",
            '"Crosshead absolute","Standard force","Standard travel"',
        ),
    ],
)
def test_a_gauge_length_is_said_of_the_travel_that_it_is_for(
    length: str, width: str, thickness: str, head: str
) -> None:
    above = f'"{thickness}",0.8,"mm"\n"{width}",50,"mm"\n"{length}",100,"mm"\n"v1",1,"mm/min"\n'
    rows = "".join(f"{way - 700.0},{force},{way}\n" for way, force in ROWS)
    [found] = read(f'{above}{head}\n"mm","N","mm"\n{rows}', test="uniaxial")
    assert is_strip(found)
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2, 1.3])


def test_an_area_under_its_group_is_the_section() -> None:
    rows = "".join(f"{way:g};{force:g}\n".replace(".", ",") for way, force in ROWS)
    text = f"Abmessung : Querschnitt;40,0;mm^2\nAbmessung : Messlänge;100,0;mm\n\nTraversenweg;Last\n(mm);(N)\n{rows}"
    [found] = read(text, test="uniaxial")
    assert found.stress.tolist() == pytest.approx([force / 40.0 for _, force in ROWS])


def test_the_cross_section_of_a_specimen_is_its_area() -> None:
    rows = "".join(f"{way:g},{force:g}\n" for way, force in ROWS)
    text = f"Specimen Cross-section (cm^2),0.4\nGauge length (mm),100\n\nExtension [mm],Load [N]\n{rows}"
    [found] = read(text, test="uniaxial")
    assert found.stress.tolist() == pytest.approx([force / 40.0 for _, force in ROWS])


@pytest.mark.parametrize(
    ("stated", "asked"),
    [
        ("", ["--gauge-length 50mm", "Load [N] needs a width too, --width 25mm"]),
        ("# width: 50 mm\n", ["--gauge-length 50mm"]),
        ("# area: 40 mm2\n", ["--gauge-length 50mm"]),
        ("# diameter: 8 mm\n", ["--gauge-length 50mm"]),
    ],
)
def test_sizes_that_lack_are_asked_for_together(stated: str, asked: list[str]) -> None:
    rows = "".join(f"{way:g},{force:g}\n" for way, force in ROWS)
    with pytest.raises(InputError) as caught:
        read(f"# test: uniaxial\n{stated}Extension [mm],Load [N]\n{rows}")
    assert all(one in str(caught.value) for one in asked)
    assert ("--width" in str(caught.value)) is (len(asked) == 2)


def test_rows_may_leave_off_the_cells_that_the_first_one_alone_has() -> None:
    head = "Extension [mm],Load [N],width_mm,thickness_mm,gauge length [mm]"
    rows = "".join(f"{way},{force}{',50,0.8,100' if k == 0 else ''}\n" for k, (way, force) in enumerate(ROWS))
    [found] = read(f"Tensile test\n{head}\n{rows}")
    assert is_strip(found)
    cut = "".join(f"{way},{force},7\n" for way, force in ROWS[:-1])
    with pytest.raises(InputError, match="has 1 cells, the header has 3"):
        read(f"# test: uniaxial\n# width: 50 mm\n# gauge length: 100 mm\nExtension [mm],Load [N],No\n{cut}30\n")


def beside(*widths: str, names: tuple[str, ...] = ("1 _ 1", "1 _ 2", "1 _ 3")) -> str:
    """Return two specimens side by side, below a small table that has a row for each of some ``widths``."""
    sizes = '"Name","Thickness","Width","Gauge_Length"\n"Units","mm","mm","mm"\n'
    sizes += "".join(f'"{one}","0.8000","{width}","100.0000"\n' for one, width in zip(names, widths, strict=False))
    heads = (
        '"1 _ 1","","","1 _ 2","",""\n"Time","Force","Stroke","Time","Force","Stroke"\n"sec","N","mm","sec","N","mm"\n'
    )
    rows = "".join(f'"{k}","{2 * k}","{10 * k}","{k}","{2 * k}","{10 * k}"\n' for k in range(4))
    return '"Test Type","Tensile"\n' + sizes + '"Mean","0.8","49.0","100.0"\n\n' + heads + rows


def test_sizes_in_a_small_table_above_are_those_of_each_specimen() -> None:
    one, two = read(beside("50.0000", "50.0000"))
    assert one.stretch[-1] == two.stretch[-1] == 1.3
    assert one.stress.tolist() == pytest.approx([0.0, 0.05, 0.1, 0.15])
    one, two = read(beside("50.0000", "40.0000"))
    assert (one.width_mm, two.width_mm) == (50.0, 40.0)
    assert two.stress.tolist() == pytest.approx([0.0, 0.0625, 0.125, 0.1875])
    one, two = read(beside("50.0000", "48.0000", "40.0000", names=("2", "3", "1")))  # by their names
    assert (one.width_mm, two.width_mm) == (40.0, 50.0)


def test_a_small_table_of_more_specimens_than_were_read_tells_the_size_of_none() -> None:
    with pytest.raises(InputError, match=r"states 50\.0000 mm and 48\.0000 mm and 40\.0000 mm; give --width"):
        read(beside("50.0000", "48.0000", "40.0000"))


@pytest.mark.parametrize(
    "name", ["Longueur entre rep\u00e8res", "\u6a19\u7dda\u9593\u8ddd\u96e2", "Abstand der Messmarken"]
)
def test_a_gauge_length_is_between_marks(name: str) -> None:
    rows = "".join(f"{way};{force}\n" for way, force in ROWS)
    [found] = read(f"Tensile test\n{name};100;mm\nWidth;50;mm\nThickness;0.8;mm\n\nExtension [mm];Load [N]\n{rows}")
    assert is_strip(found)


def test_the_one_length_of_no_known_name_is_offered_as_the_gauge_length() -> None:
    rows = "".join(f"{way};{force}\n" for way, force in ROWS)
    above = "Tensile test\nVizsgalati hossz;100;mm\nBatch;7\nWidth;50;mm\n"
    with pytest.raises(InputError, match="line 2 says vizsgalati hossz: 100 mm; if that is it, --gauge-length 100mm"):
        read(f"{above}\nExtension [mm];Load [N]\n{rows}")
    with pytest.raises(InputError, match="give --gauge-length 50mm"):
        read(f"{above}Befogasi hossz;150;mm\n\nExtension [mm];Load [N]\n{rows}")


@pytest.mark.parametrize(
    "above",
    [
        "Width;50 mm\nThickness;0,8 mm\nGauge length;100;mm",
        '"Probenbreite","50 mm"\n"Probendicke","0.8 mm"\n"Einspannlänge","100 mm"',
        "Probenbreite,50 mm\nProbendicke 0,8 mm\nGauge length 100 mm",
        "Width of strips, cut by hand\nWidth 50,0 mm\nThickness 0.8 mm\nGauge length, 100 mm",
    ],
)
def test_lines_above_are_parted_in_a_way_of_their_own(above: str) -> None:
    rows = "".join(f"{way}\t{force}\n" for way, force in ROWS)
    [found] = read(f"Tensile test\n{above}\n\nExtension [mm]\tLoad [N]\n{rows}")
    assert is_strip(found)


@pytest.mark.parametrize(
    "above",
    [
        "Jersey K7. Gauge length 100 mm, width 50mm\nStrips of 0.8 mm thickness were pulled at 100 mm/min\n",
        "# Gauge length was 100 mm and width 50 mm, thickness 0.8 mm\n",
        "Sample: strip, gauge length 100 mm, width 50mm, thickness 0.8 mm; speed 100 mm/min.\n",
        "Strips 50 mm wide, 0.8 mm thick, benchmarks 100 mm apart\n",
        "Prüfbericht 17: Streifen 50 mm breit, 0,8 mm dick, Einspannlänge 100 mm\n",
    ],
)
@pytest.mark.parametrize("mark", [";", "\t", ",", "  "])
def test_sizes_stand_in_a_sentence(above: str, mark: str) -> None:
    """They were asked for, with sizes of another strip in the option that was shown."""
    rows = "".join(f"{way}{mark}{force}\n" for way, force in ROWS)
    [found] = read_tests(f"{above}\nExtension [mm]{mark}Load [N]\n{rows}".encode(), "a.csv", test="uniaxial")
    assert is_strip(found)


def test_a_small_table_may_have_its_units_in_the_cells() -> None:
    rows = "".join(f"{way};{force}\n" for way, force in ROWS)
    above = "Sample;Width;Thickness;Gauge length\nK7;50 mm;0.8 mm;100 mm\n"
    [found] = read_tests(f"{above}\nExtension [mm];Load [N]\n{rows}".encode(), "a.csv", test="uniaxial")
    assert is_strip(found)


def test_specimens_of_one_sample_are_each_their_own() -> None:
    """Both were called after the sample, one specimen."""
    rows = "".join(f"{way};{force};{way};{force}\n" for way, force in ROWS)
    text = f"Sample: K7\nWidth;50;mm\nThickness;0.8;mm\nGauge length;100;mm\n{'Extension [mm];Load [N];' * 2}\n{rows}"
    found = read_tests(text.encode(), "a.csv", test="uniaxial")
    assert [one.specimen for one in found] == ["K7 1", "K7 2"]


@pytest.mark.parametrize(
    "above",
    [
        "Grip width 50 mm\n",
        "Jaws 50 mm wide, strips cut along the warp\n",
        "Width change 50 mm\n",
        "Strips 50 mm long\n",
    ],
)
def test_what_is_no_width_of_the_strip_is_not_taken_from_a_sentence(above: str) -> None:
    rows = "".join(f"{way};{force}\n" for way, force in ROWS)
    with pytest.raises(InputError, match="needs the width"):
        read_tests(f"{above}Gauge length;100;mm\nExtension [mm];Load [N]\n{rows}".encode(), "a.csv", test="uniaxial")
