"""Dirty STL surfaces: closed where little is missing, several pieces told apart, refused with the place where not."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from hyperfab.errors import InputError
from hyperfab.surface import soundness
from hyperfab.thermal.repair import _stitched, crossing, pieces, repaired


def soup(mesh, move=lambda corners: corners):
    """The facets of a mesh with corners of their own."""
    corners = move(np.array(mesh.triangles))
    return corners.reshape(-1, 3), np.arange(corners.size // 3, dtype=np.int64).reshape(-1, 3)


def box(*size, at=(0.0, 0.0, 0.0)):
    return trimesh.creation.box(size, transform=trimesh.transformations.translation_matrix(at))


def arrays(mesh):
    return np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int64)


def volume(found):
    return soundness(*found).volume_mm3


def test_a_narrow_slit_is_welded_and_how_far_is_said():
    def lifted(corners):
        return corners + np.where(corners.mean(axis=1, keepdims=True)[..., 2:] > 0, 0.1, 0.0) * [0, 0, 1]

    found = repaired(*soup(trimesh.creation.icosphere(3, radius=40.0), lifted), "slit.stl")
    assert 0.05 <= found.deviation_mm <= 0.1  # both lips meet between them
    assert any("none moved more than" in note for note in found.notes)
    assert soundness(found.vertices, found.triangles).sound


def test_a_corner_on_a_neighbours_edge_splits_it():
    whole = box(100, 80, 20)
    top = whole.face_normals[:, 2] > 0.5
    finer = trimesh.Trimesh(whole.vertices, whole.faces[top]).subdivide().subdivide()
    rest = trimesh.Trimesh(whole.vertices, whole.faces[~top])
    found = repaired(*soup(trimesh.util.concatenate([finer, rest])), "box.stl")
    assert found.deviation_mm < 1e-9
    assert volume((found.vertices, found.triangles)) == pytest.approx(160e3)
    assert any("4 edges were split" in note for note in found.notes)


@pytest.mark.parametrize("gap", [1.0, 5.0])
def test_a_wide_gap_is_refused_with_facet_and_place(gap):
    def lifted(corners):
        return corners + np.where(corners.mean(axis=1, keepdims=True)[..., 2:] > 0, gap, 0.0) * [0, 0, 1]

    with pytest.raises(InputError, match=r"gap\.stl, facet \d+: the surface is not closed.*one at \("):
        repaired(*soup(trimesh.creation.icosphere(3, radius=40.0), lifted), "gap.stl")


def test_pieces_are_a_union_and_inward_ones_inside_are_voids():
    void, turned = box(20, 20, 10), box(30, 30, 30, at=(200, 0, 0))
    void.invert()
    turned.invert()
    found = pieces(*arrays(trimesh.util.concatenate([box(100, 80, 20), void, turned])))
    assert sorted(volume(piece) for piece in found) == pytest.approx([27e3, 156e3])
    assert len(pieces(*arrays(box(1, 2, 3)))) == 1


def test_a_facet_through_another_is_found_and_a_sound_surface_has_none():
    ball = trimesh.creation.icosphere(3, radius=40.0)
    assert crossing(*arrays(ball)) is None
    assert crossing(*arrays(box(3, 2, 1))) is None
    vertices, faces = arrays(ball)
    vertices = vertices.copy()
    vertices[np.argmax(vertices[:, 2]), 2] = -60.0
    facet, place = crossing(vertices, faces)
    assert 0 <= facet < len(faces)
    assert np.linalg.norm(place) == pytest.approx(40.0, abs=0.5)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_whether_facets_cross_hangs_on_no_unit(size):
    """A needle through a plate, and one that ends in it by less than rounding."""
    flat = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [9, 9, 0.0]])
    facet, place = crossing(size * flat, np.array([[0, 1, 2], [3, 4, 5]]))
    assert facet in (0, 1)
    assert abs(place[2]) <= 1e-9 * size
    ends = flat.copy()
    ends[3:] = [[0.5, 0.5, -1e-9], [0.5, 0.5, 1.0], [0.6, 0.5, 1.0]]
    assert crossing(size * ends, np.array([[0, 1, 2], [3, 4, 5]])) is None


def test_a_corner_near_the_end_of_a_long_edge_splits_it_too():
    """Two facets with one edge of 100 mm in common; across it a third has its corner 1 mm from the end."""
    points = np.array([[0, 0, 0], [100, 0, 0], [50, 40, 0], [1, 0, 0], [50, -40, 0.0]])
    for corner in (1.0, 50.0, 99.0):
        points[3, 0] = corner
        faces = np.array([[0, 1, 2], [0, 4, 3], [3, 4, 1]])
        found, strayed, split = _stitched(points, faces, 1e-6)
        assert (split, strayed) == (1, 0.0)
        assert len(found) == 4


def test_a_facet_without_height_makes_way_for_its_neighbours_halves():
    """What cuts an end face along a line of four corners leaves such facets; the surface is closed with them."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0, 1], [0.5, 0, 0]], dtype=float)
    faces = np.array([[0, 2, 1], [1, 2, 3], [2, 0, 3], [0, 1, 4], [4, 1, 3], [4, 3, 0]])
    assert soundness(points, faces).closed
    mended = repaired(points, faces, "wedge.stl")
    sides = points[mended.triangles[:, [1, 2]]] - points[mended.triangles[:, :1]]
    assert len(mended.triangles) == 6
    assert np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).min() > 0.1
    assert soundness(points, mended.triangles).closed
