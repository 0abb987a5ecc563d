"""Fits with bounds, and a test that misses by itself."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from scipy.optimize import lsq_linear

from hyperfab.arrays import Array
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import judge
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Curve, Problem


class Powers(Problem):
    """A polynomial over 0 to 1."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return its values."""
        x = np.linspace(0.0, 1.0, len(self.measured))
        return np.asarray(sum(c * x**k for k, c in enumerate(own)))


def posed(measured: Array, bound: float, size: int) -> Powers:
    own = tuple(Constant(f"c{k}", 0.0, -bound, bound) for k in range(size))
    edges = np.linspace(0, len(measured), 5).astype(int)
    curves = tuple(Curve(str(a), int(a), int(b), np.arange(float(b - a))) for a, b in pairwise(edges))
    return Powers(measured, curves, own, ())


def test_a_fit_goes_on_along_its_bounds_to_the_least_misfit() -> None:
    x = np.linspace(0.0, 1.0, 80)
    problem = posed(3.0 * np.exp(-6.0 * x) + x, 1.0, 5)
    found = fit(problem, Noise(np.full(80, 0.01), np.inf, "known"), {}, np.full(5, 0.3))
    best = lsq_linear(np.stack([x**k for k in range(5)], axis=1), problem.measured, (-1.0, 1.0))
    assert found.chi2 <= 1.001 * 2.0 * best.cost / 0.01**2


def test_one_test_that_misses_is_not_lost_among_those_that_do_not() -> None:
    left = np.random.default_rng(0).standard_normal(80)
    left[60:] = np.where(np.arange(20) % 2, 2.2, -2.2)
    problem = posed(left, 1.0, 1)
    noise = Noise(np.ones(80), 20.0, "local differences")
    assert not judge(problem, noise, fit(problem, noise, {}, [0.0]), []).is_noise
    even = posed(left * np.sqrt(80.0) / np.linalg.norm(left), 1.0, 1)
    assert judge(even, noise, fit(even, noise, {}, [0.0]), []).p_lack_of_fit > 0.05
