"""A sheet that carries no compression: taut, wrinkled, slack; and two directions that each obey their own law."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.materials import bind
from hyperfab.membrane.orthotropic import orthotropic_sheet
from hyperfab.membrane.tension_field import SLACK, TAUT, WRINKLED, IsotropicSheet

SOFT = bind("neo-hookean", {"C10_MPa": 0.1})
STIFF = bind("yeoh-3", {"C10_MPa": 0.18, "C20_MPa": 0.004, "C30_MPa": 0.0008})


def _tensor(l1, l2, angle=0.0):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    c = turn @ np.diag([l1**2, l2**2]) @ turn.T
    return np.array([[c[0, 0], c[1, 1], c[0, 1]]])


def test_taut_sheet_has_the_laws_own_stress():
    found = IsotropicSheet(STIFF)(_tensor(1.4, 1.2))
    expected = STIFF.membrane(1.4, 1.2)
    assert found.state[0] == TAUT
    np.testing.assert_allclose(found.stress[0], [expected.P1 / 1.4, expected.P2 / 1.2, 0.0], rtol=1e-13)
    assert found.energy[0] == pytest.approx(float(expected.W), rel=1e-14)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3])
def test_wrinkled_sheet_pulls_as_in_a_uniaxial_test(angle):
    found = IsotropicSheet(STIFF)(_tensor(1.5, 0.7, angle))
    single = STIFF.uniaxial(1.5)
    direction = np.array([np.cos(angle), np.sin(angle)])
    s = float(single.P) / 1.5
    assert found.state[0] == WRINKLED
    np.testing.assert_allclose(
        found.stress[0], [s * direction[0] ** 2, s * direction[1] ** 2, s * direction.prod()], atol=1e-14
    )
    assert found.energy[0] == pytest.approx(float(single.W), rel=1e-14)


def test_slack_sheet_has_no_stress_and_no_energy():
    found = IsotropicSheet(STIFF)(_tensor(0.99, 0.8))
    assert found.state[0] == SLACK
    assert found.energy[0] == 0.0
    assert not found.stress.any()


def test_energy_and_stress_are_continuous_where_wrinkles_begin():
    law = IsotropicSheet(STIFF)
    natural = 1.5**-0.5
    above, below = law(_tensor(1.5, natural + 1e-9)), law(_tensor(1.5, natural - 1e-9))
    assert (above.state[0], below.state[0]) == (TAUT, WRINKLED)
    np.testing.assert_allclose(above.stress, below.stress, atol=1e-8)
    assert above.energy[0] == pytest.approx(below.energy[0], abs=1e-9)


def test_stress_is_the_derivative_of_the_energy_in_every_state():
    law = IsotropicSheet(STIFF)
    for l1, l2 in ((1.4, 1.2), (1.3, 1.3), (1.5, 0.6), (0.9, 0.8)):
        strain = _tensor(l1, l2, 0.7)
        stress = law(strain).stress[0]
        for k, factor in enumerate((0.5, 0.5, 1.0)):
            step = np.zeros(3)
            step[k] = 1e-6
            slope = (law(strain + step).energy - law(strain - step).energy)[0] / 2e-6
            assert slope == pytest.approx(factor * stress[k], abs=1e-9)


@pytest.mark.parametrize(("warp", "weft"), [(STIFF, SOFT), (SOFT, STIFF)])
def test_each_direction_pulled_alone_answers_with_its_own_law(warp, weft):
    law = orthotropic_sheet(warp, weft)
    for stretch in (1.1, 1.6):
        for axis, own in ((0, warp), (1, weft)):
            natural = stretch**-0.5
            sides = (stretch, natural) if axis == 0 else (natural, stretch)
            stress = law(_tensor(*sides)).stress[0]
            assert stress[axis] * stretch == pytest.approx(float(own.uniaxial(stretch).P), rel=1e-12)
            assert stress[1 - axis] == pytest.approx(0.0, abs=1e-12)


def test_two_equal_directions_are_the_isotropic_sheet_bit_for_bit():
    strain = np.concatenate([_tensor(1.4, 1.1, 0.3), _tensor(1.5, 0.7, 1.0), _tensor(0.9, 0.8)])
    two, one = orthotropic_sheet(STIFF, STIFF), IsotropicSheet(STIFF)
    assert two(strain).stress.tobytes() == one(strain).stress.tobytes()
    assert two(strain).energy.tobytes() == one(strain).energy.tobytes()
    assert two.principal(strain).cauchy.tobytes() == one.principal(strain).cauchy.tobytes()


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_cauchy_stress_is_the_pull_over_the_deformed_section(angle):
    """Taut: force over the section as deformed; wrinkled: as in a uniaxial test, whose sides have contracted freely."""
    taut = IsotropicSheet(STIFF).principal(_tensor(1.4, 1.2, angle))
    own = STIFF.membrane(1.4, 1.2)
    np.testing.assert_allclose(taut.stretch[0], [1.4, 1.2], rtol=1e-12)
    # Incompressible: the section is 1/stretch of the undeformed one.
    np.testing.assert_allclose(taut.cauchy[0], [1.4 * float(own.P1), 1.2 * float(own.P2)], rtol=1e-12)
    assert taut.thickness[0] == pytest.approx(1.0 / (1.4 * 1.2), rel=1e-12)
    wrinkled = IsotropicSheet(STIFF).principal(_tensor(1.5, 0.7, angle))
    np.testing.assert_allclose(wrinkled.cauchy[0], [1.5 * float(STIFF.uniaxial(1.5).P), 0.0], rtol=1e-12)
    assert wrinkled.thickness[0] == pytest.approx(1.5**-0.5, rel=1e-12)
    slack = IsotropicSheet(STIFF).principal(_tensor(0.99, 0.8, angle))
    assert slack.thickness[0] == 1.0
    assert not slack.cauchy.any()


def test_cauchy_stress_of_a_wrinkled_foam():
    """Blatz and Ko's foam with nu = 1/4 contracts to l^-1/4 both ways: the section is l^-1/2 of what it was."""
    foam = bind("blatz-ko", {"mu_MPa": 0.3, "nu": 0.25, "f": 0.0})
    found = IsotropicSheet(foam).principal(_tensor(1.5, 0.7))
    # W = mu/2 (l1^-2 + l2^-2 + l3^-2 + 2 J - 5): dW/dl1 = mu (l2 l3 - l1^-3).
    pull = 0.3 * (1.5**-0.5 - 1.5**-3.0)
    assert float(foam.uniaxial(1.5).P) == pytest.approx(pull, rel=1e-12)
    assert found.cauchy[0, 0] == pytest.approx(pull * 1.5**0.5, rel=1e-12)
    assert found.thickness[0] == pytest.approx(1.5**-0.25, rel=1e-12)


def test_cauchy_stress_of_threads_is_that_of_the_law_along_them():
    """Pulled along the stiff threads, free to contract: the uniaxial stress of that law over the section it leaves."""
    law = orthotropic_sheet(STIFF, SOFT)
    found = law.principal(_tensor(1.5, 1.5**-0.5))
    assert found.cauchy[0, 0] == pytest.approx(1.5 * float(STIFF.uniaxial(1.5).P), rel=1e-12)
    assert found.cauchy[0, 1] == pytest.approx(0.0, abs=1e-12)
    # Both ways: the ground's, mixed by the other's share of the moduli, and what each law has beyond it in tension.
    both = law.principal(_tensor(1.4, 1.2))
    stiff, soft = (float(one.uniaxial(1.0 + 1e-4).A) for one in (STIFF, SOFT))
    share = soft / (stiff + soft)
    one, two = STIFF.membrane(1.4, 1.2), SOFT.membrane(1.4, 1.2)
    excess = [float(STIFF.uniaxial(s).P) - float(SOFT.uniaxial(s).P) for s in (1.4, 1.2)]
    warp = share * float(one.P1) + (1.0 - share) * float(two.P1) + (1.0 - share) * excess[0]
    weft = share * float(one.P2) + (1.0 - share) * float(two.P2) - share * excess[1]
    np.testing.assert_allclose(both.cauchy[0], [1.4 * warp, 1.2 * weft], rtol=1e-12)


@pytest.mark.parametrize("direction", ["warp", "weft"])
def test_a_law_moves_evenly_where_warp_and_weft_cross(direction):
    """A tenth of a percent in a constant moves stress and energy by little more, also where the stiffer changes."""
    stretches = np.concatenate([_tensor(1.6, 1.3, 0.4), _tensor(1.4, 1.4), _tensor(1.7, 0.8, 0.9), _tensor(1.9, 1.2)])
    other = bind("yeoh-2", {"C10_MPa": 0.05, "C20_MPa": 0.06})

    def answer(constant):
        own = bind("yeoh-2", {"C10_MPa": constant, "C20_MPa": 0.0})
        law = orthotropic_sheet(own, other) if direction == "warp" else orthotropic_sheet(other, own)
        found = law(stretches)
        return found.energy, found.stress

    before, after = answer(0.05 * 0.9995), answer(0.05 * 1.0005)
    assert np.abs(after[0] / before[0] - 1.0).max() < 1.5e-3
    assert np.abs(after[1] - before[1]).max() < 1.5e-3 * np.abs(before[1]).max()
