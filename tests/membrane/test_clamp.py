"""A clamp that gives: force, energy and the rim's place against a second way of solving, and null without it."""

from __future__ import annotations

import numpy as np
import pytest
from builders import uniform
from scipy.optimize import brentq

from hyperfab.materials import bind
from hyperfab.membrane import outline
from hyperfab.membrane.equilibrium import Press
from hyperfab.membrane.measures import mounted_energy
from hyperfab.membrane.mesh import sheet_mesh
from hyperfab.membrane.meshing import triangulate
from hyperfab.membrane.punch import Sphere
from hyperfab.membrane.sheet import Sheet, rim_edges
from hyperfab.membrane.sphere_contact import SphereTest, run
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.membrane.verdict import work
from tests.membrane.axisymmetric import pressed_disc
from tests.membrane.references import DISC, NEO_HOOKEAN

LAW = IsotropicSheet(bind("neo-hookean", NEO_HOOKEAN))
DISC_QUARTER = outline.Disc(100.0, quarter=True)


def _pressed(rim_slip, depths=(60.0,), **more):
    return run([SphereTest(DISC_QUARTER, LAW, 1.0, 40.0, rim_slip=rim_slip, **more)], depths, 1e-4)[0]


def test_shooting_finds_the_published_force_of_the_rigid_clamp():
    force, rim, energy = pressed_disc(60.0)
    expected = DISC["neo-hookean", 60.0]
    assert force == pytest.approx(expected.force, rel=1e-9)
    assert energy == pytest.approx(expected.energy, rel=1e-9)
    assert rim == pytest.approx(100.0, abs=1e-9)


@pytest.mark.parametrize("rim_slip", [5.0, pytest.param(50.0, marks=pytest.mark.slow)])
def test_force_energy_and_rim_of_a_clamp_that_gives(rim_slip):
    force, rim, energy = pressed_disc(60.0, rim_slip=rim_slip)
    solved = _pressed(rim_slip).solved[-1]
    place = np.hypot(*solved.state.places[solved.press.sheet.mesh.rim, :2].T)
    assert solved.state.force == pytest.approx(force, rel=1e-4)
    assert solved.state.energy == pytest.approx(energy, rel=1e-4)
    np.testing.assert_allclose(place, rim, atol=2e-3)
    assert solved.state.reaction == pytest.approx(solved.state.force, rel=1e-9)


def test_work_goes_into_sheet_and_clamp():
    outcome = _pressed(20.0, np.linspace(7.5, 60.0, 8))
    assert work(outcome) == pytest.approx(outcome.solved[-1].state.energy, rel=1e-4)


def test_a_taut_sheet_has_slipped_before_it_is_pressed():
    outcome = _pressed(20.0, np.linspace(7.5, 60.0, 8), prestretch=1.05)
    last = outcome.solved[-1]
    mounted = mounted_energy(last.press)
    assert mounted < last.press.sheet.energy(last.press.sheet.flat)
    assert work(outcome) == pytest.approx(last.state.energy - mounted, rel=1e-4)


@pytest.mark.slow
def test_no_slip_is_the_rigid_clamp_bit_for_bit():
    first, again = (
        _pressed(0.0).solved[-1].state,
        run([SphereTest(DISC_QUARTER, LAW, 1.0, 40.0)], [60.0], 1e-4),
    )
    assert first.places.tobytes() == again[0].solved[-1].state.places.tobytes()


@pytest.mark.parametrize("rim_slip", [1e-5, 1e-12])
def test_a_clamp_that_hardly_gives_is_nearly_rigid(rim_slip):
    """However stiff: the force goes to the rigid clamp's, in proportion to the slip."""
    held = DISC["neo-hookean", 40.0].force
    [solved] = _pressed(rim_slip, (40.0,)).solved
    assert solved.state.force == pytest.approx(held, rel=5e-5)


@pytest.mark.parametrize("rim_slip", [2e-4, 1e-3, 0.05, 0.5])
def test_a_taut_sheet_in_a_clamp_that_hardly_gives_is_mounted_as_by_hand(rim_slip):
    """Rounding of the clamp's stiff springs is no unbalanced force: neo-Hookean, alike all round."""
    sheet = Sheet(sheet_mesh(DISC_QUARTER, triangulate(DISC_QUARTER, uniform(9.0))), LAW, 1.0, 1.05, rim_slip)

    def pulled(s):  # [N/mm], 1 mm thick
        return 2.0 * NEO_HOOKEAN["C10_MPa"] * (s - s**-5)

    s = brentq(lambda s: 100.0 * (1.05 - s) - rim_slip * pulled(s), 1.0, 1.05, xtol=1e-14)
    stored = NEO_HOOKEAN["C10_MPa"] * (2.0 * s**2 + s**-4 - 3.0) * np.pi * 100.0**2
    assert mounted_energy(Press(sheet, Sphere(40.0))) == pytest.approx(
        stored + np.pi * 100.0 * rim_slip * pulled(s) ** 2, rel=1e-6
    )


def test_depths_in_a_clamp_that_hardly_gives_are_reached_from_a_cold_start():
    """At 10 mm the sphere's force is small beside the rounding of the clamp's springs."""
    held, gives = (_pressed(rim_slip, (10.0, 20.0)).solved[0].state.force for rim_slip in (0.0, 1e-3))
    assert gives == pytest.approx(held, rel=1e-4)


def test_springs_pull_by_the_slope_of_their_energy():
    square = outline.Square(40.0)
    sheet = Sheet(sheet_mesh(square, triangulate(square, uniform(9.0))), LAW, 0.7, 1.1, 3.0)
    random = np.random.default_rng(0)
    places = sheet.flat + 0.1 * random.normal(size=sheet.flat.shape)
    way = random.normal(size=places.shape)
    slope = (sheet.energy(places + 1e-5 * way) - sheet.energy(places - 1e-5 * way)) / 2e-5
    assert (sheet.assemble(places).force * way).sum() == pytest.approx(slope, rel=1e-8)
    matrix = sheet.pattern.matrix(sheet.assemble(places).blocks)
    free = sheet.pattern.restrict(sheet.pattern.extend(sheet.pattern.restrict(way)))
    held = sheet.pattern.extend(free)
    ahead, behind = (sheet.assemble(places + sign * 1e-5 * held).force for sign in (1, -1))
    found = sheet.pattern.restrict((ahead - behind) / 2e-5)
    np.testing.assert_allclose(matrix @ free, found, atol=2e-7 * np.abs(found).max())


@pytest.mark.parametrize("order", [1, 2])
def test_rim_edges_are_the_whole_rim(order):
    disc = outline.Disc(50.0)
    mesh = sheet_mesh(disc, triangulate(disc, uniform(8.0)), order)
    _, nodes, _ = rim_edges(mesh)
    assert sorted(np.unique(nodes)) == sorted(mesh.rim)
    assert len(nodes) == (len(mesh.rim) if order == 1 else len(mesh.rim) // 2)
