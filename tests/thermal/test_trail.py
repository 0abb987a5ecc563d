"""States put away in a file, or known by coordinates, are those that were appended."""

from __future__ import annotations

import numpy as np

from hyperfab.thermal.step import State
from hyperfab.thermal.trail import Lift, Trail


def states(count, size, rng):
    zero = np.zeros(size)
    slopes = [None, *(rng.normal(size=size) for _ in range(count - 1))]
    return [State(float(k), rng.normal(size=size), zero, zero + k, slopes[k]) for k in range(count)]


def test_states_in_the_file_come_back_as_they_were():
    rng = np.random.default_rng(1)
    given = states(20, 50, rng)
    trail = Trail(given, room=8 * 50 * 7)
    assert trail.in_memory <= 4
    sensor, nodes = rng.normal(size=50), np.array([3, 17])
    for past, state in zip(trail, given, strict=True):
        assert np.array_equal(past.temperature, state.temperature)
        assert (past.slope is None) == (state.slope is None)
        assert past.slope is None or np.array_equal(past.slope, state.slope)
        assert past.reading(sensor)[0] == np.einsum("i,i->", sensor, state.temperature)
        assert np.array_equal(past.on(nodes), state.temperature[nodes])
    assert trail[-1].rate[0] == 19.0
    every = np.stack([state.temperature[nodes] for state in given])
    assert trail.extremes(nodes) == (every.min(), every.max())


def test_reduced_states_are_lifted_and_read_alike():
    rng = np.random.default_rng(2)
    lift = Lift(rng.normal(size=30), rng.normal(size=(30, 4)))
    trail = Trail(states(3, 30, rng))
    for state in states(150, 4, rng)[1:]:
        trail.append(state, lift)
    sensor, nodes = rng.normal(size=30), np.array([2, 29, 5])
    for past in trail[3:]:
        value, rate = past.reading(sensor)
        np.testing.assert_allclose(value, sensor @ past.temperature, rtol=1e-12)
        np.testing.assert_allclose(rate, sensor @ past.slope, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(past.on(nodes), past.temperature[nodes], rtol=1e-12)
    every = np.stack([past.temperature[nodes] for past in trail])
    np.testing.assert_allclose(trail.extremes(nodes), (every.min(), every.max()), rtol=1e-12)
    trail.cut(5)
    assert len(trail) == len(trail.times) == 5
