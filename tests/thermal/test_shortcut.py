"""Long runs on a reduced mold: against the closed form, against the full mold, and where it must not be trusted."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.thermal import shortcut as module
from hyperfab.thermal.condition import Contact, Convection, Heater, Radiation, Thermostat
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.history import History, Ledger, curve
from hyperfab.thermal.lumping import Alike, groups
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.projected import Face, ProjectedMedium, ProjectedModel
from hyperfab.thermal.run_basis import orthonormal
from hyperfab.thermal.shortcut import View, shortcut_for
from hyperfab.thermal.step import State, initial_state
from hyperfab.thermal.tables import Table
from hyperfab.thermal.trail import Lift, Trail
from hyperfab.thermal.transient import Schedule, run


def follow(model, start, schedule, thermostats, nodes, *, wanted, sensors=()):
    full = View(model, thermostats, None)
    shortcut, why = shortcut_for(full, schedule.until, sensors, nodes, wanted)
    history = run(model, start, schedule, thermostats=thermostats, shortcut=shortcut)
    return history, why


def point(model, node):
    sensor = np.zeros(model.size)
    sensor[node] = 1.0
    return sensor


def apart(one, other, sensors, until):
    times = np.linspace(0.0, until, 801)
    return max(float(np.abs(curve(one, s, times) - curve(other, s, times)).max()) for s in sensors)


@pytest.mark.parametrize(("until", "short"), [(15.0, False), (75.0, True)])
def test_a_small_mold_takes_the_short_cut_where_it_switches_often(block, until, short):
    """Some 0.18 s from one switching to the next; a basis costs as much as some hundred of its steps.

    Its 27 unknowns are all that the basis may have: more vectors would be told apart by rounding alone.
    """
    lump = block((0.1, 0.1, 0.05), (1, 1, 1), k=200.0, rho=2700.0, cp=900.0).flux("z-", 3e4).film("z+", 150.0, 20.0)
    model, other = lump.model(), lump.model()
    sensor, nodes = point(model, 0), np.arange(model.size)
    start, schedule = np.full(model.size, 99.0), Schedule(until, (), 0.01)

    def followed(of, wanted):
        thermostats = [Thermostat(of.heaters[0], sensor, 100.0, 0.1)]
        return follow(of, start, schedule, thermostats, nodes, wanted=wanted)[0]

    history, full = followed(model, None), followed(other, False)
    assert (history.reduced is not None) is short
    assert (len(full.switches) > 300) is short
    assert apart(history, full, [sensor], until) < 0.05


def test_relay_cycle_of_a_lump_has_the_period_of_the_closed_form(block):
    lump = block((0.1, 0.1, 0.05), (2, 2, 2), k=1e8, rho=2700.0, cp=900.0).flux("z-", 3e4)
    for way in ("x-", "x+", "z+"):
        lump.film(way, 60.0, 20.0)
    model = lump.model()
    area = 2 * 0.1 * 0.05 + 0.1 * 0.1
    tau = 2700.0 * 900.0 * 0.1 * 0.1 * 0.05 / (60.0 * area)
    hot = 20.0 + 3e4 * 0.1 * 0.1 / (60.0 * area)
    low, high = 98.0, 102.0
    sensor = point(model, 0)
    thermostats = [Thermostat(model.heaters[0], sensor, 100.0, 4.0)]
    history, _ = follow(
        model,
        np.full(model.size, 20.0),
        Schedule(3000.0, (), 1e-4),
        thermostats,
        np.arange(model.size),
        wanted=True,
    )
    first = tau * np.log((hot - 20.0) / (hot - high))
    falling = tau * np.log((high - 20.0) / (low - 20.0))
    rising = tau * np.log((hot - low) / (hot - high))
    found = np.array(history.switches)
    assert len(found) >= 10
    assert history.reduced is not None
    assert history.reduced.begun < found[3]
    exact = first + np.concatenate([[0.0], np.cumsum(np.resize([falling, rising], len(found) - 1))])
    # The lump is uniform to 2e-5 K, and each step errs by 1e-4 K at most, at 4 K in a falling stretch.
    steps = np.searchsorted(history.states.times, found)
    assert np.all(np.abs(found - exact) < steps * 1e-4 * falling / 4.0)
    assert np.all(np.abs(found - exact) < 2e-5 * exact)
    np.testing.assert_allclose(np.diff(found)[2::2], falling, rtol=1e-4)
    np.testing.assert_allclose(np.diff(found)[3::2], rising, rtol=1e-4)


def random_mold(block, seed):
    """A bar or plate of some metal, heated at two ends of its underside, with films of h(T) and radiation."""
    rng = np.random.default_rng(seed)
    size = rng.uniform([0.15, 0.1, 0.02], [0.35, 0.25, 0.06])
    mold = block(tuple(size), (5, 3, 2), k=rng.choice([30.0, 120.0, 237.0]), rho=2700.0, cp=900.0)
    film = Table(np.array([20.0, 100.0, 300.0]), np.sort(rng.uniform(40.0, 200.0, 3)))
    for way in ("z+", "x-", "x+"):
        mold.film(way, film, 25.0)
    mold.radiate("y-", rng.uniform(0.2, 0.9), 25.0).radiate("y+", 0.3, 25.0)
    under = mold.mesh.facet_nodes(mold.faces.named("block.z-").mask)
    middle = mold.mesh.points[under].mean(axis=1)[:, 0]
    power = rng.uniform(0.5, 1.5, 2) * 6e6 * float(np.prod(size)) / 2.0
    for end, watts in zip((middle < 0.4 * size[0], middle > 0.6 * size[0]), power, strict=True):
        facets = FacetOperator(mold.mesh.points, under[end])
        name = f"heater {len(mold.conditions)}"
        mold.conditions.append(Heater(name, facets.load(1.0) / facets.area, Table.constant(watts)))
    model = mold.model()
    probes = [
        point(model, mold.node(x * size[0], 0.5 * size[1], z * size[2]))
        for x, z in ((0.2, 0.5), (0.8, 0.5), (0.5, 1.0))
    ]
    together = rng.random() < 0.5
    thermostats = [
        Thermostat(heater, probes[0 if together else number], set_point, 3.0)
        for number, (heater, set_point) in enumerate(
            zip(model.heaters, 80.0 + (0.0 if together else 1.0) * rng.uniform(-5.0, 5.0, 2), strict=True)
        )
    ]
    return mold, model, probes, thermostats


def agrees(block, seed):
    until = 500.0
    found = []
    for wanted in (True, False):
        mold, model, probes, thermostats = random_mold(block, seed)
        nodes = np.unique(mold.face("z+").nodes)
        history, _ = follow(
            model,
            np.full(model.size, 25.0),
            Schedule(until),
            thermostats,
            nodes,
            wanted=wanted,
            sensors=probes,
        )
        found.append(history)
    reduced, full = found
    watched = [*probes, *(point(model, node) for node in nodes[::7])]
    assert full.reduced is None
    if reduced.reduced is None:  # few stretches, and most of them of a few steps
        assert len(full.jumps) < module.FEWEST
        return reduced, full
    assert reduced.ledger.imbalance() < 1e-11
    off = apart(reduced, full, watched, until)
    assert off < 0.05
    # Stages are solved to 1e-6 of what a step changes, some 10 K.
    assert off < reduced.reduced.error + 1e-5
    return reduced, full


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_reduced_mold_keeps_its_bound_on_a_random_mold(block, seed):
    reduced, full = agrees(block, seed)
    assert len(reduced.switches) == len(full.switches)
    assert reduced.reduced.stretches >= len(full.jumps) // 3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 53))
def test_reduced_mold_keeps_its_bound_on_many_random_molds(block, seed):
    agrees(block, seed)


@pytest.mark.slow
def test_thermostats_that_switch_one_shortly_after_the_other(block):
    """Two alike, with probes in like places: what lies between their switchings is too short to be told by itself."""
    found = []
    for wanted in (True, False):
        mold = block((0.3, 0.2, 0.04), (6, 3, 2), k=800.0, rho=2702.0, cp=903.0)
        mold.film("z+", 20.0, 25.0).radiate("y-", 0.5, 25.0)
        under = mold.mesh.facet_nodes(mold.faces.named("block.z-").mask)
        middle = mold.mesh.points[under].mean(axis=1)
        for x in (0.05, 0.25):
            near = np.argsort(np.hypot(middle[:, 0] - x, middle[:, 1] - 0.1))[:2]
            facets = FacetOperator(mold.mesh.points, under[near])
            name = f"heater {len(mold.conditions)}"
            mold.conditions.append(Heater(name, facets.load(1.0) / facets.area, Table.constant(1200.0)))
        model = mold.model()
        probes = [point(model, mold.node(x, 0.1, 0.04)) for x in (0.05, 0.2499)]
        thermostats = [
            Thermostat(heater, probe, 80.0, 2.0) for heater, probe in zip(model.heaters, probes, strict=True)
        ]
        nodes = np.unique(mold.face("z+").nodes)
        start = np.full(model.size, 25.0)
        history, _ = follow(model, start, Schedule(1800.0), thermostats, nodes, wanted=wanted, sensors=probes)
        found.append(history)
    reduced, full = found
    assert reduced.reduced is not None
    assert reduced.reduced.returns == 0
    assert len(reduced.switches) == len(full.switches) > 30
    off = apart(reduced, full, [*probes, *(point(model, node) for node in nodes[::5])], 1800.0)
    assert off < reduced.reduced.error < 0.05


def test_what_a_check_finds_comes_into_the_basis(block):
    _, model, probes, thermostats = random_mold(block, 6)
    rng = np.random.default_rng(1)
    capacity = model.pattern.matrix(model.medium.capacity(np.zeros(model.size)))
    basis = orthonormal(np.column_stack([np.ones(model.size), rng.normal(size=(model.size, 3))]), capacity, 0.0, 9)
    lift = Lift.with_room(np.full(model.size, 80.0), basis, 9)
    start = initial_state(model, 0.0, np.full(model.size, 25.0))
    history = History(Trail([start]), Ledger.begin(model, 0.0, []))
    coordinates = rng.normal(size=4)
    history.states.append(State(1.0, coordinates, np.zeros(4), np.zeros(4), np.ones(4)), lift)
    before = history.states[1].temperature, history.states[1].slope
    shortcut, _ = shortcut_for(View(model, thermostats, None), 500.0, probes, np.zeros(0, dtype=int), True)
    assert shortcut is not None
    found = [1e-5 * rng.normal(size=model.size) for _ in range(2)]
    shortcut._found = [*found, found[0] + basis[:, 1]]  # what the basis has adds nothing
    now = State(1.0, coordinates, np.zeros(4), np.zeros(4))
    narrow = View(ProjectedModel(model, lift, 0.0), thermostats, None, lift)
    found_view = shortcut._widened(narrow, now)
    wider = found_view.lift
    assert wider is not None
    # It is about the state of now, and is what is projected from nothing.
    np.testing.assert_array_equal(wider.origin, before[0])
    anew = ProjectedMedium.of(model.medium, wider)
    for name, value in vars(anew).items():
        np.testing.assert_allclose(getattr(found_view.model.medium, name), value, rtol=1e-9, atol=1e-9, err_msg=name)
    assert wider.basis.shape[1] == 6
    np.testing.assert_array_equal(wider.basis[:, :4], basis)
    np.testing.assert_allclose(wider.basis.T @ (capacity @ wider.basis), np.eye(6), atol=1e-9)
    for one in found:
        left = one - wider.basis @ (wider.basis.T @ (capacity @ one))
        assert np.abs(left).max() < 1e-12
    # The states gone through are what they were, by the same memory.
    np.testing.assert_allclose(history.states[1].temperature, before[0], rtol=1e-14)
    np.testing.assert_allclose(history.states[1].slope, before[1], rtol=1e-12)
    assert np.shares_memory(history.states.entry(1)[0].basis, wider.basis)
    # What it has already makes it no wider; it is about the present state all the same.
    shortcut._found = [1e-5 * basis[:, 1], basis[:, 2]]
    again = shortcut._widened(found_view, State(2.0, np.ones(6), np.zeros(6), np.zeros(6))).lift
    assert again is not None
    assert again.basis.shape[1] == 6
    np.testing.assert_allclose(again.origin, wider.nodal(np.ones(6)))


@pytest.mark.slow
def test_schedule_that_jumps_and_surroundings_that_change(block):
    def mold():
        made = block((0.2, 0.1, 0.04), (5, 3, 2), k=50.0, rho=2700.0, cp=900.0)
        corners = np.concatenate([[60.0 * k, 60.0 * k + 1e-3] for k in range(1, 30)])
        power = np.resize([0.0, 1.0, 1.0, 0.0], len(corners))
        face = made.face("z-")
        made.conditions.append(Heater("timed", face.load(1.0) / face.area, Table(corners, 900.0 * power)))
        air = Table(np.array([0.0, 1800.0]), np.array([20.0, 60.0]))
        film = Table(np.array([20.0, 200.0]), np.array([10.0, 30.0]))
        made.conditions.append(Convection("air", made.face("z+"), film, air))
        made.conditions.append(Radiation("sky", made.face("x+"), 0.8, air))
        return made.model(), tuple(corners), np.unique(made.face("z+").nodes)

    found = []
    for wanted in (True, False):
        model, corners, nodes = mold()
        start = np.full(model.size, 20.0)
        found.append(follow(model, start, Schedule(1800.0, corners), [], nodes, wanted=wanted)[0])
    reduced, full = found
    assert reduced.reduced is not None
    assert reduced.reduced.stretches >= 40
    off = apart(reduced, full, [point(model, node) for node in nodes], 1800.0)
    assert off < min(0.05, reduced.reduced.error)


@pytest.mark.slow
def test_basis_too_poor_is_given_up_for_the_full_mold(block, monkeypatch):
    monkeypatch.setattr(module, "VECTORS", 2)
    monkeypatch.setattr(module, "TRIES", 2)
    found = []
    for wanted in (True, False):
        mold, model, probes, thermostats = random_mold(block, 3)
        nodes = np.unique(mold.face("z+").nodes)
        start = np.full(model.size, 25.0)
        found.append(follow(model, start, Schedule(500.0), thermostats, nodes, wanted=wanted)[0])
    poor, full = found
    assert poor.reduced is not None
    assert poor.reduced.returns == module.TRIES
    assert poor.reduced.stretches == 0
    np.testing.assert_allclose(poor.switches, full.switches, atol=1e-3)
    assert apart(poor, full, probes, 500.0) < 1e-3
    assert poor.ledger.imbalance() < 1e-11


def test_points_without_any_spread_stay_together():
    rows = np.full((30, 2), 0.1)
    found = groups(rows, np.full(30, 0.3), 20)
    assert sorted(np.concatenate(found).tolist()) == list(range(30))


def test_few_points_stand_for_a_face_whose_film_has_a_corner_where_it_works(block, monkeypatch):
    """A film that jumps in slope at 100 degC, on a face that swings about it, warmer in the middle than at its rim."""
    made = block((0.3, 0.2, 0.03), (9, 7, 2), k=50.0, rho=2700.0, cp=900.0)
    film = Table(np.array([20.0, 100.0, 180.0]), np.array([20.0, 30.0, 90.0]))
    made.film("z+", film, 20.0)
    model = made.model()
    x, y = (made.mesh.points[:, axis] / made.mesh.points[:, axis].max() for axis in (0, 1))
    rng = np.random.default_rng(4)
    bowl = 4.0 * np.sin(np.pi * x) * np.sin(np.pi * y)
    other = rng.normal(size=(model.size, 20))  # vectors that nothing moves along
    basis = np.linalg.qr(np.column_stack([np.ones(model.size), bowl, x, other]))[0]
    origin = 97.0 + bowl
    swings = [origin + a + b * bowl + c * x for a, b, c in rng.uniform(-1.0, 1.0, (12, 3)) * [4.0, 0.5, 2.0]]
    face = model.conditions[0]
    assert len(face.facets.weights.ravel()) > 400
    monkeypatch.setattr("hyperfab.thermal.lumping.POINTS", 60)
    missed = {}
    for name, seen in (("seen", swings[:6]), ("unseen", [])):
        found = Face(face, Lift(origin, basis, Alike([origin, *seen])), 0.0)
        missed[name] = max(
            abs(float(found.flow(0.0, basis.T @ (at - origin))[0] / (face.flow(0.0, at) @ basis)[0]) - 1.0)
            for at in swings[6:]
        )
    # A group a kelvin wide that the corner lies in, one of eight, is off by an eighth of 50 W/m2/K in 2400 W/m2.
    assert missed["seen"] < 3e-4
    assert missed["seen"] < 0.5 * missed["unseen"]


def test_joint_that_opens_on_a_reduced_mold(block):
    """Both faces of a joint lose their contact by schedule: the projected joint is the full one's."""
    from hyperfab.thermal.projected import ProjectedModel

    made = block((0.1, 0.05, 0.02), (3, 2, 2), k=50.0, rho=2700.0, cp=900.0)
    closed = Table(np.array([0.0, 10.0]), np.array([1.0, 0.2]))
    model_conditions = [Contact("joint", made.face("z+"), made.face("z-"), 300.0, closed)]
    made.conditions += model_conditions
    made.film("x-", Table(np.array([0.0, 100.0]), np.array([5.0, 25.0])), 20.0).radiate("x+", 0.7, 10.0)
    model = HeatModel(made.mesh, [made.material], made.conditions)
    rng = np.random.default_rng(5)
    origin, at = rng.uniform(20.0, 90.0, model.size), 6.0
    basis = np.linalg.qr(np.column_stack([np.ones(model.size), rng.normal(size=(model.size, 6))]))[0]
    projected = ProjectedModel(model, Lift(origin, basis), 0.0)
    q = np.concatenate([[20.0], rng.normal(size=6) * 30.0])
    full = model.flow(at, origin + basis @ q)
    np.testing.assert_allclose(projected.flow(at, q), full @ basis, rtol=1e-9, atol=1e-9)
    assert projected.total(full @ basis) == pytest.approx(full.sum(), abs=1e-9)
    stored = model.stored(origin + basis @ q)
    np.testing.assert_allclose(projected.stored(q), stored @ basis, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda mold: mold.hold("y-", 25.0), "held"),
        (
            lambda mold: (
                setattr(
                    mold,
                    "material",
                    type(mold.material)(
                        "warm", 1.0, Table.constant(1.0), Table(np.array([0.0, 9.0]), np.array([1.0, 2.0]))
                    ),
                )
                or mold
            ),
            "change with temperature",
        ),
    ],
)
def test_what_has_no_projection_is_told(block, change, word):
    mold = change(block((1.0, 1.0, 1.0), (1, 1, 1)).flux("z-", 1.0))
    model = mold.model()
    shortcut, why = shortcut_for(View(model, [], None), 10.0, [], np.zeros(0, dtype=int), True)
    assert shortcut is None
    assert word in why
