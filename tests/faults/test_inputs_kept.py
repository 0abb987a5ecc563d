"""No output overwrites an input: not by a sibling's name, not through a table that a document names, not by a link."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from builders import plate

Run = Callable[..., object]

PLATE = (
    plate(60, 40, 10)
    + """[[heater]]
on = "plate.z-"
POWER
[[convection]]
on = "exposed"
h = FILM
ambient = "25 degC"
[[probe]]
name = "edge"
at = ["1 mm", "1 mm", "10 mm"]
[[probe]]
name = "middle"
at = ["30 mm", "20 mm", "10 mm"]
[work_surface]
on = "plate.z+"
[run]
start = "25 degC"
until = "60 s"
mesh_size = "20 mm"
"""
)
FILM = "temperature [degC],h [W/m^2/K]\n0,10\n100,12\n300,20\n"
SCHEDULE = "time [s],power [W]\n0,0\n10,100\n60,100\n"


def plate(power: str = 'power = "100 W"', film: str = '"12 W/m^2/K"') -> str:
    return PLATE.replace("POWER", power).replace("FILM", film)


@dataclass(frozen=True)
class Case:
    """A command, the files it needs, and the input that one of its outputs would be called like."""

    name: str
    words: str
    files: dict[str, str]
    input: str
    #: Where the output goes instead; None: the command is refused.
    instead: str | None = None


TEST = "specimens/treloar-1944/uniaxial.csv"
CASES = (
    Case("a curve named like a test", "fit --uniaxial k17.csv --model yeoh-1 -o k17.json",
         {"k17.csv": f"@{TEST}"}, "k17.csv", "k17.out.csv"),
    Case("a curve named like a test through another link",
         "fit --uniaxial test.csv --model yeoh-1 -o k17.json",
         {"test.csv": f"@{TEST}", "k17.csv": "=test.csv"}, "k17.csv", "k17.out.csv"),
    Case("both names taken", "fit --uniaxial k17.csv --uniaxial k17.out.csv --model yeoh-1 -o k17.json",
         {"k17.csv": f"@{TEST}", "k17.out.csv": "@specimens/lycra/warp-23C.csv"}, "k17.out.csv"),
    Case("a picture named like a test", "fit --uniaxial k17.png --model yeoh-1 -o k17.json",
         {"k17.png": f"@{TEST}"}, "k17.png"),
    Case("the document itself", "drape fabric.json --mold m.stl -o fabric.json",
         {"fabric.json": "@fabric.json", "m.stl": "@molds/cup-male.stl"}, "fabric.json"),
    Case("the document itself by a hard link", "drape fabric.json --mold m.stl -o other.json",
         {"fabric.json": "@fabric.json", "other.json": "=fabric.json", "m.stl": "@molds/cup-male.stl"},
         "other.json"),
    Case("a variations table", "mold-heat plate.toml --variations heat.variations.csv -o heat.json",
         {"plate.toml": plate(), "heat.variations.csv": "power\n1.1\n"},
         "heat.variations.csv"),
    Case("a schedule", "mold-heat m.toml -o h2.json",
         {"m.toml": plate('schedule = "h2.history.csv"'), "h2.history.csv": SCHEDULE}, "h2.history.csv"),
    Case("a schedule named like the curves", "mold-heat m.toml -o h2.json",
         {"m.toml": plate('schedule = "h2.csv"'), "h2.csv": SCHEDULE}, "h2.csv", "h2.out.csv"),
    Case("a table that the extended mold would have", "close-loop m4.toml --measured tc.csv -o loop.json",
         {"m4.toml": plate(film='{ table = "loop.film-0.csv" }'), "loop.film-0.csv": FILM,
          "tc.csv": "time [s],edge [degC],middle [degC]\n"
          + "".join(f"{t},{25 + 0.9 * t},{25 + 0.92 * t}\n" for t in range(0, 60, 3))},
         "loop.film-0.csv"),
    Case("a card by a hard link", "export fabric.json --to abaqus -o card.inp",
         {"fabric.json": "@fabric.json", "card.inp": "=fabric.json"}, "card.inp"),
    Case("a page by a hard link", "report fabric.json -o page.html",
         {"fabric.json": "@fabric.json", "page.html": "=fabric.json"}, "page.html"),
)  # fmt: skip


@pytest.fixture(scope="module")
def fabric(hf: Run, root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fabric")
    done = hf("fit", "--uniaxial", root / TEST, "--model", "yeoh-1", "-o", folder / "fabric.json")
    assert done.returncode in (0, 1)
    return folder / "fabric.json"


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_no_output_overwrites_an_input(case: Case, hf: Run, root: Path, fabric: Path, tmp_path: Path) -> None:
    for name, content in case.files.items():
        if content.startswith("="):
            os.link(tmp_path / content[1:], tmp_path / name)
        elif content.startswith("@"):
            shutil.copy(fabric if content == "@fabric.json" else root / content[1:], tmp_path / name)
        else:
            (tmp_path / name).write_text(content)
    before = {name: (tmp_path / name).read_bytes() for name in case.files}

    done = hf(*case.words.split(), cwd=tmp_path)

    assert {name: (tmp_path / name).read_bytes() for name in case.files} == before
    if case.instead is None:
        assert done.returncode == 2, done.stderr
        assert case.input in done.stderr.decode()
        assert "is an input of this command; choose another name" in done.stderr.decode()
        assert {path.name for path in tmp_path.iterdir()} == set(case.files)  # nothing was written at all
    else:
        assert done.returncode in (0, 1), done.stderr
        document = json.loads((tmp_path / case.words.split()[-1]).read_text())
        assert case.instead in document["files"]
        assert all((tmp_path / name).is_file() for name in document["files"])
        recorded = {item["name"]: item["sha256"] for item in document["provenance"]["inputs"]}
        read = next(name for name in case.files if name in recorded)
        assert recorded[read] == hashlib.sha256(before[read]).hexdigest()


WARP, WEFT = "specimens/lycra/warp-23C.csv", "specimens/lycra/weft-23C.csv"


@pytest.mark.parametrize(
    ("words", "input", "endings"),
    [
        (f"fit --uniaxial {WARP} --model yeoh-1", WARP, (".json", ".csv", ".png")),
        (f"close-loop fabric.json --measured {WARP} --measured {WEFT}", WEFT, (".model.json", ".png")),
        ("mold-heat plate.toml", "plate.toml", (".vtu", ".000.vtu", ".pvd", ".csv")),
        ("drape fabric.json --mold molds/cup-male.stl --grid 21x21 --depth 10mm --states 2",
         "molds/cup-male.stl", (".002.vtu", ".pvd")),
    ],
    ids=lambda value: value.split()[0] if isinstance(value, str) else None,
)  # fmt: skip
def test_each_file_a_command_writes_spares_an_input_of_its_name(
    words: str,
    input: str,
    endings: tuple[str, ...],
    hf: Run,
    root: Path,
    fabric: Path,
    tmp_path: Path,
) -> None:
    for ending in endings:
        folder = tmp_path / ending
        shutil.copytree(root / "specimens/lycra", folder / "specimens/lycra")
        (folder / "molds").mkdir()
        shutil.copy(root / "molds/cup-male.stl", folder / "molds")
        shutil.copy(fabric, folder / "fabric.json")
        (folder / "plate.toml").write_text(plate())
        os.link(folder / input, folder / f"out{ending}")
        before = (folder / input).read_bytes()
        done = hf(*words.split(), "-o", "out.json", cwd=folder)
        assert (folder / input).read_bytes() == before
        assert (folder / f"out{ending}").read_bytes() == before
        if ending == ".csv":
            assert done.returncode in (0, 1), done.stderr
            assert "out.out.csv" in json.loads((folder / "out.json").read_text())["files"]
        else:
            assert done.returncode == 2, done.stderr
            assert f"out{ending} is an input of this command" in done.stderr.decode()


def test_a_curve_that_gave_way_is_found_by_later_commands_and_goes_when_no_longer_written(
    hf: Run, root: Path, tmp_path: Path
) -> None:
    shutil.copy(root / TEST, tmp_path / "k17.csv")
    fit = ("fit", "--uniaxial", "k17.csv", "--model", "yeoh-1", "-o", "k17.json")
    assert hf(*fit, cwd=tmp_path).returncode in (0, 1)
    first = (tmp_path / "k17.json").read_bytes()
    assert hf(*fit, cwd=tmp_path).returncode in (0, 1)  # its own earlier curve is no obstacle
    assert (tmp_path / "k17.json").read_bytes() == first
    page = hf("report", "k17.json", "-o", "page.html", cwd=tmp_path)
    assert page.returncode == 0
    assert b"k17.out.csv" not in page.stderr
    assert b"Measured stress (rings)" in (tmp_path / "page.html").read_bytes()
    shutil.copy(tmp_path / "k17.csv", tmp_path / "test.csv")
    (tmp_path / "k17.csv").unlink()
    assert hf(*(word.replace("k17.csv", "test.csv") for word in fit), cwd=tmp_path).returncode in (0, 1)
    assert not (tmp_path / "k17.out.csv").exists()
    assert (tmp_path / "k17.csv").is_file()


def test_a_name_without_an_ending_gets_its_own_and_the_null_device_takes_a_document(
    hf: Run, root: Path, tmp_path: Path
) -> None:
    fit = ("fit", "--uniaxial", root / TEST, "--model", "yeoh-1")
    assert hf(*fit, "-o", "fabric", cwd=tmp_path).returncode in (0, 1)
    assert (tmp_path / "fabric.json").is_file()
    done = hf(*fit, "-o", os.devnull, cwd=tmp_path)
    assert done.returncode in (0, 1)
    assert done.stdout == b""
    assert hf("report", "fabric.json", "-o", "page", cwd=tmp_path).returncode == 0
    assert (tmp_path / "page.html").is_file()


@pytest.mark.parametrize("head", [b"time [s],T1 [degC]", b"time_s,T1_degC"])
def test_curves_give_way_to_a_table_that_was_measured_and_go_back_when_it_is_gone(
    hf: Run, root: Path, tmp_path: Path, head: bytes
) -> None:
    shutil.copy(root / TEST, tmp_path / "test.csv")
    log = head + b"\n0,25.0\n60,31.5\n"
    (tmp_path / "k17.csv").write_bytes(log)
    fit = ("fit", "--uniaxial", "test.csv", "--model", "yeoh-1", "-o", "k17.json")
    for _ in range(2):
        assert hf(*fit, cwd=tmp_path).returncode in (0, 1)
        assert (tmp_path / "k17.csv").read_bytes() == log
        assert "k17.out.csv" in json.loads((tmp_path / "k17.json").read_text())["files"]
    (tmp_path / "k17.csv").unlink()
    for _ in range(2):
        assert hf(*fit, cwd=tmp_path).returncode in (0, 1)
        assert "k17.csv" in json.loads((tmp_path / "k17.json").read_text())["files"]
        assert not (tmp_path / "k17.out.csv").exists()
    (tmp_path / "k17.json").unlink()  # a table of hf's own is known by its head
    assert hf(*fit, cwd=tmp_path).returncode in (0, 1)
    assert not (tmp_path / "k17.out.csv").exists()
