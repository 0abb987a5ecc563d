"""Yeoh laws: ``W = sum Ci0 (I1 - 3)^i``, mu = 2 C10.

Yeoh (1993), Rubber Chem. Technol. 66, 754, doi:10.5254/1.3538343.
"""

from __future__ import annotations

from hyperfab.materials.polynomial import Polynomial

LAWS = tuple(
    Polynomial(f"yeoh-{n}", f"{n} power{'s' if n > 1 else ''} of I1 - 3", *((i, 0) for i in range(1, n + 1)))
    for n in (1, 2, 3)
)
