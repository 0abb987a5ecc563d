"""How sure a press is: gaps to the first order against presses closed anew, and exact answers between plates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.stats import norm

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.press_contact import nearby, warmth
from hyperfab.chapters.rerun import Made, rerun
from hyperfab.io.json_io import dump_json
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import cup

FOAM = """format = "hyperfab.foam/1"
thickness = "4.5 mm +- 0.2 mm"
compression = { law = "linear", modulus = "0.05 MPa +- 10 %" }
expansion = { male = "23.6e-6 1/K +- 5 %" }
"""


def pressed(molds: str, *words: str, foam: str = FOAM, target: str = "-") -> Made:
    """Return what a press of these molds would write."""
    files = ["--male", f"{molds}-male.stl", "--female", f"{molds}-female.stl", "--foam", "foam.toml"]
    case = read(case_class("press-contact"), [*files, "--strokes", "2", *words])
    return rerun(case, target, {"foam.toml": foam.encode()})


def sds(made: Made) -> dict[str, float]:
    """Return the standard deviation of each figure."""
    return {name: band["sd"] for name, band in made.document["uncertainty"]["quantities"].items()}


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Cups, and two plates that lie 0 mm apart as drawn."""
    found: Path = tmp_path_factory.mktemp("press")
    for name, solid in (("cup-male", cup.male_cup(16, 17)), ("cup-female", cup.female_cup(17, 16))):
        (found / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    for name, middle in (("plate-male", -10.0), ("plate-female", 10.0)):
        box = trimesh.creation.box(extents=(100.0, 80.0, 20.0)).apply_translation([0.0, 0.0, middle])
        (found / f"{name}.stl").write_bytes(stl_bytes(box.vertices, box.faces))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(found)
        yield found


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        pytest.param(("--gap", "3mm +- 0.1mm", "--temperature", "200 degC +- 5 K"), marks=pytest.mark.slow),
        pytest.param(("--force", "60N +- 3N", "--float"), marks=pytest.mark.slow),
        ("--gap", "3mm", "--tilt", "0.1deg +- 0.03deg,0deg", "--frame-stiffness", "500N/mm +- 10 %"),
    ],
)
def test_gaps_to_the_first_order_give_what_presses_closed_anew_do(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    near = sds(pressed("cup", *words, "--uncertainty", "linear"))
    monkeypatch.setattr(nearby, "beside", lambda *given: None)
    anew = sds(pressed("cup", *words, "--uncertainty", "linear"))
    assert set(near) == set(anew)
    for name, sd in anew.items():
        # Of a mesh as coarse as this one; a standard deviation is told by two digits at most.
        assert near[name] == pytest.approx(sd, rel=0.03), name


#: A foam that softens where it is hot, read at each place's own temperature.
SOFTENING = """format = "hyperfab.foam/1"
thickness = "3.5 mm +- 0.1 mm"
compression = [
  { law = "linear", modulus = "0.05 MPa", temperature = "23 degC" },
  { law = "linear", modulus = "0.03 MPa", temperature = "200 degC" },
]
fabric = { above = "0.5 mm", below = "0.5 mm" }
conductivity = "0.04 W/m/K +- 10 %"
specific_heat = "1400 J/kg/K"
density = "30 kg/m^3"
"""


@pytest.mark.slow
@pytest.mark.parametrize("words", [("--gap", "3mm +- 0.05mm"), ("--force", "60N +- 2N")])
def test_foam_as_soft_as_each_place_is_hot_goes_with_its_temperature_to_the_first_order(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = (*words, "--temperature", "200 degC +- 3 K", "--dwell", "5s", "--uncertainty", "linear")
    near = sds(pressed("cup", *words, foam=SOFTENING))
    monkeypatch.setattr(nearby, "beside", lambda *given: None)
    anew = sds(pressed("cup", *words, foam=SOFTENING))
    assert set(near) == set(anew)
    for name, sd in anew.items():
        assert near[name] == pytest.approx(sd, rel=0.02), name


#: A plate heated from one end, so that a field of temperature is handed on.
HEATED = """format = "hyperfab.mold/1"
[material.aluminium]
density = "2702 kg/m^3"
conductivity = "20 W/m/K"
specific_heat = "903 J/kg/K"
[[part]]
name = "plate"
material = "aluminium"
box = { origin = ["-50 mm", "-40 mm", "LOW mm"], size = ["100 mm", "80 mm", "20 mm"] }
[[heater]]
on = "plate.x-"
power = "80 W +- 5 %"
[[convection]]
on = "exposed"
h = "12 W/m^2/K +- 5 %"
ambient = "25 degC"
[run]
start = "25 degC"
until = "900 s"
mesh_size = "40 mm"
"""


@pytest.mark.parametrize("dwell", [(), pytest.param(("--dwell", "20s"), marks=pytest.mark.slow)])
def test_foam_between_molds_of_heat_documents_goes_with_what_these_hand_on(
    dwell: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, low in (("plate-male", "-20"), ("plate-female", "0")):
        Path(f"{name}.toml").write_text(HEATED.replace("LOW", low))
        made = rerun(read(case_class("mold-heat"), [f"{name}.toml"]), f"{name}.heat.json")
        Path(f"{name}.heat.json").write_bytes(dump_json(made.document))
        for suffix, data in made.siblings.items():
            Path(f"{name}.heat{suffix}").write_bytes(data)
    heat = ("--male-heat", "plate-male.heat.json", "--female-heat", "plate-female.heat.json")
    words = ("--gap", "3mm", *heat, *dwell, "--uncertainty", "linear")
    closed: list[Any] = []
    close = warmth.close_press
    monkeypatch.setattr(warmth, "close_press", lambda case: (closed.append(case), close(case))[1])
    near = sds(pressed("plate", *words, foam=SOFTENING))
    assert len(closed) == 1
    monkeypatch.setattr(nearby, "beside", lambda *given: None)
    anew = sds(pressed("plate", *words, foam=SOFTENING))
    assert set(near) == set(anew)
    # Both plates end at one edge: whether its rim counts as touched jumps as one outgrows the other.
    for name in set(anew) - {"contact_fraction", "contact_area_mm2"}:
        assert near[name] == pytest.approx(anew[name], rel=0.005), name


def test_no_press_is_closed_again_for_its_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[Any] = []
    close = warmth.close_press
    monkeypatch.setattr(warmth, "close_press", lambda case: (closed.append(case), close(case))[1])
    made = pressed("cup", "--gap", "3mm +- 0.1mm", "--uncertainty", "sampled")
    assert len(closed) == 1
    assert made.document["uncertainty"]["samples"] == 1000


@pytest.mark.parametrize("way", ["linear", "sampled"])
def test_between_plates_the_probability_of_touching_and_the_fields_are_exact(way: str) -> None:
    gap, foam, modulus = 4.3, 4.5, 0.05
    made = pressed("plate", "--gap", f"{gap}mm +- 0.1mm", "--uncertainty", way, target="press.json")
    grid = read_vtu(made.siblings[".vtu"], "press.vtu")
    touches = norm.cdf((foam - gap) / np.hypot(0.2, 0.1))
    found = grid.point_data["touch_probability"]
    assert found == pytest.approx(np.full(len(found), touches), abs=0.01)
    assert grid.point_data["gap_mm_sd"] == pytest.approx(np.full(len(found), 0.1), rel=0.05)
    if way == "linear":
        # p = E (1 - gap / foam): by its three inputs.
        by = [modulus / foam * 0.1, modulus * gap / foam**2 * 0.2, 0.1 * modulus * (1.0 - gap / foam)]
        of_gap_and_foam = np.hypot(0.1 / foam, gap / foam**2 * 0.2)
        assert grid.point_data["compression_sd"][0] == pytest.approx(of_gap_and_foam, rel=0.03)
        # The foam's own sd takes it through the touch: within it the pressure bends.
        assert grid.point_data["pressure_MPa_sd"][0] == pytest.approx(np.linalg.norm(by), rel=0.03)


def test_a_pressure_that_bends_is_sampled_without_being_asked() -> None:
    """The foam is touched by 0.2 mm, give or take 0.22: half of what it may be is no pressure at all."""
    made = pressed("plate", "--gap", "4.3mm +- 0.3mm")
    sure = made.document["uncertainty"]
    assert sure["method"] == "sampled"
    assert "bend within their interval" in sure["reason"]
    band = sure["quantities"]["force_N"]
    assert band["low"] == pytest.approx(0.0, abs=1e-9)
    # The mean square of what is left of a normal number above 0 (truncated normal), times stiffness and area.
    mean, sd = 0.2, np.hypot(0.2, 0.3)
    above, at = norm.cdf(mean / sd), norm.pdf(mean / sd)
    first, second = mean * above + sd * at, (mean**2 + sd**2) * above + mean * sd * at
    exact = 0.05 / 4.5 * 8000.0 * np.sqrt(second - first**2)
    assert band["sd"] == pytest.approx(exact, rel=0.05)


def test_where_nothing_is_stated_fields_have_no_twin() -> None:
    foam = FOAM.replace(" +- 0.2 mm", "").replace(" +- 10 %", "").replace(" +- 5 %", "")
    made = pressed("cup", "--gap", "3mm", foam=foam, target="press.json")
    grid = read_vtu(made.siblings[".vtu"], "press.vtu")
    assert not [name for name in grid.point_data if name.endswith("_sd") or name == "touch_probability"]


def test_a_press_goes_with_the_specimens_of_its_foam(folder: Path) -> None:
    """A foam that is stiffer by a share presses harder by that share, and between plates by nothing else."""
    sure = {"order": ["mu1_MPa", "alpha1", "nu1"], "specimens": 4, "degrees_of_freedom": 3, "source": "specimens",
            "covariance": np.diag([(0.05 * 0.02) ** 2, 0.0, 0.0]).tolist()}  # fmt: skip
    fit = {"E2": 0.0, "relative_rms": 0.0, "nrmse": 0.0, "points": 9, "uncertainty": sure}
    constants = {"mu1_MPa": 0.02, "alpha1": 6.0, "nu1": 0.1}
    document = {"format": "hyperfab.material/1", "model": "hyperfoam-1", "parameters": constants, "fit": fit}
    (folder / "foam.json").write_bytes(dump_json(document))
    foam = 'format = "hyperfab.foam/1"\nthickness = "4.5 mm"\ncompression = { material = "foam.json" }\n'
    made = pressed("plate", "--gap", "4mm", "--uncertainty", "linear", foam=foam)
    band = made.document["uncertainty"]["quantities"]["force_N"]
    assert band["sd"] == pytest.approx(0.05 * made.document["force_N"], rel=1e-6)
    assert band["budget"] == [{"source": "foam.json: constants, 4 specimens", "share": pytest.approx(1.0)}]
