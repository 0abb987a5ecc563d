"""Molds as they come to ``hf drape``: on their side, in another unit, another format, open."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cloth_molds import height_block, punch

from hyperfab.cli import main
from hyperfab.io.stl_write import stl_bytes

FABRIC = {
    "format": "hyperfab.material/1",
    "model": "neo-hookean",
    "parameters": {"C10_MPa": 0.2},
    "thickness_mm": 0.8,
}


@pytest.fixture
def drape(tmp_path: Path, monkeypatch, capfd) -> Callable[..., tuple[int, str, str]]:
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    monkeypatch.chdir(tmp_path)

    def run(mold, *arguments: str) -> tuple[int, str, str]:
        if isinstance(mold, tuple):
            Path("mold.stl").write_bytes(stl_bytes(*mold))
        words = ["hf", "drape", "fabric.json", "--mold", "mold.stl"]
        for name, value in (("--grid", "31x31"), ("--size", "200mm"), ("--depth", "40mm")):
            if name not in arguments:
                words += [name, value]
        monkeypatch.setattr("sys.argv", [*words, *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capfd.readouterr()
        return int(end.value.code or 0), out, err

    return run


def cup() -> tuple[np.ndarray, np.ndarray]:
    """A cup of 120 by 100 mm, 50 high, its flat base at z = 0, no two sides alike."""
    block = height_block(
        lambda u, v: 2.0 + 48.0 * np.maximum(1.0 - (u / 60.0) ** 2 - ((v + 0.1 * u) / 50.0) ** 2, 0.0) ** 0.75,
        (60.0, 50.0),
        (60, 50),
        0.0,
    )
    return block.vertices, block.faces


@pytest.mark.parametrize(("axis", "order"), [("x", [2, 0, 1]), ("y", [1, 2, 0])])
def test_a_mold_that_lies_on_its_side_is_asked_about_and_axis_turns_it_up(drape, axis, order):
    vertices, faces = cup()
    status, out, err = drape((vertices, faces))
    upright = json.loads(out)
    assert status == 0
    assert "on its side" not in err
    lying = vertices[:, order]  # its apex now points along the axis
    assert np.ptp(lying, axis=0)["xyz".index(axis)] == pytest.approx(50.0)
    _, _, err = drape((lying, faces))
    assert "on its side" in err
    assert f"--axis {axis} turns it up" in err
    status, out, err = drape((lying, faces), "--axis", axis)
    turned = json.loads(out)
    assert status == 0
    assert "on its side" not in err
    assert turned["mold"]["axis"] == axis
    assert turned["setup"]["axis"] == axis
    for key in ("energy_J", "force_N", "stretch_max", "contact_nodes"):
        assert turned[key] == pytest.approx(upright[key], rel=1e-9), key


def test_a_mold_in_another_unit_stops_at_the_question(drape):
    vertices, faces = cup()
    status, out, err = drape((0.001 * vertices, faces))
    assert status == 3
    assert out == ""
    assert "0.12 x 0.1 x 0.05 mm" in err
    assert "--stl-unit m" in err
    status, out, _ = drape((0.001 * vertices, faces), "--stl-unit", "m")
    assert status == 0
    assert json.loads(out)["force_N"] == pytest.approx(json.loads(drape((vertices, faces))[1])["force_N"], rel=1e-6)


def test_a_mold_in_inches_that_passes_for_a_small_one_is_asked_about(drape):
    """5 mm wide under a sheet of 160: it was draped without a word."""
    vertices, faces = cup()
    _, _, err = drape((vertices / 25.4, faces))
    [said] = [line for line in err.splitlines() if "measures" in line]
    assert "measures 4.72 x 3.94 x 1.97 mm when read in mm, the sheet" in said
    assert "--stl-unit" in said
    assert "measures" not in drape((vertices / 25.4, faces), "--stl-unit", "inch")[2]


def test_a_tiny_mold_that_is_meant_is_draped_by_a_sheet_that_fits_it(drape):
    """At the same thickness the force of a net goes with the length. It was told to state the unit that it stated."""
    vertices, faces = cup()
    small = ("--size", "1.6mmx1.4mm", "--depth", "0.3mm", "--thickness", "1mm", "--stl-unit", "mm")
    status, out, err = drape((0.005 * vertices, faces), *small)
    assert status == 0, err
    assert "measures 0.6 x 0.5 x 0.25 mm when read in mm" in err
    large = ("--size", "320mmx280mm", "--depth", "60mm", "--thickness", "1mm")
    whole = json.loads(drape((vertices, faces), *large)[1])
    assert json.loads(out)["force_N"] == pytest.approx(0.005 * whole["force_N"], rel=1e-5)
    status, _, err = drape((0.005 * vertices, faces), "--stl-unit", "mm")
    assert status == 3
    assert "give a sheet that fits it: --size" in err


@pytest.mark.parametrize(
    ("text", "is_a"),
    [
        (
            b"# made by a program\nmtllib a.mtl\no cup\nv 1.0 2.0 3.0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n" + b"#" * 100,
            "OBJ",
        ),
        (b"ply\nformat ascii 1.0\nelement vertex 3\n" + b" " * 100, "PLY"),
        (b"ISO-10303-21;\nHEADER;\n" + b" " * 100, "STEP"),
    ],
)
def test_another_format_is_named(drape, text, is_a):
    Path("mold.stl").write_bytes(text)
    status, _, err = drape(None)
    assert status == 3
    assert f"is {is_a}" in err
    assert "STL" in err


def test_the_border_of_a_patch_is_told_from_a_hole(drape):
    vertices, faces = cup()
    top = faces[(vertices[faces][..., 2] > 1.0).all(1)]
    status, _, err = drape((vertices, top), "--depth", "49mm")
    assert status == 3
    assert "extrude the border down" in err


def rounded_text(vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return an ASCII STL whose corners were computed anew for each facet, and written with six digits."""
    corners = vertices[faces] + np.random.default_rng(1).uniform(-2e-5, 2e-5, (len(faces), 3, 3))
    lines = ["solid cup"]
    for three in corners:
        vertex = [f"vertex {x:.6g} {y:.6g} {z:.6g}" for x, y, z in three]
        lines += ["facet normal 0 0 0", "outer loop", *vertex, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid cup", ""])


def test_corners_that_differ_by_rounding_are_no_holes(drape):
    whole = json.loads(drape(cup())[1])
    Path("mold.stl").write_text(rounded_text(*cup()))
    status, out, err = drape("mold.stl")
    assert status == 0, err
    assert "mold.stl: corners that differ by rounding, closer than " in err
    assert json.loads(out)["force_N"] == pytest.approx(whole["force_N"], rel=1e-3)
    vertices, faces = cup()
    torn = rounded_text(vertices, np.delete(faces, np.argmax(vertices[faces, 2].mean(axis=1)), axis=0))
    Path("mold.stl").write_text(torn)
    status, _, err = drape("mold.stl")
    assert status == 3
    assert "an open edge (a hole)" in err


def test_a_mold_off_the_middle_is_the_one_of_a_larger_box(drape) -> None:
    """A plate below the sheet, which nothing touches, moves the middle of the box of both, and nothing else."""
    vertices, faces = cup()
    plate = height_block(lambda u, v: 4.0 + 0.0 * u, (68.0, 55.0), (4, 4), 0.0)
    Path("plate.stl").write_bytes(stl_bytes(plate.vertices + np.array([8.0, -5.0, 0.0]), plate.faces))
    _, out, _ = drape((vertices, faces), "--mold", "plate.stl")
    boxed = json.loads(out)
    _, out, _ = drape((vertices, faces), "--offset", "-8mmx5mm")
    off = json.loads(out)
    _, out, _ = drape((vertices, faces))
    middle = json.loads(out)
    assert off["setup"]["offset_mm"] == [-8.0, 5.0]
    shift = np.array([one["mold"]["shift_mm"] for one in (middle, off)])
    assert shift[1] - shift[0] == pytest.approx([-8.0, 5.0, 0.0], abs=1e-9)
    for key in ("force_N", "energy_J", "stretch_max", "stress_weft_max_MPa"):
        assert off[key] == pytest.approx(boxed[key], rel=1e-6), key
        assert off[key] != pytest.approx(middle[key], rel=1e-4), key


def test_a_depth_beyond_the_molds_height_is_noted(drape):
    _, _, err = drape(cup(), "--depth", "55mm")
    assert "5 mm above the sheet's plane" in err
    assert "above the sheet" not in drape(cup(), "--depth", "50mm")[2]


def test_one_of_two_bosses_that_faces_inward_is_turned(drape):
    """All of a mold that faces inward is turned, and so is one of its pieces: the answer is that of the sound file."""
    block = height_block(lambda u, v: 10.0 + 30.0 * np.exp(-(u**2 + v**2) / 300.0), (25.0, 30.0), (20, 20), 0.0)
    vertices = np.vstack([block.vertices + np.array(away) for away in ([-35.0, 0.0, 0.0], [35.0, 5.0, 0.0])])
    beside = block.faces + len(block.vertices)
    status, out, err = drape((vertices, np.vstack([block.faces, beside])))
    assert status == 0
    assert "turned" not in err
    sound = json.loads(out)
    for faces in (np.vstack([block.faces, beside[:, ::-1]]), np.vstack([block.faces[:, ::-1], beside])):
        status, out, err = drape((vertices, faces))
        assert status == 0, err
        assert f"{len(beside)} facets of whole pieces faced inward and were turned" in err
        assert json.loads(out)["force_N"] == pytest.approx(sound["force_N"], rel=1e-9)


def test_friction_over_sharp_edges_is_told_as_none(drape) -> None:
    """The flat end of a cylinder bears on its rim, between nodes: as on a pulley that nothing rubs on."""
    options = ("--friction", "0.3", "--depth", "10mm", "--grid", "21x21", "--load-steps", "2")
    sharp = punch(32)
    status, _, told = drape((sharp.vertices, sharp.faces), *options)
    assert (status, "100 % of the force goes over sharp edges" in told) == (0, True)
    status, _, told = drape(cup(), *options)
    assert (status, "sharp edges" in told) == (0, False)
