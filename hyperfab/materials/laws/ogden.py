"""Ogden laws: ``W = sum mu_r/alpha_r (l1^alpha_r + l2^alpha_r + l3^alpha_r - 3)``, mu = sum mu_r alpha_r / 2.

Ogden (1972), Proc. R. Soc. A 326, 565, doi:10.1098/rspa.1972.0026.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from hyperfab.materials.law import Axis, Extent, Law, PowerTerm, Sheet, Value, linear_axis

#: Exponents are sought here, in tests of short reach up to a power that grows by e^12 over it: beyond, it is a wall
#: that no readings lie on. Tissue that stiffens within 5 % has 78.
BOX = (-30.0, 30.0)
_GROWN = 12.0
#: Nearer to zero than this none is taken: the power is a logarithm to four digits, and mu grows beyond all bounds.
LEAST = 1e-3


class Ogden(Law):
    """Powers of the stretches; ``mu_r alpha_r > 0`` keeps each term stable on its own (Hill's condition)."""

    source = "doi:10.1098/rspa.1972.0026"
    equation = "W = sum mu_r/alpha_r (l1^alpha_r + l2^alpha_r + l3^alpha_r - 3)"
    exchangeable = True

    def __init__(self, order: int) -> None:
        numbers = range(1, order + 1)
        self.name = f"ogden-{order}"
        self.title = f"{order} power{'s' if order > 1 else ''} of the stretches"
        self.linear = tuple(f"mu{r}_MPa" for r in numbers)
        self.nonlinear = tuple(f"alpha{r}" for r in numbers)
        # Of a term that is next to nothing no test tells the power: a refit would take it anywhere.
        self.bounds = dict.fromkeys(self.nonlinear, BOX)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """mu1, alpha1, mu2, alpha2, ..."""
        pairs = zip(self.linear, self.nonlinear, strict=True)
        return tuple(name for mu, alpha in pairs for name in (mu, alpha))

    def join(self, c: Sequence[float], theta: Sequence[float]) -> dict[str, float]:
        """Return the parameters by name."""
        return dict(zip(self.names, (float(v) for pair in zip(c, theta, strict=True) for v in pair), strict=True))

    def axes(self, extent: Extent) -> list[Axis]:
        """Seek every exponent in the same box, the wider the less the tests stretched."""
        reach = float(np.arcsinh(0.5 * np.sqrt(extent.x)))  # of planar tension to that I1
        most = max(BOX[1], _GROWN / reach) if reach > 0.0 else BOX[1]
        return [linear_axis(-most, most) for _ in self.nonlinear]

    def sign(self, theta: Sequence[Value]) -> Value:
        """mu_r has the sign of alpha_r; nan where that is too near to zero."""
        alpha = np.stack(np.broadcast_arrays(*theta))
        return np.where(np.abs(alpha) < LEAST, np.nan, np.sign(alpha))

    def order(self, theta: Sequence[float]) -> list[int]:
        """Positive powers first, each sign by rising magnitude."""
        return sorted(range(len(theta)), key=lambda r: (theta[r] < 0.0, abs(theta[r])))

    def lower(self) -> Law | None:
        """Return the law with one power less."""
        return Ogden(len(self.linear) - 1) if len(self.linear) > 1 else None

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """Refuse an exponent of zero: the term would be a constant."""
        zero = [name for name in self.nonlinear if parameters[name] == 0.0]
        return f"{zero[0]} is zero" if zero else None

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[PowerTerm]:
        """Return one power a pair of constants."""
        return [PowerTerm(alpha) for alpha in theta]


LAWS = tuple(Ogden(order) for order in (1, 2, 3))
