"""A stiffness that changes with temperature."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.kinematics import Array


def factor(temperature: Array, reference: float, softening: float, curvature: float = 0.0) -> Array:
    """Return ``exp(-softening dT - curvature dT^2)``, dT [K] above ``reference``: a first-order softening
    of all moduli.

    ``softening`` [1/K] may be negative (entropic elasticity stiffens with temperature). Ferry (1980), Viscoelastic
    Properties of Polymers, ch. 11 (vertical shift).

    >>> factor(np.array([20.0]), 20.0, 0.01)
    array([1.])
    """
    rise = temperature - reference
    return np.asarray(np.exp(-softening * rise - curvature * rise**2))
