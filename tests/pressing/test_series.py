"""Fabrics that give way across: closed forms of two layers, energy, and the limit of rigid fabric."""

import numpy as np
import pytest

from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.pressing import foam_law
from hyperfab.pressing.press import Press
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.pressing.series import together

KNIT = foam_law.table([0.0, 0.1, 0.3, 0.5], [0.0, 0.001, 0.006, 0.05])
FOAMS = {
    "linear": foam_law.linear(0.05),
    "table with a level": foam_law.table([0.0, 0.1, 0.5, 0.8], [0.0, 0.004, 0.004, 0.03]),
    "plateau": foam_law.plateau(0.0045, 0.12, 0.0016),
    "hyperfoam": foam_law.hyperfoam([0.018], [17.0], [0.05]),
}
GAPS = np.linspace(5.2, 0.9, 400)


@pytest.fixture(params=FOAMS.values(), ids=FOAMS)
def sandwich(request):
    return Sandwich(3.5, 1.2, request.param, KNIT)


def test_two_springs_in_a_row():
    both = Sandwich(4.0, 1.0, foam_law.linear(0.02), foam_law.linear(0.01))
    stiffness = 1.0 / (4.0 / 0.02 + 1.0 / 0.01)
    closing = np.array([-0.5, 0.0, 0.3, 1.5])
    pressed = np.maximum(closing, 0.0)
    assert both.pressure(5.0 - closing) == pytest.approx(stiffness * pressed, abs=1e-11)
    assert both.stiffness(5.0 - closing) == pytest.approx(stiffness * (closing > 0.0), rel=1e-6)
    assert both.energy(5.0 - closing) == pytest.approx(0.5 * stiffness * pressed**2, abs=1e-11)
    foam, fabric = both.pressed(5.0 - closing)
    assert foam == pytest.approx(4.0 * (1.0 - stiffness * pressed / 0.02), rel=1e-6)
    assert fabric == pytest.approx(1.0 - stiffness * pressed / 0.01, rel=1e-6)


def test_both_layers_carry_the_pressure_and_share_the_closing(sandwich):
    foam, fabric = sandwich.pressed(GAPS)
    closed = np.minimum(GAPS, sandwich.thickness)
    assert foam + fabric == pytest.approx(closed, abs=1e-9)
    pressure = sandwich.pressure(GAPS)
    for law, strain in ((sandwich.law, 1.0 - foam / 3.5), (KNIT, 1.0 - fabric / 1.2)):
        assert pressure == pytest.approx(law.stress(strain), abs=4e-6 * pressure.max())  # chords


def test_energy_is_the_work_of_the_pressure(sandwich):
    fine = np.linspace(4.9, 0.9, 40_001)
    pressure = sandwich.pressure(fine)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (pressure[1:] + pressure[:-1]) * -np.diff(fine))])
    assert sandwich.energy(fine) == pytest.approx(work, abs=1e-6 * work[-1])


def test_stiffness_is_the_slope_of_the_pressure(sandwich):
    gaps = np.array([4.3, 3.1, 2.2, 1.4])
    slope = (sandwich.pressure(gaps - 1e-7) - sandwich.pressure(gaps + 1e-7)) / 2e-7
    assert sandwich.stiffness(gaps) == pytest.approx(slope, rel=1e-4, abs=1e-9)


def test_stiff_fabric_is_rigid_fabric_in_the_limit(sandwich):
    rigid = Sandwich(3.5, 1.2, sandwich.law)
    stiff = Sandwich(3.5, 1.2, sandwich.law, foam_law.linear(1e9))
    gaps = np.linspace(5.0, 2.2, 50)
    for name in ("pressure", "energy", "strain"):
        exact = getattr(rigid, name)(gaps)
        assert getattr(stiff, name)(gaps) == pytest.approx(exact, abs=3e-6 * exact.max())
    assert Sandwich(3.5, 1.2, sandwich.law, together([(0.6, None), (0.6, None)])).pressure(gaps).tolist() == (
        rigid.pressure(gaps).tolist()
    )


def test_layers_of_a_stack_yield_by_their_share():
    stack = together([(0.4, KNIT), (0.8, foam_law.linear(0.02)), (0.8, None)])
    stress = np.array([0.0005, 0.003, 0.006, 0.015])
    strain = (0.4 * np.interp(stress, [0.0, 0.001, 0.006, 0.05], [0.0, 0.1, 0.3, 0.5]) + 0.8 * stress / 0.02) / 2.0
    assert stack.stress(strain) == pytest.approx(stress, rel=1e-6)


def test_uneven_layers_are_shared_out_place_by_place():
    foam, fabric = np.array([3.5, 2.5, 3.0]), np.array([1.2, 0.9, 0.4])
    uneven = Sandwich(foam, fabric, FOAMS["plateau"], KNIT)
    alone = [Sandwich(a, b, FOAMS["plateau"], KNIT).pressure(2.0).item() for a, b in zip(foam, fabric, strict=True)]
    assert uneven.pressure(np.full(3, 2.0)).tolist() == alone
    assert uneven.of_vertices(np.array([2, 0])).pressure(np.full(2, 2.0)).tolist() == [alone[2], alone[0]]


def test_a_press_with_soft_fabric_stores_the_work_of_its_closing(shapes):
    """Flat plates: force times travel is exact, and the force that of the columns."""
    from hyperfab.pressing.gap import molding_front

    male = shapes.male(*shapes.plate(100.0, 40.0, 8, 4))
    female = shapes.female(*shapes.plate(140.0, 60.0, 5, 3, height=6.0))
    both = Sandwich(4.0, 1.0, foam_law.linear(0.02), foam_law.linear(0.01))
    press = Press(molding_front(male, female), female, both)
    found = press.at(-2.5)
    stiffness = 4000.0 / (4.0 / 0.02 + 1.0 / 0.01)
    assert press.first_touch == pytest.approx(-1.0, abs=1e-8)
    assert found.closing_force == pytest.approx(stiffness * 1.5, rel=1e-6)
    assert found.energy == pytest.approx(0.5 * stiffness * 1.5**2, rel=1e-6)


@pytest.mark.parametrize("area", [0.8, 1.0, 1.3, 1.9])
def test_foam_stretched_over_the_mold_is_in_plane_stress(area):
    """The thickness at which the law has no stress across, however the area is shared out between the two sides."""
    mu, alpha, nu = (0.02, 0.004), (6.0, -3.0), (0.2, 0.35)
    thick = foam_law.hyperfoam(mu, alpha, nu).thinning(area, None).item()
    law = Hyperfoam(mu, alpha, nu)
    for one in (np.sqrt(area), 1.2):
        e = np.log([[one, area / one, thick]])
        assert law.first(e)[0, 2] == pytest.approx(0.0, abs=1e-12)
    one_term = foam_law.hyperfoam([0.02], [6.0], [0.3]).thinning(area, None)
    assert one_term == pytest.approx(FOAMS["linear"].thinning(area, 0.3), rel=1e-12)


def test_what_tells_no_thinning_is_refused():
    with pytest.raises(ValueError, match="Poisson"):
        FOAMS["linear"].thinning([1.2], None)
    assert FOAMS["linear"].thinning([1.25], 0.5) == pytest.approx([0.8], rel=1e-15)


def test_between_two_temperatures_the_stress_is_between():
    cold, hot = FOAMS["table with a level"], foam_law.table([0.0, 0.3, 0.6], [0.0, 0.002, 0.01])
    half = foam_law.mixed([cold, hot], [0.75, 0.25])
    strain = np.linspace(0.0, 0.6, 61)
    assert half.stress(strain) == pytest.approx(0.75 * cold.stress(strain) + 0.25 * hot.stress(strain), rel=1e-12)
    assert half.limit == 0.6
    assert half.knots.tolist() == [0.0, 0.1, 0.3, 0.5, 0.6]
    work = np.trapezoid(half.stress(np.linspace(0, 0.6, 6001)), dx=1e-4)
    assert half.energy(0.6) == pytest.approx(work, rel=1e-7)


@pytest.mark.parametrize("celsius", [20.0, 60.0, 131.0, 300.0])
@pytest.mark.parametrize("soft", [None, foam_law.linear(0.2), foam_law.table([0, 0.2, 0.5], [0, 1e-3, 0.02])])
def test_foam_that_differs_by_place_does_at_each_what_foam_of_that_temperature_does(celsius, soft):
    """Also one that bottoms sooner when hot: each place has its own limit. Straightened laws rise by 1e-9 of their
    largest stress even where they are level: so closely both agree."""
    hot = foam_law.table([0.0, 0.3, 0.6], [0.0, 0.002, 0.01])
    laws = foam_law.Tempered((20.0, 100.0, 180.0), (FOAMS["table with a level"], foam_law.linear(0.02), hot))
    one = Sandwich(4.0, 1.0, laws.at(celsius), soft)
    many = Sandwich(4.0, 1.0, laws.at(np.array([20.0, celsius, 180.0])), soft)
    for gap in np.linspace(0.05, 5.2, 40):
        there = np.full(3, gap)
        for name in ("pressure", "energy", "strain", "stiffness", "state"):
            value = float(getattr(one, name)(gap))
            assert getattr(many, name)(there)[1] == pytest.approx(value, rel=1e-8, abs=1e-10), name
        for part, alone in zip(many.pressed(there), one.pressed(gap), strict=True):
            assert part[1] == pytest.approx(float(alone), rel=1e-8, abs=1e-8)
