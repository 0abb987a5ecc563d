"""How deep the net is in the mold, found exactly, whatever lies between the probes of a sampling."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cloth_molds import ball, block, punch, saddle, under

from hyperfab.cloth import Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.depth import SURE, cut, deepest, stands_out
from hyperfab.cloth.start import settled
from hyperfab.surface import Surface

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
NO_BENDS = (np.zeros((0, 4), np.int64), np.zeros((0, 3)))


def pin(radius: float, top: float, at: tuple[float, float], bottom: float = -30.0) -> Surface:
    mesh = trimesh.creation.cylinder(radius=radius, height=top - bottom, sections=64)
    return Surface(mesh.vertices + np.array([*at, 0.5 * (top + bottom)]), mesh.faces)


def flat_net(surface: Surface, spacing: float = 5.0, z: float = 0.0):
    """A flat net of 9 x 7 nodes at height ``z``, as it is, and what it cuts."""
    sheet = Sheet(9, 7, (8 * spacing, 6 * spacing), 1.0, SOFT, SOFT)
    mold = mold_of(surface)
    x = sheet.flat() + np.array([0.0, 0.0, z])
    state = settled(x, mold, Sheet(9, 7, sheet.size, 1.0, SOFT, SOFT, edges=(0, 0, 0, 0)))
    state.clear[:] = 0.0
    state.x[:] = x
    return x, sheet, mold, state


@pytest.mark.parametrize("offset", [0.0, 0.004, 0.2])
@pytest.mark.parametrize("share", [0.37, 0.5, 0.11])
def test_a_pin_through_a_spring_is_found_wherever_it_stands(offset, share):
    # Half a millimetre thick, 6 mm through: between three probes 1.25 mm apart it is seen by none.
    surface = pin(0.25, 6.0, (-5.0 + 5.0 * share, offset))
    x, sheet, mold, state = flat_net(surface)
    found = cut(x, sheet, mold, state, *NO_BENDS)
    apothem = 0.25 * np.cos(np.pi / 64)
    assert found.edge == pytest.approx(0.25 - offset, abs=0.25 - apothem + SURE)
    assert found.flat[0] == pytest.approx(-5.0 + 5.0 * share, abs=0.01)
    assert found.draped[0] == pytest.approx(-5.0 + 5.0 * share, abs=0.01)
    assert found.node == 0.0
    through, top, below = stands_out(x, sheet, mold_of(surface))
    assert through == pytest.approx(6.0, abs=1e-9)
    assert top[2] == pytest.approx(6.0)
    assert np.allclose(below[:2], top[:2], atol=1e-9)


def test_a_pin_amid_a_cell_is_seen_standing_through():
    surface = pin(0.25, 6.0, (-2.5, 2.5))
    x, sheet, mold, state = flat_net(surface)
    assert cut(x, sheet, mold, state, *NO_BENDS).edge == 0.0
    assert stands_out(x, sheet, mold_of(surface))[0] == pytest.approx(6.0, abs=1e-9)
    assert stands_out(x, sheet, mold_of(pin(0.25, -0.5, (-2.5, 2.5))))[0] == 0.0
    assert stands_out(x, sheet, mold_of(pin(0.25, 6.0, (40.0, 0.0))))[0] == 0.0  # beside the net


def test_nodes_and_springs_inside_a_box_are_as_deep_as_they_are():
    surface = block(22.0, 60.0)  # its top at 0, its sides at +-11: nodes to +-10, springs to +-11
    for below in (0.3, 0.8):
        x, sheet, mold, state = flat_net(surface, z=-below)
        found = cut(x, sheet, mold, state, *NO_BENDS)
        assert found.node == pytest.approx(below, abs=1e-12)
        assert found.edge == pytest.approx(below, abs=SURE)
    # The corner of a net that leans into an edge: a spring from (0, 0, 1) to (5, 0, -4) passes (1, 0, 0).
    steep = np.array([[9.0, 0.0, 1.0]]), np.array([[14.0, 0.0, -4.0]])
    depth, where, share = deepest(*steep, np.array([-1]), mold_of(surface), 0.0, SURE)
    # On x + z = 10 the edge at (11, 0) lies 1/sqrt(2) off; the deepest point is half way between top and side.
    assert where == 0
    assert depth == pytest.approx(0.5, abs=SURE)
    assert share == pytest.approx(0.3, abs=1e-5)


def test_the_deepest_point_is_never_shallower_than_any_sample_and_no_deeper_than_the_next():
    rng = np.random.default_rng(3)
    for surface in (
        ball(3, 20.0),
        punch(40, 10.0, 20.0),
        saddle(15.0, 6.0, 12),
        pin(0.3, 10.0, (1.0, 2.0), -10.0),
    ):
        mold = mold_of(surface)
        middle, size = surface.vertices.mean(0), np.ptp(surface.vertices, axis=0)
        a = middle + (rng.random((60, 3)) - 0.5) * 1.3 * size
        b = a + rng.normal(size=(60, 3)) * 0.1 * size.max()
        for k in range(60):
            depth, _, share = deepest(a[k : k + 1], b[k : k + 1], np.array([-1]), mold, 0.0, SURE)
            t = np.linspace(0.0, 1.0, 801)[:, None]
            sampled = -surface.nearest(a[k] + t * (b[k] - a[k])).distance
            step = np.linalg.norm(b[k] - a[k]) / 800
            assert depth >= max(sampled.max(), 0.0) - SURE
            assert depth <= max(sampled.max() + 0.5 * step, 0.0) + SURE
            if depth > 0.0:
                assert -surface.nearest(a[k] + share * (b[k] - a[k])).distance[0] == pytest.approx(depth, abs=1e-9)


def test_chords_on_a_ball_cut_the_sagitta():
    surface = ball(6)
    mold = mold_of(surface, (0.0, 0.0, 20.0))
    sheet = Sheet(41, 41, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = drape(sheet, mold)
    fields = answers(sheet, mold, found)
    touching = found.state.contact != 0
    both = touching[1:] & touching[:-1]
    chord = np.linalg.norm(np.diff(found.state.x, axis=0), axis=2)[both].max()
    assert fields.cut.edge == pytest.approx(chord**2 / (8 * 60.0), rel=0.1)
    assert fields.cut.node <= 1e-9


def test_a_spring_laid_over_an_edge_is_followed_as_it_runs():
    surface = block(80.0)
    sheet = Sheet(30, 30, (200.0, 200.0), 1.0, SOFT, SOFT)
    mold = mold_of(surface, under(surface, 40.0))
    found = drape(sheet, mold)
    assert len(found.bent)
    as_they_run = answers(sheet, mold, found).cut
    assert as_they_run.edge <= 1e-6
    # Straight between their nodes they would cut the edges.
    straight = cut(found.state.x, sheet, mold, found.state, *NO_BENDS)
    assert straight.edge > 0.3


def test_how_far_a_mold_stands_out_is_the_same_on_its_mirror_image():
    """A twisted cell, whose two diagonals lie at different heights, over a pin off the middle."""
    said = []
    for side in (1.0, -1.0):
        surface = pin(0.25, 6.0, (side * 2.0, 1.0))
        x, sheet, _, _ = flat_net(surface)
        x = x + np.stack([0 * x[..., 0], 0 * x[..., 0], 0.02 * side * x[..., 0] * x[..., 1]], axis=-1)
        through, top, below = stands_out(x, sheet, mold_of(surface))
        said.append([through, side * top[0], top[1], side * below[0], below[1]])
    assert said[1] == pytest.approx(said[0], abs=1e-9)
    assert said[0][0] > 5.0
