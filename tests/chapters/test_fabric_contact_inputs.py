"""`hf fabric-contact`: punches, outlines, and what material documents tell beside a law."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import Run

from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.options import read
from hyperfab.chapters.fabric_contact.outline import read_outline
from hyperfab.chapters.job import Job
from hyperfab.chapters.sheet import read_fabric
from hyperfab.console import Console
from hyperfab.errors import InputError, UsageError

LAW = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}
STRAIN = np.array([[1.96, 1.21, 0.1], [2.25, 0.4, 0.0], [1.1, 1.3, 0.2]])
SOFTENING = {
    "id": "thermal-softening", "form": "exponential", "parameters": {"softening_1_K": 0.01},
    "reference_degC": 20.0, "told_by": "temperatures",
}  # fmt: skip


@pytest.fixture
def job():
    return Job("fabric-contact", [], Console(True))


@pytest.fixture
def made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fabric.json").write_text(json.dumps(LAW))
    return tmp_path


def _fabric(job, folder, temperature=None, **more):
    (folder / "cloth.json").write_text(json.dumps({**LAW, **more}))
    return read_fabric(job, "cloth.json", temperature)


def _export(points, faces, name):
    trimesh.Trimesh(np.asarray(points, float), faces, process=False).export(name)


def test_constants_of_no_fabric_are_refused_with_their_place(job, made):
    with pytest.raises(InputError) as refused:
        _fabric(job, made, parameters={"C10_MPa": 1e200})
    assert refused.value.key == "parameters.C10_MPa"
    hot = [{"temperature_degC": 80.0, "parameters": {"C10_MPa": -1e200}}]
    with pytest.raises(InputError) as refused:
        _fabric(job, made, directions={"weft": {"parameters": {"C10_MPa": 0.1}, "temperatures": hot}})
    assert refused.value.key == "directions.weft.temperatures.0.parameters.C10_MPa"


@pytest.mark.parametrize(("option", "told"), [("--thickness 1e300mm", "1000mm"), ("--mass 1e300g/m^2", "1e+06g/m^2")])
def test_sizes_of_no_fabric_are_refused(option, told):
    with pytest.raises(UsageError, match=re.escape(told)):
        read(DrapeCase, ["fabric.json", "--mold", "cup.stl", *option.split()])


# ---- outlines --------------------------------------------------------------------------------------------------


def test_one_outline_from_stl_mesh_and_table(made, job):
    points = [[0, 0, 5], [8, 0, 5], [8, 6, 5], [0, 6, 5], [4, 3, 5]]
    faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    _export(points, faces, "a.stl")
    _export(points, faces, "a.obj")
    (made / "a.csv").write_text("x [cm],y [cm]\n0,0\n4,0\n8,0\n8,6\n0,6\n0,0\n")
    expected = np.array([[-40.0, -30], [40, -30], [40, 30], [-40, 30]])
    for name in ("a.stl", "a.obj", "a.csv"):
        found = read_outline(job, name, "cm", None)
        assert found.area == pytest.approx(4800.0)
        assert sorted(found.vertices.round(9).tolist()) == sorted(expected.tolist())
        assert read_outline(job, name, "cm", 160.0).area == pytest.approx(4 * 4800.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x [mm],y [mm]\n0,0\n10,10\n10,0\n0,10\n", "crosses itself"),
        ("x [mm],y [mm]\n0,0\n10,10\n", "no area"),
        ("x [mm],y [mm]\n0,0\n30,0\n30,3\n3,3\n3,30\n0,30\n", "middle of its box"),
        ("x [mm],z [mm]\n0,0\n10,10\n10,0\n", "y"),
    ],
)
def test_tables_that_are_no_outline_are_refused(made, job, text, said):
    (made / "a.csv").write_text(text)
    with pytest.raises(InputError, match=said):
        read_outline(job, "a.csv", "mm", None)


def test_surfaces_that_are_no_outline_are_refused(made, job):
    trimesh.creation.box((10, 10, 10)).export("box.stl")
    with pytest.raises(InputError, match="not flat"):
        read_outline(job, "box.stl", "mm", None)
    ring = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0], [-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]
    faces = [f for i in range(4) for j in [(i + 1) % 4] for f in ([i, j, j + 4], [i, j + 4, i + 4])]
    _export(ring, faces, "ring.stl")
    with pytest.raises(InputError, match="more than one closed edge"):
        read_outline(job, "ring.stl", "mm", None)
    (made / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nl 2 3\n")
    with pytest.raises(InputError, match=r"open|neither|read"):
        read_outline(job, "open.obj", "mm", None)
    (made / "bad.vtu").write_text("nothing")
    with pytest.raises(InputError, match="vtu"):
        read_outline(job, "bad.vtu", "mm", None)
    (made / "sheet.docx").write_text("nothing")
    with pytest.raises(UsageError, match="STL"):
        read_outline(job, "sheet.docx", "mm", None)


# ---- punches ---------------------------------------------------------------------------------------------------


def _ball(radius=30.0):
    return trimesh.creation.icosphere(subdivisions=3, radius=radius)


@pytest.mark.slow
def test_a_ball_from_stl_is_pressed_and_told(hf, made):
    _ball().export("ball.stl")
    done = hf(
        "fabric-contact", "fabric.json", "--punch", "ball.stl", "--size", "120mm", "--depth", "25mm", "--steps", "1",
        "--tolerance", "1e-2", "-o", "out.json", cwd=made,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((made / "out.json").read_text())
    same = hf(
        "fabric-contact", "fabric.json", "--sphere-radius", "30mm", "--size", "120mm", "--depth", "25mm", "--steps",
        "1", "-o", "-", cwd=made,
    )  # fmt: skip
    assert found["force_N"] == pytest.approx(json.loads(same.stdout)["force_N"], rel=0.02)
    assert found["setup"]["punch"] == "ball.stl"
    assert found["setup"]["punch_facets"] == 1280
    assert "sphere_radius_mm" not in found["setup"]
    assert found["files"] == ["out.csv", "out.png", "out.vtu"]


def _punched(hf, folder, *words):
    done = hf("fabric-contact", "fabric.json", "--punch", "p.stl", *words, "-o", "out.json", cwd=folder)
    assert not (folder / "out.json").exists()
    return done.returncode, done.stderr.decode()


def test_punches_that_cannot_be_meant_are_refused(hf, made):
    ball = _ball(60.0)
    ball.export("p.stl")
    status, said = _punched(hf, made, "--size", "110mm", "--depth", "50mm")
    assert status == 3
    assert "strike the clamp at" in said
    ball.update_faces(ball.triangles_center[:, 2] < ball.triangles_center[:, 2].max() - 1e-9)
    ball.export("p.stl")
    status, said = _punched(hf, made)
    assert status == 3
    assert "open edge" in said
    assert "p.stl" in said


def test_a_punch_in_inches_that_passes_for_a_needle_is_asked_about(hf, made):
    """It was pressed into the sheet as a ball of 4.7 mm, for many minutes, without a word."""
    _ball(60.0 / 25.4).export("p.stl")
    words = ("--size", "200mm", "--depth", "3mm", "--mesh-size", "90mm")  # too coarse a mesh: ended before it runs
    _, said = _punched(hf, made, *words)
    assert "p.stl: measures 4.72 x 4.72 x 4.72 mm when read in mm, the sheet 200 mm" in said
    assert "measures" not in _punched(hf, made, *words, "--stl-unit", "inch")[1]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--element", "P3"], "P1"),
        (["--rim-slip", "-1 mm^2/N"], "--rim-slip"),
        (["--punch", "p.stl", "--sphere-radius", "30mm"], "--sphere-radius"),
        (["--edge-radius", "3mm"], "--edge-radius is for the edges of a --punch"),
        (["--punch", "ball.stl", "--edge-radius", "25mm", "--depth", "5mm"], "--edge-radius 25mm: between"),
        (["--shape", "gone.csv"], "gone.csv"),
    ],
)
def test_new_options_say_what_is_wrong(hf, made, words, said):
    _ball(60.0).export("ball.stl")
    done = hf("fabric-contact", "fabric.json", *words, "-o", "out.json", cwd=made)
    assert done.returncode == (3 if "gone.csv" in words else 2)
    assert said in done.stderr.decode()


# ---- materials -------------------------------------------------------------------------------------------------


def test_softening_with_temperature_scales_the_law(made, job):
    plain = _fabric(job, made).law(STRAIN)
    soft = _fabric(job, made, 80.0, effects=[SOFTENING])
    np.testing.assert_allclose(soft.law(STRAIN).stress, np.exp(-0.6) * plain.stress, rtol=1e-12)
    assert soft.temperature == 80.0
    assert soft.obeyed == ["thermal-softening"]


def test_effects_at_their_null_value_leave_every_bit(made, job):
    plain = _fabric(job, made).law(STRAIN)
    richer = {"id": "elastic-law", "form": "exponential", "parameters": {"D_MPa": 0.0, "b": 1.0}}
    same = _fabric(job, made, 20.0, effects=[SOFTENING, richer])
    assert same.law(STRAIN).stress.tobytes() == plain.stress.tobytes()
    assert same.law(STRAIN).energy.tobytes() == plain.energy.tobytes()
    assert same.left_out == []


def test_terms_that_the_loop_added_are_obeyed(made, job):
    richer = {"id": "elastic-law", "form": "powers", "parameters": {"C20_MPa": 0.01, "C30_MPa": 0.002}}
    found = _fabric(job, made, effects=[richer]).law(STRAIN)
    own = {"C10_MPa": 0.2, "C20_MPa": 0.01, "C30_MPa": 0.002}
    same = _fabric(job, made, model="yeoh-3", parameters=own).law(STRAIN)
    np.testing.assert_allclose(found.stress, same.stress, rtol=1e-12, atol=1e-15)


def test_constants_at_temperatures_are_interpolated(made, job):
    table = [{"temperature_degC": t, "parameters": {"C10_MPa": c}} for t, c in ((20.0, 0.2), (80.0, 0.1))]
    warm = _fabric(job, made, 50.0, temperatures=table).law(STRAIN)
    same = _fabric(job, made, parameters={"C10_MPa": 0.15}).law(STRAIN)
    np.testing.assert_allclose(warm.stress, same.stress, rtol=1e-12)


def test_constants_of_one_temperature_or_none_hold_as_they_stand(made, job):
    own = _fabric(job, made).law(STRAIN)
    for known in ({}, {"temperature_degC": 23.0}):
        np.testing.assert_array_equal(_fabric(job, made, 50.0, **known).law(STRAIN).stress, own.stress)


def test_effects_that_a_sheet_cannot_obey_are_left_out_with_the_reason(made, job):
    effects = [
        {"id": "rate", "form": "log-rate", "parameters": {"amount": 0.05}},
        {"id": "mullins", "form": "pseudo-elastic", "parameters": {"amount": 0.4, "energy_MPa": 0.1}},
        {"id": "grip-slack", "form": "play", "parameters": {"slack": 0.02}},
    ]
    found = _fabric(job, made, effects=effects)
    assert [words.split(":")[0] for words in found.left_out] == ["rate"]
    assert [words.split()[0] for words in found.obeyed] == ["mullins", "grip-slack"]


def test_a_law_of_fibres_pulls_along_each_direction_as_in_its_tests(made, job):
    constants = {
        "C10_MPa": 0.034, "k1_along_MPa": 0.03, "k1_across_MPa": 0.014, "k2_along": 0.16, "k2_across": 0.19
    }  # fmt: skip
    turned = {
        "C10_MPa": 0.034, "k1_along_MPa": 0.014, "k1_across_MPa": 0.03, "k2_along": 0.19, "k2_across": 0.16
    }  # fmt: skip
    one = _fabric(job, made, model="fabric-fibres", parameters=constants)
    ways = {"warp": {"parameters": constants}, "weft": {"parameters": turned}}
    two = _fabric(job, made, model="fabric-fibres", parameters=constants, directions=ways)
    assert one.law(STRAIN).stress.tobytes() == two.law(STRAIN).stress.tobytes()
    from hyperfab.materials import bind

    law = bind("fabric-fibres", constants, anisotropic=True)
    for stretch in (1.1, 1.5):
        for axis, own in ((0, law), (1, law.turned())):
            strain = np.full((1, 3), 0.0)
            strain[0, axis], strain[0, 1 - axis] = stretch**2, 1.0 / stretch
            stress = one.law(strain).stress[0]
            assert stress[axis] * stretch == pytest.approx(float(own.uniaxial(stretch).P), rel=1e-12)
    both = law.membrane(1.4, 1.2)
    stress = one.law(np.array([[1.96, 1.44, 0.0]])).stress[0]
    np.testing.assert_allclose(stress[:2], [float(both.P1) / 1.4, float(both.P2) / 1.2], rtol=1e-12)


def test_straight_elements_meet_the_tolerance_they_state(hf, made):
    done = hf(
        "fabric-contact", "fabric.json", "--element", "P1", "--steps", "1", "--tolerance", "5e-4", "-o", "out.json",
        cwd=made,
    )  # fmt: skip
    found = json.loads((made / "out.json").read_text())
    assert done.returncode == 0
    assert found["setup"]["elements"].startswith("P1")
    assert found["force_N"] == pytest.approx(41.576556565, rel=5e-4)


@pytest.mark.parametrize("command", ["net", "membrane", "contact", "against"])
def test_an_effect_that_a_sheet_does_not_obey_is_said_by_every_command(
    hf: Run, tmp_path: Path, root: Path, command: str
) -> None:
    """On standard error and in the document, also of the fabric that another is compared with."""
    plain = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.1}, "thickness_mm": 1}
    effects = [{"id": "rate", "form": "prony-1", "parameters": {"g1": 0.5, "tau1_s": 10.0}}]
    (tmp_path / "plain.json").write_text(json.dumps(plain))
    (tmp_path / "fabric.json").write_text(json.dumps({**plain, "effects": effects}))
    pressed = ("--depth", "10mm", "--steps", "1", "--mesh-size", "30mm")
    cup = root / "molds" / "cup-male.stl"
    draped = ("drape", "fabric.json", "--mold", cup, "--grid", "11x11", "--size", "260mmx260mm", "--depth", "20mm")
    words = {
        "net": draped,
        "membrane": (*draped, "--sheet", "membrane"),
        "contact": ("fabric-contact", "fabric.json", *pressed),
        "against": ("fabric-contact", "plain.json", "--against", "fabric.json", *pressed),
    }[command]
    done = hf(*words, "-o", "-", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert b"fabric.json: the " in done.stderr
    assert b" not act on rate" in done.stderr
    told = [one for one in json.loads(done.stdout)["left_out"] if "rate: the sheet is pressed slowly" in one]
    assert len(told) == 1
    assert told[0].startswith("fabric.json") == (command == "against")
