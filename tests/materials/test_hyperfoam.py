"""The hyperfoam law: closed forms of its tests, its energy, its stability, and constants from tests."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from hyperfab.curve import TestCurve
from hyperfab.materials.hyperfoam import TESTS, Hyperfoam, Rows
from hyperfab.materials.identification.hyperfoam import _Sought, identify
from hyperfab.pressing import foam_law

MIXED = Hyperfoam((0.1, 0.05, -0.01), (8.0, -2.0, 3.0), (0.1, 0.3, 0.2))
ALIKE = Hyperfoam((0.1, 0.05), (8.0, -2.0), (0.23, 0.23))
LAM = np.linspace(0.45, 1.5, 22)


def energy(law: Hyperfoam, l1: float, l2: float, l3: float) -> float:
    """The energy as the source writes it."""
    J = l1 * l2 * l3
    return sum(
        2.0 * mu / a**2 * (l1**a + l2**a + l3**a - 3.0 + (J ** (-a * nu / (1 - 2 * nu)) - 1.0) * (1 - 2 * nu) / nu)
        for mu, a, nu in zip(law.mu, law.alpha, law.nu, strict=True)
    )


def closed(law: Hyperfoam, along: float, volume: float) -> np.ndarray:
    """Nominal stress where all terms have one Poisson's ratio: each a difference of two powers of the stretch."""
    return sum(
        2.0 * mu / a * (LAM ** (a * along) - LAM ** (-a * volume)) / LAM
        for mu, a in zip(law.mu, law.alpha, strict=True)
    )


def test_four_tests_have_their_closed_forms() -> None:
    nu = 0.23
    assert ALIKE.stress("uniaxial", LAM) == pytest.approx(closed(ALIKE, 1.0, nu), rel=1e-10, abs=1e-13)
    assert ALIKE.lateral("uniaxial", LAM) == pytest.approx(LAM**-nu, rel=1e-12)
    both = closed(ALIKE, 1.0, 2 * nu / (1 - nu))
    assert ALIKE.stress("biaxial", LAM) == pytest.approx(both, rel=1e-10, abs=1e-13)
    wide = closed(ALIKE, 1.0, nu / (1 - nu))
    assert ALIKE.stress("shear", LAM) == pytest.approx(wide, rel=1e-10, abs=1e-13)
    plates = foam_law.hyperfoam(MIXED.mu, MIXED.alpha, MIXED.nu)
    strain = np.linspace(0.0, 0.6, 13)
    pressed = MIXED.stress("confined-compression", 1.0 - strain)
    assert -pressed == pytest.approx(plates.stress(strain), rel=1e-10, abs=1e-14)
    # Simple shear keeps the volume: principal stretches L and 1/L with shear strain L - 1/L.
    L = np.linspace(1.0, 1.4, 9)
    slope = sum(2 * m / a * (L**a - L**-a) for m, a in zip(MIXED.mu, MIXED.alpha, strict=True)) / (L + 1 / L)
    assert MIXED.stress("simple-shear", L - 1 / L) == pytest.approx(slope, rel=1e-10, abs=1e-14)
    assert MIXED.stress("simple-shear", 1 / L - L) == pytest.approx(-slope, rel=1e-10, abs=1e-14)


@pytest.mark.parametrize(("alpha", "nu"), [(25.0, 0.45), (-25.0, 0.45), (3.6, 0.49), (10.0, -0.5)])
def test_one_term_contracts_by_poissons_ratio_however_far_it_is_stretched(alpha: float, nu: float) -> None:
    stretch = np.array([0.1, 0.3, 2.0, 8.0])
    found = Hyperfoam((0.01,), (alpha,), (nu,)).lateral("uniaxial", stretch)
    assert found == pytest.approx(stretch**-nu, rel=1e-12)


@pytest.mark.parametrize("stretch", [0.5, 0.9, 1.3])
def test_free_sides_take_the_least_energy_and_the_stress_is_its_slope(stretch: float) -> None:
    def least(l1: float) -> float:
        found = minimize(lambda t: energy(MIXED, l1, np.exp(t[0]), np.exp(t[0])), [0.0], tol=1e-15)
        return float(found.fun)

    h = 1e-4
    slope = (least(stretch + h) - least(stretch - h)) / (2 * h)
    assert float(MIXED.stress("uniaxial", [stretch])[0]) == pytest.approx(slope, rel=1e-6)
    J = stretch
    mean = (energy(MIXED, *[(J + h) ** (1 / 3)] * 3) - energy(MIXED, *[(J - h) ** (1 / 3)] * 3)) / (2 * h)
    assert float(MIXED.stress("volumetric", [J])[0]) == pytest.approx(mean, rel=1e-6)


def test_at_rest_it_is_hookes_law() -> None:
    h = 1e-7
    modulus = float(ALIKE.stress("uniaxial", [1.0 + h])[0]) / h
    assert modulus == pytest.approx(2.0 * 0.15 * (1.0 + 0.23), rel=1e-5)
    assert float(ALIKE.stress("simple-shear", [h])[0]) / h == pytest.approx(0.15, rel=1e-6)


@pytest.mark.parametrize("test", TESTS)
def test_slopes_by_constants_are_those_of_differences(test: str) -> None:
    stretch = np.array([-0.3, 0.1, 0.5]) if test == "simple-shear" else np.array([0.6, 0.9, 1.3])
    rows = Rows.of(test, stretch, 0.9 * stretch[::-1])
    z = np.array([MIXED.mu, MIXED.alpha, MIXED.nu])
    slopes, moved = rows.slopes(MIXED, rows.strain(MIXED))
    for k in range(z.size):
        step = np.zeros(z.size)
        step[k] = 1e-6
        up, down = (Hyperfoam(*map(tuple, z + sign * step.reshape(z.shape))) for sign in (1.0, -1.0))
        difference = (rows.stress(up, rows.strain(up)) - rows.stress(down, rows.strain(down))) / 2e-6
        assert slopes[:, k] == pytest.approx(difference, abs=1e-9)
        free = (rows.strain(up) - rows.strain(down))[:, 2] / 2e-6
        assert moved[:, k] == pytest.approx(free if rows.free.any() else 0.0, abs=1e-8)


def test_stable_is_where_every_small_change_needs_work() -> None:
    law = Hyperfoam((0.2, -0.15), (2.0, 6.0), (0.2, 0.2))
    e = np.array([[0.0, 0.0, 0.0], [0.3, 0.3, 0.3], [-0.02, 0.0, 0.0]])
    directions = np.random.default_rng(4).normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    h = 1e-4
    work = [
        min(float(d @ (law.first(at + h * d)[0] - law.first(at - h * d)[0])) for d in directions) for at in e[:, None]
    ]
    assert law.stable(e).tolist() == [one > 0.0 for one in work] == [True, False, True]


def readings_of(law: Hyperfoam) -> list[TestCurve]:
    found = []
    for test in ("uniaxial", "confined-compression", "simple-shear", "biaxial"):
        stretch = np.linspace(-0.3, 0.3, 40) if test == "simple-shear" else np.linspace(0.4, 1.4, 40)
        stress = law.stress(test, stretch)
        weight = np.full(40, 1.0 / np.abs(stress).max())
        lateral = law.lateral(test, stretch) if test == "uniaxial" else None
        found.append(TestCurve(test, stretch, stress, weight, stretch2=lateral, weight2=np.ones_like(stretch)))
    return found


@pytest.mark.parametrize("terms", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_own_constants_come_back(terms: int) -> None:
    law = Hyperfoam((0.1, 0.02, 0.05)[:terms], (15.0, 8.0, -2.0)[:terms], (0.1, 0.2, 0.3)[:terms])
    found = identify(readings_of(law), terms)
    for name in ("mu", "alpha", "nu"):
        assert getattr(found, name) == pytest.approx(getattr(law, name), rel=1e-6)


def test_stresses_alone_are_found_beside_known_exponents() -> None:
    law = Hyperfoam((0.06, 0.03), (8.0, -2.0), (0.2, 0.3))
    found = identify(readings_of(law), 2, near=Hyperfoam((0.1, 0.02), law.alpha, law.nu))
    assert found.mu == pytest.approx(law.mu, rel=1e-9)
    assert (found.alpha, found.nu) == (law.alpha, law.nu)


@pytest.mark.parametrize(("toe", "dense", "slope", "width"), [(0.04, 0.5, 0.08, 0.05), (0.05, 0.5, 0.12, 0.05)])
def test_a_foam_with_a_soft_toe_has_a_state_of_rest(toe, dense, slope, width):
    """Two terms had a negative bulk modulus there, where no reading stands, or a ratio at the end of its range."""
    stretch = np.linspace(0.4, 0.99, 30)
    strain = 1.0 - stretch
    stress = -(toe * (1.0 - np.exp(-((strain / width) ** 2))) + dense * strain**3 + slope * strain)
    law = identify([TestCurve("uniaxial", stretch, stress, np.full(30, 1.0 / np.abs(stress).max()))], 2)
    assert law.stable(np.zeros((1, 3))).all()
    assert law.bulk_modulus > 0.0
    assert min(law.nu) > -0.89


@pytest.mark.slow
def test_an_auxetic_foam_of_one_term_is_found():
    """It widens where it is pulled: a negative Poisson's ratio, by stresses and by the measured lateral stretch."""
    truth = Hyperfoam((0.05,), (2.0,), (-0.25,))
    stretch = np.concatenate([np.linspace(0.5, 0.97, 12), np.linspace(1.03, 1.3, 8)])
    stress = truth.stress("uniaxial", stretch)
    weight, across = np.full(20, 1.0 / np.abs(stress).max()), truth.lateral("uniaxial", stretch)
    for more in ({}, {"stretch2": across, "weight2": np.ones(20)}):
        found = identify([TestCurve("uniaxial", stretch, stress, weight, **more)], 1)
        assert found.parameters == pytest.approx(truth.parameters, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4, 5])
def test_a_term_more_never_carries_the_tests_worse(seed: int) -> None:
    """Of a plateau with tension, or with shear, three terms drawn at random ended above the best of two."""
    drawn = np.random.default_rng(seed)
    noise, toe, bend, dense = drawn.choice([0.003, 0.01, 0.03]), *drawn.uniform((0.02, 0.5, 1.0), (0.12, 2.0, 8.0))
    e, t = np.linspace(0.0, 0.6, 17)[1:], np.linspace(0.0, 0.6, 17)[1:]
    pressed = 0.01 * np.tanh(e / toe) * (1.0 + bend * e) + 0.01 * dense * e**3 / (1.0 - e)
    other = ("simple-shear", t, 0.003 / toe * t / (1.0 + 0.5 * t))
    if seed % 2 == 0:
        other = ("uniaxial", 1.0 + t, 0.01 / toe * t / (1.0 + bend * t))
    tests = []
    for test, stretch, stress in (("uniaxial", 1.0 - e, -pressed), other):
        read = stress * (1.0 + noise * drawn.standard_normal(16))
        tests.append(TestCurve(test, stretch, read, np.full(16, 0.25 / np.abs(stress).max())))
    one, two, three = (float(np.sum(_Sought(tests, k).equations(identify(tests, k))[0] ** 2)) for k in (1, 2, 3))
    assert one >= two >= three
