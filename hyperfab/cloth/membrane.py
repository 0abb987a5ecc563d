"""The sheet as a membrane on the grid of the net: bilinear cells that obey one law in both directions.

Each cell has the strain of its four nodes at 2 x 2 Gauss points, so that no hourglass is left, and the law answers
there in plane stress, without compression (tension field). Energy, forces and tangent are exact derivatives of each
other, the error falls with the square of the spacing, and a quarter turn or a mirror changes nothing. A side that a
sharp edge of the mold bends is laid over it as a spring is (creases.py), and counts in its cells as its chord made as
long as its way: the stretch across the edge is right, the angle between warp and weft in that row of cells about.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from hyperfab.arrays import Array, Flags

from .cells import (
    bent_stiffness,
    cell_stiffness,
    lay_forces,
    node_forces,
    side_pulls,
    straighten,
    strains,
)
from .creases import bend_stiffness
from .energy import Energy
from .linear import Tangent
from .mold import Mold
from .net import Sheet
from .round import MIDDLE, POINTS, to_grid, to_sheet

#: Gauss points handled by one call of the law: few enough that its arrays stay in the processor's cache.
AT_ONCE = 8192


class MembraneLaw(Protocol):
    """What a sheet answers to right Cauchy-Green tensors (k, 3): C11, C22, C12, compression given up.

    Called, it returns ``energy`` (k,), ``stress`` (k, 3): second Piola-Kirchhoff S11, S22, S12, and ``stiffness``
    (k, 6): dS/dE in the order 11, 22, 33, 12, 13, 23 of (E11, E22, 2 E12), all in MPa, and ``state`` (k,), 0 where
    taut.
    """

    def __call__(self, strain: Array) -> Any:
        """Energy, stress and stiffness."""
        ...

    def principal(self, strain: Array) -> Any:
        """``stretch`` (k, 2), ``cauchy`` (k, 2), ``thickness`` stretch (k,), ``nominal`` (k,); the larger first."""
        ...

    def margin(self, strain: Array) -> Array:
        """(k,) below zero where the law is unstable."""
        ...


class Membrane(Energy):
    """Energy of a sheet that obeys one law as a whole, on a mold."""

    def __init__(self, sheet: Sheet, mold: Mold) -> None:
        super().__init__(sheet, mold)
        assert sheet.membrane is not None
        self.law, self.thickness, self.directions = sheet.membrane, sheet.thickness, 4
        sharp = len(mold.creases.corners) > 0
        if sharp:  # pulls along sides decide where nodes stop on edges
            self.net = self.net._replace(tension=np.zeros((sheet.n, sheet.m, 2)))
        cells = (sheet.n - 1, sheet.m - 1, 4)
        self.gradients = sheet.gradients(POINTS) if sheet.round else None
        self.stress, self.moduli = np.zeros((*cells, 3)), np.zeros((*cells, 6))
        self.pull = np.zeros((sheet.n, sheet.m, 2, 3))
        self.scale, self.laid = np.zeros((0, 0, 0)), np.zeros((0, 0, 0), np.int64)

    def forces(self, x: Array, clear: Array, f: Array) -> tuple[float, float]:
        """Forces on the nodes at x into ``f``; (energy N mm, largest force N along warp or weft of a cell)."""
        self._lay(x, clear)
        self._scale(x)
        rows, columns = self.stress.shape[:2]
        step = max(1, AT_ONCE // (4 * columns))
        strain, sums = np.empty((step, columns, 4, 3)), []
        for i in range(0, rows, step):
            last = min(i + step, rows)
            strains(x, self.scale, self.net.rest, i, last, strain)
            met = strain[: last - i].reshape(-1, 3)
            here = None if self.gradients is None else self.gradients[i:last].reshape(-1, 5)
            if here is not None:
                to_sheet(here, met)
            with np.errstate(all="ignore"):  # beyond the limit of a law its answer is nan, and the step too long
                found = self.law(met)
            stress, moduli = self.stress[i:last], self.moduli[i:last]
            stress[:] = found.stress.reshape(stress.shape)
            moduli[:] = found.stiffness.reshape(moduli.shape)
            if here is None:
                sums.append(float(found.energy.sum()))
            else:
                sums.append(to_grid(here, found.energy, stress.reshape(-1, 3), moduli.reshape(-1, 6)))
        largest = side_pulls(x, self.scale, self.net, self.stress, self.pull)
        weigh = node_forces(x, self.net, self.pull, f)
        if len(self.springs):
            lay_forces(x, self.springs, self.ways, self.pull, f, self.push)
        return 0.25 * self.net.cell_volume * float(np.sum(sums)) + weigh, largest

    def _scale(self, x: Array) -> None:
        """Find how much longer the laid sides are than straight."""
        if not len(self.springs):
            self.scale, self.laid = np.zeros((0, 0, 0)), np.zeros((0, 0, 0), np.int64)
            return
        i, j, d = self.springs[:, 0], self.springs[:, 1], self.springs[:, 2]
        chord = np.linalg.norm(x[i + (d == 0), j + (d == 1)] - x[i, j], axis=1)
        self.scale, self.laid = np.ones((*x.shape[:2], 2)), np.zeros((*x.shape[:2], 2), np.int64)
        self.scale[i, j, d] = self.ways[:, 12] / chord
        self.laid[i, j, d] = 1 + np.arange(len(i))

    def tangent(self, x: Array, floor: float, out: Tangent) -> None:
        """Tangent at x, where ``forces`` was called last; what is slack keeps the stiffness ``floor`` N/mm."""
        out.diag[:], out.off[:] = 0.0, 0.0
        parts = (self.net, self.stress, self.moduli, floor / self.thickness, out.diag, out.off)
        cell_stiffness(x, self.scale, *parts)
        if len(self.springs):
            bent_stiffness(x, self.scale, self.laid, self.ways, *parts)
            straighten(x, self.springs, self.ways, self.net, self.pull, out.diag, out.off)
            bend_stiffness(self.net, self.springs, self.ways, floor, out.diag, out.off)


def energy_of(sheet: Sheet, mold: Mold) -> Energy:
    """The energy of a sheet on a mold: of springs, or of a membrane."""
    return Energy(sheet, mold) if sheet.membrane is None else Membrane(sheet, mold)


@dataclass(frozen=True)
class Cells:
    """What a membrane answers in the middle of its cells (n - 1, m - 1), and by the mean of these at nodes (n, m).

    Stresses by direction are nominal: the pull along the draped warp (or weft) on the undeformed section across it.
    """

    stretch: Array  # the larger principal one
    stretch_warp: Array
    stretch_weft: Array
    shear: Array  # degrees by which the angle between warp and weft is below the right one
    cauchy: Array  # MPa, the larger principal stress
    nominal: Array  # MPa, the larger principal nominal stress
    thickness: Array  # stretch
    wrinkled: Flags  # no tension in one direction, or none at all
    stress_warp: Array  # (n, m) MPa
    stress_weft: Array
    law: MembraneLaw
    strain: Array  # (k, 3) C11, C22, C12, cell by cell

    @cached_property
    def margin(self) -> Array:
        """How stable the law is, negative where it is not."""
        with np.errstate(all="ignore"):
            return self.law.margin(self.strain).reshape(self.stretch.shape)


def cells_of(sheet: Sheet, x: Array, along: Array, across: Array) -> Cells:
    """What a membrane at ``x`` (n, m, 3) mm answers; its sides along warp and weft are ``along`` and ``across`` mm."""
    law, rest = sheet.membrane, sheet.rest
    assert law is not None
    warp, weft = np.diff(x, axis=0), np.diff(x, axis=1)
    warp *= (along / np.linalg.norm(warp, axis=2))[:, :, None]
    weft *= (across / np.linalg.norm(weft, axis=2))[:, :, None]
    f1, f2 = 0.5 * (warp[:, :-1] + warp[:, 1:]) / rest[0], 0.5 * (weft[:-1] + weft[1:]) / rest[1]
    shape = f1.shape[:2]
    strain = np.stack([(f1 * f1).sum(2), (f2 * f2).sum(2), (f1 * f2).sum(2)], axis=2).reshape(-1, 3)
    if sheet.round:
        to_sheet(sheet.gradients(MIDDLE).reshape(-1, 5), strain)
    with np.errstate(all="ignore"):
        found, principal = law(strain), law.principal(strain)
    c11, c22, c12 = strain.T
    s11, s22, s12 = found.stress.T
    pull_warp, pull_weft = (s11 * c11 + s12 * c12) / np.sqrt(c11), (s22 * c22 + s12 * c12) / np.sqrt(c22)
    return Cells(
        principal.stretch[:, 0].reshape(shape),
        np.sqrt(c11).reshape(shape),
        np.sqrt(c22).reshape(shape),
        np.degrees(np.arcsin(np.clip(c12 / np.sqrt(c11 * c22), -1.0, 1.0))).reshape(shape),
        principal.cauchy[:, 0].reshape(shape),
        principal.nominal.reshape(shape),
        principal.thickness.reshape(shape),
        (found.state != 0).reshape(shape),
        _at_nodes(pull_warp.reshape(shape)),
        _at_nodes(pull_weft.reshape(shape)),
        law,
        strain,
    )


def _at_nodes(cells: Array) -> Array:
    """Mean of the cells at each node."""
    padded = np.pad(cells, 1, mode="edge")
    return np.asarray(0.25 * (padded[1:, 1:] + padded[:-1, 1:] + padded[1:, :-1] + padded[:-1, :-1]))
