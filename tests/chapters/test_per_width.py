"""Constants per width and a thickness that is given: forces are those of the tests, whatever it is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import trimesh

from hyperfab.cli import main
from hyperfab.io.stl_write import stl_bytes

DRAPE = ("--mold", "ball.stl", "--grid", "11x11", "--size", "200mmx180mm", "--depth", "50mm")
PRESS = ("--depth", "30mm", "--steps", "1", "--mesh-size", "20mm", "--tolerance", "1e-2")
#: Stretch and nominal stress [MPa] of a strip.
STRIP = ((1.1, 0.030), (1.3, 0.082), (1.5, 0.125), (1.8, 0.180))


def document(**more: Any) -> str:
    return json.dumps(
        {
            "format": "hyperfab.material/1",
            "model": "yeoh-2",
            "parameters": {"C10_MPa": 0.05, "C20_MPa": 0.01},
            "directions": {
                "warp": {"parameters": {"C10_MPa": 0.06, "C20_MPa": 0.02}},
                "weft": {"parameters": {"C10_MPa": 0.04, "C20_MPa": 0.005}},
            },
            "effects": [{"id": "elastic-law", "form": "high-powers", "parameters": {"C40_MPa": 0.001, "C2_MPa": 0.01}}],
            **more,
        }
    )


@pytest.fixture
def run(tmp_path: Path, monkeypatch, capfd) -> Callable[..., tuple[dict[str, Any], str]]:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    (tmp_path / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    # As hf fit writes a fabric that was tested in N/mm, and the same fabric in MPa over a thickness that is known.
    (tmp_path / "knit.json").write_text(document(thickness_mm=1.0, thickness_nominal=True))
    (tmp_path / "thick.json").write_text(document(thickness_mm=0.5))
    monkeypatch.chdir(tmp_path)

    def run(*words: str, status: int = 0) -> tuple[dict[str, Any], str]:
        monkeypatch.setattr("sys.argv", ["hf", *words])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capfd.readouterr()
        assert end.value.code == status, err
        return json.loads(out) if out else {}, err

    return run


@pytest.mark.parametrize(
    "command",
    [
        ("drape", *DRAPE),
        pytest.param(("drape", *DRAPE, "--sheet", "membrane"), marks=pytest.mark.slow),
        pytest.param(("fabric-contact", *PRESS), marks=pytest.mark.slow),
    ],
)
def test_a_thickness_that_is_given_changes_no_force_of_constants_per_width(run, command):
    name, *words = command
    plain, told = run(name, "knit.json", *words, "-o", "-")
    assert "knit.json is per width: 1 mm is taken" in told
    thin, told = run(name, "knit.json", *words, "--thickness", "0.5mm", "-o", "-")
    assert "per width" not in told
    assert thin["force_N"] == pytest.approx(plain["force_N"], rel=1e-9)
    assert thin["energy_J"] == pytest.approx(plain["energy_J"], rel=1e-9)
    stress = "stress_warp_max_MPa" if name == "drape" else "stress_max_MPa"
    assert thin[stress] == pytest.approx(2.0 * plain[stress], rel=1e-9)
    assert thin["setup"]["thickness_mm"] == 0.5


def test_a_tolerance_of_the_thickness_is_none_of_the_force(run):
    found, _ = run("drape", "knit.json", *DRAPE, "--thickness", "0.5mm +- 0.05mm", "-o", "-")
    quantities = found["uncertainty"]["quantities"]
    assert quantities.get("force_N", {"sd": 0.0})["sd"] < 1e-6 * found["force_N"]
    assert quantities["stress_warp_max_MPa"]["sd"] == pytest.approx(0.1 * found["stress_warp_max_MPa"], rel=0.05)


def test_a_test_that_knows_its_thickness_tells_it_of_the_other_direction(run, tmp_path):
    rows = "".join(f"{stretch},{stress}\n" for stretch, stress in STRIP)
    (tmp_path / "warp.csv").write_text(f"# test: uniaxial\n# thickness: 0.5 mm\nstretch,stress [MPa]\n{rows}")
    per_width = "".join(f"{stretch},{0.5 * stress}\n" for stretch, stress in STRIP)
    (tmp_path / "width.csv").write_text(f"# test: uniaxial\nstretch,membrane stress [N/mm]\n{per_width}")
    over, _ = run("drape", "knit.json", "--warp", "warp.csv", *DRAPE, "-o", "-")
    wide, _ = run("drape", "knit.json", "--warp", "width.csv", *DRAPE, "-o", "-")
    assert over["force_N"] == pytest.approx(wide["force_N"], rel=1e-9)


@pytest.mark.slow
def test_a_sheet_is_compared_over_the_thickness_of_the_first(run):
    alone, _ = run("fabric-contact", "knit.json", *PRESS, "-o", "-")
    found, _ = run("fabric-contact", "thick.json", "--against", "knit.json", *PRESS, "-o", "-")
    assert found["against"]["force_N"] == pytest.approx(alone["force_N"], rel=1e-3)
    _, told = run("fabric-contact", "knit.json", "--against", "thick.json", *PRESS, "-o", "-", status=3)
    assert "knit.json, key thickness_nominal" in told
    assert "give --thickness" in told


def test_a_nominal_thickness_is_none_of_a_layer_in_a_press(run, tmp_path):
    (tmp_path / "foam.toml").write_text(
        'format = "hyperfab.foam/1"\nthickness = "3 mm"\ncompression = { law = "linear", modulus = "0.05 MPa" }\n'
        'fabric = { above = "knit.json", below = "0.5 mm" }\n'
    )
    run("sample", ".")
    molds = ("--male", "molds/plate-male.stl", "--female", "molds/plate-female.stl")
    _, told = run("press-contact", *molds, "--foam", "foam.toml", "--gap", "3mm", "-o", "-", status=3)
    assert "the material document knit.json states no thickness" in told
