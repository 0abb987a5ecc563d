"""A start outside the mold, found by itself, and the passage from a coarse grid to a fine one."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.threads import in_rows
from hyperfab.surface.bvh import DEPTH, nearest_one, ray_many

from .energy import ROWS
from .landing import landed
from .mold import FREE, ON_FACE, Mold, States
from .net import Sheet, Z
from .state import State

#: A node lifted onto the mold is on it within so many mm.
ON_TOP = 1e-9


@kernel
def place(
    x: Array,
    mold: Mold,
    skin: Array,
    fixed: np.ndarray,
    contact: States,
    slot: Ints,
    clear: Array,
    first: int,
    last: int,
) -> tuple[int, float]:
    """Set nodes of rows ``first:last`` that are inside the mold, or nearer than their ``skin`` mm, onto it.

    ``clear`` comes with a distance known to be free of the mold (0: not known), which saves the search, and ``slot``
    with a facet near by or -1. Returns a held node inside the mold (flat index, -1: none) and its depth.
    """
    stack, stack_d = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    hint = np.int64(-1)  # a literal would make the search compile twice
    bad, deepest, y = -1, 0.0, np.empty(3)
    for i in range(first, last):
        for j in range(x.shape[1]):
            p = x[i, j]
            contact[i, j] = FREE
            if clear[i, j] > skin[i, j] and clear[i, j] > 0.0:
                continue
            if slot[i, j] >= 0:
                hint = slot[i, j]
            cx, cy, cz, near, feature = nearest_one(p[0], p[1], p[2], hint, mold, stack, stack_d)
            hint = near
            n = mold.normals[near, feature]
            dx, dy, dz = p[0] - cx, p[1] - cy, p[2] - cz
            distance = np.sqrt(dx * dx + dy * dy + dz * dz)
            inside = dx * n[0] + dy * n[1] + dz * n[2] < 0.0
            slot[i, j], clear[i, j] = near, distance
            if fixed[i, j] & Z:  # held in the sheet's plane: it cannot be set onto the mold
                if inside and distance > 1e-9 and distance > deepest:
                    bad, deepest = i * x.shape[1] + j, distance
            elif inside or distance <= skin[i, j]:
                y[0], y[1], y[2] = p[0], p[1], p[2]
                p[0], p[1], p[2] = cx, cy, cz
                contact[i, j], clear[i, j] = ON_FACE + landed(mold, near, feature, y, p), 0.0
    return bad, deepest


class HeldNodeInside(Exception):
    """A node that is held in the sheet's plane would be inside the mold."""

    def __init__(self, node: tuple[int, int], depth: float) -> None:
        super().__init__(f"held node {node} is {depth:.3g} mm inside the mold")
        self.node, self.depth = node, depth


def settled(
    x: Array,
    mold: Mold,
    sheet: Sheet,
    skin: Array | None = None,
    known: tuple[Array, Ints] | None = None,
) -> State:
    """State of nodes at ``x``, put onto the mold where they are in it or nearer than ``skin`` (n, m)."""
    n, m = x.shape[:2]
    skin = np.zeros((n, m)) if skin is None else skin
    clear, slot = known or (np.zeros((n, m)), np.full((n, m), -1))
    state = State(x.copy(), np.zeros((n, m), np.int8), slot, clear, np.zeros((n, m), np.int8))
    fixed = sheet.fixed
    inside: list[tuple[float, int]] = []

    def work(first: int, last: int) -> None:
        bad, depth = place(state.x, mold, skin, fixed, state.contact, state.slot, state.clear, first, last)
        if bad >= 0:
            inside.append((depth, -bad))

    in_rows(work, n, m)
    if inside:
        depth, bad = max(inside)
        raise HeldNodeInside(divmod(-bad, m), depth)
    return state


def lowered(sheet: Sheet, mold: Mold) -> State:
    """Flat sheet with every node that is below the mold's upper skin lifted onto it.

    This is the sheet lowered from above the mold straight down: all nodes end outside, whatever the mold.
    """
    x = sheet.flat()
    points = x.reshape(-1, 3).copy()
    above = mold.bounds[0, 5] + 1.0
    points[:, 2] = above
    t, slots = np.empty(len(points)), np.empty(len(points), np.int64)
    down = np.zeros_like(points)
    down[:, 2] = -1.0
    for i in range(0, len(points), ROWS):
        s = slice(i, i + ROWS)
        ray_many(
            points[s],
            down[s],
            mold.corners,
            mold.bounds,
            mold.right,
            mold.start,
            mold.number,
            t[s],
            slots[s],
        )
    top = np.where(np.isfinite(t), above - t, -np.inf).reshape(sheet.n, sheet.m)
    free = (sheet.fixed & 4) == 0
    lifted = free & (top > 0.0)
    x[:, :, 2] = np.where(lifted, top, 0.0)
    # What was lifted lies on the mold: a node on a tip is held there by its cone of normals.
    return settled(x, mold, sheet, np.where(lifted, ON_TOP, 0.0))


def refined(coarse: State, sheet: Sheet, mold: Mold) -> State:
    """A coarse grid's state on the finer grid of ``sheet``, by cubic interpolation, nodes kept outside the mold.

    Nodes amid coarse nodes that are all on the mold are put on it too.
    """
    n, m = sheet.n, sheet.m
    nc, mc = coarse.x.shape[:2]
    a, b = _interpolation(nc, n, True), _interpolation(mc, m, True)
    x = np.empty((n, m, 3))
    for k in range(3):
        x[:, :, k] = (b @ (a @ coarse.x[:, :, k]).T).T
    touching = (coarse.contact != FREE).astype(float)
    # Kernels are compiled for C order; what numpy makes of another, it decides by the size of the array.
    touch = np.ascontiguousarray((_interpolation(mc, m, False) @ (_interpolation(nc, n, False) @ touching).T).T)
    fixed, flat = sheet.fixed, sheet.flat()
    for axis in range(3):
        held = (fixed >> axis) & 1 == 1
        x[held, axis] = flat[held, axis]
    # Between touching nodes the interpolation leaves the sheet just off a convex mold.
    skin = np.where((touch > 1.0 - 1e-9) & (fixed == 0), 0.5 * max(sheet.spacing), 0.0)
    # A fine node's distance from the mold is at least its coarse neighbour's less the way between them.
    i, j = (np.rint(np.linspace(0, k - 1, f)).astype(int) for k, f in ((nc, n), (mc, m)))
    near = np.ix_(i, j)
    clear = np.maximum(coarse.clear[near] - np.linalg.norm(x - coarse.x[near], axis=2), 0.0)
    return settled(x, mold, sheet, skin, (clear, coarse.slot[near]))


def _interpolation(coarse: int, fine: int, cubic: bool) -> csr_array:
    """(fine, coarse) weights between evenly spaced nodes: four-point Lagrange, or linear."""
    at = np.linspace(0.0, coarse - 1.0, fine)
    width = 4 if cubic and coarse >= 4 else 2
    first = np.clip(np.floor(at).astype(int) - (width // 2 - 1), 0, coarse - width)
    columns = first[:, None] + np.arange(width)
    weights = np.ones((fine, width))
    for k in range(width):
        for other in range(width):
            if other != k:
                weights[:, k] *= (at - columns[:, other]) / (k - other)
    rows = np.repeat(np.arange(fine), width)
    return csr_array((weights.ravel(), (rows, columns.ravel())), shape=(fine, coarse))
