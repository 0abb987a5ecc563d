"""The units of length, mass, time, temperature and angle, and what is made of them, as exact fractions of SI.

A small grammar of its own rather than a library: unit expressions come from people's files, and the general ones
evaluate powers of powers without end, round factors, and cost more to load than a whole command takes.
Sources: BIPM, The International System of Units (9th ed.); NIST SP 811, appendix B (exact factors).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

#: Exponents of length, mass, time, temperature, angle.
Dimension = tuple[int, int, int, int, int]
_NONE: Dimension = (0, 0, 0, 0, 0)


class UnitError(ValueError):
    """A text that is no unit, or a unit of another kind; the message says what to write."""


@dataclass(frozen=True)
class Unit:
    """``factor`` SI units, of ``dimension``. ``zero`` is the zero point of a temperature scale in kelvin."""

    factor: Fraction
    dimension: Dimension
    zero: Fraction = Fraction(0)


DIMENSIONLESS = Unit(Fraction(1), _NONE)

_LENGTH: Dimension = (1, 0, 0, 0, 0)
_MASS: Dimension = (0, 1, 0, 0, 0)
_TIME: Dimension = (0, 0, 1, 0, 0)
_TEMPERATURE: Dimension = (0, 0, 0, 1, 0)
_ANGLE: Dimension = (0, 0, 0, 0, 1)
_FORCE: Dimension = (1, 1, -2, 0, 0)
_STRESS: Dimension = (-1, 1, -2, 0, 0)
_ENERGY: Dimension = (2, 1, -2, 0, 0)
_POWER: Dimension = (2, 1, -3, 0, 0)
_VOLUME: Dimension = (3, 0, 0, 0, 0)
_FREQUENCY: Dimension = (0, 0, -1, 0, 0)
_PER_AREA: Dimension = (-2, 1, 0, 0, 0)
_PER_LENGTH: Dimension = (-1, 1, 0, 0, 0)

_PREFIXES: dict[str, Fraction] = {
    "G": Fraction(10**9), "M": Fraction(10**6), "k": Fraction(10**3), "h": Fraction(10**2),
    "d": Fraction(1, 10), "c": Fraction(1, 100),
    "m": Fraction(1, 10**3), "u": Fraction(1, 10**6), "n": Fraction(1, 10**9),
}  # fmt: skip
#: Units that take a prefix: symbol, factor to SI, dimension. The gram's factor makes kg 1.
_PREFIXED: dict[str, tuple[str, Dimension]] = {
    "m": ("1", _LENGTH), "g": ("1/1000", _MASS), "s": ("1", _TIME), "N": ("1", _FORCE), "Pa": ("1", _STRESS),
    "J": ("1", _ENERGY), "W": ("1", _POWER), "Wh": ("3600", _ENERGY), "bar": ("100000", _STRESS),
    "cal": ("4.184", _ENERGY), "K": ("1", _TEMPERATURE), "l": ("1/1000", _VOLUME), "L": ("1/1000", _VOLUME),
    "Hz": ("1", _FREQUENCY), "p": ("0.00980665", _FORCE), "tex": ("1/1000000", _PER_LENGTH),
}  # fmt: skip
#: Prefixed units spelled out, and the prefixes that go with them: kilonewton, millimetres.
_SPELLED = {
    "meter": "m", "metre": "m", "gram": "g", "second": "s", "newton": "N", "pascal": "Pa", "joule": "J", "watt": "W",
    "kelvin": "K", "liter": "l", "litre": "l", "hertz": "Hz", "calorie": "cal",
}  # fmt: skip
_PREFIXES_SPELLED = {
    "giga": "G", "mega": "M", "kilo": "k", "hecto": "h", "deci": "d", "centi": "c", "milli": "m", "micro": "u",
    "nano": "n", "": "",
}  # fmt: skip
_SPELLED_OUT = re.compile(f"({'|'.join(_PREFIXES_SPELLED)})({'|'.join(_SPELLED)})s?")
_INCH, _POUND, _GRAVITY = Fraction("0.0254"), Fraction("0.45359237"), Fraction("9.80665")
_LBF = _POUND * _GRAVITY
_BTU = Fraction("1055.05585262")
_PLAIN: dict[str, tuple[Fraction, Dimension]] = {
    "in": (_INCH, _LENGTH), "inch": (_INCH, _LENGTH), "inches": (_INCH, _LENGTH), '"': (_INCH, _LENGTH),
    "ft": (12 * _INCH, _LENGTH), "foot": (12 * _INCH, _LENGTH), "feet": (12 * _INCH, _LENGTH),
    "yd": (36 * _INCH, _LENGTH), "yard": (36 * _INCH, _LENGTH), "mil": (_INCH / 1000, _LENGTH),
    "thou": (_INCH / 1000, _LENGTH), "micron": (Fraction(1, 10**6), _LENGTH),
    "mile": (63360 * _INCH, _LENGTH), "furlong": (7920 * _INCH, _LENGTH), "fathom": (72 * _INCH, _LENGTH),
    "hand": (4 * _INCH, _LENGTH),
    "angstrom": (Fraction(1, 10**10), _LENGTH), "Å": (Fraction(1, 10**10), _LENGTH),
    "t": (Fraction(1000), _MASS), "lb": (_POUND, _MASS), "lbs": (_POUND, _MASS), "lbm": (_POUND, _MASS),
    "pound": (_POUND, _MASS), "oz": (_POUND / 16, _MASS), "ounce": (_POUND / 16, _MASS),
    "tonne": (Fraction(1000), _MASS), "grain": (_POUND / 7000, _MASS), "stone": (14 * _POUND, _MASS),
    "slug": (_LBF / (12 * _INCH), _MASS),
    "sec": (Fraction(1), _TIME), "min": (Fraction(60), _TIME), "minute": (Fraction(60), _TIME),
    "minutes": (Fraction(60), _TIME), "days": (Fraction(86400), _TIME), "week": (Fraction(604800), _TIME),
    "h": (Fraction(3600), _TIME),
    "hr": (Fraction(3600), _TIME), "hour": (Fraction(3600), _TIME), "hours": (Fraction(3600), _TIME),
    "d": (Fraction(86400), _TIME), "day": (Fraction(86400), _TIME),
    "daN": (Fraction(10), _FORCE), "gF": (_GRAVITY / 1000, _FORCE), "kgF": (_GRAVITY, _FORCE), "lbF": (_LBF, _FORCE),
    "ozF": (_LBF / 16, _FORCE),
    "gf": (_GRAVITY / 1000, _FORCE), "kgf": (_GRAVITY, _FORCE), "kp": (_GRAVITY, _FORCE), "lbf": (_LBF, _FORCE),
    "tf": (1000 * _GRAVITY, _FORCE),
    "ozf": (_LBF / 16, _FORCE), "kip": (1000 * _LBF, _FORCE), "dyn": (Fraction(1, 10**5), _FORCE),
    "dyne": (Fraction(1, 10**5), _FORCE), "poundal": (_POUND * 12 * _INCH, _FORCE),
    "psi": (_LBF / _INCH**2, _STRESS), "ksi": (1000 * _LBF / _INCH**2, _STRESS),
    "psf": (_LBF / (12 * _INCH) ** 2, _STRESS), "atm": (Fraction(101325), _STRESS),
    "at": (_GRAVITY * 10**4, _STRESS), "torr": (Fraction(101325, 760), _STRESS),
    "mmHg": (Fraction("133.322387415"), _STRESS), "inHg": (Fraction("3386.388640341"), _STRESS),
    "erg": (Fraction(1, 10**7), _ENERGY), "BTU": (_BTU, _ENERGY), "Btu": (_BTU, _ENERGY), "btu": (_BTU, _ENERGY),
    "eV": (Fraction("1.602176634e-19"), _ENERGY),
    "hp": (550 * _LBF * 12 * _INCH, _POWER), "PS": (75 * _GRAVITY, _POWER),
    "degR": (Fraction(5, 9), _TEMPERATURE),
    "gsm": (Fraction(1, 1000), _PER_AREA),
    "den": (Fraction(1, 9 * 10**6), _PER_LENGTH), "denier": (Fraction(1, 9 * 10**6), _PER_LENGTH),
    "rpm": (Fraction(1, 60), _FREQUENCY),
    "deg": (Fraction(1), _ANGLE), "degree": (Fraction(1), _ANGLE), "degrees": (Fraction(1), _ANGLE),
    "°": (Fraction(1), _ANGLE), "gon": (Fraction(9, 10), _ANGLE), "arcmin": (Fraction(1, 60), _ANGLE),
    "rad": (Fraction("57.29577951308232087679815481410517033241"), _ANGLE),
    "%": (Fraction(1, 100), _NONE), "percent": (Fraction(1, 100), _NONE), "‰": (Fraction(1, 1000), _NONE),
    "ppm": (Fraction(1, 10**6), _NONE), "1": (Fraction(1), _NONE),
}  # fmt: skip
#: Scales with a zero of their own: factor and zero point [K]. In products and as a difference only the factor counts.
_SCALES: dict[str, tuple[Fraction, Fraction]] = {
    **dict.fromkeys(("degC", "°C", "celsius", "Celsius", "℃", "C", "deg C", "° C"), (Fraction(1), Fraction("273.15"))),
    **dict.fromkeys(
        ("degF", "°F", "fahrenheit", "Fahrenheit", "℉", "F", "deg F", "° F"),
        (Fraction(5, 9), Fraction("459.67") * 5 / 9),
    ),
}
_DIFFERENCES = {"delta_degC": "degC", "delta_degF": "degF", "ΔK": "K", "delta_K": "K"}

_MAX_LENGTH = 40
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_SUPERSCRIPT_RUN = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_FACTOR = re.compile(r"""(1(?!\d)|[^\W\d_]+(?:_deg[CF]|_K)?|°[CF]?|[%‰"])(?:(?:\^|\*\*)?\(?(-?\d{1,2})\)?)?""")
#: A factor before a unit or in its place, told as one: x100 N, 10^-3, 1e-3, 1/1000; and behind it: N x 10.
#: Of x103 the exponent may have been lost: it is none.
_SCALE = re.compile(
    r"[x*]? ?10(?:\^\(?|\*\*|(?=-))(?P<power>-?\d)\)?"
    r"|[x*] ?(?P<times>(?!10[1-9])[1-9]\d{0,5})|1[eE](?P<short>-?\d)|1/(?P<below>10+)"
)
_SCALED = re.compile(r"(.*[^\W\d_]) ?[x*] ?(10{1,6})")
_COUNT = re.compile(r"([1-9]\d{0,3}(?:\.\d{1,3})?) ?(?=[^\W\d_])")


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """Return the unit ``text`` stands for: ``MPa``, ``W/m^2/K``, ``W/(m² K)``, ``lbf/in2``, ``1/s``, ``s^-1``, ``%``.

    A product is read from left to right, so ``J/kg K`` is (J/kg) K; parentheses are allowed once. ``/K`` is ``1/K``.
    A factor is told as one: ``x100 N``, ``10^-3``; ``100 N`` is an amount and no unit.
    ``tex`` and ``den`` are textile's: mass per length of yarn; so is a width in ``N/5cm``. Units of metre to
    calorie may
    be spelled out.

    Raises UnitError where it is none.

    >>> parse_unit("kPa").factor, parse_unit("degF").factor
    (Fraction(1000, 1), Fraction(5, 9))
    """
    cleaned = _clean(text)
    factor, cleaned = _scale(cleaned)
    if factor != 1:
        unit = parse_unit(cleaned)
        return Unit(factor * unit.factor, unit.dimension)
    if cleaned in ("", "-", "–", "—"):
        return DIMENSIONLESS
    if cleaned in _SCALES:
        factor, zero = _SCALES[cleaned]
        return Unit(factor, _TEMPERATURE, zero)
    if len(cleaned) > _MAX_LENGTH:
        raise UnitError(f"{text[:20]}... is no unit")
    numerator, parenthesis, denominator = cleaned.partition("/(")
    if parenthesis:
        if not denominator.endswith(")"):
            raise UnitError(f"{text} is no unit")
        return _product(numerator, text, _product(denominator[:-1], text, None), -1)
    return _product(cleaned, text, None)


def _scale(text: str) -> tuple[Fraction, str]:
    """Return the factor that a unit is told with, 1 where there is none, and the unit without it."""
    if behind := _SCALED.fullmatch(text):
        return Fraction(behind[2]), behind[1]
    match = _SCALE.match(text)
    if match is None or text[match.end() : match.end() + 1].isdigit():
        return Fraction(1), text
    if match["times"] or match["below"]:
        factor = Fraction(match["times"] or 1) / Fraction(match["below"] or 1)
    else:
        factor = Fraction(10) ** int(match["power"] or match["short"])
    rest = text[match.end() :].strip(" *")
    return (Fraction(1), text) if rest.startswith("/") else (factor, rest)


def _clean(text: str) -> str:
    """Reduce the ways units are typeset to one: µ, superscripts, middle dots, spaces around operators."""
    text = text.strip().replace("µ", "u").replace("μ", "u").replace("º", "°")
    text = _SUPERSCRIPT_RUN.sub(lambda run: "^" + run[0].translate(_SUPERSCRIPTS), text)
    text = re.sub(r"(?<=[^\W\d_])\.(?=[^\W\d_])", "·", text)  # N.m, Pa.s
    text = re.sub(r"\s*([/·⋅×])\s*", r"\1", text[:200])
    return re.sub(r"[·⋅×]", "*", text)


def _product(text: str, whole: str, start: Unit | None, sign: int = 1) -> Unit:
    """Multiply out ``text``, times ``start`` to the power ``sign``."""
    factor, dimension = Fraction(1), list(_NONE)
    if start is not None:
        factor, dimension = start.factor**sign, [sign * exponent for exponent in start.dimension]
    place, operator = (1, -1) if text.startswith("/") else (0, 1)
    while True:
        count = _COUNT.match(text, place)
        if operator == -1 and count is not None:  # N/5cm, as ISO 13934 states the force of a strip
            factor /= Fraction(count[1])
            place = count.end()
        match = _FACTOR.match(text, place)
        if match is None:
            raise UnitError(f"{whole} is no unit; write it like MPa, W/m^2/K or 1/s")
        power = int(match[2] or 1) * operator
        if not 0 < abs(power) <= 6:  # h0 is a symbol, a thickness at the start, and no hour to the power of nothing
            raise UnitError(f"{whole} is no unit")
        base = _symbol(match[1], whole)
        factor *= base.factor**power
        dimension = [total + power * exponent for total, exponent in zip(dimension, base.dimension, strict=True)]
        place = match.end()
        if place == len(text):
            break
        if match[2] and text[place].isalpha():  # W/m2K: as W/m2 K
            continue
        operator = -1 if text[place] == "/" else 1
        if text[place] not in "/* ":
            raise UnitError(f"{whole} is no unit; write it like MPa, W/m^2/K or 1/s")
        place += 1
    length, mass, time, temperature, angle = dimension
    return Unit(factor, (length, mass, time, temperature, angle))


def _symbol(symbol: str, whole: str) -> Unit:
    spelled = _SPELLED_OUT.fullmatch(symbol)
    if spelled is not None:
        symbol = _PREFIXES_SPELLED[spelled[1]] + _SPELLED[spelled[2]]
    symbol = _DIFFERENCES.get(symbol, symbol)
    if symbol in _PLAIN:
        return Unit(*_PLAIN[symbol])
    if symbol in _SCALES:
        return Unit(_SCALES[symbol][0], _TEMPERATURE)
    if symbol in _PREFIXED:
        factor, dimension = _PREFIXED[symbol]
        return Unit(Fraction(factor), dimension)
    prefix, rest = symbol[:1], symbol[1:]
    if prefix in _PREFIXES and rest in _PREFIXED:
        factor, dimension = _PREFIXED[rest]
        return Unit(_PREFIXES[prefix] * Fraction(factor), dimension)
    near = [
        known
        for known in (*_PLAIN, *_PREFIXED, *_SCALES, "mm", "MPa", "kPa", "kN", "kW")
        if known.lower() == symbol.lower()
    ]
    raise UnitError(f"{whole} is no unit" + (f"; write {near[0]}" if near else ""))
