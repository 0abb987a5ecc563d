"""A law with its constants: what the sheet answers to stretch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.materials.law import Array, Law, Membrane, Sheet


@dataclass(frozen=True)
class Uniaxial:
    """Answer to tension along one direction, free to contract: energy W, nominal stress P, A = dP/dstretch."""

    W: Array
    P: Array
    A: Array


@dataclass(frozen=True)
class Material:
    """A strain-energy law with constants: linear ones ``c`` [MPa], others ``theta``.

    Made by ``hyperfab.materials.bind``. Stretches may be arrays of any shape; stresses are nominal [MPa], energies
    per undeformed volume [MPa = N/mm^2]. Beyond the limit of a law (Gent's Im) everything is nan.

    >>> from hyperfab.materials import bind
    >>> rubber = bind("neo-hookean", {"C10_MPa": 0.2})
    >>> round(float(rubber.uniaxial(2.0).P), 12)
    0.7
    >>> round(float(rubber.membrane(1.0, 1.0).A11), 12)
    1.6
    """

    law: Law
    c: tuple[float, ...]
    theta: tuple[float, ...]

    @property
    def parameters(self) -> dict[str, float]:
        """The constants by name, as in a material document."""
        return self.law.join(self.c, self.theta)

    def turned(self) -> Material:
        """Return the material with its axes exchanged; the same where all directions are alike."""
        if self.law.isotropic:
            return self
        values = self.law.turned([self.parameters[name] for name in self.law.names])
        c, theta = self.law.split(dict(zip(self.law.names, values, strict=True)))
        return Material(self.law, tuple(c), tuple(theta))

    def membrane(self, l1: ArrayLike, l2: ArrayLike) -> Membrane:
        """Return energy, stresses and tangent of the sheet stretched by ``l1`` and ``l2`` in its plane.

        The thickness stretch is condensed out at zero normal stress.
        """
        sheet = Sheet.of(l1, l2)
        with np.errstate(all="ignore"):
            parts = [term.membrane(sheet) for term in self.law.terms(sheet, self.theta)]
            whole = {
                field.name: _combine(self.c, [getattr(part, field.name) for part in parts], sheet.l1.shape)
                for field in fields(Membrane)
            }
        return Membrane(**whole)

    def uniaxial(self, stretch: ArrayLike) -> Uniaxial:
        """Return energy, nominal stress and its slope in uniaxial tension, lateral stress zero."""
        lam = np.asarray(stretch, dtype=np.result_type(np.asarray(stretch), np.float64))
        nu = self.law.contraction(self.theta)
        lateral = lam**-nu
        found = self.membrane(lam, lateral)
        with np.errstate(all="ignore"):
            slope = found.A11 - found.A12 * nu * lateral / lam
        return Uniaxial(found.W, found.P1, slope)

    def thickness_stretch(self, l1: ArrayLike, l2: ArrayLike) -> Array:
        """Return the thickness stretch that goes with in-plane stretches ``l1`` and ``l2``."""
        nu = self.law.contraction(self.theta)
        area = np.asarray(l1, dtype=float) * np.asarray(l2, dtype=float)
        return np.asarray(area ** (-nu / (1.0 - nu)))


def _combine(c: Sequence[float], parts: Sequence[Array], shape: tuple[int, ...]) -> Array:
    total = np.zeros(shape, dtype=np.result_type(*parts, np.float64))
    for constant, part in zip(c, parts, strict=True):
        # A constant of exactly zero takes its term out of the law, limit and all.
        if constant != 0.0:
            total = total + constant * part
    return total
