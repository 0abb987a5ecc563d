"""What specimens state of themselves and no law knows: it tells them apart where their stiffness rides on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pytest
from loop.test_honest import posed, pulled, rubber

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.gauges import misread
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.materials.registry import law


def strips(state: str, values: Sequence[float], gains: Sequence[float]) -> list[TestCurve]:
    """Strips pulled alike, each with a value of its own of a state, and so many times as stiff."""
    return [
        replace(
            pulled(lambda lam, g=gain: g * rubber(lam), seed=k, noise=3e-4, rows=40, name=f"{k}"),
            others={state: value},
        )
        for k, (value, gain) in enumerate(zip(values, gains, strict=True))
    ]


@pytest.mark.parametrize(
    ("state", "values", "gains"),
    [
        ("humidity", (30.0, 50.0, 70.0, 90.0), (1.0, 0.95, 0.88, 0.74)),
        # With the logarithm of the days: its order counts.
        ("age", (0.0, 120.0, 30.0, 360.0), (1.0, 1.17, 1.08, 1.26)),
    ],
)
def test_one_strip_at_each_of_four_values_that_it_follows_is_no_scatter(
    state: str, values: Sequence[float], gains: Sequence[float]
) -> None:
    problem = posed(strips(state, values, gains))
    assert estimate_noise(problem).gain_sd == 0.0
    assert misread(problem.curves, problem.measured) == []
    found = close(problem, design=False)
    assert (found.verdict, found.after.ids) == ("unexplained", ())
    assert max(found.rides_on, key=lambda name: found.rides_on[name]) == state


@pytest.mark.parametrize(
    "gains",
    [
        (1.0, 0.74, 0.95, 0.88),  # in no order of what each weighs
        (1.0, 0.98, 0.97, 0.95),  # in its order, by no more than one cloth differs
    ],
)
def test_what_each_strip_weighs_leaves_them_replicates_where_they_do_not_follow_it(gains: Sequence[float]) -> None:
    found = close(posed(strips("mass", (1.02, 1.03, 1.05, 1.06), gains)), design=False)
    assert found.noise.gain_sd == pytest.approx(np.std(gains, ddof=1), rel=0.6)
    assert found.verdict == "noise"


def test_strips_of_one_humidity_are_compared_and_those_of_another_are_not() -> None:
    """A width misread is told among strips of one humidity; what humidity does is none."""
    tests = strips("humidity", (40.0, 40.0, 40.0, 80.0, 80.0, 80.0), (1.0, 1.01, 0.99, 0.7, 0.7, 0.71))
    assert misread(posed(tests).curves, posed(tests).measured) == []
    tests = strips("humidity", (40.0, 40.0, 40.0, 80.0, 80.0, 80.0), (1.0, 2.0, 0.99, 0.7, 0.7, 0.71))
    assert [one.name for one in misread(posed(tests).curves, posed(tests).measured)] == ["1"]


def test_slack_that_follows_the_direction_does_not_stand_for_warp_and_weft() -> None:
    """Three strips of Mooney and Rivlin's law along each, the weft softer, and a zero of the load cell of each."""

    def stress(lam: np.ndarray, angle: float, zero: float) -> np.ndarray:
        much = 0.72 + 0.1 * (lam - 1.0) if angle else 1.0
        return np.asarray(much * 2.0 * (lam - lam**-2.0) * (0.1 + 0.06 / lam) + zero)

    tests = []
    for k, (angle, zero) in enumerate(product((0.0, 90.0), (0.0, 0.025, -0.015))):
        given = partial(stress, angle=angle, zero=zero)
        test = pulled(given, seed=k, noise=2e-3, rows=19, reach=0.7, name=f"{k}")
        tests.append(replace(test, stretch=test.stretch[1:], stress=test.stress[1:], direction=angle))
    found = close(fabric_problem(law("mooney-rivlin-3"), (0.1, 0.05, 0.002), tests), design=False)
    assert (found.verdict, {*found.after.ids}) == ("effect", {"load-offset", "anisotropy"})
