"""Heaters that switch between readings: a log tells what they drew, and not quite when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from loop.generators import heat as truths

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.close_loop.heaters import read_powers
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.inputs import Inputs
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.engine import close
from hyperfab.loop.fitting import fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.switching import is_coarse

#: Less is less than the finite volumes are off where the power jumps.
NOISE_K = 0.2


def switched(monkeypatch: pytest.MonkeyPatch, effect: str = "") -> HeatProblem:
    """Return the problem of a mold whose heater switched at random, its power and its probes read every 20 s.

    Finite volumes of their own follow the switching to half a second.
    """
    rng = np.random.default_rng(6)
    lengths = np.ravel(np.column_stack([rng.uniform(45.0, 80.0, 40), rng.uniform(50.0, 110.0, 40)]))
    turns = 600.0 + np.cumsum(lengths)
    monkeypatch.setattr(truths, "DURATION", 2000.0)
    monkeypatch.setattr(truths, "schedule", lambda t: truths.POWER * (np.searchsorted(turns, t) % 2 == 0))
    times, read = truths.measure(truths.draw(rng, (effect,) if effect else ()), rng, NOISE_K, 101)
    power = np.array([truths.schedule(t) / 4.0 for t in times])
    text, _ = truths.mold_toml()
    rated = f'power = "{truths.POWER / 4.0} W"\ncontrol = {{ probe = "T1", set = "150 degC", band = "4 K" }}'
    text = text.replace('schedule = "power.csv"', rated)
    document = parse_document(load_toml(text.encode(), "mold.toml"), "mold.toml", MoldDocument)
    builder = MoldBuilder(document, "mold.toml", Inputs())
    names = ["T1", "T2", "T3", "T4"]
    drawn = read_powers(document, {"power": power})
    return heat.pose(builder, heat.Thermocouples(times, read, names), [], 0.1, drawn)


def test_a_right_mold_leaves_noise_whenever_its_heater_switched(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not known of the switching was taken for what the model lacks."""
    problem = switched(monkeypatch)
    noise = estimate_noise(problem, NOISE_K)
    found = fit(problem, noise, {}, problem.given)
    assert np.sqrt(np.mean(found.residual**2)) == pytest.approx(1.0, abs=0.1)
    missed = np.sqrt(np.mean((problem.measured - found.predicted) ** 2))
    assert missed == pytest.approx(NOISE_K, rel=0.15)
    blind = fit(replace(problem), replace(noise, common=np.empty((0, 0))), {}, problem.given)
    assert np.sqrt(np.mean(blind.residual**2)) > 3.0


@pytest.mark.slow
def test_what_a_switched_mold_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    found = close(switched(monkeypatch, "sensor-lag"), noise=NOISE_K, design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("sensor-lag",))


def test_causes_in_common_are_whitened_and_owed() -> None:
    rng = np.random.default_rng(3)
    sd, common = rng.uniform(0.5, 2.0, 12), rng.normal(size=(12, 3))
    noise = Noise(sd, np.inf, "stated", common=common)
    covariance = np.diag(sd**2) + common @ common.T
    whitening = noise.whiten(np.eye(12))
    assert whitening @ covariance @ whitening.T == pytest.approx(np.eye(12), abs=1e-6)
    assert noise.about_means.coloured(whitening) == pytest.approx(np.eye(12), abs=1e-6)
    left = rng.normal(size=12)
    left *= 0.9 / np.sqrt(np.mean((whitening @ left) ** 2))
    assert noise.owed(left) == pytest.approx(common @ common.T @ np.linalg.solve(covariance, left), rel=1e-6)
    # Of what a wrong model leaves the misfit counts as noise of the readings.
    off = 10.0 * left
    louder = 81.0 * np.diag(sd**2) + common @ common.T
    assert noise.owed(off) == pytest.approx(common @ common.T @ np.linalg.solve(louder, off), rel=1e-6)
    silent = replace(noise, sd=np.where(np.arange(12) < 4, np.inf, sd))
    kept = np.ix_(range(4, 12), range(4, 12))
    told = common @ common[4:].T @ np.linalg.solve(covariance[kept], left[4:])
    assert silent.owed(left) == pytest.approx(told, rel=1e-6)  # of rows that have no say too


def test_a_log_that_is_as_slow_as_the_heaters_is_told() -> None:
    slow = np.tile([300.0, 0.0, 0.0, 300.0, 0.0], 6)
    assert is_coarse(slow)
    assert not is_coarse(np.repeat(slow, 3))
    assert not is_coarse(np.linspace(0.0, 300.0, 30))
