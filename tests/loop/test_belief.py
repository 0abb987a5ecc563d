"""What each specimen has of its own: by chance, by its size, or by how it was led."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.belief import coincidence
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import Candidate
from hyperfab.loop.noise import Noise
from hyperfab.loop.thresholds import MARGIN
from hyperfab.materials.registry import law

REACH = np.linspace(1.0, 1.5, 20)


def charged(slack: np.ndarray, lengths: tuple[float, ...], temperatures: tuple[float, ...]) -> float:
    """Return what is charged for grips that gave each specimen its own ``slack``: two of each gauge length [mm] at each
    temperature [degC], of a cloth that knows of neither."""
    states = [(length, celsius) for length in lengths for celsius in temperatures for _ in range(2)]
    pulls = []
    for k, (length, celsius) in enumerate(states):
        held = np.maximum(REACH - slack[k], 1.0)
        stress = held - held**-2
        temperature = np.full(len(REACH), celsius)
        one = TestCurve("uniaxial", REACH, stress, temperature_degC=temperature, gauge_length_mm=length, source=f"{k}")
        pulls.append(one)
    problem = fabric_problem(law("neo-hookean"), np.array([0.5]), pulls)
    form = problem.effect("grip-slack").form("each")
    values = np.concatenate([slack[:1], slack[1:] - slack[0]])
    noise = Noise(np.full(len(problem.measured), 0.01), 30.0, "local")
    found = fit(problem, noise, {"grip-slack": form}, np.concatenate([[0.5], values]))
    return coincidence(Candidate(problem, noise, found), "grip-slack")


def test_slack_that_follows_the_temperature_is_no_chance() -> None:
    random = np.random.default_rng(0)
    by_state = 0.02 + np.repeat([0.0, 0.05, 0.12], 2) + 0.001 * random.standard_normal(6)
    assert charged(by_state, (100.0,), (23.0, 60.0, 90.0)) == pytest.approx(MARGIN)


def test_slack_that_each_specimen_drew_for_itself_costs_nothing() -> None:
    drawn = [np.random.default_rng(seed).uniform(0.0, 0.1, 6) for seed in range(20)]
    costs = [charged(slack, (100.0,), (23.0, 60.0, 90.0)) for slack in drawn]
    assert np.median(costs) == 0.0
    assert np.mean(costs) < 0.5


def test_slack_of_one_length_is_told_by_how_long_a_specimen_is() -> None:
    """The same millimetres are half the stretch of twice the length: so they agree by nature, not by chance."""
    random = np.random.default_rng(1)
    by_length = np.repeat([0.10, 0.05, 0.025], 2) + 0.001 * random.standard_normal(6)
    assert charged(by_length, (50.0, 100.0, 200.0), (23.0,)) == 0.0
