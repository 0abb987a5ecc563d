"""Units nobody meets every day, from pint's registry: one name at a time, so that no expression reaches it."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from typing import Any

_NAME = re.compile(r"[A-Za-z][A-Za-z_]{1,23}", re.ASCII)
_BASE = ("[length]", "[mass]", "[time]", "[temperature]")


def rare_unit(name: str) -> tuple[Fraction, tuple[int, int, int, int, int]] | None:
    """Return the SI factor and dimension of the unit ``name``; None where pint has none of these dimensions.

    >>> rare_unit("furlong")
    (Fraction(792000, 3937), (1, 0, 0, 0, 0))
    """
    if not _NAME.fullmatch(name):
        return None
    import pint

    try:
        found = _registry().Quantity(1, name).to_base_units()
        shifted = (
            _registry().Quantity(0, name).to_base_units().magnitude != 0
        )  # a scale with a zero of its own
    except (pint.PintError, AttributeError, ValueError, TypeError, ArithmeticError):
        return None
    powers = dict(found.dimensionality)
    exponents = [powers.pop(base, 0) for base in _BASE]
    if shifted or powers or not any(exponents) or any(exponent != int(exponent) for exponent in exponents):
        return None
    length, mass, time, temperature = (int(exponent) for exponent in exponents)
    return Fraction(str(found.magnitude)), (length, mass, time, temperature, 0)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(non_int_type=Fraction, autoconvert_offset_to_baseunit=False, cache_folder=None)
