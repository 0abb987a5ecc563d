"""Nearest points of many at once: every one proven, on the tree's oriented boxes.

Close above a surface upright boxes are at their worst: the sphere around a point that touches the surface reaches
hundreds of them. A box that lies in the plane of its triangles is thin, and a sphere reaches few of these.

What is found is the least of (squared distance, place in the tree) over all triangles. It does not depend on where a
search begins; that the triangle of the point before is tried first makes it short.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.threads import in_blocks

from .bvh import DEPTH, closest_on_triangle

#: Rounding of a distance, as a share of the coordinates it is made of: no box that may be nearer is left out.
ROUNDING = 1e-14


#: Above so many triangles a node's box is upright: no plane is near them all.
_PATCH = 1024


def oriented_boxes(corners: Array, bounds: Array, right: Ints, start: Ints, count: Ints) -> Array:
    """Boxes (k, 15) around the nodes' triangles: their middle, half sizes, and the three axes.

    The first axis is the mean normal of the triangles, the second lies along the coordinate axis that the normal
    leaves most. ``corners`` (m, 3, 3) are in tree order, ``bounds`` (k, 6) are the upright boxes.
    """
    boxes = np.empty((len(right), 15))
    room = 2.0 * ROUNDING * float(np.abs(bounds[0]).max())
    in_blocks(lambda first, last: _fit(corners, bounds, start, count, room, boxes, first, last), len(right), 20_000)
    return boxes


@kernel
def _fit(
    corners: Array,
    bounds: Array,
    start: Ints,
    count: Ints,
    room: float,
    boxes: Array,
    first: int,
    last: int,
) -> None:
    """Fill ``boxes`` of the nodes ``first:last``."""
    axes, normal, low, high = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    for node in range(first, last):
        begin, end = start[node], start[node] + count[node]
        if count[node] > _PATCH:
            for a in range(3):
                boxes[node, a] = 0.5 * (bounds[node, a] + bounds[node, 3 + a])
                boxes[node, 3 + a] = 0.5 * (bounds[node, 3 + a] - bounds[node, a]) + room
                for b in range(3):
                    boxes[node, 6 + 3 * a + b] = 1.0 if a == b else 0.0
            continue
        normal[:] = 0.0
        for t in range(begin, end):
            _add_normal(corners[t], normal)
        _axes(normal, axes)
        x0, y0, z0 = corners[begin, 0, 0], corners[begin, 0, 1], corners[begin, 0, 2]
        low[:], high[:] = 0.0, 0.0
        for t in range(begin, end):
            for v in range(3):
                x, y, z = corners[t, v, 0] - x0, corners[t, v, 1] - y0, corners[t, v, 2] - z0
                for a in range(3):
                    along = axes[a, 0] * x + axes[a, 1] * y + axes[a, 2] * z
                    low[a], high[a] = min(low[a], along), max(high[a], along)
        for b in range(3):
            boxes[node, b] = corners[begin, 0, b]
            for a in range(3):
                boxes[node, b] += 0.5 * (low[a] + high[a]) * axes[a, b]
            boxes[node, 3 + b] = 0.5 * (high[b] - low[b]) + room
            for a in range(3):
                boxes[node, 6 + 3 * b + a] = axes[b, a]


@part
def _add_normal(tri: Array, out: Array) -> None:
    """Add the normal of a triangle, twice its area long."""
    ux, uy, uz = tri[1, 0] - tri[0, 0], tri[1, 1] - tri[0, 1], tri[1, 2] - tri[0, 2]
    vx, vy, vz = tri[2, 0] - tri[0, 0], tri[2, 1] - tri[0, 1], tri[2, 2] - tri[0, 2]
    out[0] += uy * vz - uz * vy
    out[1] += uz * vx - ux * vz
    out[2] += ux * vy - uy * vx


@part
def _axes(normal: Array, axes: Array) -> None:
    """Three unit axes, the first along ``normal`` (3,), or z where that is zero."""
    size = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    n = axes[0]
    n[0], n[1], n[2] = 0.0, 0.0, 1.0
    if size > 0.0:
        n[0], n[1], n[2] = normal[0] / size, normal[1] / size, normal[2] / size
    least = 0
    for a in range(1, 3):
        if abs(n[a]) < abs(n[least]):
            least = a
    size = np.sqrt(1.0 - n[least] ** 2)
    for a in range(3):
        axes[1, a] = ((1.0 if a == least else 0.0) - n[least] * n[a]) / size
    u, w = axes[1], axes[2]
    w[0], w[1], w[2] = n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]


@part
def _beyond(boxes: Array, node: int, x: float, y: float, z: float) -> Any:
    """Squared distance to an oriented box."""
    x, y, z = x - boxes[node, 0], y - boxes[node, 1], z - boxes[node, 2]
    a = abs(boxes[node, 6] * x + boxes[node, 7] * y + boxes[node, 8] * z) - boxes[node, 3]
    b = abs(boxes[node, 9] * x + boxes[node, 10] * y + boxes[node, 11] * z) - boxes[node, 4]
    c = abs(boxes[node, 12] * x + boxes[node, 13] * y + boxes[node, 14] * z) - boxes[node, 5]
    a = a if a > 0.0 else 0.0
    b = b if b > 0.0 else 0.0
    c = c if c > 0.0 else 0.0
    return a * a + b * b + c * c


@kernel
def nearest_in_turn(
    points: Array,
    hints: Ints,
    corners: Array,
    boxes: Array,
    right: Ints,
    start: Ints,
    count: Ints,
    closest: Array,
    slots: Ints,
    features: Ints,
) -> None:
    """Nearest points of ``points`` (n, 3), each best near the one before; fills ``closest``, ``slots``, ``features``.

    ``hints`` (n,) are places in the tree to try first, -1: none.
    """
    stack, stack_d = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    slot = -1
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        rounding = ROUNDING * (abs(x) + abs(y) + abs(z))
        best, bx, by, bz, feature = np.inf, 0.0, 0.0, 0.0, -1
        last, slot = slot, -1
        for hint in (last, hints[i]):
            if hint >= 0:
                cx, cy, cz, f = closest_on_triangle(corners[hint], x, y, z)
                d = (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2
                if d < best or (d == best and hint < slot):
                    best, bx, by, bz, slot, feature = d, cx, cy, cz, hint, f
        # What lies this far may still be as near, to rounding.
        limit = (np.sqrt(best) * (1.0 + ROUNDING) + rounding) ** 2
        stack[0], stack_d[0], top = 0, 0.0, 1
        while top > 0:
            top -= 1
            if stack_d[top] > limit:
                continue
            node = stack[top]
            while node >= 0 and right[node] >= 0:
                a, b = node + 1, right[node]
                da, db = _beyond(boxes, a, x, y, z), _beyond(boxes, b, x, y, z)
                if db < da:
                    a, b, da, db = b, a, db, da
                if db <= limit:
                    stack[top], stack_d[top] = b, db
                    top += 1
                node = a if da <= limit else -1
            if node < 0:
                continue
            for t in range(start[node], start[node] + count[node]):
                cx, cy, cz, f = closest_on_triangle(corners[t], x, y, z)
                d = (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2
                if d < best or (d == best and t < slot):
                    best, bx, by, bz, slot, feature = d, cx, cy, cz, t, f
                    limit = (np.sqrt(best) * (1.0 + ROUNDING) + rounding) ** 2
        closest[i, 0], closest[i, 1], closest[i, 2] = bx, by, bz
        slots[i], features[i] = slot, feature
