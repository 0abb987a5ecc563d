"""Channels beside a tension test in units that it does not know, and what is proposed for columns of no known name."""

import pytest

from hyperfab.errors import InputError
from hyperfab.io.csv_tests import read_tests
from hyperfab.io.specimen import Geometry

STRIP = Geometry(gauge_length=50.0, width=5.0, thickness=1.0)


def table(*heads: str, rows: int = 5, columns: str = "{0},{0},{1},0.1") -> bytes:
    return "\n".join([*heads, *(columns.format(k, 0.002 * k) for k in range(rows))]).encode()


@pytest.mark.parametrize("unit", ["N.m", "Nm", "V", "mV", "Ohm", "l/min", "deg/s"])
def test_a_channel_in_volts_or_of_torque_costs_no_other_its_unit(unit: str) -> None:
    """The row of units was none: the kilonewtons in it were lost, and newtons proposed in their place."""
    (curve,) = read_tests(
        table("Time,Extension,Load,Channel 4", f"s,mm,kN,{unit}"), "a.csv", test="uniaxial", geometry=STRIP
    )
    assert curve.stretch[-1] == pytest.approx(1.08)
    assert curve.stress[-1] == pytest.approx(1.6)


def test_a_force_in_volts_is_refused_as_such() -> None:
    with pytest.raises(InputError, match="V is no unit"):
        read_tests(table("Time,Extension,Load,x", "s,mm,V,N"), "a.csv", test="uniaxial", geometry=STRIP)


@pytest.mark.parametrize(
    ("head", "option"),
    [
        ("Kanal A[kN],Kanal B[mm],Soll[],Nummer[]", '"Kanal A[kN]=force [kN],Kanal B[mm]=extension [mm]"'),
        ("Time,L,F,SD", '"Time=time [s],L=strain [%],F=stress [MPa]"'),
    ],
)  # fmt: skip
def test_what_is_proposed_is_one_stretch_and_one_stress(head: str, option: str) -> None:
    """A set point without a unit is no strain beside an extension; L is no litre, F no degree."""
    with pytest.raises(InputError) as found:
        read_tests(table(head), "a.csv", test="uniaxial", geometry=STRIP)
    assert f"--columns {option}" in str(found.value)


@pytest.mark.parametrize(
    "heads",
    [("Storage modulus,Loss modulus,Tan(delta),Frequency", "Pa,Pa,,Hz"), ("Temp./\u00b0C,Time/min,E'/MPa,tan d",)],
)
def test_no_modulus_of_a_sweep_is_proposed_as_a_strain(heads: tuple[str, ...]) -> None:
    text = table(*heads)
    with pytest.raises(InputError) as found:
        read_tests(text, "a.csv", test="uniaxial", geometry=STRIP)
    assert "no column gives" in str(found.value)
    assert "--columns" not in str(found.value)


def test_a_machine_numbers_its_channels_in_front_of_their_names() -> None:
    text = table("C_1_Temps[s];C_1_Déplacement[mm];C_1_Force[kN];C_1_Consigne[]", columns="{0};{0};{1};0.1")
    (curve,) = read_tests(text, "a.csv", test="uniaxial", geometry=STRIP)
    assert (curve.stretch[-1], curve.stress[-1]) == (pytest.approx(1.08), pytest.approx(1.6))


@pytest.mark.parametrize(("head", "unit"), [("Strain (%)", "-"), ("Strain [-]", "%")], ids=["shares", "per cent"])
@pytest.mark.parametrize("geometry", [STRIP, Geometry(width=5.0, thickness=1.0)], ids=["length known", "unknown"])
def test_a_strain_that_the_extension_beside_it_gainsays_is_refused(head: str, unit: str, geometry: Geometry) -> None:
    """Shares under a heading of per cent gave moduli a hundred times too large, without a word."""
    strain = 1.0 if unit == "%" else 0.01  # of what the cells hold, a step of 0.5 mm on 50 mm
    rows = "".join(f"{k * strain},{0.5 * k},{0.02 * k}\n" for k in range(6))
    with pytest.raises(InputError) as found:
        read_tests(f"{head},Extension (mm),Stress (MPa)\n{rows}".encode(), "a.csv", test="uniaxial", geometry=geometry)
    assert f'"{head}=strain [{unit}]"' in str(found.value.remedy)


def test_an_extension_of_the_grips_beside_that_of_marks_is_no_contradiction() -> None:
    """Cloth slips out of grips, and rubber yields beside the marks: three times as much is usual."""
    rows = "".join(f"{k},{1.5 * k},{0.02 * k}\n" for k in range(6))
    text = f"Strain (%),Extension (mm),Stress (MPa)\n{rows}".encode()
    (curve,) = read_tests(text, "a.csv", test="uniaxial", geometry=STRIP)
    assert curve.stretch[-1] == pytest.approx(1.05)


def test_a_strain_of_less_than_one_per_cent_is_told() -> None:
    (curve,) = read_tests(b"Strain (%),Stress (MPa)\n0,0\n0.2,0.1\n0.5,0.3\n", "a.csv", test="uniaxial")
    assert any("0.5 % at most" in note for note in curve.notes)


def test_of_columns_of_no_known_name_the_one_that_holds_the_word_is_proposed() -> None:
    """Of a blown film's channels the pressure was proposed as strain, its curvature as stress."""
    text = "Pressure_02,CurvatureMD_02,StrainEngMD_02,StressEngMD_02\n0.1,-1e-5,0.001,0.2\n0.2,-2e-5,0.002,0.5\n"
    with pytest.raises(InputError) as told:
        read_tests(text.encode(), "a.csv")
    assert '"StrainEngMD_02=strain [-],StressEngMD_02=stress [MPa]"' in str(told.value.remedy)
