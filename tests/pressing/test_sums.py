"""What many presses are summed up by, in one pass: against the points, laws and tangents that one press is made of."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.pressing import foam_law
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.gap import Front, Gap
from hyperfab.pressing.nearby import ByPlace
from hyperfab.pressing.press import contact, stiffness
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.series import knots
from hyperfab.pressing.sums import Stack

RNG = np.random.default_rng(4)
TABLE = foam_law.table([0.0, 0.2, 0.5, 0.8], [0.0, 0.01, 0.015, 0.08])


def front() -> Front:
    """A grid of triangles of any sizes, whose last faces are the flange."""
    side = 12
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), RNG.normal(0.0, 0.2, side * side)], axis=1)
    at = np.arange(side * side).reshape(side, side)
    low, right, up, far = (part.ravel() for part in (at[:-1, :-1], at[1:, :-1], at[:-1, 1:], at[1:, 1:]))
    faces = np.concatenate([np.stack([low, right, far], axis=1), np.stack([low, far, up], axis=1)])
    areas, flange = RNG.uniform(0.3, 0.7, len(faces)), np.arange(len(faces)) > 200
    return Front(vertices, faces, np.zeros_like(vertices), areas, np.arange(side * side), flange)


def uneven(size: int) -> Array:
    """Thicknesses about 3 mm."""
    return RNG.uniform(2.0, 4.0, size)


@pytest.mark.parametrize(
    ("law", "fabric", "even"),
    [
        (TABLE, None, True),
        (TABLE, None, False),
        (TABLE, foam_law.linear(0.1), False),
        (foam_law.linear(0.05), None, True),
        (foam_law.plateau(0.01, 0.1, 0.005), None, False),  # smooth: straight between many knots
    ],
)
def test_sums_are_those_of_the_points_that_one_press_is_made_of(
    law: FoamLaw, fabric: FoamLaw | None, even: bool
) -> None:
    male = front()
    size = len(male.vertices)
    sandwich = Sandwich(3.0 if even else uneven(size), 1.0 if even else 0.3 * uneven(size), law, fabric)
    # Open, cut, pressed, and beyond the law's limit.
    nearest = RNG.uniform(0.1, 6.0, size)
    direction = RNG.normal(0.0, 0.3, (size, 3)) - [0.0, 0.0, 1.0]
    gap = Gap(nearest, direction, np.zeros(size, dtype=int), np.zeros(size, dtype=bool))
    whole = contact(male, gap, sandwich)
    arm = np.array([4.0, 7.0, 9.0])
    lever = male.vertices - arm
    modes = -np.stack([np.tile([0.0, 0.0, 1.0], (size, 1)), np.cross([1, 0, 0], lever), np.cross([0, 1, 0], lever)], -1)
    thick = [np.zeros(size) + part for part in (sandwich.foam, sandwich.fabric)]
    stack = Stack(male, thick[0], thick[1], np.array(knots(law, fabric)))
    touch = nearest + RNG.normal(0.0, 0.3, size)
    found = stack.sums(nearest, touch, direction, arm)
    close = {"rel": 3e-6 if law.bends is None else 1e-7}
    assert found.force == pytest.approx(whole.force, **close)
    assert found.moment == pytest.approx(whole.moment, **close)
    assert (found.load, found.energy) == pytest.approx((whole.load, whole.energy), **close)
    assert found.area == pytest.approx(whole.pressed_area, rel=1e-12)
    exact = stiffness(male, whole, sandwich, modes)
    assert found.tangent == pytest.approx(exact, rel=1e-3 if law.bends is None else 1e-6)
    level = contact(male, Gap(touch, direction, gap.face, gap.at_border), sandwich)
    assert found.touched.area == pytest.approx(level.pressed_area, rel=1e-12)
    pressed = level.pressed
    counted = pressed.per_face(np.ones(pressed.area.shape), len(male.faces))[~male.flange].sum()
    assert found.touched.counted == pytest.approx(counted, rel=1e-12)
    there = sandwich.at(lambda values: pressed.at_corners(male.faces, values))
    borne = (there.pressure(pressed.at_corners(male.faces, nearest)) * pressed.area).sum()
    assert found.touched.load == pytest.approx(borne, **close)
    # Where the female does not turn, nothing but moments and their tangent is left out.
    upright = stack.sums(nearest, touch, direction, arm, turns=False)
    assert upright.force == pytest.approx(found.force, rel=1e-14)
    assert upright.tangent[0, 0] == pytest.approx(found.tangent[0, 0], rel=1e-14)


def test_sums_of_a_law_by_place_are_those_of_the_one_law_where_all_places_have_it() -> None:
    male, one = front(), foam_law.linear(0.05)
    size = len(male.vertices)
    share = RNG.uniform(0.2, 0.8, size)
    same = foam_law.mixed([one, foam_law.linear(0.05)], [share, 1.0 - share])
    assert same.places is not None
    foam, fabric = uneven(size), 0.3 * uneven(size)
    gap, arm = RNG.uniform(0.5, 6.0, size), np.array([4.0, 7.0, 9.0])
    touch, direction = gap + RNG.normal(0.0, 0.3, size), RNG.normal(0.0, 0.3, (size, 3)) - [0.0, 0.0, 1.0]
    stack = Stack(male, foam, fabric, np.array(knots(one, None)))
    places = ByPlace(male, Sandwich(foam, fabric, same, None))
    for turns in (True, False):
        known, found = (each.sums(gap, touch, direction, arm, turns) for each in (stack, places))
        assert found.force == pytest.approx(known.force, rel=1e-7)
        assert found.tangent == pytest.approx(known.tangent, rel=1e-6)
        assert (found.load, found.energy, found.area) == pytest.approx((known.load, known.energy, known.area), rel=1e-7)
        assert vars(found.touched) == pytest.approx(vars(known.touched), rel=1e-7)
