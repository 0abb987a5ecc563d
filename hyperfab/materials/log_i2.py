"""The term ``ln(I2/3)`` that several laws borrow to tell biaxial stretch from uniaxial."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.kinematics import Sheet
from hyperfab.materials.term import InvariantTerm, of_I2


def log_I2(sheet: Sheet) -> InvariantTerm:
    """Return ``ln(I2/3)``; Gent & Thomas (1958), J. Polym. Sci. 28, 625, doi:10.1002/pol.1958.1202811814."""
    I2 = 3.0 + sheet.y
    return of_I2(W=np.log1p(sheet.y / 3.0), W2=1.0 / I2, W22=-1.0 / I2**2)
