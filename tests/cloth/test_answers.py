"""What is read off a net, on nets that are laid by hand: stress, thickness, shear, slack and forces with their size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cloth_molds import ball

from hyperfab.cloth import Sheet, answers, drape, mold_of, piecewise_linear
from hyperfab.cloth.net import FIXED, GRAVITY

#: Stress = 2 (stretch - 1) along the warp and 3 (stretch - 1) along the weft, MPa.
WARP, WEFT = piecewise_linear([1.0, 2.0], [0.0, 2.0]), piecewise_linear([1.0, 2.0], [0.0, 3.0])
FAR = mold_of(ball(1), (0.0, 0.0, -500.0))


def laid(change, n: int = 4, m: int = 3, **options):
    """The answers of a net of 10 mm by 10 mm cells whose nodes are put where ``change`` says."""
    sheet = Sheet(n, m, (10.0 * (n - 1), 10.0 * (m - 1)), 0.5, WARP, WEFT, **options)
    found = drape(sheet, FAR)
    x = found.state.x.copy()
    x[:] = change(sheet.flat())
    return sheet, found, answers(sheet, FAR, replace(found, state=found.state._replace(x=x)))


def columns_at(*places: float):
    def change(flat):
        flat[:, :, 0] = np.array(places)[:, None]
        return flat

    return change


def test_stress_at_a_node_is_the_mean_of_the_springs_on_both_sides():
    """Springs stretched 1.2, 1.5 and 1.1: 0.4, 1.0 and 0.2 MPa; between them the mean, at an end the one there is."""
    _, _, fields = laid(columns_at(0.0, 12.0, 27.0, 38.0))
    assert fields.stretch_warp == pytest.approx(np.repeat([[1.2], [1.5], [1.1]], 3, axis=1), rel=1e-12)
    expected = np.repeat([[0.4], [0.7], [0.6], [0.2]], 3, axis=1)
    assert fields.stress_warp == pytest.approx(expected, rel=1e-12)
    assert fields.stress_weft == pytest.approx(np.zeros((4, 3)), abs=1e-12)
    assert fields.slack_springs == 0
    assert fields.cell_stretch_warp == pytest.approx(np.repeat([[1.2], [1.5], [1.1]], 2, axis=1), rel=1e-12)
    assert fields.cell_thickness == pytest.approx(0.5 / np.repeat([[1.2], [1.5], [1.1]], 2, axis=1), rel=1e-12)


def test_stress_along_the_weft_too():
    def change(flat):
        flat[:, :, 1] = np.array([0.0, 14.0, 25.0])
        return flat

    _, _, fields = laid(change)
    assert fields.stress_weft == pytest.approx(np.tile([1.2, 0.75, 0.3], (4, 1)), rel=1e-12)
    assert fields.stretch_weft == pytest.approx(np.tile([1.4, 1.1], (4, 1)), rel=1e-12)
    assert fields.cell_stretch_weft == pytest.approx(np.tile([1.4, 1.1], (3, 1)), rel=1e-12)


def test_springs_that_are_shorter_than_at_rest_are_counted_and_bear_nothing():
    _, _, fields = laid(columns_at(0.0, 9.0, 21.0, 30.0))
    assert fields.slack_springs == 6
    assert fields.stress_warp == pytest.approx(np.repeat([[0.0], [0.2], [0.2], [0.0]], 3, axis=1), rel=1e-12)
    assert fields.cell_slack.tolist() == [[True, True], [False, False], [True, True]]


def test_a_cell_that_is_sheared_by_thirty_degrees():
    """A parallelogram of sides 12 and 10: the area is 120 cos 30, the angle off the right one is 30."""

    def change(flat):
        flat[:, :, 0] = 1.2 * flat[:, :, 0] + 0.5 * flat[:, :, 1]
        flat[:, :, 1] *= np.cos(np.radians(30.0))
        return flat

    _, _, fields = laid(change)
    assert fields.cell_shear == pytest.approx(np.full((3, 2), 30.0), rel=1e-9)
    assert fields.cell_thickness == pytest.approx(
        np.full((3, 2), 0.5 * 100.0 / (120.0 * np.cos(np.radians(30.0)))), rel=1e-9
    )


def test_a_flat_sheet_pulled_both_ways_pulls_at_its_clamps_with_stress_times_section():
    sheet, _, fields = laid(lambda flat: flat, 5, 4, prestretch=(1.2, 1.1))
    # Mounted 40 x 30 mm; before it was stretched 40 / 1.2 long and 30 / 1.1 wide, 0.5 mm thick.
    assert fields.reaction[-1, :, 0].sum() == pytest.approx(0.4 * 30.0 / 1.1 * 0.5, rel=1e-9)
    assert fields.reaction[:, -1, 1].sum() == pytest.approx(0.3 * 40.0 / 1.2 * 0.5, rel=1e-9)
    assert fields.reaction[:, 0, 1].sum() == pytest.approx(-0.3 * 40.0 / 1.2 * 0.5, rel=1e-9)
    energy = (0.5 * 2.0 * 0.2**2 + 0.5 * 3.0 * 0.1**2) * 40.0 / 1.2 * 30.0 / 1.1 * 0.5
    assert fields.spring_energy == pytest.approx(energy, rel=1e-9)
    assert fields.cell_thickness == pytest.approx(np.full((4, 3), 0.5 / 1.32), rel=1e-9)
    assert fields.imbalance < 1e-9
    assert fields.press_force == 0.0
    assert not fields.touching.any()
    assert (sheet.fixed == FIXED).sum() == 14


def test_the_weight_of_the_sheet_hangs_on_its_clamps():
    """200 g/m^2 on 40 x 30 mm, 1.2 times smaller both ways before mounting: 1.634 mN; a strip of half a cell beside the
    clamps hangs there directly."""
    sheet, found, fields = laid(lambda flat: flat, 5, 4, prestretch=(1.2, 1.2), mass=200.0)
    weight = 200.0 * 40.0 / 1.2 * 30.0 / 1.2 * 1e-9 * GRAVITY
    assert sheet.arrays.weight.sum() == pytest.approx(weight, rel=1e-12)
    assert weight == pytest.approx(1.634442e-3, rel=1e-6)
    assert found.converged
    true = answers(sheet, FAR, found)
    assert true.reaction[:, :, 2].sum() == pytest.approx(weight, rel=1e-4)
    assert true.imbalance < 1e-4 * weight
    assert fields.spring_energy > 0.0


@pytest.mark.parametrize("sides", [(0.2, 0.3), (0.5, 0.1)])
def test_the_blank_holder_shares_its_friction_out_along_an_edge(sides):
    sheet = Sheet(5, 4, (40.0, 30.0), 0.5, WARP, WEFT, edges=(4, 4, 4, 4), holder=(*sides, 0.0, 0.0))
    force = sheet.holder_force
    assert force[0].sum() == pytest.approx(sides[0] * 30.0, rel=1e-12)
    assert force[-1].sum() == pytest.approx(sides[1] * 30.0, rel=1e-12)
    assert force[0] == pytest.approx(sides[0] * np.array([5.0, 10.0, 10.0, 5.0]), rel=1e-12)
    assert not force[1:-1].any()
