"""Foam thickness that varies over the plan of the male: polynomials by name."""

from __future__ import annotations

from collections.abc import Mapping

from hyperfab.loop.problem import Array

#: Where a term of the thickness is added: ``variation.xxy`` is the coefficient of x^2 y.
VARIATION = "variation."


def variation(plan: Array, amounts: Mapping[str, float]) -> Array | float:
    """Return the relative change (n,) of foam thickness over the plan (n, 2); 0 where no term is among ``amounts``."""
    x, y = plan[:, 0], plan[:, 1]
    return sum(
        coefficient * x ** name.count("x", len(VARIATION)) * y ** name.count("y", len(VARIATION))
        for name, coefficient in amounts.items()
        if name.startswith(VARIATION)
    )
