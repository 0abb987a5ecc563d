"""The closing force is the rate of the stored energy: on flat and on smooth molds, whatever the law, however coarse."""

import numpy as np
import pytest

from hyperfab.pressing.foam_law import FoamLaw, hyperfoam, linear, plateau, table
from hyperfab.pressing.gap import molding_front, nearest_gap
from hyperfab.pressing.placement import closing_frame, in_frame
from hyperfab.pressing.pose import Pose
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.samples import cup
from hyperfab.surface import Surface

STEP = 1e-6  # mm


def cups(cells, smooth):
    solids = cup.male_cup(cells, cells - 1), cup.female_cup(cells - 2, cells + 1)
    male, female = (Surface(solid.vertices, solid.faces) for solid in solids)
    frame = closing_frame(male, female, "z")
    return in_frame(male, frame, 1, smooth), in_frame(female, frame, -1, smooth)


def sphere_in_cone(shapes, half_angle, smooth):
    """A ball of 40 mm in a cone that opens downward: their nearest and normal directions part company."""
    ball = shapes.male(*shapes.cap(40.0, 85.0, 14), mount=0.0, smooth=smooth)
    points, faces = shapes.cap(1.0, 60.0, 16, twist=0.013)
    away = 90.0 * np.arccos(np.clip(points[:, 2], -1.0, 1.0)) / np.radians(60.0)
    plan = points[:, :2] / np.maximum(np.hypot(*points[:, :2].T), 1e-12)[:, None]
    apex = 40.0 / np.sin(half_angle) + 1.0
    cone = np.column_stack([away[:, None] * plan, apex - away / np.tan(half_angle)])
    return ball, shapes.female(cone, faces, smooth=smooth)


def waves(shapes, smooth):
    """Bumps that bend both ways, so that feet lie in faces, on edges and at corners."""
    sheets = []
    for cells, height in ((17, 0.0), (15, 4.0)):
        points, faces = shapes.plate(80.0, 80.0, cells, cells + 1, height=height)
        points[:, 2] += 3.0 * np.sin(points[:, 0] / 9.0) * np.cos(points[:, 1] / 11.0 + 0.1 * height)
        sheets.append((points, faces))
    return shapes.male(*sheets[0], mount=-20.0, smooth=smooth), shapes.female(
        *sheets[1], mount=30.0, smooth=smooth
    )


def molds(shapes, name, smooth):
    if name == "spheres":
        return shapes.nested_caps(16, smooth=smooth)
    if name == "cups":
        return cups(24, smooth)
    if name == "waves":
        return waves(shapes, smooth)
    return sphere_in_cone(shapes, np.radians(float(name.removeprefix("cone "))), smooth)


LAWS = {
    "linear": linear(0.05),
    "plateau": plateau(4.5e-3, 0.12, 1.6e-3),
    "hyperfoam": hyperfoam([0.018], [17.4], [0.0]),
    "table": table([0.0, 0.1, 0.5, 0.8], [0.0, 3e-3, 6e-3, 0.05]),
}


def rate_and_force(press, opening, turned=0.0):
    """The energy's rate by differences, and the force; a little further on where a nearest facet changes just here."""
    while True:
        low, here, high = (
            press.at(Pose(opening + side * STEP, (turned, -turned), (0.0, 0.0, 60.0)))
            for side in (-1.0, 0.0, 1.0)
        )
        if (low.face == high.face).all():
            return (low.energy - high.energy) / (2.0 * STEP), here.closing_force
        opening += 2.0 * STEP


@pytest.mark.parametrize("smooth", [True, False], ids=["smooth", "facets"])
@pytest.mark.parametrize("name", ["spheres", "cups", "cone 35", "cone 55", "waves"])
def test_the_closing_force_is_the_rate_of_the_energy(shapes, name, smooth):
    male, female = molds(shapes, name, smooth)
    press = Press(molding_front(male, female), female, Sandwich(4.5, 0.0, linear(0.05)))
    touch, metal = press.first_touch(), press.metal_contact()
    for share in (0.13, 0.31, 0.52, 0.77):
        opening = touch + share * (metal - touch)
        for turned in (0.0, 0.004):
            rate, force = rate_and_force(press, opening, turned)
            assert rate == pytest.approx(force, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("soft", [None, linear(0.2)], ids=["rigid fabric", "soft fabric"])
def test_whatever_the_law_and_the_layers(shapes, law, soft):
    male, female = shapes.nested_caps(16)
    kind: FoamLaw = LAWS[law]
    press = Press(molding_front(male, female), female, Sandwich(5.0, 1.0, kind, soft))
    for opening in (1.5, 0.5):
        rate, force = rate_and_force(press, opening)
        assert rate == pytest.approx(force, rel=1e-6)


def test_the_gaps_gradient_is_that_of_the_number_told(shapes):
    """Feet in faces, on edges and at corners of a wavy female, in front of it and within."""
    _, female = waves(shapes, True)
    scatter = np.random.default_rng(3)
    points = female.vertices + scatter.normal(0.0, 4.0, female.vertices.shape)
    near, found = female.surface.nearest(points), nearest_gap(points, female)
    assert set(near.feature) >= {0, 1, 2, 3}
    assert (near.feature >= 4).any()
    assert (near.distance < 0.0).any()
    h = 1e-6
    steps = [nearest_gap(points + h * way, female).nearest - nearest_gap(points - h * way, female).nearest
             for way in np.eye(3)]  # fmt: skip
    off = np.abs(np.stack(steps, axis=1) / (2.0 * h) - found.direction).max(axis=1)
    # One point in a hundred may lie where two facets are equally near.
    assert np.quantile(off, 0.99) < 1e-7


def test_the_work_of_a_closing_is_its_energy():
    """Where a nearest facet changes, the smooth surface behind it is another by thousandths of a millimetre, less on
    finer facets: that is what is left over a whole closing."""
    for cells, smooth, tolerance in ((24, False, 1e-6), (24, True, 5e-5), (48, True, 1e-6)):
        male, female = cups(cells, smooth)
        press = Press(molding_front(male, female), female, Sandwich(4.5, 0.0, linear(0.05)))
        touch = press.first_touch()
        nodes, weights = np.polynomial.legendre.leggauss(8)
        ends = np.linspace(0.0, touch, 17)
        half = 0.5 * np.diff(ends)[:, None]
        strokes = ends[:-1, None] + half * (nodes + 1.0)
        force = [press.at(touch - stroke).closing_force for stroke in strokes.ravel()]
        assert (half * weights).ravel() @ force == pytest.approx(press.at(0.0).energy, rel=tolerance)
