"""A fabric with two directions: an isotropic ground, and threads along warp and weft that carry tension alone.

With U(stretch) the energy in uniaxial tension, the sheet has the energy

    W(C) = W_ground(C) + sum over the threads of U_thread(s) - U_ground(s),   s = max(1, stretch along the threads).

Pulled along either direction, free to contract, it answers exactly with that direction's own law: across the pull the
threads of the other direction are shortened and carry nothing.

Where a law of two directions is fitted to all tests together (fabric-fibres), ground and threads are the law's own,
and shear and biaxial stretch with them. Where two isotropic laws come from uniaxial tests along warp and weft, the
ground is the softer one and the stiffer threads carry what theirs has more; shear and biaxial stretch, which uniaxial
tests cannot tell, follow from the softer law. With equal laws it is the isotropic sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hyperfab.materials import Material
from hyperfab.membrane.tension_field import IsotropicSheet, Principal, Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Threads:
    """Threads along ``axis`` (0 warp, 1 weft): pulled alone, with the ground, they answer with ``law``."""

    axis: int
    law: Material


@dataclass(frozen=True)
class ThreadedSheet:
    """An isotropic ``ground`` with ``threads`` along x (warp), y (weft) of the undeformed sheet, or both."""

    ground: Material
    threads: tuple[Threads, ...]

    def __call__(self, strain: Array) -> Response:
        """Answer to the right Cauchy–Green tensors (n, 3)."""
        found = self._base(strain)
        energy, stress, stiffness = found.energy, found.stress.copy(), found.stiffness.copy()
        for one in self.threads:
            more, force, slope, along = self._excess(one, strain)
            energy = energy + more
            stress[:, one.axis] += force / along
            stiffness[:, one.axis] += slope / along**2 - force / along**3
        return Response(energy, stress, stiffness, found.state)

    def principal(self, strain: Array) -> Principal:
        """Return principal stretches and the principal Cauchy stresses, those of the threads included."""
        base = self._base.principal(strain)
        pulled = np.zeros(len(strain), bool)
        for one in self.threads:
            pulled |= self._excess(one, strain)[1] != 0.0
        if not pulled.any():
            return base
        stress = self(strain).stress
        root = strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2
        # Principal values of F S F' / J are those of S C / J; the area stretch is the root of det C.
        scale = 1.0 / (base.thickness * np.sqrt(np.maximum(root, 1e-12)))
        trace = stress[:, 0] * strain[:, 0] + stress[:, 1] * strain[:, 1] + 2 * stress[:, 2] * strain[:, 2]
        product = (stress[:, 0] * stress[:, 1] - stress[:, 2] ** 2) * root
        spread = np.sqrt(np.maximum(0.25 * trace**2 - product, 0.0))
        cauchy = np.column_stack([0.5 * trace + spread, 0.5 * trace - spread]) * scale[:, None]
        return Principal(base.stretch, np.where(pulled[:, None], cauchy, base.cauchy), base.thickness)

    def margin(self, strain: Array) -> Array:
        """Return the stability margin of the stretches along warp and weft, shear left aside."""
        found = self._base.margin(strain)
        taut = (strain[:, 0] > 1.0) & (strain[:, 1] > 1.0)
        stretch = np.sqrt(strain[:, :2])
        values = self.ground.membrane(stretch[:, 0], stretch[:, 1])
        m = [
            stretch[:, 0] * (np.asarray(values.P1) + stretch[:, 0] * np.asarray(values.A11)),
            stretch[:, 1] * (np.asarray(values.P2) + stretch[:, 1] * np.asarray(values.A22)),
        ]
        for one in self.threads:
            _, force, slope, along = self._excess(one, strain)
            m[one.axis] = m[one.axis] + along * (force + along * slope)
        cross = stretch[:, 0] * stretch[:, 1] * np.asarray(values.A12)
        middle, radius = 0.5 * (m[0] + m[1]), np.hypot(0.5 * (m[0] - m[1]), cross)
        return np.where(taut, (middle - radius) / (np.abs(middle) + radius), found)

    @cached_property
    def _base(self) -> IsotropicSheet:
        return IsotropicSheet(self.ground)

    def _excess(self, one: Threads, strain: Array) -> tuple[Array, Array, Array, Array]:
        """Return energy, force and slope of the threads' excess (n,) [MPa], and the stretch along them."""
        along = np.sqrt(strain[:, one.axis])
        pulled = along > 1.0
        stretch = np.where(pulled, along, 1.0)
        stiff, soft = one.law.uniaxial(stretch), self.ground.uniaxial(stretch)
        parts = (stiff.W - soft.W, stiff.P - soft.P, stiff.A - soft.A)
        energy, force, slope = (np.where(pulled, np.asarray(part), 0.0) for part in parts)
        return energy, force, slope, along


class OrthotropicSheet(ThreadedSheet):
    """Isotropic laws from uniaxial tests along x (``warp``) and y (``weft``) of the undeformed sheet."""

    def __init__(self, warp: Material, weft: Material) -> None:
        stiffer = 0 if float(warp.uniaxial(1.001).A) >= float(weft.uniaxial(1.001).A) else 1
        soft, stiff = (weft, warp) if stiffer == 0 else (warp, weft)
        super().__init__(soft, (Threads(stiffer, stiff),))

    @property
    def stiff_axis(self) -> int:
        """0 where the warp is stiffer at small strain, else 1."""
        return self.threads[0].axis
