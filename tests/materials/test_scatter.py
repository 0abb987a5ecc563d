"""Standard deviations are those of specimens: exact where the answer is known, and their intervals cover."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from scipy.stats import t as student

from hyperfab.chapters.fit.describe import uncertainty
from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.chapters.fit.orthotropic import fit_sheet
from hyperfab.curve import TestCurve
from hyperfab.documents.certainty import FitUncertainty
from hyperfab.materials.identification.scatter import Weighed, _correlated, by_readings
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import strip
from hyperfab.materials.registry import law
from trials.coverage import trial

GAINS = np.array([0.97, 1.01, 1.04, 0.995])


def neo_hookean(gains: np.ndarray, rows: int = 20, temperature: float | None = None) -> list[TestCurve]:
    lam = np.linspace(1.05, 1.8, rows)
    return [
        TestCurve(
            mode="uniaxial", source="a.csv", specimen=f"{number} {temperature}", stretch=lam,
            stress=0.2 * gain * (lam - lam**-2), temperature=temperature,
        )
        for number, gain in enumerate(gains)
    ]  # fmt: skip


def fitted(curves: list[TestCurve], relative: bool = False) -> Identified:
    found = identify(law("neo-hookean"), curves, Setting(("uniaxial",), relative, False, 1.0))
    assert isinstance(found, Identified)
    return found


@pytest.mark.parametrize("rows", [5, 20, 400])
def test_without_noise_the_variance_is_that_of_the_mean_of_specimens(rows: int) -> None:
    """However densely a specimen is read, it is one."""
    scatter = fitted(neo_hookean(GAINS, rows)).certainty.scatter
    assert scatter is not None
    assert (scatter.specimens, scatter.freedom) == (4, 3)
    assert scatter.covariance[0, 0] == pytest.approx(np.var(0.1 * GAINS, ddof=1) / 4, rel=1e-9)


def test_what_is_stated_of_readings_is_carried_to_the_constants() -> None:
    """Of one specimen; each reading by itself: C10 is a straight line's slope."""
    [curve] = neo_hookean(GAINS[:1])
    slopes = 2.0 * (curve.stretch - curve.stretch**-2)
    sd = np.linspace(0.001, 0.004, len(slopes))
    weighed = identify(law("neo-hookean"), [replace(curve, stress_sd=sd)], Setting(("uniaxial",), False, False, 1.0))
    noisy = identify(law("neo-hookean"), [curve], Setting(("uniaxial",), False, False, 1.0, noise=0.002))
    for found, each in ((weighed, sd), (noisy, 0.002)):
        assert isinstance(found, Identified)
        sure = uncertainty(found.certainty, found.specimens)
        assert (sure.source, sure.specimens, sure.degrees_of_freedom) == ("stated", 1, 0)
        assert sure.covariance is not None
        assert sure.covariance[0][0] == pytest.approx(1.0 / np.sum((slopes / each) ** 2), rel=1e-9)
        assert found.certainty.sd[0] ** 2 == pytest.approx(sure.covariance[0][0], rel=1e-12)
    # Where specimens scatter that counts, whatever is stated of their readings.
    several = identify(law("neo-hookean"), neo_hookean(GAINS), Setting(("uniaxial",), False, False, 1.0, noise=0.002))
    assert isinstance(several, Identified)
    assert uncertainty(several.certainty, several.specimens).source == "specimens"


def test_each_temperature_has_the_scatter_of_its_own_specimens() -> None:
    found = fitted([*neo_hookean(GAINS, temperature=23.0), *neo_hookean(GAINS[:3] ** 4, temperature=80.0)])
    for sure, gains in zip(found.certainties, (GAINS, GAINS[:3] ** 4), strict=True):
        assert sure.scatter is not None
        assert sure.scatter.specimens == len(gains)
        assert sure.scatter.covariance[0, 0] == pytest.approx(np.var(0.1 * gains, ddof=1) / len(gains), rel=1e-9)


#: Of a sheet: what each of its specimens is stiffer than the mean.
SHEET = {"C10_MPa": 0.05, "C20_MPa": 0.02, "C30_MPa": 0.01, "k1_warp_MPa": 0.08, "k2_warp": 0.3, "k1_weft_MPa": 0.03,
         "k2_weft": 0.5}  # fmt: skip


def sheet(warp: np.ndarray, weft: np.ndarray, temperature: float | None = None) -> list[TestCurve]:
    own, lam = Orthotropic.of(SHEET), np.linspace(1.05, 1.6, 25)
    return [
        TestCurve(mode="uniaxial", source="a.csv", specimen=f"{way} {number} {temperature}", direction=angle,
                temperature=temperature, stretch=lam, stress=gain * strip(own, angle, lam).stress)
        for way, angle, gains in (("warp", 0.0, warp), ("weft", 90.0, weft))
        for number, gain in enumerate(gains)
    ]  # fmt: skip


def sure_of_sheet(curves: list[TestCurve], setting: Setting) -> FitUncertainty | None:
    fit = fit_sheet(curves, setting).direction("warp").fit
    return None if fit is None else fit.uncertainty


def test_the_constants_of_a_sheet_scatter_as_its_specimens_do() -> None:
    """All specimens of one kind stiffer by the same share: so are the stresses of the law, and nothing else."""
    setting = Setting(("uniaxial",), False, False, 1.0)
    found = sure_of_sheet(sheet(GAINS, GAINS), setting)
    assert found is not None
    assert (found.source, found.specimens, found.degrees_of_freedom) == ("specimens", 8, 6)
    assert set(found.order) == set(SHEET)
    # The law's stress at one stretch along the warp: that of the mean of four, in its own direction alone.
    lam = np.array([1.4])
    rates = []
    for name in found.order:
        more, less = (Orthotropic.of(SHEET | {name: SHEET[name] * (1.0 + d)}) for d in (1e-5, -1e-5))
        rates.append((strip(more, 0.0, lam).stress - strip(less, 0.0, lam).stress)[0] / (2e-5 * SHEET[name]))
    sd = np.sqrt(np.array(rates) @ np.array(found.covariance) @ np.array(rates))
    expected = strip(Orthotropic.of(SHEET), 0.0, lam).stress[0] * np.sqrt(np.var(GAINS, ddof=1) / 4)
    assert expected <= sd * (1.0 + 1e-6)  # widened where directions weigh differently
    assert sd == pytest.approx(expected, rel=0.15)


def test_each_direction_and_temperature_of_a_sheet_says_how_sure_it_is() -> None:
    fit = fit_sheet(
        [*sheet(GAINS, GAINS, 23.0), *sheet(GAINS**2, GAINS, 80.0)], Setting(("uniaxial",), True, False, 1.0)
    )
    warp, weft = fit.direction("warp").fit, fit.direction("weft").fit
    assert warp is not None
    assert weft is not None
    assert warp.parameters_sd is not None
    assert weft.parameters_sd is not None
    assert warp.parameters_sd["k1_warp_MPa"] == weft.parameters_sd["k1_weft_MPa"]
    rows = fit.direction("weft").temperatures
    assert rows is not None
    for row in rows:
        assert row.fit is not None
        assert row.fit.uncertainty is not None
        assert row.fit.uncertainty.specimens == 8
    # With one specimen of a kind nothing shows how they scatter.
    alone = sure_of_sheet(sheet(GAINS[:1], GAINS[:1]), Setting(("uniaxial",), True, False, 1.0))
    assert alone is not None
    assert alone.source == "readings"


def test_what_the_law_misses_in_all_specimens_is_no_scatter() -> None:
    """The same wrong law on the same curve three times: nothing scatters."""
    lam = np.linspace(1.05, 1.8, 20)
    same = [
        TestCurve(mode="uniaxial", source="a.csv", specimen=str(k), stretch=lam, stress=0.1 * (lam - 1.0) ** 2)
        for k in range(3)
    ]
    scatter = fitted(same).certainty.scatter
    assert scatter is not None
    assert scatter.covariance[0, 0] == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize(("name", "tests"), [("yeoh-3", 1), ("mooney-rivlin-2", 3), ("gent", 2)])
def test_intervals_cover(name: str, tests: int) -> None:
    """Each share within five standard deviations of a binomial 95 % (the table of 100 labs: trials/coverage.py)."""
    labs = 60
    share = trial(name, ("uniaxial", "shear", "biaxial")[:tests], 4, 0.015, labs)
    assert np.all(share > 0.95 - 5.0 * np.sqrt(0.95 * 0.05 / labs))
    assert 0.92 < float(np.mean(share)) <= 1.0


@pytest.mark.slow
def test_the_document_says_what_its_deviations_are_known_from(hf: Run, root: Path) -> None:
    files = [word for way in ("warp", "weft") for word in ("--uniaxial", root / f"specimens/lycra/{way}-23C.csv")]
    found = json.loads(hf("fit", *files, "--model", "yeoh-3").stdout)
    for way in ("warp", "weft"):
        figures = found["directions"][way]["fit"]
        sure = figures["uncertainty"]
        assert (sure["source"], sure["specimens"], sure["degrees_of_freedom"]) == ("specimens", 3, 2)
        assert sure["order"] == list(found["directions"][way]["parameters"])
        sd = np.array(list(figures["parameters_sd"].values()))
        np.testing.assert_allclose(np.sqrt(np.diag(sure["covariance"])), sd, rtol=1e-12)
    # The constant that the sample was drawn with lies in its interval.
    own = found["directions"]["warp"]
    away = abs(own["parameters"]["C10_MPa"] - 0.060951)
    assert away < student.ppf(0.975, 2) * own["fit"]["parameters_sd"]["C10_MPa"]


def test_one_specimen_shows_no_scatter_and_none_is_made_up(hf: Run, root: Path) -> None:
    done = hf("fit", "--uniaxial", root / "specimens/treloar-1944/uniaxial.csv")
    fit = json.loads(done.stdout)["fit"]
    sure = fit["uncertainty"]
    assert (sure["source"], sure["specimens"], sure["degrees_of_freedom"]) == ("readings", 1, 0)
    # What the readings alone tell stands there, as what it is; no later command takes it for more.
    sd = [fit["parameters_sd"][name] for name in sure["order"]]
    np.testing.assert_allclose(np.sqrt(np.diag(sure["covariance"])), sd, rtol=1e-12)
    contact = hf("fabric-contact", "-", "--depth", "10mm", "--steps", "1", stdin=done.stdout)
    assert contact.returncode == 0
    assert "uncertainty" not in json.loads(contact.stdout)
    assert 0.0 < sure["law"] < 2.0


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_intervals_of_one_specimen_cover_where_readings_err_with_their_neighbours(rho: float) -> None:
    random = np.random.default_rng(7)
    lam = np.linspace(1.02, 1.8, 40)
    inside = []
    for _ in range(60):
        error = random.standard_normal(len(lam))
        for k in range(1, len(lam)):
            error[k] = rho * error[k - 1] + np.sqrt(1.0 - rho**2) * error[k]
        stress = 0.2 * (lam - lam**-2) * (1.0 + 0.01 * error)
        one = fitted([TestCurve(mode="uniaxial", source="a.csv", specimen="1", stretch=lam, stress=stress)], True)
        inside.append(abs(one.material.parameters["C10_MPa"] - 0.1) <= 1.96 * one.certainty.sd[0])
    # As if each reading erred by itself they held 16 of the 60 correlated ones.
    assert np.mean(inside) >= 0.75


def test_correlations_of_neighbours_are_those_of_each_curve() -> None:
    """Against the matrix itself; of a white residual the covariance is that of least squares, but for Student's t."""
    random = np.random.default_rng(1)
    together = np.array([True, True, False, True, False])
    curve, values = np.array([0, 0, 0, 1, 1, 2]), random.standard_normal((6, 2))
    apart = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    matrix = np.where(np.equal.outer(curve, curve), 0.6**apart, 0.0)
    assert _correlated(values, together, 0.6) == pytest.approx(matrix @ values, rel=1e-12)
    basis = np.linalg.qr(random.standard_normal((4000, 2)))[0]
    left = random.standard_normal(4000)
    left -= basis @ (basis.T @ left)
    found = by_readings(Weighed(basis, left, np.ones(4000), np.zeros(4000)), basis, np.eye(2))
    assert found == pytest.approx(np.eye(2) * (left @ left) / 3998, rel=0.05, abs=0.05)


def test_stresses_and_widths_err_each_by_their_own() -> None:
    """One constant told by 2000 stresses that err by 1, another by as many widths that err by 0.1."""
    random = np.random.default_rng(3)
    stress = np.repeat([1.0, 0.0], 2000)
    basis = np.stack([stress, 1.0 - stress], axis=1) / np.sqrt(2000.0)
    left = random.standard_normal(4000) * np.where(stress > 0.0, 1.0, 0.1)
    left -= basis @ (basis.T @ left)
    found = by_readings(Weighed(basis, left, stress, np.repeat([0, 1], 2000)), basis, np.eye(2))
    assert np.diag(found) == pytest.approx([1.0, 0.01], rel=0.1)


def test_a_pull_and_a_pressing_are_no_replicates() -> None:
    """They differ by what the law misses, which is no scatter of specimens."""
    [pulled] = neo_hookean(GAINS[:1])
    lam = np.linspace(0.95, 0.6, 20)
    pressed = replace(pulled, specimen="2", stretch=lam, stress=0.21 * (lam - lam**-2))
    assert fitted([pulled, pressed]).certainty.scatter is None
    assert fitted([pulled, replace(pulled, specimen="2", stress=1.1 * pulled.stress)]).certainty.scatter is not None
