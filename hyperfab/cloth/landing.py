"""On which face, edge or corner of the mold a node is that is set back onto it."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import part

from .features import FLAT, ON_EDGE, beside, copy, distance2, outward
from .mold import SHARP, Mold

#: Single precision, as STL files have it, leaves so much of a mold's size.
SINGLE = 2e-7


@part
def landed(mold: Mold, slot: int, feature: int, y: Array, x: Array) -> int:
    """Feature of a facet that a node rests on which is set back from y to x on it; x is put right where need be."""
    near = rounding(mold) ** 2
    if distance2(y, x) <= near:
        for e in range(3):
            if distance2(x, mold.corners[slot, e]) <= near and not _amid_edge(mold, slot, e):
                copy(mold.corners[slot, e], x)
                return 4 + e
    if feature > 3:
        return 0 if beside(mold, slot, feature, x) else feature
    return ridge_at(mold, slot, y, x) if feature == 0 else feature


@part
def _amid_edge(mold: Mold, slot: int, corner: int) -> bool:
    """Whether a corner of a facet is one of a sharp edge of several: two sharp edges meet there, or one ends."""
    v, count = mold.vertex[slot, corner], 0
    for at in range(mold.incident_first[v], mold.incident_first[v + 1]):
        s = mold.incident[at]
        for e in range(3):  # counted from both of its facets
            if mold.turn[s, e] > SHARP and (mold.vertex[s, e] == v or mold.vertex[s, (e + 1) % 3] == v):
                count += 1
    return 0 < count <= 4


@part
def rounding(mold: Mold) -> float:
    """What single precision leaves of a place on a mold, mm."""
    size = 0.0
    for k in range(3):
        size = max(size, mold.bounds[0, 3 + k] - mold.bounds[0, k])
    return SINGLE * size


@part
def ridge_at(mold: Mold, slot: int, y: Array, x: Array) -> int:
    """Put a node at y that lands on a facet, but is as near to the one beyond a ridge, onto the ridge; 0: it is not.

    ``x`` is where it gets to; the feature is returned: 1-3 an edge, 4-6 a vertex. A sheet and a mold that are their own
    mirror image have nodes in the plane between the halves; rounding alone would send each down one side of a ridge
    there, while on the ridge it is borne by both.
    """
    near, first = rounding(mold), -1
    for e in range(3):
        if not FLAT < mold.turn[slot, e] <= SHARP:
            continue
        a, b = mold.corners[slot, e], mold.corners[slot, (e + 1) % 3]
        one, two = mold.normals[slot, 0], mold.normals[mold.twins[slot, e], 0]
        off, apart, along, length = 0.0, 0.0, 0.0, 0.0
        for k in range(3):
            off += (y[k] - a[k]) * (one[k] - two[k])
            apart += (one[k] - two[k]) ** 2
            along += (y[k] - a[k]) * (b[k] - a[k])
            length += (b[k] - a[k]) ** 2
        if abs(off) > near * np.sqrt(apart):
            continue
        if first >= 0:  # as near to both: their corner
            corner = e if first == (e + 2) % 3 else first
            copy(mold.corners[slot, corner], x)
            return 4 + corner
        if 0.0 < along < length:
            first = e
            for k in range(3):
                x[k] = a[k] + along / length * (b[k] - a[k])
    return 1 + first


@part
def sharp_edge_at(mold: Mold, slot: int, x: Array) -> int:
    """Sharp edge of a facet on which a node of the facet lies but for rounding; -1: none."""
    u = np.empty(3)
    for e in range(3):
        if mold.turn[slot, e] > SHARP:
            outward(mold, slot, e, u)
            a = mold.corners[slot, e]
            off = (x[0] - a[0]) * u[0] + (x[1] - a[1]) * u[1] + (x[2] - a[2]) * u[2]
            if abs(off) < ON_EDGE:
                return e
    return -1
