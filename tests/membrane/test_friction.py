"""Friction between sheet and sphere: known forces, Coulomb's cone, the energy that slip costs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hyperfab.materials import bind
from hyperfab.membrane import equilibrium, friction_path, outline
from hyperfab.membrane.contact import Coulomb, Frictionless, Memory, Stick
from hyperfab.membrane.equilibrium import Press
from hyperfab.membrane.friction_path import run_with_friction
from hyperfab.membrane.measures import fields
from hyperfab.membrane.path import cold_start, follow
from hyperfab.membrane.sphere_contact import Outcome, Solved, SphereTest, rough_path
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.membrane.verdict import work
from tests.membrane.axisymmetric import pressed_disc
from tests.membrane.references import DISC, NEO_HOOKEAN

#: Full stick at 40, 60, 80 mm, sure to 1e-5 [N].
STUCK = {40.0: 16.8713, 60.0: 52.5686, 80.0: 103.634}


def _test(friction, prestretch=1.0, sheet=outline.Disc(100.0, quarter=True)):  # noqa: B008
    law = IsotropicSheet(bind("neo-hookean", NEO_HOOKEAN))
    return SphereTest(sheet, law, 1.0, 40.0, prestretch, friction=friction)


@pytest.fixture(scope="module")
def rubbed():
    return run_with_friction([_test(Coulomb(0.3))], [40.0, 60.0])[0]


@pytest.mark.slow
def test_force_and_energy_with_coulomb_friction(rubbed):
    forces = [solved.state.force for solved in rubbed.solved]
    assert forces == pytest.approx([15.0404007, 44.0083276], rel=5e-4)
    last = rubbed.solved[-1]
    assert last.state.energy == pytest.approx(699.82096, rel=1e-4)
    assert fields(last.press.sheet, last.state.places).stretch[0].mean() == pytest.approx(1.175128, rel=1e-3)


@pytest.mark.slow
def test_every_touching_node_slips_at_the_edge_of_the_cone(rubbed):
    state = rubbed.solved[-1].state
    rub = np.linalg.norm(state.memory.friction, axis=1)[state.touching]
    inner = np.hypot(*rubbed.solved[-1].press.sheet.mesh.nodes[state.touching].T) > 2.0
    np.testing.assert_allclose(rub[inner], 0.3 * state.pressure[state.touching][inner], rtol=1e-6, atol=1e-9)
    assert not state.memory.sticking.any()


@pytest.mark.slow
def test_work_is_stored_or_dissipated(rubbed):
    state = rubbed.solved[-1].state
    lost = rubbed.solved[-1].press.sheet.mesh.copies * state.memory.dissipated
    assert lost == pytest.approx(18.9, abs=0.15)
    assert work(rubbed) == pytest.approx(state.energy + lost, rel=1e-4)


def test_friction_that_vanishes_is_no_friction():
    press, path = rough_path(_test(Coulomb(1e-9)), [20.0, 40.0])
    free, without = rough_path(_test(Frictionless()), [40.0])
    assert press.sheet.mesh.unknowns == free.sheet.mesh.unknowns
    assert path.states[-1].force == pytest.approx(without.states[-1].force, rel=1e-8)


def test_full_stick_in_thirty_steps():
    press, path = rough_path(_test(Stick()), list(np.linspace(2.0, 60.0, 30)))
    last = path.states[-1]
    assert last.force == pytest.approx(STUCK[60.0], rel=1e-2)
    assert last.memory.dissipated == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(fields(press.sheet, last.places).stretch[0], 1.0, atol=2e-3)
    # Stiffer than any friction, and than none.
    assert last.force > 44.0083276 > DISC["neo-hookean", 60.0].force


def test_what_sticks_stays_where_it_touched():
    press, path = rough_path(_test(Stick()), [20.0, 21.0])
    before, after = path.states
    held = before.touching & after.touching
    move = after.places - before.places - np.array([0.0, 0.0, 1.0])
    assert held.sum() > 5
    assert np.abs(move[held]).max() < 1e-9
    assert follow(press, [21.0]).limit is None


@pytest.mark.slow
def test_force_with_coulomb_friction_deep_down():
    assert run_with_friction([_test(Coulomb(0.3))], [80.0])[0].solved[-1].state.force == pytest.approx(
        79.8815992, rel=5e-4
    )


@pytest.mark.slow
@pytest.mark.parametrize("depth", STUCK)
def test_full_stick_extrapolated_to_short_steps(depth):
    outcome = run_with_friction([_test(Stick())], [depth])[0]
    assert outcome.extrapolated == pytest.approx(STUCK[depth], rel=1e-3)


def _rubbing(coefficient, sticking, ways=None):
    """Nodes on a level punch, the sheet pressed on it with 2 N each, in the middle of a load step."""
    count = len(sticking)
    zeros, up = np.zeros((count, 3)), np.tile([0.0, 0.0, 1.0], (count, 1))
    memory = Memory(
        0.0, zeros, np.zeros(count), up, np.ones(count, bool), zeros,
        zeros if ways is None else np.asarray(ways, float), np.asarray(sticking, bool),
    )  # fmt: skip
    return Coulomb(coefficient).begin(memory, zeros)


def test_a_node_sticks_up_to_the_coefficient_times_the_normal_force_and_no_further():
    rubbing = _rubbing(0.3, [True] * 4)
    drag = np.array([[0.599, 0.0, 0.0], [0.0, 0.601, 0.0], [0.48, 0.36, 0.0], [-0.481, 0.361, 0.0]])
    rubbing._decide(np.arange(4), np.full(4, 2.0), drag, np.zeros((4, 3)))
    assert rubbing.sticking.tolist() == [True, False, True, False]
    # It goes the way it is pulled: friction points against that.
    np.testing.assert_allclose(rubbing.ways[1], [0.0, -1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(rubbing.ways[3], np.array([0.481, -0.361, 0.0]) / np.hypot(0.481, 0.361), atol=1e-12)
    assert not rubbing.settled
    # Without pressure nothing holds.
    loose = _rubbing(0.3, [True])
    loose._decide(np.array([0]), np.array([-1.0]), np.array([[1e-3, 0.0, 0.0]]), np.zeros((1, 3)))
    assert not loose.sticking[0]


def test_a_node_that_slips_back_is_held_and_one_that_goes_on_turns():
    rubbing = _rubbing(0.3, [False, False], ways=[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    slip = np.array([[-0.1, 0.0, 0.0], [0.1, 0.1, 0.0]])
    rubbing._decide(np.arange(2), np.full(2, 2.0), np.zeros((2, 3)), slip)
    assert rubbing.sticking.tolist() == [True, False]
    np.testing.assert_allclose(rubbing.ways[1], np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0), atol=1e-12)
    again = _rubbing(0.3, [False], ways=[[1.0, 0.0, 0.0]])
    again._decide(np.array([0]), np.array([2.0]), np.zeros((1, 3)), np.array([[0.2, 0.0, 0.0]]))
    assert again.settled


def _in_the_cone(press, state):
    """No node rubs with more than it can, and those that slip with all of it; the pole may not move."""
    nodes = state.touching & (np.hypot(*press.sheet.mesh.nodes.T) > 0.0)
    rub = np.linalg.norm(state.memory.friction[nodes], axis=1)
    part = rub / (press.tangential.coefficient * state.pressure[nodes])
    return part.max() < 1 + 1e-8 and part[~state.memory.sticking[nodes]].min(initial=1.0) > 0.994


@pytest.mark.parametrize(("prestretch", "coefficient"), [pytest.param(1.02, 1.0, marks=pytest.mark.slow), (1.2, 0.3)])
def test_small_patches_where_some_nodes_stick_and_some_slip_are_followed(prestretch, coefficient):
    """A taut sheet hardly slips on its first way: Newton's method alone ended at 2.8 mm and at 5.3 mm."""
    forces = []
    for steps in (4, 8):
        depths = list(np.linspace(6.0 / steps, 6.0, steps))
        press, path = rough_path(_test(Coulomb(coefficient), prestretch), depths)
        assert path.limit is None
        assert path.failures == 0
        assert all(_in_the_cone(press, state) for state in path.states)
        forces.append(path.states[-1].force)
    assert forces[0] == pytest.approx(forces[1], rel=2e-4)


def test_a_sheet_that_hangs_slack_does_not_rub(monkeypatch):
    """Mounted at 0.95 it is taut from about 30 mm on: at 9 mm no friction is asked for, where none could settle."""
    free = rough_path(_test(Frictionless(), 0.95), [9.0])[0]
    monkeypatch.setattr(Coulomb, "begin", lambda *_: pytest.fail("friction without a normal force"))
    state = cold_start(replace(free, tangential=Coulomb(0.3)), 9.0)
    assert state.force == 0.0
    assert not state.touching.any()


def test_a_round_sheet_mounted_slack_with_friction():
    """Shooting; an iteration each of whose steps lowers the energy finds the place that Newton's method alone finds."""
    press, path = rough_path(_test(Coulomb(0.3), 0.95), list(np.linspace(3.0, 60.0, 20)))
    force, _, energy = pressed_disc(60.0, prestretch=0.95, friction=0.3, guess=(1.13, 28.0))
    assert (force, energy) == pytest.approx((33.0156259, 357.053319), rel=1e-8)
    before, last = path.states[-2:]
    assert last.force == pytest.approx(force, rel=1e-5)
    assert last.energy == pytest.approx(energy, rel=1e-4)
    start = (60.0, before.places, before.touching, before.memory)
    careful = press.equilibrium(*start, cold=True, careful=True)
    assert careful.force == pytest.approx(last.force, rel=1e-6)
    np.testing.assert_allclose(careful.places[last.touching], last.places[last.touching], atol=1e-4)
    assert careful.memory.dissipated == pytest.approx(last.memory.dissipated, rel=1e-4)


def _slack_square(friction, steps=4):
    """The sides of a square mounted at 0.97 bear from 23.9 mm on; its corners hang a good deal longer."""
    depths = list(np.linspace(0.0, 36.0, steps + 1)[1:])
    return rough_path(_test(friction, 0.97, outline.Square(200.0, quarter=True)), depths)


@pytest.mark.slow
def test_a_square_mounted_slack_settles_with_friction():
    """It rubs as nothing where friction is nothing, the more the larger the coefficient, and least where it sticks."""
    _, without = _slack_square(Frictionless())
    paths = [_slack_square(friction)[1] for friction in (Coulomb(1e-9), Coulomb(0.3), Coulomb(1.0))]
    assert all(path.limit is None and path.failures == 0 for path in paths)
    for state, other in zip(paths[0].states, without.states, strict=True):
        assert state.force == pytest.approx(other.force, rel=1e-5)
    forces = [without.states[-1].force, *(path.states[-1].force for path in paths[1:])]
    assert forces == sorted(forces)
    assert forces[1] > 1.01 * forces[0]


@pytest.mark.slow
def test_what_hangs_is_settled_once_and_not_at_each_creep(monkeypatch):
    """A square whose corners hang: the force that comes of settling them at each creep, in half the Newton steps."""
    press, path = rough_path(_test(Frictionless(), 0.97, outline.Square(200.0, quarter=True)), [25.0])
    free, step, steps = path.states[-1], Press._step, []
    monkeypatch.setattr(Press, "_step", lambda *given: steps.append(0) or step(*given))
    start = (26.5, free.places, free.touching, free.memory)

    def rubbed():
        steps.clear()
        return replace(press, tangential=Coulomb(0.3)).equilibrium(*start, cold=True, careful=True).force, len(steps)

    force, quick = rubbed()
    monkeypatch.setattr(equilibrium, "_PASSING_RESIDUAL", equilibrium._HANGING_RESIDUAL)
    monkeypatch.setattr(equilibrium, "_PASSING_GAIN", equilibrium._NO_GAIN)
    settled, slow = rubbed()
    assert force == pytest.approx(settled, rel=1e-5)
    assert quick < 0.7 * slow


@pytest.mark.slow
def test_work_on_a_square_mounted_slack_is_stored_or_dissipated():
    press, path = _slack_square(Coulomb(0.3), 36)
    assert path.limit is None
    last = path.states[-1]
    lost = press.sheet.mesh.copies * last.memory.dissipated
    assert lost > 0.005 * last.energy
    worked = np.trapezoid([state.force for state in path.states], [state.depth for state in path.states])
    assert worked == pytest.approx(last.energy + lost, rel=3e-3)


@pytest.mark.slow
def test_a_square_mounted_slack_that_sticks():
    """Stiffer than any friction; of first order in the step."""
    rough, fine = (_slack_square(Stick(), steps)[1] for steps in (24, 48))
    assert rough.limit is None
    assert fine.limit is None
    rubbed = _slack_square(Coulomb(1.0), 24)[1].states[-1]
    assert fine.states[-1].force > rubbed.force
    assert fine.states[-1].force == pytest.approx(rough.states[-1].force, rel=1e-2)


def test_friction_that_grows_over_a_short_way_leads_to_the_sharp_law():
    """One load step in which nodes slip and the sharp law settles by itself, and the same by way of creep."""
    press, path = rough_path(_test(Coulomb(0.3)), [20.0, 21.0])
    before, sharp = path.states
    start = (21.0, before.places, before.touching, before.memory)
    near = press._creeping(press.tangential, *start)
    assert near.force == pytest.approx(sharp.force, rel=1e-9)
    np.testing.assert_allclose(near.places, sharp.places, atol=1e-6)
    free = rough_path(_test(Frictionless()), [21.0])[1].states[-1]
    assert abs(sharp.force - free.force) > 1e-3 * sharp.force


def test_friction_after_a_slip_with_creep():
    """Half a millimetre of slip in each of two ways, creep 0, 0.5 and 1 mm, 2 N on each node."""
    slip, up = np.array([[0.3, 0.4, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    near = SimpleNamespace(gap=np.zeros(1), normal=up, turning=np.zeros((1, 3, 3)))
    memory = Memory(0.0, 0 * up, np.zeros(1), up, np.ones(1, bool), 0 * up, slip / 0.5, np.zeros(1, bool))
    for creep, part in ((0.0, 1.0), (0.5, np.sqrt(0.5)), (1.0, np.sqrt(0.2))):
        rubbing = Coulomb(0.3, creep).begin(memory, 0 * up)
        friction = lambda way, rubbing=rubbing: rubbing.terms(  # noqa: E731
            np.array([0]), way, 2.0 * up, near, np.array([1e6])
        )
        terms = friction(slip)
        np.testing.assert_allclose(terms.force, 2.0 * up - 0.6 * part * slip / 0.5, rtol=1e-12)
        assert rubbing.sticking[0] == (creep > 0.0)
        # Its stiffness is what the force loses with the place.
        change = np.array([[1e-6, -2e-6, 0.0]])
        lost = friction(slip - change).force - friction(slip + change).force
        np.testing.assert_allclose(terms.blocks[0] @ change[0], 0.5 * lost[0], atol=1e-14)


@pytest.mark.parametrize("holds", [False, True])
def test_the_last_force_is_judged_by_a_rough_mesh_and_by_shorter_steps(monkeypatch, holds):
    """103 N on the fine mesh, 100 N on the rough one, 98 N there in steps of half the length.

    The mesh's error is a third of what it changed; steps of length zero would change as much again as half of them:
    103 + 2 (98 - 100) = 99 N, and that way counts as doubt too.
    """
    state = lambda depth, force: SimpleNamespace(depth=depth, force=force)  # noqa: E731
    rough = SimpleNamespace(states=[state(20.0, 40.0), state(40.0, 100.0)])
    shorter = SimpleNamespace(states=[state(20.0, 41.0), state(30.0, 70.0), state(40.0, 98.0)])
    monkeypatch.setattr(friction_path, "rough_path", lambda *_: (None, shorter))
    outcome = Outcome(None, None, [Solved(None, state(40.0, 103.0))])
    test = SimpleNamespace(friction=SimpleNamespace(holds=holds))
    friction_path._judge(test, outcome, rough, [10.0, 20.0, 30.0, 40.0], lambda _: None)
    mesh = 3.0 / 103.0 / 3.0
    if holds:
        assert outcome.extrapolated == pytest.approx(99.0, rel=1e-12)
        assert outcome.solved[-1].error == pytest.approx(mesh + 4.0 / 103.0, rel=1e-12)
    else:
        assert outcome.extrapolated is None
        assert outcome.solved[-1].error == pytest.approx(mesh, rel=1e-12)


def test_load_steps_divide_the_way_between_the_depths_evenly():
    assert friction_path._divided([20.0, 30.0], 2) == pytest.approx([10.0, 20.0, 25.0, 30.0], rel=1e-12)
