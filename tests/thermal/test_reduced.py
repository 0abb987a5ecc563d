"""A mold reduced to a few unknowns against exact solutions of the whole, and sensors that lag against theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numba import typeof

from hyperfab.ahead import listed, written
from hyperfab.thermal import reduced as reduction
from hyperfab.thermal.condition import Contact, Convection, Heater
from hyperfab.thermal.course import Course
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.medium import ThermalMaterial
from hyperfab.thermal.mesh import split_contacts
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.reduced import reduce
from hyperfab.thermal.reduced_steps import march
from hyperfab.thermal.sensors import lagging
from hyperfab.thermal.settings import patch
from hyperfab.thermal.tables import Table

from .conftest import block_mesh


def plain(mold, **changed):
    """Settings of one run in which nothing is changed but what is given; ``effects`` by name."""
    given = {name: np.array([changed.pop(name)]) for name in list(changed) if hasattr(mold.plain(), name)}
    return replace(mold.plain(), **given, effects={name: np.array([value]) for name, value in changed.items()})


def probes_at(block, *places):
    rows = np.zeros((len(places), len(block.mesh.points)))
    rows[np.arange(len(places)), [block.node(*place) for place in places]] = 1.0
    return rows


#: More time scales than a command takes, so that what is left is the steps' and the elements' error.
SCALES = (300.0, 100.0, 30.0, 10.0, 3.0, 1.0)


def reduced(block, places, start, duration, bench=None):
    model = block.model()
    probes = probes_at(block, *places)
    return reduce(model, probes, np.full(model.size, float(start)), duration, bench, scales=SCALES)


#: A slab that cools through a film: Biot and Fourier number, centre and surface. Incropera & DeWitt, series solution.
SLAB = [(0.1, 1.0, 0.9223885716, 0.878126487609), (1.0, 1.0, 0.533859401409, 0.348176851662)]


@pytest.mark.parametrize(("biot", "fourier", "centre", "surface"), SLAB)
def test_slab_that_cools_through_a_film(block, biot, fourier, centre, surface):
    mold = reduced(block((1.0, 0.1, 0.1), (24, 1, 1)).film("x+", biot), [(0, 0, 0), (1, 0, 0)], 1.0, fourier)
    shown = mold.run(np.array([0.0, 0.5 * fourier, fourier]), plain(mold), 200)[0]
    assert shown[0] == pytest.approx([1.0, 1.0], abs=1e-6)
    assert shown[-1] == pytest.approx([centre, surface], abs=2e-4)


@pytest.mark.parametrize(
    ("changed", "biot", "fourier"),
    [
        ({"film": [10.0]}, 1.0, 1.0),
        ({"conductivity": [0.1], "capacity": [0.1]}, 1.0, 1.0),
        ({"film": [10.0], "capacity": [0.5]}, 1.0, 2.0),
    ],
)
def test_a_number_in_front_of_a_matrix_is_that_of_the_whole(block, changed, biot, fourier):
    """The slab of Biot number 0.1 becomes that of 1 by ten times the film, or a tenth of conduction and capacity."""
    mold = reduced(block((1.0, 0.1, 0.1), (24, 1, 1)).film("x+", 0.1), [(0, 0, 0), (1, 0, 0)], 1.0, 1.0)
    shown = mold.run(np.array([0.0, 1.0]), plain(mold, **changed), 200)[0, -1]
    if fourier == 1.0:
        assert shown == pytest.approx(SLAB[1][2:], abs=2e-3)
    else:
        # Half the capacity: as twice the time, by the one-term series; tan z = Bi/z at z = 0.8603.
        assert shown[0] == pytest.approx(0.533859401409 * np.exp(-(0.860333589**2)), abs=2e-3)


def test_the_steps_are_taken_by_the_kernel_of_the_build(block, monkeypatch):
    # Called with an array of another order in memory it is compiled anew: a quarter of a minute.
    called = []
    monkeypatch.setattr(reduction, "march", lambda *of: called.append(of) or march(*of))
    model = block((1.0, 0.1, 0.1), (24, 1, 1)).film("x+", 0.1).model()
    mold = reduce(model, np.eye(1, model.size), np.ones(model.size), 1.0, None, zones=4)
    for changed in ({}, {"capacity_per_K": 0.1}):
        mold.run(np.array([0.0, 1.0]), plain(mold, **changed), 2)
    kinds = [[written(typeof(one)) for one in of] for of in called]
    assert len(kinds) == 2
    assert [one for one in kinds if one not in listed()["hyperfab.thermal.reduced_steps.march"]] == []


def test_slab_under_a_flux(block):
    """Aluminium, 50 kW/m^2 for a minute, and half of that: Carslaw & Jaeger, section 3.8."""
    slab = block((0.06, 0.02, 0.02), (8, 1, 1), k=237.0, rho=2702.0, cp=903.0).flux("x-", 5e4)
    mold = reduced(slab, [(0, 0, 0), (0.06, 0, 0)], 0.0, 60.0)
    shown = mold.run(np.array([0.0, 60.0]), plain(mold), 200)[0, -1]
    assert shown == pytest.approx([24.7120017351, 18.3828884011], abs=5e-3)
    half = mold.run(np.array([0.0, 60.0]), plain(mold, power=[0.5]), 200)[0, -1]
    assert half == pytest.approx(0.5 * shown, rel=1e-9)
    # 10 % of the power lost; a warmer start rides on top.
    less = mold.run(np.array([0.0, 60.0]), plain(mold, lost=0.1, start_K=[3.0]), 200)[0, -1]
    assert less == pytest.approx(0.9 * shown + 3.0, abs=1e-6)


def test_a_power_that_grows_evenly_is_summed_exactly(block):
    """16 J/K all but insulated, under 0.5 W more each second: 0.25 t^2 joules; the stages stand where that is met."""
    lump = block((0.02, 0.02, 0.02), (1, 1, 1), k=1e5, rho=2000.0, cp=1000.0).film("x+", 1e-9, 25.0)
    share = lump.model().lumped_capacity
    ramp = Table(np.array([0.0, 100.0]), np.array([0.0, 50.0]))
    lump.conditions.append(Heater("h", share / share.sum(), ramp))
    mold = reduced(lump, [(0, 0, 0)], 25.0, 100.0)
    shown = mold.run(np.array([0.0, 40.0, 100.0]), plain(mold), 40)[0, :, 0]
    # Within 0.01 K: what heats it is not spread quite as its capacity is.
    assert shown == pytest.approx(25.0 + 0.25 * np.array([0.0, 40.0, 100.0]) ** 2 / 16.0, abs=0.01)


def test_thin_plate_that_radiates(block):
    """The lumped solution of a plate that radiates both ways, 0.8, from 200 degC; its own, or as an effect."""
    plate = block((0.01, 0.01, 0.01), (1, 1, 1), k=1e5, rho=2702.0, cp=903.0)
    plate.radiate("x-", 0.8, 25.0).radiate("x+", 0.8, 25.0)
    mold = reduced(plate, [(0, 0, 0)], 200.0, 1229.65245872)
    assert mold.run(np.array([0.0, 1229.65245872]), plain(mold), 200)[0, -1, 0] == pytest.approx(100.0, abs=0.01)
    bare = block((0.01, 0.01, 0.01), (1, 1, 1), k=1e5, rho=2702.0, cp=903.0)
    bare.film("x-", 1e-9, 25.0).film("x+", 1e-9, 25.0)
    mold = reduced(bare, [(0, 0, 0)], 200.0, 1229.65245872)
    times = np.array([0.0, 1229.65245872])
    assert mold.run(times, plain(mold, emissivity=0.8), 200)[0, -1, 0] == pytest.approx(100.0, abs=0.01)
    # An ambient of 5 K more, and surroundings of 5 K less than that, are the same sky.
    other = plain(mold, emissivity=0.8, ambient_K=[5.0], surroundings_K=-5.0)
    assert mold.run(times, other, 200)[0, -1, 0] == pytest.approx(100.0, abs=0.01)


def test_a_bench_under_the_mold_is_a_film_to_the_ambient(block):
    lump = block((0.02, 0.02, 0.02), (1, 1, 1), k=1e5, rho=2000.0, cp=1000.0).film("x+", 20.0, 25.0)
    mold = reduced(lump, [(0, 0, 0)], 100.0, 600.0, bench=lump.face("x-"))
    shown = mold.run(np.array([0.0, 300.0, 600.0]), plain(mold, bench=30.0), 200)[0, :, 0]
    # C dT/dt = -(20 + 30) A (T - 25), C/A = 2000 * 1000 * 0.02.
    assert shown == pytest.approx(25.0 + 75.0 * np.exp(-50.0 * np.array([0.0, 300.0, 600.0]) / 4e4), abs=5e-3)
    # An ambient that drifts: T = Ta + d t - d/l + (T0 - Ta + d/l) exp(-l t), l the rate.
    rate, drift = 50.0 / 4e4, 0.01
    drifted = mold.run(np.array([0.0, 600.0]), plain(mold, bench=30.0, ambient_per_s=drift), 200)[0, -1, 0]
    exact = 25.0 + drift * 600.0 - drift / rate + (75.0 + drift / rate) * np.exp(-rate * 600.0)
    assert drifted == pytest.approx(exact, abs=5e-3)


def two_walls(conductance, opened):
    """Two thin walls of great conductivity, 0.05 m each, joined over their face; the hot one heated at its end."""
    mesh = block_mesh((0.1, 0.05, 0.05), (2, 1, 1), parts=lambda c: (c[:, 0] > 0.05).astype(np.int64))
    joint = ~mesh.facets.outer
    split = split_contacts(mesh, joint)
    near = FacetOperator(split.points, split.facet_nodes(joint))
    far = FacetOperator(split.points, split.facet_nodes(joint, other_side=True))
    corners = split.points[split.facet_nodes(joint | ~joint)][:, :, 0]
    ends = [
        FacetOperator(split.points, split.facet_nodes(split.facets.outer & mask))
        for mask in (corners.max(axis=1) < 1e-9, corners.min(axis=1) > 0.1 - 1e-9)
    ]
    contact = Contact("joint", near, far, conductance, Table.constant(1.0))
    power = Heater("heater", ends[0].load(1.0) / ends[0].area, Table.constant(10.0))
    film = Convection("film", ends[1], Table.constant(100.0), Table.constant(20.0))
    walls = [ThermalMaterial(name, 100.0, Table.constant(1e5), Table.constant(10.0)) for name in ("a", "b")]
    model = HeatModel(split, walls, [contact, power, film])
    weights = np.stack([(split.points[:, 0] < 1e-9), (split.points[:, 0] > 0.1 - 1e-9)]).astype(float)
    probes = weights / weights.sum(axis=1, keepdims=True)
    return reduce(model, probes, np.full(model.size, 20.0), 100.0, None, opened=[contact] if opened else [])


@pytest.mark.parametrize("opened", [False, True])
def test_a_joint_jumps_by_its_flux_over_its_conductance(opened):
    """At the end nothing changes any more: 10 W through 25 cm^2 are 4000 W/m^2."""
    mold = two_walls(200.0, opened)
    given = plain(mold, opened=[1.0 / 200.0]) if opened else plain(mold)
    hot, cold = mold.run(np.array([0.0, 100.0]), given, 200)[0, -1]
    assert cold == pytest.approx(20.0 + 4000.0 / 100.0, abs=0.05)
    assert hot - cold == pytest.approx(4000.0 / 200.0, abs=0.05)
    worse = plain(mold, opened=[1.0 / 50.0]) if opened else plain(mold, joint=[50.0])
    hot, cold = mold.run(np.array([0.0, 100.0]), worse, 200)[0, -1]
    assert hot - cold == pytest.approx(4000.0 / 50.0, abs=0.2)


def test_a_patch_knows_its_middle_and_its_axes():
    """A strip 4 by 1, evenly covered: places of mean 0 and, along the axes, mean square 1; in whatever order."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-1.95, 1.95, 40), np.linspace(-0.45, 0.45, 10)))
    points = np.column_stack([x + 7.0, np.zeros_like(x), y - 3.0])
    few = patch(np.ones((40, 1)), np.full(40, 0.1), np.column_stack([x[::10], y[::10], y[::10]]))
    assert 0.1 * (few.places**2)[:, 1:].sum(axis=0) / 4.0 == pytest.approx([1.0, 1.0], abs=1e-12)
    assert few.places[:, 0].sum() == pytest.approx(0.0, abs=1e-9)
    found = patch(np.column_stack([x, y]), np.full(len(x), 0.01), points)
    assert found.weights.sum() == pytest.approx(4.0, rel=1e-12)
    mean, square = found.weights @ found.places / 4.0, found.weights @ found.places[:, 1:] ** 2 / 4.0
    assert mean == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert square == pytest.approx([1.0, 1.0], abs=0.06)  # points counted together lose a little
    # The first axis is the long one, the third number the way from the middle.
    along, across = np.abs(found.places[:, 1]), np.abs(found.places[:, 2])
    assert along == pytest.approx(np.abs(found.rows[:, 0]) / np.std(x), abs=1e-6)
    assert across == pytest.approx(np.abs(found.rows[:, 1]) / np.std(y), abs=1e-6)
    middle = np.argmin(along**2 + across**2)
    assert found.places[middle, 0] < -0.9
    # Resistance twice as large at one end as at the other leaves the matrix of its mean conductance.
    steady = found.jump(0.01, np.array([0.0, 0.0, 0.0]))
    assert steady == pytest.approx(found.rows.T @ (found.weights[:, None] * found.rows) / (0.01 + 1e-7), rel=1e-12)
    uneven = found.uneven(np.array([0.0, 0.5, 0.0]))
    assert uneven == pytest.approx(np.maximum(1.0 + 0.5 * found.places[:, 1], 0.05), rel=1e-12)
    assert found.weights @ uneven / 4.0 == pytest.approx(1.0, rel=1e-9)


def test_a_run_says_when_it_comes_to_a_value():
    """Between its steps it is a parabola: of a parabola the time is exact, of any bend, and after a peak too."""
    grid = np.array([0.0, 1.0, 4.0])
    for curve, slope in (
        (lambda t: 3.0 * t - 0.2 * t**2, lambda t: 3.0 - 0.4 * t),
        (lambda t: 0.5 * t + 0.3 * t**2, lambda t: 0.5 + 0.6 * t),
        (lambda t: 2.0 * t, lambda t: 2.0 + 0.0 * t),
    ):
        course = Course(grid, curve(grid)[:, None], slope(grid)[:, None])
        for time in (0.25, 1.0, 2.5, 4.0):
            assert course.when(np.array([2.0]), 2.0 * curve(time)) == pytest.approx(time, rel=1e-12)
        assert course.at(np.array([0.5, 3.0]))[:, 0] == pytest.approx(curve(np.array([0.5, 3.0])), rel=1e-12)
        assert course.when(np.ones(1), 1.01 * curve(4.0)) is None
        assert course.when(np.ones(1), -1.0) == 0.0
    peak = Course(np.array([0.0, 2.0]), np.array([[0.0], [4.0]]), np.array([[4.0], [0.0]]))  # 4 t - t^2
    past = Course(np.array([0.0, 3.0]), np.array([[0.0], [3.0]]), np.array([[4.0], [-2.0]]))
    assert (peak.when(np.ones(1), 4.0), past.when(np.ones(1), 3.0)) == (2.0, 3.0)


def test_parts_hold_their_heat(block):
    """``m c T``, and a slab that a film cools loses what it stores."""
    slab = block((0.1, 0.1, 0.1), (4, 1, 1), rho=2000.0, cp=500.0).film("x+", 100.0)
    mold = reduced(slab, [(0, 0, 0)], 7.0, 600.0)
    assert mold.stored(mold.start) == pytest.approx([2000.0 * 500.0 * 1e-3 * 7.0], rel=1e-9)


def test_a_film_that_is_absent_comes_with_its_factor(block):
    """Biot number 0.1, and a film of 0.9 more beside it, is that of 1; its surroundings can be another's."""
    slab = block((1.0, 0.1, 0.1), (24, 1, 1)).film("x+", 0.1)
    model, times = slab.model(), np.array([0.0, 1.0])
    more = Convection("more", model.conditions[0].facets, Table.constant(0.9), Table.constant(0.0))
    probes, start = probes_at(slab, (0, 0, 0), (1, 0, 0)), np.ones(model.size)
    mold = reduce(model, probes, start, 1.0, None, scales=SCALES, absent=[more])
    assert mold.run(times, mold.plain(), 200)[0, -1] == pytest.approx(SLAB[0][2:], abs=2e-4)
    assert mold.run(times, plain(mold, film=[1.0, 1.0]), 200)[0, -1] == pytest.approx(SLAB[1][2:], abs=2e-3)
    # Both together are one film to surroundings at the mean of theirs by their coefficients.
    warm = mold.run(times, plain(mold, film=[1.0, 1.0], ambient_K=[0.0, 2.0, 0.0]), 200)[0, -1]
    assert warm == pytest.approx(1.8 - 0.8 * np.array(SLAB[1][2:]), abs=2e-3)


def test_a_sensor_that_lags_shows_a_ramp_late_and_a_step_slowly():
    """``lag dq/dt = T - q``: a ramp r t is shown as r (t - lag (1 - exp(-t/lag))), whatever the readings' times."""
    times = np.array([0.0, 1.0, 2.0, 5.0, 7.0, 15.0, 16.0])
    lag = 4.0
    ramp = np.stack([3.0 * times, 2.0 - times], axis=1)[None]
    shown = lagging(times, ramp, np.array([lag]))[0]
    behind = times - lag * (1.0 - np.exp(-times / lag))
    assert shown[:, 0] == pytest.approx(3.0 * behind, abs=1e-12)
    assert shown[:, 1] == pytest.approx(2.0 - behind, abs=1e-12)
    each = lagging(times, ramp, np.array([[lag, 0.0]]))[0]
    assert each[:, 0] == pytest.approx(3.0 * behind, abs=1e-12)
    assert np.array_equal(each[:, 1], ramp[0, :, 1])
    # Two sensors in a row: of a ramp, with equal lags, 2 lag behind in the end and (t + 2 lag) exp(-t/lag) before.
    fine = np.linspace(0.0, 16.0, 3201)
    twice = lagging(fine, lagging(fine, fine[None, :, None], np.array([lag])), np.array([lag]))[0, :, 0]
    exact = fine - 2.0 * lag + (fine + 2.0 * lag) * np.exp(-fine / lag)
    assert twice == pytest.approx(exact, abs=1e-5)


def _slab_warms(at: np.ndarray) -> np.ndarray:
    """Both ends of a unit slab, a unit flux through one, its other end insulated: Carslaw & Jaeger (1959), 3.8."""
    n = np.arange(1, 200)[:, None]
    decay = 2.0 / np.pi**2 * np.exp(-((n * np.pi) ** 2) * np.maximum(at, 0.0)) / n**2
    rise = np.stack([at + 1.0 / 3.0 - decay.sum(axis=0), at - 1.0 / 6.0 - ((-1.0) ** n * decay).sum(axis=0)])
    return np.where(at > 0.0, rise, 0.0)


@pytest.mark.parametrize("pulse", [0.04, 0.2])
def test_pulses_shorter_than_a_hundredth_of_the_run(block, pulse):
    """They were one step long: the heated end missed by a tenth of what a pulse warms it."""
    body, duration = block((1.0, 0.1, 0.1), (24, 1, 1)).flux("x-", 1.0), 8.0
    mold = reduced(body, [(0, 0, 0), (1, 0, 0)], 0.0, duration)
    on = np.arange(0.3, duration - 1.0, 0.7)
    turns = np.ravel(np.column_stack([on, on + pulse]))
    instant = 1e-6
    x = np.ravel(np.column_stack([turns, turns + instant]))
    [(shape, _)] = mold.heaters
    power = Table(x, np.tile([0.0, 0.01, 0.01, 0.0], len(on)))
    mold = replace(mold, heaters=[(shape, power)], corners=tuple(turns))
    times = np.linspace(0.0, duration, 401)
    shown = mold.run(times, plain(mold))[0].T
    exact = sum(_slab_warms(times - begin) - _slab_warms(times - begin - pulse) for begin in on)
    warms = float(_slab_warms(np.array([pulse]))[0, 0])
    assert np.max(np.abs(shown - exact)) < 0.02 * warms
