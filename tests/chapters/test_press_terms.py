"""Sections of foam.toml for what a real press adds: nothing where they are zero, and what they say where not."""

import json
import re
import tomllib

import numpy as np
import pytest
from chapters.test_press_contact import FOAM, block, heat_document, press, solids
from conftest import ROOT

from hyperfab.documents.base import parse_document
from hyperfab.documents.foam import FoamDocument
from hyperfab.errors import InputError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import cup

NOTHING = """
relaxation = { share = 0.0, time = "5 s", dwell = "40 s" }
variation = { x = 0.0, yy = 0.0 }
poisson = { male = 0.33, female = 0.33 }
press = { tilt = { x = "0 deg", y = "0 deg" }, offset = { x = "0 mm" } }
"""


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shop")
    for name, solid in zip(("male", "female"), solids((20, 21)), strict=True):
        (folder / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    (folder / "foam.toml").write_text(FOAM)
    return folder


def with_foam(shop, monkeypatch, text, **options):
    (shop / "other.toml").write_text(FOAM + text)
    return press(shop, monkeypatch, foam="other.toml", **{"gap": "3mm", **options})[1]


def but_for_names(document):
    """The document without what tells which files it was made from."""
    known = [{**one, "from": None} for one in document["validity"]]
    return {**document, "provenance": None, "setup": None, "validity": known}


def test_terms_of_zero_change_no_bit(shop, monkeypatch):
    _, plain = press(shop, monkeypatch, gap="3mm", temperature="200degC")
    picture = (shop / "press.vtu").read_bytes()
    zeros = with_foam(shop, monkeypatch, NOTHING, temperature="200degC")
    assert but_for_names(zeros) == but_for_names(plain)
    assert (shop / "press.vtu").read_bytes() == picture


def test_molds_that_do_not_grow_and_foam_that_does_not_shrink_change_no_bit(shop, monkeypatch):
    _, plain = press(shop, monkeypatch, gap="3mm")
    still = FOAM.replace("23.6e-6 1/K", "0 1/K") + 'shrinkage = { amount = 0.0, time = "5 s", dwell = "40 s" }\n'
    (shop / "still.toml").write_text(still)
    _, same = press(shop, monkeypatch, gap="3mm", foam="still.toml", temperature="200degC", tilt="0deg,0deg")
    for key in (
        "force_N",
        "gap_min_mm",
        "gap_mean_mm",
        "gap_max_mm",
        "pressure_max_MPa",
        "regions",
        "force_stroke",
    ):
        assert same[key] == plain[key], key


def test_a_tilt_in_the_document_is_the_tilt_of_the_option(shop, monkeypatch):
    written = with_foam(shop, monkeypatch, 'press = { tilt = { x = "0.1 deg", y = "-0.05 deg" } }\n')
    _, asked = press(shop, monkeypatch, gap="3mm", tilt="0.1deg,-0.05deg")
    assert but_for_names(written) == but_for_names(asked)
    assert written["tilt_vector_deg"] == pytest.approx([0.1, -0.05, 0.0])
    assert written["tilt_deg"] == pytest.approx(np.hypot(0.1, 0.05))
    _, plain = press(shop, monkeypatch, gap="3mm")
    # Turned about x the half at positive y comes closer: the pressure moves there by the press frame's right hand.
    assert written["centre_of_pressure_mm"][1] != pytest.approx(plain["centre_of_pressure_mm"][1], abs=0.1)
    _, option_wins = press(shop, monkeypatch, gap="3mm", foam="other.toml", tilt="0deg,0deg")
    assert but_for_names(option_wins) == but_for_names(plain)


@pytest.mark.parametrize("facets", ["smooth", "flat"])
def test_a_female_mounted_off_the_axis_is_the_one_drawn_there(shop, monkeypatch, facets):
    """Where the force is given, all that the drawing's place decides is where the female stands across the axis."""
    more = {"force": "40N", "gap": None, "facets": facets}
    written = with_foam(shop, monkeypatch, 'press = { offset = { x = "0.6 mm", y = "-0.3 mm" } }\n', **more)
    _, plain = press(shop, monkeypatch, **more)
    body = solids((20, 21))[1]
    (shop / "moved.stl").write_bytes(stl_bytes(body.vertices + np.array([0.6, -0.3, 0.0]), body.faces))
    _, drawn = press(shop, monkeypatch, **more, female="moved.stl")
    for key in ("gap_min_mm", "gap_max_mm", "contact_area_mm2", "pressure_max_MPa", "energy_J", "stroke_mm"):
        # Written STL has single precision.
        assert written[key] == pytest.approx(drawn[key], rel=2e-5), key
    assert written["centre_of_pressure_mm"] == pytest.approx(drawn["centre_of_pressure_mm"], abs=1e-3)
    assert written["gap_min_mm"] < plain["gap_min_mm"] - 0.05


def test_the_frame_in_the_document_yields_as_the_option_does(shop, monkeypatch):
    written = with_foam(shop, monkeypatch, 'press = { stiffness = "1 kN/mm" }\n')
    _, asked = press(shop, monkeypatch, gap="3mm", frame_stiffness="1kN/mm")
    assert but_for_names(written) == but_for_names(asked)
    assert written["frame_stiffness_N_mm"] == 1000.0


def test_relaxed_and_uneven_foam(shop, monkeypatch):
    _, plain = press(shop, monkeypatch, gap="3mm")
    tired = with_foam(
        shop,
        monkeypatch,
        'relaxation = { share = 0.3, time = "10 s" }\nshrinkage = { time = "1 s", dwell = "10 s" }\n',
    )
    lost = 0.3 * (1.0 - np.exp(-1.0))
    assert tired["foam_relaxation"] == pytest.approx(lost)
    assert tired["force_N"] == pytest.approx((1.0 - lost) * plain["force_N"], rel=1e-12)
    assert tired["contact_area_mm2"] == plain["contact_area_mm2"]
    uneven = with_foam(shop, monkeypatch, "variation = { x = 0.1, xx = -0.05 }\n")
    assert uneven["sandwich_max_mm"] > 4.6 > 4.4 > uneven["sandwich_min_mm"]
    grid = read_vtu((shop / "press.vtu").read_bytes(), "press.vtu")
    half = np.abs(grid.points[:, 0]).max()
    u = grid.points[:, 0] / half
    assert grid.point_data["sandwich_mm"] == pytest.approx(4.5 * (1.0 + 0.1 * u - 0.05 * u * u), abs=2e-3)


def test_the_document_in_the_docs_is_sound():
    text = (ROOT / "docs" / "press-contact.md").read_text()
    found = re.search(r"```toml\n(.*?)```", text, re.DOTALL)
    assert found is not None
    document = parse_document(tomllib.loads(found[1]), "foam.toml", FoamDocument)
    assert document.relaxation.time == [2.0, 60.0]
    assert document.press.stiffness == 50_000.0


def test_flags_lie_in_the_field(shop, monkeypatch):
    _, document = press(shop, monkeypatch, gap="3mm")
    grid = read_vtu((shop / "press.vtu").read_bytes(), "press.vtu")
    for name, share in (("at_border", "border_area_fraction"), ("oblique", "oblique_area_fraction")):
        assert bool(grid.point_data[name].any()) == (document[share] > 0.0)


def test_nothing_touched_is_no_force_and_no_minus_sign(shop, monkeypatch):
    press(shop, monkeypatch, gap="9mm")
    text = (shop / "press.json").read_text()
    assert json.loads(text)["force_N"] == 0.0
    assert "-0.0," not in text
    assert "-0.0\n" not in text


def test_poissons_ratio_of_a_mold_decides_how_an_uneven_heat_bends_it(tmp_path, monkeypatch):
    """A strain that is quadratic through the thickness: the sideways stress pushes the surface out by nu; not so on
    the mean of it, as these stresses add up to none through the thickness."""
    male, female = block(-40.0, 0.0), block(10.0, 50.0)
    for name, (points, tets, faces) in (("male", male), ("female", female)):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(points, faces))
        celsius = 100.0 + 0.05 * (points[:, 2] if name == "male" else 0.0 * points[:, 2]) ** 2
        (tmp_path / f"{name}-heat.vtu").write_bytes(
            unstructured(points, {"tetra10": tets}, {"temperature_degC": celsius})
        )
        (tmp_path / f"{name}-heat.json").write_text(json.dumps(heat_document(f"{name}-heat.vtu")))
    heat = {"male_heat": "male-heat.json", "female_heat": "female-heat.json"}
    found = []
    for ratio in (0.0, 0.33):
        (tmp_path / "foam.toml").write_text(
            FOAM.replace("4.5 mm", "12 mm") + f"poisson = {{ male = {ratio}, female = 0.33 }}\n"
        )
        found.append(press(tmp_path, monkeypatch, gap="10mm", **heat)[1])
    assert found[0]["male"]["growth_strain"] == found[1]["male"]["growth_strain"]
    assert found[0]["gap_max_mm"] != pytest.approx(found[1]["gap_max_mm"], abs=1e-4)
    assert found[0]["gap_mean_mm"] == pytest.approx(found[1]["gap_mean_mm"], abs=1e-4)


def test_foam_that_is_uneven_between_the_corners_of_large_facets_is_met_there(tmp_path, monkeypatch):
    """Plates of twelve facets; foam 4.5 (1 - 0.2 u²) mm, whose mean of 1 / (1 - 0.2 u²) is atanh(√0.2) / √0.2."""
    for name, solid in (("male", cup.plate(-20.0, 0.0)), ("female", cup.plate(10.0, 30.0))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    (tmp_path / "foam.toml").write_text(FOAM + "variation = { xx = -0.2 }\n")
    _, document = press(tmp_path, monkeypatch, gap="3mm")
    root = np.sqrt(0.2)
    exact = 0.05 * 120.0**2 * (1.0 - 3.0 / 4.5 * np.arctanh(root) / root)
    # Thickness is linear along facets of 1/16 in u: on the mean 0.4 (1/16)² / 12 too thin, of a strain of 0.28.
    assert document["force_N"] == pytest.approx(exact, rel=4e-4)
    assert document["pressure_max_MPa"] == pytest.approx(0.05 / 3.0, rel=1e-6)


def test_molds_drawn_into_each_other_are_parted_and_that_is_said(shop, monkeypatch, capsys):
    male, female = solids((20, 21))
    _, plain = press(shop, monkeypatch, gap="3mm")
    assert plain["clearance_drawn_mm"] == pytest.approx(3.0, abs=0.02)
    for depth in (3.5, 20.0):
        (shop / "low.stl").write_bytes(stl_bytes(female.vertices - [0.0, 0.0, depth], female.faces))
        _, document = press(shop, monkeypatch, gap="3mm", female="low.stl")
        overlap = depth - plain["clearance_drawn_mm"]
        assert document["clearance_drawn_mm"] == pytest.approx(-overlap, abs=1e-4)
        said = re.search(r"overlap by ([\d.]+) mm", capsys.readouterr().err)
        assert said is not None
        assert float(said[1]) == pytest.approx(overlap, abs=1e-3)
        assert document["force_N"] == pytest.approx(plain["force_N"], rel=1e-4)
    # The same mold twice is no tool, however far it is opened.
    (shop / "twin.stl").write_bytes(stl_bytes(male.vertices, male.faces))
    with pytest.raises(InputError, match="do not face each other"):
        press(shop, monkeypatch, gap="3mm", female="twin.stl")


def test_corners_that_single_precision_rounds_apart_are_welded(shop, monkeypatch, capsys):
    _, female = solids((20, 21))
    _, plain = press(shop, monkeypatch, gap="3mm")
    apart = female.vertices[female.faces].reshape(-1, 3)
    apart = apart + np.random.default_rng(3).uniform(-1e-5, 1e-5, apart.shape)
    (shop / "soup.stl").write_bytes(stl_bytes(apart, np.arange(len(apart)).reshape(-1, 3)))
    _, found = press(shop, monkeypatch, gap="3mm", female="soup.stl")
    assert "soup.stl: corners that differ by rounding" in capsys.readouterr().err
    assert found["force_N"] == pytest.approx(plain["force_N"], rel=1e-4)


def test_a_heap_of_facets_is_refused_by_name(shop, monkeypatch):
    _, female = solids((20, 21))
    apart = female.vertices[female.faces].reshape(-1, 3)
    apart = apart + np.random.default_rng(3).normal(0.0, 0.1, apart.shape)  # no rounding
    (shop / "heap.stl").write_bytes(stl_bytes(apart, np.arange(len(apart)).reshape(-1, 3)))
    with pytest.raises(InputError, match="do not hang together"):
        press(shop, monkeypatch, gap="3mm", female="heap.stl")
    # Facets are numbered as the file numbers them, those that are left out included.
    faces = np.vstack([[0, 0, 1], np.arange(len(apart)).reshape(-1, 3)])
    (shop / "heap.stl").write_bytes(stl_bytes(apart, faces))
    with pytest.raises(InputError, match="facet 2"):
        press(shop, monkeypatch, gap="3mm", female="heap.stl")
