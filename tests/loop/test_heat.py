"""The reduced mold against solutions in closed form, and the loop on a mold that something was done to."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from loop.generators import heat as truths

from hyperfab.chapters.close_loop import heat
from hyperfab.chapters.close_loop.heaters import Drawn
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.catalogue.heat import DataContext, base_conduction
from hyperfab.loop.engine import close
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.problem import split
from hyperfab.thermal import reduced
from hyperfab.thermal.reduced_steps import march
from hyperfab.thermal.sensors import lagging

CUBE = """format = "hyperfab.mold/1"
[material.copper]
density = "8900 kg/m^3"
conductivity = "4000 W/m/K"
specific_heat = "385 J/kg/K"
[[part]]
name = "cube"
material = "copper"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["20 mm", "20 mm", "20 mm"] }
[[heater]]
volume = "cube"
power = "POWER W"
[[convection]]
on = "exposed"
h = "20 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "T"
at = ["10 mm", "10 mm", "10 mm"]
[run]
start = "START degC"
until = "1000 s"
mesh_size = "20 mm"
"""


def cube(power: float, start: float) -> tuple[HeatProblem, np.ndarray]:
    text = CUBE.replace("POWER", f"{power}").replace("START", f"{start}")
    document = parse_document(load_toml(text.encode(), "cube.toml"), "cube.toml", MoldDocument)
    job = Job("close-loop", [], Console(True))
    times = np.linspace(0.0, 1000.0, 101)
    read = heat.Thermocouples(times, np.full((101, 1), start), ["T"])
    builder = MoldBuilder(document, "cube.toml", job.inputs)
    problem = heat.pose(builder, read, [], 0.1)
    return problem, times


def test_cube_warms_as_one_body() -> None:
    problem, times = cube(10.0, 25.0)
    found = problem.predict(np.array([constant.value for constant in problem.own]), {})
    capacity, loss = 8900.0 * 385.0 * 8e-6, 20.0 * 2.4e-3
    expected = 25.0 + 10.0 / loss * (1.0 - np.exp(-loss / capacity * times))
    assert np.max(np.abs(found - expected)) < 0.02


@pytest.mark.parametrize("seed", range(3))
def test_drafts_that_last_for_some_readings_are_noise_of_a_mold_that_is_right(seed: int) -> None:
    """Each reading is by 0.7 what the one before it was: neighbours tell half of the noise, and none of what lacks."""
    problem, _ = cube(30.0, 25.0)
    off = np.random.default_rng(seed).standard_normal(101)
    for row in range(1, 101):
        off[row] = 0.7 * off[row - 1] + np.sqrt(1.0 - 0.7**2) * off[row]
    problem.measured = problem.delivered + 0.2 * off
    found = close(problem, design=False)
    assert found.verdict == "noise"
    assert 0.4 < np.max(found.noise.correlation) < 0.9
    assert np.median(found.noise.sd) == pytest.approx(0.2, rel=0.5)  # so correlated, 101 readings count as 18


def test_radiation_cools_as_stefan_and_boltzmann_say() -> None:
    problem, _ = cube(0.0, 400.0)
    own = np.array([constant.value for constant in problem.own])
    own[[constant.name for constant in problem.own].index("convection.0.h")] = 0.05
    found = problem.predict(own, {"radiation": ("grey", np.array([0.8]))})
    capacity, now, expected = 8900.0 * 385.0 * 8e-6, 673.15, [400.0]
    for _ in range(100):
        for _ in range(200):
            loss = 2.4e-3 * (0.8 * 5.670374419e-8 * (now**4 - 298.15**4) + 1.0 * (now - 298.15))
            now -= 10.0 / 200 * loss / capacity
        expected.append(now - 273.15)
    assert np.max(np.abs(found - np.array(expected))) < 0.15


def test_effects_of_a_mold_are_absent_at_their_null() -> None:
    problem, _ = cube(10.0, 25.0)
    own = np.array([constant.value for constant in problem.own])
    plain = problem.predict(own, {})
    for effect in problem.effects:
        for form in effect.forms:
            with_null = problem.predict(own, {effect.id: (form.name, np.array(form.null))})
            assert np.array_equal(with_null, plain), effect.id


@pytest.mark.parametrize(
    ("name", "form", "values"),
    [
        ("radiation", "grey", [0.4]),
        ("sensor-lag", "two-stage", [12.0, 5.0]),
        ("ambient-drift", "quadratic", [2e-3, 1e-6]),
        ("property-drift", "both", [1e-3, -5e-4]),
        ("power-loss", "wire", [1e-3]),
    ],
)
def test_slopes_by_the_matrices_of_one_run_are_those_of_runs_of_their_own(
    name: str, form: str, values: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, _ = cube(20.0, 25.0)
    forms = {name: problem.effect(name).form(form)}
    x = np.array([*(1.01 * problem.given), *values])
    scale = [one.scale for one in (*problem.own, *forms[name].constants)]
    moved = x + np.diag(1e-5 * np.maximum(np.abs(x), scale))
    own = len(problem.own)
    base = problem.predict(x[:own], split(x[own:], forms))
    whole = problem.predict_many(moved[:, :own], forms, moved[:, own:]) - base
    runs = []
    monkeypatch.setattr(reduced, "march", lambda *of: runs.append(of[-1].known) or march(*of))
    near = problem.predict_near(x, forms, moved) - base
    size = np.abs(whole).max(axis=1)
    assert np.all(np.abs(near - whole).max(axis=1) <= 1e-4 * size + 1e-9)
    # One run has its matrices factored; what a sensor lags by alone is no other run of the mold.
    assert runs == [False] + [True] * (own + len(values) * (name != "sensor-lag"))


def test_wire_at_constant_voltage_warms_as_the_ordinary_differential_equation_says() -> None:
    problem, times = cube(20.0, 25.0)
    own = np.array([constant.value for constant in problem.own])
    found = problem.predict(own, {"power-loss": ("wire", np.array([0.01]))})
    capacity, loss, now, expected = 8900.0 * 385.0 * 8e-6, 20.0 * 2.4e-3, 25.0, []
    for i in range(100001):
        if i % 1000 == 0:
            expected.append(now)
        now += 0.01 * (20.0 / (1.0 + 0.01 * (now - 25.0)) - loss * (now - 25.0)) / capacity
    assert np.max(np.abs(found - np.array(expected))) < 0.05
    assert len(times) == len(expected)


@pytest.mark.parametrize(
    ("form", "values"),
    [("wire and share", [0.1, 0.01]), ("bent", [0.05, 2e-3, 1e-6]), ("through the back", [0.1, 0.02])],
)
def test_power_that_reached_the_mold_as_a_schedule_warms_it_as_the_term_does(form: str, values: list[float]) -> None:
    problem, _ = cube(20.0, 25.0)
    own = np.array([constant.value for constant in problem.own])
    own[[constant.name for constant in problem.own].index("heater.0.power")] = 1.2
    terms = {"power-loss": (form, np.array(values))}
    found = problem.predict(own, terms)
    [power] = problem.given_off(own, terms)
    run = problem.runs[0]
    [(shape, _)] = run.mold.heaters
    again = replace(problem, runs=[replace(run, mold=replace(run.mold, heaters=[(shape, power)]))])
    own[[constant.name for constant in problem.own].index("heater.0.power")] = 1.0
    # The schedule is linear between the steps of the run.
    assert again.predict(own, {}) == pytest.approx(found, abs=0.03)


def test_thermostat_is_followed_by_the_power_it_drew() -> None:
    control = 'power = "40 W"\ncontrol = { probe = "T", set = "60 degC", band = "4 K" }'
    text = CUBE.replace('power = "POWER W"', control).replace("START", "25")
    document = parse_document(load_toml(text.encode(), "cube.toml"), "cube.toml", MoldDocument)
    job = Job("close-loop", [], Console(True))
    times = np.linspace(0.0, 1000.0, 201)
    power = np.where((times < 300.0) | (np.sin(times / 20.0) > 0.0), 40.0, 0.0)
    read = heat.Thermocouples(times, np.full((201, 1), 25.0), ["T"])
    problem = heat.pose(MoldBuilder(document, "cube.toml", job.inputs), read, [], 0.1, [Drawn((0,), power)])
    found = problem.predict(np.array([constant.value for constant in problem.own]), {})
    capacity, loss, fine = 8900.0 * 385.0 * 8e-6, 20.0 * 2.4e-3, np.linspace(0.0, 1000.0, 200001)
    drawn, now, expected = np.interp(fine, times, power), 25.0, []
    for i, watt in enumerate(drawn):
        if i % 1000 == 0:
            expected.append(now)
        now += 0.005 * (watt - loss * (now - 25.0)) / capacity
    assert np.max(np.abs(found - np.array(expected))) < 0.05


def test_missing_readings_leave_the_others_where_they_are() -> None:
    document = parse_document(
        load_toml(CUBE.replace("POWER", "10").replace("START", "25").encode(), "cube.toml"),
        "cube.toml",
        MoldDocument,
    )
    job, times = Job("close-loop", [], Console(True)), np.linspace(0.0, 1000.0, 101)
    readings = np.full((101, 1), 25.0)
    readings[[0, 17, 50]] = np.nan
    builder = MoldBuilder(document, "cube.toml", job.inputs)
    problem = heat.pose(builder, heat.Thermocouples(times, readings, ["T"]), [], 0.1)
    whole, _ = cube(10.0, 25.0)
    own = np.array([constant.value for constant in problem.own])
    assert len(problem.measured) == 98
    assert np.array_equal(problem.curves[0].abscissa, np.delete(times, [0, 17, 50]))
    assert problem.predict(own, {}) == pytest.approx(np.delete(whole.predict(own, {}), [0, 17, 50]), abs=1e-6)


def test_lag_of_a_ramp_is_exact() -> None:
    times = np.linspace(0.0, 50.0, 26)
    ramp = 2.0 * times[None, :, None]
    found = lagging(times, ramp, np.array([8.0]))[0, :, 0]
    assert found == pytest.approx(2.0 * (times - 8.0 * (1.0 - np.exp(-times / 8.0))), abs=1e-9)


STEEL = """format = "hyperfab.mold/1"
[material.steel]
density = "7900 kg/m^3"
conductivity = "CONDUCTIVITY W/m/K"
specific_heat = "480 J/kg/K"
[[part]]
name = "plate"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["200 mm", "160 mm", "40 mm"] }
[[part]]
name = "mold"
material = "steel"
box = { origin = ["20 mm", "20 mm", "40 mm"], size = ["160 mm", "120 mm", "50 mm"] }
[[heater]]
on = "plate.z-"
power = "2000 W"
[[convection]]
on = "exposed"
h = "20 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "shoulder"
at = ["20 mm", "20 mm", "90 mm"]
[[probe]]
name = "edge"
at = ["0 mm", "0 mm", "40 mm"]
[run]
start = "25 degC"
until = "1800 s"
mesh_size = "20 mm"
"""


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_steel_that_conducts_worse_is_predicted_as_the_whole_mold_runs(hf: Run, tmp_path: Path, share: float) -> None:
    """Two parts that touch, some 200 K apart: the loop's few unknowns against ``hf mold-heat`` on the same mesh."""
    text = STEEL.replace("CONDUCTIVITY", "30")
    document = parse_document(load_toml(text.encode(), "mold.toml"), "mold.toml", MoldDocument)
    times = np.linspace(0.0, 1800.0, 31)
    job, read = (
        Job("close-loop", [], Console(True)),
        heat.Thermocouples(times, np.full((31, 2), 25.0), ["shoulder", "edge"]),
    )
    problem = heat.pose(MoldBuilder(document, "mold.toml", job.inputs), read, [], 0.1)
    own = np.array([constant.value for constant in problem.own])
    own[[constant.name for constant in problem.own].index("material.steel.conductivity")] = share
    found = problem.predict(own, {}).reshape(2, -1)
    worse = STEEL.replace("CONDUCTIVITY", f"{30.0 * share}").replace("[run]", '[run]\ntolerance = "0.01 K"')
    (tmp_path / "mold.toml").write_text(worse)
    assert hf("mold-heat", "mold.toml", "-o", "run.json", cwd=tmp_path).returncode == 0
    whole = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1).T
    expected = np.stack([np.interp(times, whole[0], one) for one in whole[1:]])
    # With joints by a few points, on the basis of the whole conductivity, it was off by 0.24 and 0.72 K.
    assert np.max(np.abs(found - expected)) < 0.1


@pytest.mark.slow
def test_sensor_lag_of_a_mold_is_found_and_written(hf: Run, tmp_path: Path) -> None:
    text, power = truths.mold_toml()
    (tmp_path / "mold.toml").write_text(text)
    (tmp_path / "power.csv").write_text(power)
    times, readings = truths.measure(truths.Truth(("sensor-lag",), {"sensor-lag": 1.0}), np.random.default_rng(2), 0.3)
    rows = [",".join(f"{v:.4f}" for v in (t, *row)) for t, row in zip(times, readings, strict=True)]
    head = "time [s]," + ",".join(f"T{i} [degC]" for i in range(1, 5))
    (tmp_path / "tc.csv").write_text("\n".join([head, *rows]) + "\n")
    done = hf("close-loop", "mold.toml", "--measured", "tc.csv", "-o", "loop.json", cwd=tmp_path, timeout=900)
    found = json.loads((tmp_path / "loop.json").read_text())
    assert done.returncode == 0, done.stderr.decode()
    named = {effect["id"] for effect in found["effects"]} | {name for one in found["indistinguishable"] for name in one}
    assert "sensor-lag" in named
    assert hf("mold-heat", found["model"], cwd=tmp_path, timeout=300).returncode == 0


def test_a_mold_with_a_film_all_around_is_told_how_its_base_is_sought() -> None:
    """``exposed`` takes in the underside, through which no heat would be sought in silence."""
    around = DataContext(3600.0, 150.0, 1000.0, films=1, heaters=1, opened=0, declared=0, probes=3, bench=False,
                         emits=False, typical_film=10.0)  # fmt: skip
    assert "[[insulated]]" in base_conduction(around).not_sought
    assert not base_conduction(replace(around, bench=True)).not_sought
