"""Spring laws from a fabric's strain-energy law: uniaxial tension, tabulated as far as the law is sane."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array
from hyperfab.materials.material import Uniaxial

from .law import SpringLaw, tabulate

#: Largest stretch a table goes to; beyond its end the curve continues straight.
LARGEST = 5.0
#: A law that locks is cut where its slope passes this many times the slope at rest.
LOCKED = 1e3


class Pulled(Protocol):
    """What a strip of fabric answers to tension along one direction, free to contract."""

    def uniaxial(self, stretch: ArrayLike) -> Uniaxial:
        """Return energy, nominal stress and its slope [MPa]."""
        ...


def spring_law(material: Pulled) -> SpringLaw:
    """Table of the nominal stress of a fabric strip in uniaxial tension, free to contract.

    Where the stress stops rising the table ends, and the curve goes on level: a falling stress would let the net
    tear itself apart. ``softens`` of the law says where.
    Raises ValueError where the law has no stiffness at rest or no values beyond it.

    >>> from hyperfab.materials import bind
    >>> law = spring_law(bind("neo-hookean", {"C10_MPa": 0.2}))
    >>> round(float(law(2.0)[1][0]), 10), law.largest_stretch, law.softens
    (0.7, 5.0, None)
    """
    stretch = np.linspace(1.0, LARGEST, 4001)
    found = material.uniaxial(stretch)
    sane = np.isfinite(found.P) & np.isfinite(found.A) & (LOCKED * max(found.A[0], 0.0) > found.A)
    rising = sane & (found.A > 0.0)
    count = len(stretch) if rising.all() else int(np.argmin(rising))
    if count < 10:
        raise ValueError("the law has no stiffness in tension at rest")

    def law(at: Array) -> tuple[Array, Array]:
        answer = material.uniaxial(at)
        return answer.P, answer.A

    end = float(stretch[count - 1])
    table = tabulate(law, end)
    falls = count < len(stretch) and bool(sane[count])
    return replace(table, softens=end) if falls else table
