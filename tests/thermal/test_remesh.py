"""STL surfaces of many facets: few curved ones in their place, near the surface that was given."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.thermal import elements
from hyperfab.thermal.geometry import Body, Box, Cylinder, Geometry, Stl
from hyperfab.thermal.mesh import build_mesh
from hyperfab.thermal.mesher import make_mesh
from hyperfab.thermal.remesh import as_given, laid_back, remesh_surface

RADIUS = 30.0


@pytest.fixture(scope="module")
def ball():
    """A ball of 20 480 facets, and the coarser surface for tetrahedra of 8 mm."""
    import trimesh

    sphere = trimesh.creation.icosphere(5, radius=RADIUS)
    fine = Stl(np.asarray(sphere.vertices), np.asarray(sphere.faces, dtype=np.int64))
    found = remesh_surface(fine, 8.0, 0.05)
    assert found is not None
    return fine, found


def volume(geometry, size):
    raw = laid_back(make_mesh(geometry, size), geometry)
    mesh = build_mesh(raw.points / 1e3, raw.elements, raw.parts, raw.surface, raw.surface_face)
    return mesh, elements.metric(mesh.points[mesh.elements]).volume.sum() * 1e9


def test_few_curved_facets_keep_near_the_many(ball):
    fine, found = ball
    assert len(found.surface.triangles) < 2000
    assert found.surface.fine is fine
    # Facets of 8 mm lie 8^2 / (8 R) = 0.27 mm deep where they are flat.
    assert 0.0 < found.deviation <= 0.05


def test_a_part_keeps_the_volume_of_its_stl(ball):
    fine, found = ball
    corners = fine.vertices[fine.triangles]
    exact = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    mesh, curved = volume(Geometry((Body("ball", (found.surface,)),)), 8.0)
    assert curved == pytest.approx(exact, rel=2e-4)  # flat facets of 8 mm lose 1 %
    outer = np.unique(mesh.facet_nodes(mesh.facets.outer))
    radius = np.linalg.norm(mesh.points[outer], axis=1) * 1e3
    np.testing.assert_allclose(radius, RADIUS, atol=0.01)  # the sagitta of the given facets


def test_parts_hold_what_the_given_surfaces_hold():
    """A ball of twenty facets that stands for one of a thousand, with such a hole, beside a box."""
    import trimesh

    def rough(radius):
        balls = [trimesh.creation.icosphere(n, radius=radius) for n in (0, 3)]
        coarse, fine = (Stl(np.asarray(one.vertices), np.asarray(one.faces, dtype=np.int64)) for one in balls)
        return Stl(coarse.vertices, coarse.triangles, fine=fine), *(one.volume for one in balls)

    (ball, flat, round_), (hole, flat_hole, round_hole) = rough(30.0), rough(10.0)
    box = Body("box", (Box((100.0, 0.0, 0.0), (10.0, 10.0, 10.0)),))
    geometry = Geometry((box, Body("ball", (ball,))), (Body("hole", (hole,)),))
    found = as_given(np.array([1000.0, flat - flat_hole]), geometry)
    np.testing.assert_allclose(found, [1000.0, round_ - round_hole], rtol=1e-12)


@pytest.mark.slow
def test_cavities_and_neighbours_stay_where_they_are(ball):
    hole = Cylinder((0.0, 0.0, -40.0), "z", 80.0, (8.0, 8.0))
    geometry = Geometry((Body("ball", (ball[1].surface,)),), (Body("hole", (hole,)),))
    mesh, found = volume(geometry, 8.0)
    napkin_ring = 4 / 3 * np.pi * (RADIUS**2 - 8.0**2) ** 1.5
    assert found == pytest.approx(napkin_ring, rel=2e-3)
    nodes = np.unique(mesh.facet_nodes(mesh.facets.outer))
    at = mesh.points[nodes] * 1e3
    wall = np.abs(np.linalg.norm(at[:, :2], axis=1) - 8.0)
    shell = np.abs(np.linalg.norm(at, axis=1) - RADIUS)
    assert np.minimum(wall, shell).max() < 0.4  # only where both meet is the coarser surface kept
    split = Geometry((Body("ball", (ball[1].surface,)),), (Body("half", (Box((-40, -40, -40), (80, 80, 40)),)),))
    assert volume(split, 8.0)[1] == pytest.approx(2 / 3 * np.pi * RADIUS**3, rel=2e-3)
