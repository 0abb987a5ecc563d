"""The edge of contact between the nodes of a mesh: where known flags and gaps say it is, in one patch or two."""

from __future__ import annotations

import numpy as np
import pytest
from builders import uniform

from hyperfab.membrane.contact_edge import contact_front
from hyperfab.membrane.mesh import sheet_mesh
from hyperfab.membrane.meshing import triangulate
from hyperfab.membrane.outline import Disc

SHEET = Disc(50.0)


def meshed(length: float, order: int = 2):
    return sheet_mesh(SHEET, triangulate(SHEET, uniform(length)), order)


def left(nodes, *circles):
    """Flags and gaps of a sheet that touches within circles (x, y, radius), and leaves as it does a round punch."""
    beyond = np.min([np.hypot(nodes[:, 0] - x, nodes[:, 1] - y) - r for x, y, r in circles], axis=0)
    return beyond <= 0.0, np.maximum(beyond, 0.0) ** 2


@pytest.mark.parametrize("length", [5.0, 2.5])
@pytest.mark.parametrize("radius", [11.3, 23.7, 31.9])
def test_a_circle_is_found_between_the_nodes_to_a_twelfth_of_an_element(radius, length):
    """The root of the gap is the way from the edge: its zero is the edge, but for the chords of the elements."""
    mesh = meshed(length)
    front = contact_front(mesh, mesh.nodes, *left(mesh.nodes, (0.0, 0.0, radius)))
    assert front.mean == pytest.approx(radius, abs=length / 12.0)
    assert front.area == pytest.approx(np.pi * front.mean**2, rel=1e-12)
    away = np.hypot(*front.crossings.T) - radius
    assert np.abs(away).max() < length / 2.0


def test_elements_of_one_order_place_it_half_way():
    mesh = meshed(4.0, 1)
    front = contact_front(mesh, mesh.nodes, *left(mesh.nodes, (0.0, 0.0, 20.0)))
    assert front.mean == pytest.approx(20.0, abs=0.5)


def test_two_patches_are_both_inside_and_what_lies_between_is_not():
    mesh = meshed(4.0)
    front = contact_front(mesh, mesh.nodes, *left(mesh.nodes, (-22.0, 0.0, 12.0), (24.0, 5.0, 9.0)))
    assert front.area == pytest.approx(np.pi * (144.0 + 81.0), rel=0.05)
    at = np.array([[-22.0, 0.0], [24.0, 5.0], [0.0, 0.0], [-22.0, 30.0]])
    assert front.encloses(at).tolist() == [True, True, False, False]
    # From the middle to the nearer edge; straight up from the first patch.
    assert front.beyond(at) == pytest.approx([0.0, 0.0, 10.0, 18.0], abs=1.0)


@pytest.mark.parametrize("first", [True, False])  # a corner of elements, as on the tip of a cone, or a side's middle
def test_a_single_node_is_a_contact_without_an_edge(first):
    mesh = meshed(8.0)
    touching = np.zeros(len(mesh.nodes), bool)
    alike = np.arange(len(mesh.nodes)) < mesh.corners
    touching[np.argmin(np.where(alike == first, np.hypot(*mesh.nodes.T), np.inf))] = True
    front = contact_front(mesh, mesh.nodes, touching, np.where(touching, 0.0, 1.0))
    assert len(front.points()) >= 1
    assert np.hypot(*front.points().T).max() < 8.0
