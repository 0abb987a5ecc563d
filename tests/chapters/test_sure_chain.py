"""What is shared down the chain is one source: against the whole chain run anew with a number of it moved."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.rerun import rerun
from hyperfab.io.json_io import dump_json
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import cup

FOAM = """format = "hyperfab.foam/1"
thickness = "4.5 mm"
compression = { law = "linear", modulus = "0.05 MPa" }
expansion = { male = "23.6e-6 1/K", female = "23.6e-6 1/K" }
"""
#: Two plates of one metal, the lower heated, the upper by what passes the joint; nothing is lost.
JOINED = """format = "hyperfab.mold/1"
[material.aluminium]
density = "2702 kg/m^3"
conductivity = "237 W/m/K"
specific_heat = "903 J/kg/K"
[[part]]
name = "lower"
material = "aluminium"
box = { origin = ["-50 mm", "-40 mm", "-20 mm"], size = ["100 mm", "80 mm", "20 mm"] }
[[part]]
name = "upper"
material = "aluminium"
box = { origin = ["-50 mm", "-40 mm", "0 mm"], size = ["100 mm", "80 mm", "20 mm"] }
[[heater]]
on = "lower.z-"
power = "400 W"
[[contact]]
between = ["lower", "upper"]
h = "300 W/m^2/K +- 20 %"
[run]
until = "300 s"
start = "25 degC"
mesh_size = "20 mm"
tolerance = "0.02 K"
"""
#: The plates where the press has them, each with a heater, in one room.
APART = (
    JOINED.replace('"-40 mm", "0 mm"]', '"-40 mm", "4 mm"]')
    .replace('[[contact]]\nbetween = ["lower", "upper"]\nh = "300 W/m^2/K +- 20 %"\n', "")
    .replace('"25 degC"', '"25 degC +- 3 K"')
    .replace('power = "400 W"', 'power = "400 W +- 5 %"')
    .replace(
        "[run]",
        '[[heater]]\non = "upper.z+"\npower = "300 W"\n'
        '[[convection]]\non = "exposed"\nh = "30 W/m^2/K +- 20 %"\nambient = "25 degC +- 3 K"\n[run]',
    )
)
#: Constants of a fabric, and how unsure those are that are.
#: Steps of more let the sheet find other equilibria, as its nodes slide without friction.
SHARE = 0.01
CONSTANTS = {"C10_MPa": 0.06, "C20_MPa": 0.02, "C30_MPa": 0.017}
PLATES = ("press-contact", "--male", "lower.stl", "--foam", "foam.toml", "--strokes", "2")
CUP = (
    "press-contact",
    "--male",
    "cup-male.stl",
    "--female",
    "cup-female.stl",
    "--foam",
    "foam.toml",
    "--strokes",
    "2",
)
DRAPE = ("drape", "fabric.json", "--mold", "cup-male.stl", "--grid", "25x25", "--size", "170mm", "--depth", "30mm",
         "--tolerance", "1e-9")  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two plates 4 mm apart, two cups, a foam."""
    for name, middle, sides in (
        ("lower", -10.0, (100, 80)),
        ("upper", 14.0, (100, 80)),
        ("wide", 14.0, (140, 120)),
    ):
        box = trimesh.creation.box(extents=(*sides, 20.0)).apply_translation([0.0, 0.0, middle])
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(box.vertices, box.faces))
    for name, solid in (("male", cup.male_cup(24, 25)), ("female", cup.female_cup(25, 24))):
        (tmp_path / f"cup-{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    (tmp_path / "foam.toml").write_text(FOAM)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def made(words: tuple[str, ...], target: str, **given: bytes) -> dict[str, Any]:
    """Run a command, write its document and its field, and return the document."""
    for name, data in given.items():
        Path(name.replace("__", ".")).write_bytes(data)
    found = rerun(read(case_class(words[0]), list(words[1:])), target)
    Path(target).write_bytes(dump_json(found.document))
    Path(target).with_suffix(".vtu").write_bytes(found.siblings[".vtu"])
    return found.document


def bands(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the bands of a document by figure."""
    found: dict[str, Any] = document.get("uncertainty", {}).get("quantities", {})
    return found


def fabric(constants: Mapping[str, float] = CONSTANTS) -> bytes:
    """Return a fabric whose last two constants are unsure."""
    order = list(CONSTANTS)
    covariance = np.diag([0.0, (SHARE * CONSTANTS["C20_MPa"]) ** 2, (SHARE * CONSTANTS["C30_MPa"]) ** 2]).tolist()
    sure = {
        "order": order,
        "covariance": covariance,
        "specimens": 5,
        "degrees_of_freedom": 0,
        "source": "specimens",
    }
    fit = {"E2": 0.0, "relative_rms": 0.0, "nrmse": 0.0, "points": 9, "uncertainty": sure}
    return json.dumps(
        {"format": "hyperfab.material/1", "model": "yeoh-3", "parameters": dict(constants), "thickness_mm": 0.6,
         "fit": fit}
    ).encode()  # fmt: skip


HOT = (*PLATES, "--male-heat", "heat.json:lower", "--female-heat", "heat.json:upper", "--gap", "3.8mm")
HEAT = (*HOT, "--female", "upper.stl")


@pytest.mark.slow
def test_two_paths_of_one_number_that_cancel_do() -> None:
    """What the joint passes warms one plate by as much as it cools the other: the gap stays, whoever has the heat."""
    # Drawn beside the press: plates grow evenly, by their means. The lower one's corners stay below the upper one.
    aside = JOINED.replace('origin = ["-50 mm"', 'origin = ["450 mm"')
    made(("mold-heat", "mold.toml"), "heat.json", mold__toml=aside.encode())
    press = (*HOT, "--female", "wide.stl", "--uncertainty", "linear")
    one = made(tuple(word for word in press if word not in ("--female-heat", "heat.json:upper")), "one.json")
    band = bands(one)["gap_mean_mm"]
    assert band["budget"] == [{"source": "mold.toml: contact.0.h", "share": pytest.approx(1.0)}]
    # Were they two, it would be 1.41 of the one.
    both = bands(made(press, "press.json")).get("gap_mean_mm", {"sd": 0.0})
    assert both["sd"] < 1e-3 * band["sd"]


@pytest.mark.slow
@pytest.mark.parametrize("more", [(), ("--zero", "hot")])
def test_heat_of_both_molds_against_the_chain_run_anew(more: tuple[str, ...]) -> None:
    """The room, a film and a heater act on both molds: the signed sum of what they do counts, in every figure."""
    heat = ("mold-heat", "mold.toml")
    made(heat, "heat.json", mold__toml=APART.encode())
    found = bands(made((*HEAT, *more, "--uncertainty", "linear"), "press.json"))
    variance: dict[str, float] = {}
    for old, up, down in (
        ('"25 degC +- 3 K"', '"28 degC"', '"22 degC"'),
        ('"400 W +- 5 %"', '"420 W"', '"380 W"'),
        ('"30 W/m^2/K +- 20 %"', '"36 W/m^2/K"', '"24 W/m^2/K"'),
    ):
        ends = []
        for new in (up, down):
            made((*heat, "--uncertainty", "none"), "heat.json", mold__toml=APART.replace(old, new).encode())
            ends.append(made((*HEAT, *more), "press.json"))
        for name in ("force_N", "gap_mean_mm", "pressure_max_MPa"):
            variance[name] = variance.get(name, 0.0) + (0.5 * (ends[0][name] - ends[1][name])) ** 2
    for name, total in variance.items():
        # Of molds set hot the least gap is given, and the largest pressure with it: below 1e-7 is rounding.
        if total > (1e-7 * ends[0][name]) ** 2:
            assert found[name]["sd"] == pytest.approx(np.sqrt(total), rel=0.02), name
    named = {share["source"] for share in found["gap_mean_mm"]["budget"]}
    assert {"mold.toml: heater.0.power", "mold.toml: convection.0.h"} <= named
    assert len(named) == 3  # the room once


def pressures(name: str = "pressure_MPa") -> np.ndarray:
    """Return a field of the press that was last written."""
    return np.asarray(read_vtu(Path("press.vtu").read_bytes(), "press.vtu").point_data[name])


@pytest.mark.slow
def test_constants_of_a_draped_fabric_reach_the_pressures_of_the_press() -> None:
    """Forces hardly feel them: where the sheet is thinner for one of them it is thicker elsewhere."""
    made((*DRAPE, "--uncertainty", "linear"), "drape.json", fabric__json=fabric())
    press = (*CUP, "--drape", "drape.json", "--gap", "3.5mm")
    found = made((*press, "--uncertainty", "linear"), "press.json")["uncertainty"]
    assert [one["source"] for one in found["sources"]] == ["fabric.json: constants, 5 specimens"]
    sure, variance = pressures("pressure_MPa_sd"), np.zeros(1)
    for name in ("C20_MPa", "C30_MPa"):
        ends = []
        for way in (1.0 + SHARE, 1.0 - SHARE):
            moved = fabric(CONSTANTS | {name: way * CONSTANTS[name]})
            made((*DRAPE, "--uncertainty", "none"), "drape.json", fabric__json=moved)
            made((*press, "--uncertainty", "none"), "press.json")
            ends.append(pressures())
        variance = variance + (0.5 * (ends[0] - ends[1])) ** 2
    anew = np.sqrt(variance)
    # Facets of the mold and of the sheet meet at other places: the gap's search is piecewise.
    assert np.linalg.norm(sure - anew) < 0.02 * np.linalg.norm(anew)


def test_what_hands_nothing_on_is_said() -> None:
    made(("mold-heat", "mold.toml"), "heat.json", mold__toml=JOINED.replace(" +- 20 %", "").encode())
    found = made((*HOT[:-1], "3.8mm +- 0.1mm", "--female", "upper.stl", "--uncertainty", "linear"), "press.json")
    assert "heat.json: how its field goes with its inputs" in found["uncertainty"]["left_out"]
