"""Exact and benchmark solutions: NAFEMS T2 to T4 (T1 is thermal stress), slabs, radiation, joints, flux."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from hyperfab.thermal.condition import Contact, Convection, Prescribed
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.medium import ThermalMaterial
from hyperfab.thermal.mesh import split_contacts
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.tables import Table
from hyperfab.thermal.transient import Schedule, run

from .conftest import block_mesh

ALUMINIUM = {"k": 237.0, "rho": 2702.0, "cp": 903.0}


def steady(model, guess=20.0):
    start = model.hold(0.0, np.full(model.size, guess))
    return model.solve_steady(0.0, start)[0]


def warm(model, start, until, tolerance, corners=()):
    return run(model, np.full(model.size, float(start)), Schedule(until, corners, tolerance))


def test_nafems_t2_rod_that_radiates_at_its_end(block):
    rod = block((0.1, 0.01, 0.01), (4, 1, 1), k=55.6).hold("x-", 1000.0 - 273.15).radiate("x+", 0.98, 300 - 273.15)
    temperature = steady(rod.model(), 700.0)
    assert temperature[rod.node(0.1, 0, 0)] + 273.15 == pytest.approx(927.00395045206, abs=1e-7)


def test_nafems_t3_wall_with_a_sine_on_one_side(block):
    times = np.linspace(0.0, 40.0, 4001)
    sine = Table(times, 100.0 * np.sin(math.pi * times / 40.0))
    wall = block((0.1, 0.01, 0.01), (40, 1, 1), k=35.0, rho=7200.0, cp=440.5).hold("x-", 0.0).hold("x+", sine)
    for x, t, exact in ((0.08, 32.0, 36.6031159590846), (0.02, 36.0, 0.186427867711)):
        history = warm(wall.model(), 0.0, t, 5e-3)
        assert history.states[-1].temperature[wall.node(x, 0, 0)] == pytest.approx(exact, abs=8e-3)


def test_nafems_t4_plate_with_films_and_a_corner(block):
    plate = block((0.6, 1.0, 0.1), (12, 20, 1), k=52.0)
    plate.hold("y-", 100.0).film("x+", 750.0).film("y+", 750.0)
    assert steady(plate.model())[plate.node(0.6, 0.2, 0)] == pytest.approx(18.253756537134, abs=0.02)


@pytest.mark.parametrize(
    ("biot", "fourier", "centre", "surface"),
    [
        (0.1, 1.0, 0.9223885716, 0.878126487609),
        (1.0, 1.0, 0.533859401409, 0.348176851662),
        (10.0, 0.5, 0.454640555613, 0.0643289552713),
    ],
)
def test_slab_that_cools_through_a_film(block, biot, fourier, centre, surface):
    slab = block((1.0, 0.04, 0.04), (32, 1, 1)).film("x+", biot)
    temperature = warm(slab.model(), 1.0, fourier, 1e-5).states[-1].temperature
    assert temperature[slab.node(0, 0, 0)] == pytest.approx(centre, abs=4e-5)
    assert temperature[slab.node(1, 0, 0)] == pytest.approx(surface, abs=4e-5)


def test_semi_infinite_body_under_a_flux(block):
    deep = block((1.0, 0.02, 0.02), (60, 1, 1), **ALUMINIUM).flux("x-", 5e4)
    temperature = warm(deep.model(), 0.0, 60.0, 1e-3).states[-1].temperature
    assert temperature[deep.node(0, 0, 0)] == pytest.approx(18.1735582926, rel=1e-3)
    assert temperature[deep.node(0.05, 0, 0)] == pytest.approx(9.53985235457, rel=1e-3)


def test_slab_under_a_flux(block):
    slab = block((0.06, 0.02, 0.02), (8, 1, 1), **ALUMINIUM).flux("x-", 5e4)
    temperature = warm(slab.model(), 0.0, 60.0, 1e-3).states[-1].temperature
    assert temperature[slab.node(0, 0, 0)] == pytest.approx(24.7120017351, abs=2e-3)
    assert temperature[slab.node(0.06, 0, 0)] == pytest.approx(18.3828884011, abs=2e-3)


def test_thin_plate_that_radiates(block):
    # The lumped solution has no resistance inside; the plate's is made as small by a huge conductivity.
    plate = block((0.01, 0.01, 0.01), (1, 1, 1), k=1e5, rho=2702.0, cp=903.0)
    plate.radiate("x-", 0.8, 25.0).radiate("x+", 0.8, 25.0)
    temperature = warm(plate.model(), 200.0, 1229.65245872, 1e-5).states[-1].temperature
    assert temperature.mean() == pytest.approx(100.0, abs=1e-3)


def test_joint_between_two_walls_jumps_by_flux_over_conductance():
    k1, k2, h, film = 50.0, 20.0, 300.0, 100.0
    mesh = block_mesh((0.2, 0.05, 0.05), (8, 2, 2), parts=lambda c: (c[:, 0] > 0.1).astype(np.int64))
    joint = ~mesh.facets.outer
    split = split_contacts(mesh, joint)
    assert len(split.points) - len(mesh.points) == 25  # the interface's nodes are there twice
    near = FacetOperator(split.points, split.facet_nodes(joint))
    far = FacetOperator(split.points, split.facet_nodes(joint, other_side=True))
    assert near.nodes.shape == far.nodes.shape
    np.testing.assert_allclose(split.points[near.nodes], split.points[far.nodes])
    x = split.points[:, 0]
    end = split.facets.outer & (split.points[split.facet_nodes(joint | ~joint)][:, :, 0].min(axis=1) > 0.2 - 1e-9)
    cooled = FacetOperator(split.points, split.facet_nodes(end))
    model = HeatModel(
        split,
        [ThermalMaterial(name, 1.0, Table.constant(k), Table.constant(1.0)) for name, k in (("a", k1), ("b", k2))],
        [
            Contact("joint", near, far, h, Table.constant(1.0)),
            Convection("film", cooled, Table.constant(film), Table.constant(0.0)),
        ],
        [Prescribed("hot", np.flatnonzero(x < 1e-9), Table.constant(100.0))],
    )
    temperature = steady(model)
    flux = 100.0 / (0.1 / k1 + 1 / h + 0.1 / k2 + 1 / film)
    jump = temperature[near.nodes].mean() - temperature[far.nodes].mean()
    assert jump == pytest.approx(flux / h, rel=1e-8)
    assert temperature[x > 0.2 - 1e-9].mean() == pytest.approx(flux / film, rel=1e-8)


def test_conductivity_that_rises_with_temperature(block):
    # Kirchhoff: with k = k0 (1 + b T) the integral of k is linear across the wall.
    k0, b = 10.0, 0.004
    table = Table(np.array([0.0, 1000.0]), np.array([k0, k0 * (1 + b * 1000.0)]))
    wall = block((1.0, 0.1, 0.1), (20, 1, 1), k=table).hold("x-", 0.0).hold("x+", 500.0)
    temperature = steady(wall.model(), 100.0)
    whole = k0 * (500.0 + b / 2 * 500.0**2)
    middle = brentq(lambda t: k0 * (t + b / 2 * t * t) - whole / 2, 0.0, 500.0)
    assert temperature[wall.node(0.5, 0, 0)] == pytest.approx(middle, abs=2e-3)


@pytest.mark.parametrize(
    ("temperatures", "conductivities", "flux"),
    [
        ([0, 150, 200, 300], [3, 3, 6, 6], 2e4),
        ([0, 100, 110, 300], [1, 1, 5, 5], 1e4),
        ([0, 90, 100, 110, 300], [1, 1, 20, 1, 1], 1e4),
    ],
)
def test_conductivity_that_changes_steeply(block, temperatures, conductivities, flux):
    table = Table(np.array(temperatures, float), np.array(conductivities, float))
    wall = block((0.02, 0.002, 0.002), (20, 1, 1), k=table).flux("x-", flux).film("x+", 200.0, 20.0)
    temperature = steady(wall.model())
    cold = 20.0 + flux / 200.0
    for x in (0.0, 0.01, 0.02):
        exact = brentq(lambda t, x=x: table.integral(t) - table.integral(cold) - flux * (0.02 - x), cold - 1e-9, 400.0)
        # A corner of the table inside an element of 1 mm bends the gradient there.
        assert temperature[wall.node(x, 0, 0)] == pytest.approx(exact, abs=0.02)


def test_specific_heat_that_rises_with_temperature_stores_exactly_the_enthalpy(block):
    c = Table(np.array([0.0, 100.0, 400.0]), np.array([800.0, 900.0, 1100.0]))
    body = block((0.1, 0.1, 0.1), (2, 2, 2), k=200.0, rho=2700.0, cp=c).flux("x-", 2e5)
    history = warm(body.model(), 20.0, 300.0, 0.05)
    heat = 2e5 * 0.01 * 300.0
    volume_heat = 2700.0 * 1e-3
    # Enthalpy of the piecewise linear table, from 20 degC, inverted by hand for the uniform body.
    warmed = brentq(lambda t: volume_heat * (c.integral(np.array(t)) - c.integral(np.array(20.0))) - heat, 20, 900)
    assert history.ledger.stored[-1] == pytest.approx(heat, rel=1e-12)
    assert history.states[-1].temperature.mean() == pytest.approx(warmed, rel=0.02)
    assert history.ledger.imbalance() < 1e-12


def test_steady_fin_whose_film_jumps_where_it_passes_a_temperature(block):
    """Two fins end to end, of 10 W/m^2/K where colder than 100 degC and of 80 beyond, that meet at x = 0.023."""
    k, side, length, at, above = 300.0, 0.004, 0.06, 0.023, 75.0
    cold, hot = (math.sqrt(4.0 * h / (k * side)) for h in (10.0, 80.0))
    flux = k * above * cold * math.tanh(cold * (length - at))
    tip = above / math.cosh(cold * (length - at))
    root = above * math.cosh(hot * at) + flux / (k * hot) * math.sinh(hot * at)
    heated = k * hot * above * math.sinh(hot * at) + flux * math.cosh(hot * at)
    film = Table(np.array([0.0, 100.0, 100.0005, 300.0]), np.array([10.0, 10.0, 80.0, 80.0]))
    fin = block((length, side, side), (30, 2, 2), k=k).flux("x-", heated)
    for way in ("y-", "y+", "z-", "z+"):
        fin.film(way, film, 25.0)
    temperature = steady(fin.model(), 25.0)
    assert temperature[fin.node(0, 0, 0)] == pytest.approx(25.0 + root, abs=0.1)
    assert temperature[fin.node(length, 0, 0)] == pytest.approx(25.0 + tip, abs=0.1)
