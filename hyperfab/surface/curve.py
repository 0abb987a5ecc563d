"""Order in which points follow each other closely: along Hilbert's curve."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.threads import in_blocks

#: The curve fills a cube of 2^BITS cells a side.
BITS = 12
#: Bits sorted at once.
_DIGIT = 12
#: Points that are worth a thread's while.
BLOCK = 50_000


def along_a_curve(points: Array) -> Ints:
    """Return the order (n,) of ``points`` (n, 3) along Hilbert's curve, so that each is near the one before.

    >>> along_a_curve(np.array([[0.0, 0, 0], [9, 0, 0], [1, 0, 0], [8, 0, 0]])).tolist()
    [0, 2, 3, 1]
    """
    if not len(points):
        return np.zeros(0, np.int64)
    # By columns: numpy takes several times as long for three at once.
    low, high = (np.array([bound(points[:, a]) for a in range(3)]) for bound in (np.min, np.max))
    span = float((high - low).max())
    scale = (2.0**BITS - 1.0) / span if span > 0.0 else 0.0
    points, places = np.ascontiguousarray(points), np.empty(len(points), np.int64)
    in_blocks(lambda first, last: _places(points[first:last], low, scale, places[first:last]), len(points), BLOCK)
    return _sorted(places)


@kernel
def _places(points, low, scale, out):  # type: ignore[no-untyped-def]
    """Fill places ``out`` (n,) along the curve. Skilling, AIP Conf. Proc. 707 (2004) 381."""
    for i in range(len(points)):
        x = np.int64((points[i, 0] - low[0]) * scale)
        y = np.int64((points[i, 1] - low[1]) * scale)
        z = np.int64((points[i, 2] - low[2]) * scale)
        for bit in range(BITS - 1, 0, -1):
            q = np.int64(1) << bit
            p = q - 1
            if x & q:
                x ^= p
            if y & q:
                x ^= p
            else:
                t = (x ^ y) & p
                x ^= t
                y ^= t
            if z & q:
                x ^= p
            else:
                t = (x ^ z) & p
                x ^= t
                z ^= t
        y ^= x
        z ^= y
        t = np.int64(0)
        for bit in range(BITS - 1, 0, -1):
            q = np.int64(1) << bit
            if z & q:
                t ^= q - 1
        x ^= t
        y ^= t
        z ^= t
        place = np.int64(0)
        for bit in range(BITS - 1, -1, -1):
            place = (place << 3) | (((x >> bit) & 1) << 2) | (((y >> bit) & 1) << 1) | ((z >> bit) & 1)
        out[i] = place


@kernel
def _sorted(keys: Ints) -> Ints:
    """Stable order (n,) of non-negative ``keys`` of 3 BITS bits, digit by digit."""
    n, cells = len(keys), 1 << _DIGIT
    order: Ints = np.arange(n)
    other: Ints = np.empty(n, np.int64)
    for shift in range(0, 3 * BITS, _DIGIT):
        place = np.zeros(cells + 1, np.int64)
        for i in range(n):
            place[((keys[i] >> shift) & (cells - 1)) + 1] += 1
        for d in range(cells):
            place[d + 1] += place[d]
        for i in order:
            d = (keys[i] >> shift) & (cells - 1)
            other[place[d]] = i
            place[d] += 1
        order, other = other, order
    return order
