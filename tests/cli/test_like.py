"""``--like``: an earlier document gives the set-up, inputs and all; what is given beside it wins."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import pytest
import trimesh
from builders import plate
from conftest import ROOT, Run

from hyperfab.cases.like import earlier
from hyperfab.cases.sweep import SweepCase
from hyperfab.documents.provenance import record
from hyperfab.io.inputs import Inputs
from hyperfab.io.stl_write import stl_bytes

FABRIC = {
    "format": "hyperfab.material/1",
    "model": "neo-hookean",
    "parameters": {"C10_MPa": 0.2},
    "thickness_mm": 0.8,
    "temperature_degC": 23.0,
}
#: The words of each command, and an option that changes its result: its words, and its key in ``setup``.
RUNS: dict[str, tuple[list[str], tuple[str, str], str]] = {
    "fit": (["warp.csv", "--model", "neo-hookean", "--thickness", "0.5mm"], ("--objective", "absolute"), "objective"),
    "close-loop": (["fabric.json", "warp.csv", "--noise", "2kPa"], ("--noise", "4kPa"), "noise"),
    "drape": (
        ["fabric.json", "--mold", "ball.stl", "--grid", "15x13", "--size", "200mm", "--depth", "30mm", "--friction",
         "0.2", "--load-steps", "3"],
        ("--friction", "0.1"),
        "friction",
    ),
    "fabric-contact": (
        ["fabric.json", "--size", "200mm", "--depth", "20mm", "--steps", "2", "--mesh-size", "20mm", "--tolerance",
         "1e-2"],
        ("--friction", "0.2"),
        "friction_coefficient",
    ),
    "mold-heat": (
        ["mold.toml", "--warmup-in", "50s"],
        ("--warmup-in", "60s"),
        "warmup_in_s",
    ),
    "press-contact": (
        ["--male", "male.stl", "--female", "female.stl", "--foam", "foam.toml", "--gap", "1mm", "--tilt",
         "0.05deg,0deg", "--strokes", "3", "--temperature", "60 degC +- 5 K"],
        ("--strokes", "4"),
        "strokes",
    ),
}  # fmt: skip
MOLD = (
    plate(40, 30, 10)
    + """[[heater]]
on = "plate.z-"
power = "100 W"
[work_surface]
on = "plate.z+"
[run]
start = "25 degC"
target = "60 degC"
until = "200 s"
mesh_size = "10 mm"
"""
)
#: Neo-Hooke, and a little that is not.
TEST = "# test: uniaxial\nstretch [-],stress [MPa]\n" + "".join(
    f"{lam},{0.4 * (lam - lam**-2) + 0.002 * ((7 * k) % 5 - 2)}\n"
    for k, lam in enumerate(1.02 + 0.02 * n for n in range(25))
)
FOAM = """
format = "hyperfab.foam/1"
thickness = "3 mm"
compression = { law = "linear", modulus = "0.1 MPa" }
"""


def without(document: dict[str, Any], stem: str = "a") -> dict[str, Any]:
    """Return the document less its provenance, its siblings named as those of ``a.json`` are."""
    kept = {key: value for key, value in document.items() if key != "provenance"}
    found: dict[str, Any] = json.loads(json.dumps(kept).replace(f'"{stem}.', '"a.'))
    return found


@pytest.fixture(scope="module", params=RUNS)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, hf: Run) -> tuple[str, Path]:
    """A folder in which a command was run: its document is ``a.json``."""
    folder = tmp_path_factory.mktemp("like") / "shop"
    folder.mkdir()
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=60.0)
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    (folder / "fabric.json").write_text(json.dumps(FABRIC))
    (folder / "mold.toml").write_text(MOLD)
    (folder / "warp.csv").write_text(TEST)
    (folder / "foam.toml").write_text(FOAM)
    write_molds(folder)
    done = hf(request.param, *RUNS[request.param][0], "-o", "a.json", cwd=folder)
    assert done.returncode in (0, 1), done.stderr.decode()
    return request.param, folder


def write_molds(folder: Path) -> None:
    for name, low in (("male", 0.0), ("female", 10.0)):
        box = trimesh.creation.box((40.0, 30.0, 10.0)).apply_translation((0.0, 0.0, low))
        (folder / f"{name}.stl").write_bytes(stl_bytes(box.vertices, box.faces))


def run(hf: Run, command: str, folder: Path, *words: str, name: str = "b.json") -> dict[str, Any]:
    done = hf(command, *words, "-o", name, cwd=folder)
    assert done.returncode in (0, 1), done.stderr.decode()
    found: dict[str, Any] = json.loads((folder / name).read_text())
    return found


def test_the_same_set_up_gives_the_same_document_from_another_folder(made: tuple[str, Path], hf: Run) -> None:
    command, folder = made
    first = json.loads((folder / "a.json").read_text())
    other = folder.parent / "elsewhere"
    other.mkdir(exist_ok=True)
    again = run(hf, command, other, "--like", "../shop/a.json", name="c.json")
    assert without(again, "c") == without(first)
    for curves in folder.glob("a.csv"):
        assert (other / "c.csv").read_bytes() == curves.read_bytes()


def test_inputs_of_one_name_are_told_apart_by_their_folders(tmp_path: Path, hf: Run) -> None:
    for cut in ("warp", "weft"):
        (tmp_path / cut).mkdir()
        (tmp_path / cut / "pull.csv").write_text(TEST)
    document = run(
        hf,
        "fit",
        tmp_path,
        "warp/pull.csv",
        "weft/pull.csv",
        "--model",
        "neo-hookean",
        "--thickness",
        "0.5mm",
    )
    assert document["preparation"][0].startswith("warp/pull.csv, weft/pull.csv: ")


def test_what_a_drape_takes_unasked_stands_in_its_set_up(tmp_path: Path, hf: Run) -> None:
    setup = json.loads((drape(tmp_path, hf) / "a.json").read_text())["setup"]
    assert (setup["temperature_degC"], setup["slide"]) == (23.0, [])
    assert setup["derived"] == ["thickness_mm", "temperature_degC", "slide"]


def test_sources_of_uncertainty_are_called_alike_wherever_the_command_runs(tmp_path: Path, hf: Run) -> None:
    write_molds(tmp_path)
    (tmp_path / "foam.toml").write_text(FOAM.replace("3 mm", "3 mm +- 0.1 mm"))
    (tmp_path / "out").mkdir()
    first = run(hf, "press-contact", tmp_path, *RUNS["press-contact"][0], name="out/a.json")
    again = run(hf, "press-contact", tmp_path / "out", "--like", "a.json")
    assert without(again, "b") == without(first)
    assert "foam.toml: thickness" in [one["source"] for one in first["uncertainty"]["sources"]]


def test_an_option_given_wins_and_nothing_else_of_the_set_up_changes(made: tuple[str, Path], hf: Run) -> None:
    command, folder = made
    first = json.loads((folder / "a.json").read_text())
    _, words, key = RUNS[command]
    again = run(hf, command, folder, "--like", "a.json", *words)
    changed = {name for name in again["setup"] if again["setup"][name] != first["setup"].get(name)}
    # What the coefficient is called in words follows from it.
    assert changed - {"friction"} == {key} - {"friction"}
    assert without(again, "b") != without(first)


def test_a_document_without_setup_is_read_by_its_words(made: tuple[str, Path], hf: Run) -> None:
    command, folder = made
    first = json.loads((folder / "a.json").read_text())
    old = {key: value for key, value in first.items() if key != "setup"}
    if command == "fabric-contact":
        old["setup"] = {key: value for key, value in first["setup"].items() if key != "sha256"}
    (folder / "old.json").write_text(json.dumps(old))
    assert without(run(hf, command, folder, "--like", "old.json"), "b") == without(first)


def drape(tmp_path: Path, hf: Run) -> Path:
    """A folder with a draped ball."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=60.0)
    (tmp_path / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    words = ("--grid", "9x9", "--size", "200mm", "--depth", "10mm")
    run(hf, "drape", tmp_path, "fabric.json", "--mold", "ball.stl", *words, name="a.json")
    return tmp_path


def test_inputs_that_moved_are_found_changed_ones_told_and_missing_ones_named(tmp_path: Path, hf: Run) -> None:
    folder = drape(tmp_path, hf)
    (folder / "molds").mkdir()
    (folder / "ball.stl").rename(folder / "molds" / "ball.stl")
    done = hf("drape", "--like", "a.json", "-o", "b.json", cwd=folder)
    assert done.returncode == 0
    assert b"changed" not in done.stderr
    (folder / "fabric.json").write_text(json.dumps(FABRIC | {"thickness_mm": 0.9}))
    done = hf("drape", "--like", "a.json", "-o", "c.json", cwd=folder)
    assert done.returncode == 0
    assert b"fabric.json has changed since a.json was made from it" in done.stderr
    assert json.loads((folder / "c.json").read_text())["setup"]["thickness_mm"] == 0.9
    (folder / "molds" / "ball.stl").unlink()
    done = hf("drape", "--like", "a.json", "-o", "d.json", cwd=folder)
    assert done.returncode == 3
    assert b"ball.stl" in done.stderr
    assert b"no such file" in done.stderr


def test_a_namesake_of_an_input_that_is_gone_is_named(tmp_path: Path, hf: Run) -> None:
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "warp.csv").write_text("# test: uniaxial\nstretch,stress [MPa]\n1.1,0.3\n1.2,0.5\n1.4,0.9\n")
    words = ["fit", "tests/warp.csv", "--model", "neo-hookean", "--accept", "1", "-o", "a.json"]
    assert hf(*words, cwd=tmp_path).returncode == 0
    (tmp_path / "tests" / "warp.csv").unlink()
    (tmp_path / "warp.csv").write_text("another")
    done = hf("fit", "--like", "a.json", cwd=tmp_path)
    assert done.returncode == 3
    assert b"no such file; a.json was made from it, and warp.csv is another one or has changed" in done.stderr
    done = hf("fit", "--like", "-", cwd=tmp_path, stdin=(tmp_path / "a.json").read_bytes())
    assert b"the document was made from it" in done.stderr


def test_files_that_a_study_names_by_their_place_are_told_where_they_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A study reads its files by their whole place, and one too far from the document is known by its bare name."""
    files = {"shop/near.csv": "1", "shop/out/in.csv": "1", "far/off/away.csv": "1", "far/off/same.csv": "1"}
    inputs = Inputs()
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shop" / "study.toml").write_text("")
    hashes = {"study": hashlib.sha256(b"").hexdigest()}
    read = [inputs.read("shop/study.toml"), *(inputs.read(str(tmp_path / name)) for name in files)]
    assert len(read) == 5
    provenance = record("sweep", ["shop/study.toml"], inputs.files, "shop/out/sweep.json")
    assert [one.name for one in provenance.inputs][3:] == ["away.csv", "same.csv"]
    document = {
        "format": "hyperfab.sweep/1", "name": "n", "cases": 0, "steps": 0, "by_status": {}, "axes": {}, "figures": {},
        "table": "t.csv",
        "provenance": provenance.model_dump(), "setup": {"study": "study.toml", "sha256": hashes},
    }  # fmt: skip
    made = earlier(SweepCase, document, "shop/out/sweep.json", ())
    for name in list(files)[:3]:
        (tmp_path / name).write_text("2")
    again = Inputs()
    for name in files:
        again.read(str(tmp_path / name))
    assert made.altered(inputs) == []
    told = [os.path.relpath(name, tmp_path) if os.path.isabs(name) else name for name in made.altered(again)]
    assert told == list(files)[:3]


@pytest.mark.slow
def test_a_study_is_taken_up_from_its_document(tmp_path: Path, hf: Run) -> None:
    (tmp_path / "warp.csv").write_text(TEST)
    (tmp_path / "study.toml").write_text(
        'format = "hyperfab.study/1"\nname = "Laws"\n[axis.model]\nvalues = ["neo-hookean"]\n[[step]]\nname = "fit"\n'
        'command = "fit"\narguments = ["warp.csv", "--model", "{model}"]\n[figures]\nrms = "fit.fit.relative_rms"\n'
    )
    done = hf("sweep", "study.toml", "--out", "a", "--jobs", "1", cwd=tmp_path)
    assert done.returncode in (0, 1), done.stderr.decode()
    (tmp_path / "else").mkdir()
    done = hf("sweep", "--like", "../a/sweep.json", "--out", "../b", "--jobs", "1", cwd=tmp_path / "else")
    assert done.returncode in (0, 1), done.stderr.decode()
    first, again = (json.loads((tmp_path / folder / "sweep.json").read_text()) for folder in "ab")
    assert without(again) == without(first)


def test_a_document_of_another_kind_is_refused(tmp_path: Path, hf: Run) -> None:
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    done = hf("drape", "--like", "fabric.json", cwd=tmp_path)
    assert done.returncode == 3
    assert b"a drape document is needed" in done.stderr


def test_readme_explains_it() -> None:
    assert "`--like" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_a_document_that_people_write_comes_by_a_pipe_or_under_another_name(hf: Run, tmp_path: Path) -> None:
    (tmp_path / "mold.txt").write_text(MOLD)
    piped = hf("mold-heat", "-", stdin=MOLD.encode(), cwd=tmp_path)
    named = hf("mold-heat", "mold.txt", cwd=tmp_path)
    assert piped.returncode == named.returncode == 0, piped.stderr.decode() + named.stderr.decode()
    one, other = json.loads(piped.stdout), json.loads(named.stdout)
    assert one["probes"] == other["probes"]
    assert one["energy"] == other["energy"]
