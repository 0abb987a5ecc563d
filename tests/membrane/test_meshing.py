"""Meshes fill their outline, follow the wanted size and are the same every time."""

from __future__ import annotations

import numpy as np
import pytest
from builders import uniform

from hyperfab.membrane.mesh import halved, interpolate, sheet_mesh
from hyperfab.membrane.meshing import Triangles, _joined, graded, triangulate
from hyperfab.membrane.outline import Disc, Square

OUTLINES = [Disc(100.0), Disc(100.0, quarter=True), Square(200.0), Square(200.0, quarter=True)]


def _edges(points, triangles):
    corners = points[triangles]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


@pytest.mark.parametrize("outline", OUTLINES, ids=str)
def test_elements_fill_the_outline(outline):
    mesh = sheet_mesh(outline, triangulate(outline, uniform(12.0)))
    # The rim of a disc is a parabola through three points an edge: fourth order in the edge length.
    assert mesh.copies * mesh.weights.sum() == pytest.approx(outline.area, rel=3e-6)


@pytest.mark.parametrize("outline", OUTLINES, ids=str)
def test_triangles_are_well_shaped(outline):
    found = triangulate(outline, uniform(10.0))
    edges = _edges(found.points, found.triangles)
    a, b, c = (found.points[found.triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    quality = 4 * np.sqrt(3) * area / (edges**2).sum(axis=1)
    assert quality.min() > 0.4
    assert 8.0 < np.median(edges) < 12.0


def test_elements_are_fine_where_asked():
    angle = np.linspace(0, np.pi / 2, 200)
    curve = 30.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    found = triangulate(Disc(100.0, quarter=True), graded(curve, 1.0, 10.0, 0.25))
    edges = _edges(found.points, found.triangles).mean(axis=1)
    middle = np.linalg.norm(found.points[found.triangles].mean(axis=1), axis=1)
    assert np.median(edges[np.abs(middle - 30.0) < 1.0]) == pytest.approx(1.0, rel=0.25)
    assert np.median(edges[middle > 80.0]) > 7.0


def test_same_seed_gives_the_same_mesh_and_another_seed_another():
    outline = Disc(50.0)
    first, again, other = (triangulate(outline, uniform(8.0), seed=seed, jitter=0.1) for seed in (1, 1, 2))
    assert first.points.tobytes() == again.points.tobytes()
    assert first.triangles.tobytes() == again.triangles.tobytes()
    assert first.points.tobytes() != other.points.tobytes()


def test_quadratic_fields_are_interpolated_exactly():
    outline = Square(20.0)
    mesh = sheet_mesh(outline, triangulate(outline, uniform(4.0)))
    x, y = mesh.nodes.T
    values = np.column_stack([1 + 2 * x - y + 0.3 * x * y + x**2 - 0.5 * y**2])
    points = np.random.default_rng(0).uniform(-10, 10, (200, 2))
    px, py = points.T
    exact = 1 + 2 * px - py + 0.3 * px * py + px**2 - 0.5 * py**2
    np.testing.assert_allclose(interpolate(mesh, values, points)[:, 0], exact, atol=1e-11)


def test_halved_triangles_keep_the_outline_and_their_corners():
    outline = Disc(100.0, quarter=True)
    coarse = triangulate(outline, uniform(20.0))
    fine = halved(outline, coarse)
    np.testing.assert_array_equal(fine.points[: len(coarse.points)], coarse.points)
    assert len(fine.triangles) == 4 * len(coarse.triangles)
    mesh, other = sheet_mesh(outline, fine), sheet_mesh(outline, coarse)
    assert abs(mesh.weights.sum() / (np.pi * 2500.0) - 1.0) < 1e-5
    assert np.allclose(np.hypot(*mesh.nodes[mesh.rim].T), 100.0)
    assert len(mesh.rim) == 2 * len(other.rim) - 1
    assert all((mesh.nodes[mesh.symmetric[axis], axis] == 0.0).all() for axis in (0, 1))


def test_points_without_a_triangle_are_dropped():
    """As of two that all but coincide, of which Delaunay's method takes one; points of the rim stay."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.25, 0.25], [0.25, 0.25], [0.3, 0.3]])
    found = Triangles(
        points,
        np.array([[0, 1, 3], [0, 3, 2], [1, 5, 3]]),
        np.array([[0, 1], [1, 2], [2, 0]]),
        np.zeros(3, int),
    )
    joined = _joined(found, 3)
    np.testing.assert_array_equal(joined.points, points[[0, 1, 2, 3, 5]])
    np.testing.assert_array_equal(joined.points[joined.triangles], points[found.triangles])
