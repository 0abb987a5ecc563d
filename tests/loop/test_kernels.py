"""What the loop is made of, on a straight line with a bump: each figure against its formula, written out in numpy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import chi2 as chi_squared
from scipy.stats import f as fisher
from scipy.stats import norm

from hyperfab.arrays import Array
from hyperfab.loop.dependence import dependence, period, suggestion
from hyperfab.loop.fitting import fit
from hyperfab.loop.heldout import HeldOut, Help, forecast, help_of, leave_curves_out
from hyperfab.loop.judge import (
    Candidate,
    autocorrelation,
    common_bic,
    correlation_time,
    judge,
    prior_misfit,
    scaled_chi2,
)
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Constant, Curve, Effect, Form, Problem
from hyperfab.loop.score import greatest_by_chance, points_at, signatures
from hyperfab.loop.search import Search
from hyperfab.numerics.gram import inverse, orthonormal

COUNT, SD = 60, 0.05
X = np.linspace(0.0, 1.0, COUNT)
BUMP = np.exp(-0.5 * ((X - 0.4) / 0.1) ** 2)


class Line(Problem):
    """``a + b x``, and what it may lack: a bump at 0.4, or a step that the constants can imitate in part."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        shapes = {"bump": BUMP, "bend": X**2, "level": np.ones(COUNT)}
        found = own[0] + own[1] * X
        for name, (_, values) in terms.items():
            found = found + values[0] * shapes[name]
        return np.asarray(found)


def entry(name: str, low: float = -10.0) -> Effect:
    form = Form("one", (Constant("size", 0.0, low, 10.0, 0.1),), ((0.3,),), ((0.01,),))
    return Effect(name, name, "", "", (form,))


def line(measured: Array, *, prior: float = np.inf, curves: int = 3, effects: tuple[Effect, ...] = ()) -> Line:
    own = (Constant("a", 1.0, prior_sd=prior), Constant("b", 2.0, prior_sd=prior))
    edges = np.linspace(0, COUNT, curves + 1).astype(int)
    parts = tuple(Curve(f"t{k}", int(a), int(b), X[a:b]) for k, (a, b) in enumerate(pairwise(edges)))
    return Line(measured, parts, own, effects)


def readings(bump: float = 0.0, seed: int = 4) -> Array:
    return 1.2 + 1.7 * X + bump * BUMP + SD * np.random.default_rng(seed).standard_normal(COUNT)


WHITE = Noise(np.full(COUNT, SD), 40.0, "known")
DESIGN = np.stack([np.ones(COUNT), X], axis=1)


def test_a_fit_is_the_least_squares_one_with_its_covariance() -> None:
    y = readings()
    found = fit(line(y), WHITE, {}, [0.0, 0.0])
    best, *_ = np.linalg.lstsq(DESIGN, y, rcond=None)
    covariance = SD**2 * np.linalg.inv(DESIGN.T @ DESIGN)
    assert found.x == pytest.approx(best, abs=1e-6)
    assert found.sd == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-4)
    assert found.covariance == pytest.approx(covariance, rel=1e-3)
    assert found.chi2 == pytest.approx(float(np.sum((y - DESIGN @ best) ** 2)) / SD**2, rel=1e-6)
    assert found.residual == pytest.approx((y - DESIGN @ best) / SD, abs=1e-4)
    assert found.cost == pytest.approx(found.chi2, rel=1e-9)


def test_what_is_known_beforehand_pulls_as_much_as_it_is_sure() -> None:
    """Constants known to 0.02: the posterior mean of a normal prior, and its covariance."""
    y, known = readings(), 0.02
    found = fit(line(y, prior=known), WHITE, {}, [1.0, 2.0])
    firm = 1.0
    for _ in range(100):
        precision = DESIGN.T @ DESIGN / SD**2 + firm * np.eye(2) / known**2
        mean = np.linalg.solve(precision, DESIGN.T @ y / SD**2 + firm * np.array([1.0, 2.0]) / known**2)
        # A misfit counts as noise: the prior is held as much firmer.
        firm = max(float(np.sum((y - DESIGN @ mean) ** 2)) / SD**2 / COUNT, 1.0)
    assert found.x == pytest.approx(mean, abs=2e-4)
    assert found.sd == pytest.approx(np.sqrt(np.diag(np.linalg.inv(precision))), rel=0.02)
    assert found.cost - found.chi2 == pytest.approx(firm * float(np.sum((mean - [1.0, 2.0]) ** 2)) / known**2, rel=0.02)
    assert np.diag(inverse(np.diag([4.0, 0.25]), 1e-9)) == pytest.approx([0.25, 4.0])


def test_a_signature_is_what_the_constants_cannot_imitate() -> None:
    y = readings(0.12)
    problem = line(y, effects=(entry("bump"), entry("bend"), entry("level")))
    fitted = fit(problem, WHITE, {}, [1.0, 2.0])
    found = {one.effect.id: one for one in signatures(problem, WHITE, fitted, problem.effects)}
    # A level is the constant a itself: nothing of it can be seen.
    assert found.keys() == {"bump", "bend"}
    q, _ = np.linalg.qr(DESIGN)
    for name, shape in (("bump", BUMP), ("bend", X**2)):
        rest = shape - q @ (q.T @ shape)
        left = (y - q @ (q.T @ y)) / SD
        one = found[name]
        assert one.kept == pytest.approx(float(rest @ rest) / float(shape @ shape), rel=1e-4)
        assert one.size == pytest.approx(0.01 * float(np.linalg.norm(rest)) / SD, rel=1e-4)
        assert one.z == pytest.approx(float(rest @ left) / float(np.linalg.norm(rest)), rel=1e-4)
        assert points_at(one) == pytest.approx(abs(one.z), rel=1e-9)
        assert np.linalg.norm(one.direction) == pytest.approx(1.0, rel=1e-9)


def test_an_effect_of_one_sign_does_not_point_the_other_way() -> None:
    problem = line(readings(-0.3), effects=(entry("bump", low=0.0),))
    (one,) = signatures(problem, WHITE, fit(problem, WHITE, {}, [1.0, 2.0]), problem.effects)
    assert one.z < -5.0
    assert points_at(one) == 0.0


def known(dof: float) -> Noise:
    return Noise(np.ones(1), dof, "told")


@pytest.mark.parametrize("seen", [1.5, 2.5, 3.5])
def test_the_greatest_of_a_score_by_chance(seen: float) -> None:
    """One entry: Student's tails. Two at right angles: 1 - (1 - p)^2, the noise being known."""
    problem = line(readings(), effects=(entry("bump"), entry("bend")))
    one, two = signatures(problem, WHITE, fit(problem, WHITE, {}, [1.0, 2.0]), problem.effects)
    single = 2.0 * norm.sf(seen)
    object.__setattr__(one, "z", seen)
    assert greatest_by_chance([one], known(np.inf)) == pytest.approx(single, abs=4.0 * math.sqrt(single / 2000) + 1e-3)
    across = two.direction - one.direction * float(one.direction @ two.direction)
    object.__setattr__(two, "direction", across / np.linalg.norm(across))
    object.__setattr__(two, "z", 0.0)
    both = 1.0 - (1.0 - single) ** 2
    exact = known(np.inf)
    assert greatest_by_chance([one, two], exact) == pytest.approx(both, abs=4.0 * math.sqrt(both / 2000) + 1e-3)
    # Alike, they count for one.
    object.__setattr__(two, "direction", one.direction)
    assert greatest_by_chance([one, two], exact) == pytest.approx(single, abs=4.0 * math.sqrt(single / 2000) + 1e-3)
    # A noise that is known by four readings makes great scores commoner.
    assert greatest_by_chance([one], known(4.0)) > 1.2 * greatest_by_chance([one], known(np.inf))
    assert greatest_by_chance([], known(10.0)) == 1.0


def test_an_orthonormal_basis_spans_its_columns() -> None:
    tall = np.stack([np.ones(COUNT), X, X**2, 2.0 * X], axis=1)
    basis = orthonormal(tall)
    assert basis.shape == (COUNT, 3)
    assert basis.T @ basis == pytest.approx(np.eye(3), abs=1e-6)
    assert basis @ (basis.T @ X**2) == pytest.approx(X**2, abs=1e-6)


def test_a_judgement_is_fishers_and_ljung_and_boxs() -> None:
    problem = line(readings(0.2), curves=1)
    fitted = fit(problem, WHITE, {}, [1.0, 2.0])
    found = judge(problem, WHITE, fitted, [])
    ratio = fitted.chi2 / (COUNT - 2)
    assert found.chi2_reduced == pytest.approx(ratio, rel=1e-9)
    assert found.structured == pytest.approx(math.sqrt(ratio - 1.0), rel=1e-9)
    whole, one = fisher.sf(ratio, COUNT - 2, 40.0), fisher.sf(fitted.chi2 / COUNT, COUNT, 40.0)
    assert found.p_lack_of_fit == pytest.approx(min(whole, one), rel=1e-6)
    left = fitted.residual - fitted.residual.mean()
    rho = [float(left[k:] @ left[:-k]) / float(left @ left) for k in range(1, 7)]
    statistic = COUNT * (COUNT + 2) * sum(r * r / (COUNT - k) for k, r in enumerate(rho, 1))
    assert found.p_autocorrelation == pytest.approx(chi_squared.sf(statistic, 6), rel=1e-6)
    assert found.p_greatest_score == 1.0


def test_of_several_tests_lags_are_counted_within_each() -> None:
    rng = np.random.default_rng(2)
    left, curves = rng.standard_normal(40), line(readings()).curves[:2]
    total, lags = 0.0, 0
    for curve in curves:
        part = left[curve.start : curve.stop] - left[curve.start : curve.stop].mean()
        n = len(part)
        for lag in range(1, min(6, n // 4) + 1):
            total += n * (n + 2) * (float(part[lag:] @ part[:-lag]) / float(part @ part)) ** 2 / (n - lag)
            lags += 1
    assert autocorrelation(left, curves) == pytest.approx(chi_squared.sf(total, lags), rel=1e-9)


def test_rows_that_are_alike_count_for_fewer() -> None:
    """Of a process that keeps rho of its state each row, (1 + rho)/(1 - rho) rows count as one."""
    rng, rho, count = np.random.default_rng(3), 0.6, 40_000
    left = np.empty(count)
    left[0] = 0.0
    for i, kick in enumerate(rng.standard_normal(count - 1) * math.sqrt(1 - rho**2)):
        left[i + 1] = rho * left[i] + kick
    assert correlation_time(left, [Curve("all", 0, count, np.arange(float(count)))]) == pytest.approx(
        (1 + rho) / (1 - rho), rel=0.08
    )
    assert correlation_time(np.zeros(5), [Curve("all", 0, 5, np.arange(5.0))]) == 1.0


def test_rows_of_two_curves_are_not_alike_by_standing_one_after_the_other() -> None:
    rng = np.random.default_rng(4)
    left = np.concatenate([np.cumsum(rng.standard_normal(40)), [5.0] * 25])
    curves = [Curve("a", 0, 40, np.arange(40.0)), Curve("b", 40, 65, np.arange(25.0))]
    total = 1.0
    for lag in range(1, 20):
        both = sum(
            float(left[c.start + lag : c.stop] @ left[c.start : c.stop - lag]) for c in curves if lag < c.stop - c.start
        )
        if both / float(left @ left) < 0.05:
            break
        total += 2.0 * both / float(left @ left)
    assert correlation_time(left, curves) == pytest.approx(total, rel=1e-12)


def test_whitening_makes_noise_unit_and_uncorrelated() -> None:
    """Rows of sd 0.05 that keep 0.5 of the one before, of specimens whose stiffness scatters by 10 %."""
    count, rho, gain = 12, 0.5, 0.1
    pattern = np.linspace(0.2, 1.0, count)
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    covariance = SD**2 * rho**distance + gain**2 * np.outer(pattern, pattern)
    noise = Noise(
        np.full(count, SD), 10.0, "known", gain_sd=gain, correlation=rho, starts=(0,),
        groups=(np.arange(count),), pattern=pattern,
    )  # fmt: skip
    columns = noise.whiten(np.eye(count))
    assert columns @ covariance @ columns.T == pytest.approx(np.eye(count), abs=1e-9)
    assert noise.whiten(pattern) == pytest.approx(columns @ pattern, rel=1e-12)
    # Minus twice the logarithm of what the density loses by the scatter of specimens.
    without = SD**2 * rho**distance
    lost = np.linalg.slogdet(covariance)[1] - np.linalg.slogdet(without)[1]
    assert noise.entropy == pytest.approx(lost, rel=1e-9)


def test_tests_left_out_are_predicted_as_by_a_fit_without_them() -> None:
    y = readings(0.1)
    problem = line(y, curves=4)
    found = leave_curves_out(fit(problem, WHITE, {}, [1.0, 2.0]), problem.curves)
    assert found.counted == (0, 1, 2, 3)
    for index, curve in enumerate(problem.curves):
        others = np.ones(COUNT, bool)
        others[curve.rows] = False
        best, *_ = np.linalg.lstsq(DESIGN[others], y[others], rcond=None)
        left = (y[curve.rows] - DESIGN[curve.rows] @ best) / SD
        assert found.residual[curve.rows] == pytest.approx(left, abs=1e-3)
        assert found.rms[index] == pytest.approx(math.sqrt(float(left @ left) / len(left)), rel=1e-3)


def test_a_test_that_the_others_do_not_determine_does_not_count() -> None:
    y = readings()
    problem = line(y, curves=2)
    two = Line(y, (Curve("point", 0, 1, X[:1]), Curve("rest", 1, COUNT, X[1:])), problem.own, ())
    found = leave_curves_out(fit(two, WHITE, {}, [1.0, 2.0]), two.curves)
    assert found.counted == (0,)  # one reading does not determine a line
    assert np.isnan(found.rms[1])


def held(*rms: float) -> HeldOut:
    """Tests of eight rows whose residuals are all of one size."""
    places = tuple(slice(8 * k, 8 * k + 8) for k in range(len(rms)))
    return HeldOut(np.repeat(rms, 8), tuple(range(len(rms))), np.array(rms), places)


def test_help_is_the_share_of_the_structured_error_and_of_the_tests() -> None:
    before, after = held(4.0, 3.0, 5.0, 2.0), held(2.0, 1.0, 3.0, 3.0)
    found = help_of(before, after, np.ones(32))
    structured, gone = [15.0, 8.0, 24.0, 3.0], [12.0, 8.0, 16.0, -5.0]
    taken = max(np.median(gone) / np.median(structured), np.mean(gone) / np.mean(structured))
    assert found == Help(pytest.approx(taken), pytest.approx(0.75), 4)
    assert help_of(held(4.0), held(2.0), np.ones(8)) is None
    # Most of what is explained lies in a test that the others cannot predict.
    alone = HeldOut(before.residual, (0, 1), before.rms, before.places)
    assert help_of(alone, alone, np.concatenate([np.zeros(16), np.ones(16)])) is None


def test_models_are_compared_by_schwarzs_criterion() -> None:
    y = readings(0.15)
    effects = (entry("bump"),)
    problem = line(y, effects=effects)
    plain = fit(problem, WHITE, {}, [1.0, 2.0])
    richer = fit(problem, WHITE, {"bump": effects[0].forms[0]}, [1.0, 2.0, 0.1])
    told = common_bic([plain, richer], problem, WHITE)
    scale = max(richer.chi2 / COUNT, 1.0)
    time = correlation_time(richer.residual, problem.curves)
    for names, one, constants in (((), plain, 2), (("bump",), richer, 3)):
        assert told[names] == pytest.approx(one.chi2 / scale / time + constants * math.log(COUNT / time), rel=1e-9)
    two = np.repeat([0, 1], COUNT // 2)
    halves = [float(np.sum(plain.residual[two == k] ** 2)) for k in (0, 1)]
    least = [max(float(np.mean(richer.residual[two == k] ** 2)), 1.0) for k in (0, 1)]
    assert scaled_chi2(plain, richer, two) == pytest.approx(halves[0] / least[0] + halves[1] / least[1], rel=1e-9)
    assert prior_misfit(plain, richer, problem) == 0.0


def test_what_a_residual_rides_on_is_the_share_its_means_explain() -> None:
    """Half the variance goes with one of two states, none with the other; chance is taken off."""
    rng = np.random.default_rng(6)
    side, other = np.repeat([0.0, 1.0], 400), np.tile([0.0, 1.0, 2.0, 3.0], 200)
    left = np.where(side > 0.0, 1.0, -1.0) + rng.standard_normal(800)
    found = dependence(left, {"side": side, "other": other, "none": np.full(800, 3.0)})
    assert list(found) == ["side", "other"]
    means = [left[side == k].mean() for k in (0.0, 1.0)]
    share = 400.0 * (means[0] ** 2 + means[1] ** 2) / float(left @ left)
    assert found["side"] == pytest.approx(share - 2.0 / 800.0, rel=1e-9)
    assert found["other"] < 0.01
    smooth = np.linspace(0.0, 1.0, 800)
    # Of a line over the range, means in eight bins explain all but 1/64.
    assert dependence(smooth - 0.5, {"x": smooth})["x"] == pytest.approx(1.0 - 1.0 / 64.0 - 8.0 / 800.0, abs=1e-3)


def test_a_suggestion_is_the_formula_that_is_there() -> None:
    rng = np.random.default_rng(7)
    a, b = rng.uniform(2.0, 4.0, 300), rng.uniform(-1.0, 1.0, 300)
    a[:2], b[:2] = (2.0, 4.0), (-1.0, 1.0)
    truth = 0.5 * (a - 3.0) * b
    found = suggestion(truth + 0.01 * rng.standard_normal(300), np.full(300, 0.01), {"a": a, "b": b})
    assert found is not None
    text, share = found
    assert share == pytest.approx(1.0 - 1e-4 / float(np.mean(truth**2) + 1e-4), abs=2e-3)
    assert text.startswith(("+0.5 ", "+0.49", "+0.50"))
    assert text.count("(") == 2
    assert suggestion(0.01 * rng.standard_normal(300), np.full(300, 0.01), {"a": a, "b": b}) is None


@pytest.mark.parametrize("hertz", [0.06, 0.11, 0.9])
def test_what_swings_is_told_with_its_period(hertz: float) -> None:
    rng = np.random.default_rng(3)
    time = np.sort(rng.uniform(0.0, 40.0, 300))
    drift = 0.3 * (time / 40.0) ** 2
    swing = np.sin(2.0 * np.pi * hertz * time + 1.0) + 0.2 * rng.standard_normal(300)
    found = period(swing + drift, time)
    assert found is not None
    assert found[0] == pytest.approx(1.0 / hertz, rel=0.02)
    assert 0.5 < found[1] < 1.0
    assert period(rng.standard_normal(300), time) is None
    assert period(drift, time) is None
    assert period(swing, np.full(300, np.nan)) is None


def test_a_hint_has_short_numbers_and_plain_signs() -> None:
    rate = np.linspace(-3.91402, -0.91402, 200)
    found = suggestion(0.000183777 * (rate + 2.41402) / 1.5, np.full(200, 1e-6), {"log rate": rate})
    assert found is not None
    assert found[0] == "+0.00018 (log rate + 2.41)/1.5"


def test_a_forecast_weighs_what_is_known_beforehand_against_the_noise_as_the_fit_does() -> None:
    """A third left out: the others' readings by their noise and both constants by their prior, in closed form."""
    problem, sd = (
        line(readings(0.0), prior=0.02),
        2.0 * SD,
    )  # no misfit beyond noise, which would hold the prior firmer
    noise = Noise(np.full(COUNT, sd), 40.0, "known")
    found = forecast(problem, noise, fit(problem, noise, {}, [1.0, 2.0]))
    assert found.tests == ("0 t0", "1 t1", "2 t2")
    for curve in problem.curves:
        kept = np.ones(COUNT, bool)
        kept[curve.rows] = False
        normal = DESIGN[kept].T @ DESIGN[kept] / sd**2 + np.eye(2) / 0.02**2
        right = DESIGN[kept].T @ problem.measured[kept] / sd**2 + np.array([1.0, 2.0]) / 0.02**2
        expected = DESIGN[curve.rows] @ np.linalg.solve(normal, right)
        np.testing.assert_allclose(found.predicted[curve.rows], expected, rtol=1e-6)


def test_scatter_of_stiffness_is_by_specimen() -> None:
    """Tests of one specimen are stiffer together; those of none stand alone."""
    base = line(readings(), curves=4)
    names = ("one", "other", "one", "")
    curves = tuple(replace(curve, specimen=name) for curve, name in zip(base.curves, names, strict=True))
    noise = estimate_noise(replace(base, curves=curves))
    expected = [np.concatenate([np.arange(0, 15), np.arange(30, 45)]), np.arange(15, 30)]
    assert [rows.tolist() for rows in noise.groups] == [rows.tolist() for rows in expected]


class Known(Line):
    """A line whose constants are known so well that a departure from them is told against a model."""

    well_known = True


def test_a_term_gains_what_it_spares_the_readings_and_what_is_known_less_its_price() -> None:
    """Schwarz's criterion of the sum of both: a bump that is left out bends the constants away from what is known."""
    plain = line(readings(0.8), prior=0.1, effects=(entry("bump"),))
    problem = Known(plain.measured, plain.curves, plain.own, plain.effects)
    old = fit(problem, WHITE, {}, [1.0, 2.0])
    new = fit(problem, WHITE, {"bump": problem.effects[0].forms[0]}, [1.0, 2.0, 0.8])
    found = Search(problem, WHITE).evidence(Candidate(problem, WHITE, old), Candidate(problem, WHITE, new))
    level = max(new.chi2 / COUNT, 1.0)  # what the richer one leaves counts as noise
    spared, known = old.chi2 - new.chi2, (old.cost - old.chi2) - (new.cost - new.chi2)
    assert abs(known) > 10.0
    assert new.cost - new.chi2 > 1.0
    time = correlation_time(new.residual, problem.curves)
    expected = (spared + known) / level / time - math.log(max(COUNT / time, 3.0))
    assert found.delta_bic == pytest.approx(expected, rel=1e-9)
    share = spared / max(old.chi2 - COUNT, spared)
    assert found.variance_share == pytest.approx(share, rel=1e-9)


def test_a_state_that_varies_by_rounding_alone_is_none_that_anything_rides_on() -> None:
    rng = np.random.default_rng(5)
    left = rng.standard_normal(200)
    rate = np.log(0.0083) + 2e-15 * np.sign(left)  # of clocks of tests at one speed
    assert dependence(left, {"log rate": rate}) == {}
    assert suggestion(left, np.full(200, 0.01), {"log rate": rate}) is None
