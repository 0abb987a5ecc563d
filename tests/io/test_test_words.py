"""The words by which files name tests, directions and branches, each with what it stands for."""

from __future__ import annotations

import re

import pytest
from machine_exports import workbook

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import read_tests
from hyperfab.io.headings import Heading
from hyperfab.io.layout import layout
from hyperfab.io.roles import fits

ROWS = "stretch [-],stress [MPa]\n1,0\n1.2,0.1\n1.5,0.4\n"


def one(text: str, test: str | None = "uniaxial"):
    [found] = read_tests(text.encode(), "test.csv", test=test)
    return found


@pytest.mark.parametrize(
    ("word", "degrees"),
    [
        ("warp", 0.0),
        ("wale", 0.0),
        ("weft", 90.0),
        ("course", 90.0),
        ("30 deg", 30.0),
        ("MD", 0.0),
        ("CD", 90.0),
        ("RD", 0.0),
        ("TD", 90.0),
        ("Kette", 0.0),
        ("Schuss", 90.0),
        ("cha\u00eene", 0.0),
        ("trame", 90.0),
        ("Laufrichtung", 0.0),
        ("sens travers", 90.0),
        ("bias", 45.0),
        ("schr\u00e4g", 45.0),
        ("\u00b145\u00b0", 45.0),
    ],
)
def test_a_direction_is_so_many_degrees_from_the_warp(word: str, degrees: float) -> None:
    assert one(f"# direction: {word}\n" + ROWS).direction == degrees


def test_a_bias_extension_test_pulls_at_45_degrees_though_no_name_tells() -> None:
    text = "Bias extension test\n" + ROWS
    [found] = read_tests(text.encode(), "k7.csv")
    assert (found.mode, found.direction) == ("uniaxial", 45.0)
    told = one("# direction: warp\n" + text)
    assert told.direction == 0.0
    assert one("Tensile test, bias tape\n" + ROWS).direction is None


def test_a_direction_that_is_a_branch_is_asked_for_as_one() -> None:
    with pytest.raises(InputError, match="Direction=branch"):
        one("Direction,stretch [-],stress [MPa]\nup,1,0\nup,1.2,0.1\ndown,1,0\n")


@pytest.mark.parametrize("cells", [("Cycle 1", "Cycle 2"), ("cycle_1", "cycle_2"), ("1st", "2nd cycle"), ("C1", "C2")])
def test_cycles_may_be_numbered_beside_a_word(cells: tuple[str, str]) -> None:
    rows = "".join(f"{cell},1,0\n{cell},1.2,0.1\n{cell},1.5,0.4\n" for cell in cells)
    assert one("Cycle,stretch [-],stress [MPa]\n" + rows).cycle.tolist() == [1, 1, 1, 2, 2, 2]


@pytest.mark.parametrize(("word", "sign"), [("load", 1), ("loading", 1), ("unload", -1), ("unloading", -1)])
def test_a_branch_goes_up_or_down(word: str, sign: int) -> None:
    other = "unloading" if sign > 0 else "loading"
    text = f"stretch [-],stress [MPa],branch\n1,0,{word}\n1.2,0.1,{word}\n1.5,0.4,{other}\n1.3,0.2,{other}\n"
    assert one(text).branch.tolist() == [sign, sign, -sign, -sign]


@pytest.mark.parametrize(
    ("word", "kind"),
    [
        ("uniaxial", "uniaxial"), ("tension", "uniaxial"), ("tensile", "uniaxial"), ("shear", "shear"),
        ("planar", "shear"), ("planar tension", "shear"), ("pure shear", "shear"), ("biaxial", "biaxial"),
        ("equibiaxial", "biaxial"),
    ],
)  # fmt: skip
def test_a_test_has_one_name_inside(word: str, kind: str) -> None:
    assert one(f"# test: {word}\n" + ROWS, test=None).mode == kind


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_columns_that_are_exchanged_are_refused_whatever_the_stress(scale: float) -> None:
    """A stretch below 0.9 with a tension of more than a twentieth of the peak is no test of a fabric."""
    text = "stretch [-],stress [MPa]\n" + "".join(f"{a},{b * scale}\n" for a, b in ((0.1, 1.1), (0.4, 1.5), (0.8, 2.0)))
    with pytest.raises(InputError, match="line 2"):
        one(text)
    # At rest nothing is exchanged, and compression has compression's sign.
    assert one("stretch [-],stress [MPa]\n1,0\n0.8,-0.2\n0.7,-0.4\n").stress.tolist() == [0.0, -0.2, -0.4]


@pytest.mark.parametrize(("key", "value"), [("width", "0 mm"), ("thickness", "0 mm"), ("gauge length", "-3 mm")])
def test_a_size_that_is_not_positive_is_refused_with_its_line(key: str, value: str) -> None:
    with pytest.raises(InputError, match="is not positive"):
        one(f"# {key}: {value}\n" + ROWS)


def test_one_column_called_after_a_specimen_beside_the_stretch_makes_a_table_fit() -> None:
    """Whatever else stands in the table: the unit says that the specimen's column is a stress."""
    headings = [Heading("stretch", "stretch", None, 0), Heading("Probe 1 [MPa]", "Probe 1", "MPa", 1)]
    headings.append(Heading("operator", "operator", None, 2))
    assert fits(headings)
    assert not fits(headings[::2])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_compression_takes_its_sign_from_its_largest_stress_and_not_from_its_noise(sign: float) -> None:
    """Near rest a load cell reads a little of the other sign: the curve is the same however pushing is counted."""
    text = "strain [-],stress [MPa]\n" + "".join(f"{-e},{sign * s}\n" for e, s in ((0, 0.01), (0.1, -0.2), (0.3, -0.9)))
    found = one("# test: compression\n" + text, None)
    assert found.stretch.tolist() == pytest.approx([1.0, 0.9, 0.7])
    assert found.stress.tolist() == pytest.approx([0.01, -0.2, -0.9])


PULLED = "Extension (mm),Load (N)\n10,2\n20,4\n30,6\n"
STRIP = "Width,50,mm\nThickness,0.8,mm\nGauge length,100,mm\n"


@pytest.mark.parametrize(
    "title",
    [
        "Tensile test - compression garment knit",
        "Compression garment fabric - tensile test",
        "Zugversuch Jersey mit Druck",
        'Test method,"Tensile strip test, biaxial NCF"',
        "Tensile test: biaxial warp-knitted fabric",
        "Tensile test ISO 13934-1: biaxial warp-knit",
        'Test:,"Tensile, compression garment knit"',
        "Ensayo de tracción de media de compresión",
    ],
)
def test_a_word_of_what_is_tested_is_no_kind_of_test(title: str) -> None:
    """What stands beside test, Versuch or a standard says the kind; a garment is of compression, a fabric biaxial."""
    [found] = read_tests(f"{title}\n{STRIP}{PULLED}".encode(), "k17.csv")
    assert found.mode == "uniaxial"
    assert found.stretch.tolist() == pytest.approx([1.1, 1.2, 1.3])
    assert found.stress.tolist() == pytest.approx([0.05, 0.1, 0.15])


@pytest.mark.parametrize(
    ("title", "kind"),
    [
        ("Biaxial tensile test of a compression fabric", "biaxial"),
        ("Planar tension test, uniaxial NCF", "shear"),
        ("Prova di compressione, maglia biassiale", "uniaxial"),
    ],
)
def test_a_test_that_is_no_pull_along_one_axis_is_still_known_by_its_title(title: str, kind: str) -> None:
    [found] = read_tests(f"{title}\nStrain (%),Stress (kPa)\n10,5\n20,12\n".encode(), "k17.csv")
    assert found.mode == kind
    assert (found.stretch.max() < 1.0) == ("compressione" in title)


def test_heads_of_columns_that_say_a_pull_count_more_than_a_word_in_a_name() -> None:
    heads = PULLED.replace("Extension", "Tensile extension")
    [found] = read_tests((STRIP + heads).encode(), "compression_sock_warp.csv")
    assert found.stretch.min() > 1.0
    with pytest.raises(InputError, match="does not say which test it is"):
        read_tests((STRIP + heads).encode(), "biaxial_ncf.csv")
    with pytest.raises(InputError, match="does not say which test it is"):
        read_tests((STRIP + PULLED).encode(), "biaxial_ncf_tensile.csv")


def test_compression_in_a_name_beside_readings_that_grow_is_asked_for() -> None:
    """As of a compression sock: both options that the message shows settle it."""
    with pytest.raises(InputError, match="if it was pulled") as caught:
        read_tests((STRIP + PULLED).encode(), "compression_sock.csv")
    pulled, pressed = re.findall(r'--columns "([^"]*)"', str(caught.value))
    [found] = read_tests((STRIP + PULLED).encode(), "compression_sock.csv", columns=layout([pulled]))
    assert (found.stretch.min(), found.stress.min()) == pytest.approx((1.1, 0.05))
    [found] = read_tests((STRIP + PULLED).encode(), "compression_sock.csv", columns=layout([pressed]))
    assert (found.stretch.max(), found.stress.max()) == pytest.approx((0.9, -0.05))
    [found] = read_tests((STRIP + PULLED).encode(), "compression-2.csv")  # the name says nothing else
    assert found.stretch.max() == pytest.approx(0.9)


@pytest.mark.parametrize("title", ["Tensile test", "Zugversuch ISO 13934-1", "Test type,Tensile"])
@pytest.mark.parametrize(
    "table",
    [
        "Extension (mm),Load (N)\n0,0\n-10,-2\n-20,-4\n-100,-9\n",
        "Position (mm),Load (N)\n400,0\n390,-2\n380,-4\n300,-9\n",
        "Strain (%),Stress (MPa)\n0,0\n-10,-.05\n-20,-.1\n-100,-.225\n",
    ],
)
def test_a_pull_that_counts_down_in_both_is_turned_round(title: str, table: str) -> None:
    """Under a title that says no pull the same readings are those of a compression."""
    [found] = read_tests(f"{title}\n{STRIP}{table}".encode(), "k17.csv")
    assert found.stretch.tolist() == pytest.approx([1.0, 1.1, 1.2, 2.0])
    assert found.stress.tolist() == pytest.approx([0.0, 0.05, 0.1, 0.225])
    assert any("count down and are turned round" in note for note in found.notes)
    pressed = re.sub(r"\n[^\n]*\n$", "\n", table)  # to a stretch of nothing nobody presses
    [found] = read_tests(f"{STRIP}{pressed}".encode(), "k17.csv", test="uniaxial")
    assert found.stretch.min() == pytest.approx(0.8)
    told = [note for note in found.notes if "taken as a compression, to a stretch of 0.8" in note]
    assert len(told) == ("Load" in table)  # a strain below zero is a compression by its name
    for option in re.findall(r'--columns "([^"]*)"', "".join(told)):
        [found] = read_tests(f"{STRIP}{pressed}".encode(), "k17.csv", test="uniaxial", columns=layout([option]))
        assert (found.stretch[-1], found.stress[-1]) == pytest.approx((1.2, 0.1))
        assert not any("taken as a compression" in note for note in found.notes)


@pytest.mark.parametrize(
    "table",
    [
        "Extension (mm),Load (N)\n0,0\n-10,2\n-20,4\n",
        "Position (mm),Load (N)\n400,0\n390,2\n380,4\n",
    ],
)
def test_of_a_pull_the_column_that_counts_down_is_the_one_to_turn(table: str) -> None:
    with pytest.raises(InputError, match="where it was pulled") as caught:
        read_tests(f"Tensile test\n{STRIP}{table}".encode(), "k17.csv")
    [option] = re.findall(r'--columns "([^"]*)"', str(caught.value))
    [found] = read_tests(f"Tensile test\n{STRIP}{table}".encode(), "k17.csv", columns=layout([option]))
    assert (found.stretch.max(), found.stress.max()) == pytest.approx((1.2, 0.1))
    with pytest.raises(InputError, match="where pushing counts as positive") as caught:
        read_tests(f"{STRIP}{table}".encode(), "k17.csv", test="uniaxial")
    ways = []
    for option in re.findall(r'--columns "([^"]*)"', str(caught.value)):
        [found] = read_tests(f"{STRIP}{table}".encode(), "k17.csv", test="uniaxial", columns=layout([option]))
        ways.append((found.stretch[-1], found.stress[-1]))
    assert ways == [pytest.approx((1.2, 0.1)), pytest.approx((0.8, -0.1))]


@pytest.mark.parametrize(
    ("name", "degrees"),
    [("k9_warp.csv", 0.0), ("lot3/Weft-2.txt", 90.0), ("Kette 23C.csv", 0.0), ("warp_weft.csv", None),
     ("warp_knit_3.csv", None), ("machine7.csv", None), ("lab4 Longitudinal pull.csv", 0.0), ("film_TD_2.csv", 90.0),
     ("transverse strain.csv", None), ("rib_45deg_1.csv", 45.0), ("rib -30\u00b0.csv", 30.0),
     ("rib 90 graden 1.txt", 90.0), ("foil machine direction.csv", 0.0), ("vhb_40deg.csv", None),
     ("rib_45degC.csv", None), ("rib 60 \u00b0 C.csv", None), ("0deg_90deg.csv", None), ("warp_0deg.csv", 0.0),
     ("pulled on our machine.csv", None), ("washed_60deg.csv", None), ("90deg peel.csv", None)],
)  # fmt: skip
def test_a_name_tells_the_direction_where_nothing_else_does(name: str, degrees: float | None) -> None:
    assert read_tests(f"# test: tensile\n{ROWS}".encode(), name)[0].direction == degrees
    [stated] = read_tests(f"# test: tensile\n# direction: 30 deg\n{ROWS}".encode(), name)
    assert stated.direction == 30.0


def test_sheets_of_a_workbook_tell_their_test_and_their_direction() -> None:
    rows = [["Strain", "Stress"], ["%", "MPa"], *[[(str(10 * k),), (str(k / 10),)] for k in (1, 2, 3)]]
    book = workbook({"Uniaxial warp": rows, "Biaxial": rows})
    assert [(one.mode, one.direction) for one in read_tests(book, "k17_uniaxial.xlsx")] == [
        ("uniaxial", 0.0), ("biaxial", None)
    ]  # fmt: skip
