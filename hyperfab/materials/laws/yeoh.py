"""Yeoh laws: ``W = sum Ci0 (I1 - 3)^i``, mu = 2 C10; the cubic with ``C2 ln(I2/3)`` too, mu = 2 C10 + 2 C2/3.

Yeoh (1993), Rubber Chem. Technol. 66, 754, doi:10.5254/1.3538343.
"""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.materials.law import InvariantTerm, Sheet, Value, log_I2
from hyperfab.materials.polynomial import Polynomial


class YeohLogI2(Polynomial):
    """Yeoh's cubic, with the second invariant in the weakest form it takes; linear in all four constants."""

    source = "doi:10.5254/1.3538343, doi:10.1002/pol.1958.1202811814"
    equation = "W = C10 (I1 - 3) + C20 (I1 - 3)^2 + C30 (I1 - 3)^3 + C2 ln(I2/3)"

    def __init__(self) -> None:
        super().__init__("yeoh-3-lni2", "Yeoh's cubic and the second invariant", (1, 0), (2, 0), (3, 0))
        self.linear = (*self.linear, "C2_MPa")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the three powers and the logarithm."""
        return [*super().terms(sheet, theta), log_I2(sheet)]


LAWS = (
    *(
        Polynomial(f"yeoh-{n}", f"{n} power{'s' if n > 1 else ''} of I1 - 3", *((i, 0) for i in range(1, n + 1)))
        for n in (1, 2, 3)
    ),
    YeohLogI2(),
)
