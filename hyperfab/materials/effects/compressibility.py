"""A sheet that changes its volume: contraction by an exponent other than one half."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, SHEAR, UNIAXIAL
from hyperfab.materials.kinematics import Array


def across(stretch: Array, contraction: float) -> Array:
    """Return the transverse stretch of a uniaxial test: ``stretch^-contraction``.

    Blatz & Ko (1962), Trans. Soc. Rheol. 6, 223, doi:10.1122/1.548937, for their exponent nu; 1/2 keeps the volume.

    >>> across(np.array([4.0]), 0.5)
    array([0.5])
    """
    return np.asarray(stretch**-contraction)


def as_incompressible(mode: Array, stretch: Array, second: Array, contraction: float) -> Array:
    """Return the second stretch at which an incompressible sheet has the same stretch and the same thickness.

    With the normal stress zero the thickness of Blatz and Ko's material is ``(l1 l2)^(-nu/(1-nu))``; the
    driving stress of a law in
    the stretches along the pull and through the thickness is then the incompressible one at ``l2 = 1/(l1
    l3)``. Exact for the neo-Hookean energy.
    """
    area = np.where(mode == BIAXIAL, stretch**2, np.where(mode == SHEAR, stretch, stretch * second))
    thickness = area ** (-contraction / (1.0 - contraction))
    thickness = np.where(mode == UNIAXIAL, stretch**-contraction, thickness)
    return np.asarray(1.0 / (stretch * thickness))
