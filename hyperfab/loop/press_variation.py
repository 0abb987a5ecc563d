"""Foam thickness that varies over the plan of the male: polynomials by name."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.problem import Array

#: Powers of the two plan coordinates in each form of thickness variation.
TERMS: dict[str, tuple[tuple[int, int], ...]] = {
    "wedge": ((1, 0), (0, 1)),
    "bowl": ((2, 0), (0, 2)),
    "quadric": ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
    "quadric of a bowl": ((2, 0), (0, 2), (1, 0), (0, 1), (1, 1)),
    "cubic": ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)),
    "flat bowl": ((2, 0), (0, 2), (4, 0), (2, 2), (0, 4)),
    "quartic": (
        *((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)),
        *((4, 0), (2, 2), (0, 4)),
    ),
}


def variation(plan: Array, form: str, given: Array) -> Array:
    """Return the relative change (n,) of foam thickness over the plan (n, 2)."""
    x, y = plan[:, 0], plan[:, 1]
    return np.asarray(sum(float(c) * x**i * y**j for c, (i, j) in zip(given, TERMS[form], strict=True)))
