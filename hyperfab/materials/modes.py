"""The deformation modes of the tests: where a test lies in the plane of the two stretches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.curve import share_of_shear, sheared
from hyperfab.materials.law import Array, Sheet
from hyperfab.materials.material import Material

#: Modes with one stretch to say where a point lies.
MODES = ("uniaxial", "shear", "biaxial")
SIMPLE_SHEAR = "simple-shear"
#: The tests that all laws of a sheet carry.
OF_A_SHEET = (*MODES, "biaxial-general")


def way(mode: str) -> str:
    """Return the mode of ``MODES`` through whose states a test leads a body that keeps its volume.

    Simple shear is planar tension but for a turn, which does not strain it.

    >>> way("simple-shear"), way("biaxial")
    ('shear', 'biaxial')
    """
    return "shear" if mode == SIMPLE_SHEAR else mode


def second_stretch(mode: str, stretch: Array, contraction: Any = 0.5) -> Array:
    """Return the stretch across the loading direction of ``mode``.

    Free to contract in ``uniaxial`` (stretch^-contraction), held in planar ``shear``, the same in equal ``biaxial``.

    >>> second_stretch("uniaxial", np.array([4.0]))
    array([0.5])
    """
    if mode == "uniaxial":
        return np.asarray(stretch**-contraction)
    if mode == "shear":
        return np.ones_like(stretch)
    if mode == "biaxial":
        return stretch
    raise ValueError(f"{mode} has no single stretch")


def nominal_stress(material: Material, mode: str, stretch: ArrayLike) -> Array:
    """Return the nominal stress [MPa] along the loading direction of ``mode``; nan beyond the law's limit.

    In simple shear of a law that keeps its volume ``stretch`` is the shear strain, and the stress that of shear.

    >>> from hyperfab.materials import bind
    >>> nominal_stress(bind("neo-hookean", {"C10_MPa": 0.5}), "shear", [1.0, 2.0])
    array([0.   , 1.875])
    """
    lam = np.asarray(stretch, dtype=float)
    if mode == SIMPLE_SHEAR:
        if material.law.compressible:
            raise ValueError(f"{material.law.name} changes its volume: simple shear is no planar tension of it")
        lam = sheared(lam)
        return stress_at(material, lam, np.ones_like(lam)) * share_of_shear(lam)
    nu = material.law.contraction(material.theta)
    return stress_at(material, lam, second_stretch(mode, lam, nu))


def stress_at(material: Material, l1: Array, l2: Array) -> Array:
    """Return dW/dl1 [MPa] at in-plane stretches ``l1``, ``l2``, without the tangent."""
    with np.errstate(all="ignore"):
        sheet = Sheet.of(l1, l2)
        total = np.zeros(sheet.l1.shape)
        for constant, term in zip(material.c, material.law.terms(sheet, material.theta), strict=True):
            if constant != 0.0:
                total = total + constant * term.stress(sheet)
    return np.asarray(total)
