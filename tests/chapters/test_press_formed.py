"""hf press-contact with a set: what stays between plates in closed form, what misses the wanted, the changed mold."""

import numpy as np
import pytest

from hyperfab.documents.base import schema
from hyperfab.errors import InputError, UsageError
from hyperfab.io.stl import read_stl
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import cup
from hyperfab.surface import Surface

from .test_press_contact import press
from .test_press_dwell import HEAT, TEXTILE, block

RATE, ACTIVATION = 2e9, 95e3
LAW = 'set = { rate = "2e9 1/s", activation = "95 kJ/mol" }\n'
HOT = 'temperature = "200 degC"\n'
DWELL = {"temperature": "200degC", "dwell": "20s"}


def share(celsius, seconds):
    return 1.0 - np.exp(-RATE * np.exp(-ACTIVATION / (8.31446261815324 * (celsius + 273.15))) * seconds)


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plates")
    (folder / "male.stl").write_bytes(stl_bytes(*block(-20.0, 0.0)))
    (folder / "female.stl").write_bytes(stl_bytes(*block(10.0, 30.0)))
    return folder


@pytest.fixture(scope="module")
def cups(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cups")
    for name, solid in (("male", cup.male_cup(30, 31)), ("female", cup.female_cup(31, 30))):
        (folder / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    return folder


def form(folder, monkeypatch, more, **options):
    (folder / "foam.toml").write_text(TEXTILE.replace("expansion", HEAT + more + "expansion"))
    return press(folder, monkeypatch, **options)


@pytest.mark.parametrize("more", ["", LAW])
@pytest.mark.parametrize("dwell", [None, "5s"])
def test_a_formed_thickness_is_told_where_dwell_and_set_tell_it_and_nowhere_else(plates, monkeypatch, more, dwell):
    _, document = form(plates, monkeypatch, more, gap="2mm", temperature="200degC", dwell=dwell)
    told = bool(more and dwell)
    assert [key for key in ("formed", "wanted", "compensation", "final_thickness") if key in document] == (
        ["formed"] if told else []
    )
    fields = read_vtu((plates / "press.vtu").read_bytes(), "press.vtu").point_data
    assert ("formed_thickness_mm" in fields) is told


@pytest.mark.pictures
@pytest.mark.parametrize("stays", [0.0, 0.7, 1.0])
def test_a_share_of_the_strain_stays_between_plates(plates, monkeypatch, stays):
    import jsonschema

    _, document = form(plates, monkeypatch, f"set = {stays}\n", gap="2mm", **DWELL)
    found = document["formed"]
    for key in ("thickness_min_mm", "thickness_mean_mm", "thickness_max_mm"):
        assert found[key] == pytest.approx(4.5 - stays * 2.5, abs=1e-9)
    assert found["springback_max_mm"] == pytest.approx((1.0 - stays) * 2.5, abs=1e-9)
    assert "formed.png" in " ".join(document["files"])
    jsonschema.validate(document, schema("press"))


def test_fabrics_spring_back_and_foam_sets(plates, monkeypatch):
    law = '{ law = "linear", modulus = "0.05 MPa" }'
    more = f'set = 0.5\nfabric = {{ above = "1 mm", below = "1 mm", compression = {law} }}\n'
    _, document = form(plates, monkeypatch, more, gap="4.5mm", **DWELL)
    # Of the 2 mm, foam and fabrics of one modulus take their shares of the thickness.
    taken = 2.0 * 4.5 / 6.5
    assert document["formed"]["thickness_mean_mm"] == pytest.approx(6.5 - 0.5 * taken, abs=1e-6)


def test_at_one_temperature_the_law_is_its_closed_form(plates, monkeypatch):
    _, document = form(plates, monkeypatch, LAW + HOT, gap="2mm", **DWELL)
    found = document["formed"]
    assert found["set"]["share_mean"] == pytest.approx(share(200.0, 20.0), rel=1e-9)
    assert found["thickness_mean_mm"] == pytest.approx(4.5 - 2.5 * share(200.0, 20.0), abs=1e-9)


def test_a_law_comes_back_from_thicknesses_that_it_left(plates, monkeypatch, capsys):
    rows = [(t, s, 5.0, 2.0, 5.0 - 3.0 * share(t, s)) for t in (150.0, 170.0, 190.0, 205.0) for s in (10.0, 30.0, 90.0)]
    head = "temperature [degC],dwell [s],before [mm],pressed [mm],after [mm]\n"
    (plates / "set.csv").write_text(head + "".join(",".join(repr(float(cell)) for cell in row) + "\n" for row in rows))
    _, document = form(plates, monkeypatch, 'set = { measured = "set.csv" }\n' + HOT, gap="2mm", **DWELL)
    law = document["formed"]["set"]
    assert (law["rate_1_s"], law["activation_J_mol"]) == pytest.approx((RATE, ACTIVATION), rel=1e-6)
    assert law["rms"] < 1e-9
    known = {entry["of"]: entry for entry in document["validity"]}
    assert known["set temperature_degC"]["known"] == [150.0, 205.0]
    assert known["set temperature_degC"]["within"]
    # The law goes on beyond the longest dwell, and that is what is said.
    capsys.readouterr()
    _, longer = form(
        plates, monkeypatch, 'set = { measured = "set.csv" }\n' + HOT, gap="2mm", **DWELL | {"dwell": "120s"}
    )
    assert longer["formed"]["set"]["share_mean"] == pytest.approx(share(200.0, 120.0), rel=1e-6)
    assert "set dwell_s 120 (set.csv: 0 to 90; extrapolated)" in capsys.readouterr().err


def test_a_table_is_read_between_its_rows_and_says_where_it_ends(plates, monkeypatch):
    rows = [(t, s, e, v) for (t, s, e), v in zip(
        [(t, s, e) for t in (160.0, 190.0) for s in (10.0, 40.0) for e in (0.2, 0.6)],
        (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8), strict=True)]  # fmt: skip
    text = "temperature [degC],dwell [s],strain [-],set [-]\n" + "".join(",".join(map(str, r)) + "\n" for r in rows)
    (plates / "set.csv").write_text(text)
    more = 'set = { table = "set.csv" }\ntemperature = "175 degC"\n'
    _, document = form(plates, monkeypatch, more, gap="2.7mm", temperature="175degC", dwell="25s")
    assert document["formed"]["set"]["share_mean"] == pytest.approx(0.45, abs=1e-9)  # the middle of all eight
    # Of the law by its constants nothing says how far it holds.
    assert [entry["of"] for entry in document["validity"] if "known" not in entry] == ["strain"]
    assert all(entry["within"] for entry in document["validity"] if "known" in entry)
    more = more.replace("175", "195")
    _, document = form(plates, monkeypatch, more, gap="2.7mm", temperature="195degC", dwell="25s")
    beyond = [entry["of"] for entry in document["validity"] if entry.get("within") is False]
    assert beyond == ["set temperature_degC"]
    assert document["formed"]["set"]["share_mean"] == pytest.approx(0.65, abs=1e-9)
    # A row that is missing, one that falls.
    for broken, words in (
        (text.replace("190.0,40.0,0.6,0.8\n", ""), "not tested"),
        (text.replace("0.8", "0.5"), "sooner"),
    ):
        (plates / "set.csv").write_text(broken)
        with pytest.raises(InputError, match=words):
            form(plates, monkeypatch, more, gap="2.7mm", **DWELL)


def test_where_the_product_misses_what_is_wanted(plates, monkeypatch):
    """Formed 3 mm everywhere; wanted is 3 mm in the middle, 0.4 mm more and less at the sides, even between."""
    rows = [(x, y, 0.0, 3.0 + 0.01 * x) for x in (-40.0, 0.0, 40.0) for y in (-40.0, 40.0)]
    text = "x [mm],y [mm],z [mm],thickness [mm]\n" + "".join(",".join(map(str, row)) + "\n" for row in rows)
    (plates / "wanted.csv").write_text(text)
    options = {"gap": "3mm", "wanted": "wanted.csv", "within": "0.2mm", **DWELL}
    _, document = form(plates, monkeypatch, "set = 1.0\n", **options)
    found = document["wanted"]
    assert (found["wanted_min_mm"], found["wanted_max_mm"]) == pytest.approx((2.6, 3.4))
    assert abs(found["worst_mm"]) == pytest.approx(0.4, abs=1e-9)
    assert abs(found["worst_at_mm"][0]) == pytest.approx(40.0)
    assert np.sign(found["worst_at_mm"][0]) == -np.sign(found["worst_mm"])
    off = read_vtu((plates / "press.vtu").read_bytes(), "press.vtu").point_data["off_wanted_mm"]
    assert np.abs(off).max() == pytest.approx(0.4, abs=1e-9)
    _, document = form(plates, monkeypatch, "set = 1.0\n", **{**options, "wanted": "2.9 mm", "within": "0.05mm"})
    assert document["wanted"]["rms_mm"] == pytest.approx(0.1, abs=1e-9)
    assert document["wanted"]["outside_area_fraction"] == pytest.approx(1.0)


def read_back(folder, monkeypatch, more, document, **options):
    """Press with the male that was written, the clearance set as it says."""
    data = (folder / "press.compensated.stl").read_bytes()
    mesh = read_stl(data, "press.compensated.stl")
    assert Surface(mesh.vertices, mesh.faces).soundness().closed
    to_set = f"{document['compensation']['clearance_to_set_mm']!r}mm"
    given = {**options, "male": "press.compensated.stl", "gap": to_set, "output": "back.json"}
    given.pop("compensate", None)
    return form(folder, monkeypatch, more, **given)


def test_the_compensated_cup_forms_what_is_wanted_and_so_does_its_stl(cups, monkeypatch):
    options = {"gap": "3mm", "wanted": "3mm", "within": "0.05mm", **DWELL}
    status, document = form(cups, monkeypatch, LAW, compensate=True, **options)
    assert status == 0
    found = document["compensation"]
    assert found["converged"]
    assert abs(document["wanted"]["worst_mm"]) > 1.0
    assert abs(found["wanted"]["worst_mm"]) < 0.005
    assert found["wanted"]["outside_area_fraction"] == 0.0
    assert len(found["history"]) == found["iterations"] + 2
    assert abs(found["history"][-1]["worst_mm"]) == pytest.approx(abs(found["wanted"]["worst_mm"]))
    _, back = read_back(cups, monkeypatch, LAW, document, **options)
    # It is the male that was found; the large facets of its STL are cut, and between their corners, where no gap was
    # sought, the smooth surfaces of two coarse molds part by some more.
    assert back["wanted"]["rms_mm"] < 0.003
    assert abs(back["wanted"]["worst_mm"]) < 0.02
    assert back["formed"]["thickness_mean_mm"] == pytest.approx(3.0, abs=0.005)


def test_a_coarse_cup_is_compensated_as_a_fine_one(tmp_path, monkeypatch):
    """Its foot turns by 35 degrees from facet to facet; the male is written in as many facets as that takes."""
    for name, solid in (("male", cup.male_cup(20, 21)), ("female", cup.female_cup(21, 20))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    options = {"gap": "3mm", "wanted": "3mm", "within": "0.05mm", **DWELL}
    status, document = form(tmp_path, monkeypatch, LAW, compensate=True, **options)
    assert status == 0
    assert document["compensation"]["converged"]
    _, back = read_back(tmp_path, monkeypatch, LAW, document, **options)
    assert back["wanted"]["rms_mm"] < 0.003
    assert abs(back["wanted"]["worst_mm"]) < 0.05
    assert back["formed"]["thickness_mean_mm"] == pytest.approx(3.0, abs=0.005)


def test_an_uneven_wish_is_formed_too_with_hot_molds_that_warm_the_sandwich_for_a_short_time(cups, monkeypatch):
    """Where less has set, the gap must be smaller; foam that is thinner to one side and molds that grow come along."""
    rows = [(x, y, 0.0, 3.4 + 0.002 * x) for x in (-120.0, 120.0) for y in (-120.0, 120.0)]
    text = "x [mm],y [mm],z [mm],thickness [mm]\n" + "".join(",".join(map(str, row)) + "\n" for row in rows)
    (cups / "wanted.csv").write_text(text)
    more = LAW + "variation = { x = 0.05 }\n"
    options = {"gap": "3mm", "wanted": "wanted.csv", "temperature": "205degC", "dwell": "12s"}
    status, document = form(cups, monkeypatch, more, compensate=True, **options)
    assert status == 0
    assert document["formed"]["set"]["share_max"] - document["formed"]["set"]["share_min"] > 0.05
    assert abs(document["compensation"]["wanted"]["worst_mm"]) < 0.005
    _, back = read_back(cups, monkeypatch, more, document, **options)
    assert abs(back["wanted"]["worst_mm"]) < 0.02


def test_a_frame_that_yields_is_set_closer_by_what_the_compensated_male_presses(plates, monkeypatch):
    more = 'set = 1.0\npress = { stiffness = "0.1 kN/mm" }\n'
    options = {"gap": "3mm", "wanted": "2.5mm", **DWELL}
    status, document = form(plates, monkeypatch, more, compensate=True, **options)
    assert status == 0
    _, back = read_back(plates, monkeypatch, more, document, **options)
    set_to = document["compensation"]["clearance_to_set_mm"]
    assert back["clearance_cold_mm"] - set_to == pytest.approx(back["force_N"] / 100.0, rel=1e-6)
    assert back["force_N"] > 10.0  # 0.1 mm and more
    assert back["wanted"]["worst_mm"] == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(("more", "wanted"), [(LAW, "6mm"), ("set = 0.0\n", "3mm")])
def test_what_no_gap_forms_is_told_and_is_not_called_done(cups, monkeypatch, more, wanted):
    """Thicker than the sandwich; or nothing sets."""
    status, document = form(cups, monkeypatch, more, gap="3mm", wanted=wanted, compensate=True, **DWELL)
    assert status == 4
    assert not document["compensation"]["converged"]
    assert document["compensation"]["unreached_area_fraction"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("more", "options", "words"),
    [
        (LAW, {"wanted": "3mm"}, "--dwell"),
        (LAW, {"compensate": True, "dwell": "5s"}, "--wanted"),
        (LAW, {"wanted": "3mm", "dwell": "5s", "compensate": True, "tilt": "0.05deg,0deg"}, "in parallel"),
        ("", {"wanted": "3mm", "dwell": "5s"}, "what stays"),
        (LAW, {"wanted": "3", "dwell": "5s"}, "unit|--wanted"),
        ("set = 1.2\n", {}, "not be more than 1"),
        ("set = { activation = \"95 kJ\", rate = \"1 1/s\" }\n", {}, "a mole"),
        ("set = { name = 3 }\n", {}, "measured"),
        ("set = 0.5\nshrinkage = { recovery = 0.5 }\n", {}, "one of them"),
    ],
)  # fmt: skip
def test_what_cannot_be_formed_is_refused(plates, monkeypatch, more, options, words):
    with pytest.raises((InputError, UsageError), match=words):
        form(plates, monkeypatch, more, gap="2mm", temperature="200degC", **options)
