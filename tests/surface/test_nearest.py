"""Every nearest point is the nearest: on molds with bosses, pits, folds and bumps, by trying every facet."""

import numpy as np
import pytest
from rough_molds import KINDS, brute, cups, displaced, rough_cup, rough_sheet, split, worst

from hyperfab.numerics.threads import LIMIT
from hyperfab.samples.cup import female_cup, male_cup, male_point
from hyperfab.surface import Surface
from hyperfab.surface.curve import along_a_curve

#: Rounding of distances between coordinates of some 100 mm is 1e-13.
CLOSE = 1e-9


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_no_facet_is_nearer_on_a_rough_sheet(kind, seed):
    assert worst(*rough_sheet(np.random.default_rng(seed), kind)) < CLOSE


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_no_facet_is_nearer_on_a_cup_with_a_boss_or_pit(seed):
    points, vertices, faces = rough_cup(np.random.default_rng(seed))
    assert worst(points, vertices, faces) < CLOSE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200))
def test_no_facet_is_nearer_on_any_cup_with_a_boss_or_pit(seed):
    assert worst(*rough_cup(np.random.default_rng(1000 + seed))) < CLOSE


@pytest.mark.parametrize("times", [0, 1, 2])
def test_the_same_surface_in_more_facets_has_the_same_gaps(times):
    (points, _), (vertices, faces) = cups()
    coarse = Surface(vertices, faces).nearest(points).distance
    for _ in range(times):
        vertices, faces = split(vertices, faces)
    surface = Surface(vertices, faces)
    assert surface.nearest(points).distance == pytest.approx(coarse, abs=CLOSE)
    some = points[:: 20 * 4**times]
    assert np.abs(surface.nearest(some).distance) == pytest.approx(brute(some, vertices[faces]), abs=CLOSE)


@pytest.mark.slow
@pytest.mark.parametrize("times", [0, 1, 2])
def test_no_facet_is_nearer_on_the_split_cups(times):
    (points, _), (vertices, faces) = cups()
    for _ in range(times):
        vertices, faces = split(vertices, faces)
    assert worst(points, vertices, faces) < CLOSE


def test_no_facet_is_nearer_where_two_narrow_bosses_stand_close():
    (points, _), (vertices, faces) = cups(120)
    for place, height, width in (((-13.0, -67.0, 15.0), 2.9, 1.25), ((79.0, -36.0, 6.0), -3.3, 1.5)):
        centre = vertices[((vertices - place) ** 2).sum(axis=1).argmin()]
        vertices = displaced(vertices, faces, centre, height, width)
        near = points[((points - place) ** 2).sum(axis=1) < 15.0**2]
        assert worst(near, vertices, faces) < CLOSE


def test_a_far_sheet_under_the_normal_is_not_taken_for_the_near_one_behind():
    sheet = np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    vertices = np.concatenate([sheet + np.array([0.0, 0.0, 5.0]), sheet - np.array([0.0, 0.0, 1.0])])
    surface = Surface(vertices, np.concatenate([faces[:, ::-1], faces + 4]))
    points = np.array([[x, 0.5, 0.0] for x in np.linspace(-3, 3, 50)])
    assert np.abs(surface.nearest(points).distance) == pytest.approx(1.0)


def test_coordinates_far_from_zero_cost_rounding_alone():
    points, vertices, faces = rough_sheet(np.random.default_rng(5), "bumpy")
    far = np.array([4e4, -7e4, 1e5])
    exact = brute(points, vertices[faces])
    assert np.abs(Surface(vertices + far, faces).nearest(points + far).distance) == pytest.approx(exact, abs=1e-9)


@pytest.fixture(scope="module")
def pair():
    """Points of a male with its normals, and the female above."""
    solid, above = male_cup(60, 56), female_cup(57, 61)
    points = solid.vertices[: 65 * 61]
    x, y, z = points.T
    _, normals = male_point((x - 0.12 * z) / 90.0, y / 80.0)
    return points, normals, Surface(above.vertices, above.faces)


def told(near):
    return near.distance, near.point, near.normal, near.face, near.feature


def same(one, two):
    return all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))


def test_neither_order_nor_hints_change_a_bit(pair):
    points, _, surface = pair
    rng = np.random.default_rng(2)
    mixed = rng.permutation(len(points))
    plain = told(surface.nearest(points))
    assert same([part[mixed] for part in plain], told(surface.nearest(points[mixed])))
    assert same(plain, told(surface.nearest(points, order=mixed)))
    assert same(plain, told(surface.nearest(points, hint=rng.integers(-1, len(surface.faces), len(points)))))


def test_threads_change_no_bit(pair, monkeypatch):
    _, _, surface = pair
    points = np.random.default_rng(4).normal(0.0, 60.0, (30_000, 3))
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    found = []
    for number in "123":
        monkeypatch.setenv(LIMIT, number)
        found.append([*told(surface.nearest(points)), *surface.ray(points, directions)])
    assert same(found[0], found[1])
    assert same(found[0], found[2])


def test_facets_in_another_order_give_the_same_distances(pair):
    points, _, surface = pair
    mixed = Surface(surface.vertices, np.random.default_rng(3).permutation(surface.faces))
    assert np.array_equal(mixed.nearest(points).distance, surface.nearest(points).distance)


def test_rays_along_normals_end_on_the_front_from_either_side(pair):
    points, normals, surface = pair
    ahead, face = surface.along(points, normals)
    assert (face >= 0).all()
    # The female stands 3 to 6 mm off along the male's normal; its facets of 4 mm leave 0.1 mm at the rim's bend.
    assert 2.9 < ahead.min() < ahead.max() < 6.1
    behind, hit = surface.along(points + 8.0 * normals, normals)
    seen = (hit >= 0) & (behind < 0.0)
    assert seen.mean() > 0.9
    assert behind[seen] == pytest.approx(ahead[seen] - 8.0, abs=1e-9)


def test_the_curve_visits_every_point_once_and_takes_short_steps():
    points = np.random.default_rng(1).uniform(0.0, 1.0, (20_000, 3))
    order = along_a_curve(points)
    assert np.array_equal(np.sort(order), np.arange(len(points)))
    step = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    # Mean spacing of the points is 0.037; a step between points at random would be 0.66.
    assert step.mean() < 0.05
    assert along_a_curve(points[:0]).tolist() == []
    assert along_a_curve(np.ones((3, 3))).tolist() == [0, 1, 2]
