"""hf press-contact: the document to the letter of its contract, what must not change the answer, what is refused."""

import json

import jsonschema
import numpy as np
import pytest
from conftest import ROOT

from hyperfab.cases.press import PressCase
from hyperfab.chapters import press_contact
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.documents.base import schema
from hyperfab.errors import InputError, UsageError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import cup

KEYS = [
    "gap_min_mm",
    "gap_mean_mm",
    "gap_max_mm",
    "contact_area_mm2",
    "contact_fraction",
    "force_N",
    "pressure_max_MPa",
    "stroke_mm",
    "tilt_deg",
    "regions",
]
FOAM = """
format = "hyperfab.foam/1"
thickness = "4.5 mm"
compression = { law = "linear", modulus = "0.05 MPa" }
expansion = { male = "23.6e-6 1/K", female = "23.6e-6 1/K" }
"""


#: Of the cups, beside four of their flanges: as coarse as what is asked of them allows.
CELLS = (20, 21)


def solids(cells=CELLS):
    return cup.male_cup(*cells), cup.female_cup(cells[1], cells[0])


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shop")
    for name, solid in zip(("male", "female"), solids(), strict=True):
        (folder / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    (folder / "foam.toml").write_text(FOAM)
    return folder


def press(folder, monkeypatch, output="press.json", **options):
    monkeypatch.chdir(folder)
    given = {"male": "male.stl", "female": "female.stl", "foam": "foam.toml", "strokes": 5, **options}
    case = PressCase.of({name: text for name, text in given.items() if text is not None})
    status = press_contact.run(Job("press-contact", [], Console(quiet=True), target=output), case)
    return status, json.loads((folder / output).read_text())


@pytest.mark.pictures
def test_the_document_has_the_contracts_keys_and_fits_its_schema(shop, monkeypatch):
    status, document = press(shop, monkeypatch, gap="3mm", temperature="200degC")
    assert status == 0
    assert document["format"] == "hyperfab.press/1"
    assert [key for key in KEYS if key not in document] == []
    region_keys = {"contact", "area_mm2", "centroid_mm", "gap_mean_mm", "pressure_mean_MPa"}
    assert all(region_keys <= region.keys() for region in document["regions"])
    jsonschema.validate(document, schema("press"))
    assert document["files"] == ["press.csv", "press.png", "press.vtu"]


def test_regions_share_out_the_area(shop, monkeypatch):
    _, document = press(shop, monkeypatch, gap="3mm")
    assert document["setup"]["temperature_degC"] == 20.0  # of a room, where nothing is asked
    touching = sum(region["area_mm2"] for region in document["regions"] if region["contact"])
    assert touching == pytest.approx(document["contact_area_mm2"], rel=1e-9)
    whole = document["molding_area_mm2"] + document["flange_area_mm2"]
    assert sum(region["area_mm2"] for region in document["regions"]) == pytest.approx(whole, rel=1e-9)


def test_the_field_on_the_male(shop, monkeypatch):
    press(shop, monkeypatch, gap="3mm")
    grid = read_vtu((shop / "press.vtu").read_bytes(), "press.vtu")
    assert {"gap_mm", "compression", "pressure_MPa", "contact"} <= grid.point_data.keys()
    pressed = grid.point_data["pressure_MPa"] > 0.0
    assert (grid.point_data["gap_mm"][pressed] < 4.5).all()
    assert grid.points[:, 2].max() == pytest.approx(70.0, abs=0.3)


def test_a_force_is_met_and_its_position_gives_it_back(shop, monkeypatch):
    _, forced = press(shop, monkeypatch, force="150N", temperature="200degC")
    assert forced["force_N"] == pytest.approx(150.0, rel=1e-6)
    gap = f"{forced['clearance_cold_mm']!r}mm"
    _, placed = press(shop, monkeypatch, gap=gap, temperature="200degC")
    assert placed["force_N"] == pytest.approx(150.0, rel=1e-6)
    assert placed["stroke_mm"] == pytest.approx(forced["stroke_mm"], abs=1e-6)


def test_growth_closes_a_gap_set_cold_and_hardly_changes_one_set_hot(shop, monkeypatch):
    """Both mounting faces are 170 mm apart, less the gap: that much aluminium grows into the gap."""
    _, cold = press(shop, monkeypatch, gap="3mm")
    _, hot = press(shop, monkeypatch, gap="3mm", temperature="200degC")
    expected = 23.6e-6 * 180.0 * (170.0 - 3.0)
    assert cold["clearance_hot_mm"] - hot["clearance_hot_mm"] == pytest.approx(expected, abs=0.01)
    _, zeroed = press(shop, monkeypatch, gap="3mm", temperature="200degC", zero="hot")
    assert zeroed["gap_min_mm"] == pytest.approx(cold["gap_min_mm"], abs=0.02)


@pytest.mark.slow
def test_winding_order_format_and_unit_of_the_files_do_not_change_the_answer(shop, monkeypatch):
    male, female = solids()
    _, plain = press(shop, monkeypatch, gap="3mm")
    shuffled = np.random.default_rng(5).permutation(male.faces)
    mixed, top = male.faces.copy(), 2 * (CELLS[0] + 4) * (CELLS[1] + 4)
    mixed[::7] = mixed[::7, ::-1]
    variants = {
        "shuffled": stl_bytes(male.vertices, shuffled),
        "inward": stl_bytes(male.vertices, male.faces[:, ::-1]),
        "mixed": stl_bytes(male.vertices, mixed),
        "ascii": _ascii(male),
        "open": stl_bytes(male.vertices, male.faces[:top]),
        "open inward": stl_bytes(male.vertices, male.faces[:top, ::-1]),
    }
    for name, data in variants.items():
        (shop / "variant.stl").write_bytes(data)
        _, found = press(shop, monkeypatch, gap="3mm", male="variant.stl")
        assert found["force_N"] == pytest.approx(plain["force_N"], rel=1e-5), name
        assert found["contact_area_mm2"] == pytest.approx(plain["contact_area_mm2"], rel=1e-5), name
    for name, solid in (("male", male), ("female", female)):
        (shop / f"{name}-inch.stl").write_bytes(stl_bytes(solid.vertices / 25.4, solid.faces))
    inches = {"male": "male-inch.stl", "female": "female-inch.stl", "stl_unit": "inch"}
    _, found = press(shop, monkeypatch, gap="3mm", **inches)
    assert found["force_N"] == pytest.approx(plain["force_N"], rel=1e-4)


def test_molds_in_inches_that_pass_for_small_ones_are_asked_about(shop, monkeypatch, capsys):
    """Molds 7 mm wide about 4.5 mm of foam: 100 % of 63 mm2 touched, without a word."""
    for name, solid in zip(("male", "female"), solids(), strict=True):
        (shop / f"{name}-inch.stl").write_bytes(stl_bytes(solid.vertices / 25.4, solid.faces))
    inches = {"male": "male-inch.stl", "female": "female-inch.stl", "gap": "3mm"}
    press(shop, monkeypatch, **inches)
    said = capsys.readouterr().err
    assert "male-inch.stl: measures" in said
    assert "mm when read in mm, the sandwich 4.5 mm thick; if that is not so, say --stl-unit" in said
    press(shop, monkeypatch, **inches, stl_unit="inch")
    assert "measures" not in capsys.readouterr().err


def test_collision_of_the_hot_molds_is_a_negative_verdict_and_says_how_far_to_open(shop, monkeypatch, capsys):
    status, document = press(shop, monkeypatch, gap="0.2mm", temperature="200degC")
    assert status == 1
    assert document["gap_min_mm"] < 0.0
    assert "open by 0.5" in capsys.readouterr().err
    assert document["states"]["interfering_mm2"] > 0.0


def test_too_little_spotted_is_a_negative_verdict(shop, monkeypatch):
    assert press(shop, monkeypatch, gap="3mm", min_spotted=40.0)[0] == 0
    for written in (80.0, "80", "80%"):
        status, document = press(shop, monkeypatch, gap="3mm", min_spotted=written)
        assert status == 1
        assert document["setup"]["min_spotted"] == 80.0


def test_too_much_pressure_is_a_negative_verdict(shop, monkeypatch, capsys):
    status, document = press(shop, monkeypatch, gap="3mm")
    greatest = document["pressure_max_MPa"]
    assert status == 0
    assert press(shop, monkeypatch, gap="3mm", max_pressure=f"{1.01 * greatest!r} MPa")[0] == 0
    assert press(shop, monkeypatch, gap="3mm", max_pressure=f"{0.99 * greatest!r} MPa")[0] == 1
    assert f"{0.99 * greatest:g} MPa are allowed" in capsys.readouterr().err


def test_plates_that_just_touch_bear_as_much_as_just_before(tmp_path, monkeypatch, capsys):
    for name, solid in (("male", cup.plate(-20.0, 0.0)), ("female", cup.plate(4.0, 24.0))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    (tmp_path / "foam.toml").write_text(FOAM)
    for facets in ("smooth", "flat"):
        _, before = press(tmp_path, monkeypatch, gap="0.0001mm", facets=facets)
        capsys.readouterr()
        status, touching = press(tmp_path, monkeypatch, gap="0mm", facets=facets)
        assert status == 1
        assert "the hot molds touch at" in capsys.readouterr().err
        assert touching["force_N"] == pytest.approx(before["force_N"], rel=1e-4)
        forces = [force for _, force in touching["force_stroke"]]
        assert forces == sorted(forces)
        assert touching["oblique_area_fraction"] == 0.0
        _, closed = press(tmp_path, monkeypatch, gap=None, force=f"{0.9 * touching['force_N']!r}N", facets=facets)
        assert closed["gap_min_mm"] == pytest.approx(0.45, abs=1e-6)
        # Hot, their walls slide along each other: each is 20 mm thick and grows by as much as the other.
        capsys.readouterr()
        status, hot = press(tmp_path, monkeypatch, gap="0mm", temperature="70degC", facets=facets)
        assert status == 1
        grown = 23.6e-6 * (70.0 - 20.0)
        assert f"overlap by {40.0 * grown:.3f} mm" in capsys.readouterr().err
        # Beside the walls the nearest gap is none; inside, the foam of 4.5 mm is strained by the overlap more.
        ratio = hot["force_N"] / touching["force_N"] / (1.0 + grown) ** 2
        assert 1.0 <= ratio <= 1.0 + 40.0 * grown / 4.5 + 1e-9


def test_foam_that_would_be_pressed_to_nothing_is_told(tmp_path, monkeypatch, capsys):
    """Foam of 3.5 mm between two fabrics of 0.5 mm: a gap of 1.05 mm leaves 0.05 mm, one of 0.5 mm less than none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "foam.toml").write_text(
        'format = "hyperfab.foam/1"\nthickness = "3.5 mm"\ncompression = { law = "linear", modulus = "0.05 MPa" }\n'
        'fabric = { above = "0.5 mm", below = "0.5 mm" }\nexpansion = { male = "0 1/K", female = "0 1/K" }\n'
    )
    for name, solid in (("male", cup.plate(-20.0, 0.0)), ("female", cup.plate(4.0, 24.0))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    told = {}
    for gap in ("1.05mm", "0.5mm"):
        assert press(tmp_path, monkeypatch, gap=gap)[0] == 0
        told[gap] = "the foam would be pressed by 114 % of its thickness, to nothing" in capsys.readouterr().err
    assert told == {"1.05mm": False, "0.5mm": True}


def test_floating_molds_under_a_force_off_centre_tilt_towards_it(shop, monkeypatch):
    _, middle = press(shop, monkeypatch, force="100N", floating=True)
    _, aside = press(shop, monkeypatch, force="100N", floating=True, force_at="25mm,0mm")
    assert aside["tilt_deg"] > middle["tilt_deg"]
    assert aside["force_N"] == pytest.approx(100.0, rel=1e-6)


def test_a_yielding_frame_opens_the_press(shop, monkeypatch):
    _, stiff = press(shop, monkeypatch, gap="3mm")
    _, soft = press(shop, monkeypatch, gap="3mm", frame_stiffness="1kN/mm")
    assert soft["force_N"] < stiff["force_N"]
    assert soft["clearance_cold_mm"] == pytest.approx(3.0 + soft["force_N"] / 1000.0, abs=1e-7)
    assert soft["clearance_to_set_mm"] == pytest.approx(3.0, abs=1e-7)


#: Beside another male the female's facets are cut a little otherwise, and what is behind the largest moves by so much.
@pytest.mark.parametrize(
    ("cells", "even_to", "set_to"), [((16, 17), 0.06, 0.02), (CELLS, 0.08, 0.04), ((30, 31), 0.03, 0.01)]
)
def test_the_designed_male_presses_evenly(tmp_path, monkeypatch, cells, even_to, set_to):
    (tmp_path / "foam.toml").write_text(FOAM)
    for name, solid in zip(("male", "female"), solids(cells), strict=True):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    status, document = press(tmp_path, monkeypatch, gap="3mm", temperature="200degC", design_gap="4mm", output="d.json")
    assert status == 0
    assert "d.design.stl" in document["files"]
    hot = {"temperature": "200degC", "zero": "hot", "male": "d.design.stl"}
    _, even = press(tmp_path, monkeypatch, gap="4mm", **hot)
    assert even["gap_max_mm"] - even["gap_min_mm"] < even_to
    assert document["design"]["gap_min_mm"] == pytest.approx(4.0, abs=0.01)
    assert document["design"]["gap_max_mm"] == pytest.approx(4.0, abs=0.01)
    assert even["contact_fraction"] > 0.999
    assert even["flange_area_mm2"] == pytest.approx(document["flange_area_mm2"], rel=0.07)
    # Set cold at the clearance that is told it is that gap when hot.
    cold = {**hot, "zero": "cold", "gap": f"{document['design']['clearance_to_set_mm']:.9f}mm"}
    _, set_cold = press(tmp_path, monkeypatch, **cold)
    assert set_cold["gap_min_mm"] == pytest.approx(4.0, abs=set_to)


@pytest.mark.parametrize(("degrees", "told"), [(10.0, False), (50.0, True)])
def test_a_designed_male_that_is_uneven_beside_a_crease_is_told(tmp_path, monkeypatch, capsys, degrees, told):
    """Around the outer edge of a ramp the surface of constant gap is round, and the male has no facets for that."""
    (tmp_path / "foam.toml").write_text(FOAM)
    x, y = np.meshgrid([-60.0, -40, -20, -10, 0, 10, 20, 40, 60], np.linspace(-60.0, 60.0, 13), indexing="ij")
    height = np.clip(x, -10.0, 10.0) * np.tan(np.radians(degrees))
    for name, up, back in (("male", 0.0, -40.0), ("female", 8.0, 60.0)):
        solid = cup.closed_below(np.stack([x, y, height + up], axis=-1), back, facing_up=name == "male")
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    _, document = press(tmp_path, monkeypatch, gap="8mm", design_gap="4mm")
    found = document["design"]
    assert (max(found["gap_max_mm"] - 4.0, 4.0 - found["gap_min_mm"]) > 0.05) is told
    assert ("the male of --design-gap leaves" in capsys.readouterr().err) is told


@pytest.mark.parametrize(("cells", "told"), [(CELLS, True), ((44, 45), False)])
def test_facets_too_few_for_the_sandwich_are_told(tmp_path, monkeypatch, capsys, cells, told):
    (tmp_path / "foam.toml").write_text(FOAM)
    for name, solid in zip(("male", "female"), solids(cells), strict=True):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    press(tmp_path, monkeypatch, gap="3mm")
    assert ("give a finer STL" in capsys.readouterr().err) is told


def test_a_draped_sheet_thins_the_sandwich(shop, monkeypatch):
    side = np.linspace(-150.0, 150.0, 31)
    points = np.stack(np.meshgrid(side, side, [100.0], indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(31 * 31).reshape(31, 31)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    grid = unstructured(points, {"quad": quads}, cell_data={"thickness_mm": np.full(len(quads), 0.4)})
    (shop / "drape.vtu").write_bytes(grid)
    (shop / "drape.json").write_text(json.dumps(_drape()))
    _, plain = press(shop, monkeypatch, gap="3mm")
    _, draped = press(shop, monkeypatch, gap="3mm", drape="drape.json")
    # The usual ratio where nothing tells it.
    assert draped["sandwich_mm"] == pytest.approx(4.5 * 0.8 ** (0.3 / 0.7))
    assert "0.3, as is usual" in draped["foam_thinning"]
    assert draped["contact_area_mm2"] < plain["contact_area_mm2"]
    for given, left in (
        ("poisson = 0.5", 0.8),
        ("poisson = { foam = 0 }", 1.0),
        ("poisson = -0.2", 0.8 ** (-0.2 / 1.2)),
    ):
        (shop / "ratio.toml").write_text(FOAM + given)
        _, found = press(shop, monkeypatch, gap="3mm", drape="drape.json", foam="ratio.toml")
        assert found["sandwich_mm"] == pytest.approx(4.5 * left, rel=1e-12)


@pytest.mark.slow
def test_drape_thins_incompressible_foam_as_all_layers_before(shop, monkeypatch):
    """With a ratio of 0.5 the press is that of a sandwich of the thinned layers, to the last figures."""
    test_a_draped_sheet_thins_the_sandwich(shop, monkeypatch)
    layers = 'fabric = {{ above = "{0} mm", below = "{0} mm" }}\n'
    (shop / "whole.toml").write_text(FOAM + layers.format(0.5) + "poisson = 0.5\n")
    thin = FOAM.replace('"4.5 mm"', '"3.6 mm"') + layers.format(0.4)
    (shop / "thin.toml").write_text(thin)
    _, draped = press(shop, monkeypatch, gap="3mm", drape="drape.json", foam="whole.toml")
    _, plain = press(shop, monkeypatch, gap="3mm", foam="thin.toml")
    for key in ("force_N", "contact_area_mm2", "pressure_max_MPa", "energy_J", "sandwich_mm"):
        assert draped[key] == pytest.approx(plain[key], rel=1e-9)


@pytest.mark.parametrize(
    ("short", "full"),
    [
        ('compression = "foam.csv"', 'compression = { table = "foam.csv" }'),
        ('compression = "foam.json"', 'compression = { material = "foam.json" }'),
        ("shrinkage = 0.05", "shrinkage = { amount = 0.05 }"),
        ('shrinkage = "5 %"', "shrinkage = { amount = 0.05 }"),
        ('poisson = "30 %"', "poisson = { foam = 0.3 }"),
    ],
)
def test_short_forms_of_the_foam_are_the_full_ones(shop, monkeypatch, short, full):
    (shop / "foam.csv").write_text("strain [-],stress [MPa]\n0,0\n0.5,0.01\n0.9,0.1\n")
    foam = {"mu1_MPa": 0.02, "alpha1": 8.0, "nu1": 0.1}
    (shop / "foam.json").write_text(
        json.dumps({"format": "hyperfab.material/1", "model": "hyperfoam-1", "parameters": foam})
    )
    law = next(line for line in FOAM.splitlines() if line.startswith("compression"))
    for name, text in (("short", short), ("full", full)):
        changed = FOAM.replace(law, text) if text.startswith("compression") else FOAM + text
        (shop / f"{name}.toml").write_text(changed)
    given = {"gap": "3mm", "temperature": "20degC"}
    one, other = (press(shop, monkeypatch, foam=f"{name}.toml", **given)[1] for name in ("short", "full"))
    assert one["force_N"] == other["force_N"] > 0.0


def test_a_material_of_a_newer_hf_is_refused_as_foam_by_its_version(shop, monkeypatch):
    (shop / "newer.json").write_text(json.dumps({"format": "hyperfab.material/9", "model": "hyperfoam-1"}))
    with pytest.raises(InputError, match="has version 9 of the format"):
        press(shop, monkeypatch, gap="3mm", foam="newer.json")


def test_molds_that_touch_everywhere_touch_a_hundred_percent(tmp_path, monkeypatch):
    """Cut faces sum up to their areas but for rounding, of these molds to 1 - 1e-16."""
    given = {name: str(ROOT / "molds" / f"cup-{name}.stl") for name in ("male", "female")}
    given |= {"foam": str(ROOT / "specimens" / "foam.toml"), "temperature": "200degC", "force": "500N"}
    status, document = press(tmp_path, monkeypatch, strokes=2, min_spotted="100%", **given)
    assert (status, document["contact_fraction"]) == (0, 1.0)


def test_shrunk_foam_touches_less_and_stays_thinner(shop, monkeypatch):
    _, plain = press(shop, monkeypatch, gap="3mm")
    assert "final_thickness" not in plain  # nothing says what stays
    given = '\nshrinkage = { amount = 0.2, time = "30 s", dwell = "30 s", recovery = 0.5 }\n'
    (shop / "shrinking.toml").write_text(FOAM + given)
    _, shrunk = press(shop, monkeypatch, gap="3mm", foam="shrinking.toml")
    lost = 0.2 * (1.0 - np.exp(-1.0))
    assert shrunk["foam_shrinkage"] == pytest.approx(lost)
    thickness = 4.5 * (1.0 - lost)
    assert shrunk["sandwich_mm"] == pytest.approx(thickness)
    assert shrunk["final_thickness"]["max_mm"] == pytest.approx(thickness)
    assert shrunk["final_thickness"]["min_mm"] == pytest.approx(0.5 * (shrunk["gap_min_mm"] + thickness), abs=5e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "give --gap or --force"),
        ({"gap": "3mm", "force": "5N"}, "only one of"),
        ({"gap": "3"}, "write 3mm"),
        ({"gap": "-1mm"}, "0mm or more"),
        ({"force": "0N"}, "more than 0N"),
        ({"gap": "3mm", "axis": "w"}, "x, y or z"),
        ({"gap": "3mm", "zero": "warm"}, "cold or hot"),
        ({"gap": "3mm", "facets": "round"}, "smooth or flat"),
        ({"gap": "3mm", "min_spotted": 120.0}, "between 0 and 100"),
        ({"gap": "3mm", "min_spotted": "101%"}, "between 0 and 100"),
        ({"gap": "3mm", "min_spotted": "90 degC"}, "a number of percent is needed, as 80%"),
        ({"gap": "3mm", "force_at": "1mm,2mm"}, "add --float"),
        ({"gap": "3mm", "floating": True, "force_at": "1mm"}, "two components"),
        ({"gap": "3mm", "temperature": "200degC", "male_heat": "h.json"}, "exclude each other"),
        ({"gap": "3mm", "female": "male.stl"}, "the same file"),
        ({"gap": "3mm", "strokes": 1}, "between 2 and 1001"),
        ({"gap": "3mm", "tilt": "0.1deg"}, "two components"),
        ({"gap": "3mm", "tilt": "30deg,0deg"}, "more than 5 deg"),
        ({"gap": "3mm", "tilt": "0.1deg,0deg", "floating": True}, "finds its tilt by itself"),
    ],
)
def test_options_that_cannot_mean_anything_are_refused(shop, monkeypatch, options, message):
    with pytest.raises(UsageError, match=message):
        press(shop, monkeypatch, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gap": "3mm", "axis": "x"}, "^male.stl, female.stl: .*use --axis z"),
        ({"gap": "3mm", "male": "female.stl", "female": "male.stl"}, "^female.stl, male.stl: .*swapped"),
        ({"force": "1e9N"}, r"largest force the sandwich can carry is \d+"),
        ({"gap": "3mm", "design_gap": "200mm"}, r"near \(.*\) mm"),
        ({"gap": "3mm", "female_heat": "missing.json"}, "no such file"),
    ],
)
def test_inputs_that_do_not_fit_are_refused_with_the_way_out(shop, monkeypatch, options, message):
    with pytest.raises(InputError, match=message):
        press(shop, monkeypatch, **options)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('thickness = "4.5 mm"', 'thickness = "4.5"'), "thickness"),
        (('thickness = "4.5 mm"', ""), "thickness"),
        (('law = "linear"', 'law = "rubber"'), "linear"),
        (("expansion =", "shrinkage = { amount = 2.0 }\nexpansion ="), "not be more than 0.9"),
        (("expansion =", 'shrinkage = { amount = 0.1, time = "3 s" }\nexpansion ='), "belong together"),
        (("modulus", "modulas"), "modul"),
        (('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "falling.csv" }'), "line 4.*stress falls"),
        (('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "percent.csv" }'), "below 1"),
        (('male = "23.6e-6 1/K"', 'male = "23.6e-6 mm"'), "expansion"),
        (('{ male = "23.6e-6 1/K"', '{ reference = "200 degC", male = "23.6e-6 1/K"'), "room temperature"),
        (("expansion =", 'relaxation = { share = 0.2, time = "9 s" }\nexpansion ='), "needs a dwell"),
        (("expansion =", "relaxation = { share = [0.2, 0.1] }\nexpansion ="), "one value a term"),
        (("expansion =", "variation = { x = 0.8, yy = 0.3 }\nexpansion ="), "nothing would be left"),
        (("expansion =", "variation = { z = 0.1 }\nexpansion ="), "closing axis z"),
        (("expansion =", 'press = { tilt = { z = "1 deg" } }\nexpansion ='), "no tilt"),
        (("expansion =", 'press = { offset = { z = "1 mm" } }\nexpansion ='), "name an axis across z"),
        (("expansion =", 'press = { stiffness = "0 N/mm" }\nexpansion ='), "greater than 0"),
        (("expansion =", "poisson = { male = 0.6 }\nexpansion ="), "poisson.male"),
    ],
)
def test_a_foam_document_that_is_wrong_is_refused_by_key_or_line(shop, monkeypatch, change, message):
    assert change[0] in FOAM
    (shop / "bad.toml").write_text(FOAM.replace(*change))
    (shop / "falling.csv").write_text("strain [-],stress [MPa]\n0,0\n0.2,0.1\n0.4,0.05\n")
    (shop / "percent.csv").write_text("strain [-],stress [MPa]\n0,0\n20,0.1\n40,0.2\n")
    with pytest.raises(InputError, match=message):
        press(shop, monkeypatch, gap="3mm", foam="bad.toml")


def test_only_the_document_goes_to_standard_output(hf, shop):
    found = hf(
        "press-contact",
        "--male",
        "male.stl",
        "--female",
        "female.stl",
        "--foam",
        "foam.toml",
        "--gap",
        "3mm",
        cwd=shop,
    )
    assert found.returncode == 0, found.stderr
    document = json.loads(found.stdout)
    assert document["format"] == "hyperfab.press/1"
    # The share is of the molding surface; the flange's area is in the other figure, and it is said.
    assert document["flange_area_mm2"] > 0.0
    told = f"{100 * document['contact_fraction']:.1f} % of the molding surface, {document['contact_area_mm2']:.0f} mm2"
    assert f"touching {told} with the flange, gap" in found.stderr.decode()


def test_a_mold_grows_by_its_own_field_of_temperature(tmp_path, monkeypatch):
    """Two blocks, the male hotter at its foot: free to warp it bends as the closed solution of a linear field says."""
    male, female = block(-40.0, 0.0), block(10.0, 50.0)
    alpha, slope = 23.6e-6, -1.0
    for name, (points, tets, faces), gradient in (("male", male, slope), ("female", female, 0.0)):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(points, faces))
        celsius = 120.0 + gradient * points[:, 2]
        (tmp_path / f"{name}-heat.vtu").write_bytes(
            unstructured(points, {"tetra10": tets}, {"temperature_degC": celsius})
        )
        (tmp_path / f"{name}-heat.json").write_text(json.dumps(heat_document(f"{name}-heat.vtu")))
    (tmp_path / "foam.toml").write_text(FOAM.replace("4.5 mm", "12 mm"))
    heat = {"male_heat": "male-heat.json", "female_heat": "female-heat.json", "mounted": "free"}
    _, document = press(tmp_path, monkeypatch, gap="10mm", **heat)
    assert document["male"]["temperature_degC"] == pytest.approx(140.0)
    assert "thermoelastic" in document["male"]["temperature_from"]
    grid = read_vtu((tmp_path / "press.vtu").read_bytes(), "press.vtu")
    x = grid.points
    exact = alpha * (100.0 * x + slope * x[:, [2]] * x)
    exact[:, 2] -= 0.5 * alpha * slope * (x * x).sum(axis=1)
    found = grid.point_data["growth_mm"]
    # The top is flat: what is left of both when each is measured from its own mean is the bending.
    assert np.ptp(found[:, 2] - exact[:, 2]) < 1e-5
    assert np.ptp(found[:, 2]) == pytest.approx(0.5 * alpha * 2 * 40.0**2, rel=1e-3)


def test_the_field_of_another_mold_counts_by_its_mean_and_that_is_said(shop, monkeypatch, capsys):
    points, tets, _ = block(-40.0, 0.0)
    grid = unstructured(points, {"tetra10": tets}, {"temperature_degC": np.full(len(points), 150.0)})
    (shop / "other.vtu").write_bytes(grid)
    (shop / "other.json").write_text(json.dumps(heat_document("other.vtu")))
    _, document = press(shop, monkeypatch, gap="3mm", male_heat="other.json")
    assert "its mold is another one" in capsys.readouterr().err
    assert document["male"]["temperature_degC"] == pytest.approx(150.0)
    assert document["female"]["growth_strain"] == 0.0
    assert any("uneven temperature" in line for line in document["left_out"])


def test_a_foam_test_as_the_machine_wrote_it(shop, monkeypatch):
    """Down and up again with jitter of 0.3 %: the force is that of the clean way down."""
    down = np.linspace(0.0, 0.8, 161)
    law = 0.02 * down + 0.05 * down**3
    jitter = np.random.default_rng(3).normal(0.0, 0.003 * 0.0416 / 3.0, 161)
    up = down[::-1] - 1e-4
    for name, strain, stress in (
        ("clean", down, law),
        ("raw", np.concatenate([down, up]), np.concatenate([law + jitter, 0.6 * law[::-1]])),
    ):
        rows = "".join(f"{e!r},{s!r}\n" for e, s in zip(strain.tolist(), stress.tolist(), strict=True))
        (shop / f"{name}.csv").write_text(f"strain [-],stress [MPa]\n{rows}")
        (shop / f"{name}.toml").write_text(
            FOAM.replace('{ law = "linear", modulus = "0.05 MPa" }', f'{{ table = "{name}.csv" }}')
        )
    told = []
    monkeypatch.setattr(Console, "note", lambda _, *texts: told.extend(texts))
    _, clean = press(shop, monkeypatch, gap="3mm", foam="clean.toml")
    assert not any("left out" in text for text in told)
    _, raw = press(shop, monkeypatch, gap="3mm", foam="raw.toml")
    assert any("161 rows of the loading" in text and "161 of the way back" in text for text in told)
    assert raw["force_N"] == pytest.approx(clean["force_N"], rel=0.01)
    assert raw["validity"][0]["known"] == pytest.approx([0.0, 0.8])
    lines = (shop / "raw.csv").read_text().splitlines()
    (shop / "raw.csv").write_text("\n".join([*lines[:100], *lines[20:40], *lines[100:]]))
    with pytest.raises(InputError, match=r"line 101.*goes back"):
        press(shop, monkeypatch, gap="3mm", foam="raw.toml")


def test_a_law_by_its_constants_is_told_beside_tables(shop, monkeypatch):
    """It was told only where nothing else was used; of it nothing says how far it holds."""
    (shop / "grow.csv").write_text("temperature [degC],expansion [1/K]\n20,23e-6\n250,24e-6\n")
    (shop / "grows.toml").write_text(FOAM.replace('{ male = "23.6e-6 1/K"', '{ male = { table = "grow.csv" }'))
    _, document = press(shop, monkeypatch, gap="3mm", foam="grows.toml", temperature="200degC")
    expansion, strain = document["validity"]
    assert (expansion["of"], expansion["within"]) == ("expansion.male", True)
    assert strain["of"] == "strain"
    assert "known" not in strain


def test_a_table_used_beyond_its_rows_is_told(shop, monkeypatch, capsys):
    (shop / "short.csv").write_text("strain [-],stress [MPa]\n0,0\n0.1,0.005\n")
    (shop / "grow.csv").write_text("temperature [degC],expansion [1/K]\n50,23e-6\n100,24e-6\n")
    text = FOAM.replace('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "short.csv" }')
    (shop / "short.toml").write_text(text.replace('{ male = "23.6e-6 1/K"', '{ male = { table = "grow.csv" }'))
    _, document = press(shop, monkeypatch, gap="3mm", foam="short.toml", temperature="200degC")
    strain, expansion = document["validity"]
    assert (strain["of"], strain["known"], strain["within"]) == ("strain", [0.0, 0.1], False)
    assert strain["used"][1] == pytest.approx((4.5 - document["gap_min_mm"]) / 4.5)
    assert expansion == {
        "of": "expansion.male",
        "used": [200.0, 200.0],
        "known": [50.0, 100.0],
        "within": False,
        "from": "short.toml",
    }
    assert "used beyond what is known: strain 0 to" in capsys.readouterr().err


def mold_on_boards(folder, low=-40.0):
    """A heat document of a block at 200 degC on a board of 60 degC and under one of 20 degC; and the block's STL."""
    points, tets, celsius, part = [], [], [], []
    for index, (bottom, top, degc) in enumerate(((low - 20.0, low, 60.0), (low, 0.0, 200.0), (80.0, 90.0, 20.0))):
        some, elements, faces = block(bottom, top)
        tets.append(elements + sum(map(len, points)))
        points.append(some)
        celsius.append(np.full(len(some), degc))
        part.append(np.full(len(elements), index, dtype=np.int32))
        if index == 1:
            (folder / "cup.stl").write_bytes(stl_bytes(some, faces))
    grid = unstructured(
        np.concatenate(points),
        {"tetra10": np.concatenate(tets)},
        {"temperature_degC": np.concatenate(celsius)},
        {"part": np.concatenate(part)},
    )
    (folder / "assembly.vtu").write_bytes(grid)
    document = heat_document("assembly.vtu") | {"mass_by_part_kg": {"board": 1.0, "cup": 1.0, "lid": 1.0}}
    (folder / "assembly.json").write_text(json.dumps(document))
    some, _, faces = block(10.0, 50.0)
    (folder / "flat.stl").write_bytes(stl_bytes(some, faces))
    (folder / "foam.toml").write_text(FOAM.replace("4.5 mm", "12 mm"))


def test_the_part_that_is_the_mold_gives_its_heat(tmp_path, monkeypatch):
    mold_on_boards(tmp_path)
    options = {"male": "cup.stl", "female": "flat.stl", "gap": "10mm"}
    _, document = press(tmp_path, monkeypatch, male_heat="assembly.json", **options)
    assert document["male"]["temperature_degC"] == pytest.approx(200.0)
    assert document["male"]["temperature_from"] == "field of part cup of the heat document, thermoelastic"
    # Even heat: the block grows by alpha dT, from its foot.
    grid = read_vtu((tmp_path / "press.vtu").read_bytes(), "press.vtu")
    rise = document["male"]["growth_strain"] * 40.0
    assert grid.point_data["growth_mm"][:, 2] == pytest.approx(rise, abs=1e-9)
    _, same = press(tmp_path, monkeypatch, male_heat="assembly.json:cup", **options)
    assert same["force_N"] == document["force_N"]


def test_a_heat_model_without_the_mold_asks_for_the_part(tmp_path, monkeypatch, shop, capsys):
    mold_on_boards(tmp_path)
    for name in ("male.stl", "female.stl"):
        (tmp_path / name).write_bytes((shop / name).read_bytes())
    with pytest.raises(InputError, match=r"none of its parts is this mold: .*board lies .*name the part .*json:"):
        press(tmp_path, monkeypatch, gap="3mm", male_heat="assembly.json")
    with pytest.raises(InputError, match=r"has no part cop.*board, cup, lid"):
        press(tmp_path, monkeypatch, gap="3mm", male_heat="assembly.json:cop")
    _, document = press(tmp_path, monkeypatch, gap="3mm", male_heat="assembly.json:cup")
    assert document["male"]["temperature_degC"] == pytest.approx(200.0)
    assert "that part is another one" in capsys.readouterr().err


def test_mean_pressure_and_normal_forces_are_those_of_the_touching_area(shop, monkeypatch):
    _, document = press(shop, monkeypatch, gap="3mm")
    touching = [region for region in document["regions"] if region["contact"]]
    assert all(region["normal_force_N"] == region["force_N"] for region in touching)
    load = sum(region["normal_force_N"] for region in touching)
    assert document["pressure_mean_MPa"] == pytest.approx(load / document["contact_area_mm2"], rel=1e-12)
    # On slopes the pressure's share along the axis is less than all of it.
    assert document["force_N"] < load


def block(low, high, cells=4, side=80.0):
    """A block of ten-node tetrahedra and its outer triangles."""
    from hyperfab.pressing.tetra import EDGES, TetraMesh, boundary

    across, up = np.linspace(-side / 2, side / 2, cells + 1), np.linspace(low, high, 3)
    points = np.stack(np.meshgrid(across, across, up, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(cells + 1, cells + 1, 3)
    corner = [number[i : i + cells, j : j + cells, k : k + 2].ravel() for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    # Kuhn's six tetrahedra of a cell, all about its diagonal.
    paths = [(0, 4, 6, 7), (0, 6, 2, 7), (0, 2, 3, 7), (0, 3, 1, 7), (0, 1, 5, 7), (0, 5, 4, 7)]
    tets = np.concatenate([np.stack([corner[i] for i in path], axis=1) for path in paths])
    ends = np.sort(np.stack([tets[:, list(edge)] for edge in EDGES], axis=1), axis=2)
    key, inverse = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    points = np.concatenate([points, points[key].mean(axis=1)])
    tets = np.concatenate([tets, len(points) - len(key) + inverse.reshape(-1, 6)], axis=1)
    return points, tets, boundary(TetraMesh(points, tets))[:, :3]


def heat_document(file):
    energy = dict.fromkeys(["supplied_J", "lost_J", "stored_J", "imbalance_relative"], 0.0)
    numbers = {"steps": 1, "unknowns": 1, "mass_kg": 1.0}
    return {"format": "hyperfab.heat/1", "converged": True, **numbers, "energy": energy, "files": [file]}


def _ascii(solid):
    lines = ["solid cup"]
    for corners in np.float32(solid.vertices)[solid.faces]:
        vertices = "\n".join("vertex " + " ".join(repr(float(v)) for v in corner) for corner in corners)
        lines.append(f"facet normal 0 0 0\nouter loop\n{vertices}\nendloop\nendfacet")
    return ("\n".join([*lines, "endsolid cup"]) + "\n").encode()


def _drape():
    use = {"model": "yeoh-1", "stretch_max": 1.1}
    numbers = dict.fromkeys(
        [
            "iterations",
            "iterations_finest",
            "residual_max_N",
            "residual_relative",
            "tolerance",
            "energy_J",
            "force_N",
            "imbalance_N",
            "contact_nodes",
            "penetration_max_mm",
            "penetration_nodes_mm",
            "penetration_edges_mm",
            "slack_springs",
            "stress_warp_max_MPa",
            "stress_weft_max_MPa",
            "thickness_min_mm",
            "depth_mm",
        ],
        0,
    )
    return {
        "format": "hyperfab.drape/1",
        "converged": True,
        **numbers,
        "thickness_mm": 0.5,
        "grid": [31, 31],
        "size_mm": [300.0, 300.0],
        "clamp": ["x-"],
        "warp": use,
        "weft": use,
        "mold": {"facets": 1, "closed": True, "shift_mm": [0.0, 0.0, 30.0]},
        "files": ["drape.vtu"],
    }


def test_a_small_female_over_a_large_flat_male_is_met_to_its_edges(tmp_path, monkeypatch):
    """Beside the female's edges the nearest point is the edge: a ring of foam as wide as it reaches bears there too."""
    for name, low, high in (("male", (-100, -100, -20), (200, 200, 0)), ("female", (0, 0, 10), (100, 100, 30))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(*cuboid(np.array(low, float), np.array(high, float))))
    (tmp_path / "foam.toml").write_text(FOAM)
    status, document = press(tmp_path, monkeypatch, gap="3mm", strokes=2)
    assert status == 0
    beside = np.linspace(0.0, np.sqrt(4.5**2 - 3.0**2), 2001)
    gap = np.hypot(3.0, beside)
    axial = 0.05 * (1.0 - gap / 4.5) * 3.0 / gap * (4 * 100.0 + 2 * np.pi * beside)
    force = 0.05 * (1.0 - 3.0 / 4.5) * 100.0**2 + np.trapezoid(axial, beside)
    area = 100.0**2 + 400.0 * beside[-1] + np.pi * beside[-1] ** 2
    assert document["force_N"] == pytest.approx(force, rel=0.025)
    assert document["contact_area_mm2"] == pytest.approx(area, rel=0.01)


def cuboid(low, high):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return low + corners * (high - low), np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def test_molds_far_apart_are_closed_to_their_first_touch_and_not_through_each_other(tmp_path, monkeypatch):
    """From a first guess that falls short by a tilt, or by rounding, twice the way led out at the other side."""
    for name, low, high in (("male", (0, 0, -20), (100, 100, 0)), ("female", (0, 0, 10), (100, 100, 30))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(*cuboid(np.array(low, float), np.array(high, float))))
    (tmp_path / "foam.toml").write_text(FOAM)
    status, document = press(tmp_path, monkeypatch, gap="200mm", tilt="0.05deg,0deg", strokes=2)
    assert status == 0
    first = 4.5 - 200.0 + 50.0 * np.sin(np.radians(0.05))  # the edge that the tilt lowers touches first
    assert document["stroke_mm"] == pytest.approx(first, abs=1e-3)


def test_long_strips_of_a_cylinder_meet_what_stands_over_their_middle(tmp_path, monkeypatch):
    """STL of a cylinder is strips from end to end, whose corners say nothing of what stands over their middle."""
    turn, ends = np.radians(np.linspace(-40.0, 40.0, 17)), np.array([-100.0, 100.0])
    x = np.linspace(-110.0, 110.0, 111)
    dimple = 10.0 - 7.0 * np.exp(-(x[:, None] ** 2 + x**2) / 450.0)
    arc = np.repeat(80.0 * np.cos(turn)[:, None] - 80.0, 2, axis=1)
    for name, across, along, height, up in (
        ("male", 80.0 * np.sin(turn), ends, arc, True),
        ("female", x, x, dimple, False),
    ):
        n, m = height.shape
        points = np.stack([np.repeat(across, m), np.tile(along, n), height.ravel()], axis=1)
        a = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
        one, two = np.stack([a, a + m, a + m + 1], axis=1), np.stack([a, a + m + 1, a + 1], axis=1)
        faces = np.concatenate([one, two])
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(points, faces if up else faces[:, ::-1]))
    (tmp_path / "foam.toml").write_text(FOAM)
    _, document = press(tmp_path, monkeypatch, gap="3mm", temperature="23degC")
    assert document["gap_min_mm"] == pytest.approx(3.0, abs=0.01)
    assert document["chord_error_mm"] == pytest.approx(80.0 * (1.0 - np.cos(np.radians(2.5))), abs=0.01)
