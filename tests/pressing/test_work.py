"""The closing force is the rate of the stored energy: on flat and on smooth molds, whatever the law, however coarse."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from hyperfab.pressing.foam_law import FoamLaw, hyperfoam, linear, plateau, table
from hyperfab.pressing.gap import molding_front, nearest_gap
from hyperfab.pressing.mold import Pose
from hyperfab.pressing.placement import closing_frame, in_frame
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
    return shapes.male(*sheets[0], mount=-20.0, smooth=smooth), shapes.female(*sheets[1], mount=30.0, smooth=smooth)


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
            press.at(Pose(opening + side * STEP, (turned, -turned), (0.0, 0.0, 60.0))) for side in (-1.0, 0.0, 1.0)
        )
        if (low.face == high.face).all():
            return (low.energy - high.energy) / (2.0 * STEP), here.closing_force
        opening += 2.0 * STEP


@pytest.mark.parametrize("smooth", [True, False], ids=["smooth", "facets"])
@pytest.mark.parametrize("name", ["spheres", "cups", "cone 35", "cone 55", "waves"])
def test_the_closing_force_is_the_rate_of_the_energy(shapes, name, smooth):
    male, female = molds(shapes, name, smooth)
    press = Press(molding_front(male, female), female, Sandwich(4.5, 0.0, linear(0.05)))
    touch, metal = press.first_touch, press.metal_contact
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


@pytest.mark.parametrize("name", ["spheres", "cups", "cone 55", "waves"])
def test_no_nearest_gap_jumps(shapes, name):
    """A distance changes by no more than the way, also where the nearest facet and the curve behind it change."""
    male, female = molds(shapes, name, True)
    front = molding_front(male, female)
    press = Press(front, female, Sandwich(4.5, 0.0, linear(0.05)))
    touch, metal = press.first_touch, press.metal_contact
    openings = np.linspace(touch, metal, 400)
    found = [press.gap(Pose(opening)) for opening in openings]
    step = openings[0] - openings[1]
    changed = np.stack([one.face for one in found[1:]]) != np.stack([one.face for one in found[:-1]])
    rise = np.diff(np.stack([one.nearest for one in found]), axis=0)
    assert changed.sum() > 100
    assert np.abs(rise).max() <= step + 1e-12
    lengths = np.linalg.norm(found[0].direction, axis=1)
    assert lengths == pytest.approx(1.0, abs=1e-12)


def test_the_gap_is_the_distance_of_the_smooth_surface_that_is_told(shapes):
    """No place of the patches is nearer, and the foot that is told lies on them: both by places taken closely."""
    _, female = waves(shapes, True)
    scatter = np.random.default_rng(5)
    inner = np.abs(female.vertices[:, :2]).max(axis=1) < 25.0
    points = female.vertices[inner] + scatter.normal(0.0, 1.0, (int(inner.sum()), 3)) - [0.0, 0.0, 1.5]
    found = nearest_gap(points, female)
    ticks = np.linspace(0.0, 1.0, 31)
    u, v = (one.ravel() for one in np.meshgrid(ticks, ticks))
    w = np.stack([1.0 - u - v, u, v], axis=1)[u + v <= 1.0 + 1e-12]
    bend, lean = w * np.roll(w, -1, axis=1), w - np.roll(w, -1, axis=1)
    corners, curving = female.vertices[female.faces], female.curving
    patches = np.einsum("wk,fkc->fwc", w, corners) + np.einsum("we,fec->fwc", bend, curving.bulge)
    patches += np.einsum("we,fec->fwc", bend * lean, curving.skew)
    near, _ = cKDTree(patches.reshape(-1, 3)).query(points)
    assert (near - np.abs(found.nearest)).min() > -1e-9
    # Some place lies within 0.2 mm of the foot, whose distance stands upright on the way there.
    assert (near - np.sqrt(found.nearest**2 + 0.2**2)).max() < 0.0


@pytest.mark.parametrize(
    ("cells", "smooth"),
    [(24, False), (24, True), *(pytest.param(cells, True, marks=pytest.mark.slow) for cells in (48, 68))],
)
def test_the_work_of_a_closing_is_its_energy(cells, smooth):
    male, female = cups(cells, smooth)
    press = Press(molding_front(male, female), female, Sandwich(4.5, 0.0, linear(0.05)))
    touch = press.first_touch
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ends = np.linspace(0.0, touch, 33)
    half = 0.5 * np.diff(ends)[:, None]
    strokes = ends[:-1, None] + half * (nodes + 1.0)
    force = [press.at(touch - stroke).closing_force for stroke in strokes.ravel()]
    assert (half * weights).ravel() @ force == pytest.approx(press.at(0.0).energy, rel=1e-6)
