"""Single readings that no specimen can have given, at a held stretch, where neighbours that move do not tell."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hyperfab.arrays import Array
from hyperfab.numerics.doubt import SMALL_STEP

#: A glitch in a hold lasts so many rows at most; more than this share of all rows is noise.
_TOGETHER, _MANY = 3, 0.02


def off_in_hold(way: Array, stress: Array, least: float) -> list[int]:
    """Return the rows at a held stretch that stand outside both sides of their neighbours by ``least``.

    A knock, a glitch of the load cell: what relaxes stays between them, at two and three rows from it, so that two such
    rows do not hide each other; of three one shows first. Where there are many, the curve is noisy and none is told.

    >>> relaxing = 1.0 + np.exp(-np.arange(40.0) / 10.0)
    >>> relaxing[[20, 21]] = -0.5, 0.3
    >>> sorted(off_in_hold(np.append(1.0, np.full(39, 1.5)), relaxing, 0.1))
    [20, 21]
    """
    kept, found = np.arange(len(stress)), []
    for _ in range(_TOGETHER):
        if len(kept) < 7:
            break
        near, at = sliding_window_view(stress[kept], 7)[:, [0, 1, 5, 6]], stress[kept][3:-3]
        held = np.ptp(sliding_window_view(way[kept], 7), axis=1) <= SMALL_STEP * float(np.ptp(way))
        out = 3 + np.flatnonzero(held & ((at < near.min(axis=1) - least) | (at > near.max(axis=1) + least)))
        if not out.size:
            break
        found += kept[out].tolist()
        kept = np.delete(kept, out)
    return found if len(found) <= _MANY * len(stress) + 2 else []
