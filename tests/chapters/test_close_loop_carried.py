"""What the loop found goes through the other commands: they change, and agree with the data better than before."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

DRAPE = ("--mold", "cup.stl", "--grid", "21x21", "--size", "220mmx220mm", "--depth", "40mm", "-o")
MOLD = """format = "hyperfab.mold/1"
[material.aluminium]
density = "2700 kg/m^3"
conductivity = "160 W/m/K"
specific_heat = "900 J/kg/K"
[[part]]
name = "plate"
material = "aluminium"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["120 mm", "120 mm", "20 mm"] }
[[part]]
name = "block"
material = "aluminium"
box = { origin = ["30 mm", "30 mm", "20 mm"], size = ["60 mm", "60 mm", "60 mm"] }
CONDITIONS
[[convection]]
on = "exposed"
h = "10 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "low"
at = ["60 mm", "60 mm", "10 mm"]
[[probe]]
name = "high"
at = ["60 mm", "60 mm", "70 mm"]
[run]
start = "25 degC"
until = "3000 s"
mesh_size = "30 mm"
"""
HEATER = '[[heater]]\non = "plate.z-"\nschedule = "power.csv"\n'
POWER = "time [s],power [W]\n0,700\n900,700\n901,100\n1500,100\n1501,0\n2300,0\n2301,700\n3000,700\n"
BATH = '[[temperature]]\non = "plate.z-"\nvalue = { table = "bath.csv" }\n'
BATH_TABLE = "time [s],temperature [degC]\n0,25\n600,180\n1800,180\n1900,60\n3000,60\n"


def fabric(weft: float) -> dict[str, object]:
    """Return a fabric whose weft is softer by a factor."""
    warp = {"C10_MPa": 0.06, "C20_MPa": 0.01, "C30_MPa": 0.004}
    return {
        "format": "hyperfab.material/1",
        "model": "yeoh-3",
        "parameters": warp,
        "thickness_mm": 0.5,
        "directions": {
            "warp": {"parameters": warp},
            "weft": {"parameters": {key: weft * value for key, value in warp.items()}},
        },
    }


@pytest.mark.slow
def test_two_directions_found_on_the_testing_machine_are_felt_by_the_drape(hf: Run, tmp_path: Path, root: Path) -> None:
    (tmp_path / "cup.stl").write_bytes((root / "molds" / "cup-male.stl").read_bytes())
    truth = fabric(0.4)
    plain = {key: value for key, value in truth.items() if key != "directions"}
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    (tmp_path / "plain.json").write_text(json.dumps(plain))
    random, lam = np.random.default_rng(3), np.linspace(1.0, 1.6, 60)
    i = lam**2 + 2.0 / lam - 3.0
    for way, factor in (("warp", 1.0), ("weft", 0.4)):
        p = 2.0 * (lam - lam**-2.0) * (0.06 + 2 * 0.01 * i + 3 * 0.004 * i**2) * factor
        rows = [f"{a:.6g},{b:.6g}" for a, b in zip(lam, p + 0.002 * random.standard_normal(60), strict=True)]
        head = f"# test: uniaxial\n# direction: {way}\nstretch [-],stress [MPa]\n"
        (tmp_path / f"{way}.csv").write_text(head + "\n".join(rows) + "\n")
    files = ["--measured", "warp.csv", "--measured", "weft.csv"]
    assert hf("close-loop", "plain.json", *files, "-o", "loop.json", cwd=tmp_path).returncode == 0
    force = {}
    for name in ("truth", "plain", "loop.model"):
        done = hf("drape", f"{name}.json", *DRAPE, f"{name}.out.json", cwd=tmp_path, timeout=300)
        assert done.returncode == 0, done.stderr.decode()
        force[name] = json.loads((tmp_path / f"{name}.out.json").read_text())["force_N"]
    before, after = force["plain"] - force["truth"], force["loop.model"] - force["truth"]
    assert abs(before) > 0.1 * force["truth"]
    assert abs(after) < 0.15 * abs(before)


def thermocouples(hf: Run, folder: Path, truth: str) -> np.ndarray:
    """Write what thermocouples in the true mold read; return it without its noise."""
    (folder / "power.csv").write_text(POWER)
    (folder / "bath.csv").write_text(BATH_TABLE)
    (folder / "truth.toml").write_text(truth)
    assert hf("mold-heat", "truth.toml", "-o", "truth.json", cwd=folder, timeout=300).returncode == 0
    clean = resampled(folder / "truth.csv")
    noisy = clean.copy()
    noisy[:, 1:] += 0.3 * np.random.default_rng(1).standard_normal(clean[:, 1:].shape)
    rows = [",".join(f"{value:.6g}" for value in row) for row in noisy]
    (folder / "tc.csv").write_text("\n".join(["time [s],low [degC],high [degC]", *rows]) + "\n")
    return clean


def resampled(file: Path) -> np.ndarray:
    table = np.loadtxt(file, delimiter=",", skiprows=1)
    times = np.linspace(0.0, 3000.0, 200)
    return np.column_stack([times, *(np.interp(times, table[:, 0], table[:, k]) for k in (1, 2))])


@pytest.mark.slow
def test_radiation_found_on_thermocouples_is_felt_by_mold_heat(hf: Run, tmp_path: Path) -> None:
    sky = '[[radiation]]\non = "exposed"\nemissivity = 0.9\nambient = "25 degC"\n'
    clean = thermocouples(hf, tmp_path, MOLD.replace("CONDITIONS", HEATER + sky))
    (tmp_path / "plain.toml").write_text(MOLD.replace("CONDITIONS", HEATER))
    done = hf("close-loop", "plain.toml", "--measured", "tc.csv", "-o", "loop.json", cwd=tmp_path, timeout=900)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "loop.json").read_text())
    assert [effect["id"] for effect in found["effects"]] == ["radiation"]
    misfit = {}
    for name in ("plain", "loop.model"):
        assert hf("mold-heat", f"{name}.toml", "-o", f"{name}.json", cwd=tmp_path, timeout=300).returncode == 0
        misfit[name] = float(np.sqrt(np.mean((resampled(tmp_path / f"{name}.csv") - clean)[:, 1:] ** 2)))
    assert misfit["plain"] > 5.0
    assert misfit["loop.model"] < 0.5


@pytest.mark.slow
def test_a_joint_is_found_in_a_mold_on_a_bath_of_given_temperature(hf: Run, tmp_path: Path) -> None:
    joint = '[[contact]]\nbetween = ["plate", "block"]\nh = "400 W/m^2/K"\n'
    thermocouples(hf, tmp_path, MOLD.replace("CONDITIONS", BATH + joint))
    (tmp_path / "plain.toml").write_text(MOLD.replace("CONDITIONS", BATH))
    done = hf("close-loop", "plain.toml", "--measured", "tc.csv", "-o", "loop.json", cwd=tmp_path, timeout=900)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "loop.json").read_text())
    assert [effect["id"] for effect in found["effects"]] == ["contact-resistance"]
    assert found["effects"][0]["parameters"]["resistance_m2K_W"] == pytest.approx(1.0 / 400.0, rel=0.1)
    assert hf("mold-heat", found["model"], cwd=tmp_path, timeout=300).returncode == 0


def test_an_extended_model_says_nothing_of_the_old_constants_and_carries_the_ranges_it_was_closed_on(
    hf: Run, tmp_path: Path, root: Path
) -> None:
    samples = root / "specimens" / "lycra"
    first = hf(
        "fit",
        "--uniaxial",
        samples / "warp-23C.csv",
        "--model",
        "yeoh-3",
        "--plane",
        "-o",
        "warp.json",
        cwd=tmp_path,
    )
    assert first.returncode == 0, first.stderr.decode()
    files = [word for name in ("warp-23C", "weft-23C", "warp-80C") for word in ("--measured", samples / f"{name}.csv")]
    done = hf("close-loop", "warp.json", *files, "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    model = json.loads((tmp_path / "loop.model.json").read_text())
    stale = {
        "fit",
        "stability",
        "stability_plane",
        "replicates",
        "left_out",
        "accepted",
        "fit_on",
        "preparation",
    }
    assert not stale & set(model)
    assert model["provenance"]["command"] == "close-loop"
    assert model["provenance"]["inputs"][0]["name"] == "warp.json"
    assert {one["from"] for one in model["validity"]} == {"warp-23C.csv", "weft-23C.csv", "warp-80C.csv"}
    assert all(one["within"] for one in model["validity"])
    low, high = model["tested"]["uniaxial"]["temperature_degC"]
    assert abs(low - 23.0) < 1.0
    assert abs(high - 80.0) < 1.0
    reach = json.loads((tmp_path / "warp.json").read_text())["tested"]["uniaxial"]["stretch"]
    assert model["directions"]["weft"]["tested"]["uniaxial"]["stretch"][1] == pytest.approx(reach[1], rel=0.05)
    # How sure the effects are goes with them, and on from there.
    told = json.loads((tmp_path / "loop.json").read_text())["effects"]
    assert len(told) == len(model["effects"]) > 0
    for one, own in zip(told, model["effects"], strict=True):
        assert own["parameters_sd"] == pytest.approx(one["parameters_sd"], rel=1e-6)
    (tmp_path / "cup.stl").write_bytes((root / "molds" / "cup-male.stl").read_bytes())
    model["directions"]["weft"]["tested"]["uniaxial"]["stretch"] = [1.0, 1.05]
    (tmp_path / "short.json").write_text(json.dumps(model))
    draped = hf("drape", "short.json", "--uncertainty", "none", *DRAPE, "-", cwd=tmp_path)
    found = json.loads(draped.stdout)
    assert found["weft"]["beyond_tested"] > 0 == found["warp"]["beyond_tested"]


def test_where_no_tested_range_is_known_none_is_stated(hf: Run, tmp_path: Path, root: Path) -> None:
    (tmp_path / "cup.stl").write_bytes((root / "molds" / "cup-male.stl").read_bytes())
    (tmp_path / "fabric.json").write_text(json.dumps(fabric(0.5)))
    found = json.loads(hf("drape", "fabric.json", *DRAPE, "-", cwd=tmp_path).stdout)
    assert "beyond_tested" not in found["warp"]
    assert "tested_stretch_max" not in found["warp"]
