"""Figures of loop.json where they follow from the data by formulas: a fabric that is softer when it is warm."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.close_loop.describe import errors_of

STRETCH = np.linspace(1.05, 1.9, 18)
SHAPE = 2.0 * (STRETCH - STRETCH**-2)
SD, SOFTENING = 5e-4, 0.006


def test_errors_are_those_of_their_definitions() -> None:
    rng = np.random.default_rng(2)
    measured = rng.uniform(0.5, 2.0, 12)
    before, after = measured + rng.normal(0.0, 0.2, 12), measured + rng.normal(0.0, 0.05, 12)
    sd = np.full(12, 0.04)
    curves = [np.arange(5), np.arange(5, 12)]
    found = errors_of(measured, before, after, sd, "MPa", curves=curves)
    for part, raw in ((found.before, measured - before), (found.after, measured - after), (found.noise, sd)):
        rms = math.sqrt(float(np.mean(raw**2)))
        assert part.rms == pytest.approx(rms, rel=1e-12)
        assert part.relative_rms == pytest.approx(rms / math.sqrt(float(np.mean(measured**2))), rel=1e-12)
        assert part.nrmse == pytest.approx(rms / measured.max(), rel=1e-12)
        each = [math.sqrt(float(np.mean(raw[rows] ** 2))) / measured[rows].max() for rows in curves]
        assert part.nrmse_of_tests == pytest.approx(sum(each) / 2.0, rel=1e-12)
    assert found.before.chi2_reduced == pytest.approx(float(np.mean(((measured - before) / sd) ** 2)), rel=1e-12)
    assert found.after.chi2_reduced == pytest.approx(float(np.mean(((measured - after) / sd) ** 2)), rel=1e-12)
    assert found.noise.chi2_reduced == 1.0
    # Of one test there is no mean over tests; the scatter of specimens counts as noise where it is told.
    alone = errors_of(measured, before, after, sd, "MPa", spread=2.0 * sd, curves=curves[:1])
    assert alone.before.nrmse_of_tests is None
    assert alone.noise.rms == pytest.approx(0.08, rel=1e-12)


@pytest.fixture(scope="module")
def warmed(hf: Run, tmp_path_factory) -> tuple[dict, np.ndarray]:
    """Neo-Hooke's law with C10 = 0.2 MPa at 20 degC; five tests from 20 to 80 degC, softer by 0.6 % a kelvin."""
    folder, rng = tmp_path_factory.mktemp("warm"), np.random.default_rng(5)
    given = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}
    (folder / "model.json").write_text(json.dumps({**given, "temperature_degC": 20.0, "thickness_mm": 1.0}))
    words, stresses = [], []
    for degrees in (20.0, 35.0, 50.0, 65.0, 80.0):
        stress = 0.2 * SHAPE * math.exp(-SOFTENING * (degrees - 20.0)) + SD * rng.standard_normal(len(SHAPE))
        rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(STRETCH.tolist(), stress.tolist(), strict=True))
        head = f"# test: uniaxial\n# temperature: {degrees:g} degC\n# thickness: 1 mm\n"
        (folder / f"t{degrees:g}.csv").write_text(head + "stretch [-],stress [MPa]\n" + rows)
        words += ["--measured", f"t{degrees:g}.csv"]
        stresses.append(stress)
    done = hf("close-loop", "model.json", *words, "--noise", f"{1e3 * SD}kPa", "-o", "loop.json", cwd=folder)
    assert done.returncode == 0, done.stderr.decode()
    return json.loads((folder / "loop.json").read_text()), np.array(stresses)


def test_the_noise_that_is_stated_is_the_one_that_is_told(warmed) -> None:
    found, _ = warmed
    assert found["noise"]["sd"] == pytest.approx(SD, rel=1e-9)
    assert found["noise"]["unit"] == "MPa"
    assert found["error"]["noise"]["rms"] == pytest.approx(SD, rel=1e-9)


def test_the_effect_is_found_with_its_size_and_its_doubt(warmed) -> None:
    found, _ = warmed
    assert found["verdict"] == "effect"
    [effect] = found["effects"]
    assert effect["id"] == "thermal-softening"
    value, doubt = effect["parameters"]["softening_1_K"], effect["parameters_sd"]["softening_1_K"]
    # Least squares of C10 and the rate: the curvature at the truth, to what the readings can tell.
    rises = np.repeat([0.0, 15.0, 30.0, 45.0, 60.0], len(SHAPE))
    curve = np.tile(SHAPE, 5) * np.exp(-SOFTENING * rises)
    columns = np.stack([curve, -0.2 * rises * curve], axis=1) / SD
    sd = math.sqrt(np.linalg.inv(columns.T @ columns)[1, 1])
    assert doubt == pytest.approx(sd, rel=0.25)
    assert abs(value - SOFTENING) < 4.0 * sd


def test_the_error_before_and_after(warmed) -> None:
    """Before: the constants given, fitted again to all tests alike; after: what is left is the noise."""
    found, stresses = warmed
    flat, column = stresses.ravel(), np.tile(SHAPE, 5)
    best = float(column @ flat / (column @ column))
    rms = math.sqrt(float(np.mean((flat - best * column) ** 2)))
    before, after = found["error"]["before"], found["error"]["after"]
    given = math.sqrt(float(np.mean((flat - 0.2 * column) ** 2)))
    assert before["rms"] == pytest.approx(rms, rel=0.01) or before["rms"] == pytest.approx(given, rel=1e-6)
    assert before["nrmse"] == pytest.approx(before["rms"] / flat.max(), rel=1e-9)
    assert before["relative_rms"] == pytest.approx(before["rms"] / math.sqrt(float(np.mean(flat**2))), rel=1e-9)
    # 90 readings less two constants: within three deviations of chi-squared.
    assert after["rms"] == pytest.approx(SD, rel=3.0 / math.sqrt(2.0 * 88.0))
    assert after["chi2_reduced"] == pytest.approx((after["rms"] / SD) ** 2, rel=0.05)
    evidence = effect_of(found)["evidence"]
    gone = 1.0 - max(after["chi2_reduced"] - 1.0, 0.0) / (before["chi2_reduced"] - 1.0)
    assert evidence["variance_share"] == pytest.approx(gone, abs=0.03)
    assert evidence["delta_bic"] > 50.0


def effect_of(found: dict) -> dict:
    [effect] = found["effects"]
    return effect


def test_what_is_left_is_judged_by_its_tests(warmed) -> None:
    found, _ = warmed
    left = found["residual"]
    assert left["is_noise"] is True
    assert left["structured"] == pytest.approx(
        math.sqrt(max(found["error"]["after"]["chi2_reduced"] * 90.0 / 88.0 - 1.0, 0.0)), abs=0.12
    )
    for key in ("p_lack_of_fit", "p_autocorrelation", "p_greatest_score"):
        assert 0.005 < left[key] <= 1.0
