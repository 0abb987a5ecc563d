"""Springs that a sharp edge of the mold bends: without them a net cuts the corner between its nodes.

A spring whose straight way leads through the mold at a sharp convex edge is laid over that edge instead, along the
shortest way (a frictionless pulley). With the two sides of the edge unfolded into one plane it is a straight spring
again, and so are its energy, its forces and its tangent: a node that slides over the edge feels no jump.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hyperfab.numerics.kernels import kernel, part
from hyperfab.surface import bvh

from .features import ON_EDGE
from .law import Floats, evaluate
from .mold import Creases, Ints
from .net import Arrays


class Bends(NamedTuple):
    """Bent springs: node (i, j), direction (0 warp, 1 weft), crease, and the two ways that meet on the edge."""

    springs: Ints  # (k, 4)
    ways: Floats  # (k, 13): unit ways to and from the edge, axis, reach of both, offset along the axis, their sum


@part
def _over(creases: Creases, c: int, p: Floats, q: Floats, h: Floats) -> tuple[int, float, float]:
    """Shortest way from p to q over the line of creases around ``c``: (crease, place on it, its length)."""
    s, length = 0.0, 0.0
    came = -1
    for _ in range(64):
        a, b = creases.corners[c, 0], creases.corners[c, 1]
        length = 0.0
        for k in range(3):
            h[k] = b[k] - a[k]
            length += h[k] * h[k]
        length = np.sqrt(length)
        sp, sq, dp, dq = 0.0, 0.0, 0.0, 0.0
        for k in range(3):
            h[k] /= length
            sp += (p[k] - a[k]) * h[k]
            sq += (q[k] - a[k]) * h[k]
        for k in range(3):
            dp += (p[k] - a[k] - sp * h[k]) ** 2
            dq += (q[k] - a[k] - sq * h[k]) ** 2
        dp, dq = np.sqrt(dp), np.sqrt(dq)
        s = sp + (sq - sp) * dp / max(dp + dq, 1e-300)
        if 0.0 <= s <= length:
            break
        following = creases.beyond[c, 0 if s < 0.0 else 1]
        s = min(max(s, 0.0), length)
        if following < 0 or following == came:
            break
        came, c = c, following
    return c, s, length


@part
def _parted(creases: Creases, c: int, p: Floats, q: Floats, g: Floats, h: Floats) -> bool:
    """Does the straight way from p to q lead through the mold at the place g of a crease along h?

    It does where p and q, seen from the crease, stand more than half a turn apart, measured outside the mold.
    """
    one, two = creases.normals[c, 0], creases.normals[c, 1]
    x, y, z = one[1] * h[2] - one[2] * h[1], one[2] * h[0] - one[0] * h[2], one[0] * h[1] - one[1] * h[0]
    sign = -1.0 if x * two[0] + y * two[1] + z * two[2] > 0.0 else 1.0
    reach = np.pi + np.arccos(min(1.0, one[0] * two[0] + one[1] * two[1] + one[2] * two[2]))
    turn = np.zeros(2)
    for side in range(2):
        v = p if side == 0 else q
        dx, dy, dz = v[0] - g[0], v[1] - g[1], v[2] - g[2]
        a = sign * (dx * x + dy * y + dz * z)
        b = dx * one[0] + dy * one[1] + dz * one[2]
        if a * a + b * b < 1e-24:
            return False
        angle = np.arctan2(b, a)
        if angle < 0.0:
            angle += 2.0 * np.pi
        if angle > reach:
            angle = reach if angle < 0.5 * reach + np.pi else 0.0
        turn[side] = angle
    return bool(abs(turn[0] - turn[1]) > np.pi)


@part
def _crossed(creases: Creases, c: int, p: Floats, q: Floats, g: Floats, h: Floats) -> int:
    """Crease near ``c`` over which the way from p to q is bent, at the place g of its line along h; -1: none."""
    c, s, length = _over(creases, c, p, q, h)
    end = -1
    if s <= 0.0 and creases.beyond[c, 0] < 0:
        end = 0
    elif s >= length and creases.beyond[c, 1] < 0:
        end = 1
    if end < 0:
        _place(creases, c, s, h, g)
        return c if _parted(creases, c, p, q, g, h) else -1
    for tries in range(4):  # at a corner the way slips off onto one of the other creases that meet there
        other = creases.meeting[c, end, tries]
        if other < 0:
            continue
        other, s, length = _over(creases, other, p, q, h)
        if 0.0 < s < length:
            _place(creases, other, s, h, g)
            if _parted(creases, other, p, q, g, h):
                return other
    return -1


@part
def _place(creases: Creases, c: int, s: float, h: Floats, g: Floats) -> None:
    for r in range(3):
        g[r] = creases.corners[c, 0, r] + s * h[r]


@kernel
def find_bends(
    x: Floats,
    clear: Floats,
    creases: Creases,
    straight: npt.NDArray[np.bool_],
    springs: Ints,
    ways: Floats,
    first: int,
    last: int,
    found: int,
) -> int:
    """List the bent springs of node rows ``first:last`` after the ``found`` ones; their number, also where it is more
    than fits. Springs marked in ``straight`` (n, m, 2) are left out.
    """
    n, m = x.shape[0], x.shape[1]
    stack, stack_d = np.empty(bvh.DEPTH, np.int64), np.empty(bvh.DEPTH)
    h, g = np.empty(3), np.empty(3)
    for i in range(first, last):
        for j in range(m):
            for d in range(2):
                k, l = (i + 1, j) if d == 0 else (i, j + 1)
                if k >= n or l >= m:
                    continue
                p, q = x[i, j], x[k, l]
                len2 = (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2
                if (clear[i, j] + clear[k, l]) ** 2 > len2 or straight[i, j, d] or len2 == 0.0:
                    continue
                t, c = 0.5, -1
                for _ in range(3):
                    ex, ey, ez, c, _f = bvh.nearest_one(
                        p[0] + t * (q[0] - p[0]),
                        p[1] + t * (q[1] - p[1]),
                        p[2] + t * (q[2] - p[2]),
                        c,
                        creases.corners,
                        creases.bounds,
                        creases.right,
                        creases.start,
                        creases.number,
                        stack,
                        stack_d,
                    )
                    t = (
                        (ex - p[0]) * (q[0] - p[0])
                        + (ey - p[1]) * (q[1] - p[1])
                        + (ez - p[2]) * (q[2] - p[2])
                    ) / len2
                    t = min(max(t, 0.0), 1.0)
                c = _crossed(creases, c, p, q, g, h)
                if c < 0:
                    continue
                if found < springs.shape[0]:
                    springs[found, 0], springs[found, 1], springs[found, 2], springs[found, 3] = i, j, d, c
                    _ways(p, q, g, h, ways[found])
                found += 1
    return found


@part
def _ways(p: Floats, q: Floats, g: Floats, h: Floats, way: Floats) -> None:
    """Frames on both sides of a crossing g of the crease along h: to it from p (w1), from it to q (w2), axis."""
    # The axis of unfolding is the crease where the way crosses it inside, else square to both ways (at a corner).
    dp, dq, sp, sq = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        sp += (p[k] - g[k]) * h[k]
        sq += (q[k] - g[k]) * h[k]
    for k in range(3):
        way[k] = -(p[k] - g[k] - sp * h[k])
        way[3 + k] = q[k] - g[k] - sq * h[k]
        dp += way[k] ** 2
        dq += way[3 + k] ** 2
        way[6 + k] = h[k]
    dp, dq = max(np.sqrt(dp), 1e-12), max(np.sqrt(dq), 1e-12)
    if abs(sp * dq + sq * dp) > 1e-9 * (dp + dq) * (abs(sp) + abs(sq)):
        # Held at a corner: the two straight parts, hinged about the normal of their plane.
        dp, dq = 0.0, 0.0
        for k in range(3):
            way[k], way[3 + k] = g[k] - p[k], q[k] - g[k]
            dp += way[k] ** 2
            dq += way[3 + k] ** 2
        dp, dq, sp, sq = max(np.sqrt(dp), 1e-12), max(np.sqrt(dq), 1e-12), 0.0, 0.0
        u = way
        ax, ay, az = u[1] * u[5] - u[2] * u[4], u[2] * u[3] - u[0] * u[5], u[0] * u[4] - u[1] * u[3]
        size = np.sqrt(ax * ax + ay * ay + az * az)
        if size > 1e-12 * dp * dq:
            way[6], way[7], way[8] = ax / size, ay / size, az / size
    for k in range(3):
        way[k] /= dp
        way[3 + k] /= dq
    way[9], way[10], way[11] = dp, dq, sq - sp
    way[12] = np.sqrt((dp + dq) ** 2 + (sq - sp) ** 2)


@part
def law_of(net: Arrays, i: int, j: int, d: int, length: float) -> tuple[float, float, float]:
    """Energy, force and stiffness of a spring of the given length."""
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
def bend_forces(
    x: Floats, net: Arrays, springs: Ints, ways: Floats, f: Floats, push: Floats
) -> tuple[float, float]:
    """Lay the listed springs over the edges: correct ``f`` and add the edges' push on the sheet to ``push`` (3).

    Returns the change of the energy and the largest force of a bent spring.
    """
    change, largest = 0.0, 0.0
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        chord = 0.0
        for r in range(3):
            chord += (x[k, l, r] - x[i, j, r]) ** 2
        chord = np.sqrt(chord)
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
def bend_stiffness(
    net: Arrays,
    springs: Ints,
    ways: Floats,
    floor: float,
    warp: Floats,
    weft: Floats,
    extra: Floats,
    coupling: Floats,
) -> None:
    """Tangent of the listed springs: own blocks into ``extra``, ``coupling`` (k, 9) between their nodes; the straight
    springs' blocks are cleared.
    """
    t, n1, n2 = np.empty(3), np.empty(3), np.empty(3)
    own, turn = np.empty((3, 3)), np.empty((3, 3))
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        block = warp[i, j] if d == 0 else weft[i, j]
        for r in range(6):
            block[r] = 0.0
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
        # Off the surface each end hinges about the crossing alone.
        p1, p2 = max(force / w[9], floor), max(force / w[10], floor)
        e = extra[i, j]
        at = 0
        for r in range(3):
            for c in range(r, 3):
                e[at] += own[r, c] + (p1 - across) * n1[r] * n1[c]
                at += 1
        e = extra[k, l]
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
                coupling[b, 3 * r + c] = v


@part
def _cross(a: Floats, b: Floats, out: Floats) -> None:
    out[0], out[1], out[2] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@part
def couple(springs: Ints, coupling: Floats, u: Floats, out: Floats) -> None:
    """out += coupling of the bent springs times u."""
    for b in range(springs.shape[0]):
        i, j, d = springs[b, 0], springs[b, 1], springs[b, 2]
        k, l = (i + 1, j) if d == 0 else (i, j + 1)
        c = coupling[b]
        for r in range(3):
            out[i, j, r] += c[3 * r] * u[k, l, 0] + c[3 * r + 1] * u[k, l, 1] + c[3 * r + 2] * u[k, l, 2]
            out[k, l, r] += c[r] * u[i, j, 0] + c[3 + r] * u[i, j, 1] + c[6 + r] * u[i, j, 2]


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
def over_edge(
    springs: Ints, ways: Floats, creases: Creases, hinge: Ints, x: Floats, y: Floats, stop: bool
) -> int:
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
