"""`hf sweep` as a command: what it refuses before anything runs, and real commands in one study."""

from __future__ import annotations

import csv
import json
import os
import sys
from pathlib import Path

import jsonschema
import pytest
from conftest import ROOT, Run

from hyperfab.cases.sweep import SweepCase
from hyperfab.chapters.job import Job
from hyperfab.chapters.sweep import run
from hyperfab.console import Console
from hyperfab.documents.base import schema
from hyperfab.errors import HyperfabError, UsageError

STUDY = f"""
format = "hyperfab.study/1"
name = "Laws"
[axis.model]
values = ["neo-hookean", "yeoh-2"]
[[step]]
name = "fit"
command = "fit"
arguments = ["--uniaxial", "{ROOT}/specimens/treloar-1944/uniaxial.csv", "--model", "{{model}}"]
[figures]
relative_rms = "fit.fit.relative_rms"
"""


def sweep(hf: Run, folder: Path, study: str, *options: str) -> tuple[int, str]:
    """Run a study; return the status and what was said."""
    (folder / "study.toml").write_text(study)
    done = hf("sweep", folder / "study.toml", "--out", folder / "out", *options)
    return done.returncode, done.stderr.decode()


@pytest.mark.parametrize(
    ("old", "new", "status", "words"),
    [
        ('name = "Laws"', 'nmae = "Laws"', 3, "nmae: is not a key of this document"),
        ('values = ["neo-hookean", "yeoh-2"]', "values = []", 3, "the axis is empty"),
        ("fit.fit.relative_rms", "fit.fit.relative_rsm", 3, "hf fit writes no fit.relative_rsm"),
        ("fit.fit.relative_rms", "fit.models.0.mdoel", 3, "hf fit writes no models.0.mdoel"),
        ('"neo-hookean", "yeoh-2"', "1, 1.0", 3, "a value stands twice"),
        ("fit.fit.relative_rms", "fat.fit.relative_rms", 3, "begins with no step"),
        ('command = "fit"', 'command = "fitt"', 3, "close-loop; hf --help lists the commands"),
        ('"--model"', '"--modle"', 3, "hf fit has no option --modle; --model may be meant"),
        ("{model}", "{modell}", 3, "{modell} is no axis, document or earlier step"),
        ('"{model}"]', '"yeoh-3"]', 3, "axis.model: changes no step"),
        (
            'values = ["neo-hookean", "yeoh-2"]',
            "range = { from = 1, to = 2, count = 1000000 }\n[axis.b]\nvalues = [1, 2]",
            2,
            "need --yes",
        ),
        ("[[step]]", "[axis.d]\nnormal = { mean = 1, sd = 1 }\n[[step]]", 3, "add [sampling]"),
        (
            'values = ["neo-hookean", "yeoh-2"]',
            'range = { from = "1 mm", to = "2 K", count = 3 }',
            3,
            "different units",
        ),
        ("[figures]", "[pareto]\nminimize = ['a', 'relative_rms']\n[figures]", 3, "pareto asks for 'a'"),
    ],
)
def test_what_cannot_work_is_refused_by_name_before_anything_runs(
    tmp_path: Path, old: str, new: str, status: int, words: str
) -> None:
    assert old in STUDY
    (tmp_path / "study.toml").write_text(STUDY.replace(old, new))
    with pytest.raises(HyperfabError) as found:
        run(
            Job("sweep", [], Console()),
            SweepCase(study=str(tmp_path / "study.toml"), out=str(tmp_path / "out"), jobs=1),
        )
    assert found.value.exit_status == status
    assert words in str(found.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("address", ["foo", "tcp://foo", "tcp://10.0.0.5:", "10.0.0.5/8786"])
def test_an_address_that_is_none_is_refused_before_anyone_is_called(address: str) -> None:
    with pytest.raises(UsageError, match=r"as tcp://10\.0\.0\.5:8786"):
        SweepCase(study="study.toml", out="out", scheduler=address).check()
    for good in ("127.0.0.1:8786", "tls://shop.example:8786", "tcp://[::1]:8786"):
        SweepCase(study="study.toml", out="out", scheduler=good).check()


def test_real_commands_run_in_warm_workers(hf: Run, tmp_path: Path) -> None:
    status, said = sweep(hf, tmp_path, STUDY)
    assert status in (0, 1), said  # 1: neo-Hooke is not accepted on Treloar's rubber
    assert "2 cases, 2 steps at most\n" in said  # before anything ran
    document = json.loads((tmp_path / "out" / "sweep.json").read_bytes())
    jsonschema.validate(document, schema("sweep"))
    assert document["figures"]["relative_rms"]["cases"] == 2
    assert all((tmp_path / "out" / name).exists() for name in document["files"])
    # The step's document is what the command itself writes, but for the place it stands in.
    table = (tmp_path / "out" / "sweep.csv").read_text().splitlines()
    row = dict(zip(table[0].split(","), table[1].split(","), strict=True))
    place = tmp_path / "out" / row[next(name for name in row if name.endswith("_document"))]
    alone = hf("fit", "--uniaxial", ROOT / "specimens/treloar-1944/uniaxial.csv", "--model", "neo-hookean")
    step, command = json.loads(place.read_bytes()), json.loads(alone.stdout)
    assert step["parameters"] == command["parameters"]
    assert step["fit"] == command["fit"]


def test_the_table_as_parquet_holds_what_the_csv_holds(hf: Run, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed (pip install 'hyperfab[parquet]')")
    import pandas

    (tmp_path / "study.toml").write_text(STUDY)
    paths = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}  # wherever pyarrow is
    command = ("sweep", tmp_path / "study.toml", "--out", tmp_path / "out", "--parquet", "--jobs", "1")
    done = hf(*command, env=paths)
    assert done.returncode in (0, 1), done.stderr
    document = json.loads((tmp_path / "out" / "sweep.json").read_bytes())
    assert "sweep.parquet" in document["files"]
    found = pandas.read_parquet(tmp_path / "out" / "sweep.parquet")
    told = pandas.read_csv(tmp_path / "out" / "sweep.csv")
    assert list(found.columns) == list(told.columns)
    assert found["model"].tolist() == ["neo-hookean", "yeoh-2"]
    assert found["relative_rms"].dtype == "float64"
    assert found["relative_rms"].tolist() == told["relative_rms"].tolist()
    assert found["status"].tolist() == told["status"].tolist()


def test_figures_may_be_of_what_has_a_name_of_its_own(hf: Run, tmp_path: Path) -> None:
    figures = 'uniaxial = "fit.fit.tests.uniaxial.relative_rms"\nleast = "fit.validity.0.used.0"\n'
    sweep(hf, tmp_path, STUDY + figures)
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert all(row["uniaxial"] == row["relative_rms"] and row["least"] for row in rows)
