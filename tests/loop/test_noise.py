"""What noise is made of: readings, and specimens that are stiffer or softer than their like."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from loop.blind import problem_of
from loop.generators import fabric as truths

from hyperfab.curve import TestCurve
from hyperfab.loop.contact import ForceDepth, contact_problem
from hyperfab.loop.emulator import Axis
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import Judgement, judge
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import among_specimens, estimate_noise
from hyperfab.materials.registry import law


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


class OfDepth:
    """What stands for a sheet: a force that grows with the depth, whatever its settings."""

    axes = tuple(Axis(name, base, 0.1) for name, base in (("prestretch", 0.0), ("friction", 0.0), ("slip", 0.0)))
    emulator: Any = property(lambda self: self)
    names, knots, friction, slackest = ("C10_MPa",), np.linspace(1.0, 20.0, 9), True, 0.0

    def __call__(self, settings: np.ndarray) -> np.ndarray:
        return np.append(self.knots, 1.0)


@pytest.mark.parametrize("warm", [False, True])
def test_sheets_pushed_alike_scatter_in_stiffness(warm: bool) -> None:
    """Those at another temperature are no replicates."""
    rng, depth = np.random.default_rng(6), np.linspace(0.5, 20.0, 60)
    files = [
        ForceDepth(
            f"{k}.csv", depth, gain * depth**3 * (1.0 + 0.003 * rng.standard_normal(60)), np.full(60, 23.0 + more)
        )
        for k, (gain, more) in enumerate([(1e-3, 0.0), (1.08e-3, 40.0 if warm else 0.0)])
    ]
    sheet: Any = OfDepth()
    problem = contact_problem(sheet, files, reference_degC=23.0)
    plain = Noise(np.maximum(0.003 * problem.measured, 1e-4), 40.0, "local differences")
    found = among_specimens(problem, plain)
    if warm:
        assert found is plain
    else:
        assert found.gain_sd == pytest.approx(0.08 / 1.04 / np.sqrt(2.0), rel=0.1)
        assert len(found.groups) == 2


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.6])
def test_replicates_read_elsewhere_tell_how_neighbouring_readings_err_alike(rho: float) -> None:
    """What neighbours differ by is 0.78 (0.55) of noise that they have 0.3 (0.6) of in common; a curve between two
    readings is quieter than one."""
    rng, sd = np.random.default_rng(7), 2e-3

    def pulled(name: str, slack: float) -> TestCurve:
        stretch, white = np.sort(1.0 + 0.5 * rng.random(60)), rng.standard_normal(60)
        err = white.copy()
        for i in range(1, 60):
            err[i] = rho * err[i - 1] + np.sqrt(1.0 - rho**2) * white[i]
        own = stretch - slack
        stress = 0.4 * (own - own**-2) * (1.0 + 0.03 * rng.standard_normal()) + sd * err
        return TestCurve("uniaxial", stretch, stress, source=name, specimen=name)

    found = []
    for _ in range(20):
        tests = [pulled(name, slack) for name, slack in (("a", 0.0), ("b", 0.0), ("c", 0.01), ("d", 0.0))]
        noise = estimate_noise(fabric_problem(law("neo-hookean"), (0.2,), tests))
        found.append((float(np.median(noise.sd)), float(np.max(noise.correlation))))
    size, alike = np.mean(found, axis=0)
    assert size == pytest.approx(sd, rel=0.08)
    assert alike == pytest.approx(rho, abs=0.08)


LAM = np.array([1.04, 1.06, 1.08, 1.1, 1.12, 1.14, 1.16, 1.2, 1.24, 1.3, 1.6, 1.9, 2.2, 2.5, 2.8, 3.1])


def few_readings(bend: float, share: float, seed: int = 0) -> FabricProblem:
    """Sixteen readings of a rubber, ``bend`` of its stress missing at the end, errors a share of the peak."""
    stress = 0.4 * (LAM - LAM**-5) * (1.0 - bend * (LAM - 1.0) / 2.1)
    error = share * stress.max() * np.random.default_rng(seed).standard_normal(len(LAM))
    curve = TestCurve("biaxial", LAM, np.round(stress + error, 5), source="a.csv")
    return fabric_problem(law("neo-hookean"), (0.2,), [curve])


def left_by_the_law(problem: FabricProblem) -> Judgement:
    noise = estimate_noise(problem)
    return judge(problem, noise, fit(problem, noise, {}, [problem.own[0].value]), [])


def test_a_noise_that_a_machine_has_at_least_is_not_unknown_for_few_readings() -> None:
    """Readings smoother than a machine is sure of (Kawabata's, of 1981) miss a law by four times that: no noise."""
    problem = few_readings(bend=0.08, share=1e-4)
    noise = estimate_noise(problem)
    assert noise.dof < 6.0
    assert noise.raised > 3.0
    found = left_by_the_law(problem)
    assert found.structured > 1.0
    assert found.p_lack_of_fit < 1e-3


@pytest.mark.parametrize("share", [0.002, 0.005, 0.01])
def test_noise_of_few_readings_is_seldom_called_a_lack_of_fit(share: float) -> None:
    """Below the machine's class never; about it and above, where so few tell it too low, no more than it should."""
    chance = [left_by_the_law(few_readings(0.0, share, seed)).p_lack_of_fit for seed in range(200)]
    assert np.mean(np.array(chance) < 0.005) <= 0.02
