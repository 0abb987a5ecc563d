"""What a real press adds to the drawing, against closed solutions: platens out of parallel, uneven and tired foam."""

import numpy as np
import pytest

from hyperfab.pressing.balance import balance
from hyperfab.pressing.foam_law import linear, plateau, relaxed
from hyperfab.pressing.gap import molding_front
from hyperfab.pressing.mold import Pose
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich, thickness_factor

A, B, HEIGHT, MODULUS = 120.0, 80.0, 9.0, 0.2


def plates(shapes, foam, law=None, tilt=(0.0, 0.0)):
    male = shapes.male(*shapes.plate(A, B, 60, 4))
    female = shapes.female(*shapes.plate(A + 40.0, B + 40.0, 1, 1, height=HEIGHT), mount=HEIGHT)
    front = molding_front(male, female)
    sandwich = Sandwich(foam(front.vertices), 0.0, law or linear(MODULUS))
    return Press(front, female, sandwich, Pose(0.0, tilt, (0.0, 0.0, HEIGHT)))


def test_a_tilted_plate_leaves_the_gap_of_a_wedge_and_presses_on_one_side(shapes):
    tilt = np.radians(0.3)
    press = plates(shapes, lambda points: 10.0, tilt=(0.0, tilt))
    found = press.at(0.0)
    x = press.front.vertices[:, 0]
    assert found.gap == pytest.approx(HEIGHT * np.cos(tilt) - x * np.sin(tilt), abs=1e-12)
    # Pressure acts along the normal of the turned female; the middle of the linear pressure is its mean.
    mean = MODULUS * (1.0 - HEIGHT * np.cos(tilt) / 10.0)
    assert found.closing_force == pytest.approx(mean * A * B * np.cos(tilt), rel=1e-9)
    assert found.moment[1] > 0.0  # harder at positive x, where the female is low


def test_a_force_on_a_tilted_press_is_met(shapes):
    press = plates(shapes, lambda points: 10.0, tilt=(np.radians(0.2), np.radians(-0.1)))
    opening = press.opening_for(30.0)
    assert press.at(opening).closing_force == pytest.approx(30.0, rel=1e-7)
    pose, _ = balance(press, Pose(opening, press.base.tilt, press.base.pivot), None, 500.0, floating=False)
    assert pose.tilt == press.base.tilt
    assert press.at(pose).closing_force == pytest.approx(500.0 * (pose.opening - opening), rel=1e-7)


def test_foam_that_thins_out_along_x_presses_as_its_integral_says(shapes):
    slope, thickness = 0.05, 10.0
    press = plates(shapes, lambda points: thickness * thickness_factor(points, {"x": slope}))
    exact = MODULUS * A * B * (1.0 - HEIGHT / (2.0 * slope * thickness) * np.log((1 + slope) / (1 - slope)))
    assert press.at(0.0).closing_force == pytest.approx(exact, rel=1e-6)


def test_relaxed_foam_presses_with_the_share_that_is_left(shapes):
    left = relaxed([0.2, 0.1], [10.0, 1.0], 20.0)
    assert left == pytest.approx(1.0 - 0.2 * (1.0 - np.exp(-2.0)) - 0.1 * (1.0 - np.exp(-20.0)), rel=1e-14)
    law = plateau(0.0045, 0.12, 0.0016)
    fresh, tired = (plates(shapes, lambda points: 10.0, one).at(-3.0) for one in (law, law.scaled(left)))
    assert tired.closing_force == pytest.approx(left * fresh.closing_force, rel=1e-13)
    assert tired.energy == pytest.approx(left * fresh.energy, rel=1e-13)
    strain = np.linspace(0.1, 1.2, 12)  # beyond the limit too
    assert law.scaled(left).slope(strain) == pytest.approx(left * law.slope(strain), rel=1e-13)
