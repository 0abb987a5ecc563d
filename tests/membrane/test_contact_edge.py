"""The edge of contact of a sphere: where known flags and gaps say it is, round or drawn out."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from builders import uniform

from hyperfab.membrane.contact_edge import contact_edge
from hyperfab.membrane.mesh import sheet_mesh
from hyperfab.membrane.meshing import triangulate
from hyperfab.membrane.outline import Disc


def left(mesh, along, across, uneven):
    """A press and its state: the sheet touches within an ellipse, and opens ``uneven`` times as steeply beside it."""
    x, y = mesh.nodes.T
    angle = np.arctan2(y, x)
    beyond = np.hypot(x, y) - ellipse(angle, along, across)
    steep = 1.0 + (uneven - 1.0) * np.sin(angle) ** 2
    gap = (steep * np.maximum(beyond, 0.0)) ** 2 * (1.0 + 0.02 * beyond)
    sheet = SimpleNamespace(mesh=mesh, reach=50.0, pattern=SimpleNamespace(free=mesh.nodes[:, [0] * 3] < np.inf))
    near = SimpleNamespace(gap=gap, facet=None)
    press = SimpleNamespace(sheet=sheet, punch=SimpleNamespace(near=lambda places, depth: near))
    return press, SimpleNamespace(touching=beyond <= 0.0, force=1.0, places=mesh.nodes, depth=1.0)


def ellipse(angle, along, across):
    return along * across / np.hypot(across * np.cos(angle), along * np.sin(angle))


@pytest.mark.parametrize("quarter", [True, False])
@pytest.mark.parametrize(
    ("along", "across", "uneven"),
    [(24.0, 24.0, 1.0), (30.0, 24.0, 2.0), (34.0, 23.0, 3.0), (23.0, 34.0, 0.3)],
)
def test_an_edge_is_found_around_the_whole_of_a_round_or_drawn_out_contact(along, across, uneven, quarter):
    """Each angle is asked where the sheet leaves the sphere there, not where it does along the longer axis."""
    sheet = Disc(50.0, quarter=quarter)
    mesh = sheet_mesh(sheet, triangulate(sheet, uniform(2.5)), 2)
    found = contact_edge(*left(mesh, along, across, uneven))
    around = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    exact = ellipse(around, along, across)
    assert found.mean == pytest.approx(exact.mean(), rel=3e-3)
    assert found.radius(around) == pytest.approx(exact, abs=0.5)


@pytest.mark.parametrize("order", [1, 2])
def test_a_contact_of_one_node_has_an_edge_within_an_element(order):
    mesh = sheet_mesh(Disc(50.0), triangulate(Disc(50.0), uniform(5.0)), order)
    press, state = left(mesh, 1.0, 1.0, 1.0)
    state.touching = np.hypot(*mesh.nodes.T) == np.hypot(*mesh.nodes.T).min()
    assert -5.0 < contact_edge(press, state).mean < 5.0
