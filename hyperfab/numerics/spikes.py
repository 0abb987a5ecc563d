"""Readings that no specimen can have given: glitches at a held stretch, where neighbours that move do not tell, and
swings of a machine that rings."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.doubt import SMALL_STEP, pace

#: A glitch in a hold lasts so many rows at most; more than this share of all rows is noise.
_TOGETHER, _MANY = 3, 0.02
#: Of its usual speed, by how much a crosshead speeds up or slows down at a start or stop; rows in which that rings.
_STARTS, _RINGS = 0.2, 8
#: Shares of a leap that a swing takes at least, and that a swing which ends takes yet.
_SWINGS, _OVER = 0.25, 0.1
#: Share of a leap that the swing back takes at least.
_DAMPED = 0.5
#: How much farther what creeps under a dead load goes in the first half of its time than in the second, and the least
#: share of its way that it goes to one side.
_SLOWS, _ONE_WAY = 2.0, 0.8


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


def ringing(way: Array, stress: Array, time: Array | None, least: float) -> list[int]:
    """Return the rows in which the machine rings behind a start, a stop or a turn of its crosshead.

    What is in between has mass: the force swings, against what the specimen does, by ``least`` from row to row, and by
    half of that back: it falls while the stretch goes on, or rises while that stands, on the way back the other way
    round, and turns twice at least. What hangs on the load cell shows as the crosshead slows down, a row before that
    has turned.

    >>> time = np.arange(40.0)
    >>> way = np.minimum(1.0 + 0.05 * time, 2.0)
    >>> stress = np.where(time <= 20.0, way - 1.0, 1.0)
    >>> stress[[21, 22, 23]] = 0.6, 0.9, 1.1
    >>> ringing(way, stress, time, 0.05)
    [20, 21, 22, 23, 24]
    """
    if time is None or len(way) < 8 or np.any(np.diff(time) <= 0.0):
        return []
    side = np.sign(stress[int(np.abs(stress).argmax())])
    step = np.diff(way) * np.sign(way[int((side * stress).argmax())] - way[0])
    change = side * np.diff(stress)
    speed = step / np.diff(time)
    begins = np.flatnonzero(np.abs(np.diff(speed, prepend=0.0)) > _STARTS * pace(step, np.diff(time)))
    moves = np.abs(step) > SMALL_STEP * float(np.ptp(way))
    last_move = np.maximum.accumulate(np.where(moves, np.arange(len(step)), -1))
    onward = np.where(last_move < 0, 1.0, np.sign(step[last_move]))
    # Held behind a pull the specimen relaxes, held behind its way back it recovers.
    against = np.where(moves, -onward * change, onward * change)
    found: set[int] = set()
    for row in begins:
        first = max(int(row) - 1, 0)  # the reading in which the speed changes has swung already
        near = slice(first, int(row) + _RINGS)
        swings = np.sign(change[near][np.abs(change[near]) > _SWINGS * least])
        if first:
            swings = np.append(np.sign(change[first - 1]), swings)
        # What swings back is damped by then.
        swung = against[near].max() > least and np.count_nonzero(against[near] > _DAMPED * least) > 1
        if swung and np.count_nonzero(np.diff(swings)) > 1:
            # The last swing is over a row behind the last that goes against the specimen, by however little.
            last = first + int(np.flatnonzero(against[near] > _OVER * least)[-1]) + 2
            found |= set(range(max(int(row), 1), min(last + 1, len(way))))
    return sorted(found)


def under_dead_load(way: Array, run: Ints, time: Array | None) -> bool:
    """Whether a stretch goes on under one load as that of a specimen which creeps: slower and slower, and one way.

    A crosshead that pulls on at the end of a range goes at one pace.

    >>> time, rows = np.linspace(0.0, 300.0, 40), np.arange(40)
    >>> under_dead_load(1.2 - 0.1 * np.exp(-time / 60.0), rows, time), under_dead_load(1.0 + time, rows, time)
    (True, False)
    """
    if time is None or time[run[-1]] <= time[run[0]]:
        return False
    half = np.interp(0.5 * (time[run[0]] + time[run[-1]]), time[run], way[run])
    first, second = abs(half - way[run[0]]), abs(way[run[-1]] - half)
    return bool(first > _SLOWS * second and first + second > _ONE_WAY * np.ptp(way[run]))
