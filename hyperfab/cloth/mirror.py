"""A sheet and a mold that are their own mirror image: the sheet is sought among the shapes that are so too.

In the plane between the halves nodes and springs meet edges and corners of the mold that would lead them to either
side alike: which, the order of facets or rounding would decide, and the sheet would rest askew. Among even shapes the
energy has a gradient there: a force is the mean of a node's and its image's. Where a step leaves the two apart, the one
with the lower number is followed; nodes that keep together are left as they are.

A sheet that is its own mirror image keeps so while it comes to rest: its steps are mirrored as its forces are.

Facets of a mold let a node rest on one or the next, and which it is hangs on the way there. Sweeps over the nodes in
their order lead a node and its mirror image on ways that differ by what the linear solver leaves, so that they end in
different facets. Where the unbalanced forces and the ways left to the nodes are mirror images, so is Newton's step: the
mean of a solution and its images is one that no solver's order has touched, and no further from the true one.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.threads import in_rows
from hyperfab.surface.bvh import DEPTH, closest_on_triangle, nearest_one

from .features import FLAT, copy, distance2
from .landing import rounding
from .mold import FREE, ON_FACE, Mold
from .net import Sheet
from .state import State

#: Molds of more facets are not looked at: what one facet does is small there, and to compare all of them takes long.
MOST = 20_000
#: A node this many mm from its image's place is at it.
TOGETHER = 1e-9
#: Facets whose normals differ by less face one way.
FACING = 1e-5
#: Unbalanced forces that differ by less than this share of the largest are mirror images; directions, by the second.
FORCES, DIRECTIONS = 1e-2, 1e-5
#: The mirrors, of nodes and coordinates alike: x to -x, y to -y, and of a square grid x to y and x to -y.
MIRRORS = 4


@kernel
def _is_image(mold: Mold, axis: int) -> bool:
    """Does each facet's middle have its image, by the plane where ``axis`` is 0, on a facet that faces as its own?"""
    stack, stack_d, p, near = np.empty(DEPTH, np.int64), np.empty(DEPTH), np.empty(3), rounding(mold)
    if abs(mold.bounds[0, axis] + mold.bounds[0, 3 + axis]) > 2.0 * near:
        return False
    hint = np.int64(-1)
    for s in range(mold.corners.shape[0]):
        for k in range(3):
            p[k] = (mold.corners[s, 0, k] + mold.corners[s, 1, k] + mold.corners[s, 2, k]) / 3.0
        p[axis] = -p[axis]
        x, y, z, hint, _f = nearest_one(p[0], p[1], p[2], hint, mold, stack, stack_d)
        if (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2 > near * near:
            return False
        for k in range(3):
            own = -mold.normals[s, 0, k] if k == axis else mold.normals[s, 0, k]
            if abs(own - mold.normals[hint, 0, k]) > FACING:
                return False
    return True


@part
def _edge_near(mold: Mold, slot: int, p: Array) -> int:
    """Edge of a facet that p is on but for rounding, among those that turn; -1: none."""
    best, least = -1, (10.0 * rounding(mold)) ** 2  # a node on an edge that does not turn is beside those that do
    for e in range(3):
        if abs(mold.turn[slot, e]) <= FLAT:
            continue
        a, b = mold.corners[slot, e], mold.corners[slot, (e + 1) % 3]
        s, length, off = 0.0, 0.0, 0.0
        for k in range(3):
            s += (p[k] - a[k]) * (b[k] - a[k])
            length += (b[k] - a[k]) ** 2
        s = min(max(s / length, 0.0), 1.0)
        for k in range(3):
            off += (p[k] - a[k] - s * (b[k] - a[k])) ** 2
        if off < least:
            best, least = e, off
    return best


@part
def _corner_near(mold: Mold, slot: int, p: Array) -> int:
    """Corner of a facet that p is nearest to."""
    best, least = 0, np.inf
    for c in range(3):
        off = distance2(p, mold.corners[slot, c])
        if off < least:
            best, least = c, off
    return best


@part
def _on_segment(a: Array, b: Array, p: Array) -> float:
    """Put p on the nearest place of the segment from a to b; which share of it."""
    s, length = 0.0, 0.0
    for k in range(3):
        s += (p[k] - a[k]) * (b[k] - a[k])
        length += (b[k] - a[k]) ** 2
    s = min(max(s / length, 0.0), 1.0)
    for k in range(3):
        p[k] = a[k] + s * (b[k] - a[k])
    return s


@part
def _seated(mold: Mold, slot: int, feature: int, p: Array) -> int:
    """Put p, but for rounding on the image of another facet's ``feature``, onto that of ``slot``: which one it is."""
    if feature > 3:
        c = _corner_near(mold, slot, p)
        copy(mold.corners[slot, c], p)
        return 4 + c
    e = _edge_near(mold, slot, p) if feature > 0 else -1
    if e >= 0:
        _on_segment(mold.corners[slot, e], mold.corners[slot, (e + 1) % 3], p)
        return 1 + e
    a, n = mold.corners[slot, 0], mold.normals[slot, 0]
    off = (p[0] - a[0]) * n[0] + (p[1] - a[1]) * n[1] + (p[2] - a[2]) * n[2]
    for k in range(3):
        p[k] -= off * n[k]
    return 0


@part
def _in_plane(mold: Mold, slot: int, axis: int, near: float, p: Array) -> int:
    """Put p onto what a facet has of the mirror's plane: feature it is on then, or -1 where it has nothing of it."""
    if abs(mold.normals[slot, 0, axis]) < FACING:  # the facet crosses the plane squarely
        _seated(mold, slot, 0, p)
        p[axis] = 0.0
        cx, cy, cz, _f = closest_on_triangle(mold.corners[slot], p[0], p[1], p[2])
        off = (p[0] - cx) ** 2 + (p[1] - cy) ** 2 + (p[2] - cz) ** 2
        return 0 if off <= near * near else -1
    for e in range(3):
        a, b = mold.corners[slot, e], mold.corners[slot, (e + 1) % 3]
        if abs(a[axis]) <= near and abs(b[axis]) <= near:
            s = _on_segment(a, b, p)
            if s <= 0.0 or s >= 1.0:
                return 4 + (e if s <= 0.0 else (e + 1) % 3)
            return 1 + e
    return -1


@kernel
def reflect(now: State, axis: int, mold: Mold, fixed: np.ndarray) -> None:
    """Let nodes beyond the plane where ``axis`` is 0 follow their images, and those in it stay there."""
    x, state, slot, clear, crossed = now
    n, m = x.shape[0], x.shape[1]
    stack, stack_d, p = np.empty(DEPTH, np.int64), np.empty(DEPTH), np.empty(3)
    near = rounding(mold)
    for i in range(n):
        for j in range(m):
            k, l = (n - 1 - i, j) if axis == 0 else (i, m - 1 - j)
            if i * m + j > k * m + l or fixed[i, j] == 7:
                continue
            off = 0.0
            for c in range(3):
                p[c] = -x[i, j, c] if c == axis else x[i, j, c]
                off = max(off, abs(x[k, l, c] - p[c]))
            if off <= TOGETHER and (state[i, j] == FREE) == (state[k, l] == FREE):
                continue
            own = i == k and j == l
            if own:
                p[axis] = 0.0
            crossed[k, l] = crossed[i, j]
            if state[i, j] == FREE:
                state[k, l], clear[k, l] = FREE, max(clear[i, j] - (off if own else near), 0.0)
                copy(p, x[k, l])
                continue
            _x, _y, _z, at, _f = nearest_one(p[0], p[1], p[2], slot[k, l], mold, stack, stack_d)
            feature = int(state[i, j]) - ON_FACE
            feature = _in_plane(mold, at, axis, near, p) if own else _seated(mold, at, feature, p)
            if feature < 0:
                continue
            state[k, l], slot[k, l], clear[k, l] = ON_FACE + feature, at, 0.0
            copy(p, x[k, l])


def mirrors(sheet: Sheet, mold: Mold) -> tuple[int, ...]:
    """Axes, 0 for x and 1 for y, by whose planes a net and its mold are their own mirror image.

    A membrane is left out: its law may know a direction of its own.
    """
    if sheet.membrane is not None or len(mold.corners) > MOST:
        return ()
    fixed = sheet.fixed
    return tuple(
        axis
        for axis, image in ((0, fixed[::-1]), (1, fixed[:, ::-1]))
        if np.array_equal(fixed, image) and _is_image(mold, axis)
    )


@part
def _image(mirror: int, i: int, j: int, n: int, m: int) -> tuple[int, int, int, int, float, float]:
    """The image of node (i, j), the coordinates that become x and y there, and their signs."""
    if mirror == 0:
        return n - 1 - i, j, 0, 1, -1.0, 1.0
    if mirror == 1:
        return i, m - 1 - j, 0, 1, 1.0, -1.0
    if mirror == 2:
        return j, i, 1, 0, 1.0, 1.0
    return m - 1 - j, n - 1 - i, 1, 0, -1.0, -1.0


@kernel
def _is_even(r: Array, q: Array, mirror: int, forces: float, start: int, end: int) -> bool:
    """Are forces r (n, m, 3) and projectors q (n, m, 6) of rows ``start:end`` those of their image?"""
    n, m = r.shape[0], r.shape[1]
    for i in range(start, end):
        for j in range(m):
            k, l, a, b, sx, sy = _image(mirror, i, j, n, m)
            if i * m + j > k * m + l:
                continue
            f, g, p, o = r[i, j], r[k, l], q[i, j], q[k, l]
            if (
                abs(f[0] - sx * g[a]) > forces
                or abs(f[1] - sy * g[b]) > forces
                or abs(f[2] - g[2]) > forces
                or abs(p[0] - o[3 * a]) > DIRECTIONS
                or abs(p[3] - o[3 * b]) > DIRECTIONS
                or abs(p[5] - o[5]) > DIRECTIONS
                or abs(p[1] - sx * sy * o[1]) > DIRECTIONS
                or abs(p[2] - sx * o[2 + 2 * a]) > DIRECTIONS
                or abs(p[4] - sy * o[2 + 2 * b]) > DIRECTIONS
            ):
                return False
    return True


@kernel
def mean(d: Array, mirror: int) -> None:
    """d (n, m, 3) = the mean of d and its image by one of the mirrors."""
    n, m = d.shape[0], d.shape[1]
    for i in range(n):
        for j in range(m):
            k, l, a, b, sx, sy = _image(mirror, i, j, n, m)
            if i * m + j > k * m + l:
                continue
            u, v = d[i, j], d[k, l]
            x, y, z = 0.5 * (u[0] + sx * v[a]), 0.5 * (u[1] + sy * v[b]), 0.5 * (u[2] + v[2])
            u[0], u[1], u[2] = x, y, z
            v[a], v[b], v[2] = sx * x, sy * y, z


def even(d: Array, r: Array, q: Array, worst: float) -> None:
    """Mirror a step ``d`` (n, m, 3) as the forces ``r`` and projectors ``q`` (n, m, 6) are; ``worst``: largest r."""
    n, m = r.shape[:2]
    odd = [False] * MIRRORS

    def look(first: int, last: int) -> None:
        for mirror in range(MIRRORS if n == m else 2):
            if not odd[mirror] and not _is_even(r, q, mirror, FORCES * worst, first, last):
                odd[mirror] = True

    in_rows(look, n, m)
    for mirror in range(MIRRORS if n == m else 2):
        if not odd[mirror]:
            mean(d, mirror)
