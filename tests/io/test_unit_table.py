"""Every unit that is understood, in SI, against the tables of NIST and BIPM; none is left out."""

from __future__ import annotations

from fractions import Fraction

import pytest

from hyperfab.io import unit_table
from hyperfab.io.unit_table import parse_unit

#: Values in SI base units (kg m s K, degrees of angle): NIST SP 811 (2008), appendix B.8, and the SI Brochure, 9th ed.,
#: tables 7 and 8. As printed there: seven digits where the factor is not exact.
SI = {
    # length [m]
    "m": 1, "in": 0.0254, "inch": 0.0254, "inches": 0.0254, '"': 0.0254, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
    "yd": 0.9144, "yard": 0.9144, "mil": 2.54e-5, "thou": 2.54e-5, "micron": 1e-6,
    "mile": 1609.344, "furlong": 201.168, "fathom": 1.8288, "hand": 0.1016, "angstrom": 1e-10, "Å": 1e-10,
    # mass [kg], mass per area [kg/m^2], mass per length [kg/m]
    "g": 1e-3, "t": 1e3, "lb": 0.45359237, "lbs": 0.45359237, "lbm": 0.45359237, "oz": 0.028349523125,
    "slug": 14.593903, "gsm": 1e-3, "pound": 0.45359237, "ounce": 0.028349523125, "grain": 6.479891e-5,
    "stone": 6.35029318, "tonne": 1e3, "tex": 1e-6, "den": 1.1111111e-7, "denier": 1.1111111e-7,
    # time [s], frequency [1/s] (a turn a minute is told as turns)
    "s": 1, "sec": 1, "min": 60, "h": 3600, "hr": 3600, "hour": 3600, "hours": 3600, "d": 86400, "day": 86400,
    "minute": 60, "minutes": 60, "days": 86400, "week": 604800,
    "Hz": 1, "rpm": 0.016666667,
    # force [N]
    "N": 1, "p": 9.80665e-3, "gf": 9.80665e-3, "kgf": 9.80665, "kp": 9.80665, "lbf": 4.4482216152605,
    "ozf": 0.27801385, "kip": 4448.2216152605, "dyn": 1e-5, "dyne": 1e-5, "poundal": 0.138254954376,
    "daN": 10, "tf": 9806.65, "gF": 9.80665e-3, "kgF": 9.80665, "lbF": 4.4482216152605, "ozF": 0.27801385,
    # pressure [Pa]
    "Pa": 1, "bar": 1e5, "psi": 6894.7573, "ksi": 6.8947573e6, "psf": 47.880259, "atm": 101325, "at": 98066.5,
    "torr": 133.32237, "mmHg": 133.322387415, "inHg": 3386.3886,
    # energy [J], power [W]
    "J": 1, "Wh": 3600, "cal": 4.184, "erg": 1e-7, "BTU": 1055.05585262, "Btu": 1055.05585262, "btu": 1055.05585262,
    "eV": 1.602176634e-19, "W": 1, "hp": 745.69987, "PS": 735.49875,
    # volume [m^3], temperature [K]
    "l": 1e-3, "L": 1e-3, "K": 1, "degR": 0.55555556,
    # angle [deg], share
    "deg": 1, "degree": 1, "degrees": 1, "°": 1, "gon": 0.9, "arcmin": 0.016666667, "rad": 57.295780,
    "%": 0.01, "percent": 0.01, "‰": 0.001, "ppm": 1e-6, "1": 1,
}  # fmt: skip
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}


@pytest.mark.parametrize("name", SI)
def test_a_unit_is_what_the_tables_say(name: str) -> None:
    # Half a digit of the eight that are printed.
    assert float(parse_unit(name).factor) == pytest.approx(SI[name], rel=4e-8)


def test_no_unit_is_left_out() -> None:
    assert set(SI) == set(unit_table._PLAIN) | set(unit_table._PREFIXED)
    assert set(PREFIXES) == set(unit_table._PREFIXES)


@pytest.mark.parametrize("prefix", PREFIXES)
def test_a_prefix_is_that_power_of_ten(prefix: str) -> None:
    for unit in ("Pa", "W", "N"):
        assert parse_unit(prefix + unit).factor == Fraction(str(PREFIXES[prefix]))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("N", "kg m/s^2"), ("Pa", "N/m^2"), ("J", "N m"), ("W", "J/s"), ("Wh", "W h"), ("Hz", "1/s"), ("l", "dm^3"),
        ("hp", "W"), ("cal", "J"), ("psf", "lbf/ft^2"), ("ozf", "N"), ("slug", "lbf s^2/ft"), ("gsm", "g/m^2"),
        ("eV", "J"), ("atm", "Pa"), ("rpm", "1/min"),
    ],
)  # fmt: skip
def test_a_unit_is_of_its_kind(one: str, other: str) -> None:
    assert parse_unit(one).dimension == parse_unit(other).dimension


@pytest.mark.parametrize(
    ("name", "factor", "zero"),
    [
        *((name, Fraction(1), Fraction("273.15")) for name in ("degC", "°C", "celsius", "Celsius", "℃", "C", "deg C")),
        *((name, Fraction(5, 9), Fraction("255.372222222222222222")) for name in ("degF", "°F", "fahrenheit", "F")),
    ],
)
def test_a_scale_has_its_zero(name: str, factor: Fraction, zero: Fraction) -> None:
    unit = parse_unit(name)
    assert unit.factor == factor
    assert float(unit.zero) == float(zero)
    # In a product, and as a difference, only the degree counts.
    if name not in ("℃", "deg C"):
        assert parse_unit(f"W/{name}").factor == 1 / factor
