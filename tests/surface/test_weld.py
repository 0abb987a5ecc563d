"""Corners that differ by rounding are one; a slit, a detail and a border are what they are."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from hyperfab.surface import soundness
from hyperfab.surface.weld import unrounded


def soup(mesh: trimesh.Trimesh, digits: int, off: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The facets of a mesh with corners of their own, off by up to ``off`` and then rounded, as files hold them."""
    corners = np.array(mesh.triangles)
    corners = np.round(corners + off * np.random.default_rng(seed).uniform(-1.0, 1.0, corners.shape), digits)
    vertices, inverse = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, inverse.reshape(-1, 3)


@pytest.mark.parametrize(("digits", "off"), [(6, 2e-5), (4, 1e-4), (3, 1e-4), (2, 1e-3)])
def test_a_closed_surface_that_was_rounded_facet_by_facet_is_closed_again(digits: int, off: float) -> None:
    ball = trimesh.creation.icosphere(4, radius=60.0)
    vertices, faces = soup(ball, digits, off)
    assert not soundness(vertices, faces).closed
    one = unrounded(vertices, faces)
    assert one is not None
    found = soundness(one.vertices, one.faces)
    assert found.closed
    assert len(one.vertices) == len(ball.vertices)
    assert found.volume_mm3 == pytest.approx(ball.volume, rel=1e-5)
    assert one.moved <= 2.0 * np.sqrt(3.0) * (off + 0.5 * 10.0**-digits)
    assert one.kept.tolist() == list(range(len(ball.faces)))


def test_a_surface_whose_corners_are_one_is_left_as_it_is() -> None:
    ball = trimesh.creation.icosphere(3, radius=60.0)
    vertices, faces = np.asarray(ball.vertices), np.asarray(ball.faces, np.int64)
    assert unrounded(vertices, faces) is None
    dome = faces[(vertices[faces, 2] > 0.0).all(axis=1)]  # open
    assert unrounded(vertices, dome) is None


def test_the_border_of_an_open_surface_stays() -> None:
    ball = trimesh.creation.icosphere(4, radius=60.0)
    dome = trimesh.Trimesh(ball.vertices, ball.faces[(ball.triangles[..., 2] > 0.0).all(axis=1)])
    one = unrounded(*soup(dome, 4, 1e-4))
    assert one is not None
    assert soundness(one.vertices, one.faces).open_edges == soundness(dome.vertices, dome.faces).open_edges


def test_an_edge_nearly_as_short_as_the_gap_is_a_detail() -> None:
    """Gaps of 0.02 mm beside edges of 0.05 mm: which of the corners belong together is not told by their distance."""
    block = trimesh.creation.box((200.0, 200.0, 40.0))
    chip = trimesh.creation.box((0.05, 0.05, 0.05)).apply_translation((0.0, 0.0, 40.0))
    assert unrounded(*soup(block, 6, 0.02)) is not None
    vertices, faces = soup(trimesh.util.concatenate([block, chip]), 6, 0.005)
    one = unrounded(vertices, faces)
    assert one is None or one.distance < 0.01


def test_corners_further_apart_than_any_rounding_are_a_hole() -> None:
    ball = trimesh.creation.icosphere(3, radius=60.0)
    corners = np.array(ball.triangles)
    corners[:1] += [0.0, 0.0, 0.5]
    vertices, inverse = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    assert unrounded(vertices, inverse.reshape(-1, 3)) is None
