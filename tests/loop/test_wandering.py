"""Readings that wander from row to row: noise that no replicate is needed to see."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop import engine
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve
from hyperfab.loop.search import Search
from hyperfab.loop.wandering import wandering
from hyperfab.materials.registry import law


def autoregression(random: np.random.Generator, count: int, rho: float) -> np.ndarray:
    """Return readings of unit variance, each by ``rho`` what the one before it was."""
    found = random.standard_normal(count)
    for i in range(1, count):
        found[i] = rho * found[i - 1] + np.sqrt(1.0 - rho**2) * found[i]
    return found


def told(curves: list[np.ndarray]) -> tuple[float, float]:
    """Return the correlation that is told of readings in units of the noise, and their standard deviation."""
    starts = np.cumsum([0, *(len(one) for one in curves)])
    of = [
        Curve(f"{k}", start, start + len(one), np.linspace(1.0, 1.5, len(one)), place=np.linspace(1.0, 1.5, len(one)))
        for k, (start, one) in enumerate(zip(starts, curves, strict=False))
    ]
    problem: Any = SimpleNamespace(curves=of, channel=np.zeros(starts[-1], dtype=np.int64))
    noise = wandering(problem, Noise(np.ones(starts[-1]), 30.0, "local"), np.concatenate(curves), 0)
    return float(np.max(noise.correlation)), float(noise.sd[0])


@pytest.mark.parametrize("rho", [0.5, 0.75])
def test_an_autoregression_is_told_with_its_size(rho: float) -> None:
    """What is put in comes out, on the mean of thirty draws; a mean of the readings' own curve beside it or not."""
    found = np.array(
        [
            told([2.0 * autoregression(random, 80, rho) + k * np.linspace(0.0, 5.0, 80) ** 2 for k in range(3)])
            for random in map(np.random.default_rng, range(30))
        ]
    )
    assert np.mean(found[:, 0]) == pytest.approx(rho, abs=0.07)
    assert np.mean(found[:, 1]) == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize(
    "smooth",
    [
        pytest.param(lambda x: 0.0 * x, id="nothing"),
        pytest.param(lambda x: 4.0 * np.sin(6.0 * x), id="a-law-that-is-too-poor"),
        pytest.param(lambda x: 6.0 * np.exp(-12.0 * x), id="a-toe"),
    ],
)
def test_what_bends_as_laws_do_is_no_noise(smooth: Any) -> None:
    """Twice as loud as thought, each reading by itself, on a smooth misfit: nothing that neighbours have in common."""
    along = np.linspace(0.0, 1.0, 60)
    draws = [np.random.default_rng(seed) for seed in range(40)]
    claimed = [told([smooth(along) + 2.0 * one.standard_normal(60) for _ in range(2)])[0] for one in draws]
    assert np.count_nonzero(claimed) <= 1


def test_one_curve_of_three_that_wanders_says_nothing_of_all() -> None:
    random = np.random.default_rng(3)
    quiet = [2.0 * random.standard_normal(60) for _ in range(2)]
    rho, sd = told([4.0 * autoregression(random, 60, 0.8), *quiet])
    assert rho == 0.0
    assert sd == pytest.approx(2.0, rel=0.2)  # as the two are


@pytest.mark.parametrize("count", [2, 9])
def test_readings_louder_than_their_neighbours_tell_are_told_by_what_is_left(count: int) -> None:
    """Noise of long tails (Student, 3 degrees of freedom) on a smooth misfit, of unit median deviation as noise is."""
    along, random = np.linspace(0.0, 1.0, 400), np.random.default_rng(7)
    draws = [random.standard_t(3.0, 400) / 1.134 for _ in range(count)]
    rho, sd = told([4.0 * np.sin(6.0 * along) + one for one in draws])
    assert rho == 0.0
    assert sd == pytest.approx(np.sqrt(np.mean(np.square(draws))), rel=0.1)
    assert sd > 1.25


def test_readings_as_loud_as_their_neighbours_tell_stay_so() -> None:
    along = np.linspace(0.0, 1.0, 60)
    draws = [np.random.default_rng(seed).standard_normal((3, 60)) for seed in range(40)]
    louder = [told([4.0 * np.sin(6.0 * along) + one for one in each])[1] > 1.0 for each in draws]
    assert np.count_nonzero(louder) <= 1


def strips(seed: int, softer: float) -> FabricProblem:
    """Return single strips at three temperatures, softer by so much a kelvin, whose load cell wanders by 1.2 %."""
    random, stretch = np.random.default_rng(seed), np.linspace(1.0, 1.7, 70)
    first = stretch**2 + 2.0 / stretch - 3.0
    stress = 2.0 * (stretch - stretch**-2) * (0.15 + 0.03 * first + 0.012 * first**2)
    tests = []
    for celsius in (23.0, 60.0, 100.0):
        read = np.exp(-softer * (celsius - 23.0)) * stress + 0.012 * stress[-1] * autoregression(random, 70, 0.7)
        name = f"{celsius}"
        tests.append(
            TestCurve("uniaxial", stretch, read, temperature_degC=np.full(70, celsius), source=name, specimen=name)
        )
    return fabric_problem(law("yeoh-3"), (0.15, 0.03, 0.012), tests)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("softer", "verdict", "names"), [(0.0, "noise", ()), (0.003, "effect", ("thermal-softening",))]
)
def test_a_load_cell_that_wanders_is_noise_without_replicates(
    seed: int, softer: float, verdict: str, names: tuple[str, ...]
) -> None:
    done = close(strips(seed, softer), design=False)
    assert (done.verdict, done.after.ids) == (verdict, names)
    if done.noise.is_correlated:
        assert 0.3 < np.max(done.noise.correlation) <= 0.9


def tissue() -> FabricProblem:
    """Return few readings, closer as it stiffens, of a sheet that gives four times as far one way as the other."""
    random, tests = np.random.default_rng(0), []
    for angle, begins, top, peak, growth, count in (
        (0.0, 1.46, 1.615, 2.6e-3, 17.0, 12),
        (90.0, 1.0, 1.224, 4.2e-3, 30.0, 15),
    ):
        bent = top - 0.75 * (top - begins) * random.random(count - 1) ** 1.5
        stretch = np.sort(np.concatenate([[begins], bent]))
        stress = peak * np.exp(-growth * (top - stretch)) + 1e-4 * (stretch > 1.05)
        read = stress * (1.0 + 0.04 * random.standard_normal(count))
        tests.append(TestCurve("uniaxial", stretch, read, direction=angle, source=f"{angle}", specimen=f"{angle}"))
    return fabric_problem(law("ogden-1"), (1e-9, 26.0), tests)


@pytest.mark.slow
def test_what_misses_by_far_more_than_readings_wander_is_no_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few readings hardly tell how far they wander: a model that misses by 15 times that is wrong all the same."""

    def vaguely(problem: FabricProblem, noise: Noise, left: np.ndarray, channel: int) -> Noise:
        return replace(noise, sd=3.0 * noise.sd, dof=1.0, correlation=np.full(len(noise.sd), 0.9))

    closed = engine._closed

    def nothing(search: Search, **how: Any) -> Finding:
        found = closed(search, **how)
        return replace(found, verdict="noise", after=found.before) if search.noise.dof == 1.0 else found

    monkeypatch.setattr(engine, "wandering", vaguely)
    monkeypatch.setattr(engine, "_closed", nothing)
    problem = tissue()
    done = close(problem, design=False)
    off = (problem.measured - done.before.fit.predicted) / (3.0 * engine.estimate_noise(problem, None).sd)
    assert min(np.sqrt(np.mean(off[curve.rows] ** 2)) for curve in problem.curves) > 10.0
    assert done.verdict == "unexplained"
    assert "anisotropy" in done.after.ids
