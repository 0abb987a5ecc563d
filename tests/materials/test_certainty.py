"""How sure constants are and which readings stand apart: against ordinary regression, written out in numpy."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.materials import laws
from hyperfab.materials.identification import Problem, Rows, fit_law
from hyperfab.materials.identification.quality import _by_parameter, certainty, figures
from hyperfab.materials.identification.stable import Stable
from hyperfab.materials.stability import stable_over, stable_ranges

STRETCH = np.linspace(1.1, 2.0, 12)
#: dW/dI1 and dW/dI2 of a uniaxial test: the columns of Mooney and Rivlin's law.
DESIGN = 2.0 * (STRETCH - STRETCH**-2)[:, None] * np.stack([np.ones_like(STRETCH), 1.0 / STRETCH], axis=1)
STRESS = DESIGN @ [0.2, 0.05] + 0.004 * np.random.default_rng(3).standard_normal(len(STRETCH))
WEIGHT = 1.0 / STRESS


@pytest.fixture(scope="module")
def fitted():
    found = fit_law(Problem(laws()["mooney-rivlin-2"], Rows.of([TestCurve("uniaxial", STRETCH, STRESS, WEIGHT)])))
    assert found is not None
    return found


def test_constants_have_the_standard_deviation_and_correlation_of_least_squares(fitted) -> None:
    J = DESIGN * WEIGHT[:, None]
    best, *_ = np.linalg.lstsq(J, np.ones(12), rcond=None)
    left = 1.0 - J @ best
    covariance = np.linalg.inv(J.T @ J) * float(left @ left) / 10.0
    assert list(fitted.material.parameters.values()) == pytest.approx(best.tolist(), rel=1e-8)
    told = certainty(fitted)
    sd = np.sqrt(np.diag(covariance))
    assert told.correlation == pytest.approx(covariance / np.outer(sd, sd), rel=1e-5)
    unit = J / np.sqrt((J * J).sum(axis=0))
    assert told.condition_number == pytest.approx(np.linalg.cond(unit), rel=1e-6)
    hat = J @ np.linalg.inv(J.T @ J) @ J.T
    assert told.leverage == pytest.approx(np.diag(hat), rel=1e-6)
    assert told.leverage.sum() == pytest.approx(2.0, rel=1e-9)


def test_a_reading_is_judged_by_what_all_others_say(fitted) -> None:
    """Each left out in truth: its distance from what the rest predict, over that distance's own deviation."""
    J, told = DESIGN * WEIGHT[:, None], certainty(fitted)
    for row in range(12):
        rest = np.arange(12) != row
        best, *_ = np.linalg.lstsq(J[rest], np.ones(11), rcond=None)
        left = 1.0 - J[rest] @ best
        variance = float(left @ left) / 9.0
        away = 1.0 - float(J[row] @ best)
        spread = variance * (1.0 + float(J[row] @ np.linalg.inv(J[rest].T @ J[rest]) @ J[row]))
        assert abs(told.studentised[row]) == pytest.approx(abs(away) / np.sqrt(spread), rel=1e-5)


def test_a_reading_that_decides_its_own_prediction_is_not_judged() -> None:
    """Two constants from readings near rest and one far out: that one is met whatever it says."""
    stretch = np.array([1.01, 1.011, 1.012, 1.013, 6.0])
    design = 2.0 * (stretch - stretch**-2)[:, None] * np.stack([np.ones(5), 1.0 / stretch], axis=1)
    stress = design @ [0.2, 0.05] * (1.0 + 0.01 * np.array([1.0, -1.0, 1.0, -1.0, 5.0]))
    curve = TestCurve("uniaxial", stretch, stress, np.ones(5))
    found = fit_law(Problem(laws()["mooney-rivlin-2"], Rows.of([curve])))
    assert found is not None
    told = certainty(found)
    assert told.leverage[-1] > 0.999
    assert told.studentised[-1] == 0.0
    assert np.all(told.studentised[:4] != 0.0)


def test_figures_of_a_test_are_those_of_their_definitions() -> None:
    measured, model = np.array([0.0, 1.0, 2.0, 4.0]), np.array([0.1, 1.1, 1.8, 4.0])
    told = figures(measured, model)
    assert told is not None
    assert pytest.approx(0.1**2 + 0.1**2, rel=1e-9) == told.E2
    assert told.relative_rms == pytest.approx(np.sqrt(0.02 / 3.0), rel=1e-9)
    # The reading of zero counts in the error over the peak.
    assert told.nrmse == pytest.approx(np.sqrt((0.1**2 + 0.1**2 + 0.2**2) / 4.0) / 4.0, rel=1e-9)
    assert told.points == 4
    assert figures(measured, np.array([0.1, np.nan, 1.8, 4.0])) is None
    assert figures(np.zeros(0), np.zeros(0)) is None


def test_stable_constants_of_two_groups_are_those_of_each_alone() -> None:
    """A law linear in its constants: nothing ties the groups, the bound on one does not move the other."""
    rising = TestCurve("uniaxial", STRETCH, DESIGN @ [0.2, 0.05], np.ones(12))
    falling = TestCurve("uniaxial", STRETCH, 0.1 * np.sin(3.0 * (STRETCH - 1.0)), np.ones(12))
    law, reach = laws()["mooney-rivlin-2"], {"uniaxial": (1.0, 2.0), "biaxial": (1.0, 1.5)}

    def solved(curves, groups):
        found = Stable(Problem(law, Rows.of(curves, groups)), reach).constants(np.zeros(0))
        assert found is not None
        return found[0]

    together = solved([rising, falling], [0, 1])
    assert together[:2] == pytest.approx(solved([rising], [0]), abs=1e-6)
    assert together[2:] == pytest.approx(solved([falling], [0]), abs=1e-6)
    assert together[:2] == pytest.approx([0.2, 0.05], abs=1e-6)
    plain, *_ = np.linalg.lstsq(DESIGN, falling.stress, rcond=None)
    assert np.abs(together[2:] - plain).max() > 0.01  # the bound was needed
    names = dict(zip(law.names, map(float, together[2:]), strict=True))
    from hyperfab.materials import bind

    assert stable_over(stable_ranges(bind("mooney-rivlin-2", names)), reach)


def test_constants_as_published_move_with_those_of_the_fit(fitted) -> None:
    """Mooney's constants are the ones that are fitted; of a law of two groups each moves with its own alone."""
    assert _by_parameter(fitted, 0) == pytest.approx(np.eye(2), abs=1e-7)
    curve = TestCurve("uniaxial", STRETCH, STRESS, WEIGHT)
    two = fit_law(Problem(laws()["mooney-rivlin-2"], Rows.of([curve, curve], [0, 1])))
    assert two is not None
    assert _by_parameter(two, 1) == pytest.approx(np.hstack([np.zeros((2, 2)), np.eye(2)]), abs=1e-7)
