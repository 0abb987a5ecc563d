"""Tests that stand side by side in one table: what is said of one of their columns holds for those alike."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.layout import layout

STRAIN = np.linspace(0.1, 0.9, 9)
PULLS = [gain * (1.0 - np.exp(-2.0 * STRAIN)) for gain in (1.0, 1.3)]


def table(heads: str, *columns: np.ndarray) -> bytes:
    rows = [",".join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([heads, *rows, ""]).encode()


def pairs(heads: str) -> bytes:
    return table(heads, STRAIN, PULLS[0], STRAIN, PULLS[1])


def as_told(data: bytes, name: str = "a.csv", test: str | None = "uniaxial") -> list[TestData]:
    """Read a file with the option that the message of its refusal shows, as it stands there."""
    with pytest.raises(InputError) as caught:
        read_tests(data, name, test=test)
    [option, *_] = re.findall(r"--columns (\"[^\"]*\"|'[^']*')", str(caught.value))
    return read_tests(data, name, test=test, columns=layout(shlex.split(option)))


def same(found: list[TestData], scale: float = 1.0) -> None:
    assert len(found) == 2
    for part, pull in zip(found, PULLS, strict=True):
        assert part.stretch == pytest.approx(1.0 + STRAIN, rel=1e-6)
        assert part.stress == pytest.approx(scale * pull, rel=1e-6)


@pytest.mark.parametrize(
    "heads",
    [
        "Strain,Stress,Strain,Stress",
        "Strain,Stress,Strain.1,Stress.1",
        "Strain_1,Stress_1,Strain_2,Stress_2",
        "Probe 1 Strain,Probe 1 Stress,Probe 2 Strain,Probe 2 Stress",
        "Strain 20C,Stress 20C,Strain 80C,Stress 80C",
        "Warp strain,Warp stress,Weft strain,Weft stress",
    ],
)
def test_the_unit_that_a_message_asks_for_is_that_of_every_specimen(heads: str) -> None:
    found = as_told(pairs(heads))
    same(found)
    assert len({(part.specimen, part.direction, str(part.temperature_degC)) for part in found}) == 2


def test_an_unit_may_be_typed_for_each_and_a_sign_holds_for_all() -> None:
    data = pairs("Strain_1,Stress_1,Strain_2,Stress_2")
    each = layout(["Stress_1=stress [kPa],Stress_2=stress [kPa]"])
    same(read_tests(data, "a.csv", test="uniaxial", columns=each), 1e-3)
    push = table("Strain_1,Stress_1,Strain_2,Stress_2", -0.5 * STRAIN, PULLS[0], -0.5 * STRAIN, PULLS[1])
    found = read_tests(push, "a.csv", test="uniaxial", columns=layout(["Stress_1=-stress [MPa]"]))
    assert [part.stress.max() < 0.0 for part in found] == [True, True]


def test_a_specimen_that_is_set_aside_is_not_read() -> None:
    data = pairs("Strain_1,Stress_1 [MPa],Strain_2,Stress_2 [MPa]")
    [found] = read_tests(data, "a.csv", test="uniaxial", columns=layout(["Strain_2=aside,Stress_2 [MPa]=aside"]))
    assert found.stress == pytest.approx(PULLS[0], rel=1e-6)


def test_two_axes_that_are_named_stay_axes() -> None:
    data = pairs("Strain_1,Stress_1,Strain_2,Stress_2")
    axes = "Strain_1=strain,Stress_1=stress [MPa],Strain_2=strain 2,Stress_2=stress 2 [MPa]"
    [found] = read_tests(data, "a.csv", columns=layout([axes]))
    assert found.mode == "biaxial-general"


@pytest.mark.parametrize(
    "heads",
    [
        "strain_uniaxial,stress_uniaxial [MPa],strain_biaxial,stress_biaxial [MPa]",
        "Uniaxial strain,Uniaxial stress (MPa),Equibiaxial strain,Equibiaxial stress (MPa)",
    ],
)
def test_titles_may_name_the_test_of_their_column(heads: str) -> None:
    found = read_tests(pairs(heads), "a.csv")
    same(found)
    assert [part.mode for part in found] == ["uniaxial", "biaxial"]
    with pytest.raises(InputError, match="give the file without the option"):
        read_tests(pairs(heads), "a.csv", test="uniaxial")


def test_tests_named_in_titles_may_share_a_stretch_or_stand_alone() -> None:
    both = table("stretch,stress_uniaxial [MPa],stress_planar [MPa]", 1.0 + STRAIN, *PULLS)
    assert [part.mode for part in read_tests(both, "a.csv")] == ["uniaxial", "shear"]
    [alone] = read_tests(table("strain_uniaxial,stress_uniaxial [MPa]", STRAIN, PULLS[0]), "a.csv")
    assert alone.mode == "uniaxial"
    assert alone.stress == pytest.approx(PULLS[0], rel=1e-6)


def test_a_strain_and_a_stress_that_nothing_stands_under_leave_the_true_ones() -> None:
    heads = "True strain;True stress [MPa];Engineering strain;Engineering stress [MPa]"
    rows = "".join(f"{np.log1p(e):.7g};{s * (1.0 + e):.7g};;\n" for e, s in zip(STRAIN, PULLS[0], strict=True))
    [found] = read_tests(f"{heads}\n{rows}".encode(), "a.csv", test="uniaxial")
    assert found.stretch == pytest.approx(1.0 + STRAIN, rel=1e-6)
    assert found.stress == pytest.approx(PULLS[0], rel=1e-6)


def test_a_strain_that_falls_from_one_as_the_stress_grows_is_a_stretch() -> None:
    stretch = np.linspace(1.0, 0.93, 15)
    preload = 0.2 + np.linspace(0.0, 1.0, 15)  # not at rest when the recording began
    found = as_told(table("strain,stress [kPa]", stretch, -preload))
    assert found[0].stretch == pytest.approx(stretch, rel=1e-6)


def test_a_push_of_a_few_per_cent_whose_stress_is_positive_is_asked_about() -> None:
    stretch = np.linspace(1.0, 0.93, 15)
    data = table("stretch,stress [kPa]", stretch, np.linspace(0.0, 1.0, 15))
    with pytest.raises(InputError, match="below 1") as caught:
        read_tests(data, "a.csv", test="uniaxial")
    assert "=-stretch" not in str(caught.value)
    assert as_told(data)[0].stress.max() <= 0.0
    slack = table("strain,stress [kPa]", np.linspace(-0.03, 0.5, 15), np.linspace(0.1, 1.0, 15))
    assert read_tests(slack, "a.csv", test="uniaxial")[0].stretch.min() == pytest.approx(0.97)


@pytest.mark.parametrize(
    ("heads", "directions", "temperatures"),
    [
        ("strain,warp [MPa],weft [MPa]", [0.0, 90.0], [None, None]),
        ("strain,MD (N/mm2),TD (N/mm2)", [0.0, 90.0], [None, None]),
        ("strain,0deg [MPa],45 deg [MPa]", [0.0, 45.0], [None, None]),
        ("strain,20C [MPa],80C [MPa]", [None, None], [20.0, 80.0]),
    ],
)
def test_titles_that_only_say_which_are_stresses_by_their_unit(
    heads: str, directions: list[float | None], temperatures: list[float | None]
) -> None:
    found = read_tests(table(heads, STRAIN, *PULLS), "a.csv", test="uniaxial")
    same(found)
    assert [one.direction for one in found] == directions
    assert [None if one.temperature_degC is None else one.temperature_degC[0] for one in found] == temperatures


@pytest.mark.parametrize("one", ["warp", "calendering"])
def test_titles_that_only_say_which_are_all_proposed_as_stresses(one: str) -> None:
    found = as_told(table(f"x,{one},transverse", STRAIN, *PULLS))
    same(found)
    assert [one.direction for one in found] == [0.0, 90.0]


LOADS = np.array([0.0, 1.0, 2.0, 4.0])


@pytest.mark.parametrize("numbers", [("",), (" 1", " 2")])
def test_strips_of_two_directions_under_the_same_loads_are_each_their_own(numbers: tuple[str, ...]) -> None:
    """The elongation along the weft was taken for the width of the strip along the warp."""
    of_each = [(way, gain) for way, gain in (("warp", 5.0), ("weft", 9.0)) for _ in numbers]
    heads = [f"Extension {way}{number} (%)" for way in ("warp", "weft") for number in numbers]
    data = table(",".join(["Load (N)", *heads]), LOADS, *(gain * LOADS for _, gain in of_each))
    found = read_tests(b"# width: 50 mm\n" + data, "a.csv", test="uniaxial")
    assert [one.direction for one in found] == [0.0 if way == "warp" else 90.0 for way, _ in of_each]
    for one, (_, gain) in zip(found, of_each, strict=True):
        assert one.stretch == pytest.approx(1.0 + 0.01 * gain * LOADS)
        assert one.stress == pytest.approx(LOADS / 50.0)
        assert one.stretch2 is None


def test_a_width_that_is_drawn_in_is_of_the_same_strip() -> None:
    data = table("Load (N),Strain warp (%),Strain weft (%)", LOADS, 5.0 * LOADS, -2.0 * LOADS)
    [found] = read_tests(b"# width: 50 mm\n" + data, "a.csv", test="uniaxial")
    assert found.stretch2 is not None
    assert found.stretch2[-1] == pytest.approx(0.92)


def test_forces_of_four_arms_are_asked_for() -> None:
    """The second, which pulls against the first or across it, was taken for that of the second axis."""
    rows = "".join(f"{k},{k},{2 * k},{2 * k},{10 * k},{5 * k}\n" for k in range(5))
    text = f"# width: 40 mm\n# thickness: 1 mm\nF1 [N],F2 [N],F3 [N],F4 [N],strain x [%],strain y [%]\n{rows}"
    told = layout(["strain x [%]=strain,strain y [%]=strain 2"])
    with pytest.raises(InputError, match=r"F1 \[N\] to F4 \[N\]: which are along one axis") as caught:
        read_tests(text.encode(), "a.csv", test="biaxial", columns=told)
    _, option = re.findall(r'--columns "([^"]*)"', str(caught.value))
    [found] = read_tests(text.encode(), "a.csv", test="biaxial", columns=layout([option]))
    assert found.mode == "biaxial-general"
    assert found.stress2 is not None
    assert found.stress2 == pytest.approx(2.0 * found.stress)


def test_of_a_test_with_two_forces_both_elongations_are_offered() -> None:
    """The first alone was, and pasted, no option was shown for the second."""
    rows = "".join(f"{k},{2 * k},{k},{2 * k}\n" for k in range(5))
    text = f"# width: 40 mm\n# thickness: 1 mm\n# gauge length: 60 mm\nFx [N],Fy [N],dx [mm],dy [mm]\n{rows}"
    found = as_told(text.encode(), test="biaxial")
    assert found[0].mode == "biaxial-general"
    assert found[0].stretch2 == pytest.approx(1.0 + np.arange(0.0, 10.0, 2.0) / 60.0)
