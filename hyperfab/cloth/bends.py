"""Which springs a sharp edge of the mold bends, and the shortest way each of them has over it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.surface import bvh

from .depth import deepest_of, room
from .features import distance2
from .mold import Creases, Mold

#: What a crease is to the straight way of a spring.
CLEAR, CUT, BURIED = 0, 1, 2
#: A node this many mm below a facet is on it but for rounding.
ON_FACET = 1e-9


@part
def _on(creases: Creases, c: int, p: Array, q: Array, h: Array) -> tuple[float, float]:
    """Shortest way from p to q over the line of crease ``c``: place on it from its first end, within it; its length.

    ``h`` becomes the line's direction. A place on an end may stand for one beyond.
    """
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
    return min(max(s, 0.0), length), length


@part
def _over(creases: Creases, c: int, p: Array, q: Array, h: Array) -> tuple[int, float, float]:
    """Shortest way from p to q over the line of creases around ``c``: (crease, place on it, its length)."""
    s, length = 0.0, 0.0
    came = -1
    for _ in range(64):
        s, length = _on(creases, c, p, q, h)
        if 0.0 < s < length:
            break
        following = creases.beyond[c, 0 if s <= 0.0 else 1]
        if following < 0 or following == came:
            break
        came, c = c, following
    return c, s, length


@part
def _parted(creases: Creases, c: int, p: Array, q: Array, g: Array, h: Array) -> int:
    """Does the straight way from p to q lead through the mold's wedge at a crease, which runs along h through g?

    CUT where p and q, seen from the crease, stand more than half a turn apart, measured outside the wedge, else CLEAR;
    plus BURIED where one of them stands inside it (beyond the crease's end it may: the wedge has no end).
    """
    one, two = creases.normals[c, 0], creases.normals[c, 1]
    x, y, z = one[1] * h[2] - one[2] * h[1], one[2] * h[0] - one[0] * h[2], one[0] * h[1] - one[1] * h[0]
    sign = -1.0 if x * two[0] + y * two[1] + z * two[2] > 0.0 else 1.0
    reach = np.pi + np.arccos(min(1.0, one[0] * two[0] + one[1] * two[1] + one[2] * two[2]))
    turn = np.zeros(2)
    buried, on_line = False, False
    for side in range(2):
        v = p if side == 0 else q
        dx, dy, dz = v[0] - g[0], v[1] - g[1], v[2] - g[2]
        a = sign * (dx * x + dy * y + dz * z)
        b = dx * one[0] + dy * one[1] + dz * one[2]
        if a * a + b * b < 1e-24:
            on_line = True
            continue
        angle = np.arctan2(b, a)
        if angle < 0.0:
            angle += 2.0 * np.pi
        if angle > reach:
            size = np.sqrt(a * a + b * b)
            off = min(angle - reach, 2.0 * np.pi - angle)
            buried = buried or off * size > ON_FACET
            angle = reach if angle < 0.5 * reach + np.pi else 0.0
        turn[side] = angle
    cut = CUT if not on_line and abs(turn[0] - turn[1]) > np.pi else CLEAR
    return cut + BURIED if buried else cut


@part
def _crossed(creases: Creases, c: int, p: Array, q: Array, g: Array, h: Array) -> int:
    """Crease near ``c`` over which the way from p to q is bent, at the place g of its line along h; -1: none.

    Near a corner where creases meet it is the one with the shortest way, so that the length of the way does not jump
    from one crease to the next.
    """
    c, s, length = _over(creases, c, p, q, h)
    _place(creases, c, s, h, g)
    end = 0 if s < 0.5 * length else 1
    if 0.0 < s < length and creases.beyond[c, end] >= 0:  # amid an edge of several creases
        return c if _parted(creases, c, p, q, g, h) % BURIED == CUT else -1
    if min(s, length - s) ** 2 <= distance2(q, p):
        shortest, best = np.inf, c
        for tries in range(6):
            other = c
            if tries > 0:
                other = creases.beyond[c, end] if tries == 5 else creases.meeting[c, end, tries - 1]
            if other < 0:
                continue
            at, _ = _on(creases, other, p, q, h)
            _place(creases, other, at, h, g)
            where = _parted(creases, other, p, q, g, h)
            if where == CUT:
                way = np.sqrt(distance2(p, g)) + np.sqrt(distance2(g, q))
                if way < shortest:
                    shortest, best = way, other
        if shortest < np.inf:
            at, _ = _on(creases, best, p, q, h)
            _place(creases, best, at, h, g)
            return best
        if creases.beyond[c, end] < 0:
            return -1
        _on(creases, c, p, q, h)
        _place(creases, c, s, h, g)
    return c if _parted(creases, c, p, q, g, h) % BURIED == CUT else -1


@part
def _place(creases: Creases, c: int, s: float, h: Array, g: Array) -> None:
    for r in range(3):
        g[r] = creases.corners[c, 0, r] + s * h[r]


def farthest(creases: Creases) -> float:
    """How far from a crease, in its own length, the middle of a spring can be that the crease bends.

    A line through a wedge of angle w between two places outside passes its edge within tan((pi - w)/2) of half the way
    between them. Twice that and the other half, for places beyond the ends of edges.
    """
    cosine = np.clip((creases.normals[:, 0] * creases.normals[:, 1]).sum(axis=1), -1.0, 1.0)
    # The tangent of half the angle between the normals, which is (pi - w)/2.
    steepest = np.sqrt((1.0 - cosine) / np.maximum(1.0 + cosine, 1e-300))
    return 1.0 + float(steepest.max(initial=0.0))


@kernel
def find_bends(
    x: Array,
    clear: Array,
    mold: Mold,
    straight: npt.NDArray[np.bool_],
    reach: float,
    springs: Ints,
    ways: Array,
    first: int,
    last: int,
    found: int,
) -> int:
    """List the bent springs of node rows ``first:last`` after the ``found`` ones; their number, also where it is more
    than fits. Springs marked in ``straight`` (n, m, 2) are left out, and those whose middle is further from all
    creases than ``reach`` times their length (``farthest``).
    """
    n, m = x.shape[0], x.shape[1]
    creases, work = mold.creases, room()
    h, g = np.empty(3), np.empty(3)
    for i in range(first, last):
        for j in range(m):
            for d in range(2):
                k, l = (i + 1, j) if d == 0 else (i, j + 1)
                if k >= n or l >= m:
                    continue
                p, q = x[i, j], x[k, l]
                len2 = distance2(q, p)
                if (clear[i, j] + clear[k, l]) ** 2 > len2 or straight[i, j, d] or not 0.0 < len2 < np.inf:
                    continue
                t, c = 0.5, np.int64(-1)  # a literal would make what takes it compile twice
                far = False
                for tries in range(3):
                    ex, ey, ez, c, _f = bvh.nearest_one(
                        p[0] + t * (q[0] - p[0]),
                        p[1] + t * (q[1] - p[1]),
                        p[2] + t * (q[2] - p[2]),
                        c,
                        creases,
                        work.stack,
                        work.stack_d,
                    )
                    if tries == 0:
                        off = (ex - 0.5 * (p[0] + q[0])) ** 2 + (ey - 0.5 * (p[1] + q[1])) ** 2
                        far = off + (ez - 0.5 * (p[2] + q[2])) ** 2 > reach * reach * len2
                        if far:
                            break
                    t = ((ex - p[0]) * (q[0] - p[0]) + (ey - p[1]) * (q[1] - p[1]) + (ez - p[2]) * (q[2] - p[2])) / len2
                    t = min(max(t, 0.0), 1.0)
                if far:
                    continue
                c = _crossed(creases, c, p, q, g, h)
                if c < 0:
                    continue
                # Wedges at creases have no end, the mold has: beside a corner they may be in the way where it is not.
                deep, _ = deepest_of(mold, p, q, creases.facet[c, 0], ON_FACET, ON_FACET, work)
                if deep <= ON_FACET:
                    continue
                if found < springs.shape[0]:
                    springs[found, 0], springs[found, 1], springs[found, 2], springs[found, 3] = i, j, d, c
                    _ways(p, q, g, h, ways[found])
                found += 1
    return found


@part
def _ways(p: Array, q: Array, g: Array, h: Array, way: Array) -> None:
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
