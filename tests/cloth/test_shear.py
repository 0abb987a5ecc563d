"""What resists shear resists the angle between the threads, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from hyperfab.cloth import Sheet, answers, drape, mold_of, piecewise_linear, tabulate
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.net import FIXED
from hyperfab.cloth.shear import linear_shear, shear_forces, shear_of_bias
from hyperfab.cloth.start import lowered

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
STIFF = tabulate(lambda lam: (1.0 * (lam - lam**-2), 1.0 * (1 + 2 * lam**-3)), 4.0)
G, THICK = 0.05, 0.8
BELOW = mold_of(ball(1), (0.0, 0.0, -500.0))


def sheet_of(n: int = 9, m: int = 7, **options) -> Sheet:
    return Sheet(n, m, (40.0, 24.0), THICK, SOFT, SOFT, **{"shear": linear_shear(G), **options})


def sheared(sheet: Sheet, x: np.ndarray) -> tuple[float, np.ndarray]:
    f = np.zeros_like(x)
    return float(shear_forces(x, sheet.arrays, f)), f


@pytest.mark.parametrize("stretch", [(1.3, 1.0), (1.0, 1.4), (1.2, 1.5), (0.8, 1.1)])
def test_stretch_along_the_threads_meets_no_shear_force_at_all(stretch):
    sheet = sheet_of()
    x = sheet.flat() * [*stretch, 1.0]
    energy, f = sheared(sheet, x)
    assert energy == 0.0
    assert (f == 0.0).all()
    turned = x @ Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix().T + [5.0, 6.0, 7.0]
    energy, f = sheared(sheet, turned)
    assert energy < 1e-25
    assert np.abs(f).max() < 1e-13


@pytest.mark.parametrize("slope", [0.01, 0.3, -0.8])
def test_simple_shear_meets_the_modulus_times_the_angle(slope):
    sheet = sheet_of()
    x = sheet.flat()
    x[..., 0] += slope * x[..., 1]
    angle = np.arctan(slope)
    energy, f = sheared(sheet, x)
    assert energy == pytest.approx(0.5 * G * angle**2 * 40.0 * 24.0 * THICK, rel=1e-12)
    # The upper edge is pushed back along x by the slope of the energy, G gamma times d(gamma)/d(slope).
    pushed = f[:, -1].sum(0)
    assert pushed[0] == pytest.approx(-G * angle / (1.0 + slope**2) * 40.0 * THICK, rel=1e-12)
    assert f.sum((0, 1)) == pytest.approx(np.zeros(3), abs=1e-14)
    if slope == 0.01:
        assert pushed[0] == pytest.approx(-G * slope * THICK * 40.0, rel=1e-3)


def test_threads_that_turn_like_a_trellis_meet_the_modulus_times_the_angle():
    sheet, angle = sheet_of(), 0.5
    flat = sheet.flat()
    x = flat[..., :1] * [1.0, 0.0, 0.0] + flat[..., 1:2] * [np.sin(angle), np.cos(angle), 0.0]
    _, f = sheared(sheet, x)
    along = f[:, -1].sum(0) @ [np.cos(angle), -np.sin(angle), 0.0]  # square to the weft, in the plane
    assert along == pytest.approx(-G * angle * 40.0 * THICK, rel=1e-12)
    assert f[:, -1].sum(0) @ [np.sin(angle), np.cos(angle), 0.0] == pytest.approx(0.0, abs=1e-13)


def test_a_free_strip_that_resists_shear_keeps_its_width():
    for shear in (None, linear_shear(0.4)):
        sheet = Sheet(
            31,
            11,
            (90.0, 30.0),
            1.0,
            SOFT,
            SOFT,
            prestretch=(1.09, 1.0),
            shear=shear,
            edges=(FIXED, FIXED, 0, 0),
        )
        found = drape(sheet, BELOW)
        assert found.converged
        assert np.abs(found.state.x - sheet.flat()).max() < 1e-9
        assert answers(sheet, BELOW, found).slack_springs == 0


@pytest.mark.parametrize(("n", "m", "modulus"), [(31, 31, 0.02), (25, 36, 0.2)])
def test_a_ball_under_a_sheet_that_resists_shear_is_found_by_two_solvers(n, m, modulus):
    # Beside the middle of the sheet: on ridges between mirrored halves two solvers may rest on either side.
    mold = mold_of(ball(5), (1.3, -0.7, 20.0))
    forces = {}
    for shear in (None, linear_shear(modulus)):
        sheet = Sheet(n, m, (200.0, 200.0), 1.0, SOFT, STIFF, shear=shear)
        found = drape(sheet, mold, 1e-8)
        assert found.converged, found.status
        forces[shear is not None] = answers(sheet, mold, found)
    assert forces[True].press_force > forces[False].press_force
    assert np.abs(forces[True].cell_shear).max() < np.abs(forces[False].cell_shear).max()
    assert forces[True].imbalance < 1e-6
    slow = swing(sheet, mold, lowered(sheet, mold), 1e-5)
    assert slow.converged
    assert slow.energy == pytest.approx(found.energy, rel=1e-5)


def test_the_energy_of_a_sheared_sheet_converges_as_the_grid_is_refined():
    mold = mold_of(ball(6), (0.0, 0.0, 20.0))
    e = [
        drape(Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT, shear=linear_shear(0.1)), mold).energy for n in (26, 51, 101)
    ]
    assert (e[1] - e[0]) / (e[2] - e[1]) == pytest.approx(4.0, abs=1.2)


@pytest.mark.slow
def test_a_net_with_the_law_of_a_bias_test_answers_that_test_as_measured():
    bias = piecewise_linear([1.0, 1.1, 1.3, 1.6], [0.0, 0.02, 0.08, 0.30])
    law = shear_of_bias(bias, SOFT, STIFF, 1.6)
    assert (np.diff(law(law.knots)[1]) >= 0.0).all()

    def stored(a: np.ndarray) -> float:
        l1, l2, angle = a
        return float(SOFT(l1)[0][0] + STIFF(l2)[0][0] + law(1.0 + abs(angle))[0][0])

    for stretch in (1.05, 1.2, 1.4, 1.5):
        least = minimize(
            stored,
            [1.02, 1.01, 2.0 * np.log(stretch)],
            constraints={
                "type": "eq",
                "fun": lambda a, s=stretch: a[0] ** 2 + a[1] ** 2 + 2 * a[0] * a[1] * np.sin(a[2]) - 2 * s**2,
            },
            options={"ftol": 1e-14, "maxiter": 500},
        )
        l1, l2, angle = least.x
        carried = 2.0 * stretch * float(SOFT(l1)[1][0]) / (l1 + l2 * np.sin(angle))
        assert carried == pytest.approx(float(bias(stretch)[1][0]), rel=5e-3)


def test_threads_softer_than_the_bias_test_are_refused():
    with pytest.raises(ValueError, match="before they turn"):
        shear_of_bias(piecewise_linear([1.0, 1.5], [0.0, 5.0]), SOFT, SOFT, 1.5)
