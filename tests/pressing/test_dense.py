"""Large facets are cut, and their new corners are on the mold."""

import numpy as np
import pytest

from hyperfab.pressing.curved import Curving, creases, curving
from hyperfab.pressing.dense import bent, dense
from hyperfab.pressing.gap import molding_front, nearest_gap
from hyperfab.pressing.mold import mold
from hyperfab.samples import cup
from hyperfab.surface import Surface

UP = np.array([0.0, 0.0, 1.0])


def grid(x, y, z):
    """Facets of z (n, m) over x (n,) and y (m,), looking up."""
    n, m = z.shape
    points = np.stack([np.repeat(x, m), np.tile(y, n), z.ravel()], axis=1)
    a = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + m, a + m + 1], axis=1), np.stack([a, a + m + 1, a + 1], axis=1)])
    return Surface(points, faces)


def test_new_corners_are_on_the_sphere_that_large_facets_stand_for() -> None:
    radius, height, around = 100.0, np.radians(np.linspace(10.0, 50.0, 5)), np.radians(np.linspace(0.0, 360.0, 17))[:-1]
    points = [[0.0, 0.0, radius]]
    points += [
        [radius * np.sin(t) * np.cos(p), radius * np.sin(t) * np.sin(p), radius * np.cos(t)]
        for t in height
        for p in around
    ]
    faces = [[0, 1 + k, 1 + (k + 1) % 16] for k in range(16)]
    for ring in range(4):
        for k in range(16):
            a, b = 1 + 16 * ring + k, 1 + 16 * ring + (k + 1) % 16
            faces += [[a, a + 16, b + 16], [a, b + 16, b]]
    sphere = Surface(np.array(points), np.array(faces))
    fine, _ = dense(sphere, UP, sphere)
    assert len(fine.faces) > 4 * len(faces)
    assert fine.areas.max() < sphere.areas.max() / 4.0
    off = np.abs(np.linalg.norm(fine.vertices, axis=1) - radius)
    inner = np.linalg.norm(fine.vertices[:, :2], axis=1) < radius * np.sin(
        np.radians(39.0)
    )  # beside the border: of one side
    assert off[inner].max() < 0.02  # chords: 1.1


def test_strips_of_a_cylinder_are_cut_along_and_across() -> None:
    turn, x = np.radians(np.linspace(-40.0, 40.0, 9)), np.array([-100.0, 100.0])
    cylinder = grid(80.0 * np.sin(turn), x, np.repeat(80.0 * np.cos(turn)[:, None], 2, axis=1))
    fine, _ = dense(cylinder, UP, cylinder)
    inner = np.abs(fine.vertices[:, 0]) < 80.0 * np.sin(np.radians(29.0))
    assert np.abs(np.hypot(fine.vertices[:, 0], fine.vertices[:, 2]) - 80.0)[inner].max() < 1e-3  # chords: 0.3
    assert len(np.unique(fine.vertices[:, 1].round(6))) >= 21


@pytest.mark.parametrize("cells", [(8, 9), (16, 15), (20, 21)])
def test_a_flat_rim_is_found_as_it_was_drawn(cells) -> None:
    """Facets that are cut where the blend begins bulge a little below it."""
    one, two = cup.male_cup(*cells), cup.female_cup(*cells[::-1])
    male, female = Surface(one.vertices, one.faces), Surface(two.vertices, two.faces)
    fine, drawn = dense(male, UP, female)
    assert drawn is not None
    fronts = [
        molding_front(mold(surface.vertices, surface.faces, 1, drawn=parts), mold(two.vertices, two.faces, -1))
        for surface, parts in ((male, None), (fine, drawn))
    ]
    areas = [front.areas[front.flange].sum() for front in fronts]
    assert areas[0] > 2e4
    assert areas[1] == pytest.approx(areas[0], rel=5e-3)


@pytest.mark.parametrize("is_cut", [False, True])
def test_strips_between_end_faces_curve_up_to_their_creases(is_cut) -> None:
    """A tunnel in a block, as CAD writes it: strips from end to end, each corner on a crease."""
    turn = np.radians(np.linspace(20.0, 160.0, 21))
    arc = 66.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    outline = np.concatenate([arc, np.stack([arc[::-1, 0], np.full(21, 90.0)], axis=1)])
    n, k = len(outline), np.arange(len(outline))
    after = (k + 1) % n
    points = np.concatenate([np.insert(outline, 1, y, axis=1) for y in (-100.0, 100.0)])
    sides = np.concatenate([np.stack([k, after, after + n], axis=1), np.stack([k, after + n, k + n], axis=1)])
    low, high = np.arange(20), n - 1 - np.arange(20)
    front = np.concatenate([np.stack([low + 1, low, high], axis=1), np.stack([low + 1, high, high - 1], axis=1)])
    block = Surface(points, np.concatenate([sides, front, front[:, ::-1] + n]))
    assert block.soundness().closed
    fine, drawn = dense(block, -UP, block) if is_cut else (block, None)
    tunnel = mold(fine.vertices, fine.faces, -1, drawn=drawn)
    random = np.random.default_rng(0)
    at, along = np.radians(random.uniform(-60.0, 60.0, 500)), random.uniform(-90.0, 90.0, 500)
    gap = nearest_gap(np.stack([60.0 * np.sin(at), along, 60.0 * np.cos(at)], axis=1), tunnel).nearest
    assert np.abs(gap - 6.0).max() < 1e-3  # chords: 0.12


RINGS = (15.0, 25.0, 40.0, 55.0)


def cone(degrees, sides):
    """A flat ring of some ``sides`` around a cone around a level, its two rings 40 and 25 mm wide."""
    turn = np.radians(np.linspace(0.0, 360.0, sides + 1)[:-1])
    rise = np.tan(np.radians(degrees))
    rings = [(r * np.cos(turn), r * np.sin(turn), np.full(sides, rise * np.clip(40.0 - r, 0.0, 15.0))) for r in RINGS]
    points = np.concatenate([np.stack(ring, axis=1) for ring in rings])
    a = np.arange(3 * sides)
    b = a // sides * sides + (a + 1) % sides
    faces = [np.stack([a, a + sides, b + sides], axis=1), np.stack([a, b + sides, b], axis=1)]
    return Surface(points, np.concatenate(faces))


@pytest.mark.parametrize(("degrees", "sides"), [(25.2, 12), (25.6, 12), (25.6, 24), (30.0, 16)])
def test_parts_of_facets_have_the_creases_of_the_facets_that_were_cut(degrees, sides) -> None:
    """New corners on the ring lie outside of its chords: beside some of them the parts turn by less than 25 degrees."""
    drawing = cone(degrees, sides)
    fine, drawn = dense(drawing, UP, drawing)
    assert drawn is not None
    curve = curving(fine, True, drawn)
    face, edge = np.nonzero(fine.twins >= 0)
    other = fine.twins[face, edge]
    back = np.argmax(fine.faces[other] == fine.faces[face, (edge + 1) % 3][:, None], axis=1)
    # Each side has normals of its own all along it, and both curve up to one curve.
    own, across = curve.normals[face, edge], curve.normals[other, (back + 1) % 3]
    found = np.abs(own - across).max(axis=1) > 1e-6
    ends = fine.vertices[fine.faces[face, edge]], fine.vertices[fine.faces[face, (edge + 1) % 3]]
    assert np.linalg.norm(ends[1] - ends[0], axis=1)[found].sum() == pytest.approx(
        4.0 * np.pi * (25.0 + 40.0), rel=1e-3
    )
    assert curve.bulge[face, edge] == pytest.approx(curve.bulge[other, back], abs=1e-12)
    assert curve.skew[face, edge] == pytest.approx(-curve.skew[other, back], abs=1e-12)


@pytest.mark.parametrize(
    ("cells", "worst", "rms"), [(12, 0.95, 0.2), (16, 0.55, 0.105), (20, 0.36, 0.056), (30, 0.16, 0.0175)]
)
def test_a_blend_in_few_facets_is_no_crease(cells, worst, rms) -> None:
    """The foot of the cup turns by 25 to 50 degrees from facet to facet, here a little more and there a little less."""
    solid = cup.female_cup(cells + 1, cells)
    female = mold(solid.vertices, solid.faces, -1)
    foot = (np.abs(female.surface.edge_turn) > np.radians(25.0)) & female.looking[:, None]
    foot &= (np.abs(female.surface.edge_turn) < np.radians(80.0)) & (female.surface.twins >= 0)
    assert foot.any()
    assert not creases(female.surface)[foot].any()
    u, v = np.random.default_rng(1).uniform(-1.05, 1.05, (2, 4000))
    points, normals = cup.male_point(u, v)
    off = nearest_gap(points + cup.normal_gap(u, v)[:, None] * normals, female).nearest
    # Taken for creases, edges of the foot made these 1.70, 0.91, 0.42, 0.18 and 0.245, 0.137, 0.073, 0.021 mm.
    assert np.abs(off).max() < worst
    assert np.sqrt(np.mean(off**2)) < rms


@pytest.mark.parametrize("degrees", [26.0, 30.0, 44.0])
def test_an_edge_that_goes_on_is_a_crease(degrees) -> None:
    """A ramp from border to border, and the two rings of a cone."""
    x, y = np.array([-40.0, -20, -10, 0, 10, 20, 40]), np.linspace(-40.0, 40.0, 9)
    rise = np.tan(np.radians(degrees))
    ramp = grid(x, y, np.repeat(rise * np.clip(x, -10.0, 10.0)[:, None], len(y), axis=1))
    assert creases(ramp).sum() == 2 * 2 * (len(y) - 1)
    assert creases(cone(degrees, 48)).sum() == 2 * 2 * 48


def test_a_facet_that_is_folded_is_cut_no_further_than_shows() -> None:
    """Normals 150 degrees apart at its corners: beside the fold they turn by as much however small the parts are."""
    folded = np.radians(150.0)
    normals = np.array([[[0.0, 0.0, 1.0], [np.sin(folded), 0.0, np.cos(folded)], [0.0, 0.0, 1.0]]])
    one = Curving(Surface(np.eye(3), np.array([[0, 1, 2]])), normals, np.zeros((1, 3, 3)), np.zeros((1, 3, 3)))
    assert 4 < len(bent(one, np.radians(12.0), 0.03)[0].faces) < 1000
