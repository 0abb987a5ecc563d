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
