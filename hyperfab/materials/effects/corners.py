"""Where a test turned between two readings: the corner of a way that is led there and back at steady speeds.

What rides on history hangs on the largest stretch and on the stretch at each turn. A thinned export lacks the rows of
the turns, but its clock tells them: two straight lines of stretch over time meet there.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Ints
from hyperfab.materials.effects.path import GENERAL, Path
from hyperfab.materials.law import Array

#: Readings on each side of a turn that tell its speed there, at least and at most.
_FEWEST, _MOST = 6, 30
#: Standard deviations within which lines agree with readings, and beyond which a corner is none of them.
_CLEAR = 3.0
#: A corner nearer to a reading than this share of a test's range changes nothing.
_SLIGHT = 5e-4
#: Readings are no better than this share of the range: they are written with so many digits.
_DIGITS = 1e-4
#: A way without readings more times as long than any step beside it may be a wait, of which nothing was kept.
_GAP = 2.0


def cornered(path: Path) -> tuple[Path, Ints]:
    """Return the way with a row at each corner between readings, and the row of ``path`` (m,) each stands at or after.

    It is ``path`` itself where each turn was read, or is not told: that takes a clock, and a steady speed before and
    after it.

    >>> from dataclasses import replace
    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> time = np.arange(0.5, 14.5)
    >>> pull = replace(uniaxial_pull(1.7 - 0.1 * np.abs(time - 6.8)), time_s=time)
    >>> way, row = cornered(pull)
    >>> way.stretch[6:9].round(6), way.time_s[7].round(6), row[6:9]
    (array([1.67, 1.7 , 1.63]), np.float64(6.8), array([6, 6, 7]))
    >>> untimed = replace(pull, time_s=np.full_like(time, np.nan))
    >>> cornered(untimed)[0] is untimed
    True
    """
    found = [corner for rows in path.curves for corner in _of_curve(path, rows)]
    rows = np.arange(len(path.stretch))
    if not found:
        return path, rows
    at = np.array([row for row, _, _ in found])
    new, near = at + np.arange(len(at)), np.insert(rows, at, at - 1)
    time, stretch, across, heat = (
        column[near] for column in (path.time_s, path.stretch, path.across, path.temperature_degC)
    )
    time[new] = [clock for _, clock, _ in found]
    stretch[new] = [places[0] for _, _, places in found]
    across[new] = [places[-1] if len(places) > 1 else np.nan for _, _, places in found]
    heat[new] = 0.5 * (heat[new] + path.temperature_degC[at])
    way = Path(
        starts=tuple(int(start + np.count_nonzero(at < start)) for start in path.starts),
        mode=path.mode[near],
        stretch=stretch,
        across=across,
        time_s=time,
        temperature_degC=heat,
        angle_deg=path.angle_deg[near],
        branch=path.branch[near],
        lengths_mm=path.lengths_mm,
        sections=path.sections,
    )
    return way, near


def _of_curve(path: Path, rows: slice) -> list[tuple[int, float, Array]]:
    """Return the corners of one curve: the row each is before, its time [s] and its stretch (and that across)."""
    time = path.time_s[rows]
    if not np.all(np.isfinite(time)):
        return []
    moved, still = path.moved(rows), path.still[rows]
    general = path.mode[rows.start] == GENERAL
    ways = np.stack([path.stretch[rows], path.across[rows]], axis=1) if general else moved[:, None]
    led = int(general and not np.array_equal(moved, path.stretch[rows]))
    reach = float(np.ptp(moved))
    turns = np.flatnonzero(np.diff(path.up[rows]) != 0)
    edges = [-1, *turns.tolist(), len(time)]
    found = []
    for start, top, stop in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        before, after = np.arange(max(start + 1, top - _MOST), top), np.arange(top + 1, min(top + _MOST + 1, stop))
        # A hold ends what goes at one speed.
        before = before[np.cumsum(still[before][::-1])[::-1] == 0]
        after = after[np.cumsum(still[after]) == 0]
        if min(len(before), len(after)) < _FEWEST or still[top]:
            continue
        steps = np.abs(np.diff(moved[start + 1 : stop]))
        steps[top - start - 2 : top - start] = 0.0  # those beside the turn
        corner = _met(time, ways, led, (before, after), reach, _GAP * float(np.max(steps)))
        if corner is not None:
            found.append((rows.start + corner[0], *corner[1:]))
    return found


def _met(
    time: Array, ways: Array, led: int, sides: tuple[Ints, Ints], reach: float, farthest: float
) -> tuple[int, float, Array] | None:
    """Return the row before which the lines through both ``sides`` of a turn meet, the time and the stretches there.

    ``ways`` (n, k) are the stretches, of which that ``led`` turns, after a way of some ``reach``. None where the sides
    are not straight, or meet no farther than was read, or farther than ``farthest`` along the way between readings.
    """
    top = int(sides[0][-1]) + 1
    (before, rise), (after, fall) = (_through(time[side] - time[top], ways[side, led], 1)[:2] for side in sides)
    if rise * fall >= 0.0:
        return None
    since = float((before - after) / (fall - rise))
    row, clock = (top if since < 0.0 else top + 1), float(time[top] + since)
    unread = abs(rise) * (clock - time[row - 1]) + abs(fall) * (time[row] - clock)
    beyond = np.min(np.sign(rise) * (before + rise * since - ways[top - 1 : top + 2, led]))
    if not time[row - 1] < clock < time[row] or unread > farthest or beyond < _SLIGHT * reach:
        return None
    lines, bows = ([_through(time[side] - clock, ways[side], order) for side in sides] for order in (1, 3))
    left = sum(bow[3] for bow in bows) / (sum(map(len, sides)) - 8)
    # Three standard deviations of a reading, as sides that may be bent leave them.
    clear = _CLEAR * np.maximum(np.sqrt(left), _DIGITS * reach)
    for line, bow in zip(lines, bows, strict=True):
        if np.any(np.abs(line[0] - bow[0]) > clear * np.sqrt(bow[2])):
            return None  # a turn that is rounded, or a speed that is not steady
    off = abs((before if row > top else after) - ways[top, led])
    spread = clear * np.sqrt(lines[0][2] + lines[1][2])
    if off > clear[led] * np.sqrt(1.0 + lines[row == top][2]) or np.any(np.abs(lines[0][0] - lines[1][0]) > spread):
        return None
    return (row, clock, 0.5 * (lines[0][0] + lines[1][0])) if beyond > 0.5 * spread[led] else None


def _through(since: Array, ways: Array, order: int) -> tuple[Array, Array, float, Array]:
    """Return what polynomials through readings (m,) or (m, k) have where the time ``since`` it is nought: values (k,)
    and slopes, the variance of the values as a share of a reading's, and the squares that are left (k,)."""
    scale = float(np.max(np.abs(since)))
    powers = np.vander(since / scale, order + 1)
    inverse = np.linalg.solve(powers.T @ powers, powers.T)
    found = inverse @ ways
    left = np.sum((ways - powers @ found) ** 2, axis=0)
    return found[-1], found[-2] / scale, float(np.sum(inverse[-1] ** 2)), left
