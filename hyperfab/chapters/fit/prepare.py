"""What may be done to readings before a fit: nothing unasked but to end them where the specimen broke. All is told."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.cases.reading import ReadingCase
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_tests import TestData
from hyperfab.io.units import quantity_of
from hyperfab.materials.modes import MODES, SIMPLE_SHEAR, way
from hyperfab.numerics.hygiene import branches, cycles

#: What a preload may be stated as, and what an error shows.
_PRELOADS = ("stress", "membrane-stress", "force")
#: A specimen broke where it carried the one share of its peak, then no more than the other to the end of the record,
#: while it came back by less than the third of its whole way.
_HELD, _GONE, _STILL = 0.5, 0.05, 0.003

#: The slope at a preload is that of the rows up to so many times it, or one more where they do not go on to so many
#: times it, and of so many rows at least.
_TANGENT, _RISES, _TANGENT_ROWS = 3.0, 1.5, 3
#: Columns of which a resampled test has the means, and those of which it has what the first row tells.
_MEANS = ("stretch", "stress", "stretch2", "stress2", "stress_sd", "time_s", "temperature_degC", "rate_1_s")
_FIRSTS = ("lines", "branch", "cycle")
#: A specimen that was mounted under load was no more than so many times as long as at rest, nor as short.
_MOUNTED = 2.0


@dataclass(frozen=True)
class Steps:
    """What was asked for: ``branch`` and ``cycle`` choose rows, ``zero`` and ``preload`` move the origin."""

    branch: str = "all"
    cycle: str = "all"
    zero: bool = False
    preload: str | None = None
    resample: int | None = None


def steps_of(case: ReadingCase) -> Steps:
    """Return the steps that a case asks for; UsageError where its preload is none."""
    if case.preload is not None:
        stated(case.preload)
    return Steps(case.branch, case.cycle, case.zero, case.preload, case.resample)


def stated(preload: str) -> tuple[float, str]:
    """Return a preload and its kind: a stress, a force per width, or a force, as ISO 13934-1 states it.

    >>> stated("0.1N"), stated("0.002 N/mm")
    ((0.1, 'force'), (0.002, 'membrane-stress'))
    """
    try:
        kind, value = quantity_of(preload, _PRELOADS, option="--preload")
    except UsageError:
        forms = "a stress, 0.002MPa, a force per width, 0.5 N/mm, or a force, 0.1N"
        raise UsageError(f"--preload {preload}: write {forms}") from None
    return value, kind


def _preload_of(curve: TestData, preload: str) -> float:
    """Return the preload in the unit of a test's stress: MPa, or N/mm where no thickness is known."""
    value, kind = stated(preload)
    if kind == "force":
        if curve.mode == SIMPLE_SHEAR:
            raise UsageError(
                f"--preload {preload}: a force is over the area that is sheared, not over the width of {curve.source}; "
                f"give it as a stress, 0.002MPa"
            )
        if curve.width_mm is None:
            raise UsageError(
                f"--preload {preload}: a force needs the width of the specimen, which {curve.source} "
                f"does not state; give --width 50mm"
            )
        value, kind = value / curve.width_mm, "membrane-stress"
    thickness = curve.thickness_mm or 1.0
    if kind == "membrane-stress":
        return value if curve.membrane else value / thickness
    return value * thickness if curve.membrane else value


def settled(steps: Steps) -> set[str]:
    """Return the kinds of oddity (``hyperfab.numerics.hygiene``) that the steps take out or count from."""
    chosen = {
        "unloading": steps.branch != "all",
        "cycles": steps.cycle != "all",
        "offset": steps.zero or steps.preload is not None,
    }
    return {kind for kind, done in chosen.items() if done}


def prepare(
    curves: Sequence[TestData],
    steps: Steps,
    left_out: Counter[str],
    told: list[str],
    nothing_left: bool = False,
) -> list[TestData]:
    """Return the curves after the steps, telling each in ``told`` and each row left out in ``left_out``.

    InputError where no row is left, unless there may be ``nothing_left``.
    """
    found = [whole(curve, left_out) for curve in curves]
    if steps.cycle != "all":
        there = sorted({int(number) for curve in found for number in _numbered(curve)})
        remedy = f"there are cycles {there[0]} to {there[-1]}" if len(there) > 1 else "there is one cycle"
        reason = f"not cycle {steps.cycle}"
        found = _select(found, lambda curve: _of_cycle(curve, steps.cycle), left_out, reason, remedy, nothing_left)
        told.append(f"cycle {steps.cycle} of each test")
    if steps.branch != "all":
        wanted = 1 if steps.branch == "load" else -1
        reason = f"not on the {steps.branch} branch"
        found = _select(found, lambda curve: branch_of(curve) == wanted, left_out, reason, nothing_left=nothing_left)
        told.append(f"the {steps.branch} branch of each test")
    if steps.zero:
        found = [_zeroed(curve) for curve in found]
        told.append("stretch and stress counted from the first row of each test")
    if steps.preload is not None:
        found = [_after_preload(curve, _preload_of(curve, steps.preload), left_out) for curve in found]
        told.append(
            f"slack taken out: rows before the load reaches {steps.preload} left out, stretch counted from where it "
            "would be zero by its slope there"
        )
    if steps.resample is not None:
        found = [_resampled(curve, steps.resample) for curve in found]
        told.append(f"each branch resampled to {steps.resample} points evenly spaced in stretch")
    return found


def whole(curve: TestData, left_out: Counter[str], named: str = "") -> TestData:
    """Return the curve up to the break of its specimen; what a machine records behind it is of its load cell alone."""
    count = len(curve.stretch)
    end = broken(curve.principal, curve.stress) if way(curve.mode) in MODES else count
    if end == count:
        return curve
    left_out[f"{named}behind the break of the specimen"] += count - end
    return curve.take(np.arange(end))


def broken(stretch: Array, stress: Array) -> int:
    """Return the first row behind the break of a specimen, the number of rows where it stayed whole.

    No specimen that is let go loses its stress at the stretch it had, to carry nothing to the end.

    >>> broken(np.array([1.0, 1.5, 2.0, 2.01, 2.02, 1.0]), np.array([0.0, 0.6, 1.0, 0.2, 0.01, 0.0]))
    3
    >>> broken(np.array([1.0, 1.5, 2.0, 1.5, 1.1]), np.array([0.0, 0.6, 1.0, 0.2, 0.0]))
    5
    >>> broken(np.array([1.0, 1.2, 1.06, 0.93]), np.array([0.4, 1.0, 0.6, 0.0]))
    4
    """
    size, away = np.abs(stress), np.log(stretch)
    peak, count = float(size.max(initial=0.0)), len(stress)
    gone = 1 + int(np.flatnonzero(size > _GONE * peak)[-1]) if peak > 0.0 else count
    if gone == count:
        return count
    held = int(np.flatnonzero(size[:gone] >= _HELD * peak)[-1])
    away = np.sign(away[held]) * away  # let go past its rest a pulled specimen is shorter, not farther away
    return held + 1 if away[gone] >= away[held] - _STILL * float(np.ptp(np.abs(away))) else count


def _select(
    curves: Sequence[TestData],
    wanted: Callable[[TestData], Array],
    left_out: Counter[str],
    reason: str,
    remedy: str = "choose the other branch",
    nothing_left: bool = False,
) -> list[TestData]:
    found = []
    for curve in curves:
        rows = np.flatnonzero(wanted(curve))
        if len(rows) < len(curve.stretch):
            left_out[reason] += len(curve.stretch) - len(rows)
        if len(rows):
            found.append(curve.take(rows))
    if not found and not nothing_left:
        raise InputError(
            f"no row is left: all are {reason}",
            file=curves[0].source,
            remedy=remedy,
        )
    return found


def branch_of(curve: TestCurve) -> Ints:
    """Return 1 on loading and -1 on unloading: as the file says, else by the turns of the stretch."""
    return branches(curve.principal) if curve.branch is None else curve.branch


def _numbered(curve: TestData) -> Ints:
    """Return the cycle of each row: as the file says, else counted by the turns of the stretch."""
    return cycles(curve.principal, branch_of(curve)) if curve.cycle is None else curve.cycle


def _of_cycle(curve: TestData, wanted: str) -> Array:
    cycle = _numbered(curve)
    number = {"first": int(cycle.min()), "last": int(cycle.max())}.get(wanted)
    return np.asarray(cycle == (int(wanted) if number is None else number))


def _zeroed(curve: TestData) -> TestData:
    first2 = None if curve.stretch2 is None else float(curve.stretch2[0])
    return replace(
        _counted_from(curve, float(curve.stretch[0]), first2),
        stress=curve.stress - curve.stress[0],
        stress2=None if curve.stress2 is None else curve.stress2 - curve.stress2[0],
    )


def _counted_from(curve: TestData, origin: float, origin2: float | None) -> TestData:
    """Return the curve with its stretches over those of the new rest; a shear strain is a difference."""
    return replace(
        curve,
        stretch=curve.stretch - origin if curve.mode == "simple-shear" else curve.stretch / origin,
        stretch2=None if curve.stretch2 is None or origin2 is None else curve.stretch2 / origin2,
    )


def _after_preload(curve: TestData, preload: float, left_out: Counter[str]) -> TestData:
    """Leave out what comes before the stress, pulling or pressing, passes the preload for good, and count the stretch
    from rest: lengths of the slack are no strain, that which the preload itself takes is.

    Rest is where the stress would be zero by its slope there, as testing standards take a toe out (ASTM D638, Annex
    A1), but not outside the rows below the preload, if any. Counted from the preload, a law, which is without stress
    at rest, would read stiff: of a knit whose preload is 2 % of its largest load by a third.
    """
    # Of ends as far on both sides the first, whatever their last digits.
    peak = int(np.argmax(np.round(np.abs(np.log(curve.principal)), 9)))
    stress = -curve.stress if curve.principal[peak] < 1.0 else curve.stress
    below = np.flatnonzero(stress[: peak + 1] < preload)
    start = int(below[-1]) + 1 if len(below) else 0
    if start > peak:
        raise InputError(
            f"never reaches the preload of {preload:g} {curve.stress_unit}",
            file=curve.source,
            remedy="give a smaller --preload",
        )
    share = (preload - stress[start - 1]) / (stress[start] - stress[start - 1]) if start else 0.0

    def there(column: Array) -> float:
        return float(column[start - 1] + share * (column[start] - column[start - 1]) if start else column[0])

    if start:
        left_out["slack, before the preload"] += start
    level = preload if start else float(stress[0])
    way = np.arange(start, peak + 1)
    near = int(np.argmax(np.append(stress[way], np.inf) > _TANGENT * level))
    # A machine that holds the preload before it pulls tells no slope until it does.
    near += bool(np.max(stress[way[:near]], initial=0.0) < _RISES * level)
    way = way[: max(_TANGENT_ROWS, near)]
    origin, back = there(curve.stretch), 0.0
    tells = len(way) >= _TANGENT_ROWS and np.ptp(curve.stretch[way]) > 0.0
    slope = float(np.polyfit(curve.stretch[way], stress[way], 1)[0]) if tells else 0.0
    if slope * (curve.principal[peak] - 1.0) > 0.0:
        back = -level / slope
        if start:
            before = curve.stretch[: start + 1] - origin
            back = max(back, float(before.min())) if back < 0.0 else min(back, float(before.max()))
        elif curve.mode != "simple-shear" and not 1.0 / _MOUNTED < 1.0 + back / origin < _MOUNTED:
            raise InputError(
                f"begins at {level:.3g} {curve.stress_unit}, from which its slope tells no length at rest",
                file=curve.source,
                remedy="leave --preload out, or give a file that begins at a smaller load",
            )
    kept = curve.take(np.arange(start, len(curve.stretch)))
    origin2 = None
    if curve.stretch2 is not None:
        across = float(np.polyfit(curve.stretch[way], curve.stretch2[way], 1)[0]) if back else 0.0
        origin2 = there(curve.stretch2) + across * back
    return _counted_from(kept, origin + back, origin2)


def _resampled(curve: TestData, points: int) -> TestData:
    """Return each branch as means of the readings around ``points`` stretches: every stretch counts the same."""
    branch = branch_of(curve)
    parts = [_means(curve.take(np.flatnonzero(branch == side)), points) for side in (1, -1) if (branch == side).any()]
    joined: dict[str, Any] = {}
    for name in (*_MEANS, *_FIRSTS):
        columns = [getattr(part, name) for part in parts]
        joined[name] = None if any(column is None for column in columns) else np.concatenate(columns)
    return replace(parts[0], **joined)


def _means(curve: TestData, points: int) -> TestData:
    low, high = float(curve.stretch.min()), float(curve.stretch.max())
    number = np.minimum(((curve.stretch - low) / max(high - low, 1e-300) * points).astype(int), points - 1)
    rows = [np.flatnonzero(number == k) for k in np.unique(number)]
    told = {name: column for name in (*_MEANS, *_FIRSTS) if (column := getattr(curve, name)) is not None}
    columns: dict[str, Any] = {
        name: np.array([column[own].mean() if name in _MEANS else column[own[0]] for own in rows])
        for name, column in told.items()
    }
    return replace(curve, **columns)
