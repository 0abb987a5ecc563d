"""A node on a sharp edge of the mold: do the springs hold it there, or which way does it go?

Off the edge by a little, in a direction square to it, a spring either stays straight and pulls the node on, or is bent
over the edge and pulls it back with its full force. The node is held while no direction outside the mold lets the
springs shorten: the cone of normals, for springs that turn with the edge.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import part

from .creases import law_of
from .features import BESIDE, dot, outward
from .mold import FREE, ON_FACE, Mold
from .net import Arrays, neighbour

DIRECTIONS = 73


@part
def _pull(net: Arrays, x: Array, i: int, j: int, side: int, ways: Array, hinge: Ints, bent: Ints, out: Array) -> bool:
    """Force of one of the four springs of a node (0, 1 warp; 2, 3 weft) on it; False at the border."""
    n, m = x.shape[0], x.shape[1]
    d = side // 2
    k, l = neighbour(i, j, side)
    if k < 0 or l < 0 or k >= n or l >= m:
        return False
    for h in range(2):
        if hinges_to(hinge[h], bent, side):
            w = ways[abs(hinge[h]) - 1]
            _, force, _ = law_of(net, min(i, k), min(j, l), d, w[12])
            for r in range(3):
                if hinge[h] > 0:
                    out[r] = force * ((w[9] + w[10]) * w[r] + w[11] * w[6 + r]) / w[12]
                else:
                    out[r] = -force * ((w[9] + w[10]) * w[3 + r] + w[11] * w[6 + r]) / w[12]
            return True
    length = 0.0
    for r in range(3):
        out[r] = x[k, l, r] - x[i, j, r]
        length += out[r] * out[r]
    length = max(np.sqrt(length), 1e-300)
    _, force, _ = law_of(net, min(i, k), min(j, l), d, length)
    for r in range(3):
        out[r] *= force / length
    return True


@part
def hinges_to(hinge: int, bent: Ints, side: int) -> bool:
    """Is this hinge of node (i, j) the spring on its ``side``?"""
    if hinge == 0 or bent[abs(hinge) - 1, 2] != side // 2:
        return False
    return (hinge > 0) == (side % 2 == 0)


@part
def pinned(
    mold: Mold,
    net: Arrays,
    x: Array,
    f: Array,
    i: int,
    j: int,
    slot: Ints,
    state: int,
    bent: Ints,
    ways: Array,
    hinges: Ints,
    slack: float,
) -> int:
    """State of a node on a sharp edge: as it is where the springs hold it but for ``slack`` N; else it is put beside
    the edge, the way they pull, and is on a facet or free.
    """
    s, e = slot[i, j], state - ON_FACE - 1
    one, up = np.empty(3), mold.normals[s, 0]
    outward(mold, s, e, one)
    size, angle = np.empty(5), np.empty(5)
    pull, rest = np.empty(3), np.empty(3)
    for r in range(3):
        one[r] = -one[r]
        rest[r] = f[i, j, r]
    reach = np.pi + mold.turn[s, e]  # the directions outside the mold, from this facet round to the other
    hinge = hinges[i, j] if ways.shape[0] > 0 else np.zeros(2, np.int64)
    for side in range(5):
        size[side], angle[side] = 0.0, 0.0
        if side < 4:
            if not _pull(net, x, i, j, side, ways, hinge, bent, pull):
                continue
            for r in range(3):
                rest[r] -= pull[r]
        else:
            for r in range(3):
                pull[r] = rest[r]  # weight and diagonals
        a, b = dot(pull, one), dot(pull, up)
        size[side] = np.sqrt(a * a + b * b)
        turn = np.arctan2(b, a)
        if turn < 0.0:
            turn += 2.0 * np.pi
        if turn > reach and side < 4:
            turn = reach if turn < 0.5 * reach + np.pi else 0.0
        angle[side] = turn
    most, best = 0.0, -1.0
    for d in range(DIRECTIONS):
        way = reach * d / (DIRECTIONS - 1)
        gain = 0.0
        for side in range(5):
            off = abs(way - angle[side])
            gain += size[side] * (np.cos(off) if off < np.pi or side == 4 else -1.0)
        if gain > most + 1e-12 * abs(most):
            most, best = gain, way
    if most <= slack:
        return state
    for r in range(3):
        x[i, j, r] += BESIDE * (np.cos(best) * one[r] + np.sin(best) * up[r])
    if best == 0.0:
        return ON_FACE
    if best == reach:
        slot[i, j] = mold.twins[s, e]
        return ON_FACE
    return FREE
