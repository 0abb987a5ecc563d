"""Tests of a fabric or a foam that could be done next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hyperfab.curve import TestCurve
from hyperfab.loop.fabric_tests import path_of

#: Rows a turn of a test, and how it may be led.
_POINTS, _MODES = 60, ("uniaxial", "shear", "biaxial")


def menu(tests: Sequence[TestCurve]) -> Iterator[tuple[str, Mapping[str, Any], TestCurve]]:
    """Yield tests that could be done next: what to say, what to do, and the test as the models see it (stress zero)."""
    path, _ = path_of(tests)
    pressed = bool(np.all(path.pressed))
    reach = float(np.min(path.stretch) if pressed else np.max(path.stretch)) - 1.0
    speeds = [speed for test in tests if (speed := _speed(test)) is not None]
    pace = float(np.exp(np.median(np.log(speeds)))) if speeds else 0.01
    slow, fast = pace / 16.0, pace * 16.0
    temperatures = [float(np.mean(t.temperature_degC)) for t in tests if t.temperature_degC is not None]
    usual = float(np.median(temperatures)) if temperatures else 23.0
    first = tests[0]
    angle = first.direction or 0.0
    mode = first.mode if first.mode in _MODES else "uniaxial"
    half, full = 1.0 + 0.55 * reach, 1.0 + reach
    steps = [half, 1.0, half, 1.0, full, 1.0, full, 1.0]
    loop = [full, 1.0]

    def one(
        what: str,
        turns: list[float],
        rate: float,
        *,
        at: float = usual,
        along: float = angle,
        kind: str = mode,
        hold: float = 0.0,
    ) -> tuple[str, Mapping[str, Any], TestCurve]:
        details = {
            "test": kind,
            "direction_deg": along,
            "temperature_degC": at,
            "rate_1_s": rate,
            "stretch_turns": turns,
            "hold_s": hold,
        }
        return what, details, _made(what, details, bool(speeds), bool(temperatures))

    yield one(
        "cycles to about half the stretch and back, twice, then to the full stretch and back, twice",
        steps,
        pace,
    )
    yield one("two full cycles at a sixteenth of the rate", [*loop, *loop], slow)
    yield one("two full cycles at sixteen times the rate", [*loop, *loop], fast)
    yield one("a fast pull, a hold of the stretch, and full unloading", loop, fast, hold=10.0 * abs(reach) / pace)
    yield one("a cycle at a temperature 40 K higher", loop, pace, at=usual + 40.0)
    yield one("a cycle across the direction tested", loop, pace, along=(angle + 90.0) % 180.0)
    yield one("a cycle 45 degrees from the warp", loop, pace, along=45.0)
    for kind in _MODES:
        if kind != mode:
            yield one(f"a {kind} test to the same stretch", [full], pace, kind=kind)
    if not pressed:
        yield one("a pull half as far again", [1.0 + 1.5 * reach], pace)
    yield one(
        "a slow pull through the first tenth of the stretch, read closely",
        [1.0 + 0.1 * reach, 1.0],
        pace / 4.0,
    )


def _speed(test: TestCurve) -> float | None:
    if test.rate_1_s is not None and np.all(np.asarray(test.rate_1_s) > 0.0):
        return float(np.median(test.rate_1_s))
    if test.time_s is None or not np.all(np.isfinite(test.time_s)):
        return None
    span = float(test.time_s[-1] - test.time_s[0])
    moved = float(np.sum(np.abs(np.diff(test.stretch))))
    return moved / span if span > 0.0 and moved > 0.0 else None


def _made(name: str, details: Mapping[str, Any], timed: bool, warmed: bool) -> TestCurve:
    """Return the test of these details; ``timed`` and ``warmed`` where those measured so far state it."""
    hold = details["hold_s"]
    stretch, time = [np.array([1.0])], [np.array([0.0])]
    here, now = 1.0, 0.0
    for number, turn in enumerate(details["stretch_turns"]):
        way = np.linspace(here, turn, _POINTS + 1)[1:]
        stretch.append(way)
        time.append(now + np.abs(way - here) / details["rate_1_s"])
        now = float(time[-1][-1])
        here = turn
        if number == 0 and hold > 0.0:
            wait = hold * np.linspace(0.0, 1.0, _POINTS + 1)[1:] ** 3
            stretch.append(np.full(_POINTS, turn))
            time.append(now + wait)
            now += hold
    lam = np.concatenate(stretch)
    return TestCurve(
        mode=details["test"],
        stretch=lam,
        stress=np.zeros_like(lam),
        time_s=np.concatenate(time) if timed else None,
        temperature_degC=np.full_like(lam, details["temperature_degC"]) if warmed else None,
        direction=details["direction_deg"],
        source=name,
        specimen=f"next: {name}",
    )
