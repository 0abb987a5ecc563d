"""Specimens cut from a sheet of threads: the textbook's compliance, the free strip, and the symmetry of sheets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numba import typeof

from hyperfab.ahead import listed, written
from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials.effects import compressibility, rate, threads
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import BIAXIAL, GENERAL, MODE_NAMES, UNIAXIAL, uniaxial_pull
from hyperfab.materials.effects.threads import Threads, _knots, _piece, nearest_ground
from hyperfab.materials.orthotropic import Orthotropic, specimen
from hyperfab.materials.orthotropic.specimen import strip
from hyperfab.materials.registry import law

GROUND, WARP, WEFT, SHEAR = 0.05, 1.0, 0.4, 0.1
CONSTANTS = {
    "C10_MPa": GROUND,
    "k1_warp_MPa": WARP,
    "k1_weft_MPa": WEFT,
    "k2_warp": 2.0,
    "k2_weft": 2.0,
    "G_MPa": SHEAR,
}


def cut(angles: list[float], mode: int = UNIAXIAL, reach: float = 0.3, rows: int = 30) -> list[TestCurve]:
    lam = np.linspace(1.0, 1.0 + reach, rows)
    return [
        TestCurve(
            MODE_NAMES[mode],
            lam,
            lam,
            stretch2=lam if mode == GENERAL else None,
            direction=a,
            source=f"{a:g}",
        )
        for a in angles
    ]


def posed(tests: list[TestCurve], model: str = "neo-hookean", constants: tuple[float, ...] = (GROUND,)):
    return fabric_problem(law(model), constants, tests)


@pytest.mark.parametrize("angle", [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0])
def test_a_little_pull_meets_the_compliance_of_an_orthotropic_sheet(angle: float) -> None:
    """1/E = S11 c^4 + (2 S12 + S66) s^2 c^2 + S22 s^4 (Jones, Mechanics of Composite Materials, eq. 2.97)."""
    mu = 2.0 * GROUND
    stiffness = np.array([[4.0 * mu, 2.0 * mu, 0.0], [2.0 * mu, 4.0 * mu, 0.0], [0.0, 0.0, mu + SHEAR]])
    stiffness[0, 0] += 4.0 * WARP
    stiffness[1, 1] += 4.0 * WEFT
    S = np.linalg.inv(stiffness)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    modulus = 1.0 / (S[0, 0] * c**4 + (2.0 * S[0, 1] + S[2, 2]) * s**2 * c**2 + S[1, 1] * s**4)
    problem = posed(cut([angle], reach=1e-3, rows=3))
    found = Threads(problem.fabric.path).answer(CONSTANTS, problem.fabric.path.stretch, problem.fabric.path.across)[0]
    # Threads bear tension alone: a way that is not pulled answers by the ground.
    pulled = np.linalg.solve(stiffness, [c * c, s * s, s * c])[:2] > 0.0
    if not pulled.all():
        stiffness[0, 0] -= 0.0 if pulled[0] else 4.0 * WARP
        stiffness[1, 1] -= 0.0 if pulled[1] else 4.0 * WEFT
        S = np.linalg.inv(stiffness)
        modulus = 1.0 / (S[0, 0] * c**4 + (2.0 * S[0, 1] + S[2, 2]) * s**2 * c**2 + S[1, 1] * s**4)
    assert found[-1] / 1e-3 == pytest.approx(modulus, rel=5e-3)


@pytest.mark.parametrize("angle", [0.0, 22.0, 45.0, 90.0])
def test_between_the_knots_a_strip_answers_as_the_free_strip_does(angle: float) -> None:
    path = posed(cut([angle], reach=0.4)).fabric.path
    stress, energy, width = Threads(path).answer(CONSTANTS, path.stretch, path.across)
    exact = strip(Orthotropic.of(CONSTANTS), angle, path.stretch)
    assert stress == pytest.approx(exact.stress, abs=1e-4 * exact.stress.max())
    assert energy == pytest.approx(exact.answer.energy, abs=1e-4 * exact.answer.energy.max())
    assert width == pytest.approx(exact.width, abs=2e-4)


def test_a_strip_is_settled_by_the_kernel_of_the_build(monkeypatch: pytest.MonkeyPatch) -> None:
    # A test's stretches may not be written to; for such an array it would be compiled anew, in eight seconds.
    called, settle = [], specimen._settle
    monkeypatch.setattr(specimen, "_settle", lambda *of: called.append(of) or settle(*of))
    stretch = np.array([1.0, 1.1])
    stretch.flags.writeable = False
    for given in (stretch, [1.0, 1.1], np.linspace(1.0, 1.3, 4)[::2]):
        strip(Orthotropic.of(CONSTANTS), 22.0, given)
    kinds = [[written(typeof(one)) for one in of] for of in called]
    assert len(kinds) == 3
    assert [one for one in kinds if one not in listed()["hyperfab.materials.orthotropic.specimen._settle"]] == []


def test_strips_cut_at_several_angles_answer_as_each_does_alone() -> None:
    angles, reach = [0.0, 30.0, 90.0], 0.3
    together = posed(cut(angles, reach=reach)).fabric.path
    each = [posed(cut([angle], reach=reach)).fabric.path for angle in angles]
    found = np.stack(Threads(together).answer(CONSTANTS, together.stretch, together.across))
    alone = [np.stack(Threads(path).answer(CONSTANTS, path.stretch, path.across)) for path in each]
    assert np.array_equal(found, np.concatenate(alone, axis=1))


def test_a_stretch_that_is_a_knot_ends_its_piece() -> None:
    x = np.array([0.98, 0.99, 1.0, 1.2, 1.0, 1.1, 0.97])
    cut_at = np.array([0, 0, 0, 0, 1, 1, 1])
    knots = _knots(x, cut_at)
    inside = [np.searchsorted(knots[k], value) - 1 for k, value in zip(cut_at, x, strict=True)]
    assert _piece(knots[cut_at], x).tolist() == np.maximum(inside, 0).tolist()
    assert np.array_equal(knots[:, [0, 2, -1]], [[0.98, 1.0, 1.2], [0.97, 1.0, 1.1]])


def test_where_it_begins_does_not_change_an_equilibrium() -> None:
    path = posed(cut([0.0, 30.0, 60.0])).fabric.path
    used = Threads(path)
    used.answer({**CONSTANTS, "G_MPa": 0.5}, path.stretch, path.across)
    again, fresh = (one.answer(CONSTANTS, path.stretch, path.across)[0] for one in (used, Threads(path)))
    assert again == pytest.approx(fresh, rel=1e-9, abs=1e-12)


def counted(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> list[str]:
    """Return a list that grows by one with every call of a function."""
    inner, calls = getattr(module, name), []

    def of(*given: object, **named: object) -> object:
        calls.append(name)
        return inner(*given, **named)

    monkeypatch.setattr(module, name, of)
    return calls


def test_effects_that_an_equilibrium_does_not_depend_on_do_not_ask_for_it_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    strips, knots = (counted(monkeypatch, threads, name) for name in ("strip", "_knots"))
    lam = np.linspace(1.0, 1.3, 12)
    pull = replace(uniaxial_pull(lam, 30.0), time_s=np.linspace(0.0, 10.0, 12))

    def predicted(fabric: Fabric, stiffness: float, weight: float) -> np.ndarray:
        terms = {"anisotropy": ("threads", np.array([stiffness, WEFT, 2.0, SHEAR]))}
        terms["rate"] = ("prony-1", np.array([weight, 5.0]))
        own = np.array([GROUND])
        return np.stack([fabric.stress(own, None, terms), fabric.across(terms, own)])

    used = Fabric(law("neo-hookean"), pull)
    first = predicted(used, WARP, 0.1)
    other = predicted(used, WARP, 0.2)
    assert len(strips) == 1
    assert np.max(np.abs(other - first)[0]) > 1e-3
    stiffer = predicted(used, 1.1 * WARP, 0.2)
    assert len(strips) == 2
    assert len(knots) == 1
    # What is kept is not what comes of it: each answer is that of a fabric that was never asked before.
    for found, of in ((other, (WARP, 0.2)), (stiffer, (1.1 * WARP, 0.2)), (predicted(used, WARP, 0.1), (WARP, 0.1))):
        assert found == pytest.approx(predicted(Fabric(law("neo-hookean"), pull), *of), rel=1e-9)


def test_a_width_that_the_law_has_no_say_in_is_worked_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = counted(monkeypatch, compressibility, "through")
    pull = uniaxial_pull(np.linspace(1.0, 1.3, 12))

    def widths(fabric: Fabric, modulus: float, narrower: float = 0.0, play: float = 0.0) -> np.ndarray:
        terms = {"compressibility": ("width-smooth", np.array([0.3, 0.4 + narrower, 0.01, 0.02, 0.03]))}
        terms["grip-slack"] = ("play", np.array([play]))
        return fabric.across(terms, np.array([modulus]))

    used = Fabric(law("neo-hookean"), pull)
    assert np.array_equal(widths(used, 0.1), widths(used, 0.2))
    assert len(asked) == 1
    for moved in ({"narrower": 0.05}, {"play": 0.01}):
        assert np.max(np.abs(widths(used, 0.1, **moved) - widths(used, 0.1))) > 1e-3
        assert np.array_equal(widths(used, 0.1, **moved), widths(Fabric(law("neo-hookean"), pull), 0.1, **moved))


def test_a_spring_in_series_is_followed_once_where_law_and_modulus_move(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = counted(monkeypatch, rate, "_in_series")
    pull = replace(uniaxial_pull(np.linspace(1.0, 1.3, 12)), time_s=np.linspace(0.0, 10.0, 12))

    def stress(fabric: Fabric, ground: float, modulus: float, time_s: float = 4.0, play: float = 0.0) -> np.ndarray:
        terms = {"rate": ("finite", np.array([modulus, time_s])), "grip-slack": ("play", np.array([play]))}
        return fabric.stress(np.array([ground]), None, terms)

    used = Fabric(law("neo-hookean"), pull)
    elastic = used.stress(np.array([0.1]), None, {})
    once = stress(used, 0.1, 0.2) - elastic
    assert stress(used, 0.2, 0.4) - 2.0 * elastic == pytest.approx(2.0 * once, rel=1e-12)
    assert len(asked) == 1
    for moved in ({"time_s": 3.0}, {"play": 0.01}):
        found = stress(used, 0.1, 0.2, **moved)
        assert np.max(np.abs(found - elastic - once)) > 1e-3
        assert np.array_equal(found, stress(Fabric(law("neo-hookean"), pull), 0.1, 0.2, **moved))


@pytest.mark.parametrize("model", [("neo-hookean", (0.1,)), ("yeoh-3", (0.1, 0.02, 0.01))])
def test_a_sheet_stretched_alike_every_way_does_not_know_how_it_is_mounted(
    model: tuple[str, tuple[float, ...]],
) -> None:
    """At 45 degrees every direction carries the mean of warp and weft, whatever law the sheet has."""
    problem = posed(cut([0.0, 90.0, 45.0, 135.0, 30.0], GENERAL), *model)
    own = np.array([one.value for one in problem.own])
    forms = problem.effect("anisotropy").forms
    assert "threads" in [form.name for form in forms]
    for form in forms:
        for start in form.starts:
            terms = {"anisotropy": (form.name, np.array(start))}
            warp, weft, *turned = problem.predict(own, terms).reshape(5, -1)
            mean = 0.5 * (warp + weft)
            assert turned[0] == pytest.approx(mean, rel=1e-9), form.name
            assert turned[1] == pytest.approx(mean, rel=1e-9), form.name


def test_one_reading_of_an_equal_biaxial_test_is_the_mean_of_both_axes() -> None:
    two, one = (posed(cut([0.0, 90.0], GENERAL)), posed(cut([30.0], BIAXIAL)))
    both = (
        Threads(two.fabric.path)
        .answer(CONSTANTS, two.fabric.path.stretch, two.fabric.path.across)[0]
        .reshape(2, -1)
        .mean(axis=0)
    )
    assert Threads(one.fabric.path).answer(CONSTANTS, one.fabric.path.stretch, one.fabric.path.across)[
        0
    ] == pytest.approx(both, rel=1e-12)


@pytest.mark.parametrize("angle", [0.0, 90.0])
def test_a_pair_between_warp_and_weft_answers_along_both(angle: float) -> None:
    """Each of the pair at an angle b from the warp has I = warp² cos² b + weft² sin² b; it bears tension alone."""
    along = np.linspace(0.97, 1.3, 12)
    side = np.linspace(1.0, 1.15, 12)
    made = TestCurve("biaxial-general", along, along, stretch2=side, direction=angle, source="held")
    values = np.array([0.3, 0.2, 2.0, 1.0, 0.15, 3.0, 35.0])
    found = posed([made]).fabric.stress(np.array([GROUND]), None, {"anisotropy": ("bias-threads", values)})
    k_own, k2_own = (values[0], values[2]) if angle == 0.0 else (values[1], values[3])
    share = np.cos(np.radians(values[6])) ** 2 if angle == 0.0 else np.sin(np.radians(values[6])) ** 2
    wanted = 2.0 * GROUND * (along - 1.0 / (along**3 * side**2))
    for count, k1, k2, c in ((1.0, k_own, k2_own, 1.0), (2.0, values[4], values[5], share)):
        pulled = np.maximum(c * along**2 + (1.0 - c) * side**2 - 1.0, 0.0)
        wanted += count * 2.0 * along * c * k1 * pulled * np.exp(k2 * pulled**2)
    np.testing.assert_allclose(found, np.maximum(wanted, 0.0), rtol=1e-12)  # it hangs where it would push


@pytest.mark.parametrize(
    ("name", "constants"),
    [
        ("mooney-rivlin-2", (0.1, 0.02)),
        ("ogden-1", (0.3, 3.0)),
        ("ogden-2", (0.2, 2.0, 0.05, 4.0)),
        ("gent", (0.4, 9.0)),
    ],
)
def test_the_nearest_ground_answers_as_the_law_does(name: str, constants: tuple[float, ...]) -> None:
    own = dict(zip(law(name).names, constants, strict=True))
    near = nearest_ground(law(name), own, 0.8)
    pull = uniaxial_pull(np.linspace(1.0, 1.8, 40)[1:])
    wanted = Fabric(law(name), pull).stress(np.array(constants), None, {})
    ground = law("yeoh-3-lni2")
    found = Fabric(ground, pull).stress(np.array([near[one] for one in ground.names]), None, {})
    assert min(near.values()) >= 0.0
    assert found == pytest.approx(wanted, abs=0.01 * np.max(wanted))


def test_equal_biaxial_tests_read_along_both_axes_are_each_its_own() -> None:
    """Of one direction, or none, a reading is the mean of both axes: it does not say which arm it is of."""

    def answered(angles: list[float]) -> np.ndarray:
        path = posed(cut(angles, BIAXIAL)).fabric.path
        return Threads(path).answer(CONSTANTS, path.stretch, path.stretch)[0].reshape(len(angles), -1)

    both = posed(cut([0.0, 90.0], GENERAL)).fabric.path
    arms = Threads(both).answer(CONSTANTS, both.stretch, both.stretch)[0].reshape(2, -1)
    assert arms[0, -1] > 1.5 * arms[1, -1]
    np.testing.assert_allclose(answered([0.0, 90.0]), arms, rtol=1e-12)
    np.testing.assert_allclose(answered([0.0])[0], arms.mean(axis=0), rtol=1e-12)
    assert posed(cut([0.0, 90.0], BIAXIAL)).fabric.path.weft_share.reshape(2, -1)[:, -1].tolist() == [0.0, 1.0]
