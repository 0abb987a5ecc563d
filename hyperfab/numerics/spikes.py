"""Single readings that no specimen can have given, where neighbours that move do not tell: in a hold, in the first row.

Stretch and stress (n,) are in the order they were read, in any unit of stress.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hyperfab.arrays import Array

#: Steps below this share of the whole way, or of the peak, are no remark's business.
SMALL_STEP, SMALL_LEAP = 0.003, 0.05
#: So many standard deviations of its own scatter make a step, of which a curve has hundreds, no chance.
FAR = 8.0
#: A glitch in a hold lasts so many rows at most; more than this share of all rows is noise.
_TOGETHER, _MANY = 3, 0.02


def scatter(values: Array) -> float:
    """Return the standard deviation of a reading about its neighbours, by second differences, robustly.

    On a coarse curve its curvature counts as scatter: such a curve draws fewer remarks, not more.
    """
    if len(values) < 5:
        return float(np.ptp(values)) if len(values) else 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0))


def off_in_hold(way: Array, stress: Array, least: float) -> list[int]:
    """Return the rows at a held stretch that stand outside both sides of their neighbours by ``least``.

    A knock, a glitch of the load cell: what relaxes stays between them. One of two such rows shows once the other is
    gone. Where there are many, the curve is noisy and none is told.

    >>> relaxing = 1.0 + np.exp(-np.arange(40.0) / 10.0)
    >>> relaxing[[20, 21]] = -0.5, 0.3
    >>> sorted(off_in_hold(np.append(1.0, np.full(39, 1.5)), relaxing, 0.1))
    [20, 21]
    """
    kept, found = np.arange(len(stress)), []
    for _ in range(_TOGETHER):
        if len(kept) < 5:
            break
        near, at = sliding_window_view(stress[kept], 5)[:, [0, 1, 3, 4]], stress[kept][2:-2]
        held = np.ptp(sliding_window_view(way[kept], 5), axis=1) <= SMALL_STEP * float(np.ptp(way))
        out = 2 + np.flatnonzero(held & ((at < near.min(axis=1) - least) | (at > near.max(axis=1) + least)))
        if not out.size:
            break
        found += kept[out].tolist()
        kept = np.delete(kept, out)
    return found if len(found) <= _MANY * len(stress) + 2 else []


def starts_off(way: Array, stress: Array) -> bool:
    """Return whether the first row, before the pull, reads what those behind it do not: an amplifier switched on."""
    if len(stress) < 8 or abs(way[0] - 1.0) > 1e-6:
        return False
    least = max(SMALL_LEAP * float(np.abs(stress[1:]).max()), 1.5 * FAR * scatter(stress[1:]))
    return bool(abs(stress[0]) > least and abs(stress[0] - stress[1]) > max(least, 4.0 * abs(stress[2] - stress[1])))
