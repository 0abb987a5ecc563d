"""Floating molds and yielding frames against the closed solutions for a plate on an elastic layer."""

import numpy as np
import pytest

from hyperfab.errors import NotConverged
from hyperfab.pressing.balance import balance
from hyperfab.pressing.foam_law import linear
from hyperfab.pressing.gap import molding_front
from hyperfab.pressing.mold import Pose
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich

A, B, FOAM, K = 120.0, 80.0, 10.0, 0.02  # mm, mm, mm, MPa/mm


def plates(shapes, cells=24):
    male = shapes.male(*shapes.plate(A, B, cells, 2))
    female = shapes.female(*shapes.plate(A + 20.0, B + 20.0, 1, 1, height=FOAM), mount=FOAM)
    return Press(molding_front(male, female), female, Sandwich(FOAM, 0.0, linear(K * FOAM)))


def settled(press, force, eccentricity):
    start = Pose(press.opening_for(force), (0.0, 0.0), (eccentricity, 0.0, FOAM))
    pose, _ = balance(press, start, force, None, floating=True)
    return pose, press.at(pose)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_plate_tilts_by_12_e_F_over_k_a3_b_while_all_of_it_touches(shapes, share):
    # A small force: the closed solution is that of small angles.
    force, eccentricity = 2.0, share * A / 6.0
    pose, found = settled(plates(shapes), force, eccentricity)
    assert pose.angle == pytest.approx(12.0 * eccentricity * force / (K * A**3 * B), rel=2e-4, abs=1e-12)
    assert found.pressure.max() == pytest.approx(force / (A * B) * (1.0 + 6.0 * eccentricity / A), rel=1e-3)
    assert found.closing_force == pytest.approx(force, rel=1e-9)


def test_beyond_the_core_the_plate_lifts_off_and_carries_on_three_times_the_edge_distance(shapes):
    force, eccentricity = 20.0, A / 4.0
    _, found = settled(plates(shapes, 60), force, eccentricity)
    length = 3.0 * (A / 2.0 - eccentricity)
    assert found.pressed_area == pytest.approx(length * B, rel=2e-3)
    assert found.pressure.max() == pytest.approx(2.0 * force / (B * length), rel=2e-3)


def test_the_force_acts_where_it_was_put(shapes):
    _, found = settled(plates(shapes), 20.0, 15.0)
    centre_of_pressure = found.moment[1] / found.closing_force
    assert centre_of_pressure == pytest.approx(15.0, abs=0.02)


def test_a_force_outside_the_plate_tips_it_over(shapes):
    press = plates(shapes)
    with pytest.raises(NotConverged, match="tips over"):
        settled(press, 20.0, 0.6 * A)


def test_a_frame_and_the_foam_are_springs_in_series(shapes):
    press, frame = plates(shapes), 500.0
    foam = K * A * B
    start = Pose(-2.0)
    pose, _ = balance(press, start, None, frame, floating=False)
    assert press.at(pose).closing_force == pytest.approx(2.0 / (1.0 / foam + 1.0 / frame), rel=1e-9)
    assert pose.opening + 2.0 == pytest.approx(press.at(pose).closing_force / frame, rel=1e-9)


def test_a_rigid_guided_press_stays_where_it_was_set(shapes):
    assert balance(plates(shapes), Pose(-1.5), None, None, floating=False)[0] == Pose(-1.5)


def test_a_right_force_with_a_moment_that_nothing_lowers_is_no_balance(shapes, monkeypatch):
    """Of force and two moments all must vanish: one that is left is no balance, however well the others do."""
    press = plates(shapes)
    for left in ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]):
        monkeypatch.setattr("hyperfab.pressing.balance._residual", lambda *_, left=left: 5.0 * np.array(left))
        with pytest.raises(NotConverged):
            balance(press, Pose(press.opening_for(2.0), (0.0, 0.0), (0.0, 0.0, FOAM)), 2.0, None, floating=True)
