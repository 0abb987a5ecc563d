"""What goes along with a few numbers is foretold by what is known of it, and by nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.numerics.trend import Trend


def parabola(at: np.ndarray) -> np.ndarray:
    x, y, z = at
    return np.array([1.0 + 0.3 * x + 0.2 * y - 0.5 * z + 0.02 * x * x - 0.03 * x * y + 0.01 * y * z])


def known(places: np.ndarray) -> Trend:
    trend = Trend()
    for at in places:
        trend.add(at, parabola(at))
    return trend


def test_places_along_lines_do_not_say_what_numbers_do_together():
    """Either way along three numbers and nearly along two of them, and one place drawn: what x and y do together hangs
    on that one alone, y and z on rounding; both are left out, and what is foretold is off by no more than they do."""
    lines = np.concatenate([np.eye(3), [[1.0, -1e-3, 1.7], [2.0, 0.0, 0.0], [-1.4, 1e-4, 1.4]]])
    places = np.concatenate([lines, -lines, [[0.2, 1.9, 0.5]]])
    jitter = 1e-3 * np.random.default_rng(1).standard_normal(len(places))
    trend = Trend()
    for at, off in zip(places, jitter, strict=True):
        trend.add(at, parabola(at) + off)
    for at in np.random.default_rng(2).standard_normal((50, 3)):
        found = trend.at(at)
        assert found is not None
        assert found == pytest.approx(parabola(at), abs=0.1 + 0.1 * np.abs(at).max() ** 2)


@pytest.mark.parametrize("seed", range(5))
def test_places_drawn_at_random_say_all(seed):
    trend = known(np.random.default_rng(seed).standard_normal((13, 3)))
    at = np.array([1.5, -2.0, 1.0])
    assert trend.at(at) == pytest.approx(parabola(at), abs=1e-9)
