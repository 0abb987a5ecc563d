"""Walks end where the exact tree says, for points close above a surface and in any order."""

import numpy as np
import pytest

from hyperfab.pressing.search import Search
from hyperfab.samples.cup import female_cup, male_cup, male_point
from hyperfab.surface import Surface
from hyperfab.surface.walk import Walker


@pytest.fixture(scope="module")
def pair():
    solid, above = male_cup(60, 56), female_cup(57, 61)
    points = solid.vertices[: 65 * 61]
    x, y, z = points.T
    _, normals = male_point((x - 0.12 * z) / 90.0, y / 80.0)
    return points, normals, Surface(above.vertices, above.faces)


def test_nearest_points_and_hits_are_those_of_the_tree(pair):
    points, normals, surface = pair
    found = Walker(surface.vertices, surface.faces).nearest(points, normals)
    exact = surface.nearest(points)
    seen = found.hit >= 0
    assert seen.mean() > 0.99
    assert np.abs(np.sqrt(found.distance2[seen]) - np.abs(exact.distance[seen])).max() < 1e-9
    t, _ = surface.ray(points, normals)
    assert np.abs(found.along[seen] - t[seen]).max() < 1e-9


def test_the_order_of_points_and_facets_does_not_matter(pair):
    points, normals, surface = pair
    mixed = np.random.default_rng(2).permutation(len(points))
    walker = Walker(surface.vertices, np.random.default_rng(3).permutation(surface.faces))
    plain = Walker(surface.vertices, surface.faces).nearest(points, normals)
    found = walker.nearest(points[mixed], normals[mixed])
    assert found.distance2 == pytest.approx(plain.distance2[mixed], abs=1e-9)


def test_twins_are_the_neighbours_across_the_edges(pair):
    _, _, surface = pair
    assert np.array_equal(Walker(surface.vertices, surface.faces).twins, surface.twins)


def test_lost_walks_are_mended_by_the_tree(pair):
    points, normals, surface = pair
    search = Search(surface)
    away = normals.copy()
    away[::10] = -away[::10]
    found = search.nearest(points, away)
    assert found.distance == pytest.approx(surface.nearest(points).distance, abs=1e-9)
    assert search.mended > 0
    assert not search.distrusted


def test_a_walk_into_a_local_answer_hands_the_work_to_the_tree():
    """Two sheets: the walk along the given direction ends on the far one, the near one lies behind the point."""
    sheet = np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    vertices = np.concatenate([sheet + np.array([0.0, 0.0, 5.0]), sheet - np.array([0.0, 0.0, 1.0])])
    surface = Surface(vertices, np.concatenate([faces[:, ::-1], faces + 4]))
    search = Search(surface)
    points = np.array([[x, 0.5, 0.0] for x in np.linspace(-3, 3, 50)])
    found = search.nearest(points, np.tile([0.0, 0.0, 1.0], (50, 1)))
    assert np.abs(found.distance) == pytest.approx(1.0)
    assert search.distrusted


def test_sides_follow_the_normal_of_the_nearest_feature(pair):
    points, normals, surface = pair
    search = Search(surface)
    inside = points + 8.0 * normals
    found = search.nearest(inside, normals)
    assert found.distance == pytest.approx(surface.nearest(inside).distance, abs=1e-9)
    along, hit = search.along(inside, normals)
    assert (along[hit >= 0] < 0.0).mean() > 0.9
