"""`hf report` as a command: what it writes, what it refuses, what costs a section only."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import ROOT, Run

from hyperfab.cases.about import ReportCase
from hyperfab.chapters.job import Job
from hyperfab.chapters.report import run
from hyperfab.console import Console
from hyperfab.errors import HyperfabError

FABRIC = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}


def report(*documents: Path, output: Path | str) -> int:
    """Write a page in this process."""
    names = [str(path) for path in documents]
    return run(
        Job("report", names, Console(quiet=True), target=str(output)),
        ReportCase(documents=tuple(names), title="Test"),
    )


@pytest.fixture
def fabric(tmp_path: Path) -> Path:
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    return tmp_path / "fabric.json"


def test_a_page_is_written_from_what_fit_wrote(hf: Run, tmp_path: Path) -> None:
    target = tmp_path / "fabric.json"
    data = ROOT / "specimens" / "treloar-1944" / "uniaxial.csv"
    assert hf("fit", "--uniaxial", data, "--model", "yeoh-3", "-o", target).returncode == 0
    done = hf("report", target, "-o", tmp_path / "report.html")
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == b""
    text = (tmp_path / "report.html").read_text()
    document = json.loads(target.read_bytes())
    for value in document["parameters"].values():
        assert f'title="{value!r} MPa"' in text
    assert "data:image/png;base64," in text
    assert len(text) < 8 * 2**20
    through = hf("report", "-", stdin=target.read_bytes())
    assert through.stdout.startswith(b"<!doctype html>")


def test_what_cannot_be_read_costs_its_section(fabric: Path, tmp_path: Path) -> None:
    (tmp_path / "newer.json").write_text(json.dumps({**FABRIC, "format": "hyperfab.material/9"}))
    (tmp_path / "torn.json").write_text('{"format": "hyperfab.drape/1", "conv')
    assert report(fabric, tmp_path / "newer.json", tmp_path / "torn.json", output=tmp_path / "r.html") == 3
    text = (tmp_path / "r.html").read_text()
    assert "has version 9 of the format" in text
    assert "is not valid JSON" in text
    assert "C10" in text


@pytest.mark.parametrize(
    ("documents", "output", "status", "words"),
    [
        (["fabric.json"], "report.pdf", 2, "ends in .html"),
        (["fabric.json"], "nowhere/report.html", 5, "does not exist"),
        (["none.json"], "report.html", 3, "no such file"),
        (["mold.json"], "report.html", 3, "is no document that a page can show"),
    ],
)
def test_bad_use_is_refused(
    fabric: Path, tmp_path: Path, documents: list[str], output: str, status: int, words: str
) -> None:
    (tmp_path / "mold.json").write_text('{"format": "hyperfab.mold/1"}')
    with pytest.raises(HyperfabError, match=words) as found:
        report(*(tmp_path / name for name in documents), output=tmp_path / output)
    assert found.value.exit_status == status
    assert not (tmp_path / "report.html").exists()


def test_a_document_brings_no_file_from_elsewhere_into_the_page(fabric: Path, tmp_path: Path) -> None:
    (tmp_path / "secret.csv").write_text(
        "test,direction,stretch,stress_MPa,stress_model_MPa,predicted\nkeep-out,,1,1,1,0\n"
    )
    inner = tmp_path / "in"
    inner.mkdir()
    for name in ("../secret.csv", str(tmp_path / "secret.csv")):
        (inner / "fabric.json").write_text(json.dumps({**FABRIC, "files": [name]}))
        assert report(inner / "fabric.json", output=tmp_path / "r.html") == 0
        assert "keep-out" not in (tmp_path / "r.html").read_text()
