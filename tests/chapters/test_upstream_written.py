"""The document upstream that is put right, and the commands that come from it to the model again."""

from __future__ import annotations

import hashlib
import json
import shlex
import tomllib
from pathlib import Path

import pytest
from loop.blind_chain import DRAPE, GAP, LAYOUT, Truth, fabric, foam, molds

from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.loop import LoopCase
from hyperfab.cases.mold import MoldCase
from hyperfab.cases.options import read
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.domain import Given, How
from hyperfab.chapters.close_loop.upstream_written import WRITTEN, Corrected, write
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import Kept, Listener
from hyperfab.io.toml_io import dump_toml

PRESS = ("--male", "male.stl", "--female", "female.stl", "--foam", "foam.toml", "--gap", f"{GAP}mm",
         "--tilt", "0.1deg,0deg")  # fmt: skip


@pytest.fixture
def given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Given:
    """A folder with a fabric, a sandwich of it, and a place for what is written."""
    monkeypatch.chdir(tmp_path)
    Path("fabric.json").write_bytes(fabric(Truth()))
    Path("foam.toml").write_bytes(foam(Truth()))
    for name in ("male.stl", "female.stl", "drape.json", "heat.json"):
        Path(name).write_bytes(b"")
    Path("out").mkdir()
    return Given({}, read(LoopCase, ("press.json",)), LAYOUT, How())


def written(given: Given, document: str, corrected: Corrected) -> tuple[Kept, str | None, list[list[str]]]:
    out = Kept("out/loop.json", WRITTEN)
    name, commands = write(Job("close-loop", (), Listener()), given, out, document, corrected)
    return out, name, [shlex.split(one) for one in commands]


def test_a_fabric_put_right_comes_to_the_press_by_its_drape_and_its_layers(given: Given) -> None:
    """The drape alone was told; the sandwich kept the old thickness, and the press missed by as much as before."""
    press = read(PressCase, (*PRESS, "--drape", "drape.json"))
    thicker = fabric(Truth(thick=0.6))
    corrected = Corrected(
        press, {}, thicker, press, between={"drape.json": read(DrapeCase, DRAPE)}, sandwich="foam.toml"
    )
    out, name, (drape, then) = written(given, "fabric.json", corrected)
    assert name == "loop.upstream.json"
    assert json.loads(out.siblings[".upstream.json"])["thickness_mm"] == 0.6
    assert drape[:3] == ["hf", "drape", "loop.upstream.json"]
    assert drape[-2:] == ["-o", "loop.upstream.drape.json"]
    asked = {key: then[then.index(key) + 1] for key in ("--foam", "--drape", "--male", "--tilt")}
    assert asked == {
        "--foam": "loop.upstream.foam.toml", "--drape": "loop.upstream.drape.json", "--male": "../male.stl",
        "--tilt": "0.1deg,0.0deg",
    }  # fmt: skip
    sandwich = tomllib.loads(out.siblings[".upstream.foam.toml"].decode())
    assert sandwich["fabric"] == {"above": "loop.upstream.json", "below": "loop.upstream.json"}


def test_a_fabric_that_is_a_layer_alone_is_taken_by_the_sandwich(given: Given) -> None:
    """The command that was told did not take the document that it was told for."""
    press = read(PressCase, PRESS)
    out, _, [command] = written(
        given, "fabric.json", Corrected(press, {}, fabric(Truth(thick=0.6)), press, sandwich="foam.toml")
    )
    assert command[command.index("--foam") + 1] == "loop.upstream.foam.toml"
    assert ".upstream.foam.toml" in out.siblings


def test_a_part_of_a_heat_document_is_named_as_seen_from_the_folder(given: Given) -> None:
    """As the document itself is; the mold put right comes to the press by the heat document that is made of it."""
    Path("mold.toml").write_bytes(dump_toml({"material": {}}))
    press = read(PressCase, (*PRESS, "--male-heat", "heat.json:cup", "--female-heat", "heat.json"))
    made = {"heat.json": read(MoldCase, ("mold.toml",))}
    _, name, (heat, then) = written(given, "mold.toml", Corrected(press, {}, b"[material]\n", press, between=made))
    assert name == "loop.upstream.toml"
    assert heat == ["hf", "mold-heat", "loop.upstream.toml", "-o", "loop.upstream.heat.json"]
    assert then[then.index("--male-heat") + 1] == "loop.upstream.heat.json:cup"
    # One that stays as it is.
    document = Corrected(press, {}, foam(Truth()), press)
    _, _, [command] = written(given, "foam.toml", document)
    assert command[command.index("--male-heat") + 1] == "../heat.json:cup"


def test_a_press_put_right_is_made_of_the_files_that_lie_there(given: Given) -> None:
    """It was pressed of a sandwich in memory, with a place for all that may be off, and refused as made of another."""
    for name, data in molds().items():
        Path(name).write_bytes(data)
    press = read(PressCase, (*PRESS, "--temperature", "150degC", "--strokes", "2"))
    in_memory = {"foam.toml": foam(Truth(foam={"thickness": 3.8}))}
    out, _, [command] = written(given, "", Corrected(press, in_memory, None, press))
    assert command[command.index("--temperature") + 1] == "150.0degC"
    document = json.loads(out.siblings[".upstream.json"])
    asked = {one["name"]: one["sha256"] for one in document["provenance"]["inputs"]}
    assert asked["../foam.toml"] == hashlib.sha256(Path("foam.toml").read_bytes()).hexdigest()
