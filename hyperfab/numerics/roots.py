"""Zeros of functions of one variable."""

from __future__ import annotations

import math
from collections.abc import Callable


def zero_between(value: Callable[[float], float], low: float, high: float, tolerance: float) -> float:
    """Return where ``value`` is zero between ``low`` and ``high``, to ``tolerance``.

    Chandrupatla's method (Adv. Eng. Softw. 28, 1997, 145): inverse quadratic interpolation where three points allow
    it, halving where not. SciPy has the like; loading it takes a third of a second, of commands that need no more of
    it.

    >>> round(zero_between(lambda x: x * x - 2.0, 0.0, 2.0, 1e-12), 9)
    1.414213562

    Raises:
        ValueError: the signs at the two ends are the same.

    """
    x1, x2 = low, high
    f1, f2 = value(x1), value(x2)
    if f1 != 0.0 and f2 != 0.0 and (f1 > 0.0) == (f2 > 0.0):
        raise ValueError(f"no change of sign between {low:g} and {high:g}")
    t = 0.5  # where the next point lies between the latest and the one beyond the zero
    while f1 != 0.0 and f2 != 0.0 and abs(x2 - x1) > tolerance:
        x = x1 + t * (x2 - x1)
        if x in (x1, x2):
            break  # no double lies between
        f = value(x)
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
        across, along = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        if 1.0 - math.sqrt(1.0 - across) < along < math.sqrt(across):
            t = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        else:
            t = 0.5
        least = min(0.5 * tolerance / abs(x2 - x1), 0.5)
        t = min(max(t, least), 1.0 - least)
    return x1 if abs(f1) < abs(f2) else x2
