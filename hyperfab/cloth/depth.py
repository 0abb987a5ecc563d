"""How deep points, straight ways and a net are in a mold, to a proven bound, and how far it stands out between nodes.

The depth of a point is its distance to the mold's surface where it is inside. Along a way it changes by no more than
the way (it is Lipschitz), and never exceeds the distance to any one facet, which is convex along the way: on a piece
it is at most the larger of the distances of both ends to the same facet. Pieces are halved until no bound is above the
deepest point found, so that nothing is missed between probes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.surface import Surface
from hyperfab.surface.bvh import DEPTH, closest_on_triangle, nearest_one

from .features import distance2
from .mold import Mold
from .net import Sheet
from .state import State

#: No mold has a slit this thin in front of a facet, in mm: what hovers lower above one is outside.
THIN = 1e-3
#: Pieces of a way that wait to be looked at, at most: they are halves of halves.
MOST_PIECES = 128


class Room(NamedTuple):
    """What a search along a way writes on: the tree's stack, and of each piece its ends' shares, depths and facets."""

    stack: Ints
    stack_d: Array
    shares: Array  # (p, 2)
    depths: Array  # (p, 2) mm
    facets: Ints  # (p, 2)
    points: Array  # (3, 3) mm


@part
def room() -> Room:
    """Room for searches one after the other."""
    return Room(
        np.empty(DEPTH, np.int64),
        np.empty(DEPTH),
        np.empty((MOST_PIECES, 2)),
        np.empty((MOST_PIECES, 2)),
        np.empty((MOST_PIECES, 2), np.int64),
        np.empty((3, 3)),
    )


@part
def _depth(mold: Mold, p: Array, hint: int, stack: Ints, stack_d: Array) -> tuple[float, int]:
    """Depth of a point, negative outside, and the facet nearest to it."""
    cx, cy, cz, near, feature = nearest_one(p[0], p[1], p[2], hint, mold, stack, stack_d)
    x, y, z, n = p[0] - cx, p[1] - cy, p[2] - cz, mold.normals[near, feature]
    away = np.sqrt(x * x + y * y + z * z)
    return (away if x * n[0] + y * n[1] + z * n[2] < 0.0 else -away), near


@part
def _to(mold: Mold, slot: int, p: Array) -> float:
    cx, cy, cz, _ = closest_on_triangle(mold.corners[slot], p[0], p[1], p[2])
    return np.sqrt((p[0] - cx) ** 2 + (p[1] - cy) ** 2 + (p[2] - cz) ** 2)


@part
def _above(mold: Mold, slot: int, a: Array, b: Array) -> bool:
    """Does the way from a to b run straight above a facet, less than THIN off it?"""
    corner, normal = mold.corners[slot, 0], mold.normals[slot, 0]
    for side in range(2):
        p = a if side == 0 else b
        height = 0.0
        for r in range(3):
            height += (p[r] - corner[r]) * normal[r]
        if height < 0.0 or height > THIN or _to(mold, slot, p) > height + 1e-12:
            return False
    return True


@part
def deepest_of(
    mold: Mold, start: Array, end: Array, hint: int, best: float, sure: float, work: Room
) -> tuple[float, float]:
    """Deepest point in the mold of the way from ``start`` to ``end`` (3): its depth, to ``sure`` mm, and the share of
    the way to it; (best, -1) where none is deeper than ``best`` mm. ``hint``: a facet near the start, or -1.
    """
    stack, stack_d, part_t, part_f, part_s, points = work
    a, b, middle = points[0], points[1], points[2]
    share, size = -1.0, np.sqrt(distance2(end, start))
    part_t[0, 0], part_t[0, 1] = 0.0, 1.0
    part_f[0, 0], part_s[0, 0] = _depth(mold, start, hint, stack, stack_d)
    part_f[0, 1], part_s[0, 1] = _depth(mold, end, part_s[0, 0], stack, stack_d)
    for side in range(2):
        if part_f[0, side] > best:
            best, share = part_f[0, side], float(side)
    top = 1
    while top > 0:
        top -= 1
        t0, t1, f0, f1 = part_t[top, 0], part_t[top, 1], part_f[top, 0], part_f[top, 1]
        s0, s1 = part_s[top, 0], part_s[top, 1]
        length = (t1 - t0) * size
        if length <= sure or 0.5 * (f0 + f1 + length) <= best + sure:
            continue
        t = 0.5 * (t0 + t1)
        for r in range(3):
            a[r] = start[r] + t0 * (end[r] - start[r])
            b[r] = start[r] + t1 * (end[r] - start[r])
            middle[r] = start[r] + t * (end[r] - start[r])
        if max(abs(f0), _to(mold, s0, b)) <= best + sure or max(_to(mold, s1, a), abs(f1)) <= best + sure:
            continue
        if _above(mold, s0, a, b) or _above(mold, s1, a, b):
            continue
        f, s = _depth(mold, middle, s0, stack, stack_d)
        if f > best:
            best, share = f, t
        if max(_to(mold, s, a), _to(mold, s, b)) <= best + sure:
            continue
        part_t[top, 0], part_t[top, 1], part_t[top + 1, 0], part_t[top + 1, 1] = t0, t, t, t1
        part_f[top, 0], part_f[top, 1], part_f[top + 1, 0], part_f[top + 1, 1] = f0, f, f, f1
        part_s[top, 0], part_s[top, 1], part_s[top + 1, 0], part_s[top + 1, 1] = s0, s, s, s1
        top += 2
    return best, share


@kernel
def deepest(starts: Array, ends: Array, slots: Ints, mold: Mold, best: float, sure: float) -> tuple[float, int, float]:
    """Deepest point in the mold of the segments ``starts`` to ``ends`` (k, 3), beyond ``best`` mm and to ``sure`` mm.

    ``slots``: a facet near each start, or -1. Returns its depth, its segment (-1: none is deeper than ``best``) and the
    share of the way to it.
    """
    where, share, work = -1, 0.0, room()
    for k in range(starts.shape[0]):
        depth, at = deepest_of(mold, starts[k], ends[k], slots[k], best, sure, work)
        if at >= 0.0:
            best, where, share = depth, k, at
    return best, where, share


#: The deepest point of a spring is found to this many mm.
SURE = 1e-6
#: Springs handled by one call of a kernel.
ROWS = 100_000


@dataclass(frozen=True)
class Cut:
    """Deepest point in the mold of nodes and of springs in mm, and where the latter is (flat sheet, draped)."""

    node: float
    edge: float
    flat: tuple[float, float]
    draped: tuple[float, float, float]


def cut(x: Array, sheet: Sheet, mold: Mold, state: State, bent: Ints, bent_at: Array) -> Cut:
    """How deep the net at ``x`` (n, m, 3) mm is in the mold, its springs to SURE mm.

    Springs laid over a sharp edge (``bent`` (k, 4), at ``bent_at`` (k, 3) mm) are taken as they run: two straight
    parts.
    """
    flat = sheet.flat()
    points, slots = x.reshape(-1, 3), state.slot.reshape(-1)
    near = np.flatnonzero(state.clear.reshape(-1) <= max(sheet.spacing))
    node = max(deepest(points[near], points[near], slots[near], mold, 0.0, SURE)[0], 0.0)
    best, where = 0.0, (flat[0, 0, :2], x[0, 0])
    number = np.arange(sheet.n * sheet.m).reshape(sheet.n, sheet.m)
    flat = flat.reshape(-1, 3)
    for direction in range(2):
        one = (number[:-1] if direction == 0 else number[:, :-1]).ravel()
        two = (number[1:] if direction == 0 else number[:, 1:]).ravel()
        own = bent[:, 2] == direction
        laid = np.isin(one, number[bent[own, 0], bent[own, 1]])
        room = state.clear.reshape(-1)[one] + state.clear.reshape(-1)[two]
        straight = ~laid & (room <= np.linalg.norm(points[two] - points[one], axis=1))
        first, last = (
            number[bent[own, 0], bent[own, 1]],
            number[bent[own, 0], bent[own, 1]] + (sheet.m if direction == 0 else 1),
        )
        for ends in (
            (one[straight], two[straight], points[one[straight]], points[two[straight]]),
            (first, last, points[first], bent_at[own]),
            (last, first, points[last], bent_at[own]),
        ):
            for i in range(0, len(ends[0]), ROWS):
                a, b, start, end = (np.ascontiguousarray(v[i : i + ROWS]) for v in ends)
                best, k, share = deepest(start, end, slots[a], mold, best, SURE)
                if k >= 0:
                    draped = start[k] + share * (end[k] - start[k])
                    along = share * _share(points[a[k]], end[k], points[b[k]])
                    where = (flat[a[k], :2] + along * (flat[b[k], :2] - flat[a[k], :2]), draped)
    at, draped = where
    return Cut(node, best, (float(at[0]), float(at[1])), (float(draped[0]), float(draped[1]), float(draped[2])))


def _share(start: Array, over: Array, end: Array) -> float:
    """Share of the way from ``start`` over a point to ``end`` that lies before the point."""
    one, two = float(np.linalg.norm(over - start)), float(np.linalg.norm(end - over))
    return one / max(one + two, 1e-300)


def vertices(mold: Mold) -> Array:
    """The mold's vertices (k, 3) mm."""
    return np.asarray(mold.corners.reshape(-1, 3)[np.unique(mold.vertex, return_index=True)[1]])


def stands_out(x: Array, sheet: Sheet, mold: Mold) -> tuple[float, Array, Array]:
    """How far in mm the mold's corners stand out through the net, between its nodes; where, draped and flat.

    The net at ``x`` (n, m, 3) mm is taken as triangles, four a cell about its middle (either diagonal alone would
    tell a mold from its mirror image), its outer side up. A corner beside the net, nearest to its rim, does not count.
    """
    n, m = sheet.n, sheet.m
    number = np.arange(n * m).reshape(n, m)
    a, b, c, d = (number[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    middle = n * m + np.arange(len(a))
    net = Surface(
        _with_middles(x),
        np.vstack([np.column_stack([*side, middle]) for side in ((a, b), (b, c), (c, d), (d, a))]),
    )
    corners = vertices(mold)
    high = corners[corners[:, 2] > x[:, :, 2].min()]
    none = (0.0, np.zeros(3), np.zeros(3))
    if not len(high):
        return none
    found = net.nearest(high)
    border = net.twins < 0
    at_rim = np.zeros(len(high), bool)
    on_edge = (found.feature >= 1) & (found.feature <= 3)
    at_rim[on_edge] = border[found.face[on_edge], found.feature[on_edge] - 1]
    at_vertex = found.feature > 3
    rim = np.zeros(len(net.vertices), bool)
    for side in (number[0], number[-1], number[:, 0], number[:, -1]):
        rim[side] = True
    at_rim[at_vertex] = rim[net.faces[found.face[at_vertex], found.feature[at_vertex] - 4]]
    depth = np.where(at_rim, 0.0, found.distance)
    k = int(depth.argmax())
    if depth[k] <= SURE:
        return none
    corner = net.faces[found.face[k]]
    flat = _with_middles(sheet.flat())[corner]
    weights = np.linalg.lstsq(
        np.vstack([net.vertices[corner].T, np.ones(3)]), np.append(found.point[k], 1.0), rcond=None
    )[0]
    return float(depth[k]), high[k], np.asarray(weights @ flat)


def _with_middles(x: Array) -> Array:
    """Nodes (n, m, 3) and then the middles of the cells, row by row, as (k, 3)."""
    middle = 0.25 * (x[:-1, :-1] + x[1:, :-1] + x[1:, 1:] + x[:-1, 1:])
    return np.concatenate([x.reshape(-1, 3), middle.reshape(-1, 3)])
