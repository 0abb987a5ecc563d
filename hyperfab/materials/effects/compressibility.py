"""A sheet that changes its volume: contraction by an exponent other than one half."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, SHEAR, UNIAXIAL
from hyperfab.materials.kinematics import Array


def across(stretch: Array, contraction: Array | float, bend: float = 0.0) -> Array:
    """Return the transverse stretch of a uniaxial test: ``stretch^-(contraction + bend ln stretch)``.

    Blatz & Ko (1962), Trans. Soc. Rheol. 6, 223, doi:10.1122/1.548937, for their exponent nu; 1/2 keeps the volume.

    >>> across(np.array([4.0]), 0.5)
    array([0.5])
    """
    return np.asarray(stretch ** -(contraction + bend * np.log(stretch)))


def as_incompressible(
    mode: Array, stretch: Array, second: Array, contraction: Array, bend: float = 0.0
) -> Array:
    """Return the second stretch at which an incompressible sheet has the same stretch and the same thickness.

    With the normal stress zero the thickness of Blatz and Ko's material is ``(l1 l2)^(-nu/(1-nu))``; the
    driving stress of a law in
    the stretches along the pull and through the thickness is then the incompressible one at ``l2 = 1/(l1
    l3)``. Exact for the neo-Hookean energy.
    """
    area = np.where(mode == BIAXIAL, stretch**2, np.where(mode == SHEAR, stretch, stretch * second))
    thickness = area ** (-contraction / (1.0 - contraction))
    thickness = np.where(mode == UNIAXIAL, across(stretch, contraction, bend), thickness)
    return np.asarray(1.0 / (stretch * thickness))


def pull(stretch: Array, second: Array, usual: Array) -> Array:
    """Return by how much the driving stretch ``l - l3^2/l`` differs from that of a sheet with ``usual`` second stretch.

    ``second`` is that of ``as_incompressible``. For a sheet whose moduli go with its stretch, not with its volume: the
    slope of the law stays, what it acts on is less. 1 at rest.
    """
    driving = stretch - 1.0 / (stretch**3 * second**2)
    before = stretch - 1.0 / (stretch**3 * usual**2)
    return np.asarray(np.where(np.abs(before) > 1e-9, driving / np.where(before == 0.0, 1.0, before), 1.0))
