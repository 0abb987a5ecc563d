"""hf press-contact where molds and foam are not equally hot: the foam's law at the temperature of each place."""

import json

import numpy as np
import pytest

from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu import unstructured

from .test_press_contact import block, heat_document, press
from .test_press_dwell import HEAT, series

AREA, THICK = 80.0 * 80.0, 4.0
HEAD = 'format = "hyperfab.foam/1"\nthickness = "4 mm"\nexpansion = { male = "0 1/K", female = "0 1/K", reference = "25 degC" }\n'  # noqa: E501
#: Softest half way: the mean of the stiffness is not the stiffness at the mean.
AT, MODULUS = (20.0, 100.0, 180.0), (0.05, 0.02, 0.03)
ROWS = [
    f'{{ law = "linear", modulus = "{m} MPa", temperature = "{t} degC" }}' for t, m in zip(AT, MODULUS, strict=True)
]
LAWS = f"compression = [{', '.join(ROWS)}]\n"


@pytest.fixture
def plates(tmp_path):
    """Plates with a field of temperature each: ``set_heat(male, female)`` gives them as functions of x [mm]."""
    meshes = {}
    for name, low, high in (("male", -20.0, 0.0), ("female", 10.0, 30.0)):
        points, _, outer = meshes[name] = block(low, high)
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(points, outer))

    def set_heat(**fields):
        for name, field in fields.items():
            points, tets, _ = meshes[name]
            celsius = np.asarray(field(points[:, 0]), dtype=float) + np.zeros(len(points))
            grid = unstructured(points, {"tetra10": tets}, {"temperature_degC": celsius})
            (tmp_path / f"{name}-heat.vtu").write_bytes(grid)
            (tmp_path / f"{name}-heat.json").write_text(json.dumps(heat_document(f"{name}-heat.vtu")))
        return tmp_path

    return set_heat


def pressed(folder, monkeypatch, text, **options):
    (folder / "foam.toml").write_text(HEAD + text)
    heat = {} if "temperature" in options else {f"{m}_heat": f"{m}-heat.json" for m in ("male", "female")}
    return press(folder, monkeypatch, **{**heat, "gap": "3mm", "strokes": 2, **options})[1]


def stiffness(celsius):
    return np.interp(celsius, AT, MODULUS)


def over_the_plate(value):
    """Mean and first moment over x of a function that is straight between knots every 10 mm."""
    x = np.linspace(-40.0, 40.0, 6401)
    weights = np.full(len(x), 1.0 / 6400)
    weights[[0, -1]] *= 0.5
    return weights @ value(x), weights @ (x * value(x))


@pytest.mark.parametrize(
    ("male", "female"),
    [
        (lambda x: 100.0 + 2.0 * x, lambda x: 100.0 + 2.0 * x),
        (lambda x: 100.0 + 2.0 * x, lambda x: 100.0),
        (lambda x: np.where(x < 0.0, 20.0, 180.0), lambda x: np.where(x < 0.0, 20.0, 180.0)),
    ],
)
def test_each_place_presses_by_the_law_of_its_temperature(plates, monkeypatch, male, female):
    document = pressed(plates(male=male, female=female), monkeypatch, LAWS)
    if male(1.0) == 180.0:  # of two temperatures: between the nodes beside the middle it goes over in a line
        male = female = lambda x: np.interp(x, [-10.0, 0.0], [20.0, 180.0])
    mean, moment = over_the_plate(lambda x: stiffness(0.5 * (male(x) + female(x))))
    assert mean != pytest.approx(stiffness(100.0), rel=0.1)
    tolerance = 1e-9 if male(-5.0) == 90.0 else 2e-2
    assert document["force_N"] == pytest.approx(mean * 0.25 * AREA, rel=max(tolerance, 1e-7))
    assert document["centre_of_pressure_mm"][0] == pytest.approx(moment / mean, abs=max(50 * tolerance, 1e-6))
    entry = next(one for one in document["validity"] if one["of"] == "compression")
    assert entry["known"] == [20.0, 180.0]


def test_an_even_field_presses_as_one_temperature(plates, monkeypatch):
    folder = plates(male=lambda x: 131.0, female=lambda x: 131.0)
    for more in ("", 'fabric = { above = "1 mm", compression = { law = "linear", modulus = "0.2 MPa" } }\n'):
        field = pressed(folder, monkeypatch, LAWS + more)
        even = pressed(folder, monkeypatch, LAWS + more, temperature="131degC")
        for key in ("force_N", "energy_J", "pressure_max_MPa", "contact_area_mm2"):
            assert field[key] == pytest.approx(even[key], rel=1e-9)


def test_soft_fabric_and_foam_share_the_closing_at_each_place(plates, monkeypatch):
    fabric = 'fabric = { above = "1 mm", compression = { law = "linear", modulus = "0.2 MPa" } }\n'
    hot = lambda x: 100.0 + 2.0 * x  # noqa: E731
    folder = plates(male=hot, female=hot)
    document = pressed(folder, monkeypatch, LAWS + fabric, gap="4mm")
    fine, _ = over_the_plate(lambda x: 1.0 / (THICK / stiffness(hot(x)) + 1.0 / 0.2))
    # Six points a facet of 20 mm, over which the stiffness is curved.
    assert document["force_N"] == pytest.approx(fine * AREA, rel=1e-4)
    assert document["energy_J"] == pytest.approx(0.5e-3 * document["force_N"], rel=1e-9)


def test_the_position_is_found_for_a_force(plates, monkeypatch):
    hot = lambda x: 100.0 + 2.0 * x  # noqa: E731
    folder = plates(male=hot, female=hot)
    force = over_the_plate(lambda x: stiffness(hot(x)))[0] * 0.25 * AREA
    found = pressed(folder, monkeypatch, LAWS, gap=None, force=f"{float(force)!r}N")
    assert found["gap_min_mm"] == pytest.approx(3.0, abs=1e-6)


@pytest.mark.parametrize("seconds", [1.0, 4.0, 400.0])
def test_with_a_dwell_it_is_the_law_of_the_foams_middle(plates, monkeypatch, seconds):
    """A slab whose middle is known by its series, pressed by 25 %."""
    folder = plates()
    rows = [
        f'{{ law = "linear", modulus = "{m} MPa", temperature = "{t} degC" }}' for t, m in ((25, 0.05), (200, 0.03))
    ]
    document = pressed(
        folder,
        monkeypatch,
        f"compression = [{', '.join(rows)}]\n{HEAT}",
        temperature="200degC",
        dwell=f"{seconds}s",
    )
    middle = series(seconds, thick=3e-3, capacity=30.0 * 1045.0 * 4e-3, resistance=3e-3 / 0.023)
    assert document["warming"]["middle_mean_degC"] == pytest.approx(middle, abs=1e-4)
    modulus = np.interp(middle, [25.0, 200.0], [0.05, 0.03])
    assert document["force_N"] == pytest.approx(modulus * 0.25 * AREA, rel=1e-6)
