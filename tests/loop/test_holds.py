"""A specimen that is pulled and held: a machine that holds wobbles, and few rows may tell of a long wait."""

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.fabric_tests import path_of
from hyperfab.materials.effects.path import held
from hyperfab.materials.registry import law


def relaxation(waits: int, wobble: float) -> TestCurve:
    """A pull by 30 % in 5 s, held for 5 min and read at times that grow alike: a Maxwell element beside a spring."""
    rng = np.random.default_rng(4)
    pull, wait = np.linspace(1.0, 1.3, 21), np.geomspace(0.2, 300.0, waits)
    lam = np.concatenate([pull, np.full(waits, 1.3)])
    fall = np.concatenate([np.ones(21), 0.6 + 0.4 * np.exp(-wait / 20.0)])
    stress = 0.4 * (lam - lam**-2) * fall + 4e-4 * rng.standard_normal(len(lam))
    lam[21:] += wobble * rng.standard_normal(waits)
    time = np.concatenate([np.linspace(0.0, 5.0, 21), 5.0 + wait])
    return TestCurve("uniaxial", lam, stress, time_s=time, source="held", specimen="held")


@pytest.mark.parametrize(("waits", "wobble"), [(30, 0.0), (30, 5e-5), (30, 3e-4), (8, 5e-5)])
def test_what_relaxes_in_a_hold_is_told_as_rate(waits: int, wobble: float) -> None:
    found = close(fabric_problem(law("neo-hookean"), (0.2,), [relaxation(waits, wobble)]), design=False)
    assert found.verdict != "unexplained"
    assert next(iter(found.after.fit.terms)) == "rate"


def test_the_pace_of_a_pull_does_not_count_the_wobble_of_its_hold() -> None:
    _, speed = path_of([relaxation(30, 5e-5)])
    assert speed[0] == pytest.approx(0.06, rel=0.02)


@pytest.mark.parametrize("rows", [10, 100, 5000])
def test_a_pull_is_no_hold(rows: int) -> None:
    """Neither a slow one read densely, nor one in digits that repeat, nor the turns of a sine."""
    clock = np.linspace(0.0, 60.0, rows)
    ways = clock / 60.0, np.round(clock / 60.0, 3), np.sin(np.pi * clock / 30.0) ** 2
    for way in ways if rows < 5000 else (ways[0], ways[2]):
        assert not held(1.0 + 0.5 * way, clock).any()


def test_a_specimen_that_was_held_throughout_is_held() -> None:
    clock = np.arange(20.0)
    assert held(1.5 + 1e-5 * np.sin(clock**2), clock).sum() == 19
    assert held(np.full(20, 1.5), np.full(20, np.nan)).sum() == 19


def test_a_time_that_stands_twice_leaves_the_clock_to_the_test() -> None:
    """Four readings of a hold of five minutes are one by the clock alone."""
    clock = np.concatenate([np.linspace(0.0, 5.0, 21), [80.0, 155.0, 230.0, 305.0]])
    stretch = np.concatenate([np.linspace(1.0, 1.3, 21), 1.3 + 1e-5 * np.array([1.0, -1.0, 1.0, 0.0])])
    assert held(stretch, clock).sum() == 4
    clock[11] = clock[10]
    assert held(stretch, clock).sum() == 4
