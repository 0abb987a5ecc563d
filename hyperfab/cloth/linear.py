"""Conjugate gradients for the net's tangent, matrix-free in double precision, preconditioned by multigrid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.numerics.kernels import inlined, kernel

from .creases import couple
from .law import Floats
from .mold import Ints
from .multigrid import Multigrid, project


@dataclass
class Tangent:
    """Blocks of the springs (warp, weft), of the cells by their diagonals, of the nodes, and the projectors."""

    warp: Floats
    weft: Floats
    one: Floats
    two: Floats
    cross: Floats
    extra: Floats
    q: Floats
    springs: Ints  # (k, 4) springs laid over edges: node, direction, crease
    coupling: Floats  # (k, 9) between their two nodes

    @classmethod
    def empty(cls, n: int, m: int, sheared: bool, q: Floats | None = None) -> Tangent:
        """Room for an n by m grid; ``q`` are projectors kept elsewhere."""
        cells = (n - 1, m - 1, 6) if sheared else (0, 0, 6)
        return cls(
            np.zeros((n - 1, m, 6)),
            np.zeros((n, m - 1, 6)),
            np.zeros(cells),
            np.zeros(cells),
            np.zeros((*cells[:2], 9)),
            np.zeros((n, m, 6)),
            np.zeros((n, m, 6)) if q is None else q,
            np.zeros((0, 4), np.int64),
            np.zeros((0, 9)),
        )

    @property
    def blocks(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """The springs' and the cells' blocks."""
        return self.warp, self.weft, self.one, self.two, self.cross


@inlined
def _difference(b: Floats, u: Floats, i: int, j: int, k: int, l: int, out: Floats) -> None:
    x, y, z = u[i, j, 0] - u[k, l, 0], u[i, j, 1] - u[k, l, 1], u[i, j, 2] - u[k, l, 2]
    fx, fy, fz = (
        b[0] * x + b[1] * y + b[2] * z,
        b[1] * x + b[3] * y + b[4] * z,
        b[2] * x + b[4] * y + b[5] * z,
    )
    out[i, j, 0] += fx
    out[i, j, 1] += fy
    out[i, j, 2] += fz
    out[k, l, 0] -= fx
    out[k, l, 1] -= fy
    out[k, l, 2] -= fz


@inlined
def _crossed(b: Floats, u: Floats, i: int, j: int, out: Floats) -> None:
    """What each diagonal of a cell feels of the other."""
    for r in range(3):
        p, q = 0.0, 0.0
        for s in range(3):
            p += b[3 * r + s] * (u[i + 1, j, s] - u[i, j + 1, s])
            q += b[3 * s + r] * (u[i + 1, j + 1, s] - u[i, j, s])
        out[i + 1, j + 1, r] += p
        out[i, j, r] -= p
        out[i + 1, j, r] += q
        out[i, j + 1, r] -= q


@kernel
def _apply(
    warp: Floats,
    weft: Floats,
    one: Floats,
    two: Floats,
    cross: Floats,
    extra: Floats,
    springs: Ints,
    coupling: Floats,
    q: Floats,
    u: Floats,
    out: Floats,
) -> float:
    n, m = u.shape[0], u.shape[1]
    sheared = one.shape[0] > 0
    for i in range(n):
        for j in range(m):
            e, v = extra[i, j], u[i, j]
            out[i, j, 0] = e[0] * v[0] + e[1] * v[1] + e[2] * v[2]
            out[i, j, 1] = e[1] * v[0] + e[3] * v[1] + e[4] * v[2]
            out[i, j, 2] = e[2] * v[0] + e[4] * v[1] + e[5] * v[2]
    couple(springs, coupling, u, out)
    total = 0.0
    for i in range(n):
        for j in range(m):
            if i + 1 < n:
                _difference(warp[i, j], u, i, j, i + 1, j, out)
            if j + 1 < m:
                _difference(weft[i, j], u, i, j, i, j + 1, out)
            if sheared and i + 1 < n and j + 1 < m:
                _difference(one[i, j], u, i, j, i + 1, j + 1, out)
                _difference(two[i, j], u, i + 1, j, i, j + 1, out)
                _crossed(cross[i, j], u, i, j, out)
        for j in range(m):
            a, b, c, p = out[i, j, 0], out[i, j, 1], out[i, j, 2], q[i, j]
            out[i, j, 0] = p[0] * a + p[1] * b + p[2] * c
            out[i, j, 1] = p[1] * a + p[3] * b + p[4] * c
            out[i, j, 2] = p[2] * a + p[4] * b + p[5] * c
            total += u[i, j, 0] * out[i, j, 0] + u[i, j, 1] * out[i, j, 1] + u[i, j, 2] * out[i, j, 2]
    return total


def apply(k: Tangent, u: Floats, out: Floats) -> float:
    """out = Q K u for u = Q u; returns u . out."""
    return float(_apply(*k.blocks, k.extra, k.springs, k.coupling, k.q, u, out))


@kernel
def dot(a: Floats, b: Floats) -> float:
    """Sum of products, row by row."""
    total = 0.0
    for i in range(a.shape[0]):
        row = 0.0
        for j in range(a.shape[1]):
            row += a[i, j, 0] * b[i, j, 0] + a[i, j, 1] * b[i, j, 1] + a[i, j, 2] * b[i, j, 2]
        total += row
    return total


@kernel
def combine(a: float, x: Floats, b: float, y: Floats) -> None:
    """y = a x + b y."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            for k in range(3):
                y[i, j, k] = a * x[i, j, k] + b * y[i, j, k]


class Solver:
    """Preconditioned conjugate gradients with work arrays kept between calls."""

    def __init__(self, n: int, m: int, sheared: bool) -> None:
        self.grids = Multigrid(n, m, sheared)
        self.work = np.zeros((4, n, m, 3))
        self.iterations = 0

    def __call__(self, k: Tangent, right: Floats, d: Floats, tolerance: float, largest: int = 80) -> bool:
        """Solve K d = right until the preconditioned residual falls by ``tolerance``.

        False: a direction of negative curvature was met, and ``d`` is what was found before it (or the
        preconditioned force if it was the first).
        """
        self.grids.build(k.blocks, k.extra, k.q, k.springs, k.coupling)
        found = self._solve(k, right, d, tolerance, largest)
        project(k.q, d)  # the preconditioner's single precision leaves d a little off the subspaces
        return found

    def _solve(self, k: Tangent, right: Floats, d: Floats, tolerance: float, largest: int) -> bool:
        r, z, p, ap = self.work
        r[:] = right
        d[:] = 0.0
        self.grids(r, z)
        p[:] = z
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
            combine(alpha, p, 1.0, d)
            combine(-alpha, ap, 1.0, r)
            self.grids(r, z)
            new = dot(r, z)
            combine(1.0, z, new / rz, p)
            rz = new
        return True
