"""Bounding-volume tree over triangles, compiled: exact nearest point and first hit of a ray.

The tree is stored depth first: the left child of node ``i`` is ``i + 1``, ``right[i]`` is the right child, or
``-1`` at a leaf; its triangles are ``start[i] : start[i] + count[i]`` of the reordered list. Triangles are split
at the median of their centroids along the longest side, so the depth stays below 64 for any mesh that fits memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hyperfab.arrays import Array, Ints, Singles
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.threads import in_blocks

LEAF = 4
DEPTH = 64
#: No fewer triangles are sorted by a thread of its own.
PART = 10_000


class Tree(NamedTuple):
    """What a search needs, in a mold's own named tuple or alone: ``corners`` (m, 3, 3) in tree order, ``bounds`` (k, 6)
    and the nodes (k,)."""

    corners: Array
    bounds: Array
    right: Ints
    start: Ints
    number: Ints


# Where on its triangle the nearest point lies.
FACE, EDGE_AB, EDGE_BC, EDGE_CA, VERTEX_A, VERTEX_B, VERTEX_C = range(7)


@part
def _select(centres: Singles, order: Ints, axis: int, lo: int, hi: int, k: int) -> None:
    """Reorder ``lo:hi`` so that the k-th entry is in its sorted place along ``axis`` (Hoare's select)."""
    hi -= 1
    while lo < hi:
        pivot = centres[(lo + hi) // 2, axis]
        i, j = lo, hi
        while i <= j:
            while centres[i, axis] < pivot:
                i += 1
            while centres[j, axis] > pivot:
                j -= 1
            if i <= j:
                # The centres move with their numbers: what is compared lies side by side in memory.
                for a in range(3):
                    centres[i, a], centres[j, a] = centres[j, a], centres[i, a]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if k <= j:
            hi = j
        elif k >= i:
            lo = i
        else:
            return


@part
def _widest(centres: Singles, lo: int, hi: int) -> Any:
    """The axis along which the centres ``lo:hi`` are spread most."""
    x0, y0, z0 = centres[lo, 0], centres[lo, 1], centres[lo, 2]
    x1, y1, z1 = x0, y0, z0
    for t in range(lo + 1, hi):
        x, y, z = centres[t, 0], centres[t, 1], centres[t, 2]
        x0, x1 = min(x0, x), max(x1, x)
        y0, y1 = min(y0, y), max(y1, y)
        z0, z1 = min(z0, z), max(z1, z)
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    if dx >= dy and dx >= dz:
        return 0
    return 1 if dy >= dz else 2


@kernel
def _boxes(corners: Array, order: Ints, right: Ints, start: Ints, count: Ints) -> Array:
    """Bounds (k, 6) of the nodes, from the leaves up."""
    bounds = np.empty((len(right), 6))
    for node in range(len(right) - 1, -1, -1):
        if right[node] >= 0:
            left, other = node + 1, right[node]
            for a in range(3):
                bounds[node, a] = min(bounds[left, a], bounds[other, a])
                bounds[node, 3 + a] = max(bounds[left, 3 + a], bounds[other, 3 + a])
            continue
        bounds[node, :3], bounds[node, 3:] = np.inf, -np.inf
        for t in range(start[node], start[node] + count[node]):
            f = order[t]
            for v in range(3):
                for a in range(3):
                    bounds[node, a] = min(bounds[node, a], corners[f, v, a])
                    bounds[node, 3 + a] = max(bounds[node, 3 + a], corners[f, v, a])
    return bounds


def build(corners: Array) -> tuple[Ints, Array, Ints, Ints, Ints]:
    """Tree over triangles ``corners`` (m, 3, 3): (order, bounds (k, 6), right, start, count)."""
    m = len(corners)
    order, centres = np.arange(m), _centres(corners)
    # The first halves one after the other, then what they leave side by side.
    parts = _halve(centres, order, 0, m, max(m // 8, PART))
    in_blocks(lambda i, _: _halve(centres, order, parts[i], parts[i + 1], LEAF), len(parts) - 1, 1)
    right, start, count = _nodes(m)
    return order, _boxes(corners, order, right, start, count), right, start, count


@kernel
def _centres(corners: Array) -> Singles:
    """Three times the middles (m, 3), as precise as sorting asks for."""
    centres = np.empty((corners.shape[0], 3), np.float32)
    for f in range(corners.shape[0]):
        for a in range(3):
            centres[f, a] = corners[f, 0, a] + corners[f, 1, a] + corners[f, 2, a]
    return centres


@kernel
def _halve(centres: Singles, order: Ints, first: int, last: int, most: int) -> Ints:
    """Halve ``first:last`` again and again until no part has more than ``most``; where parts begin, and the end."""
    todo = np.empty((2 * DEPTH, 2), np.int64)
    parts = np.empty(2 + (last - first) // ((most + 1) // 2), np.int64)
    todo[0, 0], todo[0, 1] = first, last
    top, n = 1, 0
    while top > 0:
        top -= 1
        lo, hi = todo[top, 0], todo[top, 1]
        if hi - lo <= most:
            parts[n] = lo
            n += 1
            continue
        mid = (lo + hi) // 2
        _select(centres, order, _widest(centres, lo, hi), lo, hi, mid)
        todo[top, 0], todo[top, 1] = mid, hi
        todo[top + 1, 0], todo[top + 1, 1] = lo, mid
        top += 2
    parts[n] = last
    return parts[: n + 1]


@kernel
def _nodes(m: int) -> tuple[Ints, Ints, Ints]:
    """The nodes of halves upon halves of m triangles, depth first: right children, and the ranges of all nodes."""
    right = np.full(2 * m + 1, -1)
    start = np.zeros(2 * m + 1, np.int64)
    count = np.zeros(2 * m + 1, np.int64)
    todo = np.empty((2 * DEPTH, 3), np.int64)  # range and the parent whose right child this is
    todo[0, 0], todo[0, 1], todo[0, 2] = 0, m, -1
    top, nodes = 1, 0
    while top > 0:
        top -= 1
        lo, hi, parent = todo[top, 0], todo[top, 1], todo[top, 2]
        node = nodes
        nodes += 1
        if parent >= 0:
            right[parent] = node
        start[node], count[node] = lo, hi - lo
        if hi - lo <= LEAF:
            continue
        mid = (lo + hi) // 2
        todo[top, 0], todo[top, 1], todo[top, 2] = mid, hi, node
        todo[top + 1, 0], todo[top + 1, 1], todo[top + 1, 2] = lo, mid, -1
        top += 2
    return right[:nodes].copy(), start[:nodes].copy(), count[:nodes].copy()


@part
def _box_distance2(bounds: Array, node: int, x: float, y: float, z: float) -> Any:
    dx = max(max(bounds[node, 0] - x, x - bounds[node, 3]), 0.0)
    dy = max(max(bounds[node, 1] - y, y - bounds[node, 4]), 0.0)
    dz = max(max(bounds[node, 2] - z, z - bounds[node, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@part
def closest_on_triangle(tri: Array, x: float, y: float, z: float) -> tuple[float, float, float, int]:
    """Nearest point of triangle ``tri`` (3, 3) to (x, y, z) and the feature it lies on.

    Regions of the triangle's Voronoi diagram, after Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    ax, ay, az = tri[0, 0], tri[0, 1], tri[0, 2]
    abx, aby, abz = tri[1, 0] - ax, tri[1, 1] - ay, tri[1, 2] - az
    acx, acy, acz = tri[2, 0] - ax, tri[2, 1] - ay, tri[2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    d1 = abx * px + aby * py + abz * pz
    d2 = acx * px + acy * py + acz * pz
    if d1 <= 0.0 and d2 <= 0.0:
        return ax, ay, az, VERTEX_A
    qx, qy, qz = x - tri[1, 0], y - tri[1, 1], z - tri[1, 2]
    d3 = abx * qx + aby * qy + abz * qz
    d4 = acx * qx + acy * qy + acz * qz
    if d3 >= 0.0 and d4 <= d3:
        return tri[1, 0], tri[1, 1], tri[1, 2], VERTEX_B
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        return ax + v * abx, ay + v * aby, az + v * abz, EDGE_AB
    rx, ry, rz = x - tri[2, 0], y - tri[2, 1], z - tri[2, 2]
    d5 = abx * rx + aby * ry + abz * rz
    d6 = acx * rx + acy * ry + acz * rz
    if d6 >= 0.0 and d5 <= d6:
        return tri[2, 0], tri[2, 1], tri[2, 2], VERTEX_C
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
        return ax + w * acx, ay + w * acy, az + w * acz, EDGE_CA
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return (
            tri[1, 0] + w * (tri[2, 0] - tri[1, 0]),
            tri[1, 1] + w * (tri[2, 1] - tri[1, 1]),
            tri[1, 2] + w * (tri[2, 2] - tri[1, 2]),
            EDGE_BC,
        )
    denom = 1.0 / (va + vb + vc)
    v, w = vb * denom, vc * denom
    return ax + abx * v + acx * w, ay + aby * v + acy * w, az + abz * v + acz * w, FACE


@part
def nearest_one(
    x: float,
    y: float,
    z: float,
    hint: int,
    tree: Tree,
    stack: Ints,
    stack_d: Array,
) -> tuple[float, float, float, int, int]:
    """Nearest point to (x, y, z) over all triangles: (cx, cy, cz, slot, feature).

    ``corners`` are in tree order; ``hint`` is a slot to try first, or -1. Among equally near triangles the first
    one met wins.
    """
    corners, bounds, right, start, number = tree.corners, tree.bounds, tree.right, tree.start, tree.number
    best, bx, by, bz, slot, feature = np.inf, 0.0, 0.0, 0.0, -1, -1
    if hint >= 0:
        bx, by, bz, feature = closest_on_triangle(corners[hint], x, y, z)
        best = (x - bx) ** 2 + (y - by) ** 2 + (z - bz) ** 2
        slot = hint
    stack[0], stack_d[0] = 0, _box_distance2(bounds, 0, x, y, z)
    top = 1
    while top > 0:
        top -= 1
        if stack_d[top] >= best:
            continue
        node = stack[top]
        while right[node] >= 0:
            a, b = node + 1, right[node]
            da = _box_distance2(bounds, a, x, y, z)
            db = _box_distance2(bounds, b, x, y, z)
            if db < da:
                a, b, da, db = b, a, db, da
            if db < best:
                stack[top], stack_d[top] = b, db
                top += 1
            if da >= best:
                node = -1
                break
            node = a
        if node < 0:
            continue
        for t in range(start[node], start[node] + number[node]):
            cx, cy, cz, f = closest_on_triangle(corners[t], x, y, z)
            d = (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2
            if d < best:
                best, bx, by, bz, slot, feature = d, cx, cy, cz, t, f
    return bx, by, bz, slot, feature


@part
def _hit(tri: Array, o: Array, d: Array) -> float:
    """Distance along the ray to a triangle, in lengths of d; -1: none.

    Moller and Trumbore's test (J. Graphics Tools 2, 1997), its edges widened by 1e-12 so that no ray slips between
    two neighbours.
    """
    ax, ay, az = tri[1, 0] - tri[0, 0], tri[1, 1] - tri[0, 1], tri[1, 2] - tri[0, 2]
    bx, by, bz = tri[2, 0] - tri[0, 0], tri[2, 1] - tri[0, 1], tri[2, 2] - tri[0, 2]
    hx, hy, hz = d[1] * bz - d[2] * by, d[2] * bx - d[0] * bz, d[0] * by - d[1] * bx
    det = ax * hx + ay * hy + az * hz
    if det == 0.0:
        return -1.0
    sx, sy, sz = o[0] - tri[0, 0], o[1] - tri[0, 1], o[2] - tri[0, 2]
    u = (sx * hx + sy * hy + sz * hz) / det
    if u < -1e-12 or u > 1.0 + 1e-12:
        return -1.0
    qx, qy, qz = sy * az - sz * ay, sz * ax - sx * az, sx * ay - sy * ax
    v = (d[0] * qx + d[1] * qy + d[2] * qz) / det
    if v < -1e-12 or u + v > 1.0 + 1e-12:
        return -1.0
    return float((bx * qx + by * qy + bz * qz) / det)


@part
def _reciprocal(x: float) -> float:
    return np.inf if x == 0.0 else 1.0 / x  # of -0 too


@part
def _met(bounds: Array, node: int, x: float, y: float, z: float, u: float, v: float, w: float, best: float) -> Any:
    """Where a ray from (x, y, z) enters a node's box, in its lengths; inf: nowhere, or beyond ``best``.

    (u, v, w) are the reciprocals of its direction, plus infinity for zero: where it runs in one of a box's planes, zero
    times infinity is no number, every comparison with that is false, and the ray counts as inside.
    """
    near, far = 0.0, best
    one, two = (bounds[node, 0] - x) * u, (bounds[node, 3] - x) * u
    one, two = (two, one) if one > two else (one, two)
    near, far = (one if one > near else near), (two if two < far else far)
    one, two = (bounds[node, 1] - y) * v, (bounds[node, 4] - y) * v
    one, two = (two, one) if one > two else (one, two)
    near, far = (one if one > near else near), (two if two < far else far)
    one, two = (bounds[node, 2] - z) * w, (bounds[node, 5] - z) * w
    one, two = (two, one) if one > two else (one, two)
    near, far = (one if one > near else near), (two if two < far else far)
    return near if near <= far * (1.0 + 1e-14) + 1e-300 else np.inf


@part
def ray_one(
    o: Array,
    d: Array,
    hint: int,
    tree: Tree,
    stack: Ints,
) -> tuple[float, int]:
    """First hit along a ray, either side of a triangle: (distance in lengths of d, slot); inf and -1: none.

    ``hint`` is a slot to try first, or -1. Of triangles hit at the same distance the one of the least slot is told.
    """
    corners, bounds, right, start, number = tree.corners, tree.bounds, tree.right, tree.start, tree.number
    best, slot = np.inf, -1
    x, y, z, u, v, w = o[0], o[1], o[2], _reciprocal(d[0]), _reciprocal(d[1]), _reciprocal(d[2])
    if hint >= 0:
        along = _hit(corners[hint], o, d)
        if along >= 0.0:
            best, slot = along, hint
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if _met(bounds, node, x, y, z, u, v, w, best) == np.inf:
            continue
        while node >= 0 and right[node] >= 0:
            a, b = node + 1, right[node]
            one = _met(bounds, a, x, y, z, u, v, w, best)
            two = _met(bounds, b, x, y, z, u, v, w, best)
            if two < one:
                a, b, one, two = b, a, two, one
            if two < np.inf:
                stack[top] = b
                top += 1
            node = a if one < np.inf else -1
        if node < 0:
            continue
        for t in range(start[node], start[node] + number[node]):
            along = _hit(corners[t], o, d)
            if along >= 0.0 and (along < best or (along == best and t < slot)):
                best, slot = along, t
    return best, slot


@kernel
def ray_many(
    origins: Array,
    directions: Array,
    corners: Array,
    bounds: Array,
    right: Ints,
    start: Ints,
    count: Ints,
    hit: Array,
    slots: Ints,
) -> None:
    """First hit along each ray into ``hit`` and ``slots``; see ``ray_one``. Best in an order of neighbours."""
    stack, last, tree = np.empty(DEPTH, np.int64), -1, Tree(corners, bounds, right, start, count)
    for i in range(origins.shape[0]):
        hit[i], slots[i] = ray_one(origins[i], directions[i], last, tree, stack)
        last = slots[i]
