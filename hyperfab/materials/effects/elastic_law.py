"""Terms that make a strain-energy law richer: what is added is itself an energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import expit

from hyperfab.materials.kinematics import Sheet
from hyperfab.materials.log_i2 import log_I2
from hyperfab.materials.term import InvariantTerm, PowerTerm, Term, of_I1, of_I2

#: Forms of what is added, and the names of their constants; those that end in _MPa are linear.
FORMS = {
    "powers": ("C20_MPa", "C30_MPa"),
    "powers-log": ("C20_MPa", "C30_MPa", "C2_MPa"),
    "powers-mixed": ("C20_MPa", "C30_MPa", "C01_MPa", "C11_MPa"),
    "ogden": ("mu_MPa", "alpha"),
    "exponential": ("D_MPa", "b"),
    "high-powers": ("C40_MPa", "C2_MPa"),
    "second-invariant": ("C01_MPa", "C11_MPa", "C02_MPa"),
    "straightening": ("D_MPa", "at", "width"),
    "straightening-log": ("D_MPa", "at", "width", "C2_MPa"),
}
#: Forms that add to an Ogden or exponential term, in the order of their linear constants.
_WITH_LOG = {"ogden-log": "ogden", "exponential-log": "exponential"}
FORMS |= {name: (*FORMS[simple], "C2_MPa") for name, simple in _WITH_LOG.items()}


def split(form: str, values: Sequence[float]) -> tuple[list[float], list[float]]:
    """Return the constants of a form that its terms are linear in, in MPa, and the others.

    >>> split("exponential", [0.3, 2.0])
    ([0.3], [2.0])
    """
    named = list(zip(FORMS[form], values, strict=True))
    linear = [float(value) for name, value in named if name.endswith("_MPa")]
    return linear, [float(value) for name, value in named if not name.endswith("_MPa")]


def added_terms(form: str, sheet: Sheet, shape: Sequence[float]) -> list[Term]:
    """Return the terms of the linear constants of a form; ``shape`` holds the others (alpha, b).

    ``straightening`` is a stiffness that rises by D where yarns have straightened, at I1 - 3 = ``at``, over ``width``;
    ``exponential`` is Fung's ``D/b (exp(b (I1 - 3)) - 1)``: Fung (1967), Am. J. Physiol. 213, 1532.
    """
    x = sheet.x
    square, cube = of_I1(x**2, 2.0 * x, 2.0 + 0.0 * x), of_I1(x**3, 3.0 * x**2, 6.0 * x)
    if form == "powers":
        return [square, cube]
    if form == "powers-log":
        return [square, cube, log_I2(sheet)]
    if form == "powers-mixed":
        return [square, cube, *added_terms("second-invariant", sheet, shape)[:2]]
    if form == "high-powers":
        return [of_I1(x**4, 4.0 * x**3, 12.0 * x**2), log_I2(sheet)]
    if form in _WITH_LOG:
        return [*added_terms(_WITH_LOG[form], sheet, shape), log_I2(sheet)]
    if form == "second-invariant":
        y = sheet.y
        mixed = InvariantTerm(W=x * y, W1=y, W2=x, W12=1.0 + 0.0 * x)
        return [of_I2(y, 1.0 + 0.0 * y, 0.0 * y), mixed, of_I2(y**2, 2.0 * y, 2.0 + 0.0 * y)]
    if form.startswith("straightening"):
        at, width = shape
        step = expit((x - at) / width)
        grown = width * (np.logaddexp(0.0, (x - at) / width) - np.logaddexp(0.0, -at / width))
        found: list[Term] = [of_I1(grown, step, step * (1.0 - step) / width)]
        return [*found, log_I2(sheet)] if form.endswith("log") else found
    if form == "ogden":
        return [PowerTerm(shape[0])]
    grown = np.exp(np.minimum(shape[0] * x, 50.0))
    return [of_I1(np.expm1(np.minimum(shape[0] * x, 50.0)) / shape[0], grown, shape[0] * grown)]
