"""Outlines of any shape: corners and smooth pieces, symmetry, crossings, and meshes that fill them."""

from __future__ import annotations

import numpy as np
import pytest
from builders import uniform

from hyperfab.membrane.mesh import sheet_mesh
from hyperfab.membrane.meshing import triangulate
from hyperfab.membrane.outline import Polygon, Square, crossing_sides

SQUARE = np.array([[-100.0, -100], [100, -100], [100, 100], [-100, 100]])
CROSS = np.array(
    [[-60.0, -110], [60, -110], [60, -60], [110, -60], [110, 60], [60, 60],
     [60, 110], [-60, 110], [-60, 60], [-110, 60], [-110, -60], [-60, -60]]
)  # fmt: skip


def _ellipse(a, b, count=200):
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([a * np.cos(angle), b * np.sin(angle)])


def _flower():
    angle = 2 * np.pi * np.arange(300) / 300
    radius = 100 + 15 * np.cos(5 * angle)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


@pytest.mark.parametrize("quarter", [False, True])
def test_a_square_of_points_is_meshed_as_the_square_bit_for_bit(quarter):
    first = triangulate(Polygon(SQUARE, quarter), uniform(15.0))
    other = triangulate(Square(200.0, quarter), uniform(15.0))
    if quarter:
        assert first.points.tobytes() == other.points.tobytes()
        assert first.triangles.tobytes() == other.triangles.tobytes()
    assert sheet_mesh(Polygon(SQUARE, quarter), first).weights.sum() == pytest.approx(4e4 / (4 if quarter else 1))


@pytest.mark.parametrize(
    ("points", "convex", "symmetric", "corners"),
    [
        (SQUARE, True, True, 4),
        (CROSS, False, True, 12),
        (_ellipse(130, 90), True, True, 0),
        (_flower(), False, False, 0),
    ],
    ids=["square", "cross", "ellipse", "flower"],
)
def test_outlines_are_known_and_filled(points, convex, symmetric, corners):
    found = Polygon(points)
    assert (found.convex, found.symmetric, len(found.arcs)) == (convex, symmetric, max(corners, 1))
    mesh = sheet_mesh(found, triangulate(found, uniform(14.0)))
    assert mesh.weights.sum() == pytest.approx(found.area, rel=2e-4)
    middles = np.isin(mesh.rim, np.arange(mesh.corners), invert=True)
    away = np.abs(found._distance(mesh.nodes[mesh.rim[middles]]))
    assert away.max() < 1e-9


def test_a_quarter_of_an_ellipse_is_a_quarter_of_its_area():
    found = Polygon(_ellipse(130, 90), quarter=True)
    mesh = sheet_mesh(found, triangulate(found, uniform(12.0)))
    assert 4 * mesh.weights.sum() == pytest.approx(found.area, rel=2e-4)
    assert mesh.nodes.min() == 0.0


def test_lines_that_cross_are_found_and_others_not():
    assert crossing_sides(CROSS) is None
    assert crossing_sides(_flower()) is None
    assert crossing_sides(SQUARE[[0, 2, 1, 3]]) == (0, 2)
    assert crossing_sides(np.array([[0.0, 0], [4, 0], [2, 0], [2, 3]])) is not None
