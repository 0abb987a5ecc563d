"""hf press-contact --dwell: the sandwich's temperature between two plates whose answer is known, and what it needs."""

import json

import numpy as np
import pytest

from hyperfab.errors import InputError, UsageError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.samples import sample_files

from .test_press_contact import heat_document, press

#: The report's textile.
TEXTILE = """
format = "hyperfab.foam/1"
thickness = "4.5 mm"
compression = { law = "linear", modulus = "0.05 MPa" }
expansion = { male = "0 1/K", female = "0 1/K", reference = "25 degC" }
"""
HEAT = 'conductivity = "0.023 W/m/K"\nspecific_heat = "1045 J/kg/K"\ndensity = "30 kg/m^3"\n'
CONDUCTIVITY, CAPACITY, THICK = 0.023, 30.0 * 1045.0, 4.5e-3


def block(low, high, side=40.0):
    """A closed box between two heights [mm]."""
    x, y, z = np.meshgrid([-side, side], [-side, side], [low, high], indexing="ij")
    corners = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plates")
    (folder / "male.stl").write_bytes(stl_bytes(*block(-20.0, 0.0)))
    (folder / "female.stl").write_bytes(stl_bytes(*block(10.0, 30.0)))
    return folder


def warm(folder, monkeypatch, more="", **options):
    (folder / "foam.toml").write_text(TEXTILE.replace("expansion", HEAT + more + "expansion"))
    status, document = press(folder, monkeypatch, **options)
    assert status == 0
    return document


def series(seconds, share=0.5, thick=THICK, capacity=CAPACITY * THICK, resistance=THICK / CONDUCTIVITY):
    k = np.arange(1, 2001, 2)
    decay = np.exp(-((k * np.pi) ** 2) * seconds / (capacity * resistance))
    return 200.0 - 175.0 * np.sum(4.0 / (k * np.pi) * np.sin(k * np.pi * share) * decay)


def test_the_reports_textile_between_plates_is_at_146_69_degrees_after_four_seconds(plates, monkeypatch):
    document = warm(plates, monkeypatch, gap="4.5mm", temperature="200degC", dwell="4s", target="100degC")
    found = document["warming"]
    for key in ("middle_min_degC", "middle_mean_degC", "middle_max_degC"):
        assert found[key] == pytest.approx(146.6937, abs=1e-3)
    assert found["middle_spread_K"] == pytest.approx(0.0, abs=1e-9)
    assert found["start_degC"] == 25.0
    for seconds, low, mean, high in found["over_time"]:
        assert (low, mean, high) == pytest.approx((series(seconds),) * 3, abs=1e-3)
    assert series(found["reached_first_s"]) == pytest.approx(100.0, abs=1e-3)
    assert found["reached_last_s"] == pytest.approx(found["reached_first_s"])
    assert found["reached_fraction"] == pytest.approx(1.0)
    grid = read_vtu((plates / "press.vtu").read_bytes(), "press.vtu")
    assert grid.point_data["middle_degC"] == pytest.approx(146.6937, abs=1e-3)
    assert any("reaction" in line for line in document["left_out"])


def test_the_sample_textile_between_the_sample_plates(tmp_path, monkeypatch):
    for path, data in sample_files().items():
        if path.split("/")[1] in ("plate-male.stl", "plate-female.stl", "textile.toml", "foam.csv"):
            (tmp_path / path.split("/")[1]).write_bytes(data)
    files = {"male": "plate-male.stl", "female": "plate-female.stl", "foam": "textile.toml"}
    _, document = press(tmp_path, monkeypatch, **files, gap="4.5mm", zero="hot", temperature="200degC", dwell="4s")
    assert document["warming"]["middle_mean_degC"] == pytest.approx(146.69, abs=0.005)
    assert document["warming"]["middle_spread_K"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("gap", [1.5, 3.0])
def test_pressed_thinner_it_warms_sooner_though_nothing_of_it_is_lost(plates, monkeypatch, gap):
    """Its mass stays, its resistance falls with the thickness."""
    document = warm(plates, monkeypatch, gap=f"{gap}mm", temperature="200degC", dwell="1.5s")
    exact = series(1.5, resistance=1e-3 * gap / CONDUCTIVITY)
    assert document["warming"]["middle_mean_degC"] == pytest.approx(exact, abs=1e-3)


def test_two_molds_of_their_own_temperature_and_an_open_gap_come_to_rest_as_ohm_says(plates, monkeypatch):
    (plates / "cold.json").write_text(_heat(60.0))
    (plates / "hot.json").write_text(_heat(200.0))
    document = warm(
        plates, monkeypatch, 'contact_conductance = "250 W/m^2/K"\n', gap="6mm", male_heat="hot.json",
        female_heat="cold.json", dwell="3h",
    )  # fmt: skip
    air = np.interp(130.0, [126.85, 176.85], [0.0338, 0.0373])
    foam, contact = THICK / CONDUCTIVITY, 1.0 / 250.0
    exact = 200.0 - 140.0 * (contact + 0.5 * foam) / (foam + 2.0 * contact + 1.5e-3 / air)
    assert document["warming"]["middle_mean_degC"] == pytest.approx(exact, abs=1e-3)


def test_contact_conducts_by_its_table_of_pressure(plates, monkeypatch):
    (plates / "contact.csv").write_text("pressure [kPa],conductance [W/m^2/K]\n0,50\n20,450\n40,500\n")
    pressure = 0.05 * 0.2  # MPa in a gap of 3.6 mm
    document = warm(
        plates, monkeypatch, 'contact_conductance = { table = "contact.csv" }\n', gap="3.6mm",
        temperature="200degC", dwell="6s",
    )  # fmt: skip
    assert document["pressure_max_MPa"] == pytest.approx(pressure)
    constant = warm(
        plates, monkeypatch, 'contact_conductance = "250 W/m^2/K"\n', gap="3.6mm", temperature="200degC",
        dwell="6s",
    )  # fmt: skip
    by_table, by_number = (np.array(one["warming"]["over_time"]) for one in (document, constant))
    assert by_table == pytest.approx(by_number, abs=1e-9)
    entry = next(one for one in document["validity"] if one["of"] == "contact_conductance")
    assert entry["within"] is True
    assert entry["known"] == [0.0, pytest.approx(0.04)]


def test_fabrics_carry_heat_of_their_own(plates, monkeypatch):
    """Fabrics without resistance leave the foam's series; they are counted with it where nothing is told of them."""
    fabric = 'fabric = { above = "0.5 mm", below = "0.5 mm"%s }\n'
    options = {"gap": "4.5mm", "temperature": "200degC", "dwell": "4s"}
    thin = warm(plates, monkeypatch, fabric % ', conductivity = "1e6 W/m/K"', **{**options, "gap": "5.5mm"})
    assert thin["warming"]["middle_mean_degC"] == pytest.approx(series(4.0), abs=1e-2)
    whole = warm(plates, monkeypatch, fabric % "", **{**options, "gap": "5.5mm"})
    exact = series(4.0, capacity=CAPACITY * 5.5e-3, resistance=5.5e-3 / CONDUCTIVITY)
    assert whole["warming"]["middle_mean_degC"] == pytest.approx(exact, abs=1e-3)


def test_the_dwell_is_that_of_relaxation_and_shrinkage_too(plates, monkeypatch):
    more = 'relaxation = { share = 0.4, time = "5 s", dwell = "1 h" }\n'
    document = warm(plates, monkeypatch, more, gap="3mm", dwell="5s")
    assert document["foam_relaxation"] == pytest.approx(0.4 * (1.0 - np.exp(-1.0)))


def test_what_the_dwell_needs_is_asked_for(plates, monkeypatch):
    (plates / "foam.toml").write_text(TEXTILE)
    with pytest.raises(InputError, match="conductivity"):
        press(plates, monkeypatch, gap="3mm", dwell="5s")
    with pytest.raises(UsageError, match="--dwell"):
        press(plates, monkeypatch, gap="3mm", target="150degC")


def _heat(celsius):
    """A heat document without a field: its work surface tells the mold's temperature."""
    at = {"time_s": 0.0, "mean_degC": celsius, "min_degC": celsius, "max_degC": celsius, "spread_K": 0.0}
    return json.dumps({**heat_document("-"), "files": [], "work_surface": {**at, "area_mm2": 1.0, "at_end": at}})
