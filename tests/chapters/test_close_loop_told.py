"""What ``hf close-loop`` says: that it is true, and that nothing is passed over in silence."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import Run
from schemas import follows_schema

from hyperfab.chapters.close_loop import names_of
from hyperfab.chapters.close_loop.describe import _candidates
from hyperfab.chapters.close_loop.fabric import _falls
from hyperfab.chapters.close_loop.finalise import errors_apart
from hyperfab.chapters.close_loop.left_out import missed_by_more, not_added, refused, silent, told_of
from hyperfab.chapters.close_loop.readings import Apart, read_thermocouples
from hyperfab.chapters.close_loop.words import (
    _beside_scatter,
    _effect,
    _far_from_known,
    _no_other,
    _rms_beside_stiffness,
)
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.documents.loop import AddedEffect, Errors, Evidence, Misfit
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import PLAIN, layout
from hyperfab.loop.belief import Belief
from hyperfab.loop.heldout import Help
from hyperfab.loop.judge import Evidence as Weight
from hyperfab.loop.problem import Constant, Effect

MODEL = {
    "format": "hyperfab.material/1",
    "model": "yeoh-3",
    "parameters": {"C10_MPa": 0.2, "C20_MPa": 0.02, "C30_MPa": 0.01},
}


def stress(stretch: np.ndarray) -> np.ndarray:
    """A rubber's nominal stress [MPa]."""
    i = stretch**2 + 2.0 / stretch - 3.0
    return np.asarray(2.0 * (stretch - stretch**-2) * (0.1 + 0.04 * i + 0.02 * i**2))


def write(
    folder: Path, name: str, *, gain: float = 1.0, noise: float = 0.001, seed: int = 0, head: str = "",
    rows: int = 60, slip: float = 0.0, spike: float = 0.0, most: float = np.inf, unit: str = "MPa",
    column: str | None = None, ripple: float = 0.0, offset: float = 0.0,
) -> str:  # fmt: skip
    """Write one pull; return the name of the file."""
    rng = np.random.default_rng(seed)
    stretch = np.linspace(1.0, 1.5, rows)
    read = np.minimum(gain * stress(stretch) + noise * rng.standard_normal(rows), most)
    told = stretch - slip * (np.arange(rows) >= 40)
    read += offset
    read *= 1.0 + ripple * np.sin(0.7 * np.linspace(0.0, 50.0, rows))
    read[rows // 2] += spike * read.max()
    time = np.linspace(0.0, 50.0, rows)
    label = "membrane stress [N/mm]" if unit == "N/mm" else f"stress [{unit}]"
    more = "" if column is None else f",{column}"
    lines = ["# test: uniaxial", *head.splitlines(), f"time [s],stretch [-],{label}{more}"]
    tail = "" if column is None else ",25"
    lines += [f"{t:.6g},{x:.8g},{p:.8g}{tail}" for t, x, p in zip(time, told, read, strict=True)]
    (folder / name).write_text("\n".join(lines) + "\n")
    return name


@pytest.fixture
def model(tmp_path: Path) -> Path:
    (tmp_path / "m.json").write_text(json.dumps(MODEL))
    return tmp_path


def closed(
    hf: Run, folder: Path, files: list[str], *more: str, status: int | None = None
) -> tuple[dict[str, Any], str]:
    words = [word for name in files for word in ("--measured", name)]
    done = hf("close-loop", "m.json", *words, *more, cwd=folder)
    assert done.returncode == status if status is not None else done.returncode in (0, 1), done.stderr.decode()
    document = json.loads(done.stdout) if done.stdout.strip() else {}
    if document:
        follows_schema(document, "loop")
    return document, done.stderr.decode()


def test_the_model_as_delivered_is_told_beside_the_refitted_one(hf: Run, model: Path) -> None:
    found, told = closed(hf, model, [write(model, "a.csv")])
    given = found["error"]["delivered"]
    lam = np.linspace(1.0, 1.5, 60)
    i = lam**2 + 2.0 / lam - 3.0
    off = 2.0 * (lam - lam**-2) * (0.2 + 0.04 * i + 0.03 * i**2) - stress(lam)
    assert given["rms"] == pytest.approx(float(np.sqrt(np.mean(off**2))), rel=0.02)
    assert f"{given['rms']:.3g} MPa ({100 * given['relative_rms']:.2g} %)" in told


def test_readings_beyond_what_the_model_as_delivered_can_answer_are_counted(hf: Run, model: Path) -> None:
    """A law that locks before the last readings: what it misses as delivered was passed over in silence."""
    lock = 1.45**2 + 2.0 / 1.45 - 3.0
    law = {"model": "gent", "parameters": {"mu_MPa": 0.2, "Im": lock}}
    (model / "m.json").write_text(json.dumps(MODEL | law))
    found, told = closed(hf, model, [write(model, "a.csv")])
    assert "delivered" not in found["error"]
    beyond = int(np.count_nonzero(np.linspace(1.0, 1.5, 60) >= 1.45))
    assert f"As delivered the model has no answer at {beyond} of 60 readings." in told


def test_constants_that_leave_what_is_known_of_them_are_told(hf: Run, model: Path) -> None:
    """The model is twice as stiff as the cloth at rest: a good fit that moves it so far is no sign of a good model."""
    name = write(model, "a.csv")
    found, told = closed(hf, model, [name], "--prior", "10%")
    value = found["constants"]["refitted"]["C10_MPa"]
    away = abs(value / 0.2 - 1.0) / 0.1
    assert away > 2.0
    assert f"C10_MPa from 0.2 to {value:.4g} ({away:.2g} standard deviations)" in told
    _, free = closed(hf, model, [name])
    assert "far from what is known" not in free


def test_constants_that_take_all_that_the_model_lacked_are_told(hf: Run, model: Path) -> None:
    """A model stiffer by a fifth: no constant is where it may not be, but the model was off."""
    name = write(model, "a.csv")
    for given, takes in ((0.12, True), (0.1, False)):
        constants = {"C10_MPa": given, "C20_MPa": 0.02, "C30_MPa": 0.02 / 3.0}
        (model / "m.json").write_text(json.dumps(MODEL | {"parameters": constants}))
        found, told = closed(hf, model, [name], "--prior", "20%")
        value = found["constants"]["refitted"]["C10_MPa"]
        assert found["verdict"] == "noise"
        assert "far from what is known" not in told
        said = f"That takes C10_MPa from {given:.4g} to {value:.4g} ({abs(value / given - 1.0) / 0.2:.2g} standard dev"
        assert (said in told) is takes
        assert ("That takes" in told) is takes


@pytest.mark.parametrize("role", ["--hold-out", "--measured"])
@pytest.mark.parametrize("other", ["a.csv", "./a.csv", "copy.csv"])
def test_no_reading_takes_part_twice(hf: Run, model: Path, role: str, other: str) -> None:
    files = [write(model, "a.csv"), write(model, "b.csv", seed=1)]
    shutil.copy(model / "a.csv", model / "copy.csv")
    _, told = closed(hf, model, files, role, other, status=2)
    assert other in told
    assert ("no prediction" if role == "--hold-out" else "count double") in told


def test_the_same_readings_in_a_file_of_another_look_count_once(hf: Run, model: Path) -> None:
    files = [write(model, "a.csv"), write(model, "b.csv", seed=1)]
    once, _ = closed(hf, model, files)
    (model / "copy.csv").write_text("# note: again\n" + (model / "a.csv").read_text())
    twice, told = closed(hf, model, [*files, "copy.csv"])
    assert "copy.csv" in told
    assert sum(twice["left_out"].values()) == 60
    assert twice["constants"] == once["constants"]


def test_what_no_law_knows_is_named(hf: Run, model: Path) -> None:
    files = [
        write(model, "a.csv", column="Wetness [arb]"),
        write(model, "b.csv", seed=1, head="# humidity: 65 %"),
    ]
    found, told = closed(hf, model, files)
    assert "Wetness" in told or "wetness" in told
    assert "humidity" in told
    assert any("humidity" in one for one in found["warnings"])


def test_what_all_tests_state_alike_is_no_state_that_anything_rides_on(hf: Run, model: Path) -> None:
    head = "# load cell: 100 N\n# humidity: {} %"
    files = [write(model, f"{h}.csv", seed=h, head=head.format(h)) for h in (40, 65)]
    found, told = closed(hf, model, files)
    assert "no law knows 40.csv: humidity, 65.csv: humidity: taken as states" in " ".join(found["warnings"])
    assert "stated and not used: load cell\n" in told
    alone, _ = closed(hf, model, files[:1])
    assert not any("no law knows" in one for one in alone["warnings"])


def test_a_state_that_no_law_knows_is_what_the_rest_rides_on(hf: Run, model: Path) -> None:
    wet = [(35, 1.25), (45, 1.1), (55, 0.9), (65, 0.75)]
    files = [
        write(
            model,
            f"{h}-{k}.csv",
            gain=g,
            seed=h + k,
            head=f"# humidity: {h} %\n# specimen: {h}-{k}\n# temperature: {20 + 20 * k} degC",
        )
        for h, g in wet
        for k in range(2)
    ]
    found, _ = closed(hf, model, files, "--noise", "0.001MPa")
    if found["verdict"] == "unexplained":
        assert found["residual"]["rides_on"].get("humidity", 0.0) > 0.3


def dead_load(folder: Path, name: str, load: float, seed: int, came_on: bool = True) -> str:
    """A strip under a weight that comes on within a second: S = 0.2 (l - 1/l^2), and of it one Maxwell branch, a half,
    20 s. The stretch follows from the exact creep of such a solid: J(t) = 1 - exp(-t/30) / 3 for a load put on at once.
    """
    rng, grid = np.random.default_rng(seed), np.linspace(1.0, 1.3, 20001)
    time = np.concatenate([np.linspace(0.0, 1.0, 6), np.geomspace(1.3, 300.0, 36)])

    def ramp(t: np.ndarray) -> np.ndarray:
        return np.asarray(t - 10.0 * (1.0 - np.exp(-t / 30.0)))

    borne = load * (ramp(time) - ramp(np.maximum(time - 1.0, 0.0))) * (1.0 + 0.003 * rng.standard_normal(42))
    stretch = np.interp(borne, 0.2 * (grid - grid**-2), grid)
    rows = [f"{a:.6g},{b:.8f},{load * min(a, 1.0):.8g}" for a, b in zip(time, stretch, strict=True)]
    text = "\n".join(["# test: uniaxial", "time [s],stretch [-],stress [MPa]", *rows[0 if came_on else 5 :]])
    (folder / name).write_text(text + "\n")
    return name


def test_creep_under_a_dead_load_is_no_cell_at_its_range_and_tells_the_branch(hf: Run, model: Path) -> None:
    law = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.12}}
    (model / "m.json").write_text(json.dumps(law))
    files = [dead_load(model, f"{load}.csv", load, seed=k) for k, load in enumerate((0.02, 0.04))]
    found, told = closed(hf, model, files)
    assert not found.get("left_out")
    assert "range" not in told
    (rate,) = [one for one in found["effects"] if one["id"] == "rate"]
    assert rate["parameters"]["g1"] == pytest.approx(0.5, abs=0.05)
    assert rate["parameters"]["tau1_s"] == pytest.approx(20.0, rel=0.1)
    _, told = closed(hf, model, [dead_load(model, "on.csv", 0.04, seed=2, came_on=False)], status=3)
    assert "the stress is 0.04 in all 37 rows" in told
    assert "and the rows in which the load comes on" in told


def test_a_slip_of_the_extensometer_is_told_and_no_effect(hf: Run, model: Path) -> None:
    files = [write(model, f"{k}.csv", slip=0.03, seed=k, rows=80) for k in range(3)]
    found, told = closed(hf, model, files)
    assert "0.csv, line 43" in told
    assert "steps back" in told
    assert found["effects"] == []
    assert found["verdict"] == "noise"
    assert sum(found["left_out"].values()) == 3 * 40


def test_readings_at_the_end_of_the_range_and_spikes_are_told_and_left_out(hf: Run, model: Path) -> None:
    top = float(stress(np.array([1.4]))[0])
    files = [write(model, f"{k}.csv", most=top, seed=k, noise=2e-4) for k in range(2)]
    files.append(write(model, "spike.csv", spike=0.3, seed=9, noise=2e-4))
    found, told = closed(hf, model, files)
    assert "same largest stress" in told
    assert "spike.csv, line 33" in told
    assert found["effects"] == []
    assert found["verdict"] == "noise"


@pytest.mark.slow
def test_a_prediction_that_got_worse_is_not_passed_over(hf: Run, model: Path) -> None:
    """The files set apart disagree with those that take part: no effect may make that more."""
    files = [
        write(model, f"{t}{k}.csv", gain=g, seed=t + k, head=f"# temperature: {t} degC")
        for t, g in ((20, 1.0), (60, 0.7))
        for k in range(2)
    ]
    write(model, "apart.csv", gain=1.3, seed=7, head="# temperature: 90 degC")
    found, told = closed(hf, model, files, "--hold-out", "apart.csv")
    held = found["held_out"]
    assert held["after"]["rms"] <= held["before"]["rms"]
    assert "not added: thermal-softening" in told
    assert found["verdict"] == "unexplained"


def test_a_file_held_out_is_the_test_that_all_measured_ones_were_given_as(hf: Run, model: Path) -> None:
    """A file of --hold-out has no other option that could say it."""
    for name in ("a.csv", "b.csv", "apart.csv"):
        write(model, name, seed=ord(name[0]) + len(name))
        (model / name).write_text((model / name).read_text().removeprefix("# test: uniaxial\n"))
    found, told = closed(hf, model, [], "--uniaxial", "a.csv", "--uniaxial", "b.csv", "--hold-out", "apart.csv")
    assert found["held_out"]["source"] == "the files of --hold-out"
    assert "apart.csv: uniaxial, as all measured files were given" in told
    write(model, "b.csv", seed=1)
    _, told = closed(hf, model, ["b.csv"], "--uniaxial", "a.csv", "--hold-out", "apart.csv", status=3)
    assert "does not say which test it is" in told
    assert '"# test: uniaxial"' in told
    assert "--uniaxial apart.csv" not in told  # that would have it measured
    write(model, "apart.csv", seed=1)
    (model / "apart.csv").write_text((model / "apart.csv").read_text().replace("uniaxial", "shear"))
    write(model, "b.csv", seed=2)
    found, _ = closed(hf, model, [], "--uniaxial", "a.csv", "--uniaxial", "b.csv", "--hold-out", "apart.csv")
    assert found["held_out"]["before"]["relative_rms"] > 0.05  # what it says itself counts


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_only_called_so_where_the_tests_say_so(hf: Run, model: Path, seed: int) -> None:
    files = [
        write(model, f"{t}.csv", gain=1.0 - 0.004 * (t - 20), seed=t + seed, head=f"# temperature: {t} degC")
        for t in (20, 40, 60)
    ]
    found, told = closed(hf, model, files)
    assert ("What is left is noise" in told) == (found["residual"]["is_noise"] and found["verdict"] != "unexplained")


def test_noise_that_is_a_guess_is_warned_of(hf: Run, model: Path) -> None:
    files = [write(model, f"{k}.csv", rows=41, seed=k) for k in range(4)]
    for name in files:
        lines = (model / name).read_text().splitlines()
        (model / name).write_text("\n".join([*lines[:2], *lines[2::12]]) + "\n")
    found, told = closed(hf, model, files)
    assert found["noise"]["source"].startswith("assumed")
    assert "--noise" in told


def test_a_force_per_width_keeps_its_unit_where_the_thickness_is_none(hf: Run, model: Path) -> None:
    (model / "m.json").write_text(json.dumps({**MODEL, "thickness_mm": 1.0, "thickness_nominal": True}))
    found, told = closed(hf, model, [write(model, "a.csv", unit="N/mm")])
    assert found["error"]["unit"] == "N/mm"
    assert "MPa (" not in told


def test_a_force_per_width_in_another_unit_is_asked_about_in_its_own(hf: Run, model: Path) -> None:
    (model / "m.json").write_text(json.dumps({**MODEL, "thickness_mm": 1.0, "thickness_nominal": True}))
    _, told = closed(hf, model, [write(model, "a.csv", unit="N/mm", gain=30.0)])
    assert "readings in N/mm are" in told


def test_a_modulus_that_no_material_has_is_not_given(hf: Run, model: Path) -> None:
    """Curves flat at rest, one a direction: unbounded constants would begin with a negative modulus."""
    rng, files = np.random.default_rng(0), []
    for way, size in (("warp", 0.6), ("weft", 0.3)):
        lam = np.linspace(1.0, 1.6, 60)
        read = size * (lam - 1.0) ** 3.5 + 2e-4 * rng.standard_normal(60)
        rows = "".join(f"{x:.6g},{p:.6g}\n" for x, p in zip(lam, read, strict=True))
        (model / f"{way}.csv").write_text(f"# test: uniaxial\n# direction: {way}\nstretch,stress [MPa]\n{rows}")
        files.append(f"{way}.csv")
    found, told = closed(hf, model, files)
    assert "no stiffness at rest" not in told
    if any("nature allows" in one for one in found["warnings"]):
        assert "Young's modulus" in told


def warm(folder: Path, ripple: float) -> list[str]:
    """Tests at 20 and 60 degC, softer when warm, and a ripple in time that no entry of the catalogue knows."""
    return [
        write(folder, f"{t}-{k}.csv", gain=g, seed=t + k, head=f"# temperature: {t} degC", ripple=ripple)
        for t, g in ((20, 1.0), (60, 0.7))
        for k in range(2)
    ]


def test_terms_beside_which_something_stays_unexplained_are_marked(hf: Run, model: Path) -> None:
    found, told = closed(hf, model, warm(model, 0.08), "-o", "loop.json", status=1)
    found = json.loads((model / "loop.json").read_text())
    assert found["verdict"] == "unexplained"
    names = [effect["id"] for effect in found["effects"]]
    assert "thermal-softening" in names
    assert all(effect["tentative"] for effect in found["effects"])
    written = json.loads((model / "loop.model.json").read_text())
    follows_schema(written, "material")
    assert [one["id"] for one in written["effects"] if one["tentative"]] == names
    assert f"{', '.join(names)} {'are' if len(names) > 1 else 'is'} the nearest" in told
    assert any("stays unexplained" in one for one in found["warnings"])
    used = hf("export", "loop.model.json", "--to", "febio", "-o", "card.feb", cwd=model)
    assert f"left something unexplained beside {', '.join(names)}" in used.stderr.decode()


def test_terms_beside_which_nothing_is_left_are_not_marked(hf: Run, model: Path) -> None:
    files = warm(model, 0.0)
    _, told = closed(hf, model, files, "-o", "loop.json", status=0)
    found, written = (json.loads((model / f"loop{end}").read_text()) for end in (".json", ".model.json"))
    assert found["verdict"] in ("effect", "ambiguous")
    assert not any(effect["tentative"] for effect in found["effects"])
    assert not any("tentative" in one for one in written["effects"])
    assert "stays unexplained" not in told
    # What was tentative no longer is where a later loop leaves nothing.
    written["effects"][0]["tentative"] = True
    (model / "m.json").write_text(json.dumps(written))
    closed(hf, model, files, "-o", "again.json", status=0)
    again = json.loads((model / "again.model.json").read_text())
    assert not any("tentative" in one for one in again["effects"])


def test_what_was_left_before_is_told_beside_what_is_left_after(hf: Run, model: Path) -> None:
    found, told = closed(hf, model, warm(model, 0.0), status=0)
    left = found["residual"]
    assert left["is_noise"] is True
    assert left["before"]["is_noise"] is False
    assert left["before"]["structured"] > left["structured"]
    assert left["before"]["p_lack_of_fit"] < 1e-6
    assert "What is left is noise" in told


def test_looking_at_the_cause_is_advised_before_one_more_test(hf: Run, model: Path) -> None:
    """A load cell off its zero is seen at rest; a test in another mode has to infer it."""
    files = [write(model, f"{k}.csv", seed=k, offset=0.02) for k in range(3)]
    found, told = closed(hf, model, files, status=0)
    assert any("load-offset" in one for one in found["indistinguishable"])
    lines = [line for line in found["summary"] if line.startswith(("What shows", "Or measure", "Measure"))]
    assert [line.split(":")[0] for line in lines] == ["What shows each of them", "Or measure next"]
    assert "readings at rest, before the pull" in lines[0]
    assert lines[0] in told.replace("\n", " ")


def test_rows_of_thermocouples_that_are_no_reading_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{t},{20 + t}\n" for t in range(9))
    (tmp_path / "t.csv").write_text(f"time [s],a [degC]\n{rows},,\nmean,24\n")
    read = read_thermocouples(Job("close-loop", [], Console(True)), "t.csv", ["a"], PLAIN)
    assert len(read.times) == 9
    assert read.left_out == {"blank row": 1, "closing row, no reading": 1}


@pytest.mark.parametrize("mean", [False, True])
def test_the_least_and_the_largest_of_a_probe_are_no_probes(
    mean: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recorder's pair of each channel is taken for its middle; beside the mean of a region neither is taken."""
    monkeypatch.chdir(tmp_path)
    head = "time [s],a Min [degC],a Max [degC]" + (",a Mean [degC]" if mean else "")
    rows = "".join(f"{t},{18 + t},{24 + t}" + (f",{20 + t}\n" if mean else "\n") for t in range(9))
    (tmp_path / "t.csv").write_text(f"{head}\n{rows}")
    read = read_thermocouples(Job("close-loop", [], Console(False)), "t.csv", ["a"], PLAIN)
    assert read.names == ["a"]
    assert read.readings[:, 0].tolist() == [(20.0 if mean else 21.0) + t for t in range(9)]
    assert ("a is taken as the middle of a Min and a Max" in capsys.readouterr().err) != mean


@pytest.mark.parametrize(("rows", "off"), [((30,), 8.0), ((30, 31), -15.0)])
def test_a_thermocouple_that_jumps_for_a_row_or_two_is_told_and_left_out(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    rows: tuple[int, ...],
    off: float,
) -> None:
    monkeypatch.chdir(tmp_path)
    times = np.arange(80.0)
    noise = 0.2 * np.random.default_rng(0).standard_normal(80)
    warm = 25.0 + 55.0 * (1.0 - np.exp(-times / 25.0)) + noise
    # Beside it a plate on a thermostat, which goes up and down as it should.
    plate = 60.0 + 3.0 * np.sin(times / 3.0) + noise
    jumped = warm.copy()
    jumped[list(rows)] += off
    body = "".join(f"{t:g},{a:.3f},{b:.3f}\n" for t, a, b in zip(times, jumped, plate, strict=True))
    (tmp_path / "t.csv").write_text(f"time [s],a [degC],b [degC]\n{body}")
    read = read_thermocouples(Job("close-loop", [], Console(True)), "t.csv", ["a", "b"], PLAIN)
    assert np.flatnonzero(~np.isfinite(read.readings[:, 0])).tolist() == list(rows)
    assert np.all(np.isfinite(read.readings[:, 1]))
    assert read.left_out == {"a off its neighbours": len(rows)}
    assert "t.csv, line 32: a reads" in capsys.readouterr().err


@pytest.mark.parametrize("begun", [0, 5000])
def test_a_log_that_begins_long_after_the_run_is_told(
    begun: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("time [s],a [degC]\n" + "".join(f"{begun + 10 * t},{20 + t}\n" for t in range(9)))
    read_thermocouples(Job("close-loop", [], Console(True)), "t.csv", ["a"], PLAIN)
    assert ("begin 5000 s after the start of the run and go on for 80 s" in capsys.readouterr().err) == bool(begun)


def test_probes_that_the_mold_has_not_are_left_out_by_the_option_that_the_message_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{t},{20 + t},21,22\n" for t in range(9))
    (tmp_path / "t.csv").write_text(f"time [s],a [degC],room [degC],T9 [degC]\n{rows}")
    job = Job("close-loop", [], Console(True))
    option = "room=aside,T9=aside"
    with pytest.raises(InputError, match=f'--columns "{option}"'):
        read_thermocouples(job, "t.csv", ["a"], PLAIN)
    assert read_thermocouples(job, "t.csv", ["a"], layout([option])).names == ["a"]
    (tmp_path / "p.csv").write_text(f"time [s],cup tip [degC],room far [degC],T9 [degC]\n{rows}")
    with pytest.raises(InputError, match=re.escape('"cup tip=cup [degC],room far=room [degC]"')):
        read_thermocouples(job, "p.csv", ["room", "cup"], PLAIN)
    with pytest.raises(
        InputError, match=r'name = "a"\), or say which it is, as in --columns "a=cup \[degC\]"$'
    ):  # none is left where all are set aside
        read_thermocouples(job, "t.csv", ["cup"], PLAIN)


def test_an_effect_that_was_added_is_not_among_those_the_data_cannot_show() -> None:
    """Its simplest form left no imprint, which a flexible law imitates; a richer one did."""
    effect = Effect("grip-slack", "the grips take up part of the extension", "marks", "", ())
    found = SimpleNamespace(
        scores={}, worth={}, indistinguishable=(), belief=None, tried={},
        added={"grip-slack": SimpleNamespace(delta_bic=120.0)},
    )  # fmt: skip
    [row] = _candidates(SimpleNamespace(effects=(effect,)), found)  # type: ignore[arg-type]
    assert row.visible


@pytest.mark.parametrize(("beside", "told"), [({"tilt", "set"}, False), ({"wedge"}, True)])
def test_what_might_stand_in_place_of_a_name_with_more_constants_is_told(beside: set[str], told: bool) -> None:
    belief = Belief({frozenset({"tilt"}): 0.6, frozenset(beside): 0.4}, 0.0, 0.0)
    found: Any = SimpleNamespace(after=SimpleNamespace(ids=("tilt",)), belief=belief)
    assert ("though with more of them wedge (0.4) might" in _no_other(found)) is told


def test_the_noise_of_readings_set_apart_is_that_of_all_others_of_their_kind() -> None:
    """Where it goes with the reading that of the first row is the least; what is known of constants is no reading."""
    problem = SimpleNamespace(
        channel=np.array([0, 0, 0, 1, 0, 0]), predict=lambda own, terms: np.arange(6.0), units=("N",)
    )
    fit = SimpleNamespace(x=np.zeros(1), own=1, terms={})
    noise = SimpleNamespace(sd=np.array([0.1, 0.5, 0.7, 1.0]), gain_sd=0.0)
    state = SimpleNamespace(fit=fit)
    found = SimpleNamespace(before=state, after=state, noise=noise)
    apart = Apart(problem, slice(4, None), np.array([4.5, 4.5]))  # type: ignore[arg-type]
    errors = errors_apart(apart, found)  # type: ignore[arg-type]
    assert errors.noise.rms == pytest.approx(np.sqrt((0.01 + 0.25 + 0.49) / 3.0))
    assert errors.after.rms == pytest.approx(0.5)


def test_the_columns_of_a_logger_are_said_to_be_probes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = "".join(f"{10 * k};{25 + k};{24 + k};25\n" for k in range(12))
    (tmp_path / "t.csv").write_text(f"Zeit [s];Sensor 1 (degC);Kanal 2;Raum [degC]\n{rows}")
    monkeypatch.chdir(tmp_path)
    job, probes = Job("close-loop", [], Console(True)), ["centre", "Edge-left 2"]
    said = layout(["Sensor 1=EDGE-left 2,Kanal 2=centre [degC],Raum=aside"], own=probes)
    read = read_thermocouples(job, "t.csv", probes, said)
    assert read.names == ["Edge-left 2", "centre"]
    assert read.readings[0].tolist() == [25.0, 24.0]
    with pytest.raises(InputError, match="is no probe of the mold") as refused:
        read_thermocouples(job, "t.csv", probes, PLAIN)
    assert '--columns "Sensor 1=centre [degC]"' in str(refused.value)
    with pytest.raises(InputError) as refused:
        read_thermocouples(job, "t.csv", probes, layout(["Sensor 1=centre"], own=probes))
    assert '--columns "Sensor 1=centre,Raum=Edge-left 2 [degC]"' in str(refused.value)
    with pytest.raises(InputError, match="Kanal 2 has no unit of a temperature"):
        read_thermocouples(job, "t.csv", probes, layout(["Sensor 1=centre,Kanal 2=Edge-left 2,Raum=aside"], own=probes))
    twice = layout(["Sensor 1=centre,Kanal 2=centre [degC],Raum=aside"], own=probes)
    with pytest.raises(InputError, match="is centre, as another column is"):
        read_thermocouples(job, "t.csv", probes, twice)
    with pytest.raises(UsageError, match="names are centre, Edge-left 2, stretch"):
        layout(["Sensor 1=center"], own=probes)


def test_a_constant_that_went_as_far_as_it_may_is_told_to_be_there() -> None:
    """A joint at a fifth of its conductance might have gone to a tenth; one at three tenths was found."""
    joints = [Constant(f"contact.{k}.h", 1.0, 0.2, 1.8, 0.1, 0.1) for k in range(2)]
    problem: Any = SimpleNamespace(expected=joints)
    found: Any = SimpleNamespace(after=SimpleNamespace(fit=SimpleNamespace(x=np.array([0.2, 0.3]), own=2)))
    document: Any = SimpleNamespace(error=SimpleNamespace(delivered=None))
    (line,) = _far_from_known(problem, found, document)
    assert "contact.0.h from 1 to 0.2 (8 standard deviations, the farthest it may go)" in line
    assert "contact.1.h from 1 to 0.3 (7 standard deviations)" in line


@pytest.mark.parametrize(
    ("domain", "many", "one"),
    [("heat", "3 probes", "1 probe"), ("fabric", "3 tests", "1 test"),
     ("press", "3 parts of the readings", "1 part of the readings")],
)  # fmt: skip
def test_what_is_left_out_is_called_what_it_is(domain: str, many: str, one: str) -> None:
    """The probes of a mold, and the parts of one file, were called tests."""
    size = Misfit(rms=1.0, relative_rms=0.1, nrmse=0.1, chi2_reduced=1.0)
    held = Errors(unit="K", before=size, after=size, noise=size, tests=3, source="each predicted from all others")
    assert told_of(held, domain) == f"On {many} left out, each predicted from the others it misses by 1 K (10 %)."
    assert told_of(held.model_copy(update={"tests": 1}), domain).startswith(f"On {one} left out, predicted")
    assert missed_by_more(held, domain).startswith(f"{many.removeprefix('3 ')} left out")
    assert f"or {many.removeprefix('3 ')} left out" in not_added(["tilt"], domain)
    apart = held.model_copy(update={"source": "the files of --hold-out"})
    assert told_of(apart, domain).startswith("On 3 tests left out it misses")


def test_readings_of_nothing_are_told_beside_the_noise_of_those_that_read() -> None:
    """A film that reads nothing on half of its rows was said to be missed by less than its noise."""
    read = np.array([0.0, 0.0, 0.0, 0.2, 0.3])
    problem: Any = SimpleNamespace(measured=read, channel=np.zeros(5, dtype=int))
    found: Any = SimpleNamespace(
        after=SimpleNamespace(fit=SimpleNamespace(predicted=np.array([0.0, 0.0, 0.1, 0.3, 0.3])))
    )
    assert "all 5 readings, of which 2 read nothing where the model has nothing" in silent(problem, found)
    found.after.fit.predicted = read + 0.1
    assert silent(problem, found) == ""


@pytest.mark.parametrize("added", [True, False])
def test_whether_what_was_found_comes_on_top_of_what_the_model_has_is_told(added: bool) -> None:
    """``mu 0.4272`` beside a model with 0.1 was read as all there is."""
    effect = AddedEffect(
        id="friction", title="it rubs", form="Coulomb", source="", parameters={"mu": 0.4272},
        evidence=Evidence(delta_bic=20.0, variance_share=1.0),
    )  # fmt: skip
    entry = Effect("friction", "it rubs", "", "", (), added=added)
    problem: Any = SimpleNamespace(effect={"friction": entry}.__getitem__)
    more = ", added to what the model has" * added
    assert _effect(problem, effect) == f"friction: it rubs (Coulomb: mu 0.4272{more}); the evidence is decisive."


@pytest.mark.parametrize(("gains", "told"), [((0.85, 1.15), True), ((1.0, 1.0), False)])
def test_what_was_added_is_told_beside_how_specimens_differ(gains: tuple[float, float], told: bool) -> None:
    """Two specimens stiffer and softer by 15 %: the rms hardly moves, though all that each leaves is explained."""
    stretch = np.linspace(1.0, 1.5, 60)
    lacks, whole = 0.9 * stress(stretch) + 0.01 * np.sin(30.0 * stretch), stress(stretch)
    measured = np.concatenate([gain * whole for gain in gains])
    before, after = (SimpleNamespace(fit=SimpleNamespace(predicted=np.tile(one, 2))) for one in (lacks, whole))
    size = [float(np.sqrt(np.mean((measured - one.fit.predicted) ** 2))) for one in (before, after)]
    errors: Any = SimpleNamespace(
        error=SimpleNamespace(
            before=SimpleNamespace(rms=1.05 * size[1]), after=SimpleNamespace(rms=size[1]), unit="MPa"
        )
    )
    groups = (np.arange(60), np.arange(60, 120))
    found: Any = SimpleNamespace(
        noise=SimpleNamespace(gain_sd=float(np.std(gains)), groups=groups), before=before, after=after
    )
    problem: Any = SimpleNamespace(measured=measured)
    said = list(_beside_scatter(problem, found, errors))
    assert bool(said) == told
    if told:
        assert "without, by" in said[0]
        assert float(said[0].split(" with what was added")[0].split()[-2]) == pytest.approx(0.0, abs=1e-12)


def test_a_specimen_slack_to_the_model_throughout_is_scaled_to_nothing() -> None:
    read, rows = np.array([0.3, 0.4]), (np.arange(2),)
    assert _rms_beside_stiffness(read, np.zeros(2), rows) == pytest.approx(0.25 * np.sqrt(2.0))


@pytest.mark.parametrize(
    ("help_", "share", "says"),
    [
        (
            Help(-0.7, 0.0, 2),
            0.6,
            "elastic-law lowers BIC by 11, but is not added: tests left out are foretold no better",
        ),
        (None, 0.02, "elastic-law lowers BIC by 11, but is not added: it takes 2% of what lacks"),
        (Help(0.9, 1.0, 2), 0.6, None),
    ],
)
def test_an_entry_with_evidence_that_is_not_added_is_told_why(
    help_: Help | None, share: float, says: str | None
) -> None:
    """Of a decisive entry beside `unexplained` a reader asks why it is not in the model."""
    tried = {
        "elastic-law": Weight(11.2, share, help_, certain=True),
        "grip-slack": Weight(-1.0, 0.1, None, certain=True),
    }
    found: Any = SimpleNamespace(tried=tried, added={}, doubted=(), worse=())
    told = list(refused(found, "fabric"))
    assert told == [] if says is None else told[0].startswith(says)
    assert list(refused(SimpleNamespace(**{**vars(found), "doubted": ("elastic-law",)}), "fabric")) == []  # type: ignore[arg-type]


def test_a_law_that_falls_within_its_tests_is_told() -> None:
    """What turns a strip up at its end may take all of its stiffness before."""
    powers = {"C20_MPa": -2.174, "C30_MPa": 3.584, "C01_MPa": -1.367, "C11_MPa": 1.676}
    strip = {
        "model": "neo-hookean",
        "parameters": {"C10_MPa": 1.368},
        "tested": {"uniaxial": {"stretch": [1.0, 1.4]}, "biaxial": {"stretch": [1.0, 1.05]}},
    }
    added = {"effects": [{"id": "elastic-law", "form": "powers-mixed", "parameters": powers}]}
    along = {key: strip[key] for key in ("parameters", "tested")}
    sheet = strip | {"directions": {"warp": along, "weft": along}}
    told = [[*_falls(MaterialDocument.model_validate(one))] for one in (strip, strip | added, sheet | added)]
    assert [len(one) for one in told] == [0, 2, 4]
    assert re.findall(r"in (\S+) tests, which went to (\S+):", " ".join(told[1])) == [
        ("uniaxial", "1.4"),
        ("biaxial", "1.05"),
    ]


@pytest.mark.parametrize(("unit", "full"), [("%", 100.0), ("-", 1.0)])
def test_a_duty_is_a_share_of_what_the_heaters_are_rated_at(
    unit: str, full: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A controller logs how much of the time its heaters were on; no column could be called a power but by its head."""
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{t};{20 + t};{full * (t % 2):g}\n" for t in range(9))
    (tmp_path / "t.csv").write_text(f"time;a;Stellgrad\ns;°C;{unit}\n{rows}")
    job, said = Job("close-loop", [], Console(True)), layout([f"Stellgrad=power [{unit}]"], own=["a", "power"])
    assert names_of("mold", {"probe": [{"name": "a"}]}) == ["a", "power"]
    read = read_thermocouples(job, "t.csv", ["a"], said, {"power": 800.0})
    assert read.powers["power"].tolist() == [0.0, 800.0] * 4 + [0.0]
    with pytest.raises(InputError, match="is a share of what power"):
        read_thermocouples(job, "t.csv", ["a"], said, {"power": None})
    aside = read_thermocouples(job, "t.csv", ["a"], PLAIN, {"power": 800.0}).unread
    assert [one.title for one in aside if one.unit == "%"] == (["Stellgrad"] if unit == "%" else [])
