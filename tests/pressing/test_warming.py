"""The sandwich between two warm molds: exact slabs, and three layers against an independent march in time."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from hyperfab.pressing.warming import Column

#: The report's textile: W/m/K, kg/m^3, J/kg/K, m.
CONDUCTIVITY, DENSITY, HEAT, THICK = 0.023, 30.0, 1045.0, 4.5e-3


def column(male=200.0, female=200.0, contact=(0.0, 0.0), fabric=(0.0, 0.0), n=1):
    """Foam of the report's textile, fabrics of another conductivity and mass on both sides (thickness in m)."""
    rows = (np.array([fabric[0], THICK, fabric[1]])[:, None], np.ones((1, n)))
    conductivity = np.array([0.05, CONDUCTIVITY, 0.08])[:, None]
    mass = np.array([300.0 * 1400.0, DENSITY * HEAT, 500.0 * 1200.0])[:, None]
    return Column(
        25.0, np.full(n, male), np.full(n, female), np.outer(contact, np.ones(n)),
        rows[0] / conductivity @ rows[1], rows[0] * mass @ rows[1],
    )  # fmt: skip


@pytest.mark.parametrize("seconds", [0.01, 0.3, 1.0, 4.0, 13.6, 60.0])
@pytest.mark.parametrize("share", [0.05, 0.25, 0.5, 0.9])
def test_a_slab_between_held_faces_is_its_series(seconds, share):
    k = np.arange(1, 4001, 2)
    decay = np.exp(-((k * np.pi / THICK) ** 2) * CONDUCTIVITY / (DENSITY * HEAT) * seconds)
    exact = 200.0 - 175.0 * np.sum(4.0 / (k * np.pi) * np.sin(k * np.pi * share) * decay)
    assert column().at(seconds, share)[0] == pytest.approx(exact, abs=1e-6 * 175.0)


def test_the_reports_textile_after_four_seconds():
    assert column().at(4.0)[0] == pytest.approx(146.69373, abs=1e-4)


@pytest.mark.parametrize(
    ("biot", "fourier", "centre", "surface"),
    [
        (0.1, 1.0, 0.9223885716, 0.878126487609),
        (1.0, 1.0, 0.533859401409, 0.348176851662),
        (10.0, 0.5, 0.454640555613, 0.0643289552713),
    ],
)
def test_a_slab_behind_two_contact_resistances(biot, fourier, centre, surface):
    half = 0.5 * THICK
    resistance = half / CONDUCTIVITY / biot
    seconds = fourier * half**2 * DENSITY * HEAT / CONDUCTIVITY
    sandwich = column(contact=(resistance, resistance))
    for share, theta in ((0.5, centre), (0.0, surface), (1.0, surface)):
        assert (200.0 - sandwich.at(seconds, share)[0]) / 175.0 == pytest.approx(theta, abs=1e-6)


def test_two_plates_of_their_own_temperature_and_conductance_come_to_rest_where_ohm_says():
    sandwich = column(210.0, 90.0, contact=(0.02, 0.31), fabric=(0.5e-3, 0.8e-3))
    before = 0.02 + 0.5e-3 / 0.05
    whole = before + THICK / CONDUCTIVITY + 0.8e-3 / 0.08 + 0.31
    for share in (0.0, 0.3, 1.0):
        exact = 210.0 - 120.0 * (before + share * THICK / CONDUCTIVITY) / whole
        assert sandwich.at(1e7, share)[0] == pytest.approx(exact, abs=1e-4)


def test_one_sided_contact_follows_its_series():
    """One face held, the other behind a resistance: tan b = -b / Bi."""
    biot = 2.5
    sandwich = column(200.0, 25.0, contact=(0.0, THICK / CONDUCTIVITY / biot))
    roots = [brentq(lambda b: b * np.cos(b) + biot * np.sin(b), (k - 0.5) * np.pi, k * np.pi) for k in range(1, 60)]
    b, x = np.array(roots), 0.5
    steady = 1.0 - biot / (1.0 + biot) * x
    for fourier in (0.05, 0.2, 1.0):
        seconds = fourier * THICK**2 * DENSITY * HEAT / CONDUCTIVITY
        amplitude = -2.0 * (b**2 + biot**2) / (b * (b**2 + biot**2 + biot))
        theta = steady + np.sum(amplitude * np.sin(b * x) * np.exp(-(b**2) * fourier))
        assert (sandwich.at(seconds)[0] - 25.0) / 175.0 == pytest.approx(theta, abs=1e-6)


def test_three_layers_against_a_fine_march():
    """Finite volumes of 240 cells, exact in time, on layers of unlike conductivity and mass behind unlike contacts."""
    fabric, contact = (0.6e-3, 0.9e-3), (0.004, 0.02)
    sandwich = column(205.0, 150.0, contact, fabric)
    cells = (40, 160, 40)
    width = np.concatenate([np.full(n, d / n) for n, d in zip(cells, (fabric[0], THICK, fabric[1]), strict=True)])
    k = np.repeat([0.05, CONDUCTIVITY, 0.08], cells)
    c = np.repeat([300.0 * 1400.0, DENSITY * HEAT, 500.0 * 1200.0], cells) * width
    between = 0.5 * width / k
    conduct = 1.0 / np.concatenate([[contact[0] + between[0]], between[:-1] + between[1:], [contact[1] + between[-1]]])
    system = np.diag(-(conduct[:-1] + conduct[1:])) + np.diag(conduct[1:-1], 1) + np.diag(conduct[1:-1], -1)
    system /= c[:, None]
    source = np.zeros(len(c))
    source[0], source[-1] = conduct[0] * 180.0 / c[0], conduct[-1] * 125.0 / c[-1]
    rest = -np.linalg.solve(system, source)
    for seconds in (1.0, 5.0, 20.0):
        found = 25.0 + rest - expm(system * seconds) @ rest
        # The middle of the foam is a border of cells.
        middle = 0.5 * (found[119] + found[120])
        assert sandwich.at(seconds)[0] == pytest.approx(middle, abs=0.01)


@pytest.mark.parametrize("shares", [[0.1, 0.5, 0.9], [0.0, 0.3, 0.4, 1.0]])
@pytest.mark.parametrize("fabric", [(0.0, 0.0), (5e-4, 3e-4)])
def test_depths_told_together_are_each_told_alone(shares, fabric):
    sandwich, times = column(220.0, 180.0, (1e-3, 0.0), fabric, n=3), np.array([0.0, 0.05, 4.0, 60.0])
    together = sandwich.at_depths(times, np.array(shares))
    assert together.shape == (len(shares), 4, 3)
    for found, share in zip(together, shares, strict=True):
        np.testing.assert_allclose(found, sandwich.at(times, share), rtol=0, atol=1e-10)


def test_a_target_is_reached_when_the_temperature_says_so():
    sandwich = column(male=np.nan, n=3)
    sandwich = Column(25.0, np.array([200.0, 180.0, 120.0]), np.array([200.0, 200.0, 120.0]), *(
        getattr(sandwich, name) for name in ("contact", "resistance", "capacity")
    ))  # fmt: skip
    found = sandwich.reaches(150.0, 60.0)
    assert np.isnan(found[2])
    assert found[0] < found[1]
    assert np.diag(sandwich.at(found[:2]))[:2] == pytest.approx(150.0, abs=1e-4)
    cooled = Column(200.0, *(np.full(1, 25.0) for _ in range(2)), np.zeros((2, 1)), *(
        getattr(sandwich, name)[:, :1] for name in ("resistance", "capacity")
    ))  # fmt: skip
    assert cooled.reaches(78.30627, 60.0)[0] == pytest.approx(4.0, abs=1e-4)


def test_places_do_not_feel_each_other_nor_how_they_are_shared_out(monkeypatch):
    many = column(n=5000)
    monkeypatch.setenv("HYPERFAB_THREADS", "1")
    alone = many.at([0.5, 4.0])
    monkeypatch.setenv("HYPERFAB_THREADS", "2")
    assert (many.at([0.5, 4.0]) == alone).all()
    assert (alone == alone[:, :1]).all()
