"""A test read with another width or gauge length is told, by name where others agree; one cloth's scatter is not."""

from __future__ import annotations

import numpy as np
import pytest
from loop.blind import case, problem_of
from loop.generators import fabric as truths

from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.gauges import Misread, misread
from hyperfab.materials import law


def told(factor: float, axis: str, count: int = 3, scatter: float = 0.02, seed: int = 0) -> list[tuple[int, Misread]]:
    """What is told of ``count`` replicates, the second of which is read with a size off by ``factor``."""
    random = np.random.default_rng(seed)
    setups = [truths.Setup(turns=(1.5, 1.0), rate=0.01) for _ in range(count)]
    setups += [truths.Setup(angle=90.0, turns=(1.4, 1.0), rate=0.01) for _ in range(2)]
    readings = truths.measure(truths.draw(random, ()), setups, random, 0.003, scatter=scatter)
    wrong = readings[1]
    if axis == "stress":
        wrong.stress = wrong.stress * factor
    else:
        wrong.stretch = 1.0 + (wrong.stretch - 1.0) * factor
    problem = problem_of(readings)
    names = [curve.name for curve in problem.curves]
    return [(names.index(one.name), one) for one in misread(problem.curves, problem.measured)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("factor", [0.65, 1.5])
def test_one_of_three_read_with_another_width_is_named(factor: float, seed: int) -> None:
    [(number, one)] = told(factor, "stress", seed=seed)
    assert (number, one.sure) == (1, True)
    assert one.factor == pytest.approx(factor, rel=0.1)
    assert f"gauge length of {one.name}" in str(one)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("factor", [0.65, 1.5])
def test_one_of_three_read_with_another_gauge_length_is_named(factor: float, seed: int) -> None:
    """What seems to have lengthened by less has more stress at the same stretch."""
    [(number, one)] = told(factor, "strain", seed=seed)
    assert (number, one.sure) == (1, True)
    assert one.factor > 1.2 if factor < 1.0 else one.factor < 1.0 / 1.2


@pytest.mark.parametrize("axis", ["stress", "strain"])
def test_of_a_pair_both_are_to_be_checked(axis: str) -> None:
    [(_, one)] = told(1.5, axis, count=2)
    assert not one.sure
    assert "of both" in str(one)


@pytest.mark.parametrize("effects", [(), ("mullins",), ("rate",), ("permanent-set",), ("anisotropy",)])
def test_no_test_of_a_usual_plan_is_accused(effects: tuple[str, ...]) -> None:
    for seed in range(3):
        problem, *_ = case(seed, effects, poor=False)
        assert misread(problem.curves, problem.measured) == []


@pytest.mark.parametrize("seed", range(10))
def test_specimens_of_one_cloth_are_not_accused(seed: int) -> None:
    assert told(1.0, "stress", scatter=0.04, seed=seed) == []


def test_biaxial_tests_at_other_ratios_are_not_led_alike() -> None:
    """A strip held across carries a third of what the same stretch carries where the other axis is pulled too."""
    pull = np.linspace(1.0, 1.3, 30)
    tests = []
    for name, across in (("equal", pull), ("half", 0.5 * (1.0 + pull)), ("strip", np.ones(30))):
        stress = (pull - 1.0) * (0.05 + 0.4 * (across - 1.0))
        tests.append(TestCurve("biaxial-general", pull, stress, stretch2=across, direction=0.0, source=name))
    problem = fabric_problem(law("neo-hookean"), [0.1], tests)
    assert misread(problem.curves, problem.measured) == []


@pytest.mark.parametrize("of", ["temperature", "rate"])
def test_what_heat_or_a_pace_softens_is_no_misread_width(of: str) -> None:
    """A fabric at 23, 80 and 105 degC, one at three rates: a file each, nothing stated twice."""
    pull, tests = np.linspace(1.0, 1.5, 60), []
    for celsius, pace, share in ((23.0, 1.0, 1.0), (80.0, 3.0, 0.7), (105.0, 9.0, 0.55)):
        tests.append(
            TestCurve(
                "uniaxial",
                pull,
                share * 0.4 * (pull - 1.0),
                time_s=np.arange(60.0) * (pace if of == "rate" else 1.0),
                temperature_degC=np.full(60, celsius if of == "temperature" else 23.0),
                source=f"{celsius:g} degC, {pace:g} s",
            )
        )
    problem = fabric_problem(law("neo-hookean"), [0.1], tests)
    assert misread(problem.curves, problem.measured) == []
