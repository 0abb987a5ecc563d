"""Gent's law: ``W = -(mu Im/2) ln(1 - (I1 - 3)/Im)``, shear modulus mu, limit I1 - 3 < Im; with ``C2 ln(I2/3)`` the
Gent-Gent law.

Gent (1996), Rubber Chem. Technol. 69, 59, doi:10.5254/1.3538357.
Pucci & Saccomandi (2002), Rubber Chem. Technol. 75, 839, doi:10.5254/1.3547687.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.materials.law import (
    Axis,
    Extent,
    InvariantTerm,
    Law,
    Sheet,
    Value,
    distance_to,
    log_axis,
    log_I2,
    of_I1,
    positive,
)


class Gent(Law):
    """Chains of limited length: the stress grows beyond all bounds as I1 - 3 comes near Im."""

    name = "gent"
    title = "limited chain length"
    source = "doi:10.5254/1.3538357"
    equation = "W = -(mu Im/2) ln(1 - (I1 - 3)/Im)"
    linear: tuple[str, ...] = ("mu_MPa",)
    nonlinear: tuple[str, ...] = ("Im",)

    def axes(self, extent: Extent) -> list[Axis]:
        """Im lies beyond the data."""
        return [log_axis(1e-4 * extent.x, 1e4 * extent.x, beyond=extent.x)]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """Im is above zero."""
        return positive(parameters, "Im")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the one term of mu, ``-(Im/2) ln(1 - (I1 - 3)/Im)``."""
        Im = theta[0]
        left = distance_to(Im, sheet.x)
        return [
            of_I1(
                W=lambda: -0.5 * Im * np.log1p(-sheet.x / np.where(left == left, Im, np.nan)),
                W1=0.5 * Im / left,
                W11=0.5 * Im / left**2,
            )
        ]


class GentGent(Gent):
    """Gent's law with the second invariant, which tells biaxial from uniaxial stretch; mu0 = mu + 2 C2/3."""

    name = "gent-gent"
    title = "limited chain length and the second invariant"
    source = "doi:10.5254/1.3547687"
    equation = "W = -(mu Im/2) ln(1 - (I1 - 3)/Im) + C2 ln(I2/3)"
    linear: tuple[str, ...] = ("mu_MPa", "C2_MPa")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the terms of mu and C2."""
        return [*super().terms(sheet, theta), log_I2(sheet)]


LAWS = (Gent(), GentGent())
