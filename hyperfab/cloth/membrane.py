"""The sheet as a membrane on the grid of the net: bilinear cells that obey one law in both directions.

Each cell has the strain of its four nodes at 2 x 2 Gauss points, so that no hourglass is left, and the law answers
there in plane stress, without compression (tension field). Energy, forces and tangent are exact derivatives of each
other, the error falls with the square of the spacing, and a quarter turn or a mirror changes nothing. Cells are
straight between their nodes: over a sharp edge of the mold nodes stop on it, and what the cells' sides cut off is told
as penetration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from hyperfab.numerics.kernels import kernel

from .energy import Energy
from .law import Floats
from .linear import Tangent
from .mold import Mold
from .net import NO_FORCE, Arrays, Sheet
from .state import State

#: Gauss points handled by one call of the law: few enough that its arrays stay in the processor's cache.
POINTS = 8192
#: Place of the nearer Gauss point along a side of length 1.
NEAR = 0.5 - 0.5 / 3.0**0.5


class MembraneLaw(Protocol):
    """What a sheet answers to right Cauchy-Green tensors (k, 3): C11, C22, C12, compression given up.

    Called, it returns ``energy`` (k,), ``stress`` (k, 3): second Piola-Kirchhoff S11, S22, S12, and ``stiffness``
    (k, 6): dS/dE in the order 11, 22, 33, 12, 13, 23 of (E11, E22, 2 E12), all in MPa, and ``state`` (k,), 0 where
    taut.
    """

    def __call__(self, strain: Floats) -> Any:
        """Energy, stress and stiffness."""
        ...

    def principal(self, strain: Floats) -> Any:
        """``stretch`` (k, 2), larger first, ``cauchy`` (k, 2) stresses, and ``thickness`` stretch (k,)."""
        ...

    def margin(self, strain: Floats) -> Floats:
        """(k,) below zero where the law is unstable."""
        ...


@kernel
def strains(x: Floats, rest: Floats, first: int, last: int, out: Floats) -> None:
    """C11, C22, C12 at the four Gauss points of the cells of rows ``first:last`` into ``out`` (k, m - 1, 4, 3)."""
    f1, f2 = np.empty((2, 3)), np.empty((2, 3))
    for i in range(first, last):
        for j in range(x.shape[1] - 1):
            for side in range(2):
                b = NEAR if side == 0 else 1.0 - NEAR
                for r in range(3):
                    f1[side, r] = (
                        (1.0 - b) * (x[i + 1, j, r] - x[i, j, r]) + b * (x[i + 1, j + 1, r] - x[i, j + 1, r])
                    ) / rest[0]
                    f2[side, r] = (
                        (1.0 - b) * (x[i, j + 1, r] - x[i, j, r]) + b * (x[i + 1, j + 1, r] - x[i + 1, j, r])
                    ) / rest[1]
            for p in range(4):
                c11, c22, c12 = 0.0, 0.0, 0.0
                for r in range(3):
                    a, b = f1[p // 2, r], f2[p % 2, r]
                    c11 += a * a
                    c22 += b * b
                    c12 += a * b
                c = out[i - first, j, p]
                c[0], c[1], c[2] = c11, c22, c12


@kernel
def cell_forces(x: Floats, net: Arrays, stress: Floats, f: Floats) -> tuple[float, float]:
    """Weight, and the forces of all cells under ``stress`` (n - 1, m - 1, 4, 3), into ``f``.

    Returns the energy of the weight in N mm, and the largest force in N that a cell passes on along warp or weft.
    """
    n, m = x.shape[0], x.shape[1]
    weigh, largest = 0.0, 0.0
    for i in range(n):
        for j in range(m):
            f[i, j, 0], f[i, j, 1], f[i, j, 2] = 0.0, 0.0, -net.weight[i, j]
            weigh += net.weight[i, j] * x[i, j, 2]
    w = 0.25 * net.cell_volume
    for i in range(n - 1):
        for j in range(m - 1):
            for p in range(4):
                t = NEAR if p // 2 == 0 else 1.0 - NEAR
                s = NEAR if p % 2 == 0 else 1.0 - NEAR
                s11, s22, s12 = stress[i, j, p, 0], stress[i, j, p, 1], stress[i, j, p, 2]
                along, across = 0.0, 0.0
                for r in range(3):
                    low, high = x[i + 1, j, r] - x[i, j, r], x[i + 1, j + 1, r] - x[i, j + 1, r]
                    left, right = x[i, j + 1, r] - x[i, j, r], x[i + 1, j + 1, r] - x[i + 1, j, r]
                    f1 = ((1.0 - t) * low + t * high) / net.rest[0]
                    f2 = ((1.0 - s) * left + s * right) / net.rest[1]
                    p1, p2 = f1 * s11 + f2 * s12, f1 * s12 + f2 * s22
                    along += p1 * p1
                    across += p2 * p2
                    p1 *= w / net.rest[0]
                    p2 *= w / net.rest[1]
                    f[i, j, r] += (1.0 - t) * p1 + (1.0 - s) * p2
                    f[i + 1, j, r] += -(1.0 - t) * p1 + s * p2
                    f[i + 1, j + 1, r] -= t * p1 + s * p2
                    f[i, j + 1, r] += t * p1 - (1.0 - s) * p2
                largest = max(largest, along / net.rest[0] ** 2, across / net.rest[1] ** 2)
    return weigh, net.cell_volume * np.sqrt(largest)


@kernel
def cell_stiffness(
    x: Floats, net: Arrays, stress: Floats, moduli: Floats, least: float, diag: Floats, off: Floats
) -> None:
    """Add the tangent of all cells; where the smaller principal stress is below ``least`` MPa it counts as that."""
    n, m = x.shape[0], x.shape[1]
    w = 0.25 * net.cell_volume
    f1, f2 = np.empty(3), np.empty(3)
    a11, a22, a12 = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    g = np.empty((4, 2))  # gradients of the shape functions of (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
    for i in range(n - 1):
        for j in range(m - 1):
            for p in range(4):
                t = NEAR if p // 2 == 0 else 1.0 - NEAR
                s = NEAR if p % 2 == 0 else 1.0 - NEAR
                g[0, 0], g[1, 0], g[2, 0], g[3, 0] = -(1.0 - t), 1.0 - t, t, -t
                g[0, 1], g[1, 1], g[2, 1], g[3, 1] = -(1.0 - s), -s, s, 1.0 - s
                for r in range(3):
                    f1[r], f2[r] = 0.0, 0.0
                for a in range(4):
                    g[a, 0] /= net.rest[0]
                    g[a, 1] /= net.rest[1]
                    v = x[i + (a == 1 or a == 2), j + (a > 1)]
                    for r in range(3):
                        f1[r] += g[a, 0] * v[r]
                        f2[r] += g[a, 1] * v[r]
                d = moduli[i, j, p]
                s11, s22, s12 = stress[i, j, p, 0], stress[i, j, p, 1], stress[i, j, p, 2]
                smaller = 0.5 * (s11 + s22) - np.sqrt(0.25 * (s11 - s22) ** 2 + s12 * s12)
                lift = max(least - smaller, 0.0)
                s11 += lift
                s22 += lift
                for r in range(3):
                    for c in range(3):
                        one, two = f1[r] * f1[c], f2[r] * f2[c]
                        mixed, turned = f1[r] * f2[c], f2[r] * f1[c]
                        both = mixed + turned
                        a11[r, c] = w * (d[0] * one + d[4] * both + d[2] * two)
                        a22[r, c] = w * (d[1] * two + d[5] * both + d[2] * one)
                        a12[r, c] = w * (d[3] * mixed + d[4] * one + d[5] * two + d[2] * turned)
                    a11[r, r] += w * s11
                    a22[r, r] += w * s22
                    a12[r, r] += w * s12
                for a in range(4):
                    own = diag[i + (a == 1 or a == 2), j + (a > 1)]
                    g1, g2 = g[a, 0], g[a, 1]
                    at = 0
                    for r in range(3):
                        for c in range(r, 3):
                            own[at] += (
                                g1 * g1 * a11[r, c] + g2 * g2 * a22[r, c] + g1 * g2 * (a12[r, c] + a12[c, r])
                            )
                            at += 1
                for pair in range(6):
                    # Each pair from the node that holds its block: see the offsets in galerkin.py.
                    if pair == 0:
                        a, b, block = 0, 1, off[i, j, 0]
                    elif pair == 1:
                        a, b, block = 3, 2, off[i, j + 1, 0]
                    elif pair == 2:
                        a, b, block = 0, 3, off[i, j, 1]
                    elif pair == 3:
                        a, b, block = 1, 2, off[i + 1, j, 1]
                    elif pair == 4:
                        a, b, block = 0, 2, off[i, j, 2]
                    else:
                        a, b, block = 3, 1, off[i, j + 1, 3]
                    k11, k22 = g[a, 0] * g[b, 0], g[a, 1] * g[b, 1]
                    k12, k21 = g[a, 0] * g[b, 1], g[a, 1] * g[b, 0]
                    for r in range(3):
                        for c in range(3):
                            block[3 * r + c] += (
                                k11 * a11[r, c] + k22 * a22[r, c] + k12 * a12[r, c] + k21 * a12[c, r]
                            )


class Membrane(Energy):
    """Energy of a sheet that obeys one law as a whole, on a mold."""

    def __init__(self, sheet: Sheet, mold: Mold) -> None:
        super().__init__(sheet, mold)
        assert sheet.membrane is not None
        self.law, self.thickness, self.directions = sheet.membrane, sheet.thickness, 4
        # Who asks for a spring's force, at a sharp edge, finds none: there the cone of normals decides alone.
        self.net = self.net._replace(warp=NO_FORCE.arrays, weft=NO_FORCE.arrays)
        cells = (sheet.n - 1, sheet.m - 1, 4)
        self.stress, self.moduli = np.zeros((*cells, 3)), np.zeros((*cells, 6))

    def leave(self, now: State, trial: State, where: int | None = None) -> bool:
        """No spring is laid over an edge: there is none to leave."""
        return False

    def forces(self, x: Floats, clear: Floats, f: Floats) -> tuple[float, float]:
        """Forces on the nodes at x into ``f``; (energy N mm, largest force N along warp or weft of a cell)."""
        rows, columns = self.stress.shape[:2]
        step = max(1, POINTS // (4 * columns))
        strain, sums = np.empty((step, columns, 4, 3)), []
        for i in range(0, rows, step):
            last = min(i + step, rows)
            strains(x, self.net.rest, i, last, strain)
            with np.errstate(
                all="ignore"
            ):  # beyond the limit of a law its answer is nan, and the step too long
                found = self.law(strain[: last - i].reshape(-1, 3))
            self.stress[i:last] = found.stress.reshape(last - i, columns, 4, 3)
            self.moduli[i:last] = found.stiffness.reshape(last - i, columns, 4, 6)
            sums.append(float(found.energy.sum()))
        weigh, largest = cell_forces(x, self.net, self.stress, f)
        return 0.25 * self.net.cell_volume * float(np.sum(sums)) + weigh, largest

    def tangent(self, x: Floats, floor: float, out: Tangent) -> None:
        """Tangent at x, where ``forces`` was called last; what is slack keeps the stiffness ``floor`` N/mm."""
        out.diag[:], out.off[:] = 0.0, 0.0
        cell_stiffness(x, self.net, self.stress, self.moduli, floor / self.thickness, out.diag, out.off)


def energy_of(sheet: Sheet, mold: Mold) -> Energy:
    """The energy of a sheet on a mold: of springs, or of a membrane."""
    return Energy(sheet, mold) if sheet.membrane is None else Membrane(sheet, mold)


@dataclass(frozen=True)
class Cells:
    """What a membrane answers in the middle of its cells (n - 1, m - 1), and by the mean of these at nodes (n, m).

    Stresses by direction are nominal: the pull along the draped warp (or weft) on the undeformed section across it.
    """

    stretch: Floats  # the larger principal one
    cauchy: Floats  # MPa, the larger principal stress
    thickness: Floats  # stretch
    margin: Floats  # of the law's stability
    wrinkled: npt.NDArray[np.bool_]  # no tension in one direction, or none at all
    stress_warp: Floats  # (n, m) MPa
    stress_weft: Floats


def cells_of(sheet: Sheet, x: Floats) -> Cells:
    """What a membrane at ``x`` (n, m, 3) mm answers."""
    law, rest = sheet.membrane, sheet.arrays.rest
    assert law is not None
    f1 = 0.5 * (np.diff(x[:, :-1], axis=0) + np.diff(x[:, 1:], axis=0)) / rest[0]
    f2 = 0.5 * (np.diff(x[:-1], axis=1) + np.diff(x[1:], axis=1)) / rest[1]
    shape = f1.shape[:2]
    strain = np.stack([(f1 * f1).sum(2), (f2 * f2).sum(2), (f1 * f2).sum(2)], axis=2).reshape(-1, 3)
    with np.errstate(all="ignore"):
        found, principal, margin = law(strain), law.principal(strain), law.margin(strain)
    c11, c22, c12 = strain.T
    s11, s22, s12 = found.stress.T
    warp = (s11 * c11 + s12 * c12) / np.sqrt(c11)
    weft = (s22 * c22 + s12 * c12) / np.sqrt(c22)
    return Cells(
        principal.stretch[:, 0].reshape(shape),
        principal.cauchy[:, 0].reshape(shape),
        principal.thickness.reshape(shape),
        margin.reshape(shape),
        (found.state != 0).reshape(shape),
        _at_nodes(warp.reshape(shape)),
        _at_nodes(weft.reshape(shape)),
    )


def _at_nodes(cells: Floats) -> Floats:
    """Mean of the cells at each node."""
    padded = np.pad(cells, 1, mode="edge")
    return np.asarray(0.25 * (padded[1:, 1:] + padded[:-1, 1:] + padded[1:, :-1] + padded[:-1, :-1]))
