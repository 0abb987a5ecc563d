"""hf mold-heat: what it writes, what it warns of, and what it refuses, by key and with a way out."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from builders import plate

from hyperfab.cases.mold import MoldCase
from hyperfab.chapters import mold_heat
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.console import Console
from hyperfab.documents.base import read_document, schema
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import InputError, NotConverged, UsageError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import read_vtu

HEAD = plate(100, 80, 20)
HEATER = """
[[heater]]
on = "plate.z-"
power = "400 W"
"""
FILM = """
[[convection]]
on = "exposed"
h = "12 W/m^2/K"
ambient = "25 degC"
"""
PROBE = """
[[probe]]
name = "centre"
at = ["50 mm", "40 mm", "20 mm"]
[work_surface]
on = "plate.z+"
"""
RUN = """
[run]
start = "25 degC"
until = "300 s"
mesh_size = "25 mm"
"""
PLATE = HEAD + HEATER + FILM + PROBE + RUN


class Quiet(Console):
    def __init__(self):
        super().__init__(True)
        self.said, self.noted = [], []

    def warn(self, *texts):
        self.said += texts

    def note(self, *texts):
        self.noted += texts


def heat(folder: Path, text: str, name: str = "heat", **options):
    (folder / "mold.toml").write_text(text)
    console = Quiet()
    target = str(folder / f"{name}.json")
    case = MoldCase.of({"mold": str(folder / "mold.toml"), **options})
    status = mold_heat.run(Job("mold-heat", [], console, target=target), case)
    return status, json.loads(Path(target).read_text()), console.said


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plate")
    status, document, said = heat(folder, PLATE)
    assert status == 0
    assert said == []
    return folder, document


def test_document_follows_its_schema(plate):
    import jsonschema

    jsonschema.validate(plate[1], schema("heat"))


def test_the_setup_tells_what_was_run_with_its_defaults(plate):
    told = {key: plate[1]["setup"].get(key) for key in ("start_degC", "target_degC", "until_s", "mesh_size_mm")}
    assert told == {"start_degC": 25.0, "target_degC": None, "until_s": 300.0, "mesh_size_mm": 25.0}
    assert (plate[1]["setup"]["steady"], plate[1]["setup"]["tolerance_K"]) == (False, 0.1)


def test_a_mold_that_nothing_heats_or_cools_is_told(tmp_path):
    _, _, said = heat(tmp_path, HEAD + FILM + PROBE + RUN)
    assert [one for one in said if "nothing heats or cools the mold" in one]
    _, _, said = heat(tmp_path, HEAD + FILM + PROBE + RUN.replace("25 degC", "80 degC"), "cooling")
    assert said == []


def test_power_less_losses_is_stored(plate):
    _, document = plate
    energy = document["energy"]
    assert energy["supplied_J"] == pytest.approx(400.0 * 300.0, rel=1e-12)
    assert energy["imbalance_relative"] < 1e-12
    mass = 0.1 * 0.08 * 0.02 * 2702.0
    assert document["mass_kg"] == pytest.approx(mass, rel=1e-12)
    # Nearly uniform, so the lumped solution holds to the resistance of the plate.
    area = 0.1 * 0.08 + 2 * 0.02 * 0.18
    rise = 400.0 / (12.0 * area) * (1 - np.exp(-12.0 * area * 300.0 / (mass * 903.0)))
    assert document["work_surface"]["mean_degC"] == pytest.approx(25.0 + rise, rel=0.01)


def test_files_are_listed_and_read_back(plate):
    folder, document = plate
    assert all((folder / name).is_file() for name in document["files"])
    assert {"heat.vtu", "heat.pvd", "heat.csv", "heat.png"} <= set(document["files"])
    grid = read_vtu((folder / "heat.vtu").read_bytes(), "heat.vtu")
    field = grid.point_data["temperature_degC"]
    assert field.max() == pytest.approx(document["hottest"]["temperature_degC"])
    rows = (folder / "heat.csv").read_text().splitlines()
    assert rows[0] == "time_s,centre_degC"
    last = [float(cell) for cell in rows[-1].split(",")]
    assert last == [300.0, document["probes"]["centre"]["final_degC"]]


def test_warmup_is_hit_exactly_and_the_run_goes_on_to_its_end(tmp_path):
    status, document, _ = heat(tmp_path, PLATE.replace("[run]", '[run]\ntarget = "80 degC"'))
    assert status == 0
    assert document["work_surface"]["at_warmup"]["mean_degC"] == pytest.approx(80.0, abs=1e-6)
    assert 0.0 < document["warmup_time_s"] < 300.0
    assert document["end_time_s"] == 300.0
    assert 0.5 < document["efficiency"] < 1.0


@pytest.mark.parametrize(("target", "told"), [(80.0, True), (300.0, False)])
def test_heaters_that_go_on_far_above_the_target_are_told(tmp_path, target, told):
    _, document, said = heat(tmp_path, PLATE.replace("[run]", f'[run]\ntarget = "{target} degC"'))
    assert (document["work_surface"]["mean_degC"] > target + 50.0) == told
    assert [one for one in said if "above the target: heaters without control" in one] == (said if told else [])


@pytest.mark.parametrize(
    ("heaters", "start", "rest"),
    [
        ("", 25.0, ""),
        (HEATER, 25.0, ", {0:.3g} min of 400 W if it were even and lost nothing"),
        (2 * HEATER, 60.0, ", {0:.3g} min of 800 W if it were even and lost nothing"),
        (HEATER.replace('power = "400 W"', 'flux = "5 W/cm^2"'), 25.0, ""),
    ],
)
def test_what_a_mold_is_as_one_body_is_said_before_it_is_meshed(tmp_path, monkeypatch, heaters, start, rest):
    """Mass, and heat to the target, by hand; with the power of all heaters the time too."""
    run = RUN.replace("25 degC", f"{start:g} degC").replace("[run]", '[run]\ntarget = "200 degC"')
    (tmp_path / "mold.toml").write_text(HEAD + heaters + FILM + PROBE + run)
    inputs = Inputs()
    said = []
    builder = MoldBuilder(
        read_document(inputs, str(tmp_path / "mold.toml"), MoldDocument), str(tmp_path / "mold.toml"), inputs
    )

    def meshed(*_):
        assert said, "the mesh was begun first"
        raise KeyboardInterrupt

    monkeypatch.setattr("hyperfab.chapters.mold_heat.problem.build_mesh", meshed)
    with pytest.raises(KeyboardInterrupt):
        builder.build(say=said.append)
    mass = 0.1 * 0.08 * 0.02 * 2702.0
    heat = mass * 903.0 * (200.0 - start)
    power = 400.0 * heaters.count("power")
    text = f"the mold weighs {mass:.4g} kg; {heat / 1e6:.3g} MJ take it to 200 degC"
    assert said == [text + rest.format(heat / power / 60.0 if power else 0.0)]


def test_target_never_reached_is_no_failure(tmp_path):
    text = PLATE.replace('until = "300 s"', 'target = "900 degC"').replace('"400 W"', '"20 W"')
    status, document, said = heat(tmp_path, text)
    assert status == 0
    assert "warmup_time_s" not in document
    assert document["target_reached"] is False
    assert any("did not reach 900 degC" in line for line in said)


def test_steady_state_balances(tmp_path):
    status, document, _ = heat(tmp_path, PLATE.replace('until = "300 s"', "steady = true"))
    assert status == 0
    assert document["power_lost_W"]["convection exposed"] == pytest.approx(400.0, rel=1e-8)


@pytest.mark.parametrize("end", ['until = "300 s"', 'target = "80 degC"', "steady = true"])
@pytest.mark.parametrize("ambient", ["25 degC", "60 degC"])
def test_a_mold_without_power_balances_too(tmp_path, end, ambient):
    text = PLATE.replace('"400 W"', '"0 W"').replace('until = "300 s"', end)
    status, document, _ = heat(tmp_path, text.replace('ambient = "25 degC"', f'ambient = "{ambient}"'))
    assert status == 0
    assert document["energy"]["imbalance_relative"] < 1e-10
    if ambient == "25 degC":
        assert document["energy"]["stored_J"] == 0.0
        assert document["hottest"]["temperature_degC"] == document["coldest"]["temperature_degC"] == 25.0


def test_a_shorter_run_leaves_no_frames_of_a_longer_one(tmp_path):
    heat(tmp_path, PLATE)
    frames = sorted(path.name for path in tmp_path.glob("heat.0*.vtu"))
    (tmp_path / "heat.900.vtu").write_text("someone else's")
    (tmp_path / "heat.txt").write_text("notes")
    status, document, _ = heat(tmp_path, PLATE.replace('until = "300 s"', "steady = true"))
    assert status == 0
    assert len(frames) > 2
    left = {"mold.toml", "heat.json", "heat.900.vtu", "heat.txt", *document["files"]}
    assert {path.name for path in tmp_path.iterdir()} == left


def test_thermostat_keeps_its_band(tmp_path):
    control = 'control = { probe = "centre", set = "60 degC", band = "2 K" }'
    text = (HEAD + HEATER + control + FILM + PROBE + RUN).replace('"12 W', '"60 W')
    status, document, _ = heat(tmp_path, text)
    assert status == 0
    assert len(document["switches_s"]) >= 2
    assert document["probes"]["centre"]["max_degC"] < 64.0
    assert document["energy"]["imbalance_relative"] < 1e-12


@pytest.mark.slow
def test_a_long_run_tells_of_the_reduced_mold_and_its_bound(tmp_path):
    control = 'control = { probe = "centre", set = "60 degC", band = "2 K" }'
    text = (HEAD + HEATER + control + FILM + PROBE + RUN).replace('"12 W', '"60 W').replace("300 s", "900 s")
    status, short, _ = heat(tmp_path, text + "reduced = true", "short")
    assert status == 0
    assert short["reduced"]["stretches"] >= 4
    assert short["reduced"]["checks"] >= 2
    assert 0.0 < short["reduced"]["error_bound_K"] < 0.05
    assert short["energy"]["imbalance_relative"] < 1e-11
    _, full, _ = heat(tmp_path, text + "reduced = false", "full")
    _, small, _ = heat(tmp_path, text, "small")
    assert "reduced" not in full
    assert small["probes"] == full["probes"]
    bound = short["reduced"]["error_bound_K"]
    np.testing.assert_allclose(short["switches_s"], full["switches_s"], atol=0.01)
    assert short["probes"]["centre"]["final_degC"] == pytest.approx(full["probes"]["centre"]["final_degC"], abs=bound)
    for what in ("mean_degC", "min_degC", "max_degC"):
        assert short["work_surface"][what] == pytest.approx(full["work_surface"][what], abs=bound)
    again = (tmp_path / "short.history.csv").read_bytes()
    heat(tmp_path, text + "reduced = true", "short")
    assert (tmp_path / "short.history.csv").read_bytes() == again


@pytest.mark.slow
def test_a_long_run_that_has_no_reduced_mold_says_why(tmp_path, monkeypatch):
    monkeypatch.setattr("hyperfab.thermal.shortcut.SMALLEST", 10)
    control = 'control = { probe = "centre", set = "60 degC", band = "0.5 K" }'
    held = '[[temperature]]\non = "plate.x-"\nvalue = "50 degC"\n'
    _, document, _ = heat(tmp_path, HEAD + HEATER + control + FILM + held + PROBE + RUN)
    assert "reduced" not in document
    assert document["notes"] == ["a long run, followed in full: temperatures are held"]


def test_a_face_that_is_held_warm_supplies_the_heat_it_gives(tmp_path):
    held = '[[temperature]]\non = "plate.x-"\nvalue = "100 degC"\n'
    _, document, _ = heat(tmp_path, HEAD + FILM + held + PROBE + RUN)
    energy = document["energy"]
    face, film = (energy["by_condition_J"][name] for name in ("temperature plate.x-", "convection exposed"))
    assert energy["supplied_J"] == pytest.approx(face)
    assert energy["lost_J"] == pytest.approx(-film)
    assert energy["stored_J"] == pytest.approx(energy["supplied_J"] - energy["lost_J"])
    assert document["efficiency"] == pytest.approx(energy["stored_J"] / energy["supplied_J"])


def test_zones_that_ask_one_probe_switch_together(tmp_path):
    control = 'control = { probe = "centre", set = "60 degC", band = "4 K" }\n'
    left = HEATER.replace("plate.z-", "plate.x-").replace("400 W", "200 W") + control
    text = (HEAD + left + left.replace("x-", "x+") + FILM + PROBE + RUN).replace('"12 W', '"60 W')
    _, two, _ = heat(tmp_path, text)
    assert len(two["switches_s"]) >= 2
    first, second = (two["energy"]["by_condition_J"][f"heater plate.x{way}"] for way in "-+")
    assert first == pytest.approx(second, rel=1e-9)
    assert two["probes"]["centre"]["max_degC"] < 66.0
    assert two["energy"]["imbalance_relative"] < 1e-12


def test_a_run_starts_from_an_earlier_one(plate, tmp_path):
    folder, before = plate
    for name in ("heat.json", "heat.vtu"):
        (tmp_path / name.replace("heat", "first")).write_bytes((folder / name).read_bytes())
    found = json.loads((tmp_path / "first.json").read_text())
    found["files"] = ["first.vtu"]
    (tmp_path / "first.json").write_text(json.dumps(found))
    later = HEAD + FILM + PROBE + RUN.replace('start = "25 degC"', 'start = { document = "first.json" }')
    _, same, _ = heat(tmp_path, later, "same")
    rows = (tmp_path / "same.csv").read_text().splitlines()
    assert float(rows[1].split(",")[1]) == pytest.approx(before["probes"]["centre"]["final_degC"], abs=1e-9)
    assert same["probes"]["centre"]["final_degC"] < before["probes"]["centre"]["final_degC"]
    _, other, _ = heat(tmp_path, later.replace('"25 mm"', '"18 mm"'), "other")
    finals = [d["probes"]["centre"]["final_degC"] for d in (same, other)]
    assert finals[0] == pytest.approx(finals[1], abs=0.05)


def test_misprinted_specific_heat_is_questioned(tmp_path):
    text = PLATE.replace("903 J/kg/K", "49 J/kg/K").replace('"300 s"', '"5 s"')
    status, _, said = heat(tmp_path, text)
    assert status == 0
    assert any("49 J/kg/K" in line and "900" in line for line in said)


def test_contact_opens_and_closes_on_its_schedule(tmp_path):
    (tmp_path / "closed.csv").write_text("time [s],contact [-]\n0,0\n100,0\n100.5,1\n300,1\n")
    second = """
[[part]]
name = "sandwich"
material = "aluminium"
box = { origin = ["0 mm", "0 mm", "20 mm"], size = ["100 mm", "80 mm", "5 mm"] }
[[contact]]
between = ["plate", "sandwich"]
h = "1000 W/m^2/K"
schedule = "closed.csv"
[[probe]]
name = "sandwich"
at = ["50 mm", "40 mm", "25 mm"]
"""
    text = HEAD + second + HEATER + PROBE + RUN
    status, document, _ = heat(tmp_path, text)
    assert status == 0
    rows = np.array(
        [[float(c) for c in row.split(",")] for row in (tmp_path / "heat.csv").read_text().splitlines()[1:]]
    )
    before = rows[rows[:, 0] <= 100.0]
    np.testing.assert_allclose(before[:, 1], 25.0, atol=1e-9)
    assert {0.0, 100.0, 100.5, 300.0} <= set(rows[:, 0])
    assert document["probes"]["sandwich"]["final_degC"] > 60.0
    assert document["energy"]["imbalance_relative"] < 1e-12


@pytest.mark.parametrize("order", [("below", "above"), ("above", "below")])
def test_a_probe_on_a_joint_tells_whose_side_it_reads(tmp_path, order):
    """Two blocks that hardly conduct to each other: which one a probe between them reads hangs on their order."""
    low = {"below": 0, "above": 20}
    parts = "".join(
        f"""
[[part]]
name = "{name}"
material = "aluminium"
start = "{100 + low[name]} degC"
box = {{ origin = ["0 mm", "0 mm", "{low[name]} mm"], size = ["20 mm", "20 mm", "20 mm"] }}
"""
        for name in order
    )
    probes = "".join(
        f"""
[[probe]]
name = "{name}"
at = ["10 mm", "10 mm", "{z} mm"]
"""
        for name, z in (("joint", 20), ("inside", 19.9))
    )
    rest = """
[[contact]]
between = ["below", "above"]
h = "1 W/m^2/K"
[run]
until = "1 s"
mesh_size = "20 mm"
"""
    head = HEAD[: HEAD.index("[[part]]")]
    _, found, said = heat(tmp_path, head + parts + probes + rest)
    read = {100: "below", 120: "above"}[round(found["probes"]["joint"]["final_degC"])]
    assert [one for one in said if "probe" in one] == [
        f"probe 'joint' lies on the joint of 'below' and 'above', where the temperature jumps, and reads that of "
        f"'{read}': move it into the part that is meant"
    ]
    assert found["probes"]["inside"]["final_degC"] == pytest.approx(100.0, abs=0.1)


def test_each_press_cycle_cools_the_mold_by_a_fresh_sandwich(tmp_path):
    (tmp_path / "closed.csv").write_text("time [s],contact [-]\n0,0\n20,0\n21,1\n60,1\n61,0\n100,0\n101,1\n140,1\n")
    sandwich = """
[[part]]
name = "sandwich"
material = "aluminium"
start = "20 degC"
box = { origin = ["0 mm", "0 mm", "20 mm"], size = ["100 mm", "80 mm", "5 mm"] }
[[contact]]
between = ["plate", "sandwich"]
h = "1000 W/m^2/K"
schedule = "closed.csv"
fresh = "20 degC"
[[probe]]
name = "sandwich"
at = ["50 mm", "40 mm", "25 mm"]
"""
    run = RUN.replace('"25 degC"', '"200 degC"').replace('"300 s"', '"140 s"')
    status, document, _ = heat(tmp_path, HEAD + sandwich + PROBE + run)
    assert status == 0
    # Lumped: each cycle the plate shares its heat with a piece of a quarter of its capacity.
    mean, capacity = 200.0, 0.2 * 2702.0 * 903.0 * 1e-3 * 0.8
    for _ in range(2):
        mean = (mean * 4 + 20.0) / 5
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(mean, abs=2.0)
    carried = document["energy"]["by_condition_J"]["fresh sandwich"]
    assert carried == pytest.approx(-(164.0 - 20.0) * capacity / 4, rel=0.02)
    assert document["energy"]["imbalance_relative"] < 1e-12


def test_power_is_found_for_a_wanted_warmup(tmp_path):
    text = PLATE.replace('until = "300 s"', 'target = "80 degC"')
    status, document, _ = heat(tmp_path, text, warmup_in="2 min")
    assert status == 0
    assert document["warmup_time_s"] == pytest.approx(120.0, rel=2e-4)
    chosen = document["design"]["power_W"]["heater plate.z-"]
    assert chosen == pytest.approx(400.0 * document["design"]["power_factor"])
    assert document["energy"]["supplied_J"] == pytest.approx(chosen * document["warmup_time_s"], rel=1e-9)


def test_wishes_that_a_mold_cannot_have_are_refused(tmp_path):
    for options, words in (
        ({"warmup_in": "2 min"}, "run.target"),
        ({"warmup_in": "2"}, "unit"),
        ({"heater_max": "1 kW"}, "--share-power"),
    ):
        with pytest.raises((InputError, UsageError), match=words):
            heat(tmp_path, PLATE, **options)


def test_a_mold_that_begins_above_its_target_is_told_and_no_power_is_sought(tmp_path):
    text = PLATE.replace('"25 degC"\nuntil', '"90 degC"\ntarget = "80 degC"\nuntil')
    _, document, said = heat(tmp_path, text)
    assert document["warmup_time_s"] == 0.0
    assert any("begins at the target of 80 degC or above it" in words for words in said)
    with pytest.raises(InputError, match="begins at 90 degC, and the target is 80 degC") as refused:
        heat(tmp_path, text, warmup_in="2 min")
    assert refused.value.key == "run.start"


@pytest.mark.slow
def test_a_quench_through_a_film_that_falls_steeply_is_followed_in_shorter_steps(tmp_path):
    """Water boils most at 120 degC and keeps off a hotter wall: against the thin plate as one body, by Runge-Kutta."""
    film = np.array([[20.0, 500.0], [100.0, 2000.0], [120.0, 20000.0], [130.0, 500.0], [400.0, 300.0]])
    table = "\n".join(f"{celsius:g},{h:g}" for celsius, h in film)
    (tmp_path / "film.csv").write_text(f"temperature [degC],h [W/m^2/K]\n{table}\n")
    wet = '[[convection]]\non = "exposed"\nh = { table = "film.csv" }\nambient = "20 degC"\n'
    run = RUN.replace('"25 degC"', '"400 degC"').replace("300 s", "8 s")
    head = HEAD.replace("20 mm", "0.5 mm")
    _, document, _ = heat(tmp_path, head + wet + PROBE.replace('"20 mm"]', '"0.5 mm"]') + run)
    area = 2.0 * (100 * 80 + 180 * 0.5) * 1e-6
    capacity = document["heat_capacity_J_K"]

    def rate(celsius):
        return -area * np.interp(celsius, *film.T) * (celsius - 20.0) / capacity

    celsius, step = 400.0, 1e-3
    for _ in range(8000):
        first = rate(celsius)
        second = rate(celsius + 0.5 * step * first)
        third = rate(celsius + 0.5 * step * second)
        celsius += step / 6.0 * (first + 2.0 * second + 2.0 * third + rate(celsius + step * third))
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(celsius, abs=0.5)
    assert document["energy"]["imbalance_relative"] < 1e-8


def test_a_held_work_surface_is_at_its_warmup_as_warm_as_it_is_held(tmp_path):
    held = '[[temperature]]\non = "plate.z+"\nvalue = "100 degC"\n'
    _, document, _ = heat(tmp_path, HEAD + held + PROBE + RUN.replace("until", 'target = "90 degC"\nuntil'))
    assert document["warmup_time_s"] == 0.0
    assert document["work_surface"]["at_warmup"]["mean_degC"] == pytest.approx(100.0, abs=1e-9)


def test_a_slow_thermometer_follows_behind(plate, tmp_path):
    text = PLATE.replace('name = "centre"', 'name = "centre"\nlag = "20 s"')
    _, document, _ = heat(tmp_path, text)
    # The plate warms evenly by the end, so the reading is the lag times the rate behind.
    rate = (400.0 - document["power_lost_W"]["convection exposed"]) / document["heat_capacity_J_K"]
    behind = plate[1]["probes"]["centre"]["final_degC"] - document["probes"]["centre"]["final_degC"]
    assert behind == pytest.approx(20.0 * rate, rel=0.03)


def test_ambient_may_follow_a_table(tmp_path):
    (tmp_path / "air.csv").write_text("time [s],temperature [degC]\n0,25\n300,125\n")
    cold = (HEAD + FILM + PROBE + RUN).replace('"25 degC"\n\n[[probe]]', '{ table = "air.csv" }\n\n[[probe]]')
    _, document, _ = heat(tmp_path, cold)
    # Lumped: T' = (a t - T) / tau above the start.
    tau = document["heat_capacity_J_K"] / (12.0 * (0.1 * 0.08 * 2 + 2 * 0.02 * 0.18))
    rate = 100.0 / 300.0
    rise = rate * (300.0 - tau * (1 - np.exp(-300.0 / tau)))
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(25.0 + rise, abs=0.2)


TOUCHING = HEAD.replace("plate", "other").split("[[part]]")[1]

REFUSED = {
    "overlapping parts": (HEAD + "[[part]]" + TOUCHING + HEATER + RUN, "overlap", "part"),
    "probe in the air": (PLATE.replace('"20 mm"]\n[work', '"21 mm"]\n[work'), "in no part", "probe.0.at"),
    "face that does not exist": (
        PLATE.replace('on = "plate.z-"', 'on = "plat.z-"'),
        "plate.z-",
        "heater.0.on",
    ),
    "no way given": (PLATE.replace('on = "plate.z-"', 'on = "plate"'), "NAME.WAY", "heater.0.on"),
    "heater on nothing": (
        PLATE.replace(
            'on = "plate.z-"',
            'on = { part = "plate", box = { origin = ["0 mm","0 mm","5 mm"], size = ["9 mm","9 mm","9 mm"] } }',
        ).replace('"0 mm","0 mm","5 mm"', '"40 mm","40 mm","5 mm"'),
        "inside the box",
        "heater.0.on",
    ),
    "negative film": (
        PLATE.replace('"12 W/m^2/K"', '"-12 W/m^2/K"'),
        "must not be less than 0",
        "convection.0.h",
    ),
    "bare number": (PLATE.replace('"400 W"', "400"), "unit", "heater.0.power"),
    "wrong kind": (PLATE.replace('"400 W"', '"400 K"'), "no unit of power", "heater.0.power"),
    "unknown key": (PLATE.replace("mesh_size", "meshsize"), "", "run"),
    "held and heated": (
        PLATE + '[[temperature]]\non = "plate.z-"\nvalue = "100 degC"\n',
        "contradict",
        "heater.0.on",
    ),
    "insulated and cooled": (
        PLATE.replace('on = "exposed"', 'on = "plate.z+"') + '[[insulated]]\non = "plate.z+"\n',
        "contradict",
        "insulated.0.on",
    ),
    "two heaters on one face": (PLATE + HEATER, "has already", "heater.1.on"),
    "no route in the steady state": (
        (HEAD + HEATER + PROBE + RUN).replace('until = "300 s"', "steady = true"),
        "no route",
        "run.steady",
    ),
    "no end": (PLATE.replace('until = "300 s"', ""), "no end", "run"),
    "unknown material": (
        PLATE.replace('material = "aluminium"', 'material = "steel"'),
        "aluminium",
        "part.0.material",
    ),
    "mesh too large": (PLATE.replace('"25 mm"', '"0.02 mm"'), "GB", "run.mesh_size"),
    "cavity outside": (
        PLATE
        + '[[cavity]]\nname = "hole"\nbox = { origin = ["900 mm","0 mm","0 mm"], size = ["9 mm","9 mm","9 mm"] }\n',
        "cuts nothing",
        "part",
    ),
    "parts that do not touch": (
        PLATE
        + "[[part]]"
        + TOUCHING.replace('["0 mm", "0 mm", "0 mm"]', '["0 mm", "0 mm", "30 mm"]')
        + '[[contact]]\nbetween = ["plate", "other"]\nh = "100 W/m^2/K"\n',
        "do not touch",
        "contact.0.between",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_nonsense_is_refused_with_its_key(tmp_path, case):
    text, words, key = REFUSED[case]
    with pytest.raises(InputError) as refusal:
        heat(tmp_path, text)
    assert words in str(refusal.value)
    assert str(refusal.value.key).startswith(key)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mold.toml"]


def test_table_that_does_not_rise_is_refused_with_its_line(tmp_path):
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n25,5\n100,9\n50,7\n")
    with pytest.raises(InputError, match=r"film\.csv, line 4"):
        heat(tmp_path, PLATE.replace('h = "12 W/m^2/K"', 'h = { table = "film.csv" }'))


def test_stl_with_a_hole_is_refused_with_facet_and_place(tmp_path):
    import trimesh

    box = trimesh.creation.box((40, 40, 20))
    box.update_faces(np.arange(len(box.faces)) != 3)
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(box))
    part = PLATE.split("box =")[0] + 'stl = "part.stl"\n' + HEATER + RUN
    with pytest.raises(InputError, match=r"part\.stl, facet \d+.*open edges"):
        heat(tmp_path, part)


def test_dirty_stl_is_welded_and_meshed_with_a_cavity(tmp_path):
    import trimesh

    whole = trimesh.creation.box((40, 40, 20)).triangles
    soup = whole + 2e-4 * np.sin(np.arange(whole.size)).reshape(whole.shape)
    loose = trimesh.Trimesh(soup.reshape(-1, 3), np.arange(soup.size // 3).reshape(-1, 3), process=False)
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(loose))
    box = 'box = { origin = ["-5 mm","-5 mm","-5 mm"], size = ["10 mm","10 mm","10 mm"] }'
    cavity = f'[[cavity]]\nname = "hole"\n{box}\n'
    text = PLATE.split("box =")[0] + 'stl = "part.stl"\n' + cavity + HEATER.replace("plate.z-", "hole.all") + RUN
    status, document, said = heat(tmp_path, text.replace('"25 mm"', '"10 mm"'))
    assert status == 0
    assert any("welded" in line for line in said)
    assert document["mass_kg"] == pytest.approx(31e-6 * 2702.0, rel=1e-4)
    assert document["conditions"]["heater hole.all"]["area_mm2"] == pytest.approx(600.0, rel=1e-6)


@pytest.mark.parametrize(("axis", "lies", "unit", "mm"), [("y", (1, 2, 0), "inch", 25.4), ("x", (2, 0, 1), "m", 1e3)])
def test_an_stl_stands_where_its_part_says(tmp_path, plate, axis, lies, unit, mm):
    """The plate, drawn about its middle, lying on a side, in another unit: the heat of the one given as a box."""
    import trimesh

    sides = np.array([100.0, 80.0, 20.0])
    drawn = trimesh.creation.box(sides[list(lies)] / mm)
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(drawn))
    place = f'stl = "part.stl"\norigin = ["5 cm", "40 mm", "10 mm"]\naxis = "{axis}"\nunit = "{unit}"\n'
    status, document, _ = heat(tmp_path, PLATE.split("box =")[0] + place + HEATER + FILM + PROBE + RUN)
    assert status == 0
    _, given = plate
    assert document["mass_kg"] == pytest.approx(given["mass_kg"], rel=1e-6)
    points = read_vtu((tmp_path / "heat.vtu").read_bytes(), "heat.vtu").points
    assert np.concatenate([points.min(0), points.max(0)]) == pytest.approx([0, 0, 0, *sides], abs=1e-4)
    for figure in ("mean_degC", "max_degC"):
        assert document["work_surface"][figure] == pytest.approx(given["work_surface"][figure], abs=0.01)


def stacked(folder: Path, gap: float, more: str = ""):
    """The plate with a block on it, whose STL was drawn in inches, ``gap`` mm above, and ``more`` parts."""
    import trimesh

    drawn = trimesh.creation.box((60.0, 40.0, 15.0))
    drawn.apply_translation((50.0, 40.0, 27.5 + gap))
    drawn.apply_scale(1 / 25.4)
    (folder / "block.stl").write_bytes(trimesh.exchange.stl.export_stl(drawn))
    block = '[[part]]\nname = "block"\nmaterial = "aluminium"\nstl = "block.stl"\nunit = "inch"\n'
    return heat(folder, HEAD + block + more + HEATER + RUN + '[work_surface]\non = "block.z+"\n')


def test_an_stl_in_inches_touches_the_box_it_was_drawn_on(tmp_path):
    """Single precision puts its underside at 20.0000005 mm: no heat passed, without a word."""
    status, document, said = stacked(tmp_path, 0.0)
    assert (status, said) == (0, [])
    mass = (100 * 80 * 20 + 60 * 40 * 15) * 1e-9 * 2702.0
    even = 25.0 + 400.0 * 300.0 / (mass * 903.0)  # of one insulated body
    assert document["work_surface"]["mean_degC"] == pytest.approx(even, rel=0.01)


def test_parts_that_meet_in_an_edge_alone_are_told(tmp_path):
    """The nodes of the edge carried heat to the second block, by the size of the elements there."""
    block = HEAD[HEAD.index("[[part]]") :].replace('"plate"', '"block"')
    assert '["0 mm", "0 mm", "0 mm"]' in block
    beside = block.replace('["0 mm", "0 mm", "0 mm"]', '["100 mm", "0 mm", "20 mm"]')
    [said] = heat(tmp_path, HEAD + beside + HEATER + RUN)[2]
    assert said.startswith("parts 'plate' and 'block' meet in an edge or a point alone")


def test_a_part_that_touches_no_other_is_told_with_its_distance(tmp_path):
    status, document, said = stacked(tmp_path, 0.3)
    assert status == 0
    assert document["work_surface"]["mean_degC"] == pytest.approx(25.0, abs=1e-6)
    [one] = said
    assert "part 'block' touches no other: the nearest, 'plate', is 0.3 mm away" in one
    assert document["notes"] == [one]


def test_parts_that_touch_each_other_alone_are_told_together(tmp_path):
    """The plate has most of the mold; the block is no part that touches none."""
    cap = '[[part]]\nname = "cap"\nmaterial = "aluminium"\nbox = '
    cap += '{ origin = ["40 mm", "30 mm", "35.5 mm"], size = ["20 mm", "20 mm", "5 mm"] }\n'
    _, _, [one] = stacked(tmp_path, 0.5, cap)
    assert "parts 'block' and 'cap' touch each other and no other: the nearest, 'plate', is 0.5 mm away" in one


def test_of_a_part_in_two_bodies_the_one_that_touches_no_other_is_told(tmp_path):
    """Nearest to the body that hangs in the air is another part, and its own part touches that elsewhere."""
    import trimesh

    bodies = [trimesh.creation.box((20.0, 40.0, 15.0)) for _ in range(2)]
    bodies[0].apply_translation((20.0, 40.0, 27.5))
    bodies[1].apply_translation((80.0, 40.0, 28.0))
    (tmp_path / "block.stl").write_bytes(trimesh.exchange.stl.export_stl(trimesh.util.concatenate(bodies)))
    block = '[[part]]\nname = "block"\nmaterial = "aluminium"\nstl = "block.stl"\n'
    _, _, [one] = heat(tmp_path, HEAD + block + HEATER + RUN + '[work_surface]\non = "block.z+"\n')
    assert "a body of part 'block' touches no other: the nearest, 'plate', is 0.5 mm away" in one


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('stl = { file = "part.stl", origin = ["0 mm", "0 mm", "0 mm"] }', "its place stands beside it"),
        (
            'box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["9 mm", "9 mm", "9 mm"] }\naxis = "y"',
            "places an stl",
        ),
    ],
)
def test_a_place_that_belongs_elsewhere_is_refused_with_the_right_form(tmp_path, line, says):
    with pytest.raises(InputError, match=says):
        heat(tmp_path, PLATE.split("box =")[0] + line + "\n" + HEATER + FILM + PROBE + RUN)


@pytest.mark.parametrize("fineness", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_a_cavity_may_be_an_stl(tmp_path, fineness):
    import trimesh

    ball = trimesh.creation.icosphere(fineness, radius=8.0)  # 320 facets, and 5120 that are meshed anew
    ball.apply_translation([50, 40, 10])
    (tmp_path / "ball.stl").write_bytes(trimesh.exchange.stl.export_stl(ball))
    text = PLATE.replace("[[heater]]", '[[cavity]]\nname = "ball"\nstl = "ball.stl"\n[[heater]]')
    text = text.replace("plate.z-", "ball.all").replace('"25 mm"', '"15 mm"').replace('"300 s"', '"5 s"')
    status, document, _ = heat(tmp_path, text)
    assert status == 0
    strays = 0.25 * ball.area * 0.015 * 15.0 if fineness == 4 else 1e-3  # 1.5 % of mesh_size is allowed at most [mm^3]
    assert document["mass_kg"] / 2702e-9 == pytest.approx(160e3 - ball.volume, abs=strays)
    assert document["conditions"]["heater ball.all"]["area_mm2"] == pytest.approx(ball.area, rel=0.03)
    assert document["conditions"]["convection exposed"]["area_mm2"] == pytest.approx(23200.0, rel=1e-6)


@pytest.mark.slow
def test_an_stl_that_was_meshed_anew_weighs_what_it_was_given_as(tmp_path):
    """Its few facets hold 3.4 % less before they are curved, which said nothing of the mesh."""
    import trimesh

    ball, hole = trimesh.creation.icosphere(4, radius=30.0), trimesh.creation.icosphere(4, radius=12.0)
    (tmp_path / "ball.stl").write_bytes(trimesh.exchange.stl.export_stl(ball))
    (tmp_path / "hole.stl").write_bytes(trimesh.exchange.stl.export_stl(hole))
    part = PLATE.split("box =")[0] + 'stl = "ball.stl"\n[[cavity]]\nname = "hole"\nstl = "hole.stl"\n'
    text = part + '[[heater]]\nvolume = "plate"\npower = "9 W"\n' + RUN.replace('"25 mm"', '"8 mm"')
    (tmp_path / "mold.toml").write_text(text)
    name, inputs, said = str(tmp_path / "mold.toml"), Inputs(), []
    builder = MoldBuilder(read_document(inputs, name, MoldDocument), name, inputs)
    builder.build(say=said.append)
    weighs = (ball.volume - hole.volume) * 2702e-9
    assert float(said[0].split("weighs ")[1].split(" kg")[0]) == pytest.approx(weighs, rel=5e-4)
    assert [doubt for doubt in builder.doubts if "volume" in doubt] == []


def box_of(x, y, z, *size):
    def mm(*values):
        return "[" + ", ".join(f'"{value} mm"' for value in values) + "]"

    return f"{{ box = {{ origin = {mm(x, y, z)}, size = {mm(*size)} }} }}"


#: A tray of walls and its lid, 40 x 40 x 20 mm, around 30 x 30 x 10 mm of air.
TRAY = [box_of(0, 0, 0, 40, 40, 5), *(box_of(x, 0, 5, 5, 40, 10) for x in (0, 35))]
TRAY += [box_of(0, y, 5, 40, 5, 10) for y in (0, 35)]
BOXED = (
    HEAD.split("box =")[0]
    + f"""shapes = [{", ".join(TRAY)}]
[[part]]
name = "lid"
material = "aluminium"
shapes = [{box_of(0, 0, 15, 40, 40, 5)}]
[[contact]]
between = ["plate", "lid"]
h = "500 W/m^2/K"
"""
)


@pytest.mark.parametrize(("kind", "inside"), [("void of an STL", 600.0), ("gap behind a joint", 3000.0)])
def test_walls_that_are_closed_in_are_not_exposed(tmp_path, kind, inside):
    """A block of 40 x 40 x 20 mm by its outside; no room's air is in there to cool it."""
    import trimesh

    block, void = trimesh.creation.box((40, 40, 20)), trimesh.creation.box((10, 10, 10))
    void.invert()
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(trimesh.util.concatenate([block, void])))
    parts = BOXED if "joint" in kind else HEAD.split("box =")[0] + 'stl = "part.stl"\n'
    heated = HEATER.replace('on = "plate.z-"', 'volume = "plate"')
    status, document, _ = heat(tmp_path, parts + heated + FILM + RUN)
    assert status == 0
    assert document["conditions"]["convection exposed"]["area_mm2"] == pytest.approx(6400.0, rel=1e-9)
    assert f"{inside / 100:g} cm^2 of walls that are closed in" in " ".join(document["notes"])


def test_bodies_of_one_stl_are_a_union_and_one_through_itself_is_refused_with_the_place(tmp_path):
    import trimesh

    block, dome = trimesh.creation.box((40, 40, 20)), trimesh.creation.icosphere(2, radius=12.0)
    dome.apply_translation([0, 0, 10])
    both = trimesh.util.concatenate([block, dome])
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(both))
    part = PLATE.split("box =")[0] + 'stl = "part.stl"\n' + HEATER + RUN.replace('"25 mm"', '"12 mm"')
    status, document, _ = heat(tmp_path, part)
    assert status == 0
    assert document["mass_kg"] == pytest.approx((32e-6 + 2e-9 * np.pi / 3 * 12.0**3) * 2702.0, rel=0.005)
    vertices = dome.vertices.copy()
    vertices[np.argmax(vertices[:, 2]), 2] = -30.0
    spike = trimesh.Trimesh(vertices, dome.faces, process=False)
    (tmp_path / "part.stl").write_bytes(trimesh.exchange.stl.export_stl(spike))
    with pytest.raises(InputError, match=r"goes through itself at \("):
        heat(tmp_path, part)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_end_it_at_once_and_leave_no_child(tmp_path, number, status):
    (tmp_path / "mold.toml").write_text(PLATE.replace('"25 mm"', '"1.5 mm"'))
    start = "from hyperfab.cli import main; main()"
    command = [sys.executable, "-c", start, "mold-heat", "mold.toml", "-o", "heat.json"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not children.read_text().split():
        time.sleep(0.05)
    child = int(children.read_text().split()[0])
    time.sleep(1.0)
    process.send_signal(number)
    assert process.wait(timeout=15.0) == status
    assert not os.path.exists(f"/proc/{child}")
    assert [path.name for path in tmp_path.iterdir()] == ["mold.toml"]


def sample(name, folder):
    """One of the two sample molds, at a coarser mesh than it is shipped with."""
    from hyperfab.samples import sample_files

    (folder / "specimens").mkdir()
    (folder / "molds").mkdir()
    files = sample_files()
    (folder / "specimens/film.csv").write_bytes(files["specimens/film.csv"])
    text = files[f"molds/{name}.toml"].decode()
    size = text.split('mesh_size = "')[1].split('"')[0]
    return heat(folder / "molds", text.replace(f'"{size}"', '"28 mm"'), name)[1]


def test_original_mold_takes_50_minutes(tmp_path):
    document = sample("original", tmp_path)
    assert document["warmup_time_s"] / 60 == pytest.approx(49.9, abs=0.5)
    assert document["energy"]["supplied_J"] == pytest.approx(9.0e6, rel=0.01)
    assert document["work_surface"]["at_warmup"]["spread_K"] < 1.3
    assert document["energy"]["imbalance_relative"] < 1e-10
    assert document["steps"] <= 15


@pytest.mark.slow
def test_proposed_mold_takes_20_minutes_and_is_even(tmp_path):
    document = sample("proposed", tmp_path)
    assert document["warmup_time_s"] / 60 == pytest.approx(19.6, abs=0.3)
    assert document["energy"]["supplied_J"] == pytest.approx(3.5e6, rel=0.02)
    assert document["work_surface"]["at_warmup"]["spread_K"] < 2.4
    assert document["energy"]["imbalance_relative"] < 1e-10


BLOCK = """
[[part]]
name = "block"
material = "aluminium"
START
box = { origin = ["0 mm", "0 mm", "20 mm"], size = ["100 mm", "80 mm", "20 mm"] }
"""
JOINT = """
[[contact]]
between = ["plate", "block"]
h = "1000 W/m^2/K"
schedule = "closed.csv"
fresh = "20 degC"
"""


def test_a_thermostat_whose_probe_comes_fresh_switches_on_again(tmp_path):
    (tmp_path / "closed.csv").write_text("time [s],contact [-]\n0,0\n100,0\n101,1\n600,1\n")
    heater = """
[[heater]]
volume = "block"
power = "1 kW"
control = { probe = "centre", set = "60 degC", band = "4 K" }
"""
    probe = PROBE.replace('"20 mm"]', '"40 mm"]')
    run = RUN.replace('"25 degC"', '"61 degC"').replace('"300 s"', '"600 s"')
    status, document, _ = heat(tmp_path, HEAD + BLOCK.replace("START", "") + JOINT + heater + probe + run)
    assert status == 0
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(60.0, abs=3.0)
    assert 100.0 in document["switches_s"]  # the fresh block is cold: on at once


@pytest.mark.parametrize("first", ["0,0\n1,1", "0,1", "5,1"])
def test_a_part_is_fresh_where_its_contact_closes_at_the_very_start(tmp_path, first):
    (tmp_path / "closed.csv").write_text(f"time [s],contact [-]\n{first}\n600,1\n")
    run = RUN.replace('"25 degC"', '"200 degC"').replace('"300 s"', '"600 s"')
    _, document, _ = heat(tmp_path, HEAD + BLOCK.replace("START", "") + JOINT + PROBE + run)
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(110.0, abs=0.1)


def test_a_part_that_lies_closed_begins_as_its_start_says(tmp_path):
    (tmp_path / "closed.csv").write_text("time [s],contact [-]\n0,1\n600,1\n")
    run = RUN.replace('"25 degC"', '"200 degC"').replace('"300 s"', '"600 s"')
    block = BLOCK.replace("START", 'start = "100 degC"')
    _, document, _ = heat(tmp_path, HEAD + block + JOINT + PROBE + run)
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(150.0, abs=0.1)


def test_a_thermostat_whose_probe_is_held_hot_from_the_start_stays_off(tmp_path):
    held = '[[temperature]]\non = "plate.z+"\nvalue = "90 degC"\n'
    control = 'power = "400 W"\ncontrol = { probe = "centre", set = "60 degC", band = "4 K" }'
    text = HEAD + HEATER.replace('power = "400 W"', control) + held + PROBE + RUN
    status, document, _ = heat(tmp_path, text)
    assert status == 0
    assert document["energy"]["by_condition_J"]["heater plate.z-"] == 0.0


def test_a_surface_held_at_the_target_has_reached_it(tmp_path):
    held = '[[temperature]]\non = "plate.z+"\nvalue = "90 degC"\n'
    _, document, _ = heat(tmp_path, HEAD + held + PROBE + RUN + 'target = "80 degC"\n')
    assert document["warmup_time_s"] == 0.0


def test_a_thermostat_that_would_switch_has_no_steady_state(tmp_path):
    steady = RUN.replace('until = "300 s"', "steady = true")
    control = 'power = "400 W"\ncontrol = { probe = "centre", set = "SET", band = "4 K" }'
    text = HEAD + HEATER.replace('power = "400 W"', control) + FILM + PROBE + steady
    with pytest.raises(InputError, match="switches off at 62") as refused:
        heat(tmp_path, text.replace("SET", "60 degC"))
    assert refused.value.key == "run.steady"
    # One that would never switch off is a heater.
    status, document, _ = heat(tmp_path, text.replace("SET", "5000 degC"))
    assert status == 0
    assert document["power_supplied_W"] == pytest.approx(400.0)


@pytest.mark.parametrize("size", ["40 mm", "20 mm"])
def test_parts_that_begin_apart_share_their_heat(tmp_path, size):
    run = RUN.replace('"300 s"', '"1000 s"').replace('"25 mm"', f'"{size}"').replace('"25 degC"', '"300 degC"')
    _, document, _ = heat(tmp_path, HEAD + BLOCK.replace("START", 'start = "0 degC"') + PROBE + run)
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(150.0, abs=1e-3)


def test_a_part_with_its_own_start_is_laid_on_an_earlier_mold(tmp_path):
    run = RUN.replace('"25 degC"', '"200 degC"')
    heat(tmp_path, HEAD + PROBE + run, "hot")
    later = RUN.replace('"25 degC"', '{ document = "hot.json" }').replace('"300 s"', '"1000 s"')
    _, document, _ = heat(tmp_path, HEAD + BLOCK.replace("START", 'start = "0 degC"') + PROBE + later)
    assert document["probes"]["centre"]["final_degC"] == pytest.approx(100.0, abs=1e-3)


def test_heat_of_melting_is_passed_in_long_steps(tmp_path):
    (tmp_path / "c.csv").write_text(
        "temperature [degC],specific heat [J/kg/K]\n20,900\n100,1100\n110,5000\n130,5000\n140,1000\n"
    )
    text = HEAD.replace('"903 J/kg/K"', '{ table = "c.csv" }').replace("237", "20000")
    heater = HEATER.replace("400 W", "1000 W")
    status, document, _ = heat(
        tmp_path, text + heater + PROBE + RUN.replace('"300 s"', '"900 s"') + 'target = "150 degC"\n'
    )
    heat_to_target = 0.5 * (912.5 + 1100) * 75 + 30500 + 100000 + 30000 + 10000
    capacity = 2702 * 0.1 * 0.08 * 0.02
    assert status == 0
    assert document["warmup_time_s"] == pytest.approx(capacity * heat_to_target / 1000.0, rel=1e-3)


def test_no_heater_is_scaled_beyond_its_bound(tmp_path):
    text = PLATE.replace('until = "300 s"', 'target = "80 degC"')
    wishes = {"share_power": True, "heater_max": "500 W"}
    _, document, _ = heat(tmp_path, text, warmup_in="3 min", **wishes)
    assert document["design"]["power_W"]["heater plate.z-"] <= 500.0
    with pytest.raises(NotConverged, match="more than the 500 W of --heater-max"):
        heat(tmp_path, text, warmup_in="30 s", **wishes)
