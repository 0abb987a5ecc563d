"""The male of constant gap, and the ranking of what to change."""

import numpy as np
import pytest

from hyperfab.pressing.dense import dense
from hyperfab.pressing.design import DesignRefused, constant_gap, gaps, offset, with_back
from hyperfab.pressing.gap import molding_front, nearest_gap, normal_gap
from hyperfab.pressing.mold import mold
from hyperfab.pressing.sensitivity import Tooling, levers
from hyperfab.samples.cup import closed_below, female_cup, male_cup
from hyperfab.surface import Surface


@pytest.fixture(scope="module")
def female():
    solid = female_cup(120, 120)
    return mold(solid.vertices, solid.faces, -1)


def test_the_gap_of_the_designed_male_is_constant(female):
    design = constant_gap(offset(female), 4.0)
    male = mold(design.vertices, design.faces, 1)
    front = molding_front(male, female)
    nearest = nearest_gap(front.vertices, female).nearest
    assert np.ptp(nearest) < 2e-3
    assert nearest.mean() == pytest.approx(4.0, abs=1e-3)
    along = normal_gap(front.vertices, front.normals, female)
    assert np.ptp(along) < 2e-3


def test_the_designed_male_is_the_sphere_inside_a_sphere(shapes):
    female = shapes.female(*shapes.cap(75.0, 80.0, 30))
    design = constant_gap(offset(female), 5.0)
    assert np.linalg.norm(design.vertices, axis=1) == pytest.approx(70.0, abs=2e-3)


@pytest.mark.parametrize("cells", [12, 16, 20, 24, 40])
def test_the_gap_is_constant_where_the_female_has_a_blend_in_few_facets(cells):
    """Its foot turns by up to 45 degrees from facet to facet. Between the male's vertices as at them."""
    solids = male_cup(cells, cells + 1), female_cup(cells + 1, cells)
    one, two = (Surface(solid.vertices, solid.faces) for solid in solids)
    surface, drawn = dense(two, np.array([0.0, 0.0, -1.0]), one)
    female = mold(surface.vertices, surface.faces, -1, drawn=drawn)
    design = constant_gap(offset(female), 4.0)
    assert design.spread < 1e-6
    found, _ = gaps(mold(*with_back(design.vertices, design.faces, -40.0), 1), female)
    assert len(found) > 1000
    assert found == pytest.approx(4.0, abs=0.01)


@pytest.mark.parametrize(("cells", "alike"), [((12, 13), 0.1), ((24, 25), 0.03), ((92, 84), 1e-3)])
def test_the_designed_male_has_the_flange_of_the_cup(cells, alike):
    """Where the foot begins the smooth surface of the female goes on in the flange's plane, and so does the male."""
    cups = male_cup(*cells), female_cup(*cells[::-1])
    one, two = (Surface(solid.vertices, solid.faces) for solid in cups)
    surface, drawn = dense(two, np.array([0.0, 0.0, -1.0]), one)
    female = mold(surface.vertices, surface.faces, -1, drawn=drawn)
    design = constant_gap(offset(female), 4.0)
    assert design.vertices[:, 2].min() == pytest.approx(2.0, abs=3e-3)
    solid = mold(*with_back(design.vertices, design.faces, -40.0), 1)
    rims = [
        front.areas[front.flange].sum()
        for front in (molding_front(male, female) for male in (solid, mold(one.vertices, one.faces, 1)))
    ]
    assert rims[0] == pytest.approx(rims[1], rel=alike)


@pytest.mark.parametrize("degrees", [10.0, 26.0, 40.0, 60.0])
def test_along_creases_the_nearest_gap_is_what_is_asked(degrees):
    """A ramp between two levels: in its inner edge a male half way between its sides stands off both by the gap."""
    x, y = np.meshgrid([-60.0, -40, -20, -10, -5, 0, 5, 10, 20, 40, 60], np.linspace(-60.0, 60.0, 13), indexing="ij")
    height = np.clip(x, -10.0, 10.0) * np.tan(np.radians(degrees))
    solid = closed_below(np.stack([x, y, height], axis=-1), 50.0, facing_up=False)
    base = offset(mold(solid.vertices, solid.faces, -1))
    design = constant_gap(base, 4.0)
    assert design.spread < 1e-6
    start = base.front.vertices
    inner = (start[:, 0] == 10.0) & (np.abs(start[:, 1]) < 55.0)
    if degrees > 25.0:
        moved = np.linalg.norm(design.vertices - start, axis=1)[inner]
        assert moved == pytest.approx(4.0 / np.cos(np.radians(degrees / 2.0)), rel=1e-6)


def test_an_offset_beyond_the_radius_is_refused_with_the_place(shapes):
    female = shapes.female(*shapes.cap(20.0, 60.0, 12))
    with pytest.raises(DesignRefused, match="folds over itself") as refused:
        constant_gap(offset(female), 25.0)
    assert np.linalg.norm(refused.value.at) == pytest.approx(20.0, abs=0.5)


def test_a_back_makes_the_design_a_solid(female):
    design = constant_gap(offset(female), 4.0)
    found = Surface(*with_back(design.vertices, design.faces, -40.0)).soundness()
    assert found.sound
    assert found.bodies == 1


def test_levers_are_the_derivatives_of_the_gap(shapes):
    """Each lever against the gap measured again after a small change of the female."""
    male, female = shapes.nested_caps(24)
    front = molding_front(male, female)
    start = nearest_gap(front.vertices, female)
    area = np.full(len(front.vertices), 1.0)
    pivot = np.array([0.0, 0.0, 100.0])
    tool = Tooling(
        front.vertices,
        start.nearest,
        start.direction,
        area,
        int(np.argmin(start.nearest)),
        pivot,
        np.zeros(3),
        pivot,
        2e-5,
        3e-5,
        0.0,
        0.0,
    )
    found = {lever.name: lever for lever in levers(tool)}
    step = 1e-4

    def again(vertices):
        change = nearest_gap(front.vertices, female.moved(vertices)).nearest - start.nearest
        return np.sqrt(np.mean((change / step) ** 2))

    raised = again(female.vertices + np.array([0.0, 0.0, step]))
    assert found["stroke"].rms == pytest.approx(raised, rel=1e-2)
    for name, along in (("first", [1.0, 0.0, 0.0]), ("second", [0.0, 1.0, 0.0])):
        shifted = again(female.vertices + step * np.array(along))
        assert found[f"shift of the female across, {name} axis"].rms == pytest.approx(shifted, rel=1e-2)
        turned = again(female.vertices + step * np.radians(1.0) * np.cross(along, female.vertices - pivot))
        assert found[f"tilt of the female about the {name} axis"].rms == pytest.approx(turned, rel=2e-2)
    warmer = again(female.vertices + step * 1e3 * 3e-5 * (female.vertices - pivot)) / 1e3
    assert found["temperature of the female alone"].rms == pytest.approx(warmer, rel=2e-2)
    change = nearest_gap(front.vertices * (1.0 + 0.1 * 2e-5), female).nearest - start.nearest
    lever = found["temperature of the male alone"]
    assert lever.rms == pytest.approx(np.sqrt(np.mean((change / 0.1) ** 2)), rel=2e-2)
    assert lever.at_closest == pytest.approx(change[np.argmin(start.nearest)] / 0.1, rel=2e-2)
    assert found["foam thickness"].rms == 1.0


def test_a_mounting_face_moves_the_gap_by_the_strain_of_its_mold(shapes):
    """Higher by 1 mm at a strain of 0.2 %: all of the mold stands 2 um nearer to the face it is mounted on."""
    flat = np.array([[0.0, 0.0, -1.0]])
    tool = Tooling(np.zeros((1, 3)), np.ones(1), flat, np.ones(1), 0, *np.zeros((3, 3)), 2e-5, 1e-5, 2e-3, 1e-3)
    found = {lever.name: lever for lever in levers(tool)}
    assert found["height of the male's mounting face"].at_closest == pytest.approx(2e-3)
    assert found["height of the female's mounting face"].at_closest == pytest.approx(-1e-3)
    steps = {(lever.unit, lever.step) for lever in found.values() if "mounting" not in lever.name}
    assert steps == {("mm", 0.1), ("deg", 0.05), ("K", 10.0)}


def test_levers_come_strongest_first(shapes):
    male, female = shapes.nested_caps(10)
    front = molding_front(male, female)
    start = nearest_gap(front.vertices, female)
    area, origin = np.ones(len(front.vertices)), np.zeros(3)
    found = levers(
        Tooling(
            front.vertices,
            start.nearest,
            start.direction,
            area,
            0,
            origin,
            origin,
            origin,
            2e-5,
            2e-5,
            0.0,
            0.0,
        )
    )
    assert [lever.step_rms for lever in found] == sorted((lever.step_rms for lever in found), reverse=True)
