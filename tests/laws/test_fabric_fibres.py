"""The orthotropic fabric law: what it owes beyond the isotropic ones."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.chapters.fit.identify import Identified, Setting, along_direction, identify
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.materials import bind, laws
from hyperfab.materials.identification import Problem, Rows, fit_law

TRUTH = {"C10_MPa": 0.02, "k1_along_MPa": 0.03, "k1_across_MPa": 0.005, "k2_along": 0.4, "k2_across": 0.1}


def fabric():
    return bind("fabric-fibres", TRUTH, anisotropic=True)


def test_stress_is_the_slope_of_the_energy_and_the_tangent_that_of_the_stress() -> None:
    # Tension in both, in one with the other slack, and in neither.
    l1, l2, h = np.array([1.3, 1.6, 0.9, 1.0]), np.array([1.1, 0.8, 0.95, 1.0]), 1e-40
    found = fabric().membrane(l1, l2)
    one, two = fabric().membrane(l1 + 1j * h, l2), fabric().membrane(l1, l2 + 1j * h)
    for value, slope in (
        (found.P1, one.W), (found.P2, two.W), (found.A11, one.P1), (found.A12, one.P2), (found.A22, two.P2),
    ):  # fmt: skip
        np.testing.assert_allclose(value, slope.imag / h, rtol=1e-13, atol=1e-15)


def test_energy_is_that_of_the_formula() -> None:
    l1, l2 = 1.4, 1.2
    ground = TRUTH["C10_MPa"] * (l1**2 + l2**2 + (l1 * l2) ** -2 - 3)
    fibres = sum(
        TRUTH[f"k1_{way}_MPa"] / (2 * TRUTH[f"k2_{way}"]) * (np.exp(TRUTH[f"k2_{way}"] * (lam**2 - 1) ** 2) - 1)
        for way, lam in (("along", l1), ("across", l2))
    )
    assert float(fabric().membrane(l1, l2).W) == pytest.approx(ground + fibres, rel=1e-14)


def test_turned_by_a_quarter_the_axes_change_places() -> None:
    one, two = fabric().membrane(1.4, 1.2), fabric().turned().membrane(1.2, 1.4)
    assert float(one.W) == pytest.approx(float(two.W), rel=1e-15)
    assert float(one.P1) == pytest.approx(float(two.P2), rel=1e-15)
    assert fabric().turned().turned() == fabric()


def test_in_uniaxial_tension_the_lateral_stress_is_zero() -> None:
    lam = np.array([1.1, 1.5, 2.0])
    np.testing.assert_allclose(fabric().membrane(lam, lam**-0.5).P2, 0.0, atol=1e-16)


def test_own_constants_are_recovered_from_warp_and_weft() -> None:
    lam = np.linspace(1.02, 1.8, 30)
    warp, weft = fabric().uniaxial(lam).P, fabric().turned().uniaxial(lam).P
    curves = [TestCurve("uniaxial", lam, warp, 1 / warp), TestCurve("uniaxial", lam, weft, 1 / weft)]
    found = fit_law(Problem(laws()["fabric-fibres"], Rows.of(curves, axes=(1, 2))))
    assert found is not None
    assert list(found.material.parameters.values()) == pytest.approx(list(TRUTH.values()), rel=1e-8)


@pytest.mark.parametrize("direction", [0.0, 90.0, None])
def test_a_general_biaxial_test_is_along_the_fibres_that_its_first_axis_is_cut_along(
    direction: float | None,
) -> None:
    """The first axis along the weft, or along the warp where it is not said: seen from both ways the law meets it."""
    lam = np.linspace(1.02, 1.5, 12)
    first, second = lam, 1.0 + 0.5 * (lam - 1.0)
    pulled = (fabric().turned() if direction == 90.0 else fabric()).membrane(first, second)
    strips = [
        TestCurve("uniaxial", lam, one.uniaxial(lam).P, direction=way)
        for one, way in ((fabric(), 0.0), (fabric().turned(), 90.0))
    ]
    both = TestCurve("biaxial-general", first, pulled.P1, stretch2=second, stress2=pulled.P2, direction=direction)
    setting = Setting(("uniaxial", "biaxial-general"), True, False, 0.3)
    found = identify(laws()["fabric-fibres"], [*strips, both], setting)
    assert isinstance(found, Identified)
    assert list(found.material.parameters.values()) == pytest.approx(list(TRUTH.values()), rel=1e-6)
    seen = [found, *(along_direction(found, way, [both], setting) for way in ("warp", "weft"))]
    for part in seen if direction is None else [found, seen[1 if direction == 0.0 else 2]]:
        figures = part.tests["biaxial-general"][0]
        assert figures is not None
        assert figures.relative_rms < 1e-9


def test_who_does_not_know_about_directions_is_refused() -> None:
    with pytest.raises(InputError, match="isotropic one is needed"):
        bind("fabric-fibres", TRUTH)
