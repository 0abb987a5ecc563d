"""The chain: each command's document is read by the next, from a file and through a pipe."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from builders import FILM, PLATE
from conftest import Run
from schemas import follows_schema

UNIAXIAL = "specimens/treloar-1944/uniaxial.csv"
FIT = ["fit", "--uniaxial", UNIAXIAL, "--model", "yeoh-3"]
DRAPE = ["--mold", "molds/cup-male.stl", "--grid", "24x24", "--size", "220mmx220mm", "--depth", "40mm"]
CONTACT = ["--sphere-radius", "40mm", "--depth", "20mm", "--mesh-size", "20mm"]
PRESS = ["press-contact", "--male", "molds/cup-male.stl", "--female", "molds/cup-female.stl", "--axis", "z"]
PRESS += ["--foam", "specimens/foam.toml", "--gap", "3mm", "--strokes", "5"]


def only_document(done: Any, kind: str) -> dict[str, Any]:
    """Return the document on standard output, valid against its schema, with nothing else beside it."""
    assert done.returncode == 0, done.stderr.decode()
    document: dict[str, Any] = json.loads(done.stdout)
    follows_schema(document, kind)
    assert document["format"] == f"hyperfab.{kind}/1"
    assert document["provenance"]["command"]
    assert done.stdout.endswith(b"}\n")
    return document


def test_fit_pipes_into_fabric_contact(hf: Run) -> None:
    fitted = hf(*FIT)
    only_document(fitted, "material")
    document = only_document(hf("fabric-contact", "-", *CONTACT, stdin=fitted.stdout), "contact")
    assert document["converged"]
    assert document["provenance"]["inputs"][0]["name"] == "-"


def test_the_arguments_are_told_as_they_were_given(hf: Run) -> None:
    """A flag that is taken back is none that was set."""
    document = only_document(hf("fit", "--quiet", "--no-zero", "--model", "yeoh-3", UNIAXIAL), "material")
    assert document["provenance"]["arguments"] == ["--no-zero", UNIAXIAL, "--model", "yeoh-3"]


def test_fit_pipes_into_drape_and_its_file_into_press(hf: Run, tmp_path: Path) -> None:
    fitted = hf(*FIT)
    # The press needs the field of thickness, which lies beside the document: so this pair meets through a file.
    target = tmp_path / "drape.json"
    draped = hf("drape", "-", *DRAPE, "-o", target, stdin=fitted.stdout)
    assert draped.returncode == 0
    # The answer first: field and picture may take as long again.
    assert draped.stderr.index(b"stretch up to") < draped.stderr.index(b"written: ")
    assert json.loads(target.read_bytes())["converged"]
    with_drape = only_document(hf(*PRESS, "--drape", target, "--temperature", "200degC"), "press")
    without = only_document(hf(*PRESS, "--temperature", "200degC"), "press")
    assert with_drape["contact_area_mm2"] != without["contact_area_mm2"]


@pytest.mark.slow
def test_a_foam_pipes_into_press(hf: Run, tmp_path: Path) -> None:
    foam = only_document(hf("fit", "--uniaxial", "specimens/foam.csv", "--model", "hyperfoam-1"), "material")
    given = json.dumps(foam | {"thickness_mm": 10.0}).encode()
    (tmp_path / "foam.json").write_bytes(given)
    last = PRESS.index("--foam") + 1
    press = [*PRESS[:last], "{}", *PRESS[last + 1 :], "--temperature", "200degC"]
    piped = only_document(hf(*[word.format("-") for word in press], stdin=given), "press")
    named = only_document(hf(*[word.format(tmp_path / "foam.json") for word in press]), "press")
    assert piped["contact_area_mm2"] == named["contact_area_mm2"] > 0.0


def test_mold_heat_pipes_into_press(hf: Run, tmp_path: Path) -> None:
    (tmp_path / "plate.toml").write_text(PLATE)
    (tmp_path / "film.csv").write_bytes(FILM)
    heated = hf("mold-heat", tmp_path / "plate.toml")
    document = only_document(heated, "heat")
    assert document["warmup_time_s"] > 0
    (tmp_path / "heat.json").write_bytes(heated.stdout)
    options = ["--male-heat", "-", "--female-heat", tmp_path / "heat.json"]
    only_document(hf(*PRESS, *options, stdin=heated.stdout), "press")


def test_a_document_of_another_kind_is_refused_by_name(hf: Run) -> None:
    fitted = hf(*FIT)
    done = hf(*PRESS, "--temperature", "200degC", "--drape", "-", stdin=fitted.stdout)
    assert done.returncode == 3
    assert b"is a material document, a drape document is needed" in done.stderr


def test_what_is_listed_under_files_is_there(hf: Run, tmp_path: Path) -> None:
    target = tmp_path / "fabric.json"
    assert hf(*FIT, "-o", target).returncode == 0
    document = json.loads(target.read_bytes())
    assert {path.name for path in tmp_path.iterdir()} == {"fabric.json", *document["files"]}
    assert any(name.endswith(".png") for name in document["files"])


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_summary_reads_what_fit_wrote(hf: Run, tmp_path: Path, quiet: list[str]) -> None:
    target = tmp_path / "fabric.json"
    assert hf(*FIT, "-o", target, *quiet).returncode == 0
    done = hf("summary", target)
    assert done.returncode == 0
    assert "yeoh-3" in done.stdout.decode()


def test_close_loop_extends_a_fabric_that_drape_takes(hf: Run, tmp_path: Path) -> None:
    warp = tmp_path / "warp.json"
    assert hf("fit", "--uniaxial", "specimens/lycra/warp-23C.csv", "--model", "yeoh-3", "-o", warp).returncode == 0
    tests = [f"--measured=specimens/lycra/{way}-{heat}C.csv" for way in ("warp", "weft") for heat in (23, 80, 105)]
    assert hf("close-loop", warp, *tests, "-o", tmp_path / "loop.json").returncode == 0
    found = json.loads((tmp_path / "loop.json").read_bytes())
    assert [effect["id"] for effect in found["effects"]] == ["anisotropy", "thermal-softening"]
    assert found["error"]["after"]["rms"] < 0.1 * found["error"]["before"]["rms"]
    before = only_document(hf("drape", warp, *DRAPE), "drape")
    after = only_document(hf("drape", tmp_path / found["model"], *DRAPE), "drape")
    # The warp alone took the fabric for as stiff across as along; the weft is softer.
    assert after["force_N"] < 0.95 * before["force_N"]
    told = hf("summary", tmp_path / "loop.json")
    assert told.returncode == 0
    assert "verdict: effect" in told.stdout.decode()
