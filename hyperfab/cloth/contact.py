"""Contact of the net's nodes with a mold, decided and not penalised: a node is outside or on the surface.

A node on a face keeps the tangential part of its force; on an edge or vertex the cone of normals decides: it rests
there while the force presses into the cone of the facets' normals, however little it leans from their axis, else it
goes on to the facet that lets it follow the force, or leaves. A node leaves when the force points outward.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.surface.bvh import DEPTH, nearest_one, ray_one

from .creases import over_edge
from .features import FLAT, borne, copy, distance2, dot, edge_reached, outward, unfold, valley
from .galerkin import times
from .landing import landed, ridge_at, sharp_edge_at
from .mold import FREE, ON_FACE, SHARP, Mold
from .net import Arrays
from .pinning import pinned
from .state import State

#: Share of the mold's size beyond which a step may lead through it, or along a tangent to nowhere.
LONG = 1e-3
#: Facets that may meet at a tip.
MOST_FACETS = 65536


class Laid(NamedTuple):
    """Springs over sharp edges: ``springs`` (b, 4), their frames ``ways`` (b, 13), and ``hinges`` (n, m, 2), those of
    each node; empty without sharp edges."""

    springs: Ints
    ways: Array
    hinges: Ints


@kernel
def move(  # noqa: C901
    now: State,
    d: Array,
    alpha: float,
    mold: Mold,
    out: State,
    laid: Laid,
    first: int,
    last: int,
) -> None:
    """Nodes of rows ``first:last`` moved by ``alpha d`` and set back onto the mold where they are on or in it.

    A node that goes over the same edge twice in a row (``crossed``) stops on it; at 2 it stops in valleys too.
    ``clear`` is a distance below which a free node's ball holds no part of the mold: most free nodes need no search.
    """
    x, state, slot, clear, crossed = now
    xt, state_t, slot_t, clear_t, crossed_t = out
    bent, ways, hinges = laid
    m = x.shape[1]
    stack, stack_d = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    y, u, begin = np.empty(3), np.empty(3), np.empty(3)
    long = LONG * np.sqrt(distance2(mold.bounds[0, 3:], mold.bounds[0, :3]))
    for i in range(first, last):
        for j in range(m):
            way = 0.0
            for k in range(3):
                step = alpha * d[i, j, k]
                way += step * step
                y[k] = x[i, j, k] + step
                xt[i, j, k] = y[k]
            state_t[i, j], slot_t[i, j], clear_t[i, j] = state[i, j], slot[i, j], clear[i, j]
            if way == 0.0:
                continue
            way = np.sqrt(way)
            crossed_t[i, j] = 0
            turned = False
            if ways.shape[0] > 0:
                stop = crossed[i, j] > 0
                c = over_edge(bent, ways, mold.creases, hinges[i, j], x[i, j], y, stop)
                if c < 0:
                    for k in range(3):
                        xt[i, j, k] = y[k]
                    slot_t[i, j], edge = mold.creases.facet[-c - 1, 0], mold.creases.facet[-c - 1, 1]
                    state_t[i, j], clear_t[i, j] = ON_FACE + 1 + edge, 0.0
                    continue
                turned = c > 0
                crossed_t[i, j] = 1 if turned else 0
            if not turned and state[i, j] == FREE and clear[i, j] > way:
                clear_t[i, j] -= way
                continue
            hint = slot[i, j]
            if not turned and state[i, j] == ON_FACE:
                edge, s = edge_reached(mold, slot[i, j], x[i, j], y, u)
                if edge < 0:  # it stays on its flat facet
                    a, n = mold.corners[slot[i, j], 0], mold.normals[slot[i, j], 0]
                    off = (y[0] - a[0]) * n[0] + (y[1] - a[1]) * n[1] + (y[2] - a[2]) * n[2]
                    for k in range(3):
                        xt[i, j, k] = y[k] - off * n[k]
                    if mold.creases.corners.shape[0] > 0:
                        state_t[i, j] = ON_FACE + 1 + sharp_edge_at(mold, slot[i, j], xt[i, j])
                    continue
                turn = mold.turn[slot[i, j], edge]
                if (turn > SHARP and crossed[i, j] > 0) or (turn < -FLAT and crossed[i, j] > 1):
                    for k in range(3):
                        xt[i, j, k] = x[i, j, k] + s * (y[k] - x[i, j, k])
                    state_t[i, j] = ON_FACE + 1 + edge
                    continue
                if turn > SHARP:
                    crossed_t[i, j] = 1
                    hint = unfold(mold, slot[i, j], edge, x[i, j], y, s)
            cx, cy, cz, near, feature = nearest_one(y[0], y[1], y[2], hint, mold, stack, stack_d)
            away = np.sqrt((y[0] - cx) ** 2 + (y[1] - cy) ** 2 + (y[2] - cz) ** 2)
            n = mold.normals[near, feature]
            inside = (y[0] - cx) * n[0] + (y[1] - cy) * n[1] + (y[2] - cz) * n[2] <= 0.0
            if turned:
                slot_t[i, j] = near
                if not inside and away > 1e-9:
                    for k in range(3):
                        xt[i, j, k] = y[k]
                    state_t[i, j], clear_t[i, j] = FREE, away
                    continue
            elif state[i, j] == FREE and way > long:
                # A long step may lead through the mold: the node stops where it meets it, beyond where it is.
                for k in range(3):
                    u[k] = y[k] - x[i, j, k]
                    begin[k] = x[i, j, k] + 1e-9 / way * u[k]
                t, met = ray_one(begin, u, near, mold, stack)
                if t < 1.0 and (not inside or away > 0.1 * way):
                    for k in range(3):
                        xt[i, j, k] = begin[k] + t * u[k]
                    slot_t[i, j], clear_t[i, j] = met, 0.0
                    state_t[i, j] = ON_FACE + ridge_at(mold, met, xt[i, j], xt[i, j])
                    continue
            slot_t[i, j] = near
            if not turned and state[i, j] == FREE and not inside:
                clear_t[i, j] = away
                continue
            if not turned and state[i, j] != FREE and way > long and away > 0.5 * way:
                for k in range(3):  # too far along the tangent to tell where on the mold it leads: stay
                    xt[i, j, k] = x[i, j, k]
                slot_t[i, j] = slot[i, j]
                continue
            xt[i, j, 0], xt[i, j, 1], xt[i, j, 2] = cx, cy, cz
            feature = landed(mold, near, feature, y, xt[i, j])
            if feature == 0 and mold.creases.corners.shape[0] > 0:
                feature = 1 + sharp_edge_at(mold, near, xt[i, j])
            state_t[i, j], clear_t[i, j] = ON_FACE + feature, 0.0


@part
def _projector(bits: int, normals: Array, count: int, q: Array) -> None:
    """q (6): projector off the fixed axes and off the first ``count`` of ``normals`` (overwritten)."""
    q[0], q[1], q[2], q[3], q[4], q[5] = 1.0, 0.0, 0.0, 1.0, 0.0, 1.0
    v = np.empty(3)
    for c in range(3 + count):
        if c < 3:
            if not (bits >> c) & 1:
                continue
            v[0], v[1], v[2] = 0.0, 0.0, 0.0
            v[c] = 1.0
        else:
            copy(normals[c - 3], v)
        a, b, d = times(q, v[0], v[1], v[2])
        length2 = a * a + b * b + d * d
        if length2 < 1e-18:
            continue
        q[0] -= a * a / length2
        q[1] -= a * b / length2
        q[2] -= a * d / length2
        q[3] -= b * b / length2
        q[4] -= b * d / length2
        q[5] -= d * d / length2
    if q[0] + q[3] + q[5] < 0.5:
        for k in range(6):
            q[k] = 0.0


@kernel
def settle(
    now: State,
    f: Array,
    rubbed: Array,
    mold: Mold,
    net: Arrays,
    laid: Laid,
    fixed: npt.NDArray[np.uint8],
    slack: float,
    before: Ints,
    q: Array,
    r: Array,
    press: Array,
    start: int,
    end: int,
) -> tuple[float, int, int, int, int]:
    """Decide the contact of every node of rows ``start:end`` under the forces f.

    ``rubbed``: the forces with friction, by which a node keeps an edge or vertex that is not sharp, or goes on over it.
    Fills the projectors ``q``, the unbalanced force ``r`` and the normal force ``press`` (n, m) N; nodes are let go
    when the force points outward by more than ``slack`` N, or presses a membrane on a flat with less. ``before`` is the
    slot of each node before the last move.
    Returns the largest unbalanced force, its node (flat index), the number of nodes on the mold, how many were let
    go, and how many were put onto a valley's line or off a sharp edge, so that the forces are no longer theirs.
    """
    x, state, slot, clear, _ = now
    bent, ways, hinges = laid
    m = x.shape[1]
    slots = np.empty(MOST_FACETS, np.int64)
    t, u = np.empty(3), np.empty(3)
    normals = np.empty((2, 3))
    worst, where, contacts, changed, moved = 0.0, 0, 0, 0, 0
    # Beside a sharp edge a membrane may rise off a flat facet that it does not press on. Were its nodes held until they
    # are pulled off, one row of them a step would follow the row before.
    least = -slack if net.tension.shape[0] > 0 else slack
    for i in range(start, end):
        for j in range(m):
            press[i, j] = 0.0
            bits = int(fixed[i, j])
            if bits == 7:
                for k in range(6):
                    q[i, j, k] = 0.0
                r[i, j, 0], r[i, j, 1], r[i, j, 2] = 0.0, 0.0, 0.0
                continue
            s = int(state[i, j])
            if s > ON_FACE and s <= ON_FACE + 3 and abs(mold.turn[slot[i, j], s - ON_FACE - 1]) <= FLAT:
                s = ON_FACE
            if s == ON_FACE:
                if before[i, j] != slot[i, j] and before[i, j] >= 0:
                    e = valley(mold, x[i, j], rubbed[i, j], slot[i, j], before[i, j], u, t)
                    if e >= 0:
                        s = ON_FACE + 1 + e
                        state[i, j] = s
                        before[i, j] = slot[i, j]
                        moved += 1
                if s == ON_FACE and dot(f[i, j], mold.normals[slot[i, j], 0]) > least:
                    s = FREE
            elif s > ON_FACE and s <= ON_FACE + 3 and mold.turn[slot[i, j], s - ON_FACE - 1] > SHARP:
                s = pinned(mold, net, x, f, i, j, slot, s, bent, ways, hinges, slack)
                moved += 1 if s != state[i, j] else 0
            elif s > ON_FACE:
                s, slot[i, j], off = borne(mold, x[i, j], rubbed[i, j], slot[i, j], s, slack, slots, t, u)
                moved += off
            if s == FREE and state[i, j] != FREE:
                changed += 1
                clear[i, j] = 0.0
            state[i, j] = s
            count = 0
            if s == ON_FACE:
                copy(mold.normals[slot[i, j], 0], normals[0])
                count = 1
            elif s > ON_FACE and s <= ON_FACE + 3:
                e = s - ON_FACE - 1
                copy(mold.normals[slot[i, j], 0], normals[0])
                outward(mold, slot[i, j], e, normals[1])
                count = 2
            p = q[i, j]
            if s > ON_FACE + 3:
                for k in range(6):
                    p[k] = 0.0
            elif count == 0 and bits == 0:
                p[0], p[1], p[2], p[3], p[4], p[5] = 1.0, 0.0, 0.0, 1.0, 0.0, 1.0
            else:
                _projector(bits, normals, count, p)
            v = f[i, j]
            r[i, j, 0], r[i, j, 1], r[i, j, 2] = times(p, v[0], v[1], v[2])
            if s != FREE:
                contacts += 1
                v = rubbed[i, j] if s > ON_FACE else v  # what rubs a node across an edge does not press it on
                a, b, c = times(p, v[0], v[1], v[2])
                press[i, j] = np.sqrt((v[0] - a) ** 2 + (v[1] - b) ** 2 + (v[2] - c) ** 2)
            size = np.sqrt(dot(r[i, j], r[i, j]))
            if size > worst:
                worst, where = size, i * m + j
    return worst, where, contacts, changed, moved
