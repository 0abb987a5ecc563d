"""Made-up foams, pressed and pulled, by formulas of their own: what they have beyond their law is named."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.special import erf

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fabric_tests import path_of
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import MODE_NAMES
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.registry import law_of

MU, ALPHA, NU = 0.05, 5.0, 0.2
GIVEN = {"mu1_MPa": 0.04, "alpha1": 6.0, "nu1": 0.25}
NOISE = 0.0005


def pressed(stretch: Array) -> Array:
    """The closed form of one term: sides of stretch^-nu."""
    return 2.0 * MU / ALPHA * (stretch ** (ALPHA - 1.0) - stretch ** (-NU * ALPHA - 1.0))


def energy(stretch: Array) -> Array:
    """The work to a stretch on a fine way, by the trapezium rule."""
    way = np.linspace(1.0, stretch.min(), 4001)
    stress = pressed(way)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (stress[1:] + stress[:-1]) * np.diff(way))])
    return np.interp(stretch, way[::-1], work[::-1])


def cycles(points: int = 30) -> Array:
    """Twice to a stretch of 0.75, twice to 0.55, and back."""
    ways = [np.linspace(1.0, low, points) for low in (0.75, 0.75, 0.55, 0.55)]
    return np.concatenate([part for way in ways for part in (way, way[-2::-1])])


Makes = Callable[[Array, Array, float], Array]


def specimens(makes: Makes) -> list[TestCurve]:
    """Cycles of compression at two rates and two temperatures, each with a replicate, and the stretch across."""
    random = np.random.default_rng(4)
    stretch, found = cycles(), []
    for number, (rate, degrees) in enumerate([(0.01, 23.0), (0.01, 23.0), (0.2, 23.0), (0.2, 23.0), (0.01, 80.0)]):
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stretch)) / rate)])
        stress = makes(stretch, time, degrees)
        found.append(
            TestCurve(
                "uniaxial", stretch, stress + random.normal(0.0, NOISE, len(stretch)), source=f"{number}",
                specimen=f"{number}", time_s=time, temperature_degC=np.full_like(stretch, degrees),
                stretch2=stretch**-NU + random.normal(0.0, 0.001, len(stretch)) if number == 0 else None,
            )
        )  # fmt: skip
    return found


def relaxing(stretch: Array, time: Array, degrees: float) -> Array:
    """A Maxwell branch of 0.4 of the stress and 10 s, integrated by small steps."""
    fine = np.linspace(0.0, time[-1], 40001)
    load = pressed(np.interp(fine, time, stretch))
    branch, keep = np.zeros_like(fine), np.exp(-(fine[1] - fine[0]) / 10.0)
    for k in range(1, len(fine)):
        branch[k] = keep * branch[k - 1] + 0.4 * np.sqrt(keep) * (load[k] - load[k - 1])
    return pressed(stretch) + np.interp(time, fine, branch)


def worn(stretch: Array, time: Array, degrees: float) -> Array:
    W = energy(stretch)
    return pressed(stretch) * (1.0 - 0.35 * erf((np.maximum.accumulate(W) - W) / 0.003))


def rubbing(stretch: Array, time: Array, degrees: float) -> Array:
    """Dry friction of a sixth of the load, against the way the specimen is led, turned over a strain of 0.02."""
    load, slides = pressed(stretch), np.zeros_like(stretch)
    for k in range(1, len(stretch)):
        step = stretch[k] - stretch[k - 1]
        aim = np.sign(step) * abs(load[k]) / 6.0
        slides[k] = aim + (slides[k - 1] - aim) * np.exp(-abs(np.log(stretch[k] / stretch[k - 1])) / 0.02)
    return load + slides


TRUTHS: dict[str, Makes] = {
    "": lambda stretch, time, degrees: pressed(stretch),
    "rate": relaxing,
    "thermal-softening": lambda stretch, time, degrees: pressed(stretch) * np.exp(-0.006 * (degrees - 23.0)),
    "mullins": worn,
    "hysteresis": rubbing,
}


def closed(makes: Makes) -> tuple[FabricProblem, Finding]:
    law = law_of("hyperfoam-1", GIVEN, foam=True)
    problem = fabric_problem(law, [GIVEN[name] for name in law.names], specimens(makes))
    return problem, close(problem, design=False)


SLOW = ("mullins", "hysteresis", "thermal-softening")


@pytest.mark.parametrize("effect", [pytest.param(one, marks=pytest.mark.slow if one in SLOW else ()) for one in TRUTHS])
def test_what_a_pressed_foam_has_is_named(effect: str) -> None:
    problem, found = closed(TRUTHS[effect])
    assert list(found.after.ids) == ([effect] if effect else [])
    assert found.after.judgement.is_small
    warp, _, _ = problem.of_own(np.asarray(found.after.fit.x[:3]))
    np.testing.assert_allclose(warp, (MU, ALPHA, NU), rtol=0.1)


def test_a_foam_with_a_term_added_is_that_of_one_term_more() -> None:
    """In every kind of test, and across the pull: what the document then has is what was foretold."""
    law = Hyperfoam((0.05, 0.02), (5.0, -2.0), (0.2, 0.35))
    way = np.linspace(0.6, 1.4, 9)
    tests = [
        TestCurve(mode, way - 1.0 if mode == "simple-shear" else way, 0.0 * way, stretch2=0.5 * (way + 1.0))
        for mode in MODE_NAMES
    ]
    path, _ = path_of(tests)
    one, term = np.array([0.05, 5.0, 0.2]), {"elastic-law": ("term-2", np.array([0.02, -2.0, 0.35]))}
    fabric = Fabric(law_of("hyperfoam-1", GIVEN, foam=True), path)
    expected = [law.stress(one.mode, one.stretch, one.stretch2) for one in tests]
    np.testing.assert_allclose(fabric.stress(one, None, term), np.concatenate(expected), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(fabric.across(term, one)[:9], law.lateral("uniaxial", way), rtol=1e-12)
    nothing = {"elastic-law": ("term-2", np.array([0.0, -2.0, 0.35]))}
    assert np.array_equal(fabric.stress(one, None, nothing), fabric.stress(one, None, {}))


def test_a_compressible_law_of_a_sheet_contracts_by_its_own_ratio() -> None:
    given = {"mu_MPa": 0.4, "f": 0.3, "nu": 0.3}
    way = np.linspace(0.6, 1.4, 9)
    path, _ = path_of([TestCurve("uniaxial", way, 0.0 * way)])
    fabric = Fabric(law_of("blatz-ko-general", given), path)
    np.testing.assert_allclose(fabric.across({}, np.array([0.4, 0.3, 0.3])), way**-0.3, rtol=1e-14)


def test_smooth_grips_of_a_foam_are_not_told_from_its_law() -> None:
    """No free law of a foam is tried beside them, whatever kinds of tests there are."""
    stretch = np.linspace(1.0, 0.5, 20)
    tests = [TestCurve(mode, stretch, pressed(stretch)) for mode in ("uniaxial", "confined-compression")]
    problem = fabric_problem(law_of("hyperfoam-1", GIVEN, foam=True), tuple(GIVEN.values()), tests)
    forms = {form.name: form for form in problem.effect("grip-slack").forms}
    assert frozenset({"grip-slack", "elastic-law"}) in problem.look_alikes({"grip-slack": forms["smooth"]})
    assert frozenset({"grip-slack", "elastic-law"}) not in problem.look_alikes({"grip-slack": forms["play"]})
