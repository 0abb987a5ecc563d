"""Every effect of a heated mold at its null: the forward run is the one without it, to the bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.close_loop.extended_mold import extend
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise

from .test_mold_heat import heat as run

MOLD = """format = "hyperfab.mold/1"
[material.steel]
density = "7800 kg/m^3"
conductivity = "40 W/m/K"
specific_heat = "470 J/kg/K"
[[part]]
name = "plate"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["60 mm", "60 mm", "20 mm"] }
[[part]]
name = "block"
material = "steel"
box = { origin = ["10 mm", "10 mm", "20 mm"], size = ["40 mm", "40 mm", "20 mm"] }
[[heater]]
on = "plate.x-"
power = "60 W"
[[convection]]
on = "block.all"
h = "12 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "T"
at = ["30 mm", "30 mm", "30 mm"]
[run]
start = "25 degC"
until = "600 s"
mesh_size = "20 mm"
"""
TABLES = {
    "ambient": "time [s],temperature [degC]\n0,25\n600,25\n",
    "film": "temperature [degC],h [W/m^2/K]\n0,12\n500,12\n",
    "k": "temperature [degC],conductivity [W/m/K]\n0,40\n500,40\n",
    "c": "temperature [degC],specific heat [J/kg/K]\n0,470\n500,470\n",
    "power": "time [s],power [W]\n0,60\n600,60\n",
}
NULLS = {
    "radiation": ("[run]", '[[radiation]]\non = "block.all"\nemissivity = 0.0\nambient = "25 degC"\n[run]'),
    "sensor-lag": ('name = "T"\n', 'name = "T"\nlag = "0 s"\n'),
    "base-conduction": (
        "[run]",
        '[[convection]]\non = "plate.z-"\nh = "0 W/m^2/K"\nambient = "25 degC"\n[run]',
    ),
    "ambient-drift": ('ambient = "25 degC"', 'ambient = { table = "ambient.null.csv" }'),
    "convection-law": ('h = "12 W/m^2/K"', 'h = { table = "film.null.csv" }'),
    "property-drift": ('conductivity = "40 W/m/K"', 'conductivity = { table = "k.null.csv" }'),
    "property-drift of specific heat": ('"470 J/kg/K"', '{ table = "c.null.csv" }'),
    "power-loss": ('power = "60 W"', 'schedule = "power.null.csv"'),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    folder = tmp_path_factory.mktemp("null")
    for name, text in TABLES.items():
        (folder / f"{name}.null.csv").write_text(text)
    assert run(folder, MOLD)[0] == 0
    return folder, (folder / "heat.csv").read_bytes()


@pytest.mark.parametrize("effect", NULLS)
def test_effect_at_its_null_leaves_the_curves_to_the_bit(plain: tuple[Path, bytes], effect: str) -> None:
    folder, curves = plain
    old, new = NULLS[effect]
    assert old in MOLD
    assert run(folder, MOLD.replace(old, new), effect)[0] == 0
    assert (folder / f"{effect}.csv").read_bytes() == curves


def test_extended_mold_of_terms_at_their_null_is_the_mold(tmp_path: Path) -> None:
    data = load_toml(MOLD.encode(), "mold.toml")
    document = parse_document(data, "mold.toml", MoldDocument)
    times = np.linspace(0.0, 600.0, 61)
    job = Job("close-loop", [], Console(True))
    read = heat.Thermocouples(times, np.full((61, 1), 25.0), ["T"])
    builder = MoldBuilder(document, "mold.toml", job.inputs)
    problem = heat.pose(builder, read, [], 0.1)
    own = np.array([constant.value for constant in problem.own])
    plain = problem.predict(own, {})
    noise = Noise(np.full(61, 0.1), np.inf, "stated")
    assert {effect.id for effect in problem.effects} >= {name.split(" ")[0] for name in NULLS}
    for effect in problem.effects:
        for form in effect.forms:
            x = np.concatenate([own, form.null])
            assert np.array_equal(problem.predict(own, {effect.id: (form.name, x[len(own) :])}), plain)
            fitted = fit(problem, noise, {effect.id: form}, x, data=plain, iterations=0)
            files, notes = extend(data, document, problem, fitted, "loop", ("", ""))
            again = load_toml(files[".model.toml"], "loop.model.toml")
            assert notes == []
            assert parse_document(again, "loop.model.toml", MoldDocument) == document, (effect.id, form.name)
