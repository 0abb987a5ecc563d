"""Tests that are none of ours, or tell what they show otherwise: frames, peels, bulges, shear by its angle."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import TestData, read_tests
from hyperfab.io.headings import heading, meaning
from hyperfab.io.specimen import Geometry

STRIP = Geometry(gauge_length=100.0, width=50.0)
ROWS = "1;2;3\n2;4;6\n3;7;9\n"


def read(text: str, **options: object) -> list[TestData]:
    return read_tests(text.encode(), "a.csv", **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("title", "said"),
    [
        ("Picture frame test", "a strip cut at 45 degrees"),
        ("Trellis frame test, PES weave", "a strip cut at 45 degrees"),
        ("Peel test", "no stress of the sheet"),
        ("Test;Tear strength", "no stress of the sheet"),
        ("ASTM D4964 CRE (looped specimen)", "--width is twice that of the strip"),
        ("Ball burst, ASTM D6797", "hf close-loop with the document of hf fabric-contact"),
    ],
)
@pytest.mark.parametrize("test", [None, "uniaxial"])
def test_a_test_of_which_no_stress_is_read_is_refused_by_name(title: str, said: str, test: str | None) -> None:
    """It was asked for as --uniaxial with a gauge length, and was a uniaxial test then."""
    text = f"{title}\n\nDisplacement [mm];Force [N];Shear angle [deg]\n{ROWS}"
    with pytest.raises(InputError, match=said) as caught:
        read(text, test=test, geometry=STRIP)
    assert caught.value.line == 1
    [found] = read(f"# test: uniaxial\n{title}\n\nDisplacement [mm];Force [N]\n1;2\n2;4\n3;7\n", geometry=STRIP)
    assert found.mode == "uniaxial"


@pytest.mark.parametrize("above", ["Bulge test\n\nPressure [kPa];Height [mm]", "Pressure [mbar];Pole height [mm]"])
def test_the_pressure_below_a_bulge_is_not_offered_as_its_stress(above: str) -> None:
    with pytest.raises(InputError, match=r"the nominal stress is p r l / \(2 t\)") as caught:
        read(f"{above}\n1;2\n2;4\n3;7\n")
    assert "--columns" not in str(caught.value)


def test_a_pressure_on_a_foam_is_still_offered_as_its_stress() -> None:
    with pytest.raises(InputError, match=r"Druck \[kPa\]=stress \[kPa\]"):
        read("Druckversuch\nStauchung [%];Druck [kPa]\n1;2\n2;4\n3;7\n")


def test_a_shear_may_be_read_as_an_angle_and_its_force_over_the_width() -> None:
    """As KES-F writes them: degrees, and gf/cm; 1 gf/cm is 9.80665e-4 N/mm."""
    [found] = read("SHEAR ANGLE(deg)\tSHEAR FORCE(gf/cm)\n0\t0\n4\t2\n8\t5\n")
    assert (found.mode, found.membrane) == ("simple-shear", True)
    assert found.stretch == pytest.approx(np.tan(np.radians([0.0, 4.0, 8.0])))
    assert found.stress == pytest.approx(np.array([0.0, 2.0, 5.0]) * 9.80665e-4)
    with pytest.raises(InputError, match=r'an angle without a unit; .*"SHEAR ANGLE=shear strain \[deg\]"'):
        read("SHEAR ANGLE\tSHEAR FORCE(gf/cm)\n0\t0\n4\t2\n8\t5\n")


def test_a_length_beside_an_extension_tells_the_gauge_length() -> None:
    """As CellScale's BioTester writes them, along both axes."""
    rows = "".join(
        f"{22000 + x},{18000 + y},{x},{y},{x / 10},{y / 10}\n" for x, y in ((0, 0), (1100, 900), (2200, 1800))
    )
    head = "XSize_um,YSize_um,XDisplacement_um,YDisplacement_um,XForce_mN,YForce_mN"
    [found] = read(f"{head}\n{rows}", geometry=Geometry(width=20.0))
    assert found.mode == "biaxial-general"
    assert found.stretch == pytest.approx([1.0, 1.05, 1.1])
    assert found.stretch2 == pytest.approx([1.0, 1.05, 1.1])


def test_image_correlation_reads_along_both_axes_of_a_biaxial_test() -> None:
    above = "Biaxial test\nArm width;40;mm\nGauge length;20;mm\n\n"
    head = "Time (s);Load cell X (mN);Load cell Y (mN);DIC displacement X (mm);DIC displacement Y (mm)\n"
    [found] = read(f"{above}{head}0;0;0;0;0\n1;100;90;1;0.9\n2;200;180;2;1.8\n")
    assert (found.mode, found.on_specimen) == ("biaxial-general", True)
    assert found.stretch2 == pytest.approx([1.0, 1.045, 1.09])
    assert found.stress == pytest.approx([0.0, 0.0025, 0.005])


@pytest.mark.parametrize("title", ["Marker distance [mm]", "Camera time [s]", "Extensometer strain 2 [%]"])
def test_what_a_gauge_is_numbered_or_stands_at_is_no_reading_along_an_axis(title: str) -> None:
    assert meaning(heading(title, 0)) is None


@pytest.mark.parametrize("room", ["Room temperature;23;°C", "Raumtemperatur;23;°C", "Ambient temperature: 23 °C"])
def test_a_test_is_as_warm_as_it_was_made_and_not_as_its_room(room: str) -> None:
    for lines in ((room, "Test temperature;80;°C"), ("试验温度;80;°C", room)):
        text = "\n".join(["Tensile test", *lines, "", "Displacement [mm];Force [N]", "1;2", "2;4"])
        [found] = read(text, geometry=STRIP)
        assert found.temperature_degC is not None
        assert found.temperature_degC.tolist() == [80.0, 80.0]
    [found] = read(f"Tensile test\n{room}\n\nDisplacement [mm];Force [N]\n1;2\n2;4\n", geometry=STRIP)
    assert found.temperature_degC is not None
    assert found.temperature_degC.tolist() == [23.0, 23.0]


@pytest.mark.parametrize(
    "above",
    [
        "Specimen,Load at Maximum (N),Extension at Maximum (mm)",
        "Probe,Höchstkraft (N),Höchstkraftdehnung (%)",
        "No,Breaking force (N),Breaking elongation (%)",
        "Sample,Strain (%),Stress (MPa),Young's modulus (MPa)",
    ],
)
def test_results_of_specimens_are_no_curve(above: str) -> None:
    """The breaks of four specimens, or what they bore at 20 %, were a curve, or offered as one by --columns."""
    rows = "1,120.3,84.2,1.25\n2,118.0,83.0,1.22\n3,121.0,85.1,1.26\n"
    cut = "\n".join(",".join(row.split(",")[: above.count(",") + 1]) for row in rows.splitlines())
    with pytest.raises(InputError, match=r"a row a specimen, and hf reads the curves behind them") as caught:
        read(f"{above}\n{cut}\n", test="uniaxial", geometry=STRIP)
    assert "--columns" not in str(caught.value)


def test_a_ledger_of_kawabatas_figures_is_a_table_of_results() -> None:
    """The linearity was offered as the strain, the work as the stress."""
    text = "Sample,LT [-],WT [gf.cm/cm2],RT [%],EMT [%]\nK7-1,0.81,12.1,45.2,22.1\nK7-2,0.80,12.3,45.6,22.4\n"
    with pytest.raises(InputError, match="results, a row a specimen, and hf reads the curves behind them"):
        read_tests(text.encode(), "kes.csv", test="uniaxial")
