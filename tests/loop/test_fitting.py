"""The fit of constants against the exact solution of a linear model, whatever their units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Array, Constant, Curve, Problem


class Line(Problem):
    """A straight line and a bend, each constant in a unit of its own."""

    units_of = np.array([1.0, 1e-3, 1e-9])

    def columns(self) -> Array:
        x = np.linspace(0.0, 1.0, 40)
        return np.stack([np.ones(40), x, x**2], axis=1) / self.units_of

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        return np.asarray(self.columns() @ own)


def test_fit_is_that_of_linear_least_squares_though_units_lie_far_apart() -> None:
    random = np.random.default_rng(5)
    own = tuple(Constant(name, 0.0, scale=unit) for name, unit in zip("abc", Line.units_of, strict=True))
    problem = Line(np.zeros(40), (Curve("one", 0, 40, np.arange(40.0)),), own, ())
    columns = problem.columns()
    problem.measured = columns @ (Line.units_of * [2.0, -1.0, 3.0]) + 0.1 * random.standard_normal(40)
    found = fit(problem, Noise(np.full(40, 0.1), np.inf, "known"), {}, [0.0, 0.0, 0.0])
    scaled = columns * Line.units_of
    expected = np.linalg.lstsq(scaled, problem.measured, rcond=None)[0]
    assert found.x / Line.units_of == pytest.approx(expected, rel=1e-6)
    spread = 0.1 * np.sqrt(np.diag(np.linalg.inv(scaled.T @ scaled)))
    assert found.sd / Line.units_of == pytest.approx(spread, rel=1e-6)
