"""Simple shear of laws that keep their volume: planar tension but for a turn."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Run

from hyperfab.materials import bind, laws
from hyperfab.materials.modes import nominal_stress

STRAIN = np.concatenate([np.linspace(-0.6, -0.05, 12), np.linspace(0.05, 1.5, 30)])
OGDEN = {"mu1_MPa": 0.2, "alpha1": 5.0}
TOY = {
    "mu": 0.3,
    "alpha": 2.5,
    "a": 1.2,
    "b": 2.0,
    "J": 30.0,
    "N": 8.0,
    "lambda_m": 3.0,
    "D": 0.3,
    "delta": 0.05,
}


def ogden(strain: np.ndarray) -> np.ndarray:
    """Return the shear stress of OGDEN, W = 2 mu/alpha (l^alpha + l^-alpha - 2) / alpha along the strain l - 1/l."""
    mu, alpha = OGDEN["mu1_MPa"], OGDEN["alpha1"]
    stretch = 0.5 * strain + np.sqrt(1.0 + 0.25 * strain**2)
    return mu * (stretch**alpha - stretch**-alpha) / (stretch + 1.0 / stretch)


def write(path: Path, stress: np.ndarray, strain: np.ndarray, head: str = "") -> Path:
    rows = "".join(f"{g:.6f},{s:.9f}\n" for g, s in zip(strain, stress, strict=True))
    path.write_text(f"{head}shear strain,shear stress [MPa]\n{rows}")
    return path


@pytest.mark.parametrize("name", [one.name for one in laws().values() if one.isotropic and not one.compressible])
def test_the_stress_is_the_slope_of_the_energy_along_the_shear_strain(name: str) -> None:
    law = laws()[name]
    constants = {
        key: 0.1 if key.startswith("C") else next((v for k, v in TOY.items() if key.startswith(k)), 0.7)
        for key in law.names
    }
    material = bind(name, constants)
    strain, step = np.array([-0.4, 0.1, 0.5]), 1e-5

    def energy(strain: np.ndarray) -> np.ndarray:
        stretch = 0.5 * strain + np.sqrt(1.0 + 0.25 * strain**2)
        return np.asarray(material.membrane(stretch, np.ones_like(stretch)).W)

    slope = (energy(strain + step) - energy(strain - step)) / (2.0 * step)
    assert nominal_stress(material, "simple-shear", strain) == pytest.approx(slope, rel=1e-8)


def test_rubber_of_mooney_and_rivlin_shears_in_proportion() -> None:
    rubber = bind("mooney-rivlin-2", {"C10_MPa": 0.3, "C01_MPa": 0.1})
    assert nominal_stress(rubber, "simple-shear", STRAIN) == pytest.approx(0.8 * STRAIN, rel=1e-14)


def test_constants_are_found_from_shear_and_pull_together(hf: Run, tmp_path: Path) -> None:
    write(tmp_path / "s.csv", ogden(STRAIN), STRAIN)
    stretch = np.linspace(1.02, 1.5, 20)
    pull = nominal_stress(bind("ogden-1", OGDEN), "uniaxial", stretch)
    rows = "".join(f"{a:.6f},{b:.9f}\n" for a, b in zip(stretch, pull, strict=True))
    (tmp_path / "u.csv").write_text(f"# test: uniaxial\nstretch,stress [MPa]\n{rows}")
    done = hf("fit", "s.csv", "u.csv", "--model", "ogden-1", "-o", "m.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "m.json").read_text())
    assert found["parameters"] == pytest.approx(OGDEN, rel=1e-6)
    assert found["fit"]["tests"]["simple-shear"]["points"] == len(STRAIN)
    assert found["tested"]["simple-shear"]["stretch"] == pytest.approx([np.sqrt(1.09) - 0.3, 2.0])
    assert found["stability"]["shear"]["stable_over_data"]
    done = hf("fit", "s.csv", "u.csv", "--model", "ogden-1", "--fit-on", "simple-shear", cwd=tmp_path)
    assert json.loads(done.stdout)["fit"]["tests"]["uniaxial"]["relative_rms"] < 1e-5


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("# thickness: 2 mm\n# area: 400 mm2\n", "Displacement [mm],Force [N]"),
        ("# thickness: 2 mm\n# width: 20 mm\n# specimen length: 20 mm\n", "Displacement [mm],Force [N]"),
        ("", "Strain [%],Stress [MPa]"),
    ],
)
def test_displacement_and_force_of_a_sheared_layer(hf: Run, tmp_path: Path, head: str, columns: str) -> None:
    strain = np.linspace(0.0, 0.5, 12)
    per = (2.0, 400.0) if "mm" in columns else (100.0, 1.0)
    rows = "".join(f"{per[0] * g:.6f},{per[1] * 0.3 * g:.6f}\n" for g in strain)
    (tmp_path / "s.csv").write_text(f"# test: simple shear\n{head}{columns}\n{rows}")
    done = hf("fit", "s.csv", "--model", "neo-hookean", cwd=tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    assert json.loads(done.stdout)["parameters"]["C10_MPa"] == pytest.approx(0.15, rel=1e-5)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("# thickness: 2 mm\n# width: 20 mm\n", "needs the area that is sheared"),
        ("# area: 400 mm2\n", "needs the thickness of the sheared layer"),
    ],
)
def test_sizes_of_a_sheared_layer_are_asked_for(hf: Run, tmp_path: Path, head: str, said: str) -> None:
    (tmp_path / "s.csv").write_text(f"# test: simple shear\n{head}Displacement [mm],Force [N]\n0,0\n1,5\n2,9\n")
    done = hf("fit", "s.csv", "--model", "neo-hookean", cwd=tmp_path)
    assert done.returncode == 3
    assert said in done.stderr.decode()


def test_a_stress_that_no_shear_has_is_told_with_those_it_has(hf: Run, tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("# test: simple shear\nshear strain,true stress [MPa]\n0,0\n1,5\n2,9\n")
    done = hf("fit", "s.csv", "--model", "neo-hookean", cwd=tmp_path)
    assert done.returncode == 3
    assert 'name one "shear stress [MPa]" or "force [N]"' in done.stderr.decode()


def test_it_is_not_taken_for_planar_tension(hf: Run, tmp_path: Path) -> None:
    write(tmp_path / "s.csv", ogden(STRAIN), STRAIN)
    done = hf("fit", "--shear", "s.csv", "--model", "gent", cwd=tmp_path)
    assert done.returncode == 3
    assert "a shear strain is of simple shear, and of no planar shear test" in done.stderr.decode()


@pytest.mark.parametrize("model", ["blatz-ko", "orthotropic"])
def test_a_law_without_a_say_refuses_it(hf: Run, tmp_path: Path, model: str) -> None:
    write(tmp_path / "s.csv", ogden(STRAIN), STRAIN)
    done = hf("fit", "s.csv", "--model", model, cwd=tmp_path)
    assert done.returncode == 3
    assert "is a test in simple shear, which only isotropic laws that keep their volume" in done.stderr.decode()
    assert "or such a law: --model all" in done.stderr.decode()


def test_the_way_it_is_sheared_makes_no_difference(hf: Run, tmp_path: Path) -> None:
    strain = np.linspace(0.05, 1.0, 20)
    found = []
    for sign in (1.0, -1.0):
        write(tmp_path / "s.csv", sign * ogden(strain), sign * strain)
        done = hf("fit", "s.csv", "--model", "ogden-1", cwd=tmp_path)
        found.append(json.loads(done.stdout))
    one, other = found
    assert other["parameters"] == pytest.approx(one["parameters"], rel=1e-6)
    assert other["tested"] == one["tested"]
    assert one["tested"]["simple-shear"]["stretch"] == pytest.approx([1.0, 0.5 + np.sqrt(1.25)])
    assert any("is taken as positive" in line for line in other["preparation"])


def test_rows_behind_the_break_of_a_layer_are_left_out(hf: Run, tmp_path: Path) -> None:
    strain = np.linspace(0.05, 1.0, 20)
    write(tmp_path / "s.csv", np.append(ogden(strain), [0.002, 0.001]), np.append(strain, [1.01, 1.02]))
    done = hf("fit", "s.csv", "--model", "ogden-1", cwd=tmp_path)
    found = json.loads(done.stdout)
    assert found["left_out"] == {"behind the break of the specimen": 2}
    assert found["parameters"] == pytest.approx(OGDEN, rel=1e-4)


def test_of_ends_as_far_on_both_sides_the_first_is_where_slack_ends(hf: Run, tmp_path: Path) -> None:
    up = np.linspace(0.0, 0.8, 17)
    strain = np.concatenate([up, up[-2::-1], -up[1:]])
    write(tmp_path / "s.csv", ogden(strain), strain)
    done = hf("fit", "s.csv", "--model", "ogden-1", "--preload", "0.05MPa", cwd=tmp_path)
    assert json.loads(done.stdout)["left_out"]["slack, before the preload"] < 10


def test_a_preload_of_a_sheared_layer_is_no_force_over_its_width(hf: Run, tmp_path: Path) -> None:
    strain = np.linspace(0.0, 0.8, 17)
    write(tmp_path / "s.csv", ogden(strain), strain)
    done = hf("fit", "s.csv", "--width", "10mm", "--thickness", "1mm", "--preload", "0.5N", cwd=tmp_path)
    assert done.returncode == 2
    assert b"give it as a stress" in done.stderr


def test_the_loop_finds_what_shear_shows(hf: Run, tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    strain = np.linspace(0.02, 1.2, 40)
    for degrees in (23, 80):
        stress = ogden(strain) * np.exp(-0.004 * (degrees - 23)) * (1.0 + 0.003 * random.standard_normal(40))
        write(tmp_path / f"{degrees}.csv", stress, strain, f"# temperature: {degrees} C\n")
    (tmp_path / "m.json").write_text(
        json.dumps(
            {
                "format": "hyperfab.material/1",
                "model": "ogden-1",
                "parameters": OGDEN,
                "temperature_degC": 23.0,
            }
        )
    )
    done = hf("close-loop", "m.json", "23.csv", "80.csv", cwd=tmp_path)
    found = json.loads(done.stdout)
    assert [one["id"] for one in found["effects"]] == ["thermal-softening"]
    assert found["verdict"] == "effect"
    assert any("simple shear is taken as planar tension" in line for line in found["preparation"])
