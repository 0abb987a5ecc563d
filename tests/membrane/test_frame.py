"""A machine that yields: the depth it reads is the punch's and force times compliance."""

import numpy as np
import pytest

from hyperfab.materials.registry import bind
from hyperfab.membrane import outline
from hyperfab.membrane.frame import punch_depths, run_on_frame
from hyperfab.membrane.sphere_contact import Outcome, Solved, SphereTest, rough_path, run
from hyperfab.membrane.tension_field import IsotropicSheet
from tests.membrane.axisymmetric import pressed_disc
from tests.membrane.references import NEO_HOOKEAN

LAW = IsotropicSheet(bind("neo-hookean", NEO_HOOKEAN))


@pytest.mark.slow
def test_the_punch_is_less_deep_than_the_machine_reads():
    """Force at the punch's own depth by shooting; the curve met at the depths that were asked for."""
    test = SphereTest(outline.Disc(100.0, quarter=True), LAW, 1.0, 40.0, mesh_size=15.0, frame=0.08)
    [outcome] = run_on_frame(test, [60.0], lambda depths: run([test], depths, 1e-2))
    [solved] = outcome.solved
    assert solved.read == pytest.approx(60.0, abs=1e-4)
    assert solved.state.depth + 0.08 * solved.state.force == pytest.approx(60.0, abs=1e-4)
    assert solved.state.force == pytest.approx(pressed_disc(solved.state.depth)[0], rel=1e-3)
    assert solved.state.force == pytest.approx(37.04043, rel=1e-3)


def test_a_path_that_ends_early_stands_as_far_as_it_came():
    """A softening sheet turns back at 60.35 mm (shooting), before the machine reads what was asked for."""
    soft = IsotropicSheet(bind("mooney-rivlin-2", {"C10_MPa": 0.2158118922, "C01_MPa": -0.0630439338}))
    test = SphereTest(outline.Disc(100.0, quarter=True), soft, 1.0, 40.0, mesh_size=15.0, order=1, frame=0.02)
    asked = []

    def press(depths):
        asked.append(depths)
        rough, path = rough_path(test, depths)
        return [Outcome(rough, path, [Solved(rough, state) for state in path.states])]

    [outcome] = run_on_frame(test, [40.0, 70.0], press)
    assert len(asked) == 1
    assert asked[0][1] > 60.35
    assert outcome.path.limit.turning_point == pytest.approx(60.35, abs=0.8)
    assert outcome.solved[0].read == pytest.approx(40.0, abs=0.1)


def test_a_path_that_found_nothing_or_turns_the_machine_back_has_depths_all_the_same():
    """No equilibrium at all; and a force that falls by 0.4 N/mm under a machine of 0.33 N/mm: it reads 25 and 23 mm."""
    read = np.array([2.0, 12.5, 26.0])
    np.testing.assert_array_equal(punch_depths(read, [], 3.0), read)
    found = punch_depths(read, [(10.0, 5.0), (20.0, 1.0)], 3.0)
    assert found[1:] == pytest.approx([5.0, 11.0])
    assert np.all(np.diff(found) > 0.0)
