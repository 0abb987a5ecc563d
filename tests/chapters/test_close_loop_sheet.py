"""A model that is one energy of the whole sheet: the loop reads it, adds to it, and writes one again."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.close_loop.extended import extend, in_terms
from hyperfab.chapters.close_loop.fabric import pose
from hyperfab.chapters.close_loop.measured_tests import Measured
from hyperfab.curve import TestCurve
from hyperfab.documents.material import Direction, MaterialDocument, Undetermined
from hyperfab.loop.fabric import FabricProblem
from hyperfab.materials.orthotropic import ABSENT, Orthotropic
from hyperfab.materials.orthotropic.specimen import strip

WOVEN = {
    "C10_MPa": 0.05,
    "k1_warp_MPa": 0.6,
    "k1_weft_MPa": 0.3,
    "k2_warp": 2.0,
    "k2_weft": 1.0,
    "G_MPa": 0.08,
}
KNIT = {**WOVEN, "C30_MPa": 0.01, "k1_bias_MPa": 0.1, "k2_bias": 0.5, "bias_deg": 35.0, "nu": 0.3}

#: Enough to tell how a pair of threads is inclined.
EVERY = 0.0, 15.0, 30.0, 60.0, 75.0, 90.0


def pulled(*angles: float) -> Measured:
    lam = np.linspace(1.0, 1.25, 14)
    return Measured(
        [TestCurve("uniaxial", lam, lam - 1.0, stretch2=lam**-0.4, direction=a, source=f"{a:g}") for a in angles],
        "MPa",
    )


def posed(document: MaterialDocument, *angles: float) -> tuple[MaterialDocument, FabricProblem]:
    told = in_terms(document, "sheet.json", pulled(*angles).tests)
    return told, pose(told, "sheet.json", pulled(*angles))


def values(problem: FabricProblem) -> np.ndarray:
    return np.array([constant.value for constant in problem.own])


def written(document: MaterialDocument, problem: FabricProblem, x: np.ndarray, **terms: Any) -> MaterialDocument:
    fit: Any = SimpleNamespace(x=np.concatenate([x, *(v for _, v in terms.values())]), own=len(x), terms=terms)
    return extend(document, problem, fit, problem.law)


@pytest.mark.parametrize("constants", [WOVEN, KNIT, {"C10_MPa": 0.1, "C2_MPa": 0.02}], ids=["woven", "knit", "none"])
def test_what_the_loop_computes_is_the_energy_of_the_sheet(constants: dict[str, float]) -> None:
    document = MaterialDocument(model="orthotropic", parameters=constants)
    problem = posed(document, 0.0, 30.0, 90.0)[1]
    stress = problem.predict(values(problem), {}).reshape(-1, 14)
    for row, angle in zip(stress, (0.0, 30.0, 90.0), strict=False):
        exact = strip(Orthotropic.of(constants), angle, np.linspace(1.0, 1.25, 14)).stress
        # Its equilibrium is sought at knots, and goes between them by cubics.
        assert row == pytest.approx(exact, abs=1e-5 * exact.max())


@pytest.mark.parametrize("constants", [WOVEN, KNIT], ids=["woven", "knit"])
def test_what_is_refitted_is_a_sheet_again(constants: dict[str, float]) -> None:
    told, problem = posed(MaterialDocument(model="orthotropic", parameters=constants), *EVERY)
    free = np.array([one.low < one.high for one in problem.own])
    moved = values(problem) * np.where(free, 1.01, 1.0)
    again = written(told, problem, moved)
    assert again.model == "orthotropic"
    for name, value in Orthotropic.of(again.parameters).parameters.items():
        # What the document does not have stays away.
        assert value == pytest.approx(1.01 * constants[name] if name in constants else ABSENT[name]), name
    _, later = posed(again, *EVERY)
    assert later.predict(values(later), {}) == pytest.approx(problem.predict(moved, {}), abs=1e-12)


def test_a_volume_that_changes_is_a_constant_of_the_sheet() -> None:
    """Every command obeys it then."""
    told, problem = posed(MaterialDocument(model="orthotropic", parameters=WOVEN), 0.0, 45.0, 90.0)
    own = values(problem)
    found = written(told, problem, own, compressibility=("uniform", np.array([0.35])))
    assert found.parameters["nu"] == 0.35
    assert [item["told_by"] for item in found.effects or []] == ["model", "model"]
    _, later = posed(found, 0.0, 45.0, 90.0)
    meant = problem.predict(own, {"compressibility": ("uniform", np.array([0.35]))})
    assert later.predict(values(later), {}) == pytest.approx(meant, abs=1e-12)


def test_what_the_tests_behind_it_left_open_is_sought_where_these_tell_it() -> None:
    open_ = [Undetermined(constant=name, value=0.0, test="a pull at 45 degrees") for name in ("G_MPa", "k1_bias_MPa")]
    document = MaterialDocument(model="orthotropic", parameters={**WOVEN, "G_MPa": 0.0}, undetermined=open_)
    free = {one.name for one in posed(document, 0.0, 30.0, 60.0, 90.0)[1].own if one.low < one.high}
    assert "anisotropy G_MPa" in free
    held = {one.name for one in posed(document, 0.0, 90.0)[1].own if one.low < one.high}
    assert "anisotropy k1_warp_MPa" in held
    assert "anisotropy G_MPa" not in held


def test_a_sheet_without_threads_may_lack_them() -> None:
    told, problem = posed(MaterialDocument(model="orthotropic", parameters={"C10_MPa": 0.1}), 0.0, 90.0)
    assert told.model == "yeoh-1"
    assert not problem.effect("anisotropy").not_sought


def test_a_sheet_told_by_pulls_along_one_thread_is_its_ground() -> None:
    """`hf fit` then writes all constants of the sheet beside its only direction too."""
    sheet = {**ABSENT, "C10_MPa": 0.1, "nu": 0.3}
    document = MaterialDocument(
        model="orthotropic", parameters=sheet, directions={"warp": Direction(parameters=dict(sheet))}
    )
    told, problem = posed(document, 0.0)
    stress = problem.predict(values(problem), {})[:14]
    exact = strip(Orthotropic.of(sheet), 0.0, np.linspace(1.0, 1.25, 14)).stress
    assert stress == pytest.approx(exact, abs=1e-9)
    again = written(told, problem, values(problem), compressibility=("uniform", np.array([0.3])))
    assert again.model == "yeoh-1"


def test_a_sheet_that_softens_with_the_temperature_is_found_soft(hf: Run, tmp_path: Path) -> None:
    random, files = np.random.default_rng(3), []
    lam = np.linspace(1.0, 1.25, 12)
    for angle in (0, 90):
        for degrees in (23, 80):
            stress = strip(Orthotropic.of(WOVEN), float(angle), lam).stress * np.exp(-0.004 * (degrees - 23))
            stress = stress + 1e-3 * random.standard_normal(len(lam))
            rows = "".join(f"{a:.6g},{b:.6g},{degrees}\n" for a, b in zip(lam, stress, strict=True))
            files.append(f"{angle}-{degrees}.csv")
            (tmp_path / files[-1]).write_text(
                f"# test: uniaxial\n# direction: {angle}\nstretch,stress [MPa],temperature [degC]\n{rows}"
            )
    model = {
        "format": "hyperfab.material/1",
        "model": "orthotropic",
        "parameters": WOVEN,
        "temperature_degC": 23.0,
    }
    (tmp_path / "sheet.json").write_text(json.dumps(model))
    hf("close-loop", "sheet.json", *files, "-o", "loop.json", cwd=tmp_path).check_returncode()
    loop = json.loads((tmp_path / "loop.json").read_text())
    assert [one["id"] for one in loop["effects"]] == ["thermal-softening"]
    extended = json.loads((tmp_path / "loop.model.json").read_text())
    assert extended["model"] == "orthotropic"
    assert extended["parameters"]["k1_warp_MPa"] == pytest.approx(0.6, rel=0.05)
    hf("close-loop", "loop.model.json", *files, "-o", "again.json", cwd=tmp_path).check_returncode()
    assert json.loads((tmp_path / "again.json").read_text())["verdict"] == "noise"
