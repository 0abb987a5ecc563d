"""Logs that tell what each heater of a mold drew, beside its thermocouples."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.close_loop.heaters import Drawn, as_power, ratings, read_powers
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.headings import heading
from hyperfab.io.inputs import Inputs
from hyperfab.io.layout import PLAIN
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise_estimate import estimate_noise

NOISE = 0.1
BAR = """format = "hyperfab.mold/1"
[material.steel]
density = "7850 kg/m^3"
conductivity = "20 W/m/K"
specific_heat = "480 J/kg/K"
[[part]]
name = "bar"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["90 mm", "20 mm", "20 mm"] }
[[heater]]
on = "bar.x-"
power = "40 W"
[[heater]]
on = "bar.x+"
power = "20 W"
[[convection]]
on = ["bar.y-", "bar.y+", "bar.z-", "bar.z+"]
h = "12 W/m^2/K"
ambient = "22 degC"
[[probe]]
name = "left"
at = ["5 mm", "10 mm", "10 mm"]
[[probe]]
name = "right"
at = ["85 mm", "10 mm", "10 mm"]
[run]
start = "22 degC"
until = "1200 s"
mesh_size = "20 mm"
"""
RULED = BAR.replace('power = "40 W"', 'power = "40 W"\ncontrol = { probe = "left", set = "90 degC", band = "2 K" }')
RULED = RULED.replace('power = "20 W"', 'power = "20 W"\ncontrol = { probe = "right", set = "70 degC", band = "2 K" }')
TIMES = np.arange(0.0, 1205.0, 5.0)
#: Each heater as it is seen to switch, at times of its own.
POWERS = {
    "heater.0.power": np.where(TIMES % 310.0 < 190.0, 40.0, 0.0),
    "heater.1.power": np.where((TIMES + 140.0) % 240.0 < 110.0, 20.0, 0.0),
}


def document(text: str) -> MoldDocument:
    return parse_document(load_toml(text.encode(), "bar.toml"), "bar.toml", MoldDocument)


def posed(text: str, drawn: list[Drawn], readings: np.ndarray | None = None) -> heat.HeatProblem:
    shown = np.full((len(TIMES), 2), 22.0) if readings is None else readings
    read = heat.Thermocouples(TIMES, shown, ["left", "right"])
    return heat.pose(MoldBuilder(document(text), "bar.toml", Inputs()), read, [], 0.1, drawn)


def log(text: str) -> np.ndarray:
    """Return what the two probes of a bar read that is heated by ``POWERS``, (t, 2)."""
    true = posed(text, read_powers(document(text), POWERS)).delivered.reshape(2, -1).T
    return true + NOISE * np.random.default_rng(2).standard_normal(true.shape)


def test_heaters_that_switch_apart_heat_by_what_each_drew() -> None:
    """All together, shared as they are rated, they heated the wrong end."""
    every = read_powers(document(RULED), {"power": sum(POWERS.values())})
    each = read_powers(document(RULED), POWERS)
    assert [one.heaters for one in every] == [(0, 1)]
    assert [one.heaters for one in each] == [(0,), (1,)]
    readings, left = log(RULED), []
    for drawn in (each, every):
        problem = posed(RULED, drawn, readings)
        left.append(fit(problem, estimate_noise(problem, NOISE).plain, {}, problem.given).residual)
    assert np.sqrt(np.mean(left[0] ** 2)) == pytest.approx(1.0, abs=0.1)
    assert np.sqrt(np.mean(left[1] ** 2)) > 10.0


def test_what_is_told_of_all_together_is_of_those_that_nothing_else_is_told_of() -> None:
    own = {"power": sum(POWERS.values()), "heater.1.power": POWERS["heater.1.power"]}
    for text in (BAR, RULED):
        rest = read_powers(document(text), own)[-1]
        assert rest.heaters == (0,)
        assert rest.power == pytest.approx(POWERS["heater.0.power"])
    half = RULED.replace('\ncontrol = { probe = "right", set = "70 degC", band = "2 K" }', "")
    (rest,) = read_powers(document(half), {"power": own["power"]})
    assert (rest.heaters, rest.beside) == ((0,), (1,))
    assert ratings(document(RULED)) == {"power": 60.0, "heater.0.power": 40.0, "heater.1.power": 20.0}
    assert ratings(document(half))["power"] is None


def test_columns_that_may_be_powers_are_shown_with_the_option_that_takes_them() -> None:
    rated = ratings(document(BAR))
    shares = [heading("Q1 [%]", 1), heading("Q2 [%]", 2)]
    each = '"Q1 [%]=heater.0.power [%],Q2 [%]=heater.1.power [%]"'
    assert as_power(shares, rated, PLAIN).endswith(f"say whose, as in --columns {each}")
    assert as_power(shares[:1], rated, PLAIN).endswith('the share of 60 W that was on, --columns "Q1 [%]=power [%]"')
    assert as_power([heading("P [kW]", 1)], rated, PLAIN).endswith('--columns "P [kW]=power [kW]"')
    assert as_power([heading("room [degC]", 1)], rated, PLAIN) == ""


def test_a_mold_without_thermostats_is_heated_by_what_the_log_tells(hf: Run, tmp_path: Path) -> None:
    """The column was read and not used, without a word. The written mold has it as its schedules."""
    rows = np.column_stack([TIMES, POWERS["heater.0.power"] / 0.4, POWERS["heater.1.power"], log(BAR)])
    body = "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
    (tmp_path / "log.csv").write_text("Time [s],Q1 [%],heater.1.power [W],left [degC],right [degC]\n" + body)
    (tmp_path / "bar.toml").write_text(BAR)
    words = ["close-loop", "bar.toml", "log.csv", "--columns", "Q1=heater.0.power [%]", "--noise", f"{NOISE} K"]
    done = hf(*words, "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    assert "tells heater.0.power, heater.1.power, in place of what the mold says" in done.stderr.decode()
    assert json.loads((tmp_path / "loop.json").read_text())["verdict"] == "noise"
    done = hf("mold-heat", "loop.model.toml", "-o", "heat.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    told = list(csv.DictReader((tmp_path / "loop.csv").open()))
    run = list(csv.DictReader((tmp_path / "heat.csv").open()))
    for probe in ("left", "right"):
        shown = [float(row[f"{probe}_degC"]) for row in run]
        at = np.interp(TIMES, [float(row["time_s"]) for row in run], shown)
        after = np.array([float(row[f"{probe}_after_degC"]) for row in told])
        assert np.sqrt(np.mean((at - after) ** 2)) < 0.5 * NOISE
