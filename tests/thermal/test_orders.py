"""How fast the error falls: third order in space (L2), second in gradients, second in time; and no energy is lost."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.thermal import elements
from hyperfab.thermal.condition import Condition, Prescribed
from hyperfab.thermal.step import initial_state, take_step
from hyperfab.thermal.tables import Table
from hyperfab.thermal.transient import Schedule, run


class Source(Condition):
    """A source given per volume, for manufactured solutions."""

    name = "source"
    linear = True
    nodes = np.zeros((0, 1), dtype=np.int64)

    def __init__(self, load):
        self.load = load

    def flow(self, time, temperature):
        return self.load

    def tangent(self, time, temperature):
        return np.zeros((0, 1, 1))


def exact(x):
    return np.sin(2 * x[..., 0]) * np.exp(x[..., 1]) * np.cos(x[..., 2])


def minus_laplacian(x):
    return 4.0 * exact(x)  # (4 - 1 + 1) u


def steady_errors(block, n):
    body = block((1.0, 1.0, 1.0), (n, n, n))
    mesh = body.mesh
    nodes = mesh.points[mesh.elements]
    found = elements.metric(nodes)
    values, gradients = elements.TETRAHEDRON.tables
    at = np.einsum("qi,mid->mqd", values, nodes)
    load = np.bincount(mesh.elements.ravel(), elements.load(found, minus_laplacian(at)).ravel(), len(mesh.points))
    body.conditions.append(Source(load))
    outer = np.unique(mesh.facet_nodes(mesh.facets.outer))
    model = body.model()
    fixed = exact(mesh.points)

    class Held(Prescribed):
        def apply(self, time, temperature):
            temperature[self.nodes] = fixed[self.nodes]

    model.prescribed = [Held("outer", outer, Table.constant(0.0))]
    model.__post_init__()
    temperature, _ = model.solve_steady(0.0, model.hold(0.0, np.zeros(model.size)))
    error = temperature[mesh.elements] @ values.T - exact(at)
    slope = np.einsum("mi,qik,mqkd->mqd", temperature[mesh.elements], gradients, found.inverse)
    gradient = np.stack(
        [
            2 * np.cos(2 * at[..., 0]) * np.exp(at[..., 1]) * np.cos(at[..., 2]),
            exact(at),
            -np.sin(2 * at[..., 0]) * np.exp(at[..., 1]) * np.sin(at[..., 2]),
        ],
        axis=-1,
    )
    l2 = np.sqrt((found.volume * error**2).sum())
    h1 = np.sqrt((found.volume[..., None] * (slope - gradient) ** 2).sum())
    return l2, h1


def test_space_orders_on_a_manufactured_solution(block):
    coarse, fine = steady_errors(block, 3), steady_errors(block, 6)
    assert np.log2(coarse[0] / fine[0]) == pytest.approx(3.0, abs=0.2)
    assert np.log2(coarse[1] / fine[1]) == pytest.approx(2.0, abs=0.15)


def test_time_order_with_a_nonlinear_film(block):
    film = Table(np.array([0.0, 200.0]), np.array([200.0, 800.0]))
    body = block((0.1, 0.05, 0.05), (4, 2, 2), k=40.0, rho=7800.0, cp=470.0).film("x-", film, 20.0)
    model = body.model()
    # The start is smooth in space and meets the film's condition nowhere worse than the mesh can show.
    start = 100.0 + 50.0 * np.cos(np.pi * body.mesh.points[:, 0] / 0.2)
    settled = run(model, start, Schedule(20.0, (), 1e-3)).states[-1].temperature

    def after(steps):
        state = initial_state(model, 0.0, settled)
        for _ in range(steps):
            state = take_step(model, state, 80.0 / steps).state
        return state.temperature

    reference = after(128)
    errors = [np.abs(after(n) - reference).max() for n in (4, 8, 16)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.25)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.25)


def test_insulated_heated_block_keeps_its_mean_to_the_last_digits(block):
    body = block((0.2, 0.1, 0.1), (4, 2, 2), k=237.0, rho=2702.0, cp=903.0).flux("x-", 3e4)
    model = body.model()
    history = run(model, np.full(model.size, 25.0), Schedule(600.0, (), 0.1))
    capacity = 2702.0 * 903.0 * 0.002
    mean = history.states[-1].stored.sum() / capacity
    assert mean == pytest.approx(25.0 + 3e4 * 0.01 * 600.0 / capacity, rel=1e-11)
    assert history.ledger.imbalance() < 1e-12


def test_account_closes_with_everything_at_once(block):
    film = Table(np.array([25.0, 200.0]), np.array([5.0, 12.0]))
    k = Table(np.array([0.0, 300.0]), np.array([200.0, 240.0]))
    c = Table(np.array([0.0, 300.0]), np.array([880.0, 1000.0]))
    body = block((0.2, 0.1, 0.1), (4, 2, 2), k=k, rho=2702.0, cp=c)
    body.flux("x-", 3e4).film("y-", film, 25.0).radiate("y+", 0.8, 25.0).hold(
        "x+", Table(np.array([0.0, 600.0]), np.array([25.0, 90.0]))
    )
    model = body.model()
    history = run(model, np.full(model.size, 25.0), Schedule(900.0, (600.0,), 0.1))
    assert history.ledger.imbalance() < 1e-11
    assert 600.0 in [state.time for state in history.states]


def test_a_coarse_tolerance_and_a_fine_one_agree(block):
    def final(tolerance):
        body = block((0.2, 0.1, 0.1), (4, 2, 2), k=237.0, rho=2702.0, cp=903.0).flux("x-", 3e4).film("x+", 50.0, 25.0)
        model = body.model()
        history = run(model, np.full(model.size, 25.0), Schedule(600.0, (), tolerance))
        return history.states[-1].temperature, len(history.states)

    coarse, few = final(0.1)
    fine, many = final(0.001)
    assert np.abs(coarse - fine).max() < 0.2
    assert few < many < 100


def test_a_source_that_grows_evenly_is_summed_exactly_by_one_step(block):
    """An insulated block, from 5 to 8 s: the stages stand at the times where a line's integral is met."""
    body = block((0.02, 0.02, 0.02), (1, 1, 1), k=1e5, rho=2000.0, cp=1000.0)
    capacity = body.model().lumped_capacity

    class Growing(Source):
        def flow(self, time, temperature):
            return self.load * time

    body.conditions.append(Growing(capacity * 2.0))  # of 16 J/K: 32 W more each second
    model = body.model()
    start = initial_state(model, 5.0, np.full(model.size, 30.0))
    step = take_step(model, start, 3.0)
    assert step.state.time == 8.0
    assert step.state.stored.sum() - start.stored.sum() == pytest.approx(16.0 * (8.0**2 - 5.0**2), rel=1e-9)
    assert step.entered(model)[-1] == pytest.approx(16.0 * (8.0**2 - 5.0**2), rel=1e-9)


def test_the_error_told_of_a_step_is_its_error(block):
    """A lump that cools through a film, by steps of a tenth and a twentieth of its time: against the exponential."""
    model = block((0.02, 0.02, 0.02), (1, 1, 1), k=1e5, rho=2000.0, cp=1000.0).film("x+", 20.0, 25.0).model()
    for share in (0.1, 0.05):
        step = take_step(model, initial_state(model, 0.0, np.full(model.size, 100.0)), share * 2000.0)
        wrong = abs(step.state.temperature.mean() - 25.0 - 75.0 * np.exp(-share))
        assert step.error == pytest.approx(wrong, rel=1.5 * share)
