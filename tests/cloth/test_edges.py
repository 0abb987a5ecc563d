"""Sharp edges: the net lies over them and not through them, whatever the facets."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball, block, punch, saddle, under

from hyperfab.cloth import Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.energy import Energy
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.linear import Tangent, apply
from hyperfab.cloth.net import FIXED, Y
from hyperfab.materials import bind
from hyperfab.surface import Surface

WARP = spring_law(bind("yeoh-3", {"C10_MPa": 0.06095, "C20_MPa": 0.02146, "C30_MPa": 0.017258}))
WEFT = spring_law(bind("yeoh-3", {"C10_MPa": 0.04, "C20_MPa": 0.012, "C30_MPa": 0.01}))
SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)


def over_punch(sections: int, n: int = 61):
    mold = mold_of(punch(sections), (0.0, 0.0, 40.0))
    sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = drape(sheet, mold)
    return found, answers(sheet, mold, found)


def test_a_sharp_rim_converges_and_its_energy_does_not_depend_on_the_facets():
    energies = []
    for sections in (64, 128, 360):
        found, fields = over_punch(sections)
        assert found.converged
        assert fields.cut.node <= 1e-9
        assert fields.cut.edge < 1e-3
        assert fields.imbalance < 1e-5
        energies.append(found.energy)
    assert np.ptp(energies) < 0.005 * energies[0]


@pytest.mark.parametrize("n", [30, 41, 50, 60])
@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_a_box_with_corners_is_covered_and_nothing_of_it_is_cut(n, turn):
    mold = mold_of(block(turn=turn), (0.0, 0.0, 40.0))
    sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
    found = drape(sheet, mold)
    fields = answers(sheet, mold, found)
    assert found.converged
    assert fields.cut.node <= 1e-9
    assert fields.cut.edge <= 1e-6
    assert fields.imbalance < 1e-4


def test_the_energy_on_a_box_settles_as_the_grid_is_refined():
    energies = []
    for n in (41, 61, 81, 101):
        sheet = Sheet(n, n, (200.0, 200.0), 1.0, SOFT, SOFT)
        found = drape(sheet, mold_of(block(), (0.0, 0.0, 40.0)))
        assert found.converged
        energies.append(found.energy)
    assert np.ptp(energies[1:]) < 0.01 * energies[-1]


def test_a_row_over_a_wedge_has_one_tension_and_the_exact_length():
    # Symmetric ridge along y, its line at z = 30: the row is straight from the clamps to the ridge.
    ridge = np.array([[0, -60, 30.0], [0, 60, 30], [-60, -60, -90], [-60, 60, -90], [60, -60, -90], [60, 60, -90]])
    wedge = Surface(ridge, [[0, 1, 2], [1, 3, 2], [0, 4, 1], [1, 4, 5], [0, 2, 4], [1, 5, 3], [2, 3, 4], [3, 5, 4]])
    if wedge.soundness().volume_mm3 < 0:
        wedge = Surface(ridge, wedge.faces[:, ::-1])
    mold = mold_of(wedge)
    exact = 2 * np.hypot(100.0, 30.0) / 200.0
    for n in (20, 21, 34):
        sheet = Sheet(n, 3, (200.0, 10.0), 1.0, SOFT, SOFT, edges=(FIXED, FIXED, Y, Y))
        found = drape(sheet, mold, 1e-9)
        assert found.converged
        stretch = answers(sheet, mold, found).stretch_warp
        assert np.abs(stretch - exact).max() < 1e-7
        assert found.energy == pytest.approx(float(SOFT(exact)[0][0]) * 200.0 * 10.0, rel=1e-9)


def test_the_forces_of_bent_springs_are_derivatives_of_the_energy_and_the_tangent_theirs():
    mold = mold_of(punch(90), (0.0, 0.0, 40.0))
    sheet = Sheet(24, 24, (200.0, 200.0), 1.0, SOFT, SOFT)
    state = drape(sheet, mold, 1e-4).state
    rng = np.random.default_rng(0)
    d = rng.normal(size=state.x.shape)
    on_top = state.contact != 0
    assert np.allclose(state.x[on_top, 2], 40.0)
    d[on_top, 2] = 0.0
    x = state.x + 1e-3 * d  # out of equilibrium
    model = Energy(sheet, mold)
    clear, f, plus, minus = np.zeros((24, 24)), np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    model.forces(x, clear, f)
    bent = len(model.springs)
    assert bent > 20
    tangent, kd, h = Tangent.empty(24, 24, 2), np.zeros_like(x), 1e-6
    model.tangent(x, 0.0, tangent)
    tangent.q[:] = [1, 0, 0, 1, 0, 1]
    apply(tangent, d, kd)
    rise = model.forces(x + h * d, clear, plus)[0] - model.forces(x - h * d, clear, minus)[0]
    assert len(model.springs) == bent
    assert rise / (2 * h) == pytest.approx(-(f * d).sum(), rel=1e-6)
    error = np.abs(kd + (plus - minus) / (2 * h))
    error[on_top, 2] = 0.0
    assert error.max() < 1e-6 * np.abs(kd).max()


@pytest.mark.parametrize("n", [61, 100, pytest.param(140, marks=pytest.mark.slow)])
@pytest.mark.parametrize("depth", [10.0, 20.0, 40.0, 50.0])
def test_a_sheet_that_hangs_on_two_ridges_rests_on_its_springs_alone(n, depth):
    surface = saddle()
    mold = mold_of(surface, under(surface, depth))
    sheet = Sheet(n, n, (220.0, 220.0), 1.0, SOFT, SOFT)
    found = drape(sheet, mold)
    fields = answers(sheet, mold, found)
    assert found.converged, found.status
    assert fields.contact_edges > 10
    assert fields.cell_on_edge.any()
    assert fields.press_force == pytest.approx(found.push[2] + fields.contact_force[..., 2].sum(), rel=1e-12)
    assert fields.imbalance < 1e-4
    # Both ridges carry, each half, and nothing rests on the trough between them.
    places = sheet.flat()[found.bent[:, 0], found.bent[:, 1], 0]
    assert (places > 30.0).any()
    assert (places < -30.0).any()
    assert not fields.touching[np.abs(sheet.flat()[..., 0]) < 30.0].any()


@pytest.mark.parametrize(
    ("half", "height", "cells", "turned", "n", "depth"),
    [
        (40.0, 10.0, 44, True, 60, 40.0),  # straight ridges aslope, ending in corners
        (50.0, 10.0, 51, True, 60, 50.0),
        (40.0, 35.0, 62, False, 60, 20.0),  # facets shorter than the springs on a steep arch
        (40.0, 10.0, 42, False, 60, 20.0),
    ],
)
def test_edges_of_facets_shorter_than_the_springs_keep_no_equilibrium_away(half, height, cells, turned, n, depth):
    surface = saddle(half, height, cells, turned)
    mold = mold_of(surface, under(surface, depth))
    sheet = Sheet(n, n, (220.0, 220.0), 1.0, WARP, WEFT)
    found = drape(sheet, mold)
    assert found.converged, found.status
    assert answers(sheet, mold, found).cut.node <= 1e-9


def test_a_smooth_mold_bends_no_spring():
    mold = mold_of(ball(3), (0.0, 0.0, 20.0))
    assert len(mold.creases.corners) == 0


def test_places_that_are_no_numbers_bend_no_spring():
    # Where a law has no answer a step leads there; the mold was asked outside of memory.
    for mold in (mold_of(ball(5, 40.0), (0.0, 0.0, 60.0)), mold_of(punch(32), (0.0, 0.0, 20.0))):
        energy = Energy(Sheet(7, 7, (200.0, 200.0), 1.0, SOFT, SOFT), mold)
        for place in (np.nan, -np.inf):
            x = np.full((7, 7, 3), place)
            energy.forces(x, np.zeros((7, 7)), np.zeros_like(x))
            assert len(energy.springs) == 0


def test_cells_folded_over_a_rim_are_as_thin_as_their_springs_say():
    mold = mold_of(punch(128), (0.0, 0.0, 40.0))
    sheet = Sheet(41, 41, (200.0, 200.0), 1.0, SOFT, SOFT)
    fields = answers(sheet, mold, drape(sheet, mold))
    product = 1.0 / (fields.cell_stretch_warp * fields.cell_stretch_weft)
    assert (fields.cell_thickness < 1.02 / np.cos(np.radians(fields.cell_shear)) * product).all()
