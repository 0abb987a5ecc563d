"""Fits with bounds, and a test that misses by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from hyperfab.arrays import Array
from hyperfab.loop.fitting import Descent, descent, fit, fitted_misfit
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


class Walled(Powers):
    """A line whose slope is at most one; how far off one of a half more is, no number tells."""

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much the slope is too steep."""
        slope = float(own[1])
        return {"slope": max(slope - 1.0, 0.0), "power": np.inf if slope > 1.5 else 0.0}


def test_a_fit_stays_where_numbers_tell_how_far_off_constants_are() -> None:
    steep = posed(3.0 * np.linspace(0.0, 1.0, 80), np.inf, 2)
    problem = Walled(steep.measured, steep.curves, steep.own, ())
    found = fit(problem, Noise(np.full(80, 0.01), np.inf, "known"), {}, [0.0, 0.0])
    assert found.x[1] == pytest.approx(1.0, abs=1e-3)
    assert np.isfinite(found.chi2)


def test_a_fit_ends_at_a_wall_that_no_number_holds() -> None:
    class Sheer(Powers):
        def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
            return {"slope": 1e160 * max(float(own[1]) - 1.0, 0.0)}

    steep = posed(3.0 * np.linspace(0.0, 1.0, 80), np.inf, 2)
    problem = Sheer(steep.measured, steep.curves, steep.own, ())
    found = fit(problem, Noise(np.full(80, 0.01), np.inf, "known"), {}, [0.0, 0.0])
    assert found.x[1] <= 1.0


class Rising(Powers):
    """A polynomial that never falls, at a few places."""

    places = np.linspace(0.0, 1.0, 15)

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much it falls there."""
        slope = sum(k * c * self.places ** (k - 1) for k, c in enumerate(own) if k)
        return {f"at {x:g}": float(-one) for x, one in zip(self.places, np.broadcast_to(slope, 15), strict=True)}


@pytest.mark.parametrize("waves", [1.0, 1.5, 2.5])
def test_a_fit_goes_on_along_walls_to_the_least_misfit(waves: float) -> None:
    """Many walls, of which the best fit is at a few: which ones is not known beforehand."""
    x = np.linspace(0.0, 1.0, 80)
    line = posed(x + 0.4 * np.sin(2.0 * np.pi * waves * x), np.inf, 8)
    problem = Rising(line.measured, line.curves, line.own, ())
    found = fit(problem, Noise(np.full(80, 0.01), np.inf, "known"), {}, np.zeros(8))
    powers = np.arange(1, 8)
    slopes = powers * Rising.places[:, None] ** (powers - 1)
    columns = np.stack([x**k for k in range(8)], axis=1)

    def misfit(own: Array) -> tuple[float, Array]:
        left = columns @ own - problem.measured
        return 0.5 * float(left @ left), columns.T @ left

    rises = {"type": "ineq", "fun": lambda own: slopes @ own[1:], "jac": lambda own: np.pad(slopes, ((0, 0), (1, 0)))}
    best = minimize(misfit, found.x, jac=True, method="SLSQP", constraints=[rises], options={"ftol": 1e-14})
    assert found.chi2 <= 1.001 * 2.0 * best.fun / 0.01**2
    assert max(problem.forbidden(found.x, {}).values()) < 1e-6


class Exponentials(Problem):
    """A factor of two exponential terms over 0 to 1, as of a law of Ogden's and a softer weft."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return its values."""
        x = np.linspace(0.0, 1.0, len(self.measured))
        return np.asarray(own[0] * (own[1] * np.expm1(own[2] * x) + own[3] * np.expm1(own[4] * x)))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_power_that_counts_for_nothing_does_not_stop_the_others(factor: float) -> None:
    names = (("factor", 1.0, 10.0), ("a", 0.01, np.inf), ("p", 20.0, 30.0), ("b", 0.4, np.inf), ("q", 5.0, 30.0))
    own = tuple(Constant(name, scale, -bound, bound, scale=scale) for name, scale, bound in names)
    x = np.linspace(0.0, 1.0, 80)
    measured = -0.28 * np.expm1(-5.4 * x)
    problem = Exponentials(measured, (Curve("0", 0, 80, np.arange(80.0)),), own, ())
    found = fit(problem, Noise(np.full(80, 1e-3), np.inf, "known"), {}, [factor, -2e-7, -4.5, -0.28, -5.0])
    assert found.chi2 < 80.0


def test_one_test_that_misses_is_not_lost_among_those_that_do_not() -> None:
    left = np.random.default_rng(0).standard_normal(80)
    left[60:] = np.where(np.arange(20) % 2, 2.2, -2.2)
    problem = posed(left, 1.0, 1)
    noise = Noise(np.ones(80), 20.0, "local differences")
    assert not judge(problem, noise, fit(problem, noise, {}, [0.0]), []).is_noise
    even = posed(left * np.sqrt(80.0) / np.linalg.norm(left), 1.0, 1)
    assert judge(even, noise, fit(even, noise, {}, [0.0]), []).p_lack_of_fit > 0.05


class Rational(Problem):
    """Kowalik and Osborne's rational function of two quadratics, and how often it was asked for."""

    asked = 0
    places = np.array([4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625])

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return its values."""
        self.asked += 1
        x = self.places
        return np.asarray(own[0] * (x**2 + x * own[1]) / (x**2 + x * own[2] + own[3]))


def rational() -> Rational:
    """Return the problem MGH09 of NIST's Statistical Reference Datasets: a long curved valley."""
    read = [0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246]
    own = tuple(Constant(f"b{k}", 0.0, scale=0.1) for k in range(1, 5))
    return Rational(np.array(read), (Curve("t", 0, 11, np.arange(11.0)),), own, ())


SMALL = Noise(np.full(11, 1e-4), np.inf, "known")


@pytest.mark.parametrize("start", [[25.0, 39.0, 41.5, 39.0], [0.25, 0.39, 0.415, 0.39]])
def test_a_fit_finds_the_certified_end_of_a_curved_valley(start: list[float]) -> None:
    found = fit(rational(), SMALL, {}, start)
    certified = [1.9280693458e-01, 1.9128232873e-01, 1.2305650693e-01, 1.3606233068e-01]
    assert found.chi2 * 1e-8 == pytest.approx(3.0750560385e-04, rel=1e-5)
    assert found.x == pytest.approx(certified, rel=5e-3)
    deviation = [1.1435312227e-02, 1.9633220911e-01, 8.0842031232e-02, 9.0025542308e-02]
    assert found.sd * np.sqrt(found.chi2 / 7) == pytest.approx(deviation, rel=5e-3)


def test_the_stiffness_of_a_specimen_that_was_led_alone_is_not_forgiven_in_a_fit() -> None:
    """It may be the model's, which would drift off the data; what is left is then judged by the whole noise."""
    problem = rational()
    once = fit(problem, SMALL, {}, [0.25, 0.39, 0.415, 0.39])
    measured = problem.measured
    wider = Noise(
        SMALL.sd, np.inf, "known", gain_sd=0.05, groups=(np.arange(11),), alike=((0,),), pattern=measured,
        measured=measured,
    )  # fmt: skip
    again = fit(problem, wider, {}, [0.25, 0.39, 0.415, 0.39])
    assert again.x == pytest.approx(once.x, rel=1e-9)
    assert again.chi2 < once.chi2


class Counted(Powers):
    """A polynomial that counts its answers."""

    asked = 0

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return its values."""
        self.asked += 1
        return super().predict(own, terms)


def counted(held: int) -> tuple[Counted, Noise]:
    free = posed(np.exp(np.linspace(0.0, 1.0, 80)), np.inf, 4)
    own = tuple(Constant(c.name, 1.0, 1.0, 1.0) if k < held else c for k, c in enumerate(free.own))
    return Counted(free.measured, free.curves, own, ()), Noise(np.full(80, 0.01), np.inf, "known")


@pytest.mark.parametrize("held", [0, 2, 4])
def test_nothing_is_asked_of_constants_that_are_held(held: int) -> None:
    problem, noise = counted(held)
    one = Descent(problem, noise, {}, np.ones(4))
    before = problem.asked
    one.ask()
    assert problem.asked - before == 4 - held
    assert np.all(one.jacobian[:, :held] == 0.0)
    assert np.all(one.jacobian[-1, held:] != 0.0)


def scattering(noise: Noise, measured: Array, gain_sd: float, alike: tuple[tuple[int, ...], ...]) -> Noise:
    groups = (np.arange(40), np.arange(40, 80))
    return Noise(
        noise.sd, np.inf, "known", gain_sd=gain_sd, groups=groups, alike=alike, pattern=measured, measured=measured
    )


@pytest.mark.parametrize("alike", [((0,), (1,)), ((0, 1),)])
def test_a_fit_is_made_anew_for_another_scatter_only_where_specimens_were_led_alike(
    alike: tuple[tuple[int, ...], ...],
) -> None:
    problem, noise = counted(0)
    fit(problem, scattering(noise, problem.measured, 0.02, alike), {}, np.ones(4))
    before = problem.asked
    fit(problem, scattering(noise, problem.measured, 0.05, alike), {}, np.ones(4))
    assert (problem.asked > before) is (len(alike) == 1)


def test_what_a_model_leaves_in_a_metric_is_worked_out_once() -> None:
    problem, noise = counted(0)
    near = fit(problem, noise, {}, np.ones(4))
    first = fitted_misfit(problem, noise.among(near.predicted, 0.0), near)
    before = problem.asked
    again = fitted_misfit(problem, noise.among(near.predicted, 0.0), near)
    assert problem.asked == before
    assert np.array_equal(again, first)
    louder = Noise(2.0 * noise.sd, np.inf, "known")
    assert not np.array_equal(fitted_misfit(problem, louder, near), again)


@pytest.mark.parametrize(("well_known", "steps"), [(True, [3] * 4 + [2] * 2), (False, [5] * 4)])
def test_the_worse_half_of_several_starts_is_left_soon_where_constants_are_well_known(
    well_known: bool, steps: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, noise = counted(0)
    monkeypatch.setattr(Counted, "well_known", well_known)
    asked: list[tuple[int, float]] = []
    advance = Descent.advance
    monkeypatch.setattr(Descent, "advance", lambda self, n: asked.append((n, self.cost)) or advance(self, n))
    starts = [np.full(4, start) for start in (1.0, 30.0, -30.0, 2.0)]
    found = descent(problem, noise, {}, starts)
    assert [n for n, _ in asked] == [*steps, 30]
    assert found.x == pytest.approx(fit(problem, noise, {}, np.ones(4)).x, rel=1e-6)


def test_constants_err_as_much_as_is_told_where_specimens_differ() -> None:
    """Pairs led alike, as they differ by chance, must not make a slope as sure as their readings: over many draws."""
    rows, draw = 80, np.random.default_rng(8)
    line = 1.0 + np.linspace(0.0, 1.0, rows)
    each = tuple(np.arange(k, k + 20) for k in range(0, rows, 20))
    starts = tuple(int(one[0]) for one in each)
    plain = Noise(
        np.full(rows, 0.02), np.inf, "known", gain_sd=0.05, correlation=0.5, starts=starts, groups=each,
        alike=((0, 1), (2, 3)), pattern=line, measured=line,
    )  # fmt: skip
    found, told = [], []
    for _ in range(400):
        white, loud = draw.standard_normal(rows), np.empty(rows)
        for row in range(rows):
            loud[row] = white[row] if row in starts else 0.5 * loud[row - 1] + np.sqrt(0.75) * white[row]
        read = line * np.repeat(1.0 + 0.05 * draw.standard_normal(4), 20) + 0.02 * loud
        noise = replace(plain, pattern=read, measured=read)
        one = fit(posed(read, np.inf, 2), noise, {}, [1.0, 1.0])
        found.append(one.x)
        told.append(sum(one.errors(noise)))
    # Of 400 draws a standard deviation is known to 3.5 %.
    assert np.sqrt(np.diag(np.mean(told, axis=0))) == pytest.approx(np.std(found, axis=0), rel=0.1)
    assert np.corrcoef(np.transpose(found))[0, 1] == pytest.approx(
        np.mean(told, axis=0)[0, 1] / np.sqrt(np.prod(np.diag(np.mean(told, axis=0)))), abs=0.05
    )
