"""Nearest point, sign, features, ray and curvature of a triangle surface, against brute force and geometry."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from hyperfab.surface import Surface, consistently_wound, inside_out


def as_surface(mesh: trimesh.Trimesh) -> Surface:
    return Surface(mesh.vertices, mesh.faces)


@pytest.fixture(scope="module")
def ball() -> Surface:
    return as_surface(trimesh.creation.icosphere(subdivisions=4, radius=60.0))


def brute_distance(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Distance to every triangle by minimising over a dense barycentric check of plane, edges and vertices."""
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    best = np.full(len(points), np.inf)
    for i, p in enumerate(points):
        n = np.cross(b - a, c - a)
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        height = ((p - a) * n).sum(1)
        q = p - height[:, None] * n
        inside = np.ones(len(a), bool)
        for s, t in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(t - s, q - s) * n).sum(1) >= 0
            along = np.clip(((p - s) * (t - s)).sum(1) / ((t - s) ** 2).sum(1), 0, 1)
            best[i] = min(best[i], np.linalg.norm(s + along[:, None] * (t - s) - p, axis=1).min())
        if inside.any():
            best[i] = min(best[i], np.abs(height[inside]).min())
    return best


def test_nearest_distance_equals_brute_force_over_all_triangles():
    surface = as_surface(trimesh.creation.torus(40, 12, major_sections=24, minor_sections=12))
    points = np.random.default_rng(1).uniform(-60, 60, (200, 3))
    near = surface.nearest(points)
    assert np.allclose(np.abs(near.distance), brute_distance(surface, points), rtol=0, atol=1e-11)
    assert np.allclose(np.linalg.norm(points - near.point, axis=1), np.abs(near.distance), atol=1e-12)


def test_the_sign_is_right_on_both_sides_of_sharp_edges_and_corners():
    box = as_surface(trimesh.creation.box((2, 2, 2)))
    points = np.random.default_rng(2).uniform(-2, 2, (5000, 3))
    q = np.abs(points) - 1
    exact = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(1), 0)
    assert np.allclose(box.nearest(points).distance, exact, atol=1e-12)


def test_a_hint_never_changes_the_distance(ball):
    points = np.random.default_rng(3).normal(0, 60, (500, 3))
    wrong = np.random.default_rng(4).integers(-1, len(ball.faces), 500)
    assert np.array_equal(np.abs(ball.nearest(points).distance), np.abs(ball.nearest(points, hint=wrong).distance))


def test_features_and_normals_at_the_edge_and_corner_of_a_box():
    box = as_surface(trimesh.creation.box((2, 2, 2)))
    near = box.nearest([[2, 2, 0.3], [3, 3, 3], [0.3, 0.1, 4]])
    assert near.feature[0] in (1, 2, 3)
    assert near.feature[1] >= 4
    assert near.feature[2] == 0
    assert np.allclose(near.normal[0], [np.sqrt(0.5), np.sqrt(0.5), 0.0])
    assert np.allclose(near.normal[1], np.ones(3) / np.sqrt(3))


def test_rays_hit_the_sphere_where_geometry_says(ball):
    rng = np.random.default_rng(5)
    xy = rng.uniform(-40, 40, (300, 2))
    t, face = ball.ray(np.column_stack([xy, np.full(300, 100.0)]), [0, 0, -1.0])
    exact = 100 - np.sqrt(3600 - (xy**2).sum(1))
    assert (face >= 0).all()
    assert np.abs(t - exact).max() < 60 * (1 - np.cos(0.04)) * 3
    assert np.isinf(ball.ray([[0, 0, 100.0]], [0, 0, 1.0])[0][0])


def test_curvature_of_a_sphere_is_one_over_its_radius(ball):
    trace = np.trace(ball.curvature, axis1=1, axis2=2)
    assert trace.mean() == pytest.approx(2 / 60, rel=3e-3)
    assert np.allclose(trace, 2 / 60, rtol=0.06)  # vertices with five facets among those with six tilt normals
    assert (ball.edge_turn > 0).all()


def test_soundness_finds_holes_flips_and_empty_facets(ball):
    assert ball.soundness().sound
    assert ball.soundness().volume_mm3 == pytest.approx(4 / 3 * np.pi * 60**3, rel=5e-3)
    assert Surface(ball.vertices, ball.faces[1:]).soundness().open_edges == 3
    flipped = ball.faces.copy()
    flipped[[7, 400]] = flipped[[7, 400]][:, ::-1]
    found = Surface(ball.vertices, flipped).soundness()
    assert found.flipped_edges == 6
    assert {7, 400} <= set(found.flipped_facets)
    mended, turned = consistently_wound(flipped)
    assert list(turned) == [7, 400]
    assert np.array_equal(mended, ball.faces)
    doubled = Surface(ball.vertices, np.vstack([ball.faces, ball.faces[:1]])).soundness()
    assert list(doubled.duplicate_facets) == [len(ball.faces)]
    empty = Surface(ball.vertices, np.vstack([ball.faces, [[0, 0, 1]]])).soundness()
    assert list(empty.degenerate_facets) == [len(ball.faces)]


def test_pieces_that_face_inward_are_found_and_hollows_left(ball):
    """A ball of 60 mm, one beside it, a hollow in the first, a grain in that: what faces inward by right stays."""
    count, points = len(ball.faces), len(ball.vertices)
    vertices = np.vstack(
        [ball.vertices, ball.vertices + np.array([200.0, 3.0, 1.0]), 0.5 * ball.vertices, 0.2 * ball.vertices]
    )
    out, inward = ball.faces, ball.faces[:, ::-1]
    pieces = [out, inward + points, inward + 2 * points, out + 3 * points]
    assert inside_out(vertices, np.vstack(pieces)).tolist() == list(range(count, 2 * count))
    assert not len(inside_out(vertices, np.vstack([out, out + points, *pieces[2:]])))
    assert not len(inside_out(ball.vertices, out))
