"""How deep a net's nodes and springs are in the mold, and how far the mold stands out between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.surface import Surface

from .depth import deepest
from .mold import Mold
from .net import Sheet
from .state import State

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
    return Cut(
        node, best, (float(at[0]), float(at[1])), (float(draped[0]), float(draped[1]), float(draped[2]))
    )


def _share(start: Array, over: Array, end: Array) -> float:
    """Share of the way from ``start`` over a point to ``end`` that lies before the point."""
    one, two = float(np.linalg.norm(over - start)), float(np.linalg.norm(end - over))
    return one / max(one + two, 1e-300)


def stands_out(x: Array, sheet: Sheet, surface: Surface, shift: Array) -> tuple[float, Array, Array]:
    """How far in mm the mold's corners stand out through the net, between its nodes; where, draped and flat.

    The net at ``x`` (n, m, 3) mm is taken as triangles, four a cell about its middle (either diagonal alone would
    tell a mold from its mirror image), its outer side up; ``shift`` puts ``surface`` in its frame. A corner beside the
    net, nearest to its rim, does not count.
    """
    n, m = sheet.n, sheet.m
    number = np.arange(n * m).reshape(n, m)
    a, b, c, d = (number[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    middle = n * m + np.arange(len(a))
    net = Surface(
        _with_middles(x),
        np.vstack([np.column_stack([*side, middle]) for side in ((a, b), (b, c), (c, d), (d, a))]),
    )
    corners = surface.vertices + shift
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
