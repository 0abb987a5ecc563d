"""Stress of a thin sheet that carries no compression: the law's own, wrinkled, or slack.

Where the law would press in the second principal direction the sheet wrinkles: it carries the law's uniaxial
stress along the first direction and nothing across (relaxed energy; Pipkin, IMA J. Appl. Math. 36 (1986) 85).
Where neither principal stretch exceeds one it is slack.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.materials import Material
from hyperfab.materials.stability import margin

TAUT, WRINKLED, SLACK = 0, 1, 2


@dataclass(frozen=True)
class Response:
    """What the sheet answers to a strain, per undeformed volume, at n points.

    ``energy`` [MPa] (n,); ``stress`` (n, 3): second Piola–Kirchhoff S11, S22, S12 [MPa]; ``stiffness`` (n, 6):
    dS/dE in the order 11, 22, 33, 12, 13, 23 of (E11, E22, 2 E12); ``state`` (n,): taut, wrinkled or slack.
    """

    energy: Array
    stress: Array
    stiffness: Array
    state: NDArray[np.int8]


class SheetLaw(Protocol):
    """A sheet's constitutive law as the elements see it."""

    def __call__(self, strain: Array) -> Response:
        """Answer to the right Cauchy–Green tensors (n, 3): C11, C22, C12."""

    def principal(self, strain: Array) -> Principal:
        """Return principal stretches and stresses at the same points."""

    def margin(self, strain: Array) -> Array:
        """Return how stable the law is at the same points (n,): negative where Drucker's condition is broken."""


@dataclass(frozen=True)
class Principal:
    """Principal stretches (n, 2), larger first, Cauchy stresses (n, 2) [MPa] along them, thickness stretch (n,).

    ``nominal`` (n,) is the larger principal nominal stress [MPa]: force per undeformed section.
    """

    stretch: Array
    cauchy: Array
    thickness: Array
    nominal: Array


@dataclass(frozen=True)
class IsotropicSheet:
    """An isotropic law in plane stress; ``relaxed``: compression is given up (tension field)."""

    material: Material
    relaxed: bool = True

    def __call__(self, strain: Array) -> Response:
        """Answer to the right Cauchy–Green tensors (n, 3)."""
        c1, c2, cos2, sin2 = principal_directions(strain)
        l1, l2 = np.sqrt(c1), np.sqrt(c2)
        values = self.material.membrane(l1, l2)
        energy, p1, p2 = np.array(values.W), np.array(values.P1), np.array(values.P2)
        a11, a12, a22 = np.array(values.A11), np.array(values.A12), np.array(values.A22)
        state = self._state(l1, p2)
        wrinkled, slack = state == WRINKLED, state == SLACK
        if wrinkled.any():
            single = self.material.uniaxial(l1[wrinkled])
            energy[wrinkled], p1[wrinkled], a11[wrinkled] = single.W, single.P, single.A
        if slack.any():
            energy[slack] = p1[slack] = a11[slack] = 0.0
        loose = wrinkled | slack
        p2[loose] = a12[loose] = a22[loose] = 0.0
        s1, s2 = p1 / l1, p2 / l2
        d11, d22, d12 = a11 / c1 - p1 / (l1 * c1), a22 / c2 - p2 / (l2 * c2), a12 / (l1 * l2)
        # Equal stretches: the difference quotient becomes a derivative.
        near = (c1 - c2) < 1e-5 * c1
        shear = np.where(near & ~loose, 0.25 * (d11 + d22) - 0.5 * d12, (s1 - s2) / np.where(near, 1.0, c1 - c2))
        return Response(energy, *rotated(s1, s2, d11, d22, d12, shear, cos2, sin2), state)

    def principal(self, strain: Array) -> Principal:
        """Return principal stretches and Cauchy stresses; none across wrinkles, where the width is the natural one."""
        c1, c2, _, _ = principal_directions(strain)
        l1, l2 = np.sqrt(c1), np.sqrt(c2)
        values = self.material.membrane(l1, l2)
        p1, p2 = np.array(values.P1), np.array(values.P2)
        l3 = np.array(self.material.thickness_stretch(l1, l2))
        state = self._state(l1, p2)
        wrinkled, slack = state == WRINKLED, state == SLACK
        cauchy = np.column_stack([p1 / (l2 * l3), p2 / (l1 * l3)])
        if wrinkled.any():
            along = l1[wrinkled]
            width = along ** -float(self.material.law.contraction(self.material.theta))
            p1[wrinkled] = self.material.uniaxial(along).P
            p2[wrinkled] = 0.0
            cauchy[wrinkled, 0] = p1[wrinkled] / width**2
            cauchy[wrinkled, 1] = 0.0
            l3[wrinkled] = width
        cauchy[slack] = p1[slack] = p2[slack] = 0.0
        l3[slack] = 1.0
        return Principal(np.column_stack([l1, l2]), cauchy, l3, np.maximum(p1, p2))

    def margin(self, strain: Array) -> Array:
        """Return the stability margin; wrinkled and slack points are judged at their natural width."""
        c1, c2, _, _ = principal_directions(strain)
        l1, l2 = np.sqrt(c1), np.sqrt(c2)
        state = self._state(l1, np.asarray(self.material.membrane(l1, l2).P2))
        nu = float(self.material.law.contraction(self.material.theta))
        natural = np.where(state == WRINKLED, l1**-nu, np.where(state == SLACK, 1.0, l2))
        return margin(self.material, np.where(state == SLACK, 1.0, l1), natural)

    def _state(self, l1: Array, p2: Array) -> NDArray[np.int8]:
        if not self.relaxed:
            return np.zeros(len(l1), np.int8)
        return np.where(l1 <= 1.0, SLACK, np.where(p2 < 0.0, WRINKLED, TAUT)).astype(np.int8)


def principal_directions(strain: Array) -> tuple[Array, Array, Array, Array]:
    """Return the principal values c1 >= c2 of C (n, 3) and cos 2t, sin 2t of the first direction's angle t to x."""
    mean, half = 0.5 * (strain[:, 0] + strain[:, 1]), 0.5 * (strain[:, 0] - strain[:, 1])
    radius = np.hypot(half, strain[:, 2])
    c1 = mean + radius
    c2 = np.maximum((strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2) / c1, 1e-12)
    safe = np.where(radius > 0.0, radius, 1.0)
    cos2 = np.where(radius > 0.0, half / safe, 1.0)
    return c1, c2, cos2, np.where(radius > 0.0, strain[:, 2] / safe, 0.0)


def rotated(
    s1: Array, s2: Array, d11: Array, d22: Array, d12: Array, shear: Array, cos2: Array, sin2: Array
) -> tuple[Array, Array]:
    """Turn principal stresses and stiffness into the sheet's axes: stress (n, 3) and stiffness (n, 6)."""
    cc, ss, cs = 0.5 * (1 + cos2), 0.5 * (1 - cos2), 0.5 * sin2
    stress = np.column_stack([cc * s1 + ss * s2, ss * s1 + cc * s2, cs * (s1 - s2)])
    # Rows of T in E' = T E for E = (E11, E22, 2 E12); stiffness = T' D T.
    t1, t2, t3 = (cc, ss, cs), (ss, cc, -cs), (-2 * cs, 2 * cs, cos2)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    stiffness = [
        d11 * t1[i] * t1[j] + d22 * t2[i] * t2[j] + d12 * (t1[i] * t2[j] + t2[i] * t1[j]) + shear * t3[i] * t3[j]
        for i, j in pairs
    ]
    return stress, np.column_stack(stiffness)
