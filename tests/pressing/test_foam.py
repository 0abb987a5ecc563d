"""Compression laws: no stress at rest, energy as its integral, slope as its derivative; and the sandwich's states."""

import numpy as np
import pytest

from hyperfab.pressing import foam_law
from hyperfab.pressing.clip import positive_part
from hyperfab.pressing.sandwich import Sandwich, State

LAWS = {
    "linear": foam_law.linear(0.05),
    "table": foam_law.table([0.0, 0.1, 0.5, 0.8], [0.0, 0.004, 0.006, 0.03]),
    "plateau": foam_law.plateau(0.0045, 0.12, 0.0016, 2.0),
    "plateau with a power": foam_law.plateau(0.0045, 0.12, 0.0016, 1.7),
    "hyperfoam": foam_law.hyperfoam([0.018, 0.001], [17.0, -3.0], [0.0, 0.1]),
}


@pytest.fixture(params=LAWS.values(), ids=LAWS)
def law(request):
    return request.param


def test_no_stress_and_no_energy_at_rest_or_in_tension(law):
    assert law.stress([-0.5, 0.0]) == pytest.approx(0.0, abs=1e-15)
    assert law.energy([-0.5, 0.0]) == pytest.approx(0.0, abs=1e-15)


def test_stress_never_falls_and_goes_on_beyond_the_limit(law):
    strain = np.linspace(0.0, law.limit + 0.1, 500)
    assert np.diff(law.stress(strain)).min() >= 0.0
    assert law.stress(law.limit + 0.05) > law.stress(law.limit)


def test_slope_is_the_derivative_of_the_stress(law):
    strain = np.linspace(0.03, law.limit + 0.04, 23)
    difference = (law.stress(strain + 1e-6) - law.stress(strain - 1e-6)) / 2e-6
    assert law.slope(strain) == pytest.approx(difference, rel=1e-4)


def test_energy_is_the_integral_of_the_stress(law):
    for end in (0.05, 0.4, law.limit, law.limit + 0.03):
        nodes = np.linspace(0.0, end, 20001)
        stress = law.stress(nodes)
        work = (stress[1:] + stress[:-1]).sum() / 2.0 * end / 20000
        assert law.energy(end) == pytest.approx(work, rel=1e-5)


def test_hyperfoam_starts_with_the_confined_modulus():
    """One term, nu = 0: E = 2 mu; between plates the modulus is 2 mu (1 - nu) / (1 - 2 nu)."""
    for nu in (0.0, 0.2):
        law = foam_law.hyperfoam(0.03, 6.0, nu)
        assert law.slope(1e-9) == pytest.approx(2 * 0.03 * (1 - nu) / (1 - 2 * nu), rel=1e-6)


@pytest.mark.parametrize(
    ("strain", "stress"),
    [([0.0, 0.2, 0.1], [0.0, 0.1, 0.2]), ([0.0, 0.5], [0.1, 0.0]), ([0.0, 1.0], [0.0, 1.0]), ([0.1], [0.1])],
)
def test_a_table_that_is_no_compression_curve_is_refused(strain, stress):
    with pytest.raises(ValueError):
        foam_law.table(strain, stress)


def test_pressure_and_energy_of_the_sandwich_belong_together():
    sandwich = Sandwich(4.0, 1.0, LAWS["plateau"])
    gap = np.linspace(1.3, 4.9, 40)
    slope = (sandwich.energy(gap + 1e-6) - sandwich.energy(gap - 1e-6)) / 2e-6
    assert -slope == pytest.approx(sandwich.pressure(gap), rel=1e-5)
    assert sandwich.pressure(5.0) == 0.0


def test_states_of_a_point():
    sandwich = Sandwich(4.0, 0.5, LAWS["table"])
    states = sandwich.state([4.6, 4.4, 1.29, 0.3, -0.1])
    assert states.tolist() == [State.OPEN, State.TOUCHING, State.BOTTOMED, State.BOTTOMED, State.INTERFERING]


def test_clipped_triangles_give_area_and_integrals_of_polynomials_exactly():
    """Level x - a on a unit square of two triangles: area 1 - a, integral of (x - a)^2 is (1 - a)^3 / 3."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    for a in (-0.5, 0.0, 0.3, 0.75, 1.0):
        part = positive_part(points[:, 0] - a, faces, np.array([0.5, 0.5]))
        x = part.at_corners(faces, points[:, 0])
        low = max(a, 0.0)
        assert part.area.sum() == pytest.approx(1.0 - low, abs=1e-14)
        exact = ((1.0 - a) ** 3 - (low - a) ** 3) / 3.0
        assert (part.area * (x - a) ** 2).sum() == pytest.approx(exact, abs=1e-14)
