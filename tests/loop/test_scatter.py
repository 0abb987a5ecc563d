"""Noise of readings at scattered places and along curves: of a known size, found to what so many readings can tell."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.loop.noise_estimate import third_differences
from hyperfab.loop.problem import Curve
from hyperfab.loop.scatter import guess_of_cloud, guess_of_curve, loudness, patches


def test_repeats_at_one_place_differ_by_root_two_of_the_noise() -> None:
    """Eight places read twice, each pair 0.3 apart: the noise is 0.3/sqrt(2), to the last digit."""
    x = np.linspace(0.0, 1.0, 8)
    places = np.repeat(np.column_stack([x, x**2]), 2, axis=0)
    values = np.repeat(10.0 * x, 2) + np.tile([0.0, 0.3], 8)
    found = guess_of_cloud(places, values)
    assert found.size == pytest.approx(0.3 / np.sqrt(2.0), rel=1e-12)
    assert found.dof == 8.0
    assert found.found == pytest.approx(np.full(8, 0.3 / np.sqrt(2.0)) * np.sign(found.found), rel=1e-12)


@pytest.mark.parametrize("tilted", [False, True])
def test_noise_about_a_plane_is_found_to_what_so_many_readings_tell(tilted: bool) -> None:
    rng, count, sd = np.random.default_rng(11), 3000, 0.07
    places = rng.uniform(0.0, 1.0, (count, 2))
    values = 4.0 * places[:, 0] - 3.0 * places[:, 1] + sd * rng.standard_normal(count)
    if tilted:
        places = np.column_stack([places, places @ [0.3, -0.5]])
    guess = guess_of_cloud(places, values)
    size, dof = guess.size, guess.dof
    assert size == pytest.approx(sd, rel=0.06)
    assert dof == pytest.approx(0.5 * count)


def test_a_plane_without_noise_has_next_to_none() -> None:
    places = np.random.default_rng(12).uniform(0.0, 1.0, (200, 2))
    assert guess_of_cloud(places, 5.0 + places @ [2.0, 1.0]).size < 1e-5


def test_a_spike_counts_as_three_median_deviations() -> None:
    """Differences of +-1 but for one of 100: rms of ones and one 3 x 1.4826."""
    places = np.repeat(np.arange(20.0)[:, None], 2, axis=0)
    spiked = np.tile([0.0, np.sqrt(2.0)], 20)
    spiked[1] = 100.0
    curve = guess_of_curve(np.tile([1.0, -1.0], 40) * 0.0 + np.arange(80.0), np.arange(80.0))
    assert curve.size == pytest.approx(1e-6 * 79.0, rel=1e-9)
    found = guess_of_cloud(places, spiked)
    assert found.size > 10.0  # repeats are readings of one thing: none is left out


def test_a_smooth_curve_is_told_from_its_noise() -> None:
    rng, count, sd = np.random.default_rng(13), 4000, 0.02
    x = np.linspace(0.0, 1.0, count)
    found = guess_of_curve(np.sin(3.0 * x) + sd * rng.standard_normal(count), x)
    assert found.size == pytest.approx(sd, rel=0.05)
    assert found.dof == pytest.approx(0.4 * len(found.found))
    # In any order of the rows.
    order = rng.permutation(count)
    again = guess_of_curve((np.sin(3.0 * x) + sd * rng.standard_normal(count))[order], x[order])
    assert again.size == pytest.approx(sd, rel=0.05)


def test_what_a_temperature_does_to_readings_taken_in_turn_is_no_noise() -> None:
    rng, sd = np.random.default_rng(16), 0.01
    x, warm = np.linspace(0.0, 1.0, 600), np.tile([23.0, 40.0, 60.0], 200)
    load = x**2 * (1.0 - 0.01 * (warm - 23.0)) + sd * rng.standard_normal(600)
    assert guess_of_curve(load, x, state=warm + 0.2 * rng.uniform(-1.0, 1.0, 600)).size == pytest.approx(sd, rel=0.1)
    # Where each reading has a temperature of its own there is one curve.
    drift = guess_of_curve(load[::3], x[::3], state=np.linspace(20.0, 90.0, 200))
    assert drift.size == guess_of_curve(load[::3], x[::3]).size


def test_noise_in_proportion_that_few_readings_show_is_not_taken_for_less_than_it_is() -> None:
    """Half of a percent of each reading and a tenth of the largest, of 60: what is guessed holds in the mean."""
    x = np.linspace(1.0, 60.0, 60)
    force = 41.5 * (x / 60.0) ** 2.6
    missed = []
    for seed in range(60):
        sd = np.hypot(0.005 * force, 0.001 * force[-1])
        off = sd * np.random.default_rng(seed).standard_normal(60)
        guess = guess_of_curve(off, x, level=force + off)
        sizes, ratio = loudness([guess], force[-1])
        missed.append(np.mean((off / (sizes[0] * np.hypot(1.0, ratio * force / force[-1]))) ** 2))
    assert np.mean(missed) == pytest.approx(1.0, abs=0.15)
    assert np.quantile(missed, 0.95) < 2.2


def test_where_a_press_holds_the_readings_are_smooth_in_time() -> None:
    """Two places held for a thousand readings each, the load relaxing: noise is what is not smooth in time."""
    rng, sd = np.random.default_rng(14), 0.01
    time = np.arange(2000.0)
    held = np.repeat([1.0, 2.0], 1000)
    load = held * (1.0 + 0.5 * np.exp(-np.tile(np.arange(1000.0), 2) / 200.0))
    found = guess_of_curve(load + sd * rng.standard_normal(2000), held, time)
    assert found.size == pytest.approx(sd, rel=0.08)


def test_third_differences_have_the_variance_of_the_noise_and_none_of_a_parabola() -> None:
    """Weights 1, -3, 3, -1 over root 20, whatever the steps between readings."""
    count = 5000
    x = np.arange(float(count))
    noise = np.random.default_rng(15).standard_normal(count)
    left, _ = third_differences(0.3 * noise + 1e-4 * (x - 7.0) ** 2, Curve("", 0, count, x))
    plain = np.convolve(0.3 * noise, [1.0, -3.0, 3.0, -1.0], "valid") / np.sqrt(20.0)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(0.3, rel=0.05)
    assert np.sort(np.abs(left))[-5:] == pytest.approx(np.sort(np.abs(plain))[-5:], rel=1e-6)
    uneven = np.sort(np.random.default_rng(16).uniform(0.0, 1.0, 400))
    left, _ = third_differences(3.0 - 2.0 * uneven + 5.0 * uneven**2, Curve("", 0, 400, uneven))
    assert np.abs(left).max() < 1e-9


def test_patches_share_out_the_cloud_and_go_from_neighbour_to_neighbour() -> None:
    places = np.random.default_rng(17).uniform(0.0, 1.0, (200, 2)) * [4.0, 1.0]
    found = patches(places)
    assert len(found) == 8
    assert sorted(np.concatenate(found).tolist()) == list(range(200))
    assert min(len(part) for part in found) >= 12
    for part in found:
        # Halved across the widest: none is wider than half of the cloud, and each goes on to the nearest that is left.
        assert np.ptp(places[part], axis=0).max() < 2.0
        assert places[part[0], 0] == places[part, 0].min()
        for at in range(len(part) - 1):
            gaps = np.linalg.norm(places[part[at + 1 :]] - places[part[at]], axis=1)
            assert gaps[0] == gaps.min()


@pytest.mark.parametrize("count", [3, 4, 5])
def test_too_few_readings_to_tell_have_a_share_of_what_was_read_not_of_the_misfit(count: int) -> None:
    places = np.random.default_rng(count).uniform(-50.0, 50.0, (count, 2))
    read = 40.0 + np.arange(count)
    left = 0.05 * np.random.default_rng(3).standard_normal(count)
    for found in (
        guess_of_cloud(places, left, read),
        guess_of_curve(left, np.arange(float(count)), level=read),
    ):
        assert found.is_assumed
        assert found.dof == 4.0
        assert found.size == pytest.approx(0.02 * read.max())
