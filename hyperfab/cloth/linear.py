"""Conjugate gradients for the net's tangent, matrix-free in double precision, preconditioned by multigrid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Reals, Singles
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.threads import in_rows

from .galerkin import times
from .multigrid import Multigrid, ahead, behind


@dataclass
class Tangent:
    """Blocks of the nodes and of each with its forward neighbours (as in galerkin.py), and the projectors."""

    diag: Array  # (n, m, 6)
    off: Array  # (n, m, 2 or 4, 9)
    q: Array  # (n, m, 6)

    @classmethod
    def empty(cls, n: int, m: int, directions: int, q: Array | None = None) -> Tangent:
        """Room for an n by m grid; ``directions``: 2 forward neighbours, or 4 with those across cells.

        ``q`` are projectors kept elsewhere.
        """
        return cls(np.zeros((n, m, 6)), np.zeros((n, m, directions, 9)), np.zeros((n, m, 6)) if q is None else q)


@kernel
def _apply(diag: Array, off: Array, q: Array, u: Array, out: Array, rows: Array, first: int, last: int) -> None:
    s = np.empty(3)
    for i in range(first, last):
        total = 0.0
        for j in range(u.shape[1]):
            e, v, p = diag[i, j], u[i, j], q[i, j]
            a, b, c = times(e, v[0], v[1], v[2])
            s[0], s[1], s[2] = -a, -b, -c
            ahead(off, u, i, j, s)
            behind(off, u, i, j, s)
            o = out[i, j]
            a, b, c = times(p, s[0], s[1], s[2])
            o[0], o[1], o[2] = -a, -b, -c
            total += v[0] * o[0] + v[1] * o[1] + v[2] * o[2]
        rows[i] = total


def apply(k: Tangent, u: Array, out: Array) -> float:
    """out = Q K u for u = Q u; returns u . out."""
    rows = np.empty(len(u))
    in_rows(lambda first, last: _apply(k.diag, k.off, k.q, u, out, rows, first, last), *u.shape[:2])
    return float(rows.sum())


@kernel
def _products(a: Array, b: Reals, rows: Array, first: int, last: int) -> None:
    """Sums of products of rows ``first:last``."""
    for i in range(first, last):
        row = 0.0
        for j in range(a.shape[1]):
            row += a[i, j, 0] * b[i, j, 0] + a[i, j, 1] * b[i, j, 1] + a[i, j, 2] * b[i, j, 2]
        rows[i] = row


def dot(a: Array, b: Reals) -> float:
    """Sum of products, row by row."""
    rows = np.empty(len(a))
    in_rows(lambda first, last: _products(a, b, rows, first, last), *a.shape[:2])
    return float(rows.sum())


@kernel
def _advance(alpha: float, p: Array, ap: Array, d: Array, r: Array, single: Singles, first: int, last: int) -> None:
    """d += alpha p and r -= alpha ap, of rows ``first:last``; ``single`` is r in single precision."""
    for i in range(first, last):
        for j in range(p.shape[1]):
            for k in range(3):
                d[i, j, k] += alpha * p[i, j, k]
                r[i, j, k] -= alpha * ap[i, j, k]
                single[i, j, k] = r[i, j, k]


@kernel
def _turn(z: Singles, beta: float, p: Array, first: int, last: int) -> None:
    """p = z + beta p, of rows ``first:last``."""
    for i in range(first, last):
        for j in range(p.shape[1]):
            for k in range(3):
                p[i, j, k] = z[i, j, k] + beta * p[i, j, k]


@kernel
def project(q: Array, v: Array, first: int, last: int) -> None:
    """v = Q v at every node of rows ``first:last``."""
    for i in range(first, last):
        for j in range(v.shape[1]):
            a, b, c, p = v[i, j, 0], v[i, j, 1], v[i, j, 2], q[i, j]
            v[i, j, 0], v[i, j, 1], v[i, j, 2] = times(p, a, b, c)


class Solver:
    """Preconditioned conjugate gradients with work arrays kept between calls."""

    def __init__(self, n: int, m: int, directions: int) -> None:
        self.grids = Multigrid(n, m, directions)
        self.work = np.zeros((3, n, m, 3))
        self.singles = np.zeros((2, n, m, 3), np.float32)
        self.iterations = 0

    def __call__(self, k: Tangent, right: Array, d: Array, tolerance: float, largest: int = 80) -> bool:
        """Solve K d = right until the preconditioned residual falls by ``tolerance``.

        False: a direction of negative curvature was met, and ``d`` is what was found before it (or the
        preconditioned force if it was the first).
        """
        self.grids.build(k.diag, k.off, k.q)
        found = self._solve(k, right, d, tolerance, largest)
        # The preconditioner's single precision leaves d a little off the subspaces.
        in_rows(lambda first, last: project(k.q, d, first, last), *d.shape[:2])
        return found

    def _solve(self, k: Tangent, right: Array, d: Array, tolerance: float, largest: int) -> bool:
        (r, p, ap), (single, z) = self.work, self.singles
        size = d.shape[:2]

        def begin(first: int, last: int) -> None:
            r[first:last], p[first:last], d[first:last] = right[first:last], 0.0, 0.0
            single[first:last] = right[first:last]

        in_rows(begin, *size)
        self.grids(single, z)
        in_rows(lambda first, last: _turn(z, 0.0, p, first, last), *size)
        rz = first = dot(r, z)
        for step in range(largest):
            self.iterations = step
            if rz <= tolerance**2 * first:
                return True
            curvature = apply(k, p, ap)
            if curvature <= 0.0:
                if step == 0:
                    d[:] = z
                return False
            alpha = rz / curvature
            in_rows(lambda first, last: _advance(alpha, p, ap, d, r, single, first, last), *size)  # noqa: B023
            self.grids(single, z)
            new = dot(r, z)
            beta = new / rz
            in_rows(lambda first, last: _turn(z, beta, p, first, last), *size)  # noqa: B023
            rz = new
        return True
