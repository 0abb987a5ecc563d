"""Terms that make a strain-energy law richer: what is added is itself an energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.materials.kinematics import Sheet
from hyperfab.materials.log_i2 import log_I2
from hyperfab.materials.term import PowerTerm, Term, of_I1

#: Forms of what is added, and the names of their constants; those that end in _MPa are linear.
FORMS = {
    "powers": ("C20_MPa", "C30_MPa"),
    "powers-log": ("C20_MPa", "C30_MPa", "C2_MPa"),
    "ogden": ("mu_MPa", "alpha"),
    "exponential": ("D_MPa", "b"),
    "high-powers": ("C40_MPa", "C2_MPa"),
}


def added_terms(form: str, sheet: Sheet, shape: Sequence[float]) -> list[Term]:
    """Return the terms of the linear constants of a form; ``shape`` holds the others (alpha, b).

    ``exponential`` is Fung's ``D/b (exp(b (I1 - 3)) - 1)``: Fung (1967), Am. J. Physiol. 213, 1532.
    """
    x = sheet.x
    square, cube = of_I1(x**2, 2.0 * x, 2.0 + 0.0 * x), of_I1(x**3, 3.0 * x**2, 6.0 * x)
    if form == "powers":
        return [square, cube]
    if form == "powers-log":
        return [square, cube, log_I2(sheet)]
    if form == "high-powers":
        return [of_I1(x**4, 4.0 * x**3, 12.0 * x**2), log_I2(sheet)]
    if form == "ogden":
        return [PowerTerm(shape[0])]
    grown = np.exp(np.minimum(shape[0] * x, 50.0))
    return [of_I1(np.expm1(np.minimum(shape[0] * x, 50.0)) / shape[0], grown, shape[0] * grown)]
