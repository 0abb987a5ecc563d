"""What is stated of the readings says how sure the constants of a whole sheet and of a foam are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hyperfab.chapters.fit.hyperfoam import fit_foam
from hyperfab.chapters.fit.identify import Setting
from hyperfab.chapters.fit.orthotropic import fit_sheet
from hyperfab.chapters.fit.readings import Readings
from hyperfab.curve import TestCurve
from hyperfab.documents.material import FitFigures
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.orthotropic.energy import Orthotropic
from hyperfab.materials.orthotropic.specimen import strip

NOISE = 0.002
SHEET = {"C10_MPa": 0.1, "k1_warp_MPa": 0.3, "k2_warp": 0.6, "nu": 0.3}
LAM = np.linspace(1.05, 1.5, 20)
ERRORS = np.random.default_rng(5).standard_normal(20)


def sheet(widths: bool) -> TestCurve:
    found = strip(Orthotropic.of(SHEET), 0.0, LAM)
    return TestCurve(
        "uniaxial",
        LAM,
        found.stress + NOISE * ERRORS,
        stretch2=np.asarray(found.width) + 1e-3 * ERRORS[::-1] if widths else None,
        source="a.csv",
        direction=0.0,
    )


def foam() -> TestCurve:
    lam = np.linspace(0.97, 0.45, 20)
    stress = Hyperfoam((0.1,), (8.0,), (0.1,)).stress("uniaxial", lam)
    return TestCurve("uniaxial", lam, stress + 0.1 * NOISE * ERRORS, source="a.csv")


def of_sheet(curve: TestCurve, noise: float | None) -> FitFigures:
    figures = fit_sheet([curve], Setting(("uniaxial",), False, False, 1.0, noise)).direction("warp").fit
    assert figures is not None
    return figures


def of_foam(curve: TestCurve, noise: float | None) -> FitFigures:
    return fit_foam(Readings([curve], [], None, True), Setting(("uniaxial",), False, False, 1.0, noise), 1).figures


def sure(figures: FitFigures) -> dict[str, float]:
    assert figures.parameters_sd is not None
    return {name: sd for name, sd in figures.parameters_sd.items() if sd is not None}


@pytest.mark.parametrize(("of", "curve"), [(of_sheet, sheet(widths=False)), (of_foam, foam())])
def test_twice_the_stated_deviation_is_half_as_sure(
    of: Callable[[TestCurve, float | None], FitFigures], curve: TestCurve
) -> None:
    """Without widths nothing else is in it; a column says the same as the noise of all."""
    one, two = of(curve, NOISE), of(curve, 2.0 * NOISE)
    column = of(replace(curve, stress_sd=np.full(20, NOISE)), None)
    for figures in (one, two, column):
        assert figures.uncertainty is not None
        assert figures.uncertainty.source == "stated"
    assert sure(two) == pytest.approx({name: 2.0 * sd for name, sd in sure(one).items()}, rel=1e-6)
    assert sure(column) == pytest.approx(sure(one), rel=1e-6)


def test_the_deviations_of_a_foam_are_those_of_least_squares() -> None:
    """sd^2 (J^T J)^-1 by differences of its stress: one test, every reading of which counts the same."""
    curve = foam()
    fit = fit_foam(Readings([curve], [], None, True), Setting(("uniaxial",), False, False, 1.0, NOISE), 1)
    best = np.array([fit.law.mu[0], fit.law.alpha[0], fit.law.nu[0]])

    def stress(mu: float, alpha: float, nu: float) -> np.ndarray:
        return Hyperfoam((mu,), (alpha,), (nu,)).stress("uniaxial", curve.stretch)

    steps = 1e-5 * np.diag(best)
    J = np.column_stack([(stress(*(best + h)) - stress(*(best - h))) / (2.0 * h.max()) for h in steps])
    expected = NOISE * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    assert list(sure(fit.figures).values()) == pytest.approx(expected.tolist(), rel=1e-4)


def test_the_noise_of_the_stresses_does_not_drown_the_widths() -> None:
    """Every reading counts the same, with the noise told or not: so do the widths beside them."""
    curve, setting = sheet(widths=True), Setting(("uniaxial",), False, False, 1.0)
    told = fit_sheet([curve], replace(setting, noise=NOISE)).law.parameters
    assert told == pytest.approx(dict(fit_sheet([curve], setting).law.parameters), rel=1e-6)


def test_widths_without_a_stated_deviation_are_as_sure_as_what_they_leave() -> None:
    figures = of_sheet(sheet(widths=True), NOISE)
    assert figures.uncertainty is not None
    assert figures.uncertainty.source == "stated"
    # The ratio hangs on the widths: at the rate at which the stretch across, 1.5^-nu, falls with it, from 20 of them.
    assert 1e-3 / np.sqrt(20.0) / np.log(1.5) < sure(figures)["nu"] < 1e-3 / np.sqrt(20.0) / np.log(1.05)
