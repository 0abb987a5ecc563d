"""Carroll's law: ``W = A (I1 - 3) + B (I1^4 - 81) + C (sqrt(I2) - sqrt(3))``, mu = 2 A + 216 B + C/sqrt(3).

Carroll (2011), J. Elast. 103, 173, doi:10.1007/s10659-010-9276-7.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.materials.law import InvariantTerm, Law, Sheet, Value, of_I1, of_I2


class Carroll(Law):
    """Three constants, linear in all; follows rubber in all modes up to large stretch."""

    name = "carroll"
    title = "three linear constants for all modes"
    source = "doi:10.1007/s10659-010-9276-7"
    equation = "W = A (I1 - 3) + B (I1^4 - 81) + C (sqrt(I2) - sqrt(3))"
    linear = ("A_MPa", "B_MPa", "C_MPa")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the terms of A, B and C."""
        x, y = sheet.x, sheet.y
        I1, root = 3.0 + x, np.sqrt(3.0 + y)
        return [
            of_I1(W=x, W1=1.0, W11=0.0),
            of_I1(W=x * (I1 + 3.0) * (I1 * I1 + 9.0), W1=4.0 * I1**3, W11=12.0 * I1**2),
            of_I2(W=y / (root + 3.0**0.5), W2=0.5 / root, W22=-0.25 / root**3),
        ]


LAWS = (Carroll(),)
