"""Operators of the multigrid hierarchy: 3x3 blocks between projectors, and the Galerkin products of coarser grids."""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints, Singles
from hyperfab.numerics.kernels import inlined, kernel

# Offsets of the stored (forward) neighbours: next in x, next in y, and the two diagonals.
OX = np.array([1, 0, 1, 1])
OY = np.array([0, 1, 1, -1])


@inlined
def times(s: Array | Singles, a: float, b: float, c: float) -> tuple[Any, Any, Any]:
    """A symmetric matrix, by its upper triangle (6), times a vector."""
    return s[0] * a + s[1] * b + s[2] * c, s[1] * a + s[3] * b + s[4] * c, s[2] * a + s[4] * b + s[5] * c


@inlined
def _is_free(q: Array) -> Any:
    return q[0] + q[3] + q[5] == 3.0


@inlined
def _sandwich(q: Array, b: Array, r: Array, t: Array, out: Singles) -> None:
    """out (9) = Q B R with symmetric Q, R (6) and full B (3, 3); ``t`` (3, 3) is room for Q B."""
    for k in range(3):
        t[0, k], t[1, k], t[2, k] = times(q, b[0, k], b[1, k], b[2, k])
    for k in range(3):
        out[3 * k], out[3 * k + 1], out[3 * k + 2] = times(r, t[k, 0], t[k, 1], t[k, 2])


@kernel
def invert(diag: Singles, q: Array, inverse: Singles, first: int, last: int) -> None:
    """Pseudo-inverse of each diagonal block on its node's subspace, of rows ``first:last``."""
    m = q.shape[1]
    for i in range(first, last):
        for j in range(m):
            rank = q[i, j, 0] + q[i, j, 3] + q[i, j, 5]
            if rank < 0.5:
                for k in range(6):
                    inverse[i, j, k] = 0.0
                continue
            # Complete the block by its mean stiffness off the subspace, invert, project.
            d0, d1, d2 = float(diag[i, j, 0]), float(diag[i, j, 1]), float(diag[i, j, 2])
            d3, d4, d5 = float(diag[i, j, 3]), float(diag[i, j, 4]), float(diag[i, j, 5])
            s = (d0 + d3 + d5) / rank
            if s <= 0.0:
                for k in range(6):
                    inverse[i, j, k] = 0.0
                continue
            tiny = 1e-6 * s  # a node whose springs are all in one plane keeps a little stiffness across
            a0, a1, a2 = d0 + s * (1.0 - q[i, j, 0]) + tiny, d1 - s * q[i, j, 1], d2 - s * q[i, j, 2]
            a3, a4, a5 = (
                d3 + s * (1.0 - q[i, j, 3]) + tiny,
                d4 - s * q[i, j, 4],
                d5 + s * (1.0 - q[i, j, 5]) + tiny,
            )
            c0, c1, c2 = a3 * a5 - a4 * a4, a2 * a4 - a1 * a5, a1 * a4 - a2 * a3
            det = a0 * c0 + a1 * c1 + a2 * c2
            inv = 1.0 / det
            s2 = 1.0 / (s + tiny)  # what the completion contributes, to be taken off again
            inverse[i, j, 0] = c0 * inv - s2 * (1.0 - q[i, j, 0])
            inverse[i, j, 1] = c1 * inv + s2 * q[i, j, 1]
            inverse[i, j, 2] = c2 * inv + s2 * q[i, j, 2]
            inverse[i, j, 3] = (a0 * a5 - a2 * a2) * inv - s2 * (1.0 - q[i, j, 3])
            inverse[i, j, 4] = (a1 * a2 - a0 * a4) * inv + s2 * q[i, j, 4]
            inverse[i, j, 5] = (a0 * a3 - a1 * a1) * inv - s2 * (1.0 - q[i, j, 5])


@kernel
def halve(  # noqa: C901
    diag: Singles, off: Singles, places: Ints, cd: Singles, co: Singles, first: int, last: int
) -> None:
    """P^T A P for the coarser rows ``first:last``, which are the finer rows ``places``, those between left out.

    P interpolates a row left out between its two neighbours, along the first direction alone. The operator (not yet
    sandwiched) comes out transposed, nodes (m, coarse n), so that a second call coarsens the other direction.
    """
    m, more, sheared = diag.shape[1], len(places), off.shape[2] == 4
    for i in range(first, last):
        b = places[i]
        between = i + 1 < more and places[i + 1] == b + 2
        for j in range(m):
            d, o = cd[j, i], co[j, i]
            for k in range(6):
                d[k] = diag[b, j, k]
            for k in range(9):
                o[0, k] = off[b, j, 1, k]
        for side in range(2):  # the row left out before, and the one behind
            if (side == 0 and (i == 0 or places[i - 1] != b - 2)) or (side == 1 and not between):
                continue
            row, low = (b - 1, b - 1) if side == 0 else (b + 1, b)
            for j in range(m):
                d, o, across, along = cd[j, i], co[j, i], diag[row, j], off[low, j, 0]
                for k in range(6):
                    d[k] += 0.25 * across[k]
                d[0] += along[0]
                d[1] += 0.5 * (along[1] + along[3])
                d[2] += 0.5 * (along[2] + along[6])
                d[3] += along[4]
                d[4] += 0.5 * (along[5] + along[7])
                d[5] += along[8]
                for k in range(9):
                    o[0, k] += 0.25 * off[row, j, 1, k]
                if sheared and j + 1 < m:
                    for r in range(3):
                        for c in range(3):
                            k = 3 * r + c
                            o[0, k] += 0.5 * (off[low, j, 2, k] + off[low, j + 1, 3, 3 * c + r])
        if i + 1 == more:
            continue
        share = 0.5 if between else 1.0
        for j in range(m):
            o = co[j, i]
            for k in range(9):
                o[1, k] = share * off[b, j, 0, k]
                o[2, k] = share * off[b, j, 2, k] if sheared else 0.0
            if j > 0:
                for r in range(3):
                    for c in range(3):
                        co[j - 1, i + 1, 3, 3 * c + r] = share * off[b, j, 3, 3 * r + c] if sheared else 0.0
            if not between:
                continue
            s, e = diag[b + 1, j], off[b + 1, j]
            o[1, 0] += 0.25 * s[0]
            o[1, 1] += 0.25 * s[1]
            o[1, 2] += 0.25 * s[2]
            o[1, 3] += 0.25 * s[1]
            o[1, 4] += 0.25 * s[3]
            o[1, 5] += 0.25 * s[4]
            o[1, 6] += 0.25 * s[2]
            o[1, 7] += 0.25 * s[4]
            o[1, 8] += 0.25 * s[5]
            for k in range(9):
                o[1, k] += 0.5 * e[0, k]
                o[2, k] += 0.25 * e[1, k]
                if sheared:
                    o[2, k] += 0.5 * e[2, k]
            if j > 0:
                back = co[j - 1, i + 1, 3]
                for r in range(3):
                    for c in range(3):
                        k = 3 * r + c
                        back[k] += 0.25 * off[b + 1, j - 1, 1, k]
                        if sheared:
                            back[k] += 0.5 * e[3, 3 * c + r]


@kernel
def sandwich_all(q: Array, diag: Array, off: Array, to_diag: Singles, to_off: Singles, first: int, last: int) -> None:
    """Put the projectors of the nodes around the blocks of rows ``first:last`` of an operator, in single precision."""
    n, m = q.shape[0], q.shape[1]
    b, t = np.empty((3, 3)), np.empty((3, 3))
    o = np.empty(9, np.float32)
    for i in range(first, last):
        for j in range(m):
            free, to = _is_free(q[i, j]), to_diag[i, j]
            for k in range(6):
                to[k] = o[k] = diag[i, j, k]
            if not free:
                b[0, 0], b[0, 1], b[0, 2], b[1, 1], b[1, 2], b[2, 2] = o[0], o[1], o[2], o[3], o[4], o[5]
                b[1, 0], b[2, 0], b[2, 1] = b[0, 1], b[0, 2], b[1, 2]
                _sandwich(q[i, j], b, q[i, j], t, o)
                to[0], to[1], to[2], to[3], to[4], to[5] = o[0], o[1], o[2], o[4], o[5], o[8]
            for d in range(off.shape[2]):
                ni, nj = i + OX[d], j + OY[d]
                if ni >= n or nj < 0 or nj >= m:
                    continue
                block = to_off[i, j, d]
                for k in range(9):
                    block[k] = off[i, j, d, k]
                if not (free and _is_free(q[ni, nj])):
                    for k in range(9):
                        b[k // 3, k % 3] = block[k]
                    _sandwich(q[i, j], b, q[ni, nj], t, block)
