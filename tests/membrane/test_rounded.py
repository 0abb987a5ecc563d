"""Sharp edges of a punch that are rounded: what a ball inside it can reach, and a flat plunger by shooting."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from hyperfab.materials import bind
from hyperfab.membrane import outline
from hyperfab.membrane.punch import Facets
from hyperfab.membrane.sphere_contact import SphereTest, run
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.surface import Surface

RADIUS = 3.0


def _facets(mesh, radius=RADIUS):
    low, high = mesh.bounds
    return Facets(
        Surface(mesh.vertices, mesh.faces), -np.array([*(0.5 * (low[:2] + high[:2])), high[2]]), edge_radius=radius
    )


def test_a_box_is_all_balls_that_have_room_in_it():
    box = _facets(trimesh.creation.box(extents=(60.0, 50.0, 40.0)))
    points = np.random.default_rng(0).uniform([-36.0, -31.0, -6.0], [36.0, 31.0, 6.0], (2000, 3))
    inner = np.array([30.0, 25.0, 20.0]) - RADIUS
    centred = points + np.array([0.0, 0.0, 20.0])
    exact = np.linalg.norm(np.maximum(np.abs(centred) - inner, 0.0), axis=1) - RADIUS
    seen = box.near(points, 0.0)
    near = exact > -RADIUS + 1e-9  # deeper inside, the nearest face is as good
    assert near.sum() > 1000
    np.testing.assert_allclose(seen.gap[near & (seen.gap < RADIUS)], exact[near & (seen.gap < RADIUS)], atol=1e-9)
    # The normal is the gap's slope, and how it turns is the normal's.
    at = np.array([[29.0, 3.0, 0.5], [29.5, 24.5, 0.4], [29.0, 24.0, -8.0]])
    seen, step = box.near(at, 0.0), 1e-5
    for axis in range(3):
        moved = [box.near(at + sign * step * np.eye(3)[axis], 0.0) for sign in (1.0, -1.0)]
        np.testing.assert_allclose((moved[0].gap - moved[1].gap) / (2 * step), seen.normal[:, axis], atol=1e-6)
        np.testing.assert_allclose(
            (moved[0].normal - moved[1].normal) / (2 * step), seen.turning[:, :, axis], atol=1e-5
        )


def test_edges_that_go_inward_and_round_sides_stay_as_they_are():
    cylinder = trimesh.creation.cylinder(radius=30.0, height=40.0, sections=64)
    assert _facets(cylinder, 0.0).sharp.any()
    assert not _facets(cylinder).sharp.any()
    aside = np.array([[30.5, 0.0, -20.0], [3.0, 4.0, 0.2]])
    np.testing.assert_array_equal(_facets(cylinder).near(aside, 0.0).gap, _facets(cylinder, 0.0).near(aside, 0.0).gap)
    ell = [[0, 0, 0], [40, 0, 0], [40, 0, 20], [20, 0, 20], [20, 0, 40], [0, 0, 40]]
    front, back = np.array(ell, float), np.array([0.0, 60.0, 0.0])
    vertices = np.concatenate([front, front + back])
    caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    sides = [side for k in range(6) for side in ([k, k + 6, (k + 1) % 6], [(k + 1) % 6, k + 6, (k + 1) % 6 + 6])]
    mesh = trimesh.Trimesh(vertices, [*caps, *([c + 6, b + 6, a + 6] for a, b, c in caps), *sides])
    assert mesh.is_watertight
    mesh.fix_normals()
    corner = np.array([[1.0, 0.0, -19.0]])  # beside the edge between the step and the upright above it
    np.testing.assert_array_equal(_facets(mesh).near(corner, 0.0).gap, _facets(mesh, 0.0).near(corner, 0.0).gap)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "depth", "force"),
    [(6.0, 20.0, 1.9955175), (3.0, 20.0, 2.2123645), (2.5, 50.0, 20.8175794)],  # by shooting, of a round plunger
)
def test_a_flat_plunger_with_a_rounded_rim_is_met_to_its_facets(radius, depth, force):
    plunger = _facets(trimesh.creation.cylinder(radius=30.0, height=60.0, sections=64), radius)
    law = IsotropicSheet(bind("neo-hookean", {"C10_MPa": 0.1}))
    test = SphereTest(outline.Disc(100.0, quarter=True), law, 1.0, 30.0, facets=plunger)
    [outcome] = run([test], [0.5 * depth, depth], 1e-3)
    # Its 64 sides are in the mean 0.08 % nearer to the axis.
    assert outcome.solved[-1].state.force == pytest.approx(force, rel=2e-3)
