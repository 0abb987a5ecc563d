"""Large facets are cut, and their new corners are on the mold."""

import numpy as np
import pytest

from hyperfab.pressing.dense import dense
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
    fine = dense(sphere, UP, sphere)
    assert len(fine.faces) > 4 * len(faces)
    assert fine.areas.max() < sphere.areas.max() / 4.0
    off = np.abs(np.linalg.norm(fine.vertices, axis=1) - radius)
    inner = np.linalg.norm(fine.vertices[:, :2], axis=1) < radius * np.sin(np.radians(39.0))  # beside the border: flat
    assert off[inner].max() < 0.02  # chords: 1.1


def test_strips_of_a_cylinder_are_cut_along_and_across() -> None:
    turn, x = np.radians(np.linspace(-40.0, 40.0, 9)), np.array([-100.0, 100.0])
    cylinder = grid(80.0 * np.sin(turn), x, np.repeat(80.0 * np.cos(turn)[:, None], 2, axis=1))
    fine = dense(cylinder, UP, cylinder)
    inner = np.abs(fine.vertices[:, 0]) < 80.0 * np.sin(np.radians(29.0))
    assert np.abs(np.hypot(fine.vertices[:, 0], fine.vertices[:, 2]) - 80.0)[inner].max() < 1e-3  # chords: 0.3
    assert len(np.unique(fine.vertices[:, 1].round(6))) >= 21


def test_a_flat_rim_stays_flat_where_a_blend_begins() -> None:
    male = cup.male_cup(8, 9)
    surface = Surface(male.vertices, male.faces)
    fine = dense(surface, UP, surface)
    assert len(fine.faces) > len(surface.faces)
    top = surface.normals[:, 2] > 0.5
    low = surface.vertices[surface.faces[top]][..., 2].min()
    looking = fine.normals[:, 2] > 0.5
    level = np.abs(fine.vertices[fine.faces[looking]][..., 2] - low).max(axis=1) < 1e-9
    before = np.abs(surface.vertices[surface.faces[top]][..., 2] - low).max(axis=1) < 1e-9
    assert fine.vertices[fine.faces[looking]][..., 2].min() >= low - 1e-9
    assert fine.areas[looking][level].sum() == pytest.approx(surface.areas[top][before].sum(), rel=1e-9)
