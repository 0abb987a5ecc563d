"""hf press-contact between plates: laws by temperature, fabrics that give way, areas and what is left out, as told."""

import json

import pytest

from hyperfab.cases.press import PressCase
from hyperfab.chapters import press_contact
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.errors import InputError
from hyperfab.pressing.foam_law import hyperfoam

from .test_press_contact import press
from .test_press_dwell import plates  # noqa: F401

AREA = 80.0 * 80.0
HEAD = 'format = "hyperfab.foam/1"\nthickness = "4 mm"\nexpansion = { male = "0 1/K", female = "0 1/K" }\n'
SPRING = 'compression = { law = "linear", modulus = "0.02 MPa"%s }\n'


def pressed(folder, monkeypatch, text, **options):
    (folder / "foam.toml").write_text(HEAD + text)
    return press(folder, monkeypatch, **{"gap": "3mm", **options})[1]


@pytest.mark.parametrize(("celsius", "modulus"), [(20, 0.05), (100, 0.04), (180, 0.03), (200, 0.03), (-20, 0.05)])
def test_the_law_is_that_of_the_molds_temperature(plates, monkeypatch, celsius, modulus):  # noqa: F811
    text = """compression = [
      { law = "linear", modulus = "0.03 MPa", temperature = "180 degC" },
      { law = "linear", modulus = "0.05 MPa", temperature = "20 degC" },
    ]
    """
    document = pressed(plates, monkeypatch, text, temperature=f"{celsius}degC")
    assert document["force_N"] == pytest.approx(modulus * 0.25 * AREA, rel=1e-9)
    entry = next(one for one in document["validity"] if one["of"] == "compression")
    assert entry["known"] == [20.0, 180.0]
    assert entry["within"] is (20 <= celsius <= 180)
    assert not any("temperature: its law" in line for line in document["left_out"])


@pytest.mark.parametrize("laws", ["[]", '[{ law = "linear", modulus = "1 MPa" }]'])
def test_of_several_laws_each_needs_its_temperature(plates, monkeypatch, laws):  # noqa: F811
    with pytest.raises(InputError, match="compression"):
        pressed(plates, monkeypatch, f"compression = {laws}\n")


def test_a_law_is_multiplied_by_its_factor(plates, monkeypatch):  # noqa: F811
    document = pressed(plates, monkeypatch, SPRING % ", factor = 1.5")
    assert document["force_N"] == pytest.approx(1.5 * 0.02 * 0.25 * AREA, rel=1e-9)


def test_fabric_gives_way_by_its_curve_and_takes_its_share_of_the_closing(plates, monkeypatch):  # noqa: F811
    (plates / "knit.csv").write_text("strain [-],stress [kPa]\n0,0\n0.4,4\n0.5,50\n")
    layers = 'fabric = { above = "0.4 mm", below = "0.6 mm"%s }\n'
    rigid = pressed(plates, monkeypatch, SPRING % "" + layers % "", gap="4mm")
    assert rigid["force_N"] == pytest.approx(0.02 * 0.25 * AREA, rel=1e-9)
    assert any("compression of the fabric" in line for line in rigid["left_out"])
    soft = pressed(plates, monkeypatch, SPRING % "" + layers % ', compression = { table = "knit.csv" }', gap="4mm")
    assert soft["force_N"] == pytest.approx(AREA / (4.0 / 0.02 + 1.0 / 0.01), rel=1e-6)
    assert not any("compression of the fabric" in line for line in soft["left_out"])
    entry = next(one for one in soft["validity"] if one["of"] == "fabric.compression")
    assert entry["used"][1] == pytest.approx(1.0 / 3.0, rel=1e-6)
    assert entry["within"] is True


def test_fabric_gives_way_by_its_material_document(plates, monkeypatch):  # noqa: F811
    constants = {"mu1_MPa": 0.01, "alpha1": 8.0, "nu1": 0.0}
    material = {
        "format": "hyperfab.material/1",
        "model": "hyperfoam-1",
        "parameters": constants,
        "thickness_mm": 1.0,
    }
    (plates / "spacer.json").write_text(json.dumps(material))
    document = pressed(plates, monkeypatch, SPRING % "" + 'fabric = { above = "spacer.json" }\n', gap="4mm")
    pressure = document["pressure_max_MPa"]
    given = 1.0 - 4.0 * pressure / 0.02
    assert hyperfoam([0.01], [8.0], [0.0]).stress(given) == pytest.approx(pressure, rel=1e-5)


def test_forces_count_the_males_area_and_the_females_is_told(plates, monkeypatch):  # noqa: F811
    document = pressed(plates, monkeypatch, SPRING % "")
    assert document["bearing_area_ratio"] == pytest.approx(1.0, rel=1e-9)
    assert document["force_beside_fraction"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("tested", [["uniaxial"], ["uniaxial", "confined-compression"]])
def test_held_sides_far_beyond_the_tests_are_told(plates, monkeypatch, capsys, tested):  # noqa: F811
    """A law of free specimens with a Poisson's ratio near 0.5 says next to anything between plates."""
    material = {
        "format": "hyperfab.material/1",
        "model": "hyperfoam-1",
        "parameters": {"mu1_MPa": 0.01, "alpha1": 6.0, "nu1": 0.48},
        "tested": {name: {"stretch": [0.5, 1.0]} for name in tested},
        "thickness_mm": 4.0,
    }
    (plates / "soft.json").write_text(json.dumps(material))
    (plates / "foam.toml").write_text(HEAD + 'compression = { material = "soft.json" }\n')
    monkeypatch.chdir(plates)
    given = {"male": "male.stl", "female": "female.stl", "foam": "foam.toml", "strokes": 2, "gap": "3mm"}
    press_contact.run(Job("press-contact", [], Console(), target="press.json"), PressCase.of(given))
    said = capsys.readouterr().err
    assert ("where its sides are held" in said) is (tested == ["uniaxial"])
