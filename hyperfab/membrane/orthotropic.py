"""A fabric with two directions: the softer direction's law everywhere, and the stiffer one's excess along its threads.

With U(stretch) the energy in uniaxial tension, the sheet has the energy

    W(C) = W_soft(C) + U_stiff(s) - U_soft(s),   s = max(1, stretch along the stiff direction).

Pulled along either direction, free to contract, it answers exactly with that direction's own law: across the pull the
threads of the other direction are shortened and carry nothing. What uniaxial tests cannot tell, shear and biaxial
stretch, follows from the softer law. With equal laws it is the isotropic sheet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.materials import Material
from hyperfab.membrane.tension_field import IsotropicSheet, Principal, Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OrthotropicSheet:
    """Laws along x (warp) and y (weft) of the undeformed sheet."""

    warp: Material
    weft: Material

    @property
    def stiff_axis(self) -> int:
        """0 where the warp is stiffer at small strain, else 1."""
        return 0 if float(self.warp.uniaxial(1.001).A) >= float(self.weft.uniaxial(1.001).A) else 1

    def __call__(self, strain: Array) -> Response:
        """Answer to the right Cauchy–Green tensors (n, 3)."""
        found = self._soft(strain)
        axis = self.stiff_axis
        energy, force, slope, along = self._excess(strain)
        stress, stiffness = found.stress.copy(), found.stiffness.copy()
        stress[:, axis] += force / along
        stiffness[:, axis] += slope / along**2 - force / along**3
        return Response(found.energy + energy, stress, stiffness, found.state)

    def principal(self, strain: Array) -> Principal:
        """Return principal stretches and the principal Cauchy stresses, those of the threads included."""
        base = self._soft.principal(strain)
        _, force, _, _ = self._excess(strain)
        if not force.any():
            return base
        stress = self(strain).stress
        root = strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2
        # Principal values of F S F' / J are those of S C / J; the area stretch is the root of det C.
        scale = 1.0 / (base.thickness * np.sqrt(np.maximum(root, 1e-12)))
        trace = stress[:, 0] * strain[:, 0] + stress[:, 1] * strain[:, 1] + 2 * stress[:, 2] * strain[:, 2]
        product = (stress[:, 0] * stress[:, 1] - stress[:, 2] ** 2) * root
        spread = np.sqrt(np.maximum(0.25 * trace**2 - product, 0.0))
        cauchy = np.column_stack([0.5 * trace + spread, 0.5 * trace - spread]) * scale[:, None]
        return Principal(base.stretch, np.where(force[:, None] == 0.0, base.cauchy, cauchy), base.thickness)

    def margin(self, strain: Array) -> Array:
        """Return the stability margin of the stretches along warp and weft, shear left aside."""
        _, force, slope, along = self._excess(strain)
        found = self._soft.margin(strain)
        taut = (strain[:, 0] > 1.0) & (strain[:, 1] > 1.0)
        axis = self.stiff_axis
        stretch = np.sqrt(strain[:, :2])
        values = self._material.membrane(stretch[:, 0], stretch[:, 1])
        m = [
            stretch[:, 0] * (np.asarray(values.P1) + stretch[:, 0] * np.asarray(values.A11)),
            stretch[:, 1] * (np.asarray(values.P2) + stretch[:, 1] * np.asarray(values.A22)),
        ]
        m[axis] = m[axis] + along * (force + along * slope)
        cross = stretch[:, 0] * stretch[:, 1] * np.asarray(values.A12)
        middle, radius = 0.5 * (m[0] + m[1]), np.hypot(0.5 * (m[0] - m[1]), cross)
        return np.where(taut, (middle - radius) / (np.abs(middle) + radius), found)

    @property
    def _material(self) -> Material:
        return self.weft if self.stiff_axis == 0 else self.warp

    @property
    def _soft(self) -> IsotropicSheet:
        return IsotropicSheet(self._material)

    def _excess(self, strain: Array) -> tuple[Array, Array, Array, Array]:
        """Return energy, force and slope of the stiff threads' excess (n,) [MPa], and the stretch along them."""
        axis = self.stiff_axis
        along = np.sqrt(strain[:, axis])
        pulled = along > 1.0
        stretch = np.where(pulled, along, 1.0)
        stiff = (self.warp if axis == 0 else self.weft).uniaxial(stretch)
        soft = self._material.uniaxial(stretch)
        parts = (stiff.W - soft.W, stiff.P - soft.P, stiff.A - soft.A)
        energy, force, slope = (np.where(pulled, np.asarray(part), 0.0) for part in parts)
        return energy, force, slope, along
