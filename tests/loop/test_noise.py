"""What noise is made of: readings, and specimens that are stiffer or softer than their like."""

from __future__ import annotations

import numpy as np
import pytest
from loop.blind import problem_of
from loop.generators import fabric as truths

from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise


def test_spread_is_what_a_perfect_model_misses_by():
    rng = np.random.default_rng(3)
    specimens, rows, sd, gain_sd = 4000, 20, 0.002, 0.03
    truth = np.tile(np.linspace(0.0, 0.5, rows), specimens)
    gains = np.exp(np.repeat(rng.normal(0.0, gain_sd, specimens), rows))
    measured = truth * gains + rng.normal(0.0, sd, len(truth))
    groups = tuple(np.arange(rows * k, rows * (k + 1)) for k in range(specimens))
    noise = Noise(np.full(len(truth), sd), 100.0, "stated", gain_sd=gain_sd, groups=groups, measured=measured)
    missed = np.sqrt(np.mean((measured - truth).reshape(specimens, rows) ** 2, axis=0))
    told = np.sqrt(np.mean(noise.spread(truth).reshape(specimens, rows) ** 2, axis=0))
    assert told == pytest.approx(missed, rel=0.04)
    assert noise.plain.spread(truth) == pytest.approx(sd)


@pytest.mark.parametrize(("gain", "offset"), [(1.1, 0.0), (1.0, 0.02)])
def test_an_offset_of_a_specimen_is_told_from_its_stiffness(gain: float, offset: float) -> None:
    rng = np.random.default_rng(5)
    setup = truths.Setup(turns=(1.4, 1.0), rate=0.01)
    readings = truths.measure(truths.draw(rng, ()), [setup, setup], rng, 0.002)
    readings[1].stress = gain * readings[1].stress + offset
    noise = estimate_noise(problem_of(readings))
    assert noise.sd[0] == pytest.approx(0.002, rel=0.3)
    if offset:
        assert noise.gain_sd < 0.01
    else:
        assert noise.gain_sd == pytest.approx(0.1 / 1.05 / np.sqrt(2.0), rel=0.1)
        assert noise.gain_doubt > noise.gain_sd


@pytest.mark.parametrize("louder", [1.0, 4.0])
def test_noise_of_each_curve_is_its_own_where_they_clearly_differ(louder: float) -> None:
    rng = np.random.default_rng(8)
    setup = truths.Setup(turns=(1.4, 1.0), rate=0.01)
    readings = truths.measure(truths.draw(rng, ()), [setup] * 4, rng, 0.002)
    readings[2].stress = readings[2].stress + rng.normal(0.0, 0.002 * np.sqrt(louder**2 - 1.0), len(readings[2].stress))
    problem = problem_of(readings)
    noise = estimate_noise(problem)
    levels = [float(np.median(noise.sd[curve.rows])) for curve in problem.curves]
    assert levels == pytest.approx([0.002, 0.002, 0.002 * louder, 0.002], rel=0.3)
    if louder == 1.0:
        assert levels == [levels[0]] * 4
