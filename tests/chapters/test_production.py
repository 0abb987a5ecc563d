"""Pieces laid in a hot mold and taken out: closed forms of lumps and slabs, the account of heat, two starts."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from hyperfab.errors import InputError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from tests.chapters.test_mold_heat import FILM, HEAD, HEATER, PROBE, heat
from tests.chapters.test_press_contact import FOAM, press

AREA = 0.1 * 0.08
#: A thousand times the conductivity of metals costs the account of heat three of its digits to rounding.
BALANCED = 1e-9
#: As good as uniform at all times: what is left is the exchange between the two.
STUFF = """
[material.even]
density = "1000 kg/m^3"
conductivity = "1e6 W/m/K"
specific_heat = "1000 J/kg/K"
[material.foam]
density = "100 kg/m^3"
conductivity = "0.05 W/m/K"
specific_heat = "1500 J/kg/K"
"""
PIECE = """
[production]
period = "50 s"
in = "30 s"
temperature = "20 degC"
h = "400 W/m^2/K"
layers = [ { material = "even", thickness = "2 mm" } ]
"""


def mold(more: str, start: float = 200.0, tolerance: str = "1 mK", size: str = "50 mm") -> str:
    run = f'\n[run]\nstart = "{start} degC"\nmesh_size = "{size}"\ntolerance = "{tolerance}"\n'
    return HEAD.replace('"237 W/m/K"', '"1e6 W/m/K"') + STUFF + PROBE + more + run


MOLD_CAPACITY, PIECE_CAPACITY = AREA * 0.02 * 2702.0 * 903.0, AREA * 0.002 * 1e6


def test_two_bodies_share_their_heat_as_they_do_in_closed_form(tmp_path):
    status, document, _ = heat(tmp_path, mold(PIECE + "pieces = 3\n"))
    assert status == 0
    rate = AREA * 400.0 * (1 / MOLD_CAPACITY + 1 / PIECE_CAPACITY)
    surface, drawn = 200.0, []
    for _ in range(3):
        both = (MOLD_CAPACITY * surface + PIECE_CAPACITY * 20.0) / (MOLD_CAPACITY + PIECE_CAPACITY)
        after = both + (surface - both) * np.exp(-rate * 30.0)
        drawn.append(MOLD_CAPACITY * (surface - after))
        surface = after
    made = document["production"]
    assert made["pieces"] == 3
    assert made["area_mm2"] == pytest.approx(AREA * 1e6, rel=1e-9)
    assert made["last"]["heat_from_mold_J"] == pytest.approx(drawn[-1], rel=1e-4)
    assert made["last"]["dip_K"] == pytest.approx(drawn[-1] / MOLD_CAPACITY, rel=2e-4)
    assert document["work_surface"]["mean_degC"] == pytest.approx(surface, abs=2e-3)
    assert made["power_to_hold_W"] == pytest.approx(drawn[-1] / 50.0, rel=1e-4)
    energy = document["energy"]
    assert energy["imbalance_relative"] < BALANCED
    assert energy["by_condition_J"]["pieces taken out"] == pytest.approx(-sum(drawn), rel=1e-4)
    assert document["heat_capacity_J_K"] == pytest.approx(MOLD_CAPACITY, rel=1e-9)


def periodic(power: float) -> tuple[float, float]:
    """Return the temperature of a light mold when a piece is due, and the heat each takes, from two linear systems."""
    light = MOLD_CAPACITY / 10
    film = 12.0 * 2 * 0.02 * 0.18  # the sides; below is the heater, and the top is bare between pieces
    joint, top = AREA * 400.0, 12.0 * AREA
    closed = np.array([[-(film + joint) / light, joint / light, 0.0],
                       [joint / PIECE_CAPACITY, -joint / PIECE_CAPACITY, 0.0], [0.0, 0.0, 0.0]])  # fmt: skip
    closed[0, 2] = (power + film * 25.0) / light
    bare = np.array([[-(film + top) / light, (power + (film + top) * 25.0) / light], [0, 0]])

    def cycle(at: float) -> tuple[float, float]:
        mold, piece, _ = expm(30.0 * closed) @ [at, 20.0, 1.0]
        return float((expm(20.0 * bare) @ [mold, 1.0])[0]), PIECE_CAPACITY * (piece - 20.0)

    at = brentq(lambda t: cycle(t)[0] - t, 20.0, 500.0, xtol=1e-12)
    return at, cycle(at)[1]


@pytest.mark.slow
def test_a_production_comes_round_to_the_same_from_above_and_below(tmp_path):
    exact, taken = periodic(100.0)
    text = PIECE + HEATER.replace("400 W", "100 W") + FILM
    for start in (exact - 30.0, exact + 30.0):
        _, document, _ = heat(tmp_path, mold(text, start).replace("2702 kg", "270.2 kg"))
        made = document["production"]
        assert made["came_round"]
        assert document["work_surface"]["mean_degC"] == pytest.approx(exact, abs=5e-3)
        assert made["last"]["heat_from_mold_J"] == pytest.approx(taken, rel=2e-4)
        assert made["power_W"] == pytest.approx(100.0, rel=1e-12)
        assert made["power_to_hold_W"] == pytest.approx(100.0, rel=1e-4)
        assert document["energy"]["imbalance_relative"] < BALANCED


def test_a_piece_of_foam_warms_as_the_slab_of_the_series_does(tmp_path):
    """One face in contact, the other insulated: the roots of b tan b = Bi (Carslaw and Jaeger, 3.11)."""
    foam = PIECE.replace('"even", thickness = "2 mm"', '"foam", thickness = "4 mm"').replace("30 s", "15 s")
    _, document, _ = heat(tmp_path, mold(foam + "pieces = 1\n").replace("2702 kg", "2.7e6 kg"))
    biot, fourier = 400.0 * 0.004 / 0.05, 0.05 / 1.5e5 * 15.0 / 0.004**2
    share = 1.0
    for i in range(40):
        b = brentq(lambda x: x * np.sin(x) - biot * np.cos(x), i * np.pi, (i + 0.5) * np.pi)
        share -= 2 * biot**2 / (b**2 * (biot**2 + biot + b**2)) * np.exp(-(b**2) * fourier)
    last = document["production"]["last"]
    assert last["taken_out_degC"] == pytest.approx(20.0 + 180.0 * share, abs=0.1)
    assert last["heat_from_mold_J"] == pytest.approx(AREA * 0.004 * 1.5e5 * 180.0 * share, rel=2e-3)


def test_a_piece_between_two_molds_conducts_from_one_to_the_other(tmp_path):
    more = 'other = { h = "100 W/m^2/K", temperature = "150 degC" }\npieces = 1\n'
    text = mold(PIECE.replace("30 s", "4000 s").replace("50 s", "5000 s") + more)
    text = text.replace('"even", thickness', '"foam", thickness').replace("2702 kg", "2.7e6 kg")
    _, document, _ = heat(tmp_path, text)
    last = document["production"]["last"]
    resistance = 1 / 400.0 + 0.002 / 0.05 + 1 / 100.0
    through = AREA * 50.0 / resistance * 4000.0
    # What it takes to warm up is 0.2 % of what goes through in that time, and is taken off here.
    stored = AREA * 0.002 * 1.5e5 * (150.0 + 50.0 * (0.01 + 0.02) / resistance - 20.0)
    assert last["heat_from_mold_J"] + last["heat_from_other_J"] == pytest.approx(stored, rel=1e-3)
    assert -last["heat_from_other_J"] == pytest.approx(through, rel=0.01)
    # The piece is cold when it is laid in, and its cells conduct to no node of the mold: they cost no digits.
    assert document["energy"]["imbalance_relative"] < 1e-10


@pytest.mark.slow
def test_the_last_field_is_that_of_closing_and_a_production_begins_from_a_warmup(tmp_path):
    warm = mold(HEATER + FILM, 25.0).replace("[run]", '[run]\ntarget = "180 degC"')
    heat(tmp_path, warm, "warm")
    text = mold(PIECE + HEATER + FILM + "", 25.0).replace(
        'in = "30 s"', 'in = "30 s"\npieces = 2\non = { part = "plate", box = { origin = ["0 mm", "0 mm", "0 mm"], '
        'size = ["50 mm", "80 mm", "20 mm"] } }'
    )  # fmt: skip
    _, document, _ = heat(tmp_path, text.replace('"25.0 degC"', '{ document = "warm.json" }'), "made")
    grid = read_vtu((tmp_path / "made.vtu").read_bytes(), "made.vtu")
    field = grid.point_data["temperature_degC"]
    assert len(grid.points) == len(field) == int(grid.cells["tetra10"].max()) + 1
    assert field.max() == pytest.approx(document["hottest"]["temperature_degC"], abs=1e-9)
    rows = [line.split(",") for line in (tmp_path / "made.pieces.csv").read_text().splitlines()]
    assert rows[0][:4] == ["number", "time_s", "surface_degC", "lowest_degC"]
    assert [row[0] for row in rows[1:]] == ["1", "2"]
    assert float(rows[1][2]) == pytest.approx(180.0, abs=0.01)
    # What it lies on counts, and half of the top and of the bottom is left to the air.
    assert document["production"]["area_mm2"] == pytest.approx(50.0 * (2 * 80.0 + 2 * 20.0) + 80.0 * 20.0, rel=1e-9)
    assert json.loads((tmp_path / "made.json").read_text())["converged"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (mold(PIECE.replace("30 s", "60 s")), "longer than the period"),
        (mold(PIECE).replace("[run]", '[run]\nuntil = "10 s"'), "ends with its pieces"),
        (mold(PIECE.replace('"even"', '"wool"')), r"no .material.; there is"),
        (mold(PIECE.replace("in =", 'on = "plate.q"\nin =')), "names no face"),
        (mold(PIECE).replace("[work_surface]\non", "[work_surface]\n#"), "work_surface"),
        (
            mold(PIECE + HEATER + 'control = { probe = "centre", set = "200 degC", band = "2 K" }\n'),
            "production.pieces",
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        heat(tmp_path, text)


def test_aids_that_know_no_pieces_say_so(tmp_path):
    (tmp_path / "factors.csv").write_text("film [-]\n1\n")
    text = mold(PIECE + HEATER + FILM)
    for options in ({"variations": str(tmp_path / "factors.csv")}, {"share_power": True}):
        with pytest.raises(InputError, match=r"production|pieces"):
            heat(tmp_path, text, **options)


def test_the_press_closes_on_the_mold_as_the_production_leaves_it(tmp_path, monkeypatch):
    """The male's temperature in the press is that of the field when the next piece is due."""
    for name, low in (("male", 0.0), ("female", 30.0)):
        corner, far = np.array([0.0, 0.0, low]), np.array([100.0, 80.0, low + 20.0])
        x, y, z = np.meshgrid(*np.stack([corner, far], axis=1), indexing="ij")
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces))
    (tmp_path / "foam.toml").write_text(FOAM)
    _, made = heat(tmp_path, mold(PIECE + "pieces = 2\n", 180.0), "made")[:2]
    _, document = press(tmp_path, monkeypatch, gap="3mm", male_heat="made.json")
    assert document["male"]["temperature_degC"] == pytest.approx(made["work_surface"]["mean_degC"], abs=0.05)
    assert "heat document, thermoelastic" in document["male"]["temperature_from"]
