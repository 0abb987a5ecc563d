"""Quantities carry their unit; factors are exact; what is no quantity is refused with the right form."""

from __future__ import annotations

import contextlib
import time
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hyperfab.errors import InputError, UsageError, placed
from hyperfab.io.unit_table import UnitError, parse_unit
from hyperfab.io.units import KINDS, column_factor, quantity, tolerance, worded


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        # NIST SP 811, appendix B.8: exact conversions, rounded once to the nearest double
        ("1 in", "length", 25.4),
        ("1 ft", "length", 304.8),
        ("1 mil", "length", 0.0254),
        ("0.6mm", "length", 0.6),
        ("2x10^3 mm", "length", 2000.0),
        ("2·10⁻³ m", "length", 2.0),
        ("60 µm", "length", 0.06),
        ("3 millimeters", "length", 3.0),
        ("1 mile", "length", 1609344.0),
        ("2 kilonewtons", "force", 2000.0),
        ("5 minutes", "time", 300.0),
        ("4 oz/yd^2", "mass-per-area", 135.6229898995292),
        ("1 lbf", "force", 4.4482216152605),
        ("1 kgf", "force", 9.80665),
        ("250 cN", "force", 2.5),
        ("1 psi", "stress", 6.894757293168361336722673e-3),
        ("1 ksi", "stress", 6.894757293168361336722673),
        ("1 N/mm^2", "stress", 1.0),
        ("1 N/mm²", "stress", 1.0),
        ("1e6 Pa", "stress", 1.0),
        ("1 bar", "stress", 0.1),
        ("1 lbf/in", "membrane-stress", 0.175126835246476377952755905),
        ("25 degC", "temperature", 25.0),
        ("25°C", "temperature", 25.0),
        ("298.15 K", "temperature", 25.0),
        ("77 degF", "temperature", 25.0),
        ("-40 °F", "temperature", -40.0),
        ("9 degF", "temperature-difference", 5.0),
        ("2 degC", "temperature-difference", 2.0),
        ("2 delta_degC", "temperature-difference", 2.0),
        ("1 h", "time", 3600.0),
        ("50 min", "time", 3000.0),
        ("1 BTU", "energy", 1055.05585262),
        ("2.5 kWh", "energy", 9.0e6),
        ("3 kW", "power", 3000.0),
        ("1 hp", "power", 745.69987158227022),
        ("2 W/cm^2", "heat-flux", 20000.0),
        ("12 W/m^2/K", "film-coefficient", 12.0),
        ("12 W/(m² K)", "film-coefficient", 12.0),
        ("12 W m^-2 K^-1", "film-coefficient", 12.0),
        ("12 W/m2K", "film-coefficient", 12.0),
        ("1 BTU/h/ft^2/degF", "film-coefficient", 5.67826334111348778253),
        ("2.702 g/cm^3", "density", 2702.0),
        ("237 W/m/K", "conductivity", 237.0),
        ("0.903 kJ/kg/K", "specific-heat", 903.0),
        ("903 J/(kg*K)", "specific-heat", 903.0),
        ("903 J/kg K", "specific-heat", 903.0),
        ("23e-6/K", "thermal-expansion", 23e-6),
        ("180 gsm", "mass-per-area", 180.0),
        ("0.18 kg/m^2", "mass-per-area", 180.0),
        ("10 %", "dimensionless", 0.1),
        ("0.3", "dimensionless", 0.3),
        (0.3, "dimensionless", 0.3),
        ("0.5 mm/mm", "dimensionless", 0.5),
        ("1 rad", "angle", 57.29577951308232),
        ("10 mm/min", "velocity", 1 / 6),
        ("1 hand", "length", 101.6),
        ("1 poundal", "force", 0.138254954376),
        ("1 poundal/hand", "membrane-stress", 0.001360777110),
        ("6 %/min", "rate", 0.001),
    ],
)
def test_units_convert_to_the_nearest_double(text: object, kind: str, value: float) -> None:
    assert quantity(text, kind) == value


@pytest.mark.parametrize("kind", KINDS)
def test_the_example_of_each_kind_is_one(kind: str) -> None:
    assert quantity(KINDS[kind].example, kind, option="--x") is not None


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("60", "length", "write 60mm"),
        (60, "length", 'write "60mm"'),
        ("12", "film-coefficient", "write 12 W/m^2/K"),
        ("60 MPa", "length", "write it like 60mm"),
        ("60 mm", "temperature", "25 degC"),
        ("60 mpa", "stress", "write MPa"),
        ("60 furlongs_of_cloth", "length", "is no unit"),
        ("5 degRe", "temperature-difference", "is no unit"),
        ("1,5 mm", "length", "decimal point"),
        ("mm", "length", "a number and its unit"),
        ("", "length", "a number and its unit"),
        ("nan mm", "length", "is no length"),
        ("inf mm", "length", "is no length"),
        ("1_000 mm", "length", "is no"),
        ("١ mm", "length", "is no length"),
        ("1e400 mm", "length", "larger than any number"),
        ("1e999999999 mm", "length", "is no"),
        ("-300 degC", "temperature", "absolute zero"),
        ("5 degC/m", "temperature", "no unit of temperature"),
        ("5 m^7", "length", "is no unit"),
        (True, "length", "is written 60mm"),
        (None, "length", "is written 60mm"),
        (["60mm"], "length", "is written 60mm"),
        (float("nan"), "dimensionless", "no finite number"),
        (10**400, "dimensionless", "no finite number"),
        ("20x20 mm", "length", "may be a product or two sizes; write one number, as in 60mm"),
        ("4*100 W", "power", "may be a product or two sizes"),
        ("0x10 mm", "length", "may be a product or two sizes"),
    ],
)
def test_what_is_no_quantity_is_refused_with_the_right_form(text: object, kind: str, said: str) -> None:
    with pytest.raises(UsageError) as usage:
        quantity(text, kind, option="--depth")
    assert str(usage.value).startswith("--depth")
    assert said in str(usage.value)
    with pytest.raises(InputError) as bad, placed("mold.toml", "run.until"):
        quantity(text, kind)
    assert "mold.toml, key run.until" in str(bad.value)
    assert said in str(bad.value)


@pytest.mark.parametrize(
    "unit",
    [
        "m**(9**9**9)",
        "m^9^9^9",
        "m" * 10**6,
        "m*" * 10**5,
        "(" * 10**5,
        "m/" * 10**5,
        "m^" + "9" * 10**5,
        " " * 10**6,
    ],
)
def test_hostile_units_are_refused_at_once(unit: str) -> None:
    start = time.process_time()
    with pytest.raises(UsageError):
        quantity(f"60 {unit}", "length", option="--x")
    with pytest.raises(UsageError):
        quantity(f"{unit}", "length", option="--x")
    assert time.process_time() - start < 0.3


@given(st.text(max_size=30), st.sampled_from(sorted(KINDS)))
def test_any_text_is_a_number_or_a_usage_error(text: str, kind: str) -> None:
    with contextlib.suppress(UsageError):
        assert isinstance(quantity(text, kind, option="--x"), float)


@given(st.text(alphabet="mkgsNPaJWhKCF°degin²³^*/()-1 %·", max_size=16))
def test_any_unit_text_is_a_unit_or_a_unit_error(text: str) -> None:
    with contextlib.suppress(UnitError):
        assert parse_unit(text).factor > 0


@given(st.decimals(-10000, 10000, places=6), st.sampled_from(["mm", "inch", "um", "yd", "m"]))
def test_lengths_are_rounded_once(number: object, unit: str) -> None:
    exact = Fraction(str(number)) * {
        "mm": 1, "inch": Fraction(254, 10), "um": Fraction(1, 1000), "yd": Fraction(9144, 10), "m": 1000,
    }[unit]  # fmt: skip
    assert quantity(f"{number:f} {unit}", "length") == float(exact)


def test_units_of_yarn_are_exact() -> None:
    # ISO 1144: 1 tex is 1 g/km; the denier is 1 g per 9000 m
    kg_per_m = parse_unit("kg/m")
    for text, factor in (
        ("tex", Fraction(1, 10**6)),
        ("dtex", Fraction(1, 10**7)),
        ("den", Fraction(1, 9 * 10**6)),
    ):
        assert parse_unit(text).factor == factor
        assert parse_unit(text).dimension == kg_per_m.dimension
    assert parse_unit("cN/tex").factor == 10**4  # J/kg


def test_column_factors_are_exact() -> None:
    assert column_factor("kPa", "stress") == (Fraction(1, 1000), 0)
    assert column_factor("degF", "temperature") == (Fraction(5, 9), Fraction(-160, 9))
    with pytest.raises(UnitError):
        column_factor("mm", "stress")


@pytest.mark.parametrize(
    ("text", "kind", "value", "sd"),
    [
        ("200 degC +- 5 K", "temperature", 200.0, 5.0),
        ("200 degC ± 5 °C", "temperature", 200.0, 5.0),
        ("473.15 K +/- 9 degF", "temperature", 200.0, 5.0),
        ("3000 W ± 2 %", "power", 3000.0, 60.0),
        ("3 kW±60W", "power", 3000.0, 60.0),
        ("0.6mm +- 0.03mm", "length", 0.6, 0.03),
        ("0.6mm +- 30µm", "length", 0.6, 0.03),
        ("0.3 ± 0.05", "dimensionless", 0.3, 0.05),
        ("-2 mm +- 10 %", "length", -2.0, 0.2),
        ("12 W/m^2/K ± 25%", "film-coefficient", 12.0, 3.0),
        ("60mm +- 0mm", "length", 60.0, 0.0),
    ],
)
def test_a_quantity_may_state_one_standard_deviation(text: str, kind: str, value: float, sd: float) -> None:
    found = quantity(text, kind)
    assert (found, tolerance(found)) == (value, sd)
    again = quantity(worded(found, KINDS[kind].unit), kind)
    assert (again, tolerance(again)) == (value, sd)


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("200 degC +- 5", "temperature", "a tolerance needs its unit, or %; write 200 degC +- 2 K"),
        ("200 degC +- 5 %", "temperature", "a share of a temperature means nothing"),
        ("60mm +- 5 N", "length", "N is no unit of length"),
        ("60mm +- -1mm", "length", "a standard deviation is not below 0"),
        ("60mm +- ", "length", "nothing is no tolerance; write 60mm +- 2 %"),
        ("60mm ± 1mm ± 1mm", "length", "is no unit"),
        ("5 % ± 1 %", "dimensionless", "can be read two ways; write 0.05 +- 0.01"),
        ("± 1mm", "length", "is no length"),
    ],
)
def test_a_tolerance_that_cannot_be_meant_is_refused_with_the_right_form(text: str, kind: str, said: str) -> None:
    with pytest.raises(UsageError) as refused:
        quantity(text, kind, option="--x")
    assert said in str(refused.value)
