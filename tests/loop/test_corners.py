"""Cyclic tests whose turning points were not read: their clock tells where two steady speeds meet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erf

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.materials.effects.corners import cornered
from hyperfab.materials.effects.path import GENERAL, Path, uniaxial_pull
from hyperfab.materials.registry import law

#: Stretches at which the tests turn, and their speed [1/s].
WAY, SPEED = np.array([1.0, 1.25, 1.06, 1.25, 1.06, 1.5, 1.06, 1.5, 1.06, 1.7, 1.06, 1.7, 1.1]), 0.02
TURNS = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(WAY)))]) / SPEED
C10, C20, NOISE = 0.12, 0.015, 2e-4


def led(time: Array) -> Array:
    return np.interp(time, TURNS, WAY)


def path_of(time: Array, stretch: Array) -> Path:
    return replace(uniaxial_pull(stretch), time_s=time)


def inserted(path: Path) -> tuple[Array, Array]:
    """Return times [s] and stretches of the rows that were not read."""
    way, near = cornered(path)
    new = np.flatnonzero(np.diff(near, prepend=-1) == 0)
    for name in ("stretch", "time_s", "mode"):
        assert np.array_equal(np.delete(getattr(way, name), new), getattr(path, name))
    return way.time_s[new], way.stretch[new]


@pytest.mark.parametrize("start", [0.1, 0.35, 0.6, 0.85])
def test_a_corner_between_readings_is_where_both_ways_meet(start: float) -> None:
    """Two curves, the second without a clock: rows, curves and what was read stay where they were."""
    time = np.arange(start, TURNS[-1], 0.9)
    times, stretches = inserted(path_of(time, led(time)))
    missing = np.min(np.abs(time[:, None] - TURNS[1:-1]), axis=0) * SPEED > 5e-4 * np.ptp(WAY)
    assert times == pytest.approx(TURNS[1:-1][missing], abs=1e-9)
    assert stretches == pytest.approx(WAY[1:-1][missing], abs=1e-12)
    two = path_of(np.concatenate([time, np.full_like(time, np.nan)]), np.tile(led(time), 2))
    two = replace(two, starts=(0, len(time), 2 * len(time)), branch=np.tile(path_of(time, time).branch, 2))
    way, near = cornered(two)
    assert way.starts == (0, len(time) + len(times), 2 * len(time) + len(times))
    assert np.array_equal(near[way.starts[1] :], np.arange(len(time), 2 * len(time)))


def test_digits_of_clock_and_stretch_move_a_corner_by_no_more_than_their_own_size() -> None:
    random = np.random.default_rng(1)
    time = np.sort(random.uniform(0.0, TURNS[-1], 420)).round(2)
    times, stretches = inserted(path_of(time, led(time + random.uniform(-0.005, 0.005, len(time))).round(4)))
    assert len(times) >= 8
    # 0.01 s at this speed are 0.0002.
    assert np.max(np.abs(stretches - WAY[np.argmin(np.abs(times[:, None] - TURNS), axis=1)])) < 2e-4


CLOCK = np.arange(0.0, 60.0, 0.25)
THERE_AND_BACK = 1.5 - 0.5 * np.abs((CLOCK % 20.0) / 10.0 - 1.0)
#: Up in 10 s, a wait of 3 s at the top, back.
WAITS = np.interp(CLOCK % 23.0, [0.0, 10.0, 13.0, 23.0], [1.0, 1.5, 1.5, 1.0])


@pytest.mark.parametrize(
    ("clock", "stretch"),
    [
        (CLOCK, THERE_AND_BACK),
        (np.full_like(CLOCK, np.nan), THERE_AND_BACK + 0.0 * CLOCK),
        (CLOCK[CLOCK % 20.0 < 19.5], WAITS[CLOCK % 20.0 < 19.5]),
        # A log that leaves out what does not change: waits without a reading.
        (CLOCK[np.diff(WAITS, prepend=0.0) != 0.0][:75], WAITS[np.diff(WAITS, prepend=0.0) != 0.0][:75]),
    ],
    ids=["read", "no clock", "waits", "waits that were not kept"],
)
def test_no_row_is_added_where_a_turn_was_read_or_cannot_be_told(clock: Array, stretch: Array) -> None:
    path = path_of(clock, stretch)
    assert cornered(path)[0] is path


@pytest.mark.parametrize("rows", [12, 16, 20, 30, 60, 100, 400])
@pytest.mark.parametrize("noise", [0.0, 3e-4])
def test_a_sine_has_no_corner(rows: int, noise: float) -> None:
    random = np.random.default_rng(rows)
    for evenly in (True, False):
        for start in random.uniform(0.0, 1.0, 8):
            time = (np.arange(5 * rows) + start) / rows if evenly else np.sort(random.uniform(0.0, 5.0, 5 * rows))
            stretch = 1.25 - 0.25 * np.cos(2.0 * np.pi * time) + noise * random.standard_normal(len(time))
            path = path_of(time, stretch)
            assert cornered(path)[0] is path


def test_sheets_pulled_both_ways_turn_in_both() -> None:
    time = np.arange(0.35, TURNS[-1], 0.9)
    wanted = inserted(path_of(time, led(time)))
    for other in (1.0 + 0.3 * (led(time) - 1.0), np.full_like(time, 1.1)):
        for along, across in ((led(time), other), (other, led(time))):
            path = replace(path_of(time, along), across=across, mode=np.full(len(time), GENERAL))
            way, near = cornered(path)
            new = np.flatnonzero(np.diff(near, prepend=-1) == 0)
            assert way.time_s[new] == pytest.approx(wanted[0], abs=1e-9)
            both = np.stack([along, across]), np.stack([way.stretch, way.across])[:, new]
            moved = int(np.argmax(np.ptp(both[0], axis=1)))
            assert both[1][moved] == pytest.approx(wanted[1], abs=1e-9)
            held = np.ptp(other) == 0.0
            assert both[1][1 - moved] == pytest.approx(1.1 if held else 1.0 + 0.3 * (wanted[1] - 1.0), abs=1e-9)


def elastic(lam: Array) -> tuple[Array, Array]:
    """Return stress and energy of a strip of Yeoh's law."""
    x = lam**2 + 2.0 / lam - 3.0
    return 2.0 * (lam - lam**-2) * (C10 + 2.0 * C20 * x), C10 * x + C20 * x * x


def softened(time: Array) -> Array:
    """Ogden and Roxburgh's stress: 1/r 0.45, m 0.01 MPa, beta 0.1; the largest stretch by the turns gone through."""
    stress, energy = elastic(led(time))
    gone = [np.max(WAY[:-1][TURNS[:-1] <= t], initial=1.0) for t in time]
    _, most = elastic(np.maximum(gone, led(time)))
    return stress * (1.0 - 0.45 * erf((most - energy) / (0.01 + 0.1 * most)))


def rubbed(time: Array) -> Array:
    """Dahl's friction of 0.012 MPa that turns over a strain of 0.015, exact from turn to turn, beside the law."""
    slip, strain = 0.012, 0.015
    before, found = 0.0, np.empty_like(time)
    for start, stop, begins in zip(TURNS[:-1], TURNS[1:], WAY[:-1], strict=True):
        sign = np.sign(led(np.array([stop]))[0] - begins)
        now = (time >= start) & (time <= stop)
        fades = np.exp(-np.abs(led(time[now]) - begins) / strain)
        found[now] = sign * slip + (before - sign * slip) * fades
        before = sign * slip + (before - sign * slip) * np.exp(-SPEED * (stop - start) / strain)
    return elastic(led(time))[0] + found


def thinned(stress: Callable[[Array], Array], timed: bool = True) -> list[TestCurve]:
    """Two tests, read every 1.3 s: a reading misses a turn by up to 1.3 % of strain."""
    random = np.random.default_rng(7)
    found = []
    for number, start in enumerate((0.4, 0.9)):
        time = np.arange(start, TURNS[-1], 1.3)
        read = stress(time) + NOISE * random.standard_normal(len(time))
        found.append(
            TestCurve(
                "uniaxial", led(time), read, time_s=time if timed else None, source=f"{number}", specimen=f"{number}"
            )
        )
    return found


LAWS = {
    "mullins": (softened, "pseudo-elastic-beta", (0.45, 0.01, 0.1)),
    "hysteresis": (rubbed, "dry", (0.012, 0.015)),
}


@pytest.mark.parametrize("name", LAWS)
def test_what_rides_on_history_has_its_constants_from_thinned_tests(name: str) -> None:
    """With the clock within three standard deviations, and no more is left than the noise; without it far off."""
    stress, form, truth = LAWS[name]
    off, left = {}, {}
    for timed in (True, False):
        problem = fabric_problem(law("yeoh-2"), (C10, C20), thinned(stress, timed))
        forms = {name: next(one for e in problem.effects if e.id == name for one in e.forms if one.name == form)}
        noise = Noise(np.full(len(problem.measured), NOISE), np.inf, "known")
        found = fit(problem, noise, forms, [C10, C20, *truth])
        place = found.place(name)
        off[timed] = float(np.max(np.abs(found.x[place] - truth) / found.sd[place]))
        left[timed] = found.chi2 / len(problem.measured)
    assert off[True] < 3.0
    assert off[False] > 10.0
    # Of 390 readings and 5 constants, within three standard deviations of chi squared.
    assert 0.78 < left[True] < 1.22
    assert left[False] > 5.0


@pytest.mark.parametrize("name", LAWS)
def test_what_rides_on_history_is_named_alone_from_thinned_tests(name: str) -> None:
    found = close(fabric_problem(law("yeoh-2"), (C10, C20), thinned(LAWS[name][0])), design=False)
    assert (found.verdict, found.after.ids) == ("effect", (name,))
