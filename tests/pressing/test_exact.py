"""Gaps, contact edge, area and force against closed solutions: spheres, wedge, growth; and their order."""

import numpy as np
import pytest

from hyperfab.pressing.foam_law import linear
from hyperfab.pressing.gap import axial_gap, molding_front, nearest_gap, normal_gap
from hyperfab.pressing.mold import even_growth
from hyperfab.pressing.placement import clearance
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich

A, B, D = 70.0, 75.0, 1.5
K = 0.02


def exact_gaps(theta):
    nearest = B - np.sqrt(A**2 + 2 * A * D * np.cos(theta) + D**2)
    normal = -D * np.cos(theta) + np.sqrt(B**2 - D**2 * np.sin(theta) ** 2) - A
    axial = np.sqrt(B**2 - A**2 * np.sin(theta) ** 2) - A * np.cos(theta) - D
    return nearest, normal, axial


def errors(shapes, rings, smooth=True):
    male, female = shapes.nested_caps(rings, smooth=smooth)
    front = molding_front(male, female)
    theta = np.arccos(np.clip(front.vertices[:, 2] / A, -1.0, 1.0))
    found = (
        nearest_gap(front.vertices, female).nearest,
        normal_gap(front.vertices, front.normals, female),
        axial_gap(front.vertices, female),
    )
    return [np.sqrt(np.mean((gap - exact) ** 2)) for gap, exact in zip(found, exact_gaps(theta), strict=True)]


def pressed(shapes, rings, foam):
    male, female = shapes.nested_caps(rings)
    return Press(molding_front(male, female), female, Sandwich(foam, 0.0, linear(K * foam)))


def test_three_gaps_between_spheres(shapes):
    nearest, normal, axial = errors(shapes, 40)
    assert nearest < 5e-5
    assert normal < 3e-4
    assert axial < 1e-5


def test_facets_as_they_are_err_by_their_chords_and_the_smooth_surface_behind_them_does_not(shapes):
    flat, smooth = errors(shapes, 20, smooth=False), errors(shapes, 20)
    assert all(100.0 * s < f for s, f in zip(smooth, flat, strict=True))


def test_gaps_to_facets_as_they_are_converge_with_the_square_of_their_size(shapes):
    coarse, fine = errors(shapes, 12, smooth=False), errors(shapes, 36, smooth=False)
    orders = [np.log(c / f) / np.log(3.0) for c, f in zip(coarse, fine, strict=True)]
    assert min(orders) > 1.8


def test_force_of_full_contact(shapes):
    assert pressed(shapes, 80, 6.0).at(0.0).closing_force == pytest.approx(618.231, rel=1e-3)


def test_force_area_and_edge_of_partial_contact(shapes):
    found = pressed(shapes, 80, 4.0).at(0.0)
    assert found.closing_force == pytest.approx(46.599, rel=1e-3)
    assert found.pressed_area == pytest.approx(10445.8, rel=5e-4)
    # The touching cap's height over its edge: area = 2 pi a^2 (1 - cos(edge)).
    edge = np.degrees(np.arccos(1.0 - found.pressed_area / (2 * np.pi * A**2)))
    assert edge == pytest.approx(48.65, abs=0.03)


def test_area_and_force_converge_at_second_order(shapes):
    coarse, fine = (pressed(shapes, rings, 4.0).at(0.0) for rings in (20, 60))
    for name, exact in (("closing_force", 46.599), ("pressed_area", 10445.8)):
        ratio = abs(getattr(coarse, name) / exact - 1.0) / abs(getattr(fine, name) / exact - 1.0)
        assert np.log(ratio) / np.log(3.0) > 1.5


def test_the_position_for_a_force_gives_that_force(shapes):
    press = pressed(shapes, 20, 6.0)
    assert press.at(press.opening_for(300.0)).closing_force == pytest.approx(300.0, rel=1e-9)


@pytest.mark.parametrize("angle", [5.0, 20.0])
def test_gap_in_a_wedge(shapes, angle):
    theta = np.radians(angle)
    male = shapes.male(*shapes.plate(100.0, 40.0, 20, 4))
    female = shapes.female(*shapes.plate(400.0, 60.0, 30, 3, height=80.0, slope=np.tan(theta)))
    front = molding_front(male, female)
    distance = 80.0 / np.tan(theta) + front.vertices[:, 0]
    assert nearest_gap(front.vertices, female).nearest == pytest.approx(distance * np.sin(theta), abs=1e-9)
    assert normal_gap(front.vertices, front.normals, female) == pytest.approx(distance * np.tan(theta), abs=1e-9)


def test_uniform_growth_of_nested_spheres(shapes):
    """Radii grow, and the centres move away from the mounting faces."""
    male, female = shapes.nested_caps(40)
    male = shapes.male(male.vertices, male.faces, mount=-40.0)
    female = shapes.female(female.vertices, female.faces[:, ::-1], mount=120.0)
    em, ef = 23.6e-6 * 180.0, 12e-6 * 130.0
    axis = np.zeros(2)
    hot_male = male.moved(male.vertices + even_growth(male, em, axis).at(male.vertices))
    hot_female = female.moved(female.vertices + even_growth(female, ef, axis).at(female.vertices))
    front = molding_front(hot_male, hot_female)
    a, b = A * (1 + em), B * (1 + ef)
    height_male, height_female = 40.0, 120.0 + D
    d = D + em * height_male + ef * height_female
    centre = em * height_male
    theta = np.arccos(np.clip((front.vertices[:, 2] - centre) / a, -1.0, 1.0))
    exact = b - np.sqrt(a**2 + 2 * a * d * np.cos(theta) + d**2)
    assert np.abs(nearest_gap(front.vertices, hot_female).nearest - exact).max() < 5e-4


def test_growth_leaves_the_mounting_face_at_its_height(shapes):
    points, faces = shapes.cap(A, 80.0, 10)
    male = shapes.male(points, faces)
    low = points[:, 2] == points[:, 2].min()
    assert np.abs(even_growth(male, 0.004, np.zeros(2)).at(points)[low, 2]).max() == 0.0


def test_clearance_is_the_closest_pair_along_the_axis(shapes):
    male, female = shapes.nested_caps(30)
    assert clearance(male, female).gap == pytest.approx(B - A - D, abs=1e-4)


def test_the_nearest_of_a_smaller_female_is_her_border_wherever_the_male_reaches_beyond(shapes):
    """On an edge, or at any of its corners: the gap there is told apart, since no female lies opposite."""
    points, _ = shapes.plate(100.0, 60.0, 20, 12)
    for corner in range(3):
        vertices, faces = shapes.plate(80.0, 40.0, 4, 4, height=5.0)
        found = nearest_gap(points, shapes.female(vertices, np.roll(faces, corner, axis=1)))
        beyond = (np.abs(points[:, 0]) > 40.0) | (np.abs(points[:, 1]) > 20.0)
        inside = (np.abs(points[:, 0]) < 40.0) & (np.abs(points[:, 1]) < 20.0)
        assert found.at_border[beyond].all()
        assert not found.at_border[inside].any()


@pytest.mark.parametrize("rounding", [0.0, 1e-6])
def test_the_rim_of_a_dome_is_its_flange_also_where_its_heights_are_rounded(shapes, rounding):
    points, faces = shapes.plate(120.0, 120.0, 24, 24)
    away = np.hypot(points[:, 0], points[:, 1])
    points[:, 2] = 25.0 * np.clip(1.0 - away / 40.0, 0.0, None)
    points[:, 2] += rounding * 120.0 * np.random.default_rng(7).uniform(0.0, 1.0, len(points))
    front = molding_front(
        shapes.male(points, faces, mount=-5.0), shapes.female(*shapes.plate(140.0, 140.0, 1, 1, 40.0))
    )
    rim = (np.hypot(*front.vertices[:, :2].T) >= 40.0)[front.faces].all(axis=1)
    assert (front.flange == rim).all()
    assert front.areas[rim].sum() == pytest.approx(120.0**2 - np.pi * 40.0**2, rel=0.08)


@pytest.mark.parametrize(("deep", "has"), [(0.004, True), (2.0, False)])
def test_a_rim_has_a_groove_of_next_to_nothing_and_no_deeper(shapes, deep, has):
    points, faces = shapes.plate(120.0, 120.0, 24, 24)
    away = np.hypot(points[:, 0], points[:, 1])
    points[:, 2] = 25.0 * np.clip(1.0 - away / 40.0, 0.0, None)
    points[np.argmin(np.abs(points[:, :2] - 50.0).sum(axis=1)), 2] = -deep
    front = molding_front(
        shapes.male(points, faces, mount=-5.0), shapes.female(*shapes.plate(140.0, 140.0, 1, 1, 40.0))
    )
    rim = (away >= 40.0)[faces].all(axis=1)
    assert front.areas[front.flange].sum() == pytest.approx(has * front.areas[rim].sum(), rel=1e-3)


def test_what_dips_below_a_smaller_level_is_no_flange(shapes):
    """A shallow bowl between a ledge around it and a wall: its floor molds."""
    points, faces = shapes.plate(120.0, 120.0, 24, 24)
    away = np.hypot(points[:, 0], points[:, 1])
    points[:, 2] = 0.2 * np.minimum(away / 40.0, 1.0) ** 2 + np.clip(away - 50.0, 0.0, None)
    front = molding_front(
        shapes.male(points, faces, mount=-5.0), shapes.female(*shapes.plate(140.0, 140.0, 1, 1, 80.0))
    )
    assert not front.flange.any()
