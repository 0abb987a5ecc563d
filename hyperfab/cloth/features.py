"""How a node on an edge or a vertex of the mold goes on: the cone of normals decides."""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import part

from .mold import FREE, ON_FACE, SHARP, Mold

#: Passes over the normals of a tip, how near to their cone a force counts as in it, and what rounding makes of a force
#: across a normal, both as a share of the force. Normals of a blunt tip tell what lacks only by a small angle.
PASSES, CLOSE, ROUNDING = 60, 1e-9, 1e-13
#: Forces along two facets whose sizes differ by this share are as large.
EVEN = 1e-6
#: How far in mm a node that lands on a sharp edge or corner is put beside it, onto one of the facets.
BESIDE = 1e-6
#: Facets that turn by less (rad) are one.
FLAT = 1e-6
#: A step that ends within this many mm of a sharp edge ends on it.
ON_EDGE = 3e-7


@part
def dot(a: Array, b: Array) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@part
def distance2(a: Array, b: Array) -> Any:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@part
def copy(a: Array, b: Array) -> None:
    b[0], b[1], b[2] = a[0], a[1], a[2]


@part
def outward(mold: Mold, slot: int, edge: int, out: Array) -> None:
    """Unit vector in the facet's plane across an edge, away from the facet."""
    a, b, n = mold.corners[slot, edge], mold.corners[slot, (edge + 1) % 3], mold.normals[slot, 0]
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    out[0], out[1], out[2] = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
    length = np.sqrt(dot(out, out))
    if length > 0.0:
        for k in range(3):
            out[k] /= length


@part
def edge_reached(mold: Mold, slot: int, x: Array, y: Array, u: Array) -> tuple[int, float]:
    """First edge that the way from x to y in a facet's plane crosses: (edge or -1, fraction of the way)."""
    found, least = -1, 2.0
    for e in range(3):
        outward(mold, slot, e, u)
        a = mold.corners[slot, e]
        before = (x[0] - a[0]) * u[0] + (x[1] - a[1]) * u[1] + (x[2] - a[2]) * u[2]
        after = (y[0] - a[0]) * u[0] + (y[1] - a[1]) * u[1] + (y[2] - a[2]) * u[2]
        if after > 1e-12 and after > before:
            s = max(0.0, -before) / (after - before)
            if s < least:
                found, least = e, s
    return found, least


@part
def _in_cone(mold: Mold, slots: Ints, count: int, r: Array, rest: Array) -> bool:
    """Does -r lie in the cone of the facets' normals? ``rest``: r + sum of the nearest combination of normals.

    Non-negative least squares by active sets (Lawson and Hanson): in space three normals at a time are enough, so that
    the tip of a cone of thousands of facets is settled in a few passes over them.
    """
    size = np.sqrt(dot(r, r))
    copy(r, rest)
    active, weight, wanted = np.empty(3, np.int64), np.zeros(3), np.zeros(3)
    held = 0
    for _ in range(PASSES):
        if dot(rest, rest) <= (CLOSE * size) ** 2:
            break
        worst, best = -ROUNDING * size, -1
        for c in range(count):
            behind = dot(rest, mold.normals[slots[c], 0])
            if behind < worst:
                worst, best = behind, slots[c]
        if best < 0 or held == 3:
            break
        active[held], weight[held] = best, 0.0
        held += 1
        while held > 0:
            if not _combined(mold, active, held, r, wanted):
                held -= 1  # but for rounding it is one of those there
                break
            share, out = 1.0, -1
            for c in range(held):
                if wanted[c] <= 0.0 and weight[c] / (weight[c] - wanted[c]) < share:
                    share, out = weight[c] / (weight[c] - wanted[c]), c
            for c in range(held):
                weight[c] += share * (wanted[c] - weight[c])
            if out < 0:
                break
            held -= 1
            for c in range(out, held):
                active[c], weight[c] = active[c + 1], weight[c + 1]
        copy(r, rest)
        for c in range(held):
            for k in range(3):
                rest[k] += weight[c] * mold.normals[active[c], 0, k]
    return bool(dot(rest, rest) <= (CLOSE * size) ** 2)


@part
def _combined(mold: Mold, active: Ints, held: int, r: Array, wanted: Array) -> bool:
    """Weights of one to three normals whose sum is nearest to -r; False where they lie in one plane or line."""
    a = mold.normals[active[0], 0]
    if held == 1:
        wanted[0] = -dot(a, r)
        return True
    b = mold.normals[active[1], 0]
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    if held == 2:
        plane = x * x + y * y + z * z
        if plane < 1e-18:
            return False
        c, p, s = dot(a, b), -dot(a, r), -dot(b, r)
        wanted[0], wanted[1] = (p - c * s) / plane, (s - c * p) / plane
        return True
    n = mold.normals[active[2], 0]
    volume = x * n[0] + y * n[1] + z * n[2]
    if abs(volume) < 1e-13:
        return False
    wanted[2] = -(x * r[0] + y * r[1] + z * r[2]) / volume
    bn = b[1] * n[2] - b[2] * n[1], b[2] * n[0] - b[0] * n[2], b[0] * n[1] - b[1] * n[0]
    na = n[1] * a[2] - n[2] * a[1], n[2] * a[0] - n[0] * a[2], n[0] * a[1] - n[1] * a[0]
    wanted[0] = -(bn[0] * r[0] + bn[1] * r[1] + bn[2] * r[2]) / volume
    wanted[1] = -(na[0] * r[0] + na[1] * r[1] + na[2] * r[2]) / volume
    return True


@part
def _facets_at(mold: Mold, slot: int, state: int, out: Ints) -> int:
    """Facets around a node's edge or vertex."""
    feature = state - ON_FACE
    out[0] = slot
    if feature <= 3:
        other = mold.twins[slot, feature - 1]
        if other < 0:
            return 1
        out[1] = other
        return 2
    v = mold.vertex[slot, feature - 4]
    first, last = mold.incident_first[v], mold.incident_first[v + 1]
    count = min(last - first, out.shape[0])
    for c in range(count):
        out[c] = mold.incident[first + c]
    return count


@part
def _follow(mold: Mold, slots: Ints, count: int, x: Array, r: Array, t: Array, u: Array) -> tuple[int, int]:
    """Facet along which a node at x, on the rim of all of them, can follow the force r best, and one that is as good;
    -1: none."""
    best, found, second = 0.0, -1, -1
    for c in range(count):
        s = slots[c]
        n = mold.normals[s, 0]
        rn = dot(r, n)
        if rn > 0.0:
            continue
        for k in range(3):
            t[k] = r[k] - rn * n[k]
        length = np.sqrt(dot(t, t))
        if length <= (1.0 - EVEN) * best:
            continue
        size = 0.0
        for k in range(3):
            size = max(size, abs(mold.corners[s, 1, k] - mold.corners[s, 0, k]))
        inward = True
        for e in range(3):
            outward(mold, s, e, u)
            a = mold.corners[s, e]
            off = (x[0] - a[0]) * u[0] + (x[1] - a[1]) * u[1] + (x[2] - a[2]) * u[2]
            if off > -1e-9 * size and dot(t, u) > 0.0:
                inward = False
        if inward and length > (1.0 + EVEN) * best:
            best, found, second = length, s, -1
        elif inward:
            second = s
    return found, second


@part
def _decide(
    mold: Mold, x: Array, r: Array, slot: int, state: int, slack: float, slots: Ints, t: Array, u: Array
) -> tuple[int, int]:
    """State and slot of a node on an edge or vertex under the force r; ``slack`` N across it are none."""
    count = _facets_at(mold, slot, state, slots)
    # Along an edge the node is free to slide: only the force across it is judged.
    copy(r, u)
    if state <= ON_FACE + 3:
        e = state - ON_FACE - 1
        a, b = mold.corners[slot, e], mold.corners[slot, (e + 1) % 3]
        t[0], t[1], t[2] = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        s = dot(r, t) / dot(t, t)
        for k in range(3):
            u[k] = r[k] - s * t[k]
    across = np.empty(3)
    copy(u, across)
    if _in_cone(mold, slots, count, across, t) or dot(t, t) <= slack * slack:
        return state, slot
    face, second = _follow(mold, slots, count, x, r, t, u)
    for e in range(3):
        if second >= 0 and state > ON_FACE + 3 and mold.twins[face, e] == second and mold.turn[face, e] > FLAT:
            return ON_FACE + 1 + e, face  # down either facet alike: along the ridge between them
    if face >= 0:
        return ON_FACE, face
    pulled = True  # outward of every facet of a valley, or of one facet of a ridge
    for c in range(count):
        pulled = pulled and dot(across, mold.normals[slots[c], 0]) > 0.0
    if pulled or state > ON_FACE + 3 or count == 1:
        return FREE, slot
    if mold.turn[slot, state - ON_FACE - 1] > 0.0:
        return FREE, slot
    return state, slot


@part
def _step_off(mold: Mold, slot: int, feature: int, onto: int, x: Array) -> int:
    """1 where a node that leaves a sharp corner (``feature`` of ``slot``) for the facet ``onto`` is put beside it."""
    corner = mold.vertex[slot, feature - 4]
    for e in range(3):
        if mold.vertex[onto, e] == corner and beside(mold, onto, 4 + e, x):
            return 1
    return 0


@part
def borne(
    mold: Mold, x: Array, r: Array, slot: int, state: int, slack: float, slots: Ints, t: Array, u: Array
) -> tuple[int, int, int]:
    """State and slot of a node on an edge or vertex under the force r; 1 where it is put off a sharp corner, else 0."""
    s, onto = _decide(mold, x, r, slot, state, slack, slots, t, u)
    off = _step_off(mold, slot, state - ON_FACE, onto, x) if state > ON_FACE + 3 and s == ON_FACE else 0
    if s == ON_FACE and dot(r, mold.normals[onto, 0]) > slack:
        s = FREE
    return s, onto, off


@part
def valley(mold: Mold, x: Array, r: Array, slot: int, before: int, u: Array, t: Array) -> int:
    """Edge of a valley just crossed, if the force pushes back to it from both sides; -1 else."""
    for e in range(3):
        if mold.twins[slot, e] == before and mold.turn[slot, e] < -1e-9:
            outward(mold, slot, e, u)
            n = mold.normals[slot, 0]
            here = dot(r, u) - dot(r, n) * dot(u, n)
            a, b, n = mold.corners[slot, e], mold.corners[slot, (e + 1) % 3], mold.normals[before, 0]
            t[0], t[1], t[2] = b[0] - a[0], b[1] - a[1], b[2] - a[2]
            # From the other facet the way to the edge runs along n x (its own sense of the edge).
            vx, vy, vz = n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]
            there = r[0] * vx + r[1] * vy + r[2] * vz
            if here > 0.0 and there > 0.0:
                s = ((x[0] - a[0]) * t[0] + (x[1] - a[1]) * t[1] + (x[2] - a[2]) * t[2]) / dot(t, t)
                s = min(1.0, max(0.0, s))
                for k in range(3):
                    x[k] = a[k] + s * t[k]
                return e
    return -1


@part
def unfold(mold: Mold, slot: int, edge: int, x: Array, y: Array, s: float) -> int:
    """Way from x to y, in a facet's plane, that crosses an edge at the fraction s: the rest of it is turned into the
    plane of the facet beyond, y becomes its end. Returns that facet.
    """
    a, b = mold.corners[slot, edge], mold.corners[slot, (edge + 1) % 3]
    other = mold.twins[slot, edge]
    t, u, v = np.empty(3), np.empty(3), np.empty(3)
    outward(mold, slot, edge, u)
    size = 0.0
    for k in range(3):
        t[k] = b[k] - a[k]
        size += t[k] * t[k]
    size = np.sqrt(size)
    n = mold.normals[other, 0]
    v[0], v[1], v[2] = t[1] * n[2] - t[2] * n[1], t[2] * n[0] - t[0] * n[2], t[0] * n[1] - t[1] * n[0]
    along, across = 0.0, 0.0
    for k in range(3):
        rest = (1.0 - s) * (y[k] - x[k])
        along += rest * t[k] / size
        across += rest * u[k]
    for k in range(3):
        y[k] = x[k] + s * (y[k] - x[k]) + along * t[k] / size + across * v[k] / size
    return other


@part
def beside(mold: Mold, slot: int, feature: int, x: Array) -> bool:
    """Put a node on a sharp edge or corner a little beside it, onto the facet; False where the feature is not sharp."""
    sharp = False
    if 1 <= feature <= 3:
        sharp = mold.turn[slot, feature - 1] > SHARP
    elif feature > 3:
        corner = feature - 4
        sharp = mold.turn[slot, corner] > SHARP or mold.turn[slot, (corner + 2) % 3] > SHARP
    if not sharp:
        return False
    tri = mold.corners[slot]
    size = 0.0
    for k in range(3):
        size += ((tri[0, k] + tri[1, k] + tri[2, k]) / 3.0 - x[k]) ** 2
    share = min(BESIDE / np.sqrt(size), 0.5)
    for k in range(3):
        x[k] += share * ((tri[0, k] + tri[1, k] + tri[2, k]) / 3.0 - x[k])
    return True
