"""Extended tube law: chains of limited length in tubes formed by their neighbours.

``W = Gc/2 [(1 - d^2)(I1 - 3)/(1 - d^2 (I1 - 3)) + ln(1 - d^2 (I1 - 3))] + 2 Ge/beta^2 (sum l^-beta - 3)``
Kaliske & Heinrich (1999), Rubber Chem. Technol. 72, 602, doi:10.5254/1.3538822. mu = Gc (1 - 2 d^2) + Ge.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.materials.law import Axis, Extent, Law, PowerTerm, Sheet, Term, Value, distance_to, log_axis, of_I1


class ExtendedTube(Law):
    """Cross-links Gc, entanglements Ge, inextensibility delta, tube relaxation beta."""

    name = "extended-tube"
    title = "limited chain length in tubes of entanglement"
    source = "doi:10.5254/1.3538822"
    equation = "W = Gc/2 [(1-d^2)(I1-3)/(1-d^2(I1-3)) + ln(1-d^2(I1-3))] + 2 Ge/beta^2 (sum l^-beta - 3), d = delta"
    linear = ("Gc_MPa", "Ge_MPa")
    nonlinear = ("delta", "beta")

    def axes(self, extent: Extent) -> list[Axis]:
        """1/delta^2 lies beyond the data's I1 - 3; beta from 0.001, near its null, to 10."""
        low, high = math.log(1e-4), math.log(1e4)
        return [Axis(low, high, lambda u: (extent.x * (1.0 + np.exp(u))) ** -0.5), log_axis(1e-3, 10.0)]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """beta is not zero."""
        return "beta is zero" if parameters["beta"] == 0.0 else None

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[Term]:
        """Return the terms of Gc and Ge."""
        delta, beta = theta
        d, x = delta * delta, sheet.x
        left = distance_to(1.0, d * x)
        # W1 = [(1-d)/left^2 - d/left]/2; the sum cancels at rest only to 1 - 2 d, which is as it should be.
        first = 0.5 * ((1.0 - d) / left**2 - d / left)
        second = 0.5 * (2.0 * d * (1.0 - d) / left**3 - d * d / left**2)
        return [
            of_I1(W=lambda: 0.5 * ((1.0 - d) * x / left + np.log1p(-d * x + 0.0 * left)), W1=first, W11=second),
            PowerTerm(-beta, factor=-2.0 / beta),
        ]


LAWS = (ExtendedTube(),)
