"""Cycles read so thinly that none of their turns was: specimens led alike all the same."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Curve
from hyperfab.loop.replicates import difference, replicates
from hyperfab.materials.registry import law

#: Where the specimens turn, and what the way back has of the stress of the way out.
TURNS, BACK, NOISE = (1.0, 1.15, 1.0, 1.3, 1.0, 1.45, 1.0, 1.45, 1.0), 0.6, 2e-3


def read(random: np.random.Generator, turns: tuple[float, ...], per_way: int) -> tuple[Array, Array]:
    """Return the way gone at readings taken at random, one in each of so many equal steps, and the places there."""
    corners = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    count = per_way * (len(turns) - 1)
    way = (np.arange(count) + random.uniform(0.0, 1.0, count)) / count * corners[-1]
    return way, np.interp(way, corners, turns)


def loop_of(way: Array, place: Array, turns: tuple[float, ...]) -> Array:
    """Return a stress in proportion to the strain, less of it on each way back: it drops at each turn."""
    corners = np.cumsum(np.abs(np.diff(turns)))
    back = np.searchsorted(corners, way) % 2 == 1
    return (place - 1.0) * np.where(back, BACK, 1.0)


@pytest.mark.parametrize("seed", range(6))
def test_readings_on_either_side_of_a_turn_are_not_compared(seed: int) -> None:
    """A line is met by a line, wherever it was read; what lies beside a turn may be of the way out or back."""
    random = np.random.default_rng(seed)
    ways = [read(random, TURNS, per_way) for per_way in (20, 21)]
    stress = np.concatenate([loop_of(*one, TURNS) for one in ways])
    first, second = (
        Curve("", start, start + len(place), np.arange(float(len(place))), (), "way", place=place)
        for start, (_, place) in zip((0, len(ways[0][0])), ways, strict=True)
    )
    apart, level, *_ = difference(stress, np.ones_like(stress), first, second)
    assert len(level) > 100
    assert np.max(np.abs(apart)) < 1e-12


def test_a_first_way_that_was_not_read_is_compared_with_none() -> None:
    """One of them was first read on its way back, and ends a way earlier."""
    places = [np.concatenate([np.linspace(a, b, 9)[1:] for a, b in ways]) for ways in (
        ((1.0, 1.1), (1.1, 1.0), (1.0, 1.2), (1.2, 1.0)), ((1.09, 1.0), (1.0, 1.2), (1.2, 1.0)),
    )]  # fmt: skip
    rises = [np.diff(place, prepend=before) > 0.0 for place, before in zip(places, (1.0, 1.1), strict=True)]
    stress = np.concatenate([(p - 1.0) * np.where(up, 1.0, BACK) for p, up in zip(places, rises, strict=True)])
    first = Curve("", 0, 32, np.arange(32.0), (), "way", place=places[0])
    second = Curve("", 32, 56, np.arange(24.0), (), "way", place=places[1])
    for pair in ((first, second), (second, first)):
        apart, level, *_ = difference(stress, np.ones(56), *pair)
        assert len(level) > 15
        assert np.max(np.abs(apart)) < 1e-12


def cycles(random: np.random.Generator, name: str, turns: tuple[float, ...]) -> TestCurve:
    way, place = read(random, turns, 20)
    stress = 0.4 * loop_of(way, place, turns) * (1.0 + 0.03 * random.standard_normal())
    stress += NOISE * random.standard_normal(len(way))
    return TestCurve("uniaxial", place, stress, time_s=way / 0.01, source=name, specimen=name)


@pytest.mark.parametrize("seed", range(6))
def test_specimens_read_thinly_at_their_turns_are_replicates_and_tell_the_noise(seed: int) -> None:
    random = np.random.default_rng(seed)
    tests = [cycles(random, name, TURNS) for name in "abc"]
    problem = fabric_problem(law("neo-hookean"), (0.1,), tests)
    assert len(replicates(problem.curves)) == 2
    noise = estimate_noise(problem)
    assert noise.source == "replicates and local differences"
    assert noise.sd == pytest.approx(np.full(len(noise.sd), NOISE), rel=0.25)
    assert noise.gain_sd < 0.08


def test_specimens_that_turn_elsewhere_by_more_than_a_step_are_no_replicates() -> None:
    random = np.random.default_rng(1)
    far = tuple(1.25 if one == 1.15 else one for one in TURNS)
    problem = fabric_problem(law("neo-hookean"), (0.1,), [cycles(random, "a", TURNS), cycles(random, "b", far)])
    assert not replicates(problem.curves)


def creeps(loads: tuple[float, ...], off: float = 0.0) -> list[TestCurve]:
    """Return tests under weights [MPa] that were hung on: the strain goes on with a power of time, the load stands."""
    time = np.concatenate([[0.0], np.geomspace(1.0, 3000.0, 40)])
    random = np.random.default_rng(5)
    found = []
    for load in loads:
        stress = np.where(time > 0.0, load, 0.0) * (1.0 + off * random.standard_normal(len(time)))
        stretch = 1.0 + 0.8 * load * (time > 0.0) * (1.0 + 0.05 * time**0.25)
        found.append(TestCurve("uniaxial", stretch, stress, time_s=time, source=f"{load}"))
    return found


def test_weights_that_were_hung_on_are_no_digits_of_a_load_cell() -> None:
    """Of loads of 0.1, 0.2 and 0.3 MPa a step of 0.1 passed for what readings are rounded to."""
    problem = fabric_problem(law("neo-hookean"), np.array([0.2]), creeps((0.1, 0.2, 0.3)))
    assert np.max(estimate_noise(problem).sd) == pytest.approx(0.005 * 0.3)


@pytest.mark.parametrize("off", [0.0, 0.002])
def test_specimens_creep_alike_under_one_load_and_not_under_two(off: float) -> None:
    """The machine that holds a load holds it to a part in a thousand or so."""
    problem = fabric_problem(law("neo-hookean"), np.array([0.2]), creeps((0.1, 0.12, 0.1), off))
    assert [(one.name, two.name) for one, two in replicates(problem.curves)] == [("0.1", "0.1")]
