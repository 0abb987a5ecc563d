"""Alexander's law: ``W = C1 int exp(k (I1-3)^2) dI1 + C2 ln((I2 - 3 + gamma)/gamma) + C3 (I2 - 3)``.

Alexander (1968), Int. J. Eng. Sci. 6, 549, doi:10.1016/0020-7225(68)90006-2. mu = 2 (C1 + C2/gamma + C3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from hyperfab.materials.law import (
    Array,
    Axis,
    Extent,
    InvariantTerm,
    Law,
    Sheet,
    Value,
    log_axis,
    of_I1,
    of_I2,
    positive,
)


class Alexander(Law):
    """Exponential upturn in I1, Gent-Thomas and Mooney terms in I2; made for neoprene film."""

    name = "alexander"
    title = "exponential in I1, logarithm and line in I2"
    source = "doi:10.1016/0020-7225(68)90006-2"
    equation = "W = C1 int exp(k (I1-3)^2) dI1 + C2 ln((I2 - 3 + gamma)/gamma) + C3 (I2 - 3)"
    linear = ("C1_MPa", "C2_MPa", "C3_MPa")
    nonlinear = ("k", "gamma")

    def axes(self, extent: Extent) -> list[Axis]:
        """k from a straight line to an upturn of e^20 over the data; gamma below the I2 of the data."""
        return [log_axis(1e-3 / extent.x**2, 20.0 / extent.x**2), log_axis(1e-3, 1e3)]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """gamma is above zero."""
        return positive(parameters, "gamma")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the terms of C1, C2 and C3."""
        k, gamma = theta
        x, y = sheet.x, sheet.y
        growth = np.exp(k * x * x)
        return [
            of_I1(W=lambda: _integral(x, k), W1=growth, W11=2.0 * k * x * growth),
            of_I2(W=np.log1p(y / gamma), W2=1.0 / (y + gamma), W22=-((y + gamma) ** -2.0)),
            of_I2(W=y, W2=1.0, W22=0.0),
        ]


def _integral(x: Array, k: Value) -> Array:
    """Return int_0^x exp(k s^2) ds by Gauss quadrature: the integrand is entire, 64 points leave no error."""
    nodes, weights = _gauss()
    s = x[..., None] * nodes
    return np.asarray(x * (np.exp(k * s * s) @ weights))


@cache
def _gauss() -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(64)
    return 0.5 * (nodes + 1.0), 0.5 * weights


LAWS = (Alexander(),)
