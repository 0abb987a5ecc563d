"""Predictions and slopes of a fabric where what was answered before is not worked out again: the same to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fitting import Descent
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Form, Problem, split
from hyperfab.materials.registry import law

_UP = np.linspace(1.0, 1.6, 16)


def problem_of(name: str = "yeoh-3", constants: tuple[float, ...] = (0.1, 0.02, 0.01)) -> FabricProblem:
    """Return that of four tests, pulled and let go, each at its own pace, of which two state how narrow they became."""
    way = np.concatenate([_UP, _UP[-2::-1]])
    tests = [
        TestCurve(
            mode="uniaxial",
            stretch=way,
            stress=0.3 * (way - 1.0) * (1.0 + 0.1 * number),
            time_s=np.arange(float(len(way))) * 2.0**number,
            temperature_degC=np.full_like(way, 20.0 + 20.0 * (number % 2)),
            direction=90.0 * (number // 2),
            source=f"test {number}",
            stretch2=way**-0.45 if number % 2 else None,
        )
        for number in range(4)
    ]
    return fabric_problem(law(name), constants, tests)


def with_forms(problem: Problem, names: dict[str, str]) -> tuple[dict[str, Form], Array]:
    """Return the forms of these names, and constants where none of them is at its null."""
    forms = {effect: problem.effect(effect).form(form) for effect, form in names.items()}
    own = [np.array(form.starts[0]) for form in forms.values()]
    x = np.concatenate([problem.given, *own])
    scale = np.concatenate([[one.scale for one in form.constants] for form in forms.values()])
    x[len(problem.own) :] += 0.01 * scale * np.arange(1, len(scale) + 1)
    return forms, x


FORMS = [
    {"grip-slack": "each-toe", "load-offset": "each-drift", "rate": "prony-2-bent", "mullins": "pseudo-elastic"},
    {
        "load-offset": "each",
        "anisotropy": "constants-fibres",
        "elastic-law": "exponential-log",
        "hysteresis": "friction",
    },
    {"grip-slack": "yields", "permanent-set": "flow-power", "thermal-softening": "exponential", "mullins": "smooth"},
    {"permanent-set": "network", "rate": "finite", "hysteresis": "pseudo-elastic", "elastic-law": "ogden"},
    {"elastic-law": "smooth-close", "compressibility": "uniform", "rate": "prony-1", "anisotropy": "ratio"},
]


@pytest.mark.parametrize("names", FORMS, ids=lambda names: "+".join(names))
def test_slopes_are_those_of_one_prediction_after_the_other(names: dict[str, str]) -> None:
    problem = problem_of()
    forms, x = with_forms(problem, names)
    moved = x + np.diag(1e-5 * np.maximum(np.abs(x), 1e-3))
    found = problem.predict_near(x, forms, moved)
    own = len(problem.own)
    for one, told in zip(moved, found, strict=True):
        fresh = problem_of().predict(one[:own], split(one[own:], forms))
        assert np.all(np.isfinite(fresh))
        np.testing.assert_array_equal(told, fresh)


def test_what_one_test_alone_asks_for_costs_one_prediction_for_all_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, asked = problem_of(), []
    forms, x = with_forms(problem, {"load-offset": "each-drift"})
    predict = problem.predict
    monkeypatch.setattr(problem, "predict", lambda *given: asked.append(1) or predict(*given))
    there = Descent(problem, Noise(np.full(len(problem.measured), 0.01), np.inf, "known"), forms, x)
    asked.clear()
    there.ask()
    # Where it is, what three of four offsets and what four drifts do, and the law's own and the first test's offset.
    assert len(asked) == 1 + 2 + len(problem.own) + 1


def test_a_test_that_a_form_does_not_tell_of_has_the_mean_of_all() -> None:
    problem = problem_of()
    forms, x = with_forms(problem, {"load-offset": "each"})
    wider = problem.remake([*problem.tests, problem.tests[0]])
    moved = x + np.diag(np.full(len(x), 1e-4))
    found, own = wider.predict_near(x, forms, moved), len(problem.own)
    each = [wider.predict(one[:own], split(one[own:], forms)) for one in moved]
    np.testing.assert_array_equal(found, np.stack(each))
