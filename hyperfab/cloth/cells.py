"""Compiled loops over the bilinear cells of a membrane: strains, pulls on their sides, forces on nodes, tangent."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part

from .net import Arrays

#: Place of the nearer Gauss point along a side of length 1.
NEAR = 0.5 - 0.5 / 3.0**0.5
#: The four sides of a cell: start and end among (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1), each as i and j.
SIDES = np.array([[0, 0, 1, 0], [0, 1, 1, 1], [0, 0, 0, 1], [1, 0, 1, 1]])
CORNERS = np.array([[0, 1], [3, 2], [0, 3], [1, 2]])
#: The pairs of a cell's corners from the node that holds their block: both corners, its i and j, the neighbour
#: (offsets in galerkin.py).
PAIRS = np.array([[0, 1, 0, 0, 0], [3, 2, 0, 1, 0], [0, 3, 0, 0, 1], [1, 2, 1, 0, 1], [0, 2, 0, 0, 2], [3, 1, 0, 1, 3]])


@part
def _longer(scale: Array, i: int, j: int) -> tuple[float, float, float, float]:
    """How much longer than straight the four sides of a cell are, in the order of ``SIDES``."""
    if scale.shape[0] == 0:
        return 1.0, 1.0, 1.0, 1.0
    return scale[i, j, 0], scale[i, j + 1, 0], scale[i, j, 1], scale[i + 1, j, 1]


@kernel
def strains(x: Array, scale: Array, rest: Array, first: int, last: int, out: Array) -> None:
    """C11, C22, C12 at the four Gauss points of the cells of rows ``first:last`` into ``out`` (k, m - 1, 4, 3).

    ``scale`` (n, m, 2): how much longer than straight each side is; empty where none is laid over an edge.
    """
    f1, f2 = np.empty((2, 3)), np.empty((2, 3))
    for i in range(first, last):
        for j in range(x.shape[1] - 1):
            low, high, left, right = _longer(scale, i, j)
            for side in range(2):
                b = NEAR if side == 0 else 1.0 - NEAR
                for r in range(3):
                    f1[side, r] = (
                        (1.0 - b) * low * (x[i + 1, j, r] - x[i, j, r])
                        + b * high * (x[i + 1, j + 1, r] - x[i, j + 1, r])
                    ) / rest[0]
                    f2[side, r] = (
                        (1.0 - b) * left * (x[i, j + 1, r] - x[i, j, r])
                        + b * right * (x[i + 1, j + 1, r] - x[i + 1, j, r])
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
def side_pulls(x: Array, scale: Array, net: Arrays, stress: Array, pull: Array) -> float:
    """What the cells under ``stress`` (n - 1, m - 1, 4, 3) pull their sides with, into ``pull`` (n, m, 2, 3) N.

    Returns the largest force in N that a cell passes on along warp or weft.
    """
    n, m = x.shape[0], x.shape[1]
    largest = 0.0
    w = 0.25 * net.cell_volume
    for i in range(n):
        for j in range(m):
            for r in range(3):
                pull[i, j, 0, r], pull[i, j, 1, r] = 0.0, 0.0
    for i in range(n - 1):
        for j in range(m - 1):
            low, high, left, right = _longer(scale, i, j)
            for p in range(4):
                t = NEAR if p // 2 == 0 else 1.0 - NEAR
                s = NEAR if p % 2 == 0 else 1.0 - NEAR
                s11, s22, s12 = stress[i, j, p, 0], stress[i, j, p, 1], stress[i, j, p, 2]
                along, across = 0.0, 0.0
                for r in range(3):
                    f1 = (
                        (1.0 - t) * low * (x[i + 1, j, r] - x[i, j, r])
                        + t * high * (x[i + 1, j + 1, r] - x[i, j + 1, r])
                    ) / net.rest[0]
                    f2 = (
                        (1.0 - s) * left * (x[i, j + 1, r] - x[i, j, r])
                        + s * right * (x[i + 1, j + 1, r] - x[i + 1, j, r])
                    ) / net.rest[1]
                    p1, p2 = f1 * s11 + f2 * s12, f1 * s12 + f2 * s22
                    along += p1 * p1
                    across += p2 * p2
                    p1 *= w / net.rest[0]
                    p2 *= w / net.rest[1]
                    pull[i, j, 0, r] += (1.0 - t) * p1
                    pull[i, j + 1, 0, r] += t * p1
                    pull[i, j, 1, r] += (1.0 - s) * p2
                    pull[i + 1, j, 1, r] += s * p2
                largest = max(largest, along / net.rest[0] ** 2, across / net.rest[1] ** 2)
    return net.cell_volume * np.sqrt(largest)


@kernel
def node_forces(x: Array, net: Arrays, pull: Array, f: Array) -> float:
    """Weight, and the pulls of all sides as if straight, on their nodes into ``f``; the energy of the weight in N mm.

    Where ``net.tension`` has room, it becomes the pull along each side.
    """
    n, m = x.shape[0], x.shape[1]
    weigh = 0.0
    for i in range(n):
        for j in range(m):
            weigh += net.weight[i, j] * x[i, j, 2]
            for r in range(3):
                v = pull[i, j, 0, r] + pull[i, j, 1, r]
                if i > 0:
                    v -= pull[i - 1, j, 0, r]
                if j > 0:
                    v -= pull[i, j - 1, 1, r]
                f[i, j, r] = v
            f[i, j, 2] -= net.weight[i, j]
    if net.tension.shape[0] > 0:
        for i in range(n):
            for j in range(m):
                for d in range(2):
                    k, l = (i + 1, j) if d == 0 else (i, j + 1)
                    net.tension[i, j, d] = 0.0
                    if k < n and l < m:
                        size, along = 0.0, 0.0
                        for r in range(3):
                            v = x[k, l, r] - x[i, j, r]
                            size += v * v
                            along += v * pull[i, j, d, r]
                        net.tension[i, j, d] = max(along / max(np.sqrt(size), 1e-300), 0.0)
    return weigh


@kernel
def lay_forces(x: Array, springs: Ints, ways: Array, pull: Array, f: Array, push: Array) -> None:
    """Lay the listed sides over the edges: correct ``f``, and add the edges' push on the sheet to ``push`` (3).

    A laid side counts as its chord made as long as its way: what pulls along it pulls its nodes along the way.
    """
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        w, g = ways[b], pull[i, j, d]
        chord, along = 0.0, 0.0
        for r in range(3):
            v = x[k, l, r] - x[i, j, r]
            chord += v * v
            along += v * g[r]
        chord = np.sqrt(chord)
        along /= chord
        longer = w[12] / chord
        for r in range(3):
            across = g[r] - along * (x[k, l, r] - x[i, j, r]) / chord
            here = along * ((w[9] + w[10]) * w[r] + w[11] * w[6 + r]) / w[12]
            there = along * ((w[9] + w[10]) * w[3 + r] + w[11] * w[6 + r]) / w[12]
            f[i, j, r] += here + longer * across - g[r]
            f[k, l, r] -= there + longer * across - g[r]
            push[r] += here - there


@part
def _moduli(
    f1: Array,
    f2: Array,
    stress: Array,
    d: Array,
    w: float,
    least: float,
    a11: Array,
    a22: Array,
    a12: Array,
) -> None:
    """How the forces on a point of volume ``w`` along warp and weft change with F1 and F2: (3, 3) each, a21 = a12'."""
    s11, s22, s12 = stress[0], stress[1], stress[2]
    smaller = 0.5 * (s11 + s22) - np.sqrt(0.25 * (s11 - s22) ** 2 + s12 * s12)
    lift = max(least - smaller, 0.0)
    for r in range(3):
        for c in range(3):
            one, two = f1[r] * f1[c], f2[r] * f2[c]
            mixed, turned = f1[r] * f2[c], f2[r] * f1[c]
            both = mixed + turned
            a11[r, c] = w * (d[0] * one + d[4] * both + d[2] * two)
            a22[r, c] = w * (d[1] * two + d[5] * both + d[2] * one)
            a12[r, c] = w * (d[3] * mixed + d[4] * one + d[5] * two + d[2] * turned)
        a11[r, r] += w * (s11 + lift)
        a22[r, r] += w * (s22 + lift)
        a12[r, r] += w * s12


@part
def _is_bent(scale: Array, i: int, j: int) -> bool:
    """Is a side of this cell laid over an edge?"""
    low, high, left, right = _longer(scale, i, j)
    return low * high * left * right != 1.0


@kernel
def cell_stiffness(
    x: Array,
    scale: Array,
    net: Arrays,
    stress: Array,
    moduli: Array,
    least: float,
    diag: Array,
    off: Array,
) -> None:
    """Add the tangent of all cells without laid sides.

    Where the smaller principal stress is below ``least`` MPa it counts as that.
    """
    n, m = x.shape[0], x.shape[1]
    w = 0.25 * net.cell_volume
    f1, f2 = np.empty(3), np.empty(3)
    a11, a22, a12 = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    g = np.empty((4, 2))  # gradients of the shape functions of (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
    for i in range(n - 1):
        for j in range(m - 1):
            if _is_bent(scale, i, j):
                continue
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
                _moduli(f1, f2, stress[i, j, p], moduli[i, j, p], w, least, a11, a22, a12)
                for a in range(4):
                    own = diag[i + (a == 1 or a == 2), j + (a > 1)]
                    g1, g2 = g[a, 0], g[a, 1]
                    at = 0
                    for r in range(3):
                        for c in range(r, 3):
                            own[at] += g1 * g1 * a11[r, c] + g2 * g2 * a22[r, c] + g1 * g2 * (a12[r, c] + a12[c, r])
                            at += 1
                for pair in range(6):
                    a, b = PAIRS[pair, 0], PAIRS[pair, 1]
                    block = off[i + PAIRS[pair, 2], j + PAIRS[pair, 3], PAIRS[pair, 4]]
                    k11, k22 = g[a, 0] * g[b, 0], g[a, 1] * g[b, 1]
                    k12, k21 = g[a, 0] * g[b, 1], g[a, 1] * g[b, 0]
                    for r in range(3):
                        for c in range(3):
                            block[3 * r + c] += k11 * a11[r, c] + k22 * a22[r, c] + k12 * a12[r, c] + k21 * a12[c, r]


@kernel
def bent_stiffness(  # noqa: C901
    x: Array,
    scale: Array,
    laid: Ints,
    ways: Array,
    net: Arrays,
    stress: Array,
    moduli: Array,
    least: float,
    diag: Array,
    off: Array,
) -> None:
    """Add the tangent of the cells with laid sides, but for how these turn; ``laid`` (n, m, 2): 1 + a side's way."""
    n, m = x.shape[0], x.shape[1]
    w = 0.25 * net.cell_volume
    e, weight = np.empty((4, 3)), np.empty(4)
    turn = np.empty((4, 2, 3, 3))  # of a side with its start and its end
    h, k = np.empty((4, 4, 3, 3)), np.empty((4, 4, 3, 3))
    f1, f2 = np.empty(3), np.empty(3)
    a11, a22, a12 = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for i in range(n - 1):
        for j in range(m - 1):
            if not _is_bent(scale, i, j):
                continue
            for side in range(4):
                p, q = SIDES[side, 0] + i, SIDES[side, 1] + j
                r_, s_, d = SIDES[side, 2] + i, SIDES[side, 3] + j, side // 2
                chord = 0.0
                for r in range(3):
                    e[side, r] = x[r_, s_, r] - x[p, q, r]
                    chord += e[side, r] ** 2
                chord = np.sqrt(chord)
                c, at = scale[p, q, d], laid[p, q, d]
                for r in range(3):
                    for u in range(3):
                        same = 1.0 if r == u else 0.0
                        across = c * (same - e[side, r] * e[side, u] / (chord * chord))
                        start = end = e[side, u] / chord
                        if at > 0:
                            v = ways[at - 1]
                            start = ((v[9] + v[10]) * v[u] + v[11] * v[6 + u]) / v[12]
                            end = ((v[9] + v[10]) * v[3 + u] + v[11] * v[6 + u]) / v[12]
                        turn[side, 0, r, u] = -(e[side, r] / chord * start + across)
                        turn[side, 1, r, u] = e[side, r] / chord * end + across
                for r in range(3):
                    e[side, r] *= c
            h[:], k[:] = 0.0, 0.0
            for p in range(4):
                t = NEAR if p // 2 == 0 else 1.0 - NEAR
                s = NEAR if p % 2 == 0 else 1.0 - NEAR
                weight[0], weight[1] = (1.0 - t) / net.rest[0], t / net.rest[0]
                weight[2], weight[3] = (1.0 - s) / net.rest[1], s / net.rest[1]
                for r in range(3):
                    f1[r] = weight[0] * e[0, r] + weight[1] * e[1, r]
                    f2[r] = weight[2] * e[2, r] + weight[3] * e[3, r]
                _moduli(f1, f2, stress[i, j, p], moduli[i, j, p], w, least, a11, a22, a12)
                for one in range(4):
                    for two in range(4):
                        z = weight[one] * weight[two]
                        for r in range(3):
                            for u in range(3):
                                if one < 2:
                                    v = a11[r, u] if two < 2 else a12[r, u]
                                else:
                                    v = a12[u, r] if two < 2 else a22[r, u]
                                h[one, two, r, u] += z * v
            for one in range(4):
                for two in range(4):
                    for p in range(2):
                        for q in range(2):
                            block = k[CORNERS[one, p], CORNERS[two, q]]
                            block += turn[one, p].T @ h[one, two] @ turn[two, q]
            for a in range(4):
                own = diag[i + (a == 1 or a == 2), j + (a > 1)]
                at = 0
                for r in range(3):
                    for u in range(r, 3):
                        own[at] += k[a, a, r, u]
                        at += 1
            for pair in range(6):
                block = off[i + PAIRS[pair, 2], j + PAIRS[pair, 3], PAIRS[pair, 4]]
                for r in range(3):
                    for u in range(3):
                        block[3 * r + u] += k[PAIRS[pair, 0], PAIRS[pair, 1], r, u]


@kernel
def straighten(x: Array, springs: Ints, ways: Array, net: Arrays, pull: Array, diag: Array, off: Array) -> None:
    """Put right how the ``pull`` (n, m, 2, 3) N of the listed sides turns: along with their ways, across with both.

    A side is e = l n, n its chord's direction and l its way's length. Of the second derivative of pull . e what the
    pull along n makes of n is taken out, as its way's turning is added elsewhere; what its part across n makes of l and
    n together is added.
    """
    n, here, there = np.empty(3), np.empty(3), np.empty(3)  # how the way grows with its start and its end
    t = np.empty(3)  # the pull across the chord, N
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        w, chord, along = ways[b], 0.0, 0.0
        for r in range(3):
            n[r] = x[k, l, r] - x[i, j, r]
            chord += n[r] * n[r]
            along += n[r] * pull[i, j, d, r]
        chord = np.sqrt(chord)
        for r in range(3):
            t[r] = (pull[i, j, d, r] - along * n[r] / (chord * chord)) / chord
            n[r] /= chord
            here[r] = -((w[9] + w[10]) * w[r] + w[11] * w[6 + r]) / w[12]
            there[r] = ((w[9] + w[10]) * w[3 + r] + w[11] * w[6 + r]) / w[12]
        longer = w[12] / chord
        z = net.tension[i, j, d] * longer / chord
        at = 0
        for r in range(3):
            for c in range(3):
                turned = longer * (t[r] * n[c] + n[r] * t[c])
                v = z * ((1.0 if r == c else 0.0) - n[r] * n[c]) + turned
                off[i, j, d, 3 * r + c] += v + here[r] * t[c] - t[r] * there[c]
                if c >= r:
                    diag[i, j, at] -= v + here[r] * t[c] + t[r] * here[c]
                    diag[k, l, at] -= v - there[r] * t[c] - t[r] * there[c]
                    at += 1
