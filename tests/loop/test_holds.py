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


@pytest.mark.parametrize(("seed", "stiffens", "share"), [(1, 0.35, 0.5), (3, 0.5, 0.6)])
def test_a_law_that_stiffens_is_no_stress_that_hardly_relaxes(seed: int, stiffens: float, share: float) -> None:
    """Exponential fibres in all directions of the plane, at three rates: a branch that never relaxes is a spring."""
    random, tests = np.random.default_rng(seed), []
    angles = np.pi * (np.arange(24) + 0.5) / 24.0

    def stress(mode: str, lam: np.ndarray) -> np.ndarray:
        side = lam**-0.5 if mode == "uniaxial" else np.ones_like(lam)
        narrows = -0.5 * lam**-1.5 if mode == "uniaxial" else np.zeros_like(lam)
        total = (1.0 - share) * (lam - 1.0 / (lam**3 * side**2))
        for c, s in zip(np.cos(angles), np.sin(angles), strict=True):
            strain = np.maximum((lam * c) ** 2 + (side * s) ** 2 - 1.0, 0.0)
            pull = 2.8 * strain * np.exp(stiffens * strain**2) * (lam * c**2 + side * narrows * s**2)
            total += share * pull / len(angles)
        return 0.3 * total

    top = float(stress("uniaxial", np.array([1.57]))[0])
    plan = [("uniaxial", rate, (1.57, 1.0) * 3) for rate in (0.014, 0.046, 0.155)]
    plan += [("uniaxial", 0.014, (1.32, 1.0) * 2), ("shear", 0.014, (1.57, 1.0))]
    for number, (mode, rate, turns) in enumerate(plan):
        ends = (1.0, *turns)
        ways = [np.linspace(a, b, 41)[1:] for a, b in zip(ends, turns, strict=False)]
        lam = np.concatenate([[1.0], *ways])
        noisy = stress(mode, lam) + 0.017 * top * random.standard_normal(len(lam))
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(lam)))]) / rate
        tests.append(TestCurve(mode, lam, noisy, time_s=time, source=f"{number}", specimen=f"{number}"))
    found = close(fabric_problem(law("neo-hookean"), [0.2], tests), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("elastic-law",))
    assert found.belief is not None
    assert found.belief.of["rate"] < 0.05
