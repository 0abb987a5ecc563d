"""Effects of a fabric: absent at their null, and what each does in a case worked by hand."""

from __future__ import annotations

import ast
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from loop.generators import fabric as truths
from sources import parsed

from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials import bind
from hyperfab.materials.effects import compressibility
from hyperfab.materials.effects.anisotropy import fibres
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import BIAXIAL, MODE_NAMES, SHEAR, UNIAXIAL, Path, uniaxial_pull
from hyperfab.materials.effects.permanent_set import second_network
from hyperfab.materials.effects.rate import flowing, relaxing, relaxing_measured, thinning
from hyperfab.materials.law import Sheet
from hyperfab.materials.registry import law

WARP = np.array([0.06, 0.02, 0.017])


def path_of(stretch: np.ndarray, rate: float = 0.01, temperature: float = 23.0, angle: float = 0.0) -> Path:
    time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stretch)))]) / rate
    n = len(stretch)
    return Path(
        starts=(0, n),
        mode=np.full(n, UNIAXIAL),
        stretch=stretch,
        across=np.full(n, np.nan),
        time_s=time,
        temperature_degC=np.full(n, temperature),
        angle_deg=np.full(n, angle),
        branch=np.zeros(n, dtype=np.int64),
    )


def cycles() -> np.ndarray:
    turns = [1.0, 1.3, 1.0, 1.3, 1.0, 1.6, 1.0]
    return np.concatenate([[1.0], *(np.linspace(a, b, 41)[1:] for a, b in pairwise(turns))])


def rich_problem():  # type: ignore[no-untyped-def]
    tests = []
    for number, (angle, temperature, mode) in enumerate([(0.0, 23.0, 0), (90.0, 23.0, 0), (0.0, 60.0, 1)]):
        lam = cycles()
        tests.append(
            TestCurve(
                MODE_NAMES[mode],
                lam,
                np.full_like(lam, 0.1),
                time_s=np.linspace(0.0, 100.0 / (1 + 9 * number), len(lam)),
                temperature_degC=np.full_like(lam, temperature),
                direction=angle,
                source=f"t{number}",
            )
        )
    return fabric_problem(law("yeoh-3"), WARP, tests)


def test_catalogue_has_every_id_of_a_fabric() -> None:
    assert sorted(effect.id for effect in rich_problem().effects) == sorted(truths.IDS)


@pytest.mark.parametrize("effect", [effect.id for effect in rich_problem().effects])
def test_null_leaves_the_prediction_as_it_is(effect: str) -> None:
    problem = rich_problem()
    entry = problem.effect(effect)
    plain = problem.predict(WARP, {})
    for form in entry.forms:
        with_null = problem.predict(WARP, {effect: (form.name, np.array(form.null))})
        assert np.array_equal(with_null, plain), form.name
        there = {effect: (form.name, np.array(form.starts[0]))}
        moved = problem.predict(WARP, there) - plain
        if form.name.startswith("width"):  # which is read beside the stresses
            assert not moved.any()
            moved = problem.fabric.across(there) - problem.fabric.across({})
        assert np.max(np.abs(moved)) > 1e-6, form.name


def test_without_terms_the_fabric_is_its_law_to_the_bit() -> None:
    lam = np.linspace(1.0, 1.8, 50)
    fabric = Fabric(law("yeoh-3"), path_of(lam))
    alone = bind("yeoh-3", {"C10_MPa": 0.06, "C20_MPa": 0.02, "C30_MPa": 0.017}).uniaxial(lam).P
    assert np.allclose(fabric.stress(WARP, None, {}), alone, rtol=1e-14)


def test_maxwell_branch_follows_the_convolution_integral() -> None:
    # A ramp of stress s t on a branch g, tau: g s tau (1 - exp(-t/tau)).
    lam = np.linspace(1.0, 1.5, 81)
    path = path_of(lam)
    found = relaxing(path, 2.0 * path.time_s, [0.3], [7.0])
    assert np.allclose(found, 0.3 * 2.0 * 7.0 * (1.0 - np.exp(-path.time_s / 7.0)), rtol=1e-12)


def test_thinning_dashpot_is_eyrings() -> None:
    # Held after a jump: q' = -(q0/tau) sinh(q/q0), integrated in small explicit steps.
    lam, time = np.array([1.3, 1.3, 1.3]), np.array([0.0, 2.0, 6.0])
    path = replace(path_of(lam), time_s=time)
    found = thinning(path, np.ones(3), 0.4, 5.0, 0.1)
    q, expected = float(found[0]), [float(found[0])]
    for step in (2.0, 4.0):
        for _ in range(20000):
            q -= step / 20000 * 0.1 / 5.0 * np.sinh(q / 0.1)
        expected.append(q)
    assert found == pytest.approx(expected, rel=1e-3)
    slow = thinning(path_of(cycles()), cycles() - 1.0, 0.3, 7.0, 1e3)
    assert slow == pytest.approx(relaxing(path_of(cycles()), cycles() - 1.0, [0.3], [7.0]), abs=2e-4)


def test_mullins_softens_only_below_the_largest_stretch() -> None:
    lam = cycles()
    fabric = Fabric(law("yeoh-3"), path_of(lam))
    plain = fabric.stress(WARP, None, {})
    soft = fabric.stress(WARP, None, {"mullins": ("pseudo-elastic", np.array([0.4, 0.01]))})
    virgin = lam >= np.maximum.accumulate(lam)
    assert np.array_equal(soft[virgin], plain[virgin])
    below = ~virgin & (lam > 1.01)
    assert np.all(soft[below] < plain[below])


def test_friction_encloses_a_loop_of_the_same_width_at_every_rate() -> None:
    widths = []
    for rate in (0.01, 1.0):
        lam = cycles()
        fabric = Fabric(law("yeoh-3"), path_of(lam, rate))
        stress = fabric.stress(WARP, None, {"hysteresis": ("friction", np.array([0.1, 0.05]))})
        widths.append(np.trapezoid(stress, lam))
    assert widths[0] == pytest.approx(widths[1], rel=1e-12)
    assert widths[0] > 0.0


def test_set_leaves_the_first_pull_and_slackens_the_second() -> None:
    lam = cycles()
    fabric = Fabric(law("yeoh-3"), path_of(lam))
    plain = fabric.stress(WARP, None, {})
    found = fabric.stress(WARP, None, {"permanent-set": ("returned", np.array([0.2]))})
    assert np.array_equal(found[:41], plain[:41])
    second = slice(81, 121)
    slack = lam[second] < 1.0 + 0.2 * 0.3 - 1e-9
    assert np.all(found[second][slack] == 0.0)


def test_weft_of_its_own_is_the_weft() -> None:
    lam = np.linspace(1.0, 1.6, 30)
    weft = 0.5 * WARP
    both = Fabric(law("yeoh-3"), path_of(lam, angle=90.0)).stress(WARP, weft, {})
    alone = Fabric(law("yeoh-3"), path_of(lam)).stress(weft, None, {})
    assert np.array_equal(both, alone)


def test_foam_of_one_term_is_told_exactly() -> None:
    # Blatz-Ko, f = 1: P = mu (l - l3^2 / l) with l3 = l^-nu in tension.
    lam = np.linspace(1.0, 2.0, 20)
    fabric = Fabric(law("neo-hookean"), path_of(lam))
    terms = {"compressibility": ("uniform", np.array([0.3]))}
    assert np.allclose(fabric.stress(np.array([0.2]), None, terms), 0.4 * (lam - lam**-1.6), rtol=1e-12)
    assert np.allclose(fabric.across(terms), lam**-0.3, rtol=1e-14)


def test_a_dashpot_of_power_one_is_maxwells_and_one_of_power_three_flows_as_norton_says() -> None:
    stretch = np.concatenate([np.linspace(1.0, 1.4, 2001), np.full(2000, 1.4)])
    path = replace(path_of(stretch), time_s=np.linspace(0.0, 80.0, len(stretch)))
    stress = stretch - 1.0
    linear = flowing(path, stress, 0.7, 5.0, 1.0, 1.0)
    assert linear == pytest.approx(relaxing(path, stress, [0.7], [5.0]), abs=1e-4)
    held = flowing(path, stress, 0.7, 5.0, 3.0, 0.1)[2001:]
    # dq/dt = -q^3/(tau size^2): 1/q^2 grows by 2 t/(tau size^2).
    time = path.time_s[2001:] - path.time_s[2001]
    assert 1.0 / held**2 == pytest.approx(1.0 / held[0] ** 2 + 2.0 * time / (5.0 * 0.01), rel=1e-6)


def test_memory_of_true_stress_relaxes_in_true_stress() -> None:
    path = path_of(cycles())
    stress = cycles() - 1.0
    found = relaxing_measured(path, stress, [0.5], [7.0], 1.0)
    assert found * cycles() == pytest.approx(relaxing(path, stress * cycles(), [0.5], [7.0]), abs=1e-14)


def test_fibres_along_the_pull_add_the_slope_of_their_energy() -> None:
    stretch = np.linspace(1.0, 1.5, 501)
    for angle, warp, weft in ((0.0, 0.3, 0.0), (90.0, 0.0, 0.3)):
        stress, energy = fibres(uniaxial_pull(stretch, angle), stretch, warp, weft, 0.8)
        assert np.gradient(energy, stretch)[1:-1] == pytest.approx(stress[1:-1], rel=2e-3, abs=1e-5)
        assert np.any(stress > 0.0)
        across, _ = fibres(uniaxial_pull(stretch, 90.0 - angle), stretch, warp, weft, 0.8)
        assert not np.any(across)


def test_a_second_network_leaves_a_set_where_both_balance() -> None:
    stretch = np.linspace(1.0, 1.5, 5001)
    law_of = law("neo-hookean")
    fabric = Fabric(law_of, uniaxial_pull(stretch))
    first = fabric.stress(np.array([0.2]), None, {})
    second = Fabric(law_of, uniaxial_pull(stretch / 1.5)).stress(np.array([0.2]), None, {})
    found = second_network(first, second, np.full_like(stretch, 1.5), 0.1)
    at = int(np.argmax(found > 0.0))
    x = stretch[at]
    balance = 0.9 * (x - x**-2.0) + 0.1 * (x / 1.5 - (x / 1.5) ** -2.0) / 1.5
    assert balance == pytest.approx(0.0, abs=1e-3)
    assert not np.any(found[:at])


@pytest.mark.parametrize("nu", [0.2, 0.4, 0.49])
@pytest.mark.parametrize("mode", [UNIAXIAL, SHEAR, BIAXIAL])
def test_energy_of_shape_and_volume_leaves_no_stress_across(mode: int, nu: float) -> None:
    """Stresses by differences of the energy itself, neo-Hookean, at the stretches the volume gives."""
    G, K = 1.0, 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))

    def energy(l1: float, l2: float, l3: float) -> float:
        J = l1 * l2 * l3
        return 0.5 * G * (J ** (-2 / 3) * (l1**2 + l2**2 + l3**2) - 3.0) + 0.5 * K * (J - 1.0) ** 2

    def stress(state: list[float], along: int) -> float:
        up, down = list(state), list(state)
        up[along] += 1e-6
        down[along] -= 1e-6
        return (energy(*up) - energy(*down)) / 2e-6

    stretch, kind, none = np.array([1.6]), np.array([mode]), np.array([np.nan])
    J = compressibility.volume(kind, stretch, none, nu)
    side = float(np.sqrt(J[0] / 1.6)) if mode == UNIAXIAL else 1.0 if mode == SHEAR else 1.6
    state = [1.6, side, float(J[0]) / (1.6 * side)]
    assert stress(state, 2) == pytest.approx(0.0, abs=1e-8)
    first, second = compressibility.of_shape(kind, stretch, none, J)
    there = Sheet.of(first, second)
    term = law("neo-hookean").terms(there, [])[0]
    told = 0.5 * G * term.stress(there) / np.cbrt(J)
    assert float(told[0]) == pytest.approx(stress(state, 0), rel=1e-6)


def _asks_a_name(node: ast.AST) -> bool:
    """Whether code goes one way or another by the name of a form."""

    def is_form(one: ast.AST) -> bool:
        key = one.slice if isinstance(one, ast.Subscript) else None
        return (
            (isinstance(one, ast.Name) and one.id.endswith("form"))
            or (isinstance(one, ast.Attribute) and one.attr == "form")
            or (isinstance(key, ast.Constant) and key.value == "form")
        )

    if isinstance(node, ast.Compare):
        texts = [one for one in ast.walk(node) if isinstance(one, ast.Constant) and one.value and one.value != "form"]
        return is_form(node.left) and any(isinstance(one.value, str) for one in texts)
    call = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    return call and node.func.attr in ("startswith", "endswith", "split") and is_form(node.func.value)


def test_no_form_is_told_by_its_name() -> None:
    found = []
    for file, tree in parsed().items():
        found += [f"{file.name}:{node.lineno}" for node in ast.walk(tree) if _asks_a_name(node)]
    assert found == []
