"""Measured tests of a fabric as rows: how specimens were led, which are replicates, what a residual may ride on."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TypeVar

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.curve import TestCurve, sheared
from hyperfab.loop.gauges import factors_of
from hyperfab.loop.noise_estimate import MAD, third_differences
from hyperfab.loop.problem import Curve
from hyperfab.loop.replicates import ride
from hyperfab.loop.thresholds import MACHINE, SHARE, clearly
from hyperfab.materials.effects.path import GENERAL, MODE_NAMES, SIMPLE_SHEAR, Path
from hyperfab.numerics.doubt import moving

T = TypeVar("T", bound=TestCurve)

_SMOOTH_DEGREE = 5
#: Rows slower than this share of a test's mean pace stand still.
_STANDS = 0.1
#: Paces within this factor count as one, where none is stated: machines and hands keep one so well. Rates that were
#: chosen to differ are further apart.
ONE_PACE = 1.5
#: Readings of one way, or one hold, that tell as much of it as any number.
_A_WAY = 300
#: Sizes of specimens within this factor count as one: those cut by hand are a few percent apart.
_ONE_SIZE = 1.2
#: A test was led by its load where that stands in more than this share of the readings.
_MOSTLY = 0.75


def path_of(tests: Sequence[TestCurve]) -> tuple[Path, Array]:
    """Return how all specimens were led, one after the other, and the strain rate of each row [1/s], nan if unknown."""

    def column(name: str) -> Array:
        parts = []
        for test in tests:
            value = getattr(test, name)
            parts.append(np.full(len(test.stretch), np.nan) if value is None else np.asarray(value, dtype=np.float64))
        return np.concatenate(parts)

    count = [len(test.stretch) for test in tests]
    time = np.concatenate([_clock(test) for test in tests])
    mode, stretch = np.repeat([MODE_NAMES.index(test.mode) for test in tests], count), column("stretch")
    thickness, width, length = np.array([_size(test) for test in tests]).T
    # Of one cloth, whose thickness no test states, the widths tell it.
    section = width if np.all(np.isnan(thickness)) else width * thickness
    path = Path(
        starts=tuple(int(v) for v in np.concatenate([[0], np.cumsum(count)])),
        mode=mode,
        stretch=np.where(mode == SIMPLE_SHEAR, sheared(stretch), stretch),
        across=column("stretch2"),
        time_s=time,
        temperature_degC=column("temperature_degC"),
        angle_deg=np.repeat([float(test.angle_deg) for test in tests], count),
        branch=np.nan_to_num(column("branch")).astype(np.int64),
        lengths_mm=tuple(map(float, length)),
        sections=tuple(map(float, section)),
    )
    speed = column("rate_1_s")
    for rows in path.curves:
        if np.all(np.isfinite(speed[rows])) or not np.all(np.isfinite(time[rows])):
            continue
        part, span = np.abs(np.diff(path.moved(rows))), np.diff(time[rows])
        going = (part > 1e-9) & ~path.still[rows][1:]
        speed[rows] = float(np.sum(part[going])) / max(float(np.sum(span[going])), 1e-12)
    return path, speed


def _clock(test: TestCurve) -> Array:
    """Return the time of each row; from the rate where that alone is known."""
    if test.time_s is not None and np.all(np.isfinite(test.time_s)):
        return np.asarray(test.time_s - test.time_s[0], dtype=np.float64)
    if test.rate_1_s is None or not np.all(np.asarray(test.rate_1_s) > 0.0):
        return np.full(len(test.stretch), np.nan)
    stretch = test.stretch
    if test.mode == MODE_NAMES[GENERAL] and test.stretch2 is not None:
        stretch = moving(stretch, test.stretch2)
    step = np.abs(np.diff(stretch)) / np.asarray(test.rate_1_s)[1:]
    return np.concatenate([[0.0], np.cumsum(step)])


def curves_of(
    path: Path, tests: Sequence[TestCurve], stress: Array, ridden: Collection[str] = ()
) -> tuple[tuple[Curve, ...], Array, Array]:
    """Return the curves, the rows that state a transverse stretch, and the readings: stresses, then those.

    Tests that differ in a ``ridden`` state are no replicates.
    """
    curves, rows, extra = [], [], []
    at = len(stress)
    setups, sizes = setups_of(path, tests, ridden=ridden), _sizes_of(tests)
    for test, place, setup, size in zip(tests, path.curves, setups, sizes, strict=True):
        cuts = _corners(path, place)
        time = path.time_s[place]
        rising = bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0))
        specimen = test.specimen or test.source
        lam = path.moved(place)
        abscissa = time if rising else lam
        curves.append(
            Curve(test.source, place.start, place.stop, abscissa, cuts, setup, specimen, place=lam, size=size)
        )
        if test.contraction is not None and np.all(np.isfinite(test.contraction)):
            count = place.stop - place.start
            rows.append(np.arange(place.start, place.stop))
            extra.append(test.contraction)
            shifted = tuple(cut - place.start + at for cut in cuts)
            curves.append(
                Curve(f"{test.source} transverse", at, at + count, abscissa, shifted, setup, specimen, 1, lam)
            )
            at += count
    if not rows:
        return tuple(curves), np.empty(0, dtype=np.int64), stress
    order = sorted(curves, key=lambda curve: curve.start)
    return tuple(order), np.concatenate(rows), np.concatenate([stress, *extra])


def _corners(path: Path, place: slice) -> tuple[int, ...]:
    """Return the rows of a test at which its way turns, or it begins or ceases to stand still."""
    corners = (np.diff(path.up[place]) != 0) | (np.diff(path.still[place].astype(np.int64)) != 0)
    return tuple(int(i) for i in place.start + 1 + np.flatnonzero(corners))


def hanging(path: Path, curves: Sequence[Curve], stress: Array) -> Flags:
    """Return which rows (n,) are of sheets that hang slack where they would have to push: those of curves that pull,
    without readings clearly below zero. What is thick enough pushes back. A crosshead that comes back a hair too far
    leaves a sheet as slack as before."""
    found = ~path.pressed
    for curve in curves:
        if curve.channel == 0:
            read = stress[curve.rows]
            apart, _ = third_differences(stress, curve)
            noise = max(MAD * float(np.median(np.abs(apart))) if len(apart) else 0.0, MACHINE * float(np.max(read)))
            found[curve.rows] &= float(np.min(read)) > -np.sqrt(clearly()) * noise
    return found


def thinned(test: T) -> T:
    """Return a test with so many readings of each way at most, evenly, and of each hold, closer after it begins.

    A machine that logs a thousand times a second reads the same curve more often than any law bends. Where the way
    turns, a hold begins or ends, the readings stay.
    """
    if len(test.stretch) <= _A_WAY:
        return test
    path, _ = path_of([test])
    [whole] = path.curves
    kept = []
    for piece in Curve(test.source, whole.start, whole.stop, path.stretch, _corners(path, whole)).pieces():
        count = piece.stop - piece.start
        some = np.linspace(0.0, count - 1.0, min(count, _A_WAY))
        if count > _A_WAY and path.still[piece].all():
            some = np.concatenate([some[::2], np.geomspace(1.0, count, _A_WAY // 2) - 1.0])
        kept.append(piece.start + np.unique(some.round().astype(np.int64)))
    return test.take(np.concatenate(kept))


def setups_of(path: Path, tests: Sequence[TestCurve], *, sized: bool = True, ridden: Collection[str] = ()) -> list[str]:
    """Return what each test shares with its replicates: its state, its size, and the whole way it was led, in both
    stretches; of one that creeps the load it was led by.

    What grips take is told by the length, what a load cell is off by the section: tests of other sizes are no
    replicates, unless sizes do not count (``sized``). A state that no law knows, as the humidity, keeps specimens
    apart where it is stated alike for several; what each has of its own, as its mass, only where their stiffness has
    ``ridden`` on it.
    """
    apart = [name for name in _others(tests) if name in ridden or _is_shared(name, tests)]
    found: list[tuple[str, float, float, Array, tuple[Array, Array], str]] = []
    for test, rows in zip(tests, path.curves, strict=True):
        how, pace = _how(test, path.moved(rows), apart)
        way = _way(path, rows)
        size, load = _size(test), _hung(test)
        same = (
            name
            for other_how, other_pace, other_load, other_size, other_way, name in found
            if other_how == how
            and abs(load - other_load) <= SHARE * max(load, other_load)
            and abs(np.log(pace / other_pace)) <= np.log(ONE_PACE)
            and not (sized and _is_larger_or_smaller(size, other_size))
            and _is_same_way(way, other_way)
        )
        found.append((how, pace, load, size, way, next(same, f"{how} {len(found)}")))
    return [name for *_, name in found]


def _hung(test: TestCurve) -> float:
    """Return the load that a test was led by, as one that creeps: the stretch goes on while the load stands; else 0."""
    load = np.abs(test.stress)
    most = float(np.median(load))
    stands = np.abs(load - most) <= 2.0 * MACHINE * most
    creeps = np.mean(stands) > _MOSTLY and np.ptp(test.stretch[stands]) > SHARE * np.ptp(test.stretch)
    return most if creeps else 0.0


def _size(test: TestCurve) -> Array:
    """Return thickness, width and gauge length of a test's specimen [mm], nan where they are not stated."""
    return np.array([test.thickness_mm, test.width_mm, test.gauge_length_mm], dtype=np.float64)


def _is_larger_or_smaller(one: Array, other: Array) -> bool:
    """Whether a specimen is of another size than another, in what is stated of both."""
    return bool(np.any(np.abs(np.log(one / other)) > np.log(_ONE_SIZE)))


def _sizes_of(tests: Sequence[TestCurve]) -> list[str]:
    """Return what each test shares with those of specimens of its size, as far as that is stated."""
    found: list[Array] = []
    names = []
    for test in tests:
        size = _size(test)
        same = (
            k
            for k, one in enumerate(found)
            if np.array_equal(np.isnan(size), np.isnan(one)) and not _is_larger_or_smaller(size, one)
        )
        names.append(str(next(same, len(found))))
        found += [size] if names[-1] == str(len(found)) else []
    return names


def _is_shared(name: str, tests: Sequence[TestCurve]) -> bool:
    """Whether a state is stated alike for several tests: each value of it for two, on average."""
    return 2 * len({test.others.get(name) for test in tests}) <= len(tests)


def ridden_states(tests: Sequence[TestCurve], curves: Sequence[Curve], measured: Array) -> tuple[str, ...]:
    """Return the states that each specimen has of its own and no law knows, on which the stiffness of those that were
    otherwise led alike rides.

    One strip at each of four humidities is no set of replicates, though none shares its humidity with another.
    """
    names = [name for name in _others(tests) if not _is_shared(name, tests)]
    read = [curve for curve in curves if curve.channel == 0]
    led: dict[str, list[int]] = {}
    for k, curve in enumerate(read):
        led.setdefault(curve.setup, []).append(k)
    groups = [(np.array(one), np.log(factors_of(measured, [read[k] for k in one]))) for one in led.values()]
    found = []
    for name in names:
        values = np.array([test.others.get(name, np.nan) for test in tests])
        if ride([(values[members], stiffness) for members, stiffness in groups], len(names)):
            found.append(name)
    return tuple(found)


def _how(test: TestCurve, stretch: Array, states: Sequence[str]) -> tuple[str, float]:
    """Return mode, whether it pulls or presses, direction, temperature with the ``states`` that no law knows, and
    stated rate of a test, rounded; and where no rate is stated, its pace [1/s], 1 where it has no clock."""
    temperature = "-" if test.temperature_degC is None else f"{float(np.mean(test.temperature_degC)):.0f}"
    surroundings = "/".join([temperature, *(f"{test.others.get(name)}" for name in states)])
    speed, pace = "-" if test.rate_1_s is None else f"{float(np.median(test.rate_1_s)):.2g}", 1.0
    span = 0.0 if test.time_s is None else float(test.time_s[-1] - test.time_s[0])
    if speed == "-" and test.time_s is not None and span > 0.0:
        moved, took = np.abs(np.diff(stretch)), np.diff(test.time_s)
        # What waits at a stretch, however long, was pulled there at its own pace.
        going = moved * span > _STANDS * float(np.sum(moved)) * took
        pace = float(np.sum(moved[going]) / np.sum(took[going])) if np.any(going) else 1.0
        speed = "by its clock"
    way = "pulls" if np.max(stretch) - 1.0 >= 1.0 - np.min(stretch) else "presses"
    return f"{test.mode} {way} {test.angle_deg:.0f} {surroundings} {speed}", pace


def _way(path: Path, rows: slice) -> tuple[Array, Array]:
    """Return the strains (turns, 2) at which a test turned, along the pull and across where that is given, and how far
    beyond they may be (turns, 2): by the longer step between readings there.

    Not those at which it ended, but where both stretches are led: what two tests along one axis have in common does not
    hang on which of them went on.
    """
    turns = rows.start + np.flatnonzero(np.diff(path.up[rows]) != 0)
    last = [rows.stop - 1] if path.mode[rows.stop - 1] == GENERAL else []
    ends = np.array([*turns, *last], dtype=np.int64)
    across = np.where(path.mode[ends] == GENERAL, path.across[ends], 1.0)
    turned = np.log(np.stack([path.stretch[ends], across], axis=1))
    steps = np.abs(np.diff(np.log(path.stretch[rows]), prepend=np.nan))
    beyond = np.zeros_like(turned)
    beyond[: len(turns), 0] = np.fmax(steps[turns - rows.start], steps[turns - rows.start + 1])
    return turned, beyond


def _is_same_way(one: tuple[Array, Array], other: tuple[Array, Array]) -> bool:
    """Whether two tests turned at the same places, but for a share of how far they went or the step of readings."""
    (turned, beyond), (others, as_far) = one, other
    if turned.shape != others.shape:
        return False
    far = np.max(np.abs([turned, others]), initial=0.0)
    return bool(np.all(np.abs(turned - others) <= np.maximum(np.maximum(beyond, as_far), SHARE * far)))


def states_of(path: Path, tests: Sequence[TestCurve], speed: Array) -> dict[str, Array]:
    """Return the state variables that a residual may ride on, by name."""
    cycle = np.ones(len(path.stretch))
    for rows, test in zip(path.curves, tests, strict=True):
        if test.cycle is not None:
            cycle[rows] = test.cycle
        else:
            up = path.up[rows]
            cycle[rows] = 1.0 + np.concatenate([[0], np.cumsum((up[1:] > 0) & (up[:-1] < 0))])
    count = [len(test.stretch) for test in tests]
    return {
        "stretch": path.stretch,
        "branch": path.up.astype(np.float64),
        "cycle": cycle,
        "time_s": path.time_s,
        "log rate": np.log(np.maximum(speed, 1e-12)),
        "temperature_degC": path.temperature_degC,
        "direction_deg": path.angle_deg,
        "mode": path.mode.astype(np.float64),
        **{name: np.repeat([test.others.get(name, np.nan) for test in tests], count) for name in _others(tests)},
    }


def _others(tests: Sequence[TestCurve]) -> list[str]:
    """Return the names of the states that tests tell and no law knows."""
    return [*dict.fromkeys(name for test in tests for name in test.others)]


def smooth_of(path: Path, rows: int) -> Array:
    """Return polynomials of the strain, a set for each mode in the data: what a poor elastic law leaves."""
    columns = []
    for mode in np.unique(path.mode):
        there = path.mode == mode
        reach = max(float(np.max(path.stretch[there])) - 1.0, 1e-9)
        strain = np.where(there, (path.stretch - 1.0) / reach, 0.0)
        columns += [strain**power for power in range(1, _SMOOTH_DEGREE + 1)]
        if mode == GENERAL:
            other = np.where(there, path.across - 1.0, 0.0) / max(float(np.ptp(path.across[there])), 1e-9)
            columns += [strain**m * other**n for m in range(3) for n in range(1, 3)]
    found = np.zeros((rows, len(columns)))
    found[: len(path.stretch)] = np.stack(columns, axis=1)
    return found
