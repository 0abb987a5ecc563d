"""Strips cut at several angles from a sheet that no form of the catalogue is: what differs is its directions."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.loop.judge import Judgement
from hyperfab.materials.identification.design import Problem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import strip
from hyperfab.materials.registry import law

ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)
#: Of warp, weft and shear: a stiffness [MPa], and the power its stress goes with.
WAYS = ((1.0, 1.4), (0.4, 2.1), (0.12, 1.7))
NOISE, SCATTER = 0.003, 0.02


def carried(stretch: np.ndarray, angle: float) -> np.ndarray:
    """Return the stress [MPa] of a strip whose compliances, at a strain, add up as those of linear elasticity do.

    Lekhnitskii (1968), Anisotropic Plates, ch. 2; each of them falls with the strain in its own way.
    """
    strain = np.maximum(stretch - 1.0, 1e-9)
    c, s = np.cos(np.radians(angle)) ** 2, np.sin(np.radians(angle)) ** 2
    warp, weft, shear = (1.0 / (stiff * strain**power) for stiff, power in WAYS)
    return 1.0 / (c * c * warp + s * s * weft + c * s * shear)


def strips(contracts: bool = False) -> list[TestCurve]:
    random, found = np.random.default_rng(5), []
    stretch = np.linspace(1.0, 1.5, 16)
    for angle in ANGLES[::2] if contracts else ANGLES:
        for number in (1, 2):
            stress = carried(stretch, angle) * (1.0 + SCATTER * random.standard_normal())
            stress += NOISE * np.max(stress) * random.standard_normal(len(stretch))
            # Slanted threads turn: there it becomes narrower than a sheet that keeps its volume.
            exponent = 0.3 + 0.6 * np.sin(2.0 * np.radians(angle)) ** 2 * (1.0 + np.log(stretch))
            width = stretch**-exponent + 0.001 * random.standard_normal(len(stretch))
            name = f"{angle:g}-{number}"
            across = width if contracts else None
            found.append(
                TestCurve("uniaxial", stretch, stress, stretch2=across, direction=angle, source=name, specimen=name)
            )
    return found


def closed(model: str, tests: list[TestCurve]) -> Finding:
    warp = [
        TestCurve(one.mode, one.stretch, one.stress, np.ones_like(one.stress)) for one in tests if not one.direction
    ]
    fitted = fit_law(Problem(law(model), Rows.of(warp)))
    assert fitted is not None
    constants = [fitted.material.parameters[name] for name in law(model).names]
    return close(fabric_problem(law(model), constants, tests), design=False)


@pytest.mark.parametrize("model", ["mooney-rivlin-3", "yeoh-2"])
@pytest.mark.slow
def test_a_sheet_of_other_stiffness_at_every_angle_is_anisotropic_and_no_more(model: str) -> None:
    found = closed(model, strips())
    assert found.verdict == "effect"
    assert {*found.after.ids} - {"elastic-law"} == {"anisotropy"}
    assert found.after.judgement.beside_machine <= found.after.judgement.structured


@pytest.mark.slow
def test_strips_that_become_narrower_between_warp_and_weft_need_no_other_name() -> None:
    found = closed("mooney-rivlin-3", strips(contracts=True))
    assert found.verdict == "effect"
    assert {*found.after.ids} == {"anisotropy", "compressibility"}


def test_what_a_testing_machine_may_be_off_asks_for_no_other_name() -> None:
    """Replicates tell how they scatter, not what the machine reads wrong in all of them."""
    assert Judgement(1.5, 0.7, 0.3, 1e-20, 1e-20, 1e-20).is_small
    assert not Judgement(1.5, 0.7, 0.7, 1e-20, 1e-20, 1e-20).is_small


@pytest.mark.slow
def test_a_laminate_at_seven_angles_is_anisotropic() -> None:
    """Ogden's law has no threads of its own, and no formula comes near: each specimen had a slack of its own."""
    sheet = Orthotropic.of({"C10_MPa": 0.3, "k1_warp_MPa": 4.0, "k1_weft_MPa": 9.0, "k1_bias_MPa": 1.5})
    random, stretch = np.random.default_rng(3), np.linspace(1.0, 1.08, 14)
    tests = []
    for angle in np.linspace(0.0, 90.0, 7):
        stress = strip(sheet, angle, stretch).stress
        stress = stress + 0.004 * np.max(stress) * random.standard_normal(len(stretch))
        name = f"{angle:g}"
        tests.append(TestCurve("uniaxial", stretch, stress, direction=float(angle), source=name, specimen=name))
    found = closed("ogden-1", tests)
    assert found.verdict == "effect"
    assert {*found.after.ids} == {"anisotropy"}


@pytest.mark.parametrize("seed", range(2))
def test_threads_of_the_way_that_gives_least_are_found_as_straight_as_they_become(seed: int) -> None:
    """A soft ground pulled to 1.6 along the warp, threads along the weft that are straight at 1.22: their growth is by
    the strain that way reaches, not by that of the other."""
    random, tests = np.random.default_rng(seed), []
    for angle, top in ((0.0, 1.6), (90.0, 1.22)):
        stretch = np.linspace(1.0, top, 40)
        stress, grown = 0.02 * (stretch - stretch**-2), stretch**2 - 1.0
        if angle:
            stress = stress + 2.0 * 0.002 * stretch * grown * np.exp(30.0 * grown**2)
        read = stress + 0.002 * np.max(stress) * random.standard_normal(40)
        tests.append(TestCurve("uniaxial", stretch, read, direction=angle, source=f"{angle}", specimen=f"{angle}"))
    done = close(fabric_problem(law("neo-hookean"), (0.01,), tests), design=False)
    assert (done.verdict, done.after.ids) == ("effect", ("anisotropy",))
    assert done.after.fit.forms["anisotropy"].name == "weft-fibres"
    np.testing.assert_allclose(done.after.fit.x, [0.01, 0.002, 30.0], rtol=0.02)
