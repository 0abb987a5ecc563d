"""Cycles at several rates, each a file of its own: the sheet hangs slack where it would have to push."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.materials.registry import law

RATES = (0.01, 0.03, 0.05)
SPRINGS = np.array([0.05, 0.03])
TIMES, NOISE = np.array([5.0, 60.0]), 1.5e-4


def cycle(rate: float, shares: tuple[float, float], thick: bool = False) -> TestCurve:
    """Return a pull to twice the length and back of a neo-Hookean strip with two Maxwell branches, step by step."""
    step = 0.2
    time = np.arange(0.0, 2.0 / rate, step)
    stretch = 1.0 + np.minimum(rate * time, 2.0 - rate * time)
    driving = stretch - stretch**-2
    stress, branches = 0.03 * driving, np.zeros(2)
    for k in range(1, len(time)):
        branches = branches * np.exp(-step / TIMES)
        branches += 0.03 * np.array(shares) * (driving[k] - driving[k - 1]) * np.exp(-0.5 * step / TIMES)
        stress[k] += branches.sum()
    read = (stress if thick else np.maximum(stress, 0.0)) + np.random.default_rng(3).normal(0.0, NOISE, len(time))
    return TestCurve("uniaxial", stretch, read, time_s=time, source=f"{rate} 1/s", specimen=f"{rate} 1/s")


def flowing(rate: float, top: float) -> TestCurve:
    """Return a pull to ``top`` and back of springs in series with dashpots, in small steps, beside a stiffening law."""
    step, fine = 0.2, 20
    time = np.arange(0.0, 2.0 * (top - 1.0) / rate, step)
    stretch = 1.0 + np.minimum(rate * time, 2.0 * (top - 1.0) - rate * time)
    chains = 1.0 - (stretch**2 + 2.0 / stretch - 3.0) / 70.0
    stress, dashpots = 0.02 * (stretch - stretch**-2) / chains, np.zeros(2)
    for k in range(1, len(time)):
        for part in range(fine):
            now = stretch[k - 1] + (part + 0.5) / fine * (stretch[k] - stretch[k - 1])
            spring = now / np.exp(dashpots)
            dashpots += step / fine * (spring**2 - 1.0 / spring) / (3.0 * TIMES)
        spring = stretch[k] / np.exp(dashpots)
        stress[k] += np.sum(SPRINGS * (spring**2 - 1.0 / spring)) / stretch[k]
    read = np.maximum(stress, 0.0) + np.random.default_rng(5).normal(0.0, NOISE, len(time))
    name = f"{rate} 1/s to {top}"
    return TestCurve("uniaxial", stretch, read, time_s=time, source=name, specimen=name)


def problem(shares: tuple[float, float] = (1.3, 1.0), thick: bool = False) -> FabricProblem:
    return fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), [cycle(rate, shares, thick) for rate in RATES])


def test_relaxation_of_a_strip_that_goes_slack_is_found_with_its_constants() -> None:
    found = close(problem(), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("rate",))
    form, values = found.after.fit.forms["rate"], found.after.fit.x[3:]
    assert form.name == "prony-2"
    np.testing.assert_allclose(values, [1.3, 5.0, 1.0, 60.0], rtol=0.05)
    left = found.after.fit.predicted - problem().measured
    assert np.sqrt(np.mean(left**2)) < 1.1 * NOISE


def test_a_dashpot_that_flows_far_is_found_with_its_constants() -> None:
    """As a set or a loop it would pass, were there small strains alone."""
    tests = [flowing(rate, top) for rate in RATES[::2] for top in (1.5, 2.5)]
    found = close(fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), tests), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("rate",))
    assert found.after.fit.forms["rate"].name == "finite-2"
    pairs = found.after.fit.x[3:].reshape(2, 2)
    np.testing.assert_allclose(pairs[np.argsort(pairs[:, 1])], np.stack([SPRINGS, TIMES], axis=1), rtol=0.05)


def test_paces_that_were_chosen_to_differ_make_no_replicates() -> None:
    setups = [curve.setup for curve in problem().curves]
    assert len(set(setups)) == 3
    alike = [replace(cycle(rate, (1.3, 1.0)), specimen=str(rate)) for rate in (0.01, 0.012)]
    curves = fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), alike).curves
    assert curves[0].setup == curves[1].setup


@pytest.mark.parametrize("thick", [False, True])
def test_only_what_reads_no_push_hangs(thick: bool) -> None:
    made = problem(thick=thick)
    assert made.fabric.hang is not None
    assert made.fabric.hang.all() != thick
    own = np.array([0.015, 0.0, 0.0])
    terms = {"rate": ("prony-2", np.array([1.3, 5.0, 1.0, 60.0]))}
    assert (made.predict(own, terms).min() < -0.005) == thick
    offset = {**terms, "load-offset": ("constant", np.array([-0.01]))}
    if not thick:
        # What the cell reads beside the sheet is not the sheet's.
        np.testing.assert_allclose(made.predict(own, offset).min(), -0.01, atol=1e-12)


def test_a_crosshead_that_comes_back_a_hair_too_far_leaves_the_sheet_slack() -> None:
    """One row beyond rest, where the law would push, weighed as much as all others: a set was named for the rate."""
    tests = [cycle(rate, (1.3, 1.0)) for rate in RATES]
    tests = [replace(one, stretch=np.append(one.stretch[:-1], 1.0 - 2.5e-6)) for one in tests]
    made = fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), tests)
    assert made.fabric.hang is not None
    assert made.fabric.hang.all()
    found = close(made, design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("rate",))


def test_what_was_pressed_does_not_hang() -> None:
    pull = cycle(0.05, (1.3, 1.0))
    push = replace(pull, stretch=2.0 - pull.stretch + 1e-3, stress=-pull.stress, source="push", specimen="push")
    made = fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), [pull, push])
    hang, (pulled, pressed) = made.fabric.hang, made.fabric.path.curves
    assert hang is not None
    assert hang[pulled].all()
    assert not hang[pressed].any()


def test_the_shift_of_a_clock_is_told_where_it_is_read_at_two_temperatures() -> None:
    def forms(*at: tuple[float, float]) -> set[str]:
        tests = [
            replace(
                one := cycle(rate, (0.3, 0.2)),
                temperature_degC=np.full(len(one.stretch), celsius),
                source=f"{celsius} {rate}",
            )
            for celsius, rate in at
        ]
        made = fabric_problem(law("yeoh-3"), (0.02, 0.0, 0.0), tests)
        return {form.name for form in made.effect("rate").forms if "shifted" in form.name and form.simpler}

    once = (20.0, 0.01), (20.0, 0.05), (50.0, 0.01), (80.0, 0.01)
    assert not forms(*once)
    assert forms(*once, (50.0, 0.05))
