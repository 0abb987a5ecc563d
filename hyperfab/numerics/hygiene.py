"""A measured curve looked at before any model: where it turns, and readings that no specimen can have given.

Pure arrays in the order they were read; nothing here knows files, units or laws. A sheet of readings that is merely
noisy draws no remark: every threshold is the larger of a share of the curve and a multiple of its own scatter.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.numerics.doubt import FAR, SMALL_LEAP, SMALL_STEP, Doubt, leap, moving, scatter
from hyperfab.numerics.rest import offset, starts_off, unzeroed
from hyperfab.numerics.spikes import lost, off_in_hold, ringing, saturated

#: A curve has turned where it comes back by this share of its whole way.
TURN = 0.2
#: Branches and cycles that differ by less than this share of the peak may be averaged without a word.
ALIKE = 0.02
#: Below this share of the peak a reading is zero, whatever its last digits say.
ZERO = 1e-9
#: A stretch that goes on slower than this share of the speed of the pull creeps.
_CREEPS = 0.2


def turns(way: Array, share: float = TURN) -> list[slice]:
    """Return the sweeps of ``way``: rows between places where it comes back by ``share`` of its whole range.

    Neighbours do not overlap; the turning row belongs to the sweep that ends there.

    >>> turns(np.array([1.0, 1.5, 2.0, 1.6, 1.1, 1.4, 2.0]))
    [slice(0, 3, None), slice(3, 5, None), slice(5, 7, None)]
    """
    count = len(way)
    enough = share * float(np.ptp(way)) if count else 0.0
    if count < 3 or enough == 0.0:
        return [slice(0, count)]
    edges, low, high, rising = [0], 0, 0, None
    for row, value in enumerate(way.tolist()):
        if value > way[high]:
            high = row
        if value < way[low]:
            low = row
        if rising is not False and way[high] - value >= enough:
            if rising:
                edges.append(high + 1)
            rising, low = False, row
        elif rising is not True and value - way[low] >= enough:
            if rising is False:
                edges.append(low + 1)
            rising, high = True, row
        if rising is False and way[low] == value:
            high = row
        if rising is True and way[high] == value:
            low = row
    edges.append(count)
    return [slice(a, b) for a, b in pairwise(edges) if b > a]


def branches(stretch: Array, share: float = TURN) -> Ints:
    """Return 1 for rows on the way away from stretch 1 and -1 for rows on the way back to it.

    What begins compressed is a table in the order of its stretch: it has no way back to rest before it turned.

    >>> branches(np.array([1.0, 1.5, 2.0, 1.5, 1.1])), branches(np.array([0.5, 0.8, 1.0, 1.5]))
    (array([ 1,  1,  1, -1, -1]), array([1, 1, 1, 1]))
    """
    found = sides(_away(stretch), share)
    if len(stretch) and stretch[0] < 1.0:
        found[: int(np.argmax([*(found > 0), True]))] = 1
    return found


def sides(way: Array, share: float = TURN) -> Ints:
    """Return 1 for rows of a sweep in which ``way`` grows, -1 for those of one in which it falls.

    >>> sides(np.array([1.0, 1.5, 1.1, 1.6]))
    array([ 1,  1, -1,  1])
    """
    found = np.ones(len(way), dtype=np.int64)
    for part in turns(way, share):
        # From the row it turned at: a sweep may be of one row.
        if len(way) and way[part.stop - 1] < way[max(part.start - 1, 0)]:
            found[part] = -1
    return found


def _away(stretch: Array) -> Array:
    return np.abs(np.log(np.maximum(stretch, 1e-12)))


def cycles(stretch: Array, branch: Ints | None = None) -> Ints:
    """Return the number of the cycle, from 1, that each row belongs to: a new one begins with each new loading."""
    side = branches(stretch) if branch is None else branch
    begins = np.zeros(len(side), dtype=bool)
    begins[1:] = (side[1:] == 1) & (side[:-1] == -1)
    return np.asarray(1 + np.cumsum(begins), dtype=np.int64)


def first_loading(stretch: Array, branch: Ints | None = None, cycle: Ints | None = None) -> Flags:
    """Return which rows are of the first way away from rest: as stated, else by the turns, up to the farthest stretch.

    Where no row goes away from rest (a table written from its far end) the first way is taken as it is.

    >>> first_loading(np.array([1.0, 1.5, 1.1, 1.6, 2.0])).tolist()
    [True, True, False, False, False]
    >>> first_loading(np.array([1.6, 1.4, 1.2])).tolist(), first_loading(np.array([0.4, 1.0, 1.2])).tolist()
    ([True, True, True], [True, True, True])
    """
    side = branches(stretch) if branch is None else branch
    number = cycles(stretch, side) if cycle is None else cycle
    loading = side == 1
    if not loading.any():
        return np.asarray(number == number.min()) if len(number) else loading
    found = loading & (number == number[loading].min())
    if branch is None:
        away = _away(stretch)
        rows = np.arange(len(stretch))
        begun = rows >= int(np.argmin(np.where(found, away, np.inf)))
        found &= rows <= int(np.argmax(np.where(found & begun, away, -np.inf)))
    return np.asarray(found)


def look(
    stretch: Array,
    stress: Array,
    *,
    stretch2: Array | None = None,
    time: Array | None = None,
    branch: Ints | None = None,
    cycle: Ints | None = None,
) -> list[Doubt]:
    """Return what is odd about one specimen's curve, gravest first. Arrays have one entry a row, in file order.

    Of a general biaxial test, whose ``stretch2`` is told, the way is that of the axis that moves most: the other may be
    held, or drawn in under a rising load.
    """
    if len(stretch) < 3 or not np.any(stress):
        return []
    way = stretch if stretch2 is None else moving(stretch, stretch2)
    gone = lost(way, stress)
    if gone:
        kept = np.delete(np.arange(len(way)), gone)
        others = look(
            stretch[kept],
            stress[kept],
            stretch2=None if stretch2 is None else stretch2[kept],
            time=None if time is None else time[kept],
            branch=None if branch is None else branch[kept],
            cycle=None if cycle is None else cycle[kept],
        )
        told = Doubt(
            "lost",
            tuple(gone),
            len(gone) / len(way),
            f"{len(gone)} rows read a stretch that is not followed on the way, while the stress goes on",
            "did the camera or extensometer lose its marks? leave these rows out",
        )
        return [told, *(replace(one, rows=tuple(kept[list(one.rows)].tolist())) for one in others)]
    found = [
        *_doubled(stretch, stress, time),
        *_steps_back(way, stress),
        *saturated(way, stress, time),
        *_leaps(way, stress, time),
        *offset(stretch, stress, stretch2),
        *unzeroed(way, stress),
        *_failing(way, stress, time),
    ]
    if np.ptp(way) > 0.0:
        side = branches(way) if branch is None else branch
        found += _unloading(way, stress, side)
        found += _cycles(way, stress, side, cycles(way, side) if cycle is None else cycle, time)
    return found


def _steps_back(way: Array, stress: Array) -> Iterator[Doubt]:
    """A stretch that steps back in mid-pull while the stress does not follow: the extensometer slipped."""
    step = np.diff(way)
    least = max(SMALL_STEP * float(np.ptp(way)), FAR * scatter(way))
    rows = []
    for row in np.flatnonzero(step < -least):
        before, after = step[max(row - 4, 0) : row], step[row + 1 : row + 5]
        if len(before) < 2 or len(after) < 2 or min(np.median(before), np.median(after)) <= 0.0:
            continue  # an unloading begins, goes on or ends here
        if way[row] - way[row + 1] > 0.5 * np.ptp(way):
            continue  # the next pull begins
        if way[row + 1 :].max() > way[row] and _stress_stays(way, stress, int(row)):
            rows.append(int(row) + 1)
    if rows:
        size = float(max(way[row - 1] - way[row] for row in rows))
        yield Doubt(
            "step-back",
            tuple(rows),
            size / float(np.ptp(way)),
            f"the stretch steps back by {size:.2g} in mid-pull{_times(rows)} and the stress does not follow",
            "did the extensometer slip? leave out what follows, or measure again",
        )


def _stress_stays(way: Array, stress: Array, row: int) -> bool:
    """Whether after the step back behind ``row`` more stress is read than at the same stretch before.

    A specimen let go retraces its curve or lies below it; one whose gauge slipped goes on at the stress it had. The
    readings of both sides that share stretches are taken together: one reading alone may be off by its noise.
    """
    low, stop = way[row + 1], row + 1
    start = max(row - 3, 0)
    while start > 0 and low <= way[start] <= way[row]:
        start -= 1
    while stop < len(way) and low <= way[stop] <= way[row]:
        stop += 1
    slope, level = np.polyfit(way[start : row + 1] - way[row], stress[start : row + 1], 1)
    above = np.mean(stress[row + 1 : stop] - level - slope * (way[row + 1 : stop] - way[row]))
    return bool(slope > 0.0 and above > 0.5 * slope * (way[row] - low))


def _leaps(way: Array, stress: Array, time: Array | None) -> Iterator[Doubt]:
    """Single readings off the curve, a force that swings where the crosshead starts, stops or turns, and stresses that
    fall in one row while the stretch goes on."""
    if len(stress) < 8:
        return
    peak = float(np.abs(stress).max())
    least = leap(stress, peak)
    rung = np.array(ringing(way, stress, time, least), dtype=np.int64)
    if rung.size:
        size = float(np.abs(np.diff(stress)[rung - 1]).max()) / peak
        yield Doubt(
            "ringing",
            tuple(rung.tolist()),
            size,
            f"the force swings by {100 * size:.0f} % of the peak from row to row where the crosshead starts or stops",
            f"the machine rings, the specimen does not: leave these {len(rung)} rows out, or start and stop slower",
        )
    step = np.diff(way)
    off = np.abs(stress[1:-1] - 0.5 * (stress[:-2] + stress[2:]))
    around = np.abs(stress[2:] - stress[:-2])
    spikes = 1 + np.flatnonzero((off > least) & (off > 4.0 * around) & (step[1:] * step[:-1] > 0.0))
    begins = starts_off(way, stress)
    spikes = np.union1d(spikes, [*([0] if begins else []), *off_in_hold(way, stress, least)]).astype(np.int64)
    if spikes.size:
        off = np.concatenate([[abs(stress[0] - stress[1])], off, [0.0]])
        size = float(off[spikes].max()) / float(np.abs(stress[int(begins) :]).max())
        yield Doubt(
            "spike",
            tuple(int(row) for row in spikes),
            size,
            f"a reading stands off its neighbours by {100 * size:.0f} % of the peak{_times(spikes)}",
            "correct the reading or leave it out",
        )
    change = np.diff(stress) * np.sign(stress[int(np.abs(stress).argmax())])
    near = np.concatenate([spikes - 1, spikes, rung - 1])
    falls = [
        int(row) + 1
        for row in np.flatnonzero((change < -least) & (step >= 0.0))
        if row not in near
        and np.sum(change[row + 1 : row + 5] > 0.0) >= 3  # it carries again: no failure of the specimen
        and np.sum(change[max(row - 4, 0) : row] > 0.0) >= 3
    ]
    if falls:
        size = float(max(-change[row - 1] for row in falls)) / peak
        yield Doubt(
            "drop",
            tuple(falls),
            size,
            f"the stress falls by {100 * size:.0f} % of the peak in one row{_times(falls)} while the stretch goes on",
            "did the specimen slip in its grips, or a yarn break?",
        )


def _doubled(stretch: Array, stress: Array, time: Array | None) -> Iterator[Doubt]:
    """Rows that stand twice: they would count double and hide the scatter."""
    columns = np.stack([stretch, stress] if time is None else [stretch, stress, time])
    count = columns.shape[1]
    rows: NDArray = np.array([], dtype=np.int64)
    half = count // 2
    if count >= 6 and count % 2 == 0 and np.array_equal(columns[:, :half], columns[:, half:]):
        rows = np.arange(half, count)
    elif count >= 6 and count % 2 == 0 and np.array_equal(columns[:, ::2], columns[:, 1::2]):
        rows = np.arange(1, count, 2)
    elif time is not None:
        rows = 1 + np.flatnonzero(np.all(columns[:, 1:] == columns[:, :-1], axis=0) & (stress[1:] != 0.0))
        rows = rows if len(rows) >= 3 else rows[:0]
    if len(rows):
        yield Doubt(
            "doubled",
            tuple(int(row) for row in rows),
            len(rows) / count,
            f"{len(rows)} of {count} rows stand twice",
            "leave out the copies",
        )


def _failing(way: Array, stress: Array, time: Array | None) -> Iterator[Doubt]:
    """A stress that falls for good while the stretch goes on to its end: the specimen tears, layer by layer.

    Where the stretch only creeps behind the peak, far slower than up to it, the stress relaxes; where it passes 1, a
    test that was pressed is pulled.
    """
    top, last = int(np.abs(stress).argmax()), int(_away(way).argmax())
    if (way[top] - 1.0) * (way[last] - 1.0) < 0.0:
        return
    peak, rest = stress[top], stress[top : last + 1]
    if len(rest) < 5 or abs(way[last] - way[top]) < 10.0 * SMALL_STEP * np.ptp(way):
        return
    if time is not None and abs(way[last] - way[top]) * abs(time[top] - time[0]) < _CREEPS * abs(
        way[top] - way[0]
    ) * abs(time[last] - time[top]):
        return
    fallen = 1.0 - float(np.sign(peak) * rest[-1] / abs(peak))
    climbs = float(np.max(np.maximum.accumulate(rest[::-1] * np.sign(peak)) - rest[::-1] * np.sign(peak)))
    if fallen > 2.0 * SMALL_LEAP and climbs < 0.2 * fallen * abs(peak):
        yield Doubt(
            "failing",
            tuple(range(top + 1, last + 1)),
            fallen,
            f"the stress falls by {100 * fallen:.0f} % behind its peak at a stretch of {way[top]:.3g}, to the end",
            "does the specimen tear there? no elastic law falls: leave out what follows the peak",
        )


def _unloading(way: Array, stress: Array, side: Ints) -> Iterator[Doubt]:
    if not ((side == 1).any() and (side == -1).any()):
        return
    size, most = _apart(way, stress, side == 1, side == -1)
    if size > ALIKE:
        rows = np.flatnonzero(side == -1)
        yield Doubt(
            "unloading",
            tuple(int(row) for row in rows),
            size,
            f"loading and unloading differ by up to {100 * most:.0f} %, {100 * size:.0f} % of the peak in the mean",
            "--branch load takes loading alone",
        )


def _cycles(way: Array, stress: Array, side: Ints, number: Ints, time: Array | None) -> Iterator[Doubt]:
    first, last = int(number.min()), int(number.max())
    if first == last:
        return
    loading = side == 1
    size, most = _apart(way, stress, loading & (number == first), loading & (number == last))
    if size > ALIKE:
        yield Doubt(
            "cycles",
            tuple(int(row) for row in np.flatnonzero(number != first)),
            size,
            f"cycles {first} and {last} differ by up to {100 * most:.0f} %, {100 * size:.0f} % of the peak in the mean"
            + _paces(way, loading, number, time),
            "--cycle first takes the first alone",
        )


def _paces(way: Array, loading: Flags, number: Ints, time: Array | None) -> str:
    """Return how fast the first and the last cycle were pulled, in words, where one was twice as fast."""
    if time is None:
        return ""
    found = []
    for cycle in (number.min(), number.max()):
        rows = loading & (number == cycle)
        took = float(np.ptp(time[rows]))
        found.append(float(np.ptp(way[rows])) / took if took > 0.0 else 0.0)
    one, two = found
    told = min(found) > 0.0 and max(one / two, two / one) >= 2.0
    return f"; they were pulled at {one:.2g} and {two:.2g} 1/s" if told else ""


def _apart(way: Array, stress: Array, one: Flags, other: Flags) -> tuple[float, float]:
    """Return the mean and the largest distance of two sets of rows, at the stretches both reach.

    The mean is a share of the peak, the largest of the larger of the two, where that is half the peak and more: what
    constants through both would have to average.
    """
    if one.sum() < 3 or other.sum() < 3:
        return 0.0, 0.0
    low, high = max(way[one].min(), way[other].min()), min(way[one].max(), way[other].max())
    if not high > low:
        return 0.0, 0.0
    grid = np.linspace(low, high, 33)
    curves = []
    for rows in (one, other):
        order = np.argsort(way[rows], kind="stable")
        curves.append(np.interp(grid, way[rows][order], stress[rows][order]))
    peak, gap = float(np.abs(stress).max()), np.abs(curves[0] - curves[1])
    larger = np.maximum(np.abs(curves[0]), np.abs(curves[1]))
    high_up = larger >= 0.5 * larger.max()
    return float(np.mean(gap)) / peak, float(np.max(gap[high_up] / larger[high_up], initial=0.0))


def _times(rows: object) -> str:
    count = len(rows)  # type: ignore[arg-type]
    return f", {count} times" if count > 1 else ""
