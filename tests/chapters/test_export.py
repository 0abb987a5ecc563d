"""``hf export`` as a user calls it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.fabric import FabricDocument
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument

LYCRA = [f"specimens/lycra/{name}-23C.csv" for name in ("warp", "weft")]


@pytest.fixture(scope="module")
def fabric(hf: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "fabric.json"
    done = hf("fit", "--uniaxial", LYCRA[0], "--uniaxial", LYCRA[1], "--model", "yeoh-3")
    assert done.returncode == 0
    path.write_bytes(done.stdout)
    return path


def test_card_of_one_direction_is_written_whole(hf: Run, fabric: Path, tmp_path: Path) -> None:
    done = hf("export", fabric, "--to", "abaqus", "--direction", "warp", "-o", tmp_path / "card.inp")
    assert done.returncode == 0
    assert done.stdout == b""
    card = (tmp_path / "card.inp").read_text()
    assert "*HYPERELASTIC, REDUCED POLYNOMIAL, N=3" in card
    assert "constants of warp, 23 degC" in card


def test_card_comes_on_standard_output_and_from_standard_input(hf: Run, fabric: Path) -> None:
    done = hf("export", "-", "--to", "febio", stdin=fabric.read_bytes())
    assert done.returncode == 0
    assert b'type="Yeoh"' in done.stdout
    assert b"directions (warp, weft); the card has the constants of all together" in done.stderr
    assert b'--direction "warp" writes those of one' in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", "nastran"], "abaqus"),
        (["--to", "abaqus", "--direction", "bias"], "warp"),
        (["--to", "abaqus", "--name", "my fabric"], "lycra_warp"),
        (["--to", "ls-dyna", "--name", "x" * 81], "80 in all"),
        (["--to", "abaqus", "--name", "9lives"], "a letter, then"),
        (["--to", "abaqus", "--density", "3"], "kg/m"),
        (["--to", "abaqus", "--bulk-modulus", "0 MPa"], "more than 0MPa"),
    ],
)
def test_what_cannot_be_meant_is_refused(hf: Run, fabric: Path, arguments: list[str], words: str) -> None:
    done = hf("export", fabric, *arguments)
    assert done.returncode == 2
    assert words in done.stderr.decode()
    assert done.stdout == b""


def test_the_document_is_never_overwritten(hf: Run, fabric: Path) -> None:
    before = fabric.read_bytes()
    assert hf("export", fabric, "--to", "ansys", "-o", fabric).returncode == 2
    assert fabric.read_bytes() == before


def test_a_sheet_that_a_solver_cannot_hold_has_a_way_out(hf: Run, tmp_path: Path) -> None:
    sheet = {"C10_MPa": 0.05, "k1_warp_MPa": 0.04, "k1_weft_MPa": 0.02, "k2_warp": 1.0, "k2_weft": 0.5}
    for more, out in (
        ({}, b"; febio can"),
        ({"C2_MPa": 0.01}, b"none of the solvers can: fit a law of each"),
    ):
        document = {"format": "hyperfab.material/1", "model": "orthotropic", "parameters": {**sheet, **more}}
        (tmp_path / "sheet.json").write_text(json.dumps(document))
        done = hf("export", "sheet.json", "--to", "abaqus", cwd=tmp_path)
        assert done.returncode == 2
        assert out in done.stderr


def test_a_bulk_modulus_beside_a_law_with_a_volume_of_its_own_is_not_passed_over(hf: Run) -> None:
    foam = {"mu_MPa": 0.4, "f": 0.3, "nu": 0.3}
    document = {"format": "hyperfab.material/1", "model": "blatz-ko-general", "parameters": foam}
    done = hf("export", "-", "--to", "abaqus", "--bulk-modulus", "500MPa", stdin=json.dumps(document).encode())
    assert done.returncode == 2
    assert b"by its own nu; leave the option out" in done.stderr
    document["bulk_modulus_MPa"] = 500.0
    done = hf("export", "-", "--to", "abaqus", stdin=json.dumps(document).encode())
    assert done.returncode == 0
    assert b"volumetric test is left aside" in done.stderr


def test_a_bulk_modulus_at_which_a_pull_widens_is_told(hf: Run) -> None:
    document = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.3}}
    for K, said in ((0.39, True), (0.41, False)):
        done = hf("export", "-", "--to", "abaqus", "--bulk-modulus", f"{K}MPa", stdin=json.dumps(document).encode())
        assert done.returncode == 0
        assert (b"widens" in done.stderr) == said


def test_a_foam_has_a_card_at_each_temperature_and_a_way_out(hf: Run) -> None:
    """Between two tests constants go linearly; LS-DYNA has one Poisson's ratio for all terms, FEBio none."""

    def foam(mu: float) -> dict[str, float]:
        return {"mu1_MPa": mu, "alpha1": 8.0, "nu1": 0.1, "mu2_MPa": 0.5 * mu, "alpha2": -2.0, "nu2": 0.3}

    document = {
        "format": "hyperfab.material/1", "model": "hyperfoam-2", "parameters": foam(0.1), "temperature_degC": 20.0,
        "temperatures": [{"temperature_degC": t, "parameters": foam(mu)} for t, mu in ((20.0, 0.1), (100.0, 0.06))],
    }  # fmt: skip
    given = json.dumps(document).encode()
    for degrees, mu in ((20, b"0.1"), (60, b"0.08"), (100, b"0.06")):
        done = hf("export", "-", "--to", "abaqus", "--temperature", f"{degrees}degC", stdin=given)
        assert done.returncode == 0
        assert b"*HYPERFOAM, N=2\n" + mu + b", 8.0, " in done.stdout
    for solver in ("ls-dyna", "febio"):
        done = hf("export", "-", "--to", solver, stdin=given)
        assert done.returncode == 2
        assert b"0.1, 0.3; abaqus and ansys can" in done.stderr
    done = hf("export", "-", "--to", "abaqus", "--bulk-modulus", "500MPa", stdin=given)
    assert done.returncode == 2
    assert b"by its own nu; leave the option out" in done.stderr


def test_constants_that_are_those_of_one_direction_are_told_as_that(hf: Run) -> None:
    """``hf close-loop`` writes so what it found of the weft beside a model of the warp."""
    warp = {"C10_MPa": 0.06}
    document = {
        "format": "hyperfab.material/1", "model": "yeoh-1", "parameters": warp,
        "directions": {"warp": {"parameters": warp}, "weft": {"parameters": {"C10_MPa": 0.045}}},
    }  # fmt: skip
    done = hf("export", "-", "--to", "abaqus", stdin=json.dumps(document).encode())
    assert b"the card has the constants of warp\n" in done.stderr


@pytest.mark.parametrize("modulus", [0.0, -5.0])
def test_a_document_without_a_bulk_modulus_above_zero_is_refused(hf: Run, modulus: float) -> None:
    document = {
        "format": "hyperfab.material/1", "model": "yeoh-1", "parameters": {"C10_MPa": 0.2},
        "bulk_modulus_MPa": modulus,
    }  # fmt: skip
    done = hf("export", "-", "--to", "abaqus", stdin=json.dumps(document).encode())
    assert done.returncode == 3
    assert b"key bulk_modulus_MPa: input should be greater than 0" in done.stderr
    assert done.stdout == b""


def test_a_sheet_written_by_hand_is_turned_too(hf: Run) -> None:
    """Its law has a warp and a weft, whether or not the document says again what each is."""
    constants = {"C10_MPa": 0.05, "k1_warp_MPa": 0.2, "k2_warp": 0.3}
    document = {"format": "hyperfab.material/1", "model": "orthotropic", "parameters": constants}
    for way, angle in (("warp", b"<theta>0.0</theta>"), ("weft", b"<theta>90.0</theta>")) * 2:
        done = hf("export", "-", "--to", "febio", "--direction", way, stdin=json.dumps(document).encode())
        assert done.returncode == 0
        assert angle in done.stdout
        if way == "weft":
            document["directions"] = {"warp": {"parameters": constants}}
    for _ in range(2):
        done = hf("export", "-", "--to", "febio", "--direction", "bias", stdin=json.dumps(document).encode())
        assert done.returncode == 2
        document.pop("directions", None)


@pytest.mark.parametrize("way", ["warp", "weft"])
def test_terms_added_to_a_law_are_in_the_card_that_can_hold_them(hf: Run, way: str) -> None:
    """A card of the constants alone bore several times the stress of the law that the loop had found."""
    constants = {"C10_MPa": 0.04}
    slopes = {f"D_{k}{side}_MPa": -0.02 + 0.006 * k for k in range(1, 10) for side in ("", "_weft")}
    form = {"reach": 2.0, "reach_weft": 1.0, **slopes, "D_9_weft_MPa": 0.1}
    document = {
        "format": "hyperfab.material/1", "model": "neo-hookean", "parameters": constants, "thickness_mm": 1.0,
        "directions": {one: {"parameters": constants} for one in ("warp", "weft")},
        "effects": [{"id": "elastic-law", "form": "smooth-strain-each-way", "parameters": form}],
    }  # fmt: skip
    told = json.dumps(document).encode()
    done = hf("export", "-", "--to", "abaqus", "--direction", way, stdin=told)
    assert done.returncode == 0
    assert b"without" not in done.stderr
    card = done.stdout.decode()
    assert "neo-hookean with the terms of elastic-law" in card
    rows = [tuple(map(float, line.split(","))) for line in card.split("TEST DATA\n")[1].splitlines()]
    law = FabricDocument(parse_document(document, "loop.json", MaterialDocument), "loop.json").material(way)
    stretches = 1.0 + np.array([strain for _, strain in rows])
    np.testing.assert_allclose([stress for stress, _ in rows], law.uniaxial(stretches).P, rtol=1e-12, atol=1e-15)
    for asked in (["--to", "abaqus"], ["--to", "ansys", "--direction", way]):
        lacks = hf("export", "-", *asked, stdin=told).stderr.decode()
        assert "without the effects elastic-law: at a stretch of 1.1 it bears" in lacks
    ratio = 2.0 * 0.04 * (1.1 - 1.1**-2) / float(law.uniaxial(1.1).P)
    assert f"it bears {ratio:.2g} times the stress" in lacks
