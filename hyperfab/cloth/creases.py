"""Springs that a sharp edge of the mold bends: without them a net cuts the corner between its nodes.

A spring whose straight way leads through the mold at a sharp convex edge is laid over that edge instead, along the
shortest way (a frictionless pulley). With the two sides of the edge unfolded into one plane it is a straight spring
again, and so are its energy, its forces and its tangent: a node that slides over the edge feels no jump.

Bent springs are listed as (k, 4) node (i, j), direction (0 warp, 1 weft) and crease, with their ways (k, 13): unit ways
to and from the edge, axis, reach of both, offset along the axis, their sum.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.surface import bvh

from .features import ON_EDGE, distance2
from .law import evaluate
from .mold import Creases
from .net import Arrays


@part
def law_of(net: Arrays, i: int, j: int, d: int, length: float) -> tuple[float, float, float]:
    """Energy, force and stiffness of a spring of the given length."""
    if net.tension.shape[0] > 0:
        return 0.0, net.tension[i, j, d], 0.0
    rest = net.rest[d]
    if length <= rest:
        return 0.0, 0.0, 0.0
    if d == 0:
        w, p, a = evaluate(length / rest, net.warp[0], net.warp[1], net.warp[2])
        area = net.warp_area[j]
    else:
        w, p, a = evaluate(length / rest, net.weft[0], net.weft[1], net.weft[2])
        area = net.weft_area[i]
    return w * area * rest, p * area, a * area / rest


@kernel
def bend_forces(x: Array, net: Arrays, springs: Ints, ways: Array, f: Array, push: Array) -> tuple[float, float]:
    """Lay the listed springs over the edges: correct ``f`` and add the edges' push on the sheet to ``push`` (3).

    Returns the change of the energy and the largest force of a bent spring.
    """
    change, largest = 0.0, 0.0
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        chord = np.sqrt(distance2(x[k, l], x[i, j]))
        w = ways[b]
        e0, t0, _ = law_of(net, i, j, d, chord)
        e1, t1, _ = law_of(net, i, j, d, w[12])
        change += e1 - e0
        largest = max(largest, t1)
        across, along = (w[9] + w[10]) / w[12] * t1, w[11] / w[12] * t1
        for r in range(3):
            straight = t0 / chord * (x[k, l, r] - x[i, j, r])
            here = across * w[r] + along * w[6 + r]
            there = -across * w[3 + r] - along * w[6 + r]
            f[i, j, r] += here - straight
            f[k, l, r] += there + straight
            push[r] += here + there
    return change, largest


@kernel
def unjoin(springs: Ints, diag: Array, off: Array) -> None:
    """Take the straight springs' tangent of the listed ones out of ``diag`` and ``off``."""
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        at = 0
        for r in range(3):
            for c in range(3):
                v = off[i, j, d, 3 * r + c]
                if c >= r:
                    diag[i, j, at] += v
                    diag[k, l, at] += v
                    at += 1
                off[i, j, d, 3 * r + c] = 0.0


@kernel
def bend_stiffness(
    net: Arrays,
    springs: Ints,
    ways: Array,
    floor: float,
    diag: Array,
    off: Array,
) -> None:
    """Add the tangent of the listed springs."""
    t, n1, n2 = np.empty(3), np.empty(3), np.empty(3)
    own, turn = np.empty((3, 3)), np.empty((3, 3))
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        w = ways[b]
        _, force, slope = law_of(net, i, j, d, w[12])
        along, across = max(slope, floor), max(force / w[12], floor)
        for r in range(3):
            t[r] = ((w[9] + w[10]) * w[r] + w[11] * w[6 + r]) / w[12]
        _cross(w[6:9], w[0:3], n1)
        _cross(w[6:9], w[3:6], n2)
        for r in range(3):
            for c in range(3):
                own[r, c] = (along - across) * t[r] * t[c]
                turn[r, c] = w[r] * w[3 + c] + w[6 + r] * w[6 + c] + n1[r] * n2[c]
            own[r, r] += across
        # Off the surface each end hinges about the crossing alone, by the pull's part square to the edge.
        square = force * (w[9] + w[10]) / w[12]
        p1, p2 = max(square / w[9], floor), max(square / w[10], floor)
        e = diag[i, j]
        at = 0
        for r in range(3):
            for c in range(r, 3):
                e[at] += own[r, c] + (p1 - across) * n1[r] * n1[c]
                at += 1
        e = diag[k, l]
        at = 0
        for r in range(3):
            for c in range(r, 3):
                v = (p2 - across) * n2[r] * n2[c]
                for u in range(3):
                    for z in range(3):
                        v += turn[u, r] * own[u, z] * turn[z, c]
                e[at] += v
                at += 1
        for r in range(3):
            for c in range(3):
                v = across * n1[r] * n2[c]
                for u in range(3):
                    v -= own[r, u] * turn[u, c]
                off[i, j, d, 3 * r + c] += v


@part
def _cross(a: Array, b: Array, out: Array) -> None:
    out[0], out[1], out[2] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def hinge_nodes(springs: Ints, hinges: Ints) -> None:
    """Note at each node up to two bent springs it belongs to: 1 + their number, negative for the second end."""
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        for side in range(2):
            h = hinges[i, j] if side == 0 else hinges[k, l]
            v = b + 1 if side == 0 else -(b + 1)
            if h[0] == 0:
                h[0] = v
            elif h[1] == 0:
                h[1] = v


@part
def over_edge(springs: Ints, ways: Array, creases: Creases, hinge: Ints, x: Array, y: Array, stop: bool) -> int:
    """A node stepping from x to y past the sharp edge that bends one of its springs goes on along that spring.

    Straight on, it would leave the way on which nothing jumps. ``y`` is then where it gets to, or with ``stop`` the
    place where it meets the edge; a step that ends on the edge stops there anyhow. Returns 1 + the crease, negative
    where it stopped, 0 where none is passed.
    """
    most, best = -ON_EDGE, 0
    for h in range(2):
        if hinge[h] == 0:
            continue
        w = ways[abs(hinge[h]) - 1]
        past = 0.0
        for k in range(3):
            past += (y[k] - x[k]) * (w[k] if hinge[h] > 0 else -w[3 + k])
        past -= w[9] if hinge[h] > 0 else w[10]
        if past > most:
            most, best = past, hinge[h]
    if best == 0:
        return 0
    w = ways[abs(best) - 1]
    along = 0.0
    for k in range(3):
        along += (y[k] - x[k]) * w[6 + k]
    stop = stop or most < ON_EDGE
    beyond = 0.0 if stop else most
    for k in range(3):
        if best > 0:
            y[k] = x[k] + w[9] * w[k] + along * w[6 + k] + beyond * w[3 + k]
        else:
            y[k] = x[k] - w[10] * w[3 + k] + along * w[6 + k] - beyond * w[k]
    c = springs[abs(best) - 1, 3]
    if stop:
        cx, cy, cz, _f = bvh.closest_on_triangle(creases.corners[c], y[0], y[1], y[2])
        y[0], y[1], y[2] = cx, cy, cz
        return -(c + 1)
    return int(c + 1)
