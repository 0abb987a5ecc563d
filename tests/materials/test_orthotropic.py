"""The orthotropic law: exact states of its specimens, its symmetries, and its constants from tests."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import ABSENT, LINEAR, NAMES, Orthotropic
from hyperfab.materials.orthotropic.determined import sought_by
from hyperfab.materials.orthotropic.identify import identify
from hyperfab.materials.orthotropic.specimen import held, stable_range, strip

KNIT = {
    "C10_MPa": 0.1, "C20_MPa": 0.03, "C30_MPa": 0.01, "C2_MPa": 0.02, "k1_warp_MPa": 0.2, "k1_weft_MPa": 0.1,
    "k1_bias_MPa": 0.15, "G_MPa": 0.3, "nu": 0.3, "k2_warp": 0.5, "k2_weft": 0.2, "k2_bias": 0.7, "bias_deg": 35.0,
}  # fmt: skip
LAM = np.linspace(1.03, 1.6, 12)


def _pulls(law: Orthotropic, angle: float, width: bool = False) -> TestCurve:
    found = strip(law, angle, LAM)
    lateral = (found.width, None, np.full(len(LAM), 5.0)) if width else (None, None, None)
    return TestCurve("uniaxial", LAM, found.stress, 1.0 / found.stress, *lateral, direction=angle)


def _held(law: Orthotropic, mode: str, across: np.ndarray) -> TestCurve:
    one, two, _ = held(law, 0.0, LAM, across)
    both = (across, two, 1.0 / two) if mode == "biaxial" else (None, None, None)
    return TestCurve(mode, LAM, one, 1.0 / one, *both, direction=0.0)


def test_without_threads_it_is_the_isotropic_law():
    constants = {"C10_MPa": 0.1, "C20_MPa": 0.02, "C30_MPa": 0.004, "C2_MPa": 0.05}
    isotropic, own = bind("yeoh-3-lni2", constants), Orthotropic.of(constants)
    for angle in (0.0, 30.0, 90.0):
        np.testing.assert_allclose(strip(own, angle, LAM).stress, isotropic.uniaxial(LAM).P, rtol=1e-11)
        np.testing.assert_allclose(strip(own, angle, LAM).width, LAM**-0.5, rtol=1e-11)
        one, two, _ = held(own, angle, LAM, np.full_like(LAM, 1.2))
        plane = isotropic.membrane(LAM, 1.2)
        np.testing.assert_allclose(one, plane.P1, rtol=1e-11)
        np.testing.assert_allclose(two, plane.P2, rtol=1e-11)


def test_a_ground_contracts_by_its_ratio():
    law = Orthotropic.of({"C10_MPa": 0.1, "C20_MPa": 0.02, "nu": 0.2})
    np.testing.assert_allclose(strip(law, 15.0, LAM).width, LAM**-0.2, rtol=1e-11)


def test_an_equal_biaxial_square_at_45_degrees_carries_the_mean_of_warp_and_weft():
    law = Orthotropic.of(KNIT)
    warp, weft, _ = held(law, 0.0, LAM, LAM)
    one, two, _ = held(law, 45.0, LAM, LAM)
    np.testing.assert_allclose(one, 0.5 * (warp + weft), rtol=1e-12)
    np.testing.assert_allclose(two, 0.5 * (warp + weft), rtol=1e-12)


def test_a_strip_is_free_at_its_edges_and_shears_where_it_is_cut_at_an_angle():
    """The strip's energy is least over its width and shear: against a search that knows only the energy."""
    law = Orthotropic.of(KNIT)
    found = strip(law, 30.0, [1.4])
    angle = np.deg2rad(30.0)
    t, n = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])

    def energy(width: float, shear: float) -> float:
        C = 1.96 * np.outer(t, t) + width * np.outer(n, n) + shear * (np.outer(t, n) + np.outer(n, t))
        return float(law.answer([[C[0, 0], C[1, 1], C[0, 1]]]).energy[0])

    width, shear = found.width[0] ** 2, found.shear[0] * 1.4 * found.width[0]
    assert abs(shear) > 0.05
    least = energy(width, shear)
    for dw, ds in ((1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3), (1e-3, 1e-3), (-1e-3, 1e-3)):
        assert energy(width + dw, shear + ds) > least
    # dW/dstretch along the path of least energy is the nominal stress.
    more, less = (strip(law, 30.0, [1.4 + d]).answer.energy[0] for d in (1e-5, -1e-5))
    assert (more - less) / 2e-5 == pytest.approx(found.stress[0], rel=1e-8)


def test_quarter_turn_mirror_and_scale():
    law = Orthotropic.of(KNIT)
    turned = law.turned()
    for angle in (0.0, 20.0, 45.0):
        own = strip(law, angle, LAM)
        np.testing.assert_allclose(strip(turned, angle + 90.0, LAM).stress, own.stress, rtol=1e-10)
        mirrored = strip(law, -angle, LAM)
        np.testing.assert_allclose(mirrored.stress, own.stress, rtol=1e-10)
        np.testing.assert_allclose(mirrored.shear, -own.shear, atol=1e-11)
        np.testing.assert_allclose(strip(law.scaled(10.0), angle, LAM).stress, 10.0 * own.stress, rtol=1e-10)


@pytest.mark.parametrize(
    "weft", [{}, {"k1_weft_MPa": KNIT["k1_warp_MPa"], "k2_weft": KNIT["k2_warp"]}], ids=["knit", "even"]
)
@pytest.mark.parametrize("name", NAMES)
def test_the_law_moves_evenly_with_each_constant(name, weft):
    """Also where warp and weft are equal, and one becomes the stiffer."""
    constants = {**KNIT, **weft}
    law = Orthotropic.of(constants)
    for factor in (0.999, 1.001):
        moved = Orthotropic.of({**constants, name: constants[name] * factor})
        for angle in (0.0, 30.0, 45.0, 90.0):
            own = strip(law, angle, LAM).stress
            assert np.abs(strip(moved, angle, LAM).stress / own - 1.0).max() < 3e-3
            for one, other in zip(held(moved, angle, LAM, LAM)[:2], held(law, angle, LAM, LAM)[:2], strict=True):
                assert np.abs(one / other - 1.0).max() < 3e-3


@pytest.mark.parametrize(
    ("name", "value", "word"),
    [
        ("C10_MPa", -0.1, "below zero"),
        ("nu", 0.6, "0 to 0.5"),
        ("bias_deg", 91.0, "0 to 90"),
        ("k3", 1.0, "no constant"),
    ],
)
def test_constants_without_meaning_are_refused(name, value, word):
    with pytest.raises(InputError, match=word):
        Orthotropic.of({**KNIT, name: value})


def test_it_finds_its_own_constants():
    law = Orthotropic.of(KNIT)
    tests = [
        _pulls(law, 0.0, width=True),
        _pulls(law, 90.0, width=True),
        _pulls(law, 45.0),
        _pulls(law, 22.5),
    ]
    tests += [_held(law, "biaxial", LAM), _held(law, "shear", np.ones_like(LAM))]
    found = identify(tests)
    assert not found.unknown
    for name in NAMES:
        assert found.law.parameters[name] == pytest.approx(KNIT[name], rel=1e-6)


def test_readings_of_an_isotropic_sheet_with_eight_digits_have_its_law_and_no_more():
    """What a constant would gain below the rounding of a file is not worth its name: the law can then be exported."""
    law = Orthotropic.of({"C10_MPa": 0.2})
    tests = [_pulls(law, angle, width=angle == 0.0) for angle in (0.0, 90.0, 45.0)]
    tests.append(_held(law, "biaxial", LAM))
    rounded = [
        dataclasses.replace(
            test, stress=np.array([float(f"{value:.7e}") for value in test.stress]),
        )
        for test in tests
    ]  # fmt: skip
    found = identify(rounded).law.parameters
    assert found["C10_MPa"] == pytest.approx(0.2, rel=1e-7)
    assert {name: found[name] for name in (*LINEAR[1:], "nu")} == dict.fromkeys(LINEAR[1:], 0.0) | {"nu": 0.5}


def test_constants_at_the_end_of_their_range_are_not_in_how_sure_the_others_are():
    law = Orthotropic.of({"C10_MPa": 0.2, "C2_MPa": 0.05})
    tests = [_pulls(law, 0.0, width=True), _held(law, "shear", np.ones_like(LAM))]
    found = identify(tests)
    held = found.sought.index("nu")
    assert found.law.parameters["nu"] == 0.5
    assert not found.optimum.jacobian[:, held].any()
    assert found.optimum.jacobian[:, found.sought.index("C2_MPa")].any()


def test_what_the_tests_leave_open_is_named_and_absent():
    law = Orthotropic.of({"C10_MPa": 0.1, "k1_warp_MPa": 0.2, "k2_warp": 0.5})
    tests = [_pulls(law, 0.0), _pulls(law, 90.0)]
    sought, unknown = sought_by(tests)
    assert {"C10_MPa", "k1_warp_MPa", "k1_weft_MPa"} <= set(sought)
    assert {one.name for one in unknown} == {"C2_MPa", "nu", "k1_bias_MPa", "k2_bias", "bias_deg", "G_MPa"}
    found = identify(tests).law.parameters
    for one in unknown:
        assert found[one.name] == ABSENT[one.name]
        assert one.test


#: Sheets of stiff threads along warp and weft: one whose angle resists, and one of inclined threads.
SHEETS = {
    "shear": {"C10_MPa": 0.05, "k1_warp_MPa": 2.0, "k1_weft_MPa": 5.0, "G_MPa": 0.9},
    "threads": {"C10_MPa": 0.06, "k1_warp_MPa": 2.0, "k1_weft_MPa": 5.0, "k1_bias_MPa": 0.8},
}


def _softening(angle: float, sheet: str = "shear") -> TestCurve:
    """A strip that softens as it is pulled, which no term of the law does: what is missed must not turn the threads."""
    stretch = np.linspace(1.001, 1.04, 20)
    stress = strip(Orthotropic.of(SHEETS[sheet]), angle, stretch).stress * (1.0 - 2.0 * (stretch - 1.0))
    weight = 1.0 / np.maximum(stress, 0.1 * stress.max())
    return TestCurve("uniaxial", stretch, stress, weight, direction=angle)


@pytest.mark.parametrize("sheet", list(SHEETS))
@pytest.mark.parametrize("slanted", [(15.0, 45.0), (45.0, 60.0), (45.0, 75.0)])
def test_a_second_slanted_test_leaves_the_other_angles_where_they_are(slanted, sheet):
    """Inclined threads must not stand in for those of warp or weft: that is right where it was fitted alone."""
    found = identify([_softening(angle, sheet) for angle in (0.0, *slanted, 90.0)])
    for angle in (15.0, 30.0, 60.0, 75.0):
        own = _softening(angle, sheet)
        one = strip(found.law, angle, own.stretch[14:15]).stress[0]
        assert one == pytest.approx(own.stress[14], rel=0.15)


@pytest.mark.parametrize(
    "slanted",
    [
        (15, 45),
        (45, 75),
        (30, 45, 60),
        *(pytest.param(angles, marks=pytest.mark.slow) for angles in ((30, 45), (45, 60), (15, 45, 75))),
    ],
)
def test_a_laminate_cut_at_two_slanted_angles_tells_the_others(data_dir, slanted):
    """Stiffness at 3 % of a coated nylon: within 18 % at every angle; three angles between, within 15 %."""

    def read(angle: int) -> TestCurve:
        lines = (data_dir / "nylon-laminate" / f"uniaxial-{angle}.csv").read_text().splitlines()
        rows = np.array([[float(v) for v in line.split(",")] for line in lines if line[0].isdigit()])
        rows = rows[rows[:, 0] > 0.0]
        stress = rows[:, 1] / 75.0
        return TestCurve("uniaxial", 1.0 + rows[:, 0] / 97.0, stress,
                         1.0 / np.maximum(stress, 0.1 * stress.max()), direction=float(angle))  # fmt: skip

    found = identify([read(angle) for angle in (0, *slanted, 90)])
    for angle in {15, 30, 60, 75} - set(slanted):
        own = read(angle)
        ratio = strip(found.law, float(angle), [1.03]).stress[0] / np.interp(1.03, own.stretch, own.stress)
        assert ratio == pytest.approx(1.0, abs=0.18 if len(slanted) == 2 else 0.155)


def test_strips_on_both_sides_of_45_degrees_tell_warp_and_weft():
    """Without one along them: what a strip at 30 and one at 60 degrees say is not taken for a sheet alike both ways."""
    law = Orthotropic.of({"C10_MPa": 0.05, "k1_warp_MPa": 0.2, "k2_warp": 0.1, "k1_weft_MPa": 0.05, "k2_weft": 0.1})
    found = identify([_pulls(law, 30.0), _pulls(law, 60.0)])
    assert {"k1_warp_MPa", "k1_weft_MPa"} <= set(found.sought)
    assert "G_MPa" in {one.name for one in found.unknown}
    assert "G_MPa" in sought_by([_pulls(law, angle) for angle in (30.0, 45.0, 60.0)])[0]
    for angle in (0.0, 45.0, 90.0):
        own = strip(law, angle, LAM).stress
        assert np.abs(strip(found.law, angle, LAM).stress / own - 1.0).max() < 0.05


def test_a_single_slanted_strip_tells_one_stiffness_that_of_the_ground():
    """Its angle's resistance as well would take all of it, and the grips of a short strip what is left."""
    law = Orthotropic.of({"C10_MPa": 0.05})
    pull = dataclasses.replace(_pulls(law, 45.0), aspect=1.3)
    found = identify([pull])
    assert "G_MPa" not in found.sought
    assert {one.name: one.test for one in found.unknown}["G_MPa"] == "a uniaxial test along warp or weft"
    assert found.law.parameters["C10_MPa"] == pytest.approx(0.05, rel=0.1)
    assert "G_MPa" in sought_by([_pulls(law, 0.0), _pulls(law, 45.0)])[0]


def test_biaxial_tests_at_several_ratios_tell_the_contraction_and_the_second_invariant():
    law = Orthotropic.of({**KNIT, "k1_bias_MPa": 0.0, "G_MPa": 0.0})
    tests = []
    for ratio in (0.0, 0.5, 1.0):
        for one, other in {(1.0, ratio), (ratio, 1.0)}:
            first, second = 1.0 + one * (LAM - 1.0), 1.0 + other * (LAM - 1.0)
            along, across, _ = held(law, 0.0, first, second)
            peak = np.maximum(along, across)
            tests.append(
                TestCurve("biaxial-general", first, along, 1.0 / peak, second, across, 1.0 / peak, direction=0.0)
            )
    sought, unknown = sought_by(tests)
    assert {"nu", "C2_MPa"} <= set(sought)
    assert {one.name for one in unknown} == {"G_MPa"}
    found = identify(tests).law
    for angle in (0.0, 90.0):
        own = strip(law, angle, LAM)
        np.testing.assert_allclose(strip(found, angle, LAM).stress, own.stress, rtol=1e-3)
        np.testing.assert_allclose(strip(found, angle, LAM).width, own.width, rtol=1e-3)


def test_a_steep_warp_beside_a_weft_that_stretches_far_is_found():
    """How steep threads may grow went by the farthest stretch of any: most of the warp's stress was missed."""
    law = Orthotropic.of({"C10_MPa": 0.05, "k1_warp_MPa": 0.04, "k2_warp": 4.0})
    far = np.linspace(1.1, 3.2, 20)
    weft = strip(law, 90.0, far).stress
    found = identify([_pulls(law, 0.0), TestCurve("uniaxial", far, weft, 1.0 / weft, direction=90.0)])
    assert found.sse < 1e-12
    assert found.law.parameters["k2_warp"] == pytest.approx(4.0, rel=1e-6)


def test_biaxial_pulls_that_draw_the_warp_in_tell_inclined_threads_and_none_along_it():
    """Pulls at five ratios counted as one kind, and threads that nothing pulls had 1e6 MPa."""
    law = Orthotropic.of({"C10_MPa": 0.02, "k1_bias_MPa": 0.05, "k2_bias": 2.0, "bias_deg": 20.0})
    weft, tests = np.linspace(1.05, 3.2, 15), []
    for drawn in (0.45, 0.6, 0.75, 0.9):
        warp = np.linspace(0.99, drawn, 15)
        one, two, _ = held(law, 0.0, warp, weft)
        even = np.full(15, 1.0 / two.max())
        tests.append(TestCurve("biaxial-general", warp, one, even, weft, two, even, direction=0.0))
    found = identify(tests)
    assert {one.name for one in found.unknown} == {"k1_warp_MPa", "k2_warp", "G_MPa"}
    assert found.law.parameters["k1_warp_MPa"] == 0.0
    assert found.law.parameters["bias_deg"] == pytest.approx(20.0, abs=1e-3)


def test_pulls_of_a_weft_that_stretches_far_more_than_the_warp_are_of_several_ratios():
    """Strains of 0.2 along the warp beside 1.6 along the weft counted as planar shear all, and told no coupling."""
    law = Orthotropic.of({**KNIT, "k1_bias_MPa": 0.0, "G_MPa": 0.0})
    tests = []
    for one, other in ((1.0, 1.0), (1.0, 0.5), (0.5, 1.0)):
        warp, weft = 1.0 + one * (LAM - 1.0) / 3.0, 1.0 + other * (LAM - 1.0) * 2.7
        along, across, _ = held(law, 0.0, warp, weft)
        even = 1.0 / np.maximum(along, across)
        tests.append(TestCurve("biaxial-general", warp, along, even, weft, across, even, direction=0.0))
    assert {one.name for one in sought_by(tests)[1]} == {"G_MPa"}
    assert identify(tests).sse < 1e-12


def test_one_slanted_angle_says_nothing_of_inclined_threads():
    def pulls(*angles: float) -> set[str]:
        return {one.name for one in sought_by([_softening(angle) for angle in angles])[1]}

    assert {"k1_bias_MPa", "k2_bias", "bias_deg"} <= pulls(0.0, 45.0, 90.0)
    # A mirror image is no other angle.
    assert {"k1_bias_MPa", "bias_deg"} <= pulls(0.0, 30.0, 150.0, 90.0)
    assert pulls(0.0, 30.0, 45.0, 90.0) & {"k1_bias_MPa", "bias_deg"} == {"bias_deg"}
    assert "bias_deg" not in pulls(0.0, 15.0, 30.0, 60.0, 75.0, 90.0)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("name", LINEAR)
def test_stress_and_stiffness_are_the_derivatives_of_the_energy_of_each_constant(name, nu):
    """S = 2 dW/dC and its derivative by C11, C22, C12, in a stretched and sheared state, by finite differences."""
    law = Orthotropic.of({**KNIT, "nu": nu})
    alone = Orthotropic({**law.parameters, **dict.fromkeys(LINEAR, 0.0), name: 1.0})
    C, h = np.array([[1.7, 1.2, 0.35], [1.3, 2.1, -0.4]]), 1e-5
    own = alone.answer(C)
    np.testing.assert_allclose(law.stress_terms(C)[:, LINEAR.index(name)], own.stress, rtol=1e-13, atol=1e-15)
    for j in range(3):
        moved = h * np.eye(3)[j]
        more, less = alone.answer(C + moved), alone.answer(C - moved)
        twice = 1.0 if j == 2 else 2.0  # C12 stands in C twice
        slope = twice * (more.energy - less.energy) / (2 * h)
        np.testing.assert_allclose(slope, own.stress[:, j], rtol=1e-8, atol=1e-8)
        slope = twice * (more.stress - less.stress) / (2 * h)
        np.testing.assert_allclose(slope, own.stiffness[:, :, j], rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("mode", ["uniaxial", "shear", "biaxial"])
def test_where_a_sheet_is_stable_hangs_neither_on_its_unit_of_stress_nor_on_its_angle(mode):
    ground = Orthotropic.of({"C10_MPa": 0.2, "C20_MPa": 0.01})
    for factor in (1e-4, 1.0, 1e4):
        for angle in (0.0, 30.0):
            assert stable_range(ground.scaled(factor), mode, angle, 3.0) == (1.0, 3.0, "scan")
