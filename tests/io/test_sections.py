"""What a force acts on: the section that a file states, or that its sizes make."""

from __future__ import annotations

import re

import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.specimen import Geometry
from hyperfab.io.units import quantity

PULL = "Tensile test\nWidth,50,mm\nGauge length,100,mm\n{}Extension (mm),Load (N)\n10,2\n20,4\n"
PRESS = "Compression test ISO 3386\n{}Compressive strain (%),Compressive load (N)\n10,800\n20,1800\n"


def one(text: str, geometry: Geometry | None = None) -> TestData:
    [found] = read_tests(text.encode(), "a.csv", geometry=geometry)
    return found


def given(options: str) -> Geometry:
    """Return the sizes of options as a message shows them."""
    told = re.findall(r"--([a-z-]+) (\S+?mm)", options)
    return Geometry(**{name.replace("-", "_"): quantity(value, "length") for name, value in told})


def test_a_stated_area_is_the_section() -> None:
    found = one(PULL.format("Area,40,mm^2\n"))
    assert (found.stress.tolist(), found.membrane) == (pytest.approx([0.05, 0.1]), False)
    assert one(PULL.format("Area,40,mm^2\nThickness,0.8,mm\n")).stress.tolist() == pytest.approx([0.05, 0.1])


def test_an_area_that_gainsays_width_and_thickness_is_asked_for() -> None:
    text = PULL.format("Area,20,mm^2\nThickness,0.8,mm\n")
    with pytest.raises(InputError, match=r"line 4: states an area of 20 mm\^2") as caught:
        one(text)
    sizes, area = str(caught.value).split("or for the area")
    assert one(text, given(sizes)).stress.tolist() == pytest.approx([0.05, 0.1])
    assert one(text, given(area)).stress.tolist() == pytest.approx([0.1, 0.2])


@pytest.mark.parametrize(
    "sizes",
    [
        "Width,100,mm\nThickness,50,mm\nArea,10000,mm^2\nGauge length,50,mm\n",
        "Specimen length,100,mm\nSpecimen width,100,mm\nSpecimen thickness,50,mm\n",
        "Länge,100,mm\nBreite,100,mm\nHöhe,50,mm\n",
        "Length,100,mm\nWidth,100,mm\nThickness,50,mm\nGauge length,50,mm\n",
    ],
)
def test_a_block_that_is_pressed_stands_on_length_times_width(sizes: str) -> None:
    assert one(PRESS.format(sizes)).stress.tolist() == pytest.approx([-0.08, -0.18])


def test_a_bar_that_is_pressed_along_its_gauge_length_keeps_width_times_thickness() -> None:
    text = PRESS.format("Width,10,mm\nThickness,5,mm\nGauge length,30,mm\n")
    assert one(text).stress.tolist() == pytest.approx([-16.0, -36.0])


def test_of_a_block_that_states_no_length_the_area_is_asked_for() -> None:
    text = PRESS.format("Width,100,mm\nThickness,50,mm\n")
    with pytest.raises(InputError, match="needs the area that is pressed") as caught:
        one(text)
    assert one(text, given(str(caught.value))).stress.tolist() == pytest.approx([-0.16, -0.36])
    line = re.findall(r'"(# area: [^"]*)"', str(caught.value))[0]
    assert one(f"{line}\n{text}").stress.tolist() == pytest.approx([-0.08, -0.18])


def test_what_is_pressed_is_the_height_and_no_length_of_the_block() -> None:
    text = PRESS.replace("strain (%)", "displacement (mm)")
    with pytest.raises(InputError, match="thickness of 50 mm: if that is pressed") as caught:
        one(text.format("Length,100,mm\nWidth,100,mm\nThickness,50,mm\n"))
    found = one(text.format("Length,100,mm\nWidth,100,mm\nThickness,50,mm\n"), given(str(caught.value)))
    assert found.stretch.tolist() == pytest.approx([0.8, 0.6])
    assert found.stress.tolist() == pytest.approx([-0.08, -0.18])


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("Thickness,0.8", r"line 4, key thickness.*--thickness 0.8mm"),
        ("Thickness,0.8,mm\nSpecimen thickness,0.9,mm", r"states 0.8 mm and 0.9 mm; .*--thickness 0.8mm or"),
    ],
)
def test_a_size_that_is_needed_and_cannot_be_taken_is_asked_for(line: str, message: str) -> None:
    """Without it the stress would be one per width, in N/mm, and its constants look like those in MPa."""
    with pytest.raises(InputError, match=message) as caught:
        one(PULL.format(f"{line}\n"))
    found = one(
        PULL.format(f"{line}\n"),
        given(str(caught.value).split(" or ")[0] if "states" in message else str(caught.value)),
    )
    assert found.stress.tolist() == pytest.approx([0.05, 0.1])


def test_a_gauge_length_without_a_unit_is_shown_with_it() -> None:
    with pytest.raises(InputError, match="--gauge-length 100mm"):
        one(PULL.replace("Gauge length,100,mm", "Gauge length,100").format("Thickness,0.8,mm\n"))


@pytest.mark.parametrize(
    "words",
    [
        "Test length", "Jaw span", "Distance between jaws", "Distance between clamps", "Length between grips",
        "Initial jaw separation", "Nominal gage length", "Clamp separation", "Free clamping length", "Nip distance",
        "Prüflänge", "Distanza iniziale tra i morsetti", "Longueur d'épreuve", "Initial specimen length",
    ],
)  # fmt: skip
def test_the_length_between_the_grips_is_known_in_the_words_of_standards(words: str) -> None:
    text = PULL.replace("Gauge length", words).format("Thickness,0.8,mm\n")
    assert one(text).stretch.tolist() == pytest.approx([1.1, 1.2])
