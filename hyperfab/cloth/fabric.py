"""Spring laws from a fabric's strain-energy law: uniaxial tension, tabulated as far as the law is sane."""

from __future__ import annotations

import numpy as np

from hyperfab.materials import Material

from .law import Floats, SpringLaw, tabulate

#: Largest stretch a table goes to; beyond its end the curve continues straight.
LARGEST = 5.0
#: A law that locks is cut where its slope passes this many times the slope at rest.
LOCKED = 1e3


def spring_law(material: Material) -> SpringLaw:
    """Table of the nominal stress of a fabric strip in uniaxial tension, free to contract.

    Raises ValueError where the law has no stiffness at rest or no values beyond it.

    >>> from hyperfab.materials import bind
    >>> law = spring_law(bind("neo-hookean", {"C10_MPa": 0.2}))
    >>> round(float(law(2.0)[1][0]), 10), law.largest_stretch
    (0.7, 5.0)
    """
    stretch = np.linspace(1.0, LARGEST, 4001)
    found = material.uniaxial(stretch)
    sane = np.isfinite(found.P) & np.isfinite(found.A) & (LOCKED * max(found.A[0], 0.0) > found.A)
    count = len(stretch) if sane.all() else int(np.argmin(sane))
    if count < 10:
        raise ValueError("the law has no stiffness in tension at rest")

    def law(at: Floats) -> tuple[Floats, Floats]:
        answer = material.uniaxial(at)
        return answer.P, answer.A

    return tabulate(law, float(stretch[count - 1]))


def softens_at(law: SpringLaw, largest: float) -> float | None:
    """Smallest stretch up to ``largest`` at which the stress no longer rises, or None.

    >>> from hyperfab.cloth.law import piecewise_linear
    >>> softens_at(piecewise_linear([1.0, 1.2, 1.4], [0.0, 1.0, 0.9]), 1.3) > 1.19
    True
    """
    stretch = np.linspace(1.0 + 1e-9, max(largest, 1.0 + 2e-9), 2001)
    falling = law(stretch)[2] <= 0.0
    return float(stretch[np.argmax(falling)]) if falling.any() else None
