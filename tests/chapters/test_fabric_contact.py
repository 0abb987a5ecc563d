"""`hf fabric-contact`: the document, its siblings, its refusals and its exit status."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree

import jsonschema
import pytest

NEO_HOOKEAN = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}
STIFFER = {**NEO_HOOKEAN, "parameters": {"C10_MPa": 0.25}}
#: Uniaxial constants of Treloar's rubber: stable to 57.46 mm, no equilibrium beyond 60.35 mm.
SOFTENING = {
    **NEO_HOOKEAN,
    "model": "mooney-rivlin-2",
    "parameters": {"C10_MPa": 0.2158118922, "C01_MPa": -0.0630439338},
}
TWO_WAYS = {
    **NEO_HOOKEAN,
    "thickness_mm": 0.5,
    "directions": {
        "warp": {"parameters": {"C10_MPa": 0.3}},
        "weft": {"parameters": {"C10_MPa": 0.2}},
    },
}


@pytest.fixture
def press(hf, tmp_path):
    """Run the command on material documents in an empty folder; returns exit status, document, standard error."""

    def run(document, *options, against=None, output="contact.json"):
        (tmp_path / "fabric.json").write_text(json.dumps(document))
        words = ["fabric-contact", "fabric.json", *options]
        if against is not None:
            (tmp_path / "other.json").write_text(json.dumps(against))
            words += ["--against", "other.json"]
        done = hf(*words, "-o", output, cwd=tmp_path)
        path = tmp_path / output
        found = json.loads(path.read_text()) if path.exists() else None
        return done.returncode, found, done.stderr.decode()

    return run


@pytest.mark.slow
def test_half_the_thickness_on_the_sphere_is_offered_and_its_size_told(press):
    """A sheet of 2 mm over 40 mm: its middle surface is that of a thin sheet over 41 mm."""
    common = ("--thickness", "2mm", "--depth", "30mm", "--mesh-size", "15mm", "--steps", "2")
    _, thin, _ = press(NEO_HOOKEAN, *common, "--sphere-radius", "40mm")
    _, middle, _ = press(NEO_HOOKEAN, *common, "--sphere-radius", "40mm", "--middle-surface")
    _, larger, _ = press(NEO_HOOKEAN, *common, "--sphere-radius", "41mm")
    assert any("1 mm, 2.5 % of its radius" in text for text in thin["left_out"])
    assert not any("half the sheet's thickness" in text for text in middle["left_out"])
    assert middle["force_N"] == pytest.approx(larger["force_N"], rel=1e-9)
    assert middle["force_N"] > 1.005 * thin["force_N"]
    assert middle["setup"]["sphere_radius_mm"] == 40.0
    assert middle["setup"]["middle_surface"] is True
    status, _, err = press(NEO_HOOKEAN, "--punch", "p.stl", "--middle-surface", output="punch.json")
    assert status == 2
    assert "--middle-surface" in err


@pytest.mark.pictures
def test_document_holds_the_known_force_and_valid_siblings(press, hf, tmp_path):
    status, found, _ = press(NEO_HOOKEAN, "--depth", "60mm", "--steps", "3")
    assert status == 0
    assert found["converged"] is True
    assert found["force_N"] == pytest.approx(41.576556565, rel=1e-4)
    assert found["energy_J"] == pytest.approx(0.69307619325, rel=1e-4)
    assert found["contact_radius_mm"] == pytest.approx(30.716268, abs=0.2)
    assert found["stretch_max"] == pytest.approx(1.2854086307, rel=1e-3)
    assert found["wrinkled_area_fraction"] == 0.0
    assert [depth for depth, _ in found["force_depth"]] == [0.0, 20.0, 40.0, 60.0]
    assert found["stability"] == {"stable": True}
    assert found["contact_radius_undeformed_mm"] == pytest.approx(27.803588, abs=0.2)
    # At the apex, stretched alike both ways by the known 1.2854: 2 C (l^2 - l^-4).
    apex = 0.4 * (1.2854086307**2 - 1.2854086307**-4)
    assert found["stress_max_MPa"] == pytest.approx(apex, rel=5e-3)
    nominal = 0.4 * (1.2854086307 - 1.2854086307**-5)
    assert found["stress_nominal_max_MPa"] == pytest.approx(nominal, rel=5e-3)
    # There the tension in both directions over the sphere's radius: sigma thickness / l^2 (1/R + 1/R).
    assert found["pressure_max_MPa"] == pytest.approx(2.0 * apex / 1.2854086307**2 / 40.0, rel=5e-3)
    known = {20.0: 1.7959477986, 40.0: 14.679562516, 60.0: 41.576556565}
    assert dict(found["force_depth"][1:]) == pytest.approx(known, rel=2e-4)
    # The estimate is of the size of the true error: no bound, but no stranger either.
    error = abs(found["force_N"] / 41.576556565 - 1.0)
    assert error / 3.0 < found["force_error_relative"] <= 1e-4
    balance = found["balance"]
    assert balance["stored_J"] == pytest.approx(0.69307619325, rel=1e-4)
    assert balance["work_J"] == pytest.approx(0.69307619325, rel=1e-3)
    assert balance["dissipated_J"] == pytest.approx(0.0, abs=1e-9)
    off = balance["work_J"] / balance["stored_J"] - 1.0
    assert balance["imbalance_relative"] == pytest.approx(off, rel=1e-6, abs=1e-12)
    assert balance["reaction_N"] == pytest.approx(41.576556565, rel=1e-4)
    assert abs(balance["force_imbalance_relative"]) < 1e-9
    assert 2 <= found["newton_iterations"] < 30
    assert found["newton_iterations_total"] > 2 * found["newton_iterations"]
    assert 500 < found["unknowns"] < 100_000
    setup = {
        "size_mm": 200.0,
        "thickness_mm": 1.0,
        "sphere_radius_mm": 40.0,
        "depth_mm": 60.0,
        "prestretch": 1.0,
    }
    assert {key: found["setup"][key] for key in setup} == setup
    jsonschema.validate(found, json.loads(hf("schema", "contact").stdout))
    assert found["files"] == ["contact.csv", "contact.png", "contact.vtu"]
    lines = (tmp_path / "contact.csv").read_text().splitlines()
    assert lines[0].startswith("depth_mm,force_N,energy_J")
    assert float(lines[-1].split(",")[1]) == found["force_N"]
    assert (tmp_path / "contact.png").read_bytes().startswith(b"\x89PNG")
    fields = {item.get("Name") for item in ElementTree.parse(tmp_path / "contact.vtu").iter("DataArray")}
    assert {"stress_1_MPa", "stress_2_MPa", "thickness_mm", "contact", "wrinkled"} <= fields


def test_two_materials_are_compared_at_the_same_points(press):
    status, found, _ = press(NEO_HOOKEAN, "--depth", "40mm", "--steps", "2", against=STIFFER)
    assert status == 0
    assert found["stress_difference_percent"] == pytest.approx(25.0, rel=1e-6)
    assert found["force_ratio"] == pytest.approx(0.8, rel=1e-8)
    other = found["against"]
    assert other["force_N"] == pytest.approx(found["force_N"] / 0.8, rel=1e-8)
    assert other["stress_max_MPa"] == pytest.approx(1.25 * found["stress_max_MPa"], rel=1e-6)
    assert other["stretch_max"] == pytest.approx(found["stretch_max"], rel=1e-8)
    assert other["force_depth"][-1] == [40.0, other["force_N"]]
    balance = found["balance"]
    off = (balance["reaction_N"] - found["force_N"]) / found["force_N"]
    assert balance["force_imbalance_relative"] == pytest.approx(off, rel=1e-9, abs=0.0)
    assert found["compared_at_depth_mm"] == 40.0


@pytest.mark.parametrize("limit", [0.02])
@pytest.mark.slow
def test_chains_that_lock_end_with_4_and_figures_up_to_there(press, limit):
    """Smoothed strains may pass the law's limit where no point of the sheet has: that is no stress without a number."""
    locking = {**NEO_HOOKEAN, "model": "gent", "parameters": {"mu_MPa": 0.4, "Im": limit}}
    status, found, said = press(locking, "--depth", "40mm", "--steps", "1", "--tolerance", "1e-3")
    assert status == 4, said
    assert "no equilibrium" in said
    assert 0.0 < found["depth_reached_mm"] < 40.0
    # Equal stretch both ways reaches the limit first: 2 l^2 + l^-4 - 3 = Im.
    assert 1.0 + math.sqrt(limit / 12.0) < found["stretch_max"] < 1.0 + math.sqrt(limit / 2.0)
    assert found["stress_max_MPa"] > 100.0 * 0.4 * limit


@pytest.mark.slow
def test_constants_that_fail_end_with_4_and_name_both_depths(press):
    status, found, said = press(SOFTENING, "--depth", "70mm", "--steps", "2")
    assert status == 4
    assert found["converged"] is False
    assert found["depth_reached_mm"] == pytest.approx(60.35, abs=0.02)
    assert found["turning_point_mm"] == pytest.approx(60.35, abs=0.02)
    assert found["stability"]["stable"] is False
    assert found["stability"]["first_unstable_depth_mm"] == pytest.approx(57.46, abs=0.02)
    assert found["stability"]["stretches"] == pytest.approx([1.418, 1.418], abs=2e-3)
    assert "57.4" in said
    assert "60.35" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_constants_unstable_before_the_depth_end_with_4_though_it_is_reached(press):
    status, found, _ = press(SOFTENING, "--depth", "59mm", "--steps", "2")
    assert status == 4
    assert found["converged"] is True
    assert found["stability"]["stable"] is False
    assert found["depth_reached_mm"] == 59.0
    assert "lose Drucker stability at 57.4" in found["status"]


@pytest.mark.slow
def test_a_second_law_that_fails_is_told_where_the_status_is_4(press):
    status, found, _ = press(NEO_HOOKEAN, "--depth", "59mm", "--steps", "2", against=SOFTENING)
    assert status == 4
    assert found["stability"] == {"stable": True}
    assert found["status"].startswith("other.json: the constants lose Drucker stability at 57.4")
    assert found["depth_reached_mm"] == found["against"]["depth_reached_mm"] == 59.0


def test_a_fabric_with_two_directions_says_how_they_are_used(press):
    status, found, _ = press(TWO_WAYS, "--depth", "40mm", "--steps", "1", "--shape", "square")
    assert status == 0
    assert found["setup"]["thickness_mm"] == 0.5
    assert "warp" in found["setup"]["fabric"]
    assert any("shear" in words for words in found["left_out"])


@pytest.mark.slow
def test_friction_costs_energy_and_makes_the_sheet_stiffer(press):
    status, found, _ = press(NEO_HOOKEAN, "--depth", "40mm", "--friction", "0.3", "--steps", "2")
    assert status == 0
    assert found["force_N"] == pytest.approx(15.0404007, rel=5e-4)
    assert found["setup"]["friction"] == "Coulomb 0.3"
    assert found["balance"]["dissipated_J"] > 0.001
    assert abs(found["balance"]["imbalance_relative"]) < 2e-4


def test_the_path_begins_with_the_mounted_sheet(press, tmp_path):
    """Stretched by 1.05 both ways: energy C10 (2 s^2 + s^-4 - 3), stress 2 C10 (s^2 - s^-4)."""
    press(NEO_HOOKEAN, "--depth", "5mm", "--steps", "1", "--prestretch", "1.05")
    first = dict(
        zip(
            *(line.split(",") for line in (tmp_path / "contact.csv").read_text().splitlines()[:2]),
            strict=True,
        )
    )
    energy = 0.2 * (2 * 1.05**2 + 1.05**-4 - 3) * math.pi * 100.0**2
    assert float(first["energy_J"]) == pytest.approx(1e-3 * energy, rel=1e-5)
    assert float(first["stress_max_MPa"]) == pytest.approx(0.4 * (1.05**2 - 1.05**-4), rel=1e-6)


def test_document_alone_goes_to_standard_output(hf, tmp_path):
    done = hf(
        "fabric-contact",
        "-",
        "--depth",
        "20mm",
        "--steps",
        "1",
        stdin=json.dumps(NEO_HOOKEAN).encode(),
        cwd=tmp_path,
    )
    assert done.returncode == 0
    assert json.loads(done.stdout)["files"] == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--depth", "60"], "60mm"),
        (["--depth", "-3mm"], "--depth"),
        (["--shape", "hexagon"], "disc or square"),
        (["--prestretch", "5%"], "prestretch"),
        (["--prestretch", "50"], "1.05"),
        (["--steps", "0"], "--steps"),
        (["--mesh-size", "0.01mm"], "--mesh-size"),
        (["--size", "60mm", "--depth", "50mm"], "strike the clamp"),
        (["--tolerance", "0"], "--tolerance"),
        (["--friction", "glue"], "stick"),
        (["--depth", "1e6mm"], "--depth"),
        (["--depth", "1e-9mm"], "--depth"),
        (["--size", "1e9mm"], "--size"),
        (["--sphere-radius", "1um"], "--sphere-radius"),
        (["--friction", "30"], "coefficient"),
    ],
)
def test_options_that_cannot_be_meant_are_refused(press, options, said):
    status, found, error = press(NEO_HOOKEAN, *options)
    assert status == 2
    assert found is None
    assert said in error


def test_constants_a_law_does_not_know_are_refused_with_their_key(press):
    status, _, said = press({**NEO_HOOKEAN, "parameters": {"C11_MPa": 0.2}})
    assert status == 3
    assert "fabric.json" in said
    assert "parameters" in said


def test_effects_at_their_null_value_change_no_digit(press):
    few = ("--depth", "40mm", "--steps", "2", "--mesh-size", "20mm")
    documents = []
    for options in ((), ("--friction", "0", "--prestretch", "1", "--rim-slip", "0mm^2/N")):
        _, found, _ = press(NEO_HOOKEAN, *few, *options)
        documents.append({**found, "provenance": None})
    assert documents[0] == documents[1]
