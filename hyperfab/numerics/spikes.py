"""Readings that no specimen can have given: glitches at a held stretch, where neighbours that move do not tell, a
stretch that was not followed, swings of a machine that rings, the end of a load cell's range."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.doubt import FAR, SMALL_STEP, Doubt, pace, scatter

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
#: Steps that tell the usual one around a row; how many times that a leap away from the way takes beside it, at least;
#: the share of what the way goes on by meanwhile to which it is back where it would be, or of the leap to which it is
#: back where it was; the share of all halts of a stretch, as long, that are made up for at once where it was not
#: followed.
_PACED, _AWAY, _BACK, _NEAR, _MADE_UP = 9, 1.5, 0.5, 0.25, 0.5


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


def lost(way: Array, stress: Array) -> list[int]:
    """Return the rows in which the stretch was not followed: its reading stood, and was on its way again.

    A camera that has lost its marks gives 0, or once more what it read last, while the stress goes on.

    >>> way = np.linspace(1.0, 1.5, 51)
    >>> way[10], way[30:32] = 1.0, way[29]
    >>> lost(way, np.linspace(0.0, 2.0, 51))
    [10, 30, 31]
    """
    return sorted({*_leapt(way, stress), *_stood(way)})


def _leapt(way: Array, stress: Array) -> list[int]:
    """Rows at one value off the way that those before and behind them are on, at which the stress is not what it is
    there."""
    if len(way) < _PACED:
        return []
    step = np.diff(way)
    usual = np.median(sliding_window_view(np.pad(step, _PACED // 2, mode="edge"), _PACED), axis=1)
    far = np.maximum(max(SMALL_STEP * float(np.ptp(way)), FAR * scatter(way)), _AWAY * np.abs(usual))
    jumps = np.flatnonzero(np.abs(step - usual) > far)
    found: list[int] = []
    for out, back in zip(jumps[:-1].tolist(), jumps[1:].tolist(), strict=True):
        run = slice(out + 1, back + 1)
        on, went = (back + 1 - out) * usual[out], way[back + 1] - way[out]
        # Where the way turns meanwhile it is back at least.
        good = abs(went - on) <= _BACK * abs(on) or abs(went) <= _NEAR * min(abs(step[out]), abs(step[back]))
        if out + 1 in found or np.ptp(way[run]) > 0.0 or not good:
            continue
        others = np.delete(np.arange(len(way)), run)
        there = stress[others[int(np.argmin(np.abs(way[others] - way[out + 1])))]]
        if np.all(np.abs(stress[run] - stress[out]) < 0.5 * abs(there - stress[out])):
            found += range(out + 1, back + 1)
    return found


def _stood(way: Array) -> list[int]:
    """Rows that read what the row before did, to the digit, where the next step is all that was gone meanwhile.

    A coarse scale stands too, and a crosshead that holds: neither makes up for it.
    """
    step = np.diff(way)
    moves = np.flatnonzero(step != 0.0)
    made_up: list[tuple[int, int]] = []
    stays = []
    for here, then in zip(moves[:-1].tolist(), moves[1:].tolist(), strict=True):
        stood = then - here - 1
        near = np.concatenate([step[max(here - 3, 0) : here + 1], step[then + 1 : then + 5]])
        near = near[near != 0.0]
        onward = len(near) > 3 and bool(np.all(near * step[then] > 0.0))
        if stood and onward and abs(step[then]) > (stood + 0.5) * float(np.median(np.abs(near))):
            made_up.append((here + 2, then + 1))
        elif stood:
            stays.append(stood)
    longest = max((stop - first for first, stop in made_up), default=0)
    if len(made_up) < _MADE_UP * (len(made_up) + sum(one <= longest for one in stays)):
        return []
    return [row for first, stop in made_up for row in range(first, stop)]


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


def saturated(way: Array, stress: Array, time: Array | None) -> Iterator[Doubt]:
    """A reading that stands at its very peak, digit for digit, while the stretch goes on: the range has ended."""
    top = float(stress[int(np.abs(stress).argmax())])
    equal = np.flatnonzero(stress == top)
    runs = [run for run in np.split(equal, np.flatnonzero(np.diff(equal) > 1) + 1) if len(run) > 3]
    same = np.flatnonzero((np.diff(stress) == 0.0) & (stress[1:] != top) & (stress[1:] != 0.0))
    usual = max((len(run) + 1 for run in np.split(same, np.flatnonzero(np.diff(same) > 1) + 1)), default=1)
    # Every cycle that goes so far ends there; its rows count, however few, where those of one cycle are no chance.
    moved = [float(np.ptp(way[run])) / max(float(np.ptp(way)), 1e-300) for run in runs]
    ends = any(
        len(run) > 3 * usual and far > 0.02 and not under_dead_load(way, run, time)
        for run, far in zip(runs, moved, strict=True)
    )
    if ends:
        rows = np.concatenate(runs)
        yield Doubt(
            "saturation",
            tuple(rows.tolist()),
            max(moved),
            f"{len(rows)} rows read the same largest stress over {100 * max(moved):.0f} % of the stretch",
            "has the load cell or its amplifier reached its range? leave these rows out",
        )
