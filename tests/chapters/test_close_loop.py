"""``hf close-loop`` as a user calls it."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Run
from loop.generators import fabric as truths
from schemas import follows_schema

from hyperfab.chapters.close_loop.domain import How
from hyperfab.chapters.close_loop.measured_tests import read_measured
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.io.layout import PLAIN
from hyperfab.materials.modes import OF_A_SHEET

MODEL = {
    "format": "hyperfab.material/1",
    "model": "yeoh-3",
    "parameters": {"C10_MPa": 0.1, "C20_MPa": 0.02, "C30_MPa": 0.01},
}

FABRIC_IDS = {"anisotropy", "hysteresis", "rate", "mullins", "permanent-set", "thermal-softening", "grip-slack",
              "load-offset", "compressibility", "elastic-law"}  # fmt: skip

FLAT = "".join(f"{1.0 + 0.02 * i:.6g},0.1\n" for i in range(20))
TWO_BODIES = """format = "hyperfab.mold/1"
[material.body]
density = "2700 kg/m^3"
conductivity = "200 W/m/K"
specific_heat = "500 J/kg/K"
[[part]]
name = "one"
material = "body"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["14.8 mm", "20 mm", "5 mm"] }
[[part]]
name = "two"
material = "body"
box = { origin = ["14.8 mm", "0 mm", "0 mm"], size = ["14.8 mm", "20 mm", "5 mm"] }
[[heater]]
volume = "one"
schedule = "p1.csv"
[[heater]]
volume = "two"
schedule = "p2.csv"
[[convection]]
on = "exposed"
h = "10 W/m^2/K"
ambient = "23 degC"
[[contact]]
between = ["one", "two"]
h = "100 W/m^2/K"
[[probe]]
name = "T1"
at = ["7 mm", "10 mm", "2.5 mm"]
[[probe]]
name = "T2"
at = ["22 mm", "10 mm", "2.5 mm"]
[run]
start = "20.4 degC"
until = "600 s"
mesh_size = "5 mm"
"""


def shop(folder: Path, effects: tuple[str, ...], seed: int = 4, noise: float = 0.004) -> list[str]:
    """Write a model and the tests of a fabric with effects nobody declares; return the arguments."""
    random = np.random.default_rng(seed)
    truth = truths.draw(random, effects)
    readings = truths.measure(truth, truths.rich(1.5, 0.01, 60.0), random, noise)
    (folder / "fabric.json").write_text(json.dumps(MODEL))
    arguments = ["close-loop", "fabric.json"]
    for number, reading in enumerate(readings):
        setup = reading.setup
        head = [
            f"# test: {setup.mode}",
            f"# direction: {'weft' if setup.angle else 'warp'}",
            f"# temperature: {setup.temperature} degC",
            f"# specimen: {reading.specimen}",
            "time [s],stretch [-],stress [MPa]",
        ]
        rows = zip(reading.time, reading.stretch, reading.stress, strict=True)
        body = [f"{t:.6g},{lam:.8g},{p:.6g}" for t, lam, p in rows]
        (folder / f"{number}.csv").write_text("\n".join([*head, *body]) + "\n")
        arguments += ["--measured", f"{number}.csv"]
    return arguments


@pytest.mark.pictures
def test_undeclared_effect_is_found_and_added(hf: Run, tmp_path: Path) -> None:
    arguments = shop(tmp_path, ("thermal-softening",))
    done = hf(*arguments, "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == b""
    document = json.loads((tmp_path / "loop.json").read_text())
    follows_schema(document, "loop")
    assert document["verdict"] == "effect"
    assert [effect["id"] for effect in document["effects"]] == ["thermal-softening"]
    assert document["error"]["before"]["chi2_reduced"] > 1.5
    assert document["error"]["after"]["rms"] < 1.1 * document["error"]["noise"]["rms"]
    assert document["held_out"]["after"]["rms"] < 1.2 * document["held_out"]["noise"]["rms"]
    assert set(document["files"]) == {"loop.csv", "loop.model.json", "loop.png"}
    extended = json.loads((tmp_path / document["model"]).read_text())
    follows_schema(extended, "material")
    assert len(extended["temperatures"]) >= 2
    # As every document it says what was run, and on what.
    assert (extended["setup"], extended["provenance"]) == (document["setup"], document["provenance"])


@pytest.mark.slow
def test_extended_model_leaves_nothing_to_find(hf: Run, tmp_path: Path) -> None:
    arguments = shop(tmp_path, ("anisotropy",))
    assert hf(*arguments, "-o", "loop.json", cwd=tmp_path).returncode == 0
    again = ["close-loop", "loop.model.json", *arguments[2:], "-o", "again.json"]
    done = hf(*again, cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "again.json").read_text())
    assert found["verdict"] == "noise"
    assert found["effects"] == []


@pytest.mark.parametrize("C10", [0.1, pytest.param(-0.1, marks=pytest.mark.slow)])
def test_model_without_stiffness_at_rest_is_refitted(hf: Run, tmp_path: Path, C10: float) -> None:
    """One noisy test may give such constants; the loop begins there, and ends where a material can be."""
    steps = [1.0 + 0.015 * i for i in range(41)]
    rows = "".join(f"{x:.6g},{2 * C10 * (x - x**-2):.6g}\n" for x in steps)
    (tmp_path / "t.csv").write_text("# test: uniaxial\nstretch,stress [MPa]\n" + rows)
    model = {**MODEL, "model": "mooney-rivlin-2", "parameters": {"C10_MPa": 0.3, "C01_MPa": -0.5}}
    (tmp_path / "soft.json").write_text(json.dumps(model))
    done = hf("close-loop", "soft.json", "--measured", "t.csv", "-o", "loop.json", cwd=tmp_path)
    # What pulls back when it is pushed is no material: nothing carries such data.
    assert done.returncode == (1 if C10 < 0.0 else 0), done.stderr.decode()
    assert b"no stiffness at rest" not in done.stderr
    if C10 < 0.0:
        # The least misfit along the edge of what a material can be: C10 + C01 = 0.
        x = np.array(steps)
        edge, stress = 2.0 * (x - x**-2) - 2.0 * (1.0 - x**-3), 2.0 * C10 * (x - x**-2)
        least = np.sqrt(np.mean((stress - edge * (edge @ stress) / (edge @ edge)) ** 2))
        assert json.loads((tmp_path / "loop.json").read_text())["error"]["before"]["rms"] == pytest.approx(
            least, rel=0.01
        )
    extended = json.loads((tmp_path / "loop.model.json").read_text())
    assert sum(extended["parameters"].values()) > 0.0


def test_data_set_apart_are_predicted(hf: Run, tmp_path: Path) -> None:
    arguments = shop(tmp_path, ("thermal-softening",))
    # The weft at the high temperature takes no part.
    arguments = [*arguments[: 2 + 2 * 5], *arguments[2 + 2 * 6 :], "--hold-out", "5.csv"]
    found = json.loads(hf(*arguments, cwd=tmp_path).stdout)
    assert found["held_out"]["source"] == "the files of --hold-out"
    assert found["held_out"]["after"]["rms"] < 1.2 * found["held_out"]["noise"]["rms"]
    assert found["held_out"]["before"]["rms"] > 2.0 * found["held_out"]["after"]["rms"]


def test_every_entry_is_told_also_where_the_data_cannot_show_it(hf: Run, tmp_path: Path) -> None:
    arguments = shop(tmp_path, ())[:4]
    found = json.loads(hf(*arguments, cwd=tmp_path).stdout)
    follows_schema(found, "loop")
    rows = {one["id"]: one for one in found["candidates"]}
    assert set(rows) == FABRIC_IDS
    assert all({"score", "delta_bic", "confounded_with", "shown_by"} <= one.keys() for one in rows.values())
    for name in ("anisotropy", "thermal-softening", "compressibility"):
        assert not rows[name]["visible"]
        assert rows[name]["not_sought"]
        assert (rows[name]["score"], rows[name]["delta_bic"]) == (0.0, 0.0)
    assert rows["hysteresis"]["visible"]
    assert not {"held_out", "next_measurement", "model"} & found.keys()


@pytest.mark.parametrize(
    "effect",
    [
        {"id": "rate", "form": "prony-1", "parameters": {"g1": 0.3, "tau1_s": 5.0}},
        {"id": "load-offset", "form": "drift", "parameters": {"offset_MPa": 0.01, "drift_MPa_s": 1e-4}},
    ],
    ids=["rate", "drift"],
)
def test_model_with_a_rate_needs_tests_with_times(hf: Run, tmp_path: Path, effect: dict[str, Any]) -> None:
    (tmp_path / "fabric.json").write_text(json.dumps(MODEL | {"effects": [effect]}))
    curve = "".join(f"{1.0 + 0.02 * i:.6g},{0.01 * i + 0.0001 * (i % 3):.6g}\n" for i in range(20))
    (tmp_path / "pull.csv").write_text(f"# test: uniaxial\nstretch [-],stress [MPa]\n{curve}")
    done = hf("close-loop", "fabric.json", "--measured", "pull.csv", cwd=tmp_path)
    assert done.returncode == 3
    assert b"fabric.json, key effects.0" in done.stderr
    assert b"column time" in done.stderr


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        (["--fix", "C99_MPa"], 2, "no such constant"),
        (["--noise", "3"], 2, "unit"),
        (["--prior", "10"], 2, "at most 100%"),
        (["--noise", "0MPa"], 2, "more than zero"),
        (["--measured", "0.csv"], 2, "given twice"),
        (["--measured", "nowhere.csv"], 3, "no such file"),
    ],
)
def test_mistakes_are_told(hf: Run, tmp_path: Path, change: list[str], status: int, words: str) -> None:
    arguments = shop(tmp_path, ())
    done = hf(*arguments, *change, cwd=tmp_path)
    assert done.returncode == status
    assert words in done.stderr.decode()
    assert b"Traceback" not in done.stderr


def test_domain_that_is_not_built_is_refused_by_name(hf: Run, tmp_path: Path) -> None:
    (tmp_path / "d.json").write_text('{"format": "hyperfab.heat/1"}')
    done = hf("close-loop", "d.json", "--measured", "x.csv", cwd=tmp_path)
    assert done.returncode == 3
    assert "heat" in done.stderr.decode()


def test_file_the_model_was_fitted_to_is_the_test_it_was_given_as(hf: Run, tmp_path: Path) -> None:
    strain = np.linspace(0.02, 0.5, 40)
    stretch = 1.0 + strain
    stress = 0.1 * (stretch - stretch**-2) * (1.0 + 0.01 * np.random.default_rng(1).standard_normal(40))
    rows = "".join(f"{e:.4f},{s:.6f}\n" for e, s in zip(strain, stress, strict=True))
    (tmp_path / "warp.csv").write_text("strain [-],stress [MPa]\n" + rows)
    done = hf("fit", "--uniaxial", "warp.csv", "--model", "neo-hookean", "-o", "fabric.json", cwd=tmp_path)
    assert done.returncode == 0
    # Of a fit whose set-up was taken from another one's, its own words say nothing of it.
    done = hf("fit", "--like", "fabric.json", "-o", "again.json", cwd=tmp_path)
    assert done.returncode == 0
    for model in ("fabric.json", "again.json"):
        done = hf("close-loop", model, "--measured", "warp.csv", "-o", "loop.json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr.decode()


@pytest.mark.parametrize(
    "knit", ["knit-glove-garter", pytest.param("knit-acrylic-stockinette", marks=pytest.mark.slow)]
)
def test_knits_differ_in_their_two_directions(hf: Run, tmp_path: Path, data_dir: Path, knit: str) -> None:
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    files = [data_dir / knit / f"uniaxial-{way}.csv" for way in ("warp", "weft")]
    done = hf("close-loop", "m.json", "--measured", files[0], "--measured", files[1], cwd=tmp_path, timeout=600)
    found = json.loads(done.stdout)
    assert found["effects"][0]["id"] == "anisotropy"
    assert found["error"]["before"]["nrmse"] > 0.1
    assert found["error"]["after"]["nrmse"] < 0.055


def test_directions_are_named_with_a_contraction_beyond_that_of_a_volume_that_stays(hf: Run, tmp_path: Path) -> None:
    """One strip a direction with its width, which shrinks by more than any isotropic sheet's: threads that turn do
    that. Whether the ground, the grips or the cell make up for the rest these tests do not tell."""
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    random = np.random.default_rng(5)
    strain = np.linspace(0.01, 0.5, 50)
    for way, gain, power in (("warp", 1.0, 0.9), ("weft", 0.4, 0.8)):
        stress = gain * 0.3 * strain * (1.0 + 2.0 * strain**2) * (1.0 + 0.004 * random.standard_normal(50))
        width = (1.0 + strain) ** -power - 1.0
        rows = zip(100.0 * strain, 100.0 * width, stress, strict=True)
        body = "".join(f"{e:.2f},{w:.2f},{s:.5f}\n" for e, w, s in rows)
        head = f"# test: uniaxial\n# direction: {way}\nstrain [%],lateral strain [%],stress [MPa]\n"
        (tmp_path / f"{way}.csv").write_text(head + body)
    done = hf("close-loop", "m.json", "warp.csv", "weft.csv", "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "loop.json").read_text())
    assert found["verdict"] == "ambiguous"
    assert {effect["id"]: effect["form"] for effect in found["effects"]}["anisotropy"] == "bias-threads"
    assert found["error"]["before"]["nrmse"] > 0.1
    assert found["error"]["after"]["nrmse"] < 0.01
    # The contraction has an error of its own, and its rows beside the stresses' in the table.
    told, rows = found["contraction"], list(csv.DictReader(io.StringIO((tmp_path / "loop.csv").read_text())))
    for moment in ("before", "after"):
        left = [float(row["transverse_stretch"]) - float(row[f"transverse_{moment}"]) for row in rows]
        assert told[moment]["rms"] == pytest.approx(np.sqrt(np.mean(np.square(left))), rel=1e-6)
    assert told["after"]["relative_rms"] < 0.05 < told["before"]["relative_rms"]
    assert any("narrower" in line for line in found["summary"])
    sure = {one["id"]: one.get("probability", 0.0) for one in found["candidates"]}
    assert sure["anisotropy"] > 0.5 > max(p for name, p in sure.items() if name != "anisotropy")
    assert "anisotropy" not in {name for group in found["indistinguishable"] for name in group}


def test_a_test_that_no_sheet_law_has_a_say_in_is_told(hf: Run, tmp_path: Path) -> None:
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    pull = "".join(f"{1 + e:.2f},{0.6 * e:.4f}\n" for e in np.linspace(0.02, 0.5, 20))
    pressed = "".join(f"{1 - e:.2f},{-0.2 * e:.4f}\n" for e in np.linspace(0.0, 0.3, 21))
    (tmp_path / "pull.csv").write_text(f"# test: uniaxial\nstretch,stress [MPa]\n{pull}")
    (tmp_path / "held.csv").write_text(f"# test: confined-compression\nstretch,stress [MPa]\n{pressed}")
    done = hf("close-loop", "m.json", "pull.csv", "held.csv", cwd=tmp_path)
    said = "held.csv is left out: the model's law has no say in a confined compression test"
    assert said in done.stderr.decode()
    assert sum(json.loads(done.stdout)["left_out"].values()) == 21


@pytest.mark.slow
def test_elastomer_shows_rate_and_temperature(hf: Run, tmp_path: Path, data_dir: Path) -> None:
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    files = [data_dir / "vhb4905" / f"uniaxial-{t}C.csv" for t in (20, 40)]
    done = hf("close-loop", "m.json", "--measured", files[0], "--measured", files[1], cwd=tmp_path, timeout=600)
    found = json.loads(done.stdout)
    assert {"rate", "thermal-softening"} <= {effect["id"] for effect in found["effects"]}
    assert found["error"]["after"]["nrmse"] < 0.05


@pytest.mark.parametrize(("rows", "words"), [("1,0\n1.2,0.1\n1.3,0.15\n", "too few rows"), (FLAT, "in all 20 rows")])
def test_curves_without_information_are_refused(hf: Run, tmp_path: Path, rows: str, words: str) -> None:
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    (tmp_path / "c.csv").write_text("# test: uniaxial\nstretch [-],stress [MPa]\n" + rows)
    done = hf("close-loop", "m.json", "--measured", "c.csv", cwd=tmp_path)
    assert done.returncode == 3
    assert words in done.stderr.decode()


@pytest.mark.slow
def test_sensors_of_two_heated_bodies_lag(hf: Run, tmp_path: Path, data_dir: Path) -> None:
    power = np.loadtxt(data_dir / "tclab" / "power.csv", delimiter=",", skiprows=2)
    for number, watt in ((1, 0.01), (2, 0.0075)):
        on = power[:, number]
        turns = np.flatnonzero(np.diff(on)) + 1
        at = [(0.0, on[0]), *((power[i, 0] + d, on[i - 1 + (d > 0)]) for i in turns for d in (-0.01, 0.01))]
        body = "\n".join(f"{t:.6g},{watt * percent:.6g}" for t, percent in at)
        (tmp_path / f"p{number}.csv").write_text(f"time [s],power [W]\n{body}\n")
    (tmp_path / "kit.toml").write_text(TWO_BODIES)
    thermocouples = data_dir / "tclab" / "thermocouples.csv"
    done = hf("close-loop", "kit.toml", "--measured", thermocouples, cwd=tmp_path, timeout=600)
    found = json.loads(done.stdout)
    assert done.returncode == 1
    assert [effect["id"] for effect in found["effects"]] == ["sensor-lag"]
    assert found["effects"][0]["parameters"]["lag_s"] == pytest.approx(16.0, abs=2.0)
    assert found["error"]["before"]["rms"] > 1.0
    assert found["error"]["after"]["rms"] <= 0.65


def test_the_axes_of_a_general_biaxial_test_are_across_each_other(tmp_path: Path) -> None:
    rows = "".join(f"{1 + 0.01 * i:.6g},{0.01 * i:.6g},{1 + 0.005 * i:.6g},{0.008 * i:.6g}\n" for i in range(9))
    head = "# test: biaxial-general\nstretch,stress [MPa],stretch 2,stress 2 [MPa]\n"
    (tmp_path / "both.csv").write_text(head + rows)
    job = Job("close-loop", [], Console(True))
    measured = read_measured(job, [str(tmp_path / "both.csv")], PLAIN, None, {}, How(), OF_A_SHEET)
    assert [test.angle_deg for test in measured.tests] == [0.0, 90.0]


def test_what_a_scatter_of_specimens_may_be_is_told_as_such(hf: Run, tmp_path: Path) -> None:
    """One hot specimen, 6 % softer, beside cold ones that differ by 4 %."""
    steps = [*(1.0 + 0.01 * i for i in range(41)), *(1.4 - 0.01 * i for i in range(1, 41))]
    arguments = ["close-loop", "model.json"]
    (tmp_path / "model.json").write_text(json.dumps(MODEL))
    for number, (gain, hot) in enumerate([(1.02, 23), (0.98, 23), (1.025, 23), (0.985, 23), (0.94, 80)]):
        noise = np.random.default_rng(number).normal(0.0, 0.0004, len(steps))
        body = "".join(
            f"{x:.6g},{gain * 2 * (x - x**-2) * (0.1 + 0.04 * (x**2 + 2 / x - 3)) + e:.8g}\n"
            for x, e in zip(steps, noise, strict=True)
        )
        head = f"# test: uniaxial\n# direction: warp\n# rate: 0.01 1/s\n# temperature: {hot} degC\n"
        (tmp_path / f"{number}.csv").write_text(f"{head}stretch,stress [MPa]\n{body}")
        arguments += ["--measured", f"{number}.csv"]
    done = hf(*arguments, cwd=tmp_path)
    document = json.loads(done.stdout)
    assert document["verdict"] == "noise"
    assert "specimens of each kind of test would tell" in document["summary"][-1]
