"""Growth of hot molds by finite elements against the closed solutions of thermoelasticity."""

import numpy as np
import pytest

from hyperfab.pressing import thermoelastic
from hyperfab.pressing.tetra import EDGES, TetraMesh, at_boundary, boundary, merged, samples
from hyperfab.pressing.thermoelastic import deform, mounting

ALPHA = 23.6e-6


def box(cells, sides=(80.0, 60.0, 40.0), origin=(-40.0, -30.0, -40.0)):
    """A box of tetrahedra, each cell cut into six, with nodes in the middle of the edges."""
    lines = [np.linspace(0.0, side, n + 1) + o for side, n, o in zip(sides, cells, origin, strict=True)]
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([n + 1 for n in cells])
    tets = []
    for path in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        corner, corners = np.zeros(3, dtype=int), []
        for step in (None, *path):
            if step is not None:
                corner = corner + np.eye(3, dtype=int)[step]
            block = tuple(slice(c, n + c) for c, n in zip(corner, cells, strict=True))
            corners.append(number[block].ravel())
        odd = path in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        tets.append(np.stack(corners if not odd else [corners[1], corners[0], *corners[2:]], axis=1))
    tets = np.concatenate(tets)
    ends = np.sort(np.stack([tets[:, list(edge)] for edge in EDGES], axis=1), axis=2)
    key, inverse = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    middles = points[key].mean(axis=1)
    elements = np.concatenate([tets, len(points) + inverse.reshape(-1, 6)], axis=1)
    return TetraMesh(np.concatenate([points, middles]), elements)


@pytest.fixture(scope="module")
def mesh():
    return box((5, 4, 3))


def test_volume_and_outer_faces(mesh):
    volume = samples(mesh, slice(None)).volume.sum()
    assert volume == pytest.approx(80.0 * 60.0 * 40.0, rel=1e-12)
    faces = boundary(mesh)
    a, b, c = (mesh.points[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    assert 0.5 * np.linalg.norm(normals, axis=1).sum() == pytest.approx(2 * (80 * 60 + 80 * 40 + 60 * 40))
    assert ((a - mesh.points.mean(axis=0)) * normals).sum(axis=1).min() > 0.0


@pytest.mark.parametrize("flat", [True, False])
def test_even_heat_gives_even_growth_from_the_mounting_face(mesh, flat):
    line = np.array([3.0, -2.0])
    strain = ALPHA * 180.0
    moved = deform(mesh, np.full(len(mesh.points), strain), mounting(mesh, 1, flat, line))
    exact = strain * (mesh.points - np.array([3.0, -2.0, -40.0]))
    assert np.abs(moved - exact).max() < 1e-9


def test_a_linear_temperature_bends_a_free_mold_without_stress(mesh):
    """u = alpha (T0 x + (g.x) x - g |x|^2 / 2), up to a rigid motion: quadratic elements give it to rounding."""
    x = mesh.points
    slope = np.array([0.4, -0.3, 0.9])
    heat = 180.0 + x @ slope
    moved = deform(mesh, ALPHA * heat, mounting(mesh, 1, False, np.zeros(2)))
    exact = ALPHA * (180.0 * x + (x @ slope)[:, None] * x - 0.5 * slope * (x * x).sum(axis=1)[:, None])
    assert np.abs(_without_rigid(x, moved) - _without_rigid(x, exact)).max() < 1e-9


def test_a_plate_held_flat_cannot_bend_and_grows_through_its_thickness_instead():
    """In the middle of a wide plate the strain in the plane is the mean one; along the axis it is
    ((1 + nu) e(z) - 2 nu mean) / (1 - nu)."""
    mesh = box((16, 16, 2), (400.0, 400.0, 20.0), (-200.0, -200.0, 0.0))
    z = mesh.points[:, 2]
    mean, bend, nu = 1e-3, 2e-4, 0.33
    moved = deform(mesh, mean + bend * (z - 10.0) / 10.0, mounting(mesh, 1, True, np.zeros(2)), nu)
    middle = (np.abs(mesh.points[:, :2]) < 1.0).all(axis=1)
    half, whole = middle & (np.abs(z - 10.0) < 1e-9), middle & (z > 19.9)
    assert moved[half, 2] == pytest.approx(10.0 * mean - 5.0 * bend * (1 + nu) / (1 - nu), rel=1e-3)
    assert moved[whole, 2] == pytest.approx(20.0 * mean, rel=1e-3)


def test_values_between_the_nodes_of_the_boundary_are_quadratic(mesh):
    faces = boundary(mesh)
    field = (mesh.points**2).sum(axis=1)
    places = np.array([[13.0, 7.0, 0.0], [40.0, 3.3, -11.0], [-7.7, -30.0, -22.0]])
    values, distance = at_boundary(mesh, faces, field, places)
    assert values == pytest.approx((places**2).sum(axis=1), rel=1e-12)
    assert distance.max() < 1e-9


def test_the_distance_is_that_of_the_curved_sides_not_of_their_chords(mesh):
    """A box bent to a parabola, which its elements hold exactly: places on it lie on it, though in the middle of a side
    they are the sagitta off its chord."""
    radius = 400.0
    bent = TetraMesh(mesh.points - np.outer(mesh.points[:, 0] ** 2 / (2.0 * radius), [0.0, 0.0, 1.0]), mesh.elements)
    x, y = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 500)) * np.array([[40.0], [30.0]])
    places = np.column_stack([x, y, -(x**2) / (2.0 * radius)])
    sagitta = 16.0**2 / (8.0 * radius)
    _, distance = at_boundary(bent, boundary(bent), bent.points[:, 0], places)
    # To the first order: the chord's foot is beside the place by the sagitta times the slope.
    assert distance.max() < 1.2 * sagitta * 40.0 / radius


def test_parts_that_touch_move_together(mesh):
    far = len(mesh.points)
    twice = TetraMesh(
        np.concatenate([mesh.points, mesh.points + np.array([80.0, 0.0, 0.0])]),
        np.concatenate([mesh.elements, mesh.elements + far]),
    )
    one, number = merged(twice.points, twice.elements)
    assert len(one.points) < 2 * far
    assert one.points[number] == pytest.approx(twice.points, abs=1e-9)


def test_a_large_mesh_is_solved_through_rigid_pieces(monkeypatch):
    monkeypatch.setattr(thermoelastic, "_DIRECT_NODES", 100)
    monkeypatch.setattr(thermoelastic, "_AGGREGATES", 60)
    mesh = box((9, 8, 7))
    strain = ALPHA * (100.0 + mesh.points[:, 2])
    moved = deform(mesh, strain, mounting(mesh, 1, False, np.zeros(2)))
    x, slope = mesh.points, np.array([0.0, 0.0, 1.0])
    exact = ALPHA * (100.0 * x + (x @ slope)[:, None] * x - 0.5 * slope * (x * x).sum(axis=1)[:, None])
    assert np.abs(_without_rigid(x, moved) - _without_rigid(x, exact)).max() < 1e-8


def _without_rigid(points, moved):
    x = points - points.mean(axis=0)
    columns = [np.tile(axis, (len(x), 1)) for axis in np.eye(3)] + [np.cross(axis, x) for axis in np.eye(3)]
    matrix = np.stack([column.ravel() for column in columns], axis=1)
    share, *_ = np.linalg.lstsq(matrix, moved.ravel(), rcond=None)
    return moved - (matrix @ share).reshape(-1, 3)
