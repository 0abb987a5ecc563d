"""The engine: what it calls noise, what it names, what it leaves open. Truths come from tests/loop/generators."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from loop.blind import as_tests, carried_out, case, problem_of
from loop.generators import fabric as truths

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.heldout import leave_curves_out
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Curve
from hyperfab.loop.search import Search
from hyperfab.materials.identification.design import Problem as IdentifiedProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.registry import law, laws


@pytest.mark.parametrize("seed", range(8))
def test_noise_is_called_noise(seed: int) -> None:
    problem, _, _, _ = case(seed, (), poor=False)
    found = close(problem)
    assert found.verdict == "noise"
    assert not found.after.ids


#: By default each effect is sought once: these by forms of other make, the others by those of the catalogue.
OTHER_MAKE = ("grip-slack", "hysteresis", "mullins", "permanent-set", "rate")


def slow_where(slow: bool, effect: str) -> Any:
    return pytest.param(effect, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize("effect", [slow_where(one in OTHER_MAKE, one) for one in truths.IDS])
@pytest.mark.parametrize("seed", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_effect_is_named_or_among_its_look_alikes(effect: str, seed: int) -> None:
    problem, _, _, _ = case(seed, (effect,), poor=False)
    found = close(problem, design=False)
    named = set(found.after.ids) | {name for one in found.indistinguishable for name in one}
    assert found.verdict in ("effect", "ambiguous")
    assert effect in named


@pytest.mark.parametrize("effect", ["hysteresis", "mullins", "rate"])
def test_poor_protocol_is_ambiguous_and_the_measurement_asked_for_settles_it(effect: str) -> None:
    problem, noise, truth, setups = case(0, (effect,), poor=True)
    found = close(problem)
    assert found.verdict == "ambiguous"
    assert any(effect in one for one in found.indistinguishable)
    asked = found.measurements[0]
    assert asked.decisive
    wider = close(carried_out(problem, asked.details, truth, noise, 0), design=False)
    assert (wider.verdict, wider.after.ids) == ("effect", (effect,))
    # The old test once more tells no more than it did.
    old = setups[0]
    again = {
        "test": old.mode,
        "direction_deg": old.angle,
        "temperature_degC": old.temperature,
        "rate_1_s": old.rate,
    }
    again |= {"stretch_turns": old.turns, "hold_s": old.hold}
    assert close(carried_out(problem, again, truth, noise, 0), design=False).verdict != "effect"


@pytest.mark.parametrize(
    "outside", ["one-gain", *(pytest.param(one, marks=pytest.mark.slow) for one in ("ripple", "stick-slip"))]
)
def test_what_no_entry_explains_stays_unexplained(outside: str) -> None:
    problem, _, _, _ = case(0, (outside,), poor=False)
    found = close(problem, design=False)
    assert found.verdict == "unexplained"
    assert found.rides_on


def test_local_differences_find_the_noise_and_replicates_the_scatter() -> None:
    random = np.random.default_rng(3)
    truth = truths.draw(random, ())
    setups = [truths.Setup(turns=(1.5, 1.0), rate=0.01) for _ in range(6)]
    readings = truths.measure(truth, setups, random, 0.003, scatter=0.04)
    noise = estimate_noise(problem_of(readings))
    assert np.median(noise.sd) == pytest.approx(0.003, rel=0.15)
    assert 0.015 < noise.gain_sd < 0.09


def test_leaving_a_curve_out_is_exact_for_a_linear_model() -> None:
    # The law is linear in its constants: refit without the curve and predict it.
    problem, _, _, _ = case(1, ("thermal-softening",), poor=False)
    noise = estimate_noise(problem)
    state = Search(problem, noise).base()
    held = leave_curves_out(state.fit, problem.curves)
    curve: Curve = problem.curves[3]
    columns = np.stack([problem.predict(np.eye(3)[i], {}) for i in range(3)], axis=1)
    rest = np.ones(len(problem.measured), dtype=bool)
    rest[curve.rows] = False
    c = np.linalg.lstsq(columns[rest], problem.measured[rest], rcond=None)[0]
    expected = (problem.measured - columns @ c)[curve.rows] / noise.sd[curve.rows]
    assert held.residual[curve.rows] == pytest.approx(expected, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize(
    "effect", [slow_where(one not in OTHER_MAKE, one) for one in truths.IDS if one != "load-offset"]
)
def test_laws_of_other_make_are_called_by_their_name(effect: str) -> None:
    """Of each effect the first kind that is no form of the catalogue (tests/loop/test_generators.py counts those)."""
    kind = {"permanent-set": 1, "compressibility": 1, "rate": 1, "thermal-softening": 2}.get(effect, 0)
    problem, _, _, _ = case(kind, (effect,), poor=False, which="other")
    found = close(problem, design=False)
    assert (found.verdict, found.after.ids) == ("effect", (effect,))


@pytest.mark.parametrize(
    "pair",
    [
        ("anisotropy", "hysteresis"),
        pytest.param(("rate", "thermal-softening"), marks=pytest.mark.slow),
        pytest.param(("mullins", "rate"), marks=pytest.mark.slow),
    ],
)
def test_two_effects_are_both_found(pair: tuple[str, str]) -> None:
    problem, _, _, _ = case(1, pair, poor=False)
    found = close(problem, design=False)
    assert found.verdict == "effect"
    assert set(found.after.ids) == set(pair)


@pytest.mark.parametrize("name", [name for name, one in laws().items() if one.isotropic])
def test_the_loop_closes_on_every_law_though_its_constants_stem_from_other_stretches(name: str) -> None:
    random = np.random.default_rng(3)
    truth = truths.draw(random, ())
    setups = [truths.Setup(turns=(1.5, 1.0), rate=0.01, points=30), truths.Setup(mode="shear", turns=(1.4,))]
    tests = as_tests(truths.measure(truth, setups, random, 0.002))
    short = np.linspace(1.01, 1.1, 20)
    curve = TestCurve("uniaxial", short, truth.elastic("uniaxial", short), np.ones(20))
    found = fit_law(IdentifiedProblem(law(name), Rows.of([curve])))
    assert found is not None
    given = [found.material.parameters[key] for key in law(name).names]
    problem = fabric_problem(law(name), given, tests)
    search = Search(problem, estimate_noise(problem))
    base = search.base()
    assert np.isfinite(base.fit.chi2)
    assert search.ranking(base)


@pytest.mark.parametrize(("softer", "found"), [(0.7, ["thermal-softening"]), (0.96, [])])
@pytest.mark.parametrize("hot", [1, 3])
def test_one_hot_specimen_among_specimens_that_scatter(softer: float, found: list[str], hot: int) -> None:
    """What it differs by counts against what the others differ by; several hot ones count more."""
    rng = np.random.default_rng(11)
    cold = truths.Setup(turns=(1.4, 1.0), rate=0.01)
    warm = truths.Setup(turns=(1.4, 1.0), rate=0.01, temperature=80.0)
    readings = truths.measure(truths.draw(rng, ()), [cold] * 4 + [warm] * hot, rng, 0.002)
    for number, gain in enumerate((1.02, 0.99, 1.015, 0.975, 1.01, 0.98, 1.02)[: len(readings)]):
        readings[number].stress = readings[number].stress * gain * (softer if number >= 4 else 1.0)
    closed = close(problem_of(readings), design=False)
    assert list(closed.after.ids) == found
    assert closed.verdict == ("effect" if found else "noise")
    assert closed.belief is not None
    assert all(closed.belief.of[name] > 0.9 for name in found)


@pytest.mark.slow
def test_a_further_name_that_makes_up_for_a_formula_is_not_told() -> None:
    """Friction of another make: with its formula damage would leave noise, a smooth law of it alone does as well."""
    problem, _, _, _ = case(0, ("hysteresis",), poor=False, which="rough")
    found = close(problem, design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("hysteresis",))
    assert found.belief is not None
    assert found.belief.of["hysteresis"] > 0.9
