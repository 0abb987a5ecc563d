"""Gent-Gent law: Gent's law and a logarithm of I2, ``W = -(mu Im/2) ln(1 - (I1 - 3)/Im) + C2 ln(I2/3)``.

Pucci & Saccomandi (2002), Rubber Chem. Technol. 75, 839, doi:10.5254/1.3547687.
"""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.materials.law import InvariantTerm, Sheet, Value, log_I2
from hyperfab.materials.laws.gent import Gent, gent_term


class GentGent(Gent):
    """Gent's law with the second invariant, which tells biaxial from uniaxial stretch; mu0 = mu + 2 C2/3."""

    name = "gent-gent"
    title = "limited chain length and the second invariant"
    source = "doi:10.5254/1.3547687"
    equation = "W = -(mu Im/2) ln(1 - (I1 - 3)/Im) + C2 ln(I2/3)"
    linear: tuple[str, ...] = ("mu_MPa", "C2_MPa")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the terms of mu and C2."""
        return [gent_term(sheet, theta[0]), log_I2(sheet)]


LAWS = (GentGent(),)
