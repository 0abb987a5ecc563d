"""Geometric multigrid for the net's tangent: 3x3 blocks on an n by m grid, nine-point Galerkin coarse operators.

The unknown of a node is its displacement in the node's allowed subspace, given by a projector Q (free: identity; on
the mold: tangent plane; on a sharp edge: a line; held: zero). All operators are kept sandwiched between projectors,
so that contact needs neither rotation nor renumbering; what a sweep finds lies in the subspaces, whatever it begins
with. All is in single precision: it only serves as a preconditioner.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints, Reals, Singles
from hyperfab.numerics.bands import BAND, PIECE, follow, in_bands, next_band, tell
from hyperfab.numerics.kernels import inlined, kernel
from hyperfab.numerics.threads import in_rows

from .galerkin import OX, OY, halve, invert, sandwich_all, times

SMALLEST = 4  # grids of at most this many nodes a side are not coarsened further


@dataclass
class Level:
    """Operator of one grid: projectors, diagonal blocks, forward blocks, inverse diagonals, and the way up."""

    q: Array  # (n, m, 6)
    diag: Singles  # (n, m, 6)
    off: Singles  # (n, m, 2 or 4, 9)
    inverse: Singles  # (n, m, 6)
    kept: tuple[Ints, Ints]  # rows and columns that the coarser grid keeps
    vectors: Singles  # (3, n, m, 3) right side and solution, but of the finest grid, and residual
    halved: tuple[Singles, Singles]  # blocks with every second row left out, (m, n/2, 6) and (m, n/2, 4, 9)


def coarse_size(n: int) -> int:
    """Nodes of the next coarser grid: every second one and the last.

    >>> [coarse_size(n) for n in (9, 10, 4, 3)]
    [5, 6, 4, 3]
    """
    return n if n <= SMALLEST else n // 2 + 1


def kept(n: int) -> Ints:
    """Return which nodes of a line the coarser one keeps; one left out lies between two of them.

    >>> kept(9).tolist(), kept(6).tolist()
    ([0, 2, 4, 6, 8], [0, 2, 4, 5])
    """
    nc = coarse_size(n)
    return np.arange(n) if nc == n else np.minimum(2 * np.arange(nc), n - 1)


@inlined
def _add(a: Reals, u: Reals, s: Reals) -> None:
    s[0] -= a[0] * u[0] + a[1] * u[1] + a[2] * u[2]
    s[1] -= a[3] * u[0] + a[4] * u[1] + a[5] * u[2]
    s[2] -= a[6] * u[0] + a[7] * u[1] + a[8] * u[2]


@inlined
def _add_t(a: Reals, u: Reals, s: Reals) -> None:
    s[0] -= a[0] * u[0] + a[3] * u[1] + a[6] * u[2]
    s[1] -= a[1] * u[0] + a[4] * u[1] + a[7] * u[2]
    s[2] -= a[2] * u[0] + a[5] * u[1] + a[8] * u[2]


@inlined
def ahead(off: Reals, u: Reals, i: int, j: int, s: Reals) -> None:
    """s -= sum over the neighbours of (i, j) that come after it of their block times u."""
    n, m = u.shape[0], u.shape[1]
    if i + 1 < n:
        _add(off[i, j, 0], u[i + 1, j], s)
    if j + 1 < m:
        _add(off[i, j, 1], u[i, j + 1], s)
    if off.shape[2] == 4 and i + 1 < n:
        if j + 1 < m:
            _add(off[i, j, 2], u[i + 1, j + 1], s)
        if j > 0:
            _add(off[i, j, 3], u[i + 1, j - 1], s)


@inlined
def behind(off: Reals, u: Reals, i: int, j: int, s: Reals) -> None:
    """s -= sum over the neighbours of (i, j) that come before it of their block times u."""
    m = u.shape[1]
    if i > 0:
        _add_t(off[i - 1, j, 0], u[i - 1, j], s)
    if j > 0:
        _add_t(off[i, j - 1, 1], u[i, j - 1], s)
    if off.shape[2] == 4 and i > 0:
        if j > 0:
            _add_t(off[i - 1, j - 1, 2], u[i - 1, j - 1], s)
        if j + 1 < m:
            _add_t(off[i - 1, j + 1, 3], u[i - 1, j + 1], s)


@inlined
def _solve(d: Singles, s: Singles, u: Singles) -> None:
    u[0], u[1], u[2] = times(d, s[0], s[1], s[2])


@kernel
def sweep_from_zero(inverse: Singles, off: Singles, b: Singles, u: Singles, done: Ints) -> None:
    """One Gauss-Seidel sweep over the nodes in order from u = 0, whatever u holds; for ``in_bands``."""
    s, n, m = np.empty(3, np.float32), u.shape[0], u.shape[1]
    first = next_band(done)
    while first < n:
        for start in range(0, m + BAND, PIECE):
            follow(done, first, start + PIECE, m)
            for i in range(first, min(first + BAND, n)):
                for j in range(max(start - i + first, 0), min(start + PIECE - i + first, m)):
                    s[0], s[1], s[2] = b[i, j, 0], b[i, j, 1], b[i, j, 2]
                    behind(off, u, i, j, s)
                    _solve(inverse[i, j], s, u[i, j])
            tell(done, first, start + PIECE)
        first = next_band(done)


@kernel
def sweep_back(inverse: Singles, off: Singles, b: Singles, u: Singles, done: Ints) -> None:
    """One Gauss-Seidel sweep over the nodes in reverse; for ``in_bands``, rows and columns counted from the last."""
    s, n, m = np.empty(3, np.float32), u.shape[0], u.shape[1]
    first = next_band(done)
    while first < n:
        for start in range(0, m + BAND, PIECE):
            follow(done, first, start + PIECE, m)
            for row in range(first, min(first + BAND, n)):
                for column in range(max(start - row + first, 0), min(start + PIECE - row + first, m)):
                    i, j = n - 1 - row, m - 1 - column
                    s[0], s[1], s[2] = b[i, j, 0], b[i, j, 1], b[i, j, 2]
                    behind(off, u, i, j, s)
                    ahead(off, u, i, j, s)
                    _solve(inverse[i, j], s, u[i, j])
            tell(done, first, start + PIECE)
        first = next_band(done)


@kernel
def left(off: Singles, u: Singles, r: Singles, first: int, last: int) -> None:
    """r = b - A u after a forward sweep from zero: each node's own equation held until the nodes after it moved.

    Of rows ``first:last``.
    """
    s = np.empty(3, np.float32)
    for i in range(first, last):
        for j in range(u.shape[1]):
            s[0], s[1], s[2] = 0.0, 0.0, 0.0
            ahead(off, u, i, j, s)
            r[i, j, 0], r[i, j, 1], r[i, j, 2] = s[0], s[1], s[2]


@kernel
def restrict(r: Singles, rows: Ints, columns: Ints, out: Singles, first: int, last: int) -> None:
    """out = P^T r, of the coarser grid's rows ``first:last``.

    P interpolates between the finer grid's ``rows`` and ``columns`` that are kept.
    """
    m, half = r.shape[1], np.float32(0.5)
    line = np.empty((m, 3), np.float32)
    for a in range(first, last):
        i = rows[a]
        before = a > 0 and rows[a - 1] == i - 2
        after = a + 1 < len(rows) and rows[a + 1] == i + 2
        for j in range(m):
            for k in range(3):
                line[j, k] = r[i, j, k]
                if before:
                    line[j, k] += half * r[i - 1, j, k]
                if after:
                    line[j, k] += half * r[i + 1, j, k]
        for b in range(len(columns)):
            j = columns[b]
            for k in range(3):
                out[a, b, k] = line[j, k]
                if b > 0 and columns[b - 1] == j - 2:
                    out[a, b, k] += half * line[j - 1, k]
                if b + 1 < len(columns) and columns[b + 1] == j + 2:
                    out[a, b, k] += half * line[j + 1, k]


@kernel
def prolong(e: Singles, rows: Ints, columns: Ints, u: Singles, first: int, last: int) -> None:
    """u += P e, of the coarser grid's rows ``first:last`` and those left out behind them."""
    mc, half = e.shape[1], np.float32(0.5)
    line = np.empty((mc, 3), np.float32)
    for a in range(first, last):
        between = a + 1 < len(rows) and rows[a + 1] == rows[a] + 2
        for i in range(rows[a], rows[a] + 1 + between):
            for b in range(mc):
                for k in range(3):
                    line[b, k] = e[a, b, k] if i == rows[a] else half * (e[a, b, k] + e[a + 1, b, k])
            for b in range(mc):
                j = columns[b]
                for k in range(3):
                    u[i, j, k] += line[b, k]
                if b + 1 < mc and columns[b + 1] == j + 2:
                    for k in range(3):
                        u[i, j + 1, k] += half * (line[b, k] + line[b + 1, k])


class Multigrid:
    """V-cycles on a hierarchy of grids; the arrays are kept between Newton steps.

    ``directions``: forward neighbours of the finest grid's operator, 2 or 4.
    """

    def __init__(self, n: int, m: int, directions: int = 2) -> None:
        self.levels: list[Level] = []
        while True:
            half = coarse_size(n)
            self.levels.append(
                Level(
                    np.empty((n, m, 6)),
                    np.zeros((n, m, 6), np.float32),
                    np.zeros((n, m, directions, 9), np.float32),
                    np.zeros((n, m, 6), np.float32),
                    (kept(n), kept(m)),
                    np.zeros((3, n, m, 3), np.float32),
                    (np.zeros((m, half, 6), np.float32), np.zeros((m, half, 4, 9), np.float32)),
                )
            )
            directions = 4
            if max(n, m) <= SMALLEST:
                break
            n, m = coarse_size(n), coarse_size(m)
        self.direct: Array = np.zeros((0, 0))

    def build(self, diag: Array, off: Array, q: Array) -> None:
        """Set up all levels for the finest operator (diagonal and forward blocks) and its projectors."""
        self.levels[0].q = q
        _smoothed(self.levels[0], diag, off)
        for fine, coarse in zip(self.levels, self.levels[1:], strict=False):
            rows, columns = fine.kept
            fine.q.take(rows, axis=0).take(columns, axis=1, out=coarse.q, mode="clip")  # else buffered
            _in_chunks(fine.diag, fine.off, rows, *fine.halved)
            _in_chunks(*fine.halved, columns, coarse.diag, coarse.off)
            _smoothed(coarse, coarse.diag, coarse.off)
        self.direct = _dense_inverse(self.levels[-1])

    def __call__(self, r: Singles, out: Singles) -> None:
        """out = approximate inverse of the operator applied to r: one symmetric V-cycle."""
        self._cycle(0, r, out)

    def _cycle(self, k: int, b: Singles, u: Singles) -> None:
        level = self.levels[k]
        r = level.vectors[2]
        if k == len(self.levels) - 1:
            u[:] = (self.direct @ b.ravel()).reshape(u.shape)
            return
        in_bands(lambda done: sweep_from_zero(level.inverse, level.off, b, u, done), *u.shape[:2])
        in_rows(lambda first, last: left(level.off, u, r, first, last), *u.shape[:2])
        right, found = self.levels[k + 1].vectors[:2]
        in_rows(lambda first, last: restrict(r, *level.kept, right, first, last), *right.shape[:2])
        self._cycle(k + 1, right, found)
        in_rows(lambda first, last: prolong(found, *level.kept, u, first, last), *found.shape[:2])
        in_bands(lambda done: sweep_back(level.inverse, level.off, b, u, done), *u.shape[:2])


def _smoothed(level: Level, diag: Reals, off: Reals) -> None:
    """Set a level's operator, ``diag`` and ``off`` between its projectors, and invert its diagonal."""

    def work(first: int, last: int) -> None:
        sandwich_all(level.q, diag, off, level.diag, level.off, first, last)
        invert(level.diag, level.q, level.inverse, first, last)

    in_rows(work, *level.q.shape[:2])


def _in_chunks(diag: Singles, off: Singles, places: Ints, coarse_diag: Singles, coarse_off: Singles) -> None:
    """Coarsen the first direction."""

    def work(first: int, last: int) -> None:
        halve(diag, off, places, coarse_diag, coarse_off, first, last)

    in_rows(work, len(places), diag.shape[1])


def _dense_inverse(level: Level) -> Array:
    """Pseudo-inverse of the coarsest operator."""
    n, m = level.q.shape[:2]
    a = np.zeros((n, m, 3, n, m, 3))
    for i in range(n):
        for j in range(m):
            d: Any = level.diag[i, j]
            a[i, j, :, i, j, :] = [[d[0], d[1], d[2]], [d[1], d[3], d[4]], [d[2], d[4], d[5]]]
            for k in range(level.off.shape[2]):
                p, q = i + OX[k], j + OY[k]
                if p < n and 0 <= q < m:
                    block = level.off[i, j, k].reshape(3, 3)
                    a[i, j, :, p, q, :] = block
                    a[p, q, :, i, j, :] = block.T
    values, vectors = np.linalg.eigh(a.reshape(n * m * 3, -1))
    largest = values[-1]
    inverse = np.where(values > 1e-7 * largest, 1.0 / np.where(values > 0, values, 1.0), 0.0)
    return np.asarray((vectors * inverse) @ vectors.T)
