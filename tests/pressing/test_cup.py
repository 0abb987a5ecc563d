"""The sample cup: the gap the formula gives, the spotted fractions, and what must not change the answer."""

import numpy as np
import pytest
from rough_molds import split

from hyperfab.errors import InputError
from hyperfab.pressing.closing import Case, close_press
from hyperfab.pressing.foam_law import linear
from hyperfab.pressing.placement import check_roles, closing_frame, in_frame
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.samples import cup
from hyperfab.surface import Surface

CUP_AREA = 31853.80
SPOTTED = {3.5: 0.241570, 4.5: 0.520907, 5.5: 0.786212}


def surfaces(male_cells, female_cells):
    solids = cup.male_cup(*male_cells), cup.female_cup(*female_cells)
    return [Surface(solid.vertices, solid.faces) for solid in solids]


def closed(male, female, foam, axis="z", **options):
    frame = closing_frame(male, female, axis)
    one, two = in_frame(male, frame, 1), in_frame(female, frame, -1)
    growth = np.zeros_like(one.vertices), np.zeros_like(two.vertices)
    options = options or {"gap": 3.0}
    return close_press(Case(one, two, Sandwich(foam, 0.0, linear(0.05)), *growth, **options))


@pytest.fixture(scope="module")
def fine():
    return surfaces((155, 151), (150, 157))


@pytest.mark.parametrize("foam", SPOTTED)
def test_spotted_fraction_of_the_cup(fine, foam):
    found = closed(*fine, foam)
    touching = found.touching.sum()
    cup_faces = ~found.front.flange
    assert touching / CUP_AREA == pytest.approx(SPOTTED[foam], abs=1e-3)
    assert found.touching[cup_faces].sum() / found.front.areas[cup_faces].sum() == pytest.approx(
        SPOTTED[foam], abs=1e-3
    )


def test_gap_along_the_normal_of_the_cup(fine):
    found = closed(*fine, 4.5)
    x, y, z = found.cold.T
    exact = cup.normal_gap((x - cup.K_LEAN * z) / cup.A_MM, y / cup.B_MM)
    assert np.abs(found.normal - exact).max() < 0.02
    assert np.sqrt(np.mean((found.normal - exact) ** 2)) < 2e-3


def test_the_datum_does_not_depend_on_where_the_facets_lie():
    """Grids without a vertex at the apex give the true clearance too, to far less than their chords."""
    for male_cells, female_cells in (((61, 57), (58, 63)), ((60, 62), (59, 60))):
        found = closed(*surfaces(male_cells, female_cells), 4.5)
        assert found.datum.gap == pytest.approx(3.0, abs=5e-3)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_wrong_axis_is_refused_and_the_right_one_named(fine, axis):
    with pytest.raises(InputError, match="use --axis z"):
        closing_frame(*fine, axis)


@pytest.mark.parametrize("depth", [3.5, 20.0])
def test_of_molds_drawn_into_each_other_the_right_axis_is_named_too(depth):
    male, female = surfaces((30, 30), (31, 29))
    low = Surface(female.vertices - np.array([0.0, 0.0, depth]), female.faces)
    assert closing_frame(male, low, "z").axis == "z"
    with pytest.raises(InputError, match="use --axis z"):
        closing_frame(male, low, "x")


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_the_answer_does_not_depend_on_how_the_tool_lies_in_space(axis):
    male, female = surfaces((40, 41), (42, 39))
    straight = closed(male, female, 4.5)
    turn = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]
    turned = [Surface(s.vertices[:, turn], s.faces) for s in (male, female)]
    found = closed(*turned, 4.5, axis)
    assert found.contact.closing_force == pytest.approx(straight.contact.closing_force, rel=1e-9)
    upside = [Surface(s.vertices[:, turn] * -1.0, s.faces[:, ::-1]) for s in (male, female)]
    found = closed(*upside, 4.5, axis)
    assert found.contact.closing_force == pytest.approx(straight.contact.closing_force, rel=1e-6)


def test_shuffled_triangles_give_the_same_answer():
    male, female = surfaces((40, 41), (42, 39))
    straight = closed(male, female, 4.5)
    shuffle = np.random.default_rng(1)
    mixed = [Surface(s.vertices, shuffle.permutation(s.faces)) for s in (male, female)]
    found = closed(*mixed, 4.5)
    assert found.contact.closing_force == pytest.approx(straight.contact.closing_force, rel=1e-9)
    assert found.touching.sum() == pytest.approx(straight.touching.sum(), rel=1e-9)


@pytest.mark.slow
def test_the_female_in_more_facets_gives_the_same_press():
    """The same facets split are flat: what changes is the smooth surface read from them, by the chord of 0.02 mm.

    The sandwich is pressed by 0.7 mm on average: 3 % of its force.
    """
    male, female = surfaces((92, 84), (88, 90))
    straight = closed(male, female, 4.5)
    vertices, faces = female.vertices, female.faces
    for _ in range(2):
        vertices, faces = split(vertices, faces)
        found = closed(male, Surface(vertices, faces), 4.5)
        assert found.contact.gap.min() == pytest.approx(straight.contact.gap.min(), abs=0.02)
        assert found.contact.gap.max() == pytest.approx(straight.contact.gap.max(), abs=0.05)
        assert found.contact.closing_force == pytest.approx(straight.contact.closing_force, rel=0.03)


def test_a_force_that_is_next_to_nothing_has_its_position():
    male, female = surfaces((30, 30), (31, 29))
    for force in (1e-3, 1e-9, 1e-18):
        found = closed(male, female, 4.5, force=force)
        assert found.stroke == pytest.approx(0.0, abs=0.2)
        assert found.contact.closing_force == pytest.approx(force, rel=1e-3)


def test_swapped_molds_are_refused():
    male, female = surfaces((30, 30), (31, 29))
    frame = closing_frame(female, male, "z")
    with pytest.raises(InputError, match="swapped"):
        check_roles(in_frame(female, frame, 1), in_frame(male, frame, -1))


def test_a_force_out_of_reach_names_the_largest():
    male, female = surfaces((30, 30), (31, 29))
    with pytest.raises(InputError, match=r"largest force the sandwich can carry is \d"):
        closed(male, female, 4.5, force=1e7)


def test_the_stroke_counts_from_the_first_touch():
    male, female = surfaces((30, 30), (31, 29))
    near, far = closed(male, female, 4.5, gap=3.0), closed(male, female, 4.5, gap=4.0)
    assert near.stroke - far.stroke == pytest.approx(1.0, abs=1e-6)
    assert far.press.at(far.first_touch).closing_force == pytest.approx(0.0, abs=1e-6)
    assert closed(male, female, 4.5, gap=6.0).stroke < 0.0
