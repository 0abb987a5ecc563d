"""A fabric known by the laws of its two directions: an isotropic ground, and threads along warp and weft.

With U(stretch) the energy in uniaxial tension, the sheet has the energy

    W(C) = W_ground(C) + sum over the threads of U_thread(s) - U_ground(s),   s = max(1, stretch along the threads),

and gives up compression as a whole (``hyperfab.membrane.relaxed``). Pulled along either direction, free to contract,
it answers exactly with that direction's own law: across the pull the threads of the other are shortened and idle.

Where a law of two directions is fitted to all tests together (fabric-fibres), ground and threads are the law's own.
Where two isotropic laws come from uniaxial tests along warp and weft, which tell nothing of shear and biaxial stretch,
the ground is a mixture of both, W_ground = s W_warp + (1 - s) W_weft with s the weft's share of the sum of Young's
moduli: as stiff at rest as the harmonic mean of both, nearer to the softer one. It moves evenly with every constant,
also where warp and weft cross, and with equal laws it is the isotropic sheet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.materials import Material
from hyperfab.materials.orthotropic.energy import Answer
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.tension_field import IsotropicSheet, SheetLaw

#: Laws with the share of each.
Mixture = tuple[tuple[float, Material], ...]
_SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])


@dataclass(frozen=True)
class ThreadedLaw:
    """A ``ground``, and what the threads along warp (x) and weft (y) carry beyond it in uniaxial tension."""

    ground: Mixture
    threads: tuple[Mixture, Mixture]

    def answer(self, strain: Array) -> Answer:
        """Answer to the right Cauchy-Green tensors (n, 3), compression included."""
        energy, stress, stiffness = (
            np.zeros(len(strain)),
            np.zeros((len(strain), 3)),
            np.zeros((len(strain), 3, 3)),
        )
        for share, material in self.ground:
            found = IsotropicSheet(material, relaxed=False)(strain)
            energy += share * found.energy
            stress += share * found.stress
            stiffness += share * found.stiffness[:, _SYMMETRIC]
        for axis, mixture in enumerate(self.threads):
            along = np.sqrt(strain[:, axis])
            pulled = np.flatnonzero(along > 1.0)
            s = along[pulled]
            for share, material in mixture:
                one = material.uniaxial(s)
                energy[pulled] += share * one.W
                stress[pulled, axis] += share * np.asarray(one.P) / s
                stiffness[pulled, axis, axis] += share * (np.asarray(one.A) / s**2 - np.asarray(one.P) / s**3)
        return Answer(energy, stress, stiffness)

    def thickness_stretch(self, strain: Array) -> Array:
        """Return the ground's thickness stretch (n,)."""
        root = np.sqrt(np.maximum(strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2, 1e-300))
        # Only the product of both stretches counts.
        parts = [share * np.asarray(one.thickness_stretch(root, np.ones_like(root))) for share, one in self.ground]
        return np.asarray(np.sum(parts, axis=0))


def fibre_sheet(ground: Material, warp: Material, weft: Material) -> RelaxedSheet:
    """Return the sheet of a law of two directions whose ``ground`` is known: the laws seen along warp and weft."""
    return RelaxedSheet(ThreadedLaw(((1.0, ground),), (((1.0, warp), (-1.0, ground)), ((1.0, weft), (-1.0, ground)))))


def orthotropic_sheet(warp: Material, weft: Material) -> SheetLaw:
    """Return the sheet of isotropic laws from uniaxial tests along x (``warp``) and y (``weft``)."""
    if warp == weft:
        return IsotropicSheet(warp)
    stiff, other = (float(one.uniaxial(1.0 + 1e-4).A) for one in (warp, weft))
    share = other / (stiff + other)
    return RelaxedSheet(
        ThreadedLaw(
            _mixed((share, warp), (1.0 - share, weft)),
            (_mixed((1.0 - share, warp), (share - 1.0, weft)), _mixed((share, weft), (-share, warp))),
        )
    )


def _mixed(*parts: tuple[float, Material]) -> Mixture:
    """Return a mixture; of laws that differ in linear constants alone it is one law, and asked once."""
    first = parts[0][1]
    if any(one.law is not first.law or one.theta != first.theta for _, one in parts):
        return parts
    constants = zip(*(one.c for _, one in parts), strict=True)
    return (
        (
            1.0,
            replace(
                first, c=tuple(sum(share * c for (share, _), c in zip(parts, each, strict=True)) for each in constants)
            ),
        ),
    )
