"""Design aids: the power for a wanted time, and shares that even a surface."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.errors import NotConverged
from hyperfab.thermal.condition import Heater
from hyperfab.thermal.design import scale_for_warmup, scaled, share_power
from hyperfab.thermal.tables import Table


def heated(block, powers):
    """A plate cooled on top with a heater at each end."""
    body = block((0.3, 0.1, 0.02), (12, 4, 1), k=40.0, rho=7800.0, cp=470.0)
    area = 0.1 * 0.02
    for way, power in zip(("x-", "x+"), powers, strict=True):
        body.flux(way, power / area)
    film = Table(np.array([0.0, 300.0]), np.array([20.0, 40.0]))
    body.film("z+", film, 20.0)
    return body.model(), body.face("z+")


def test_symmetry_shares_the_power_equally(block):
    model, surface = heated(block, (300.0, 100.0))
    shared = share_power(model, surface, np.full(model.size, 20.0))
    np.testing.assert_allclose(shared.powers, 200.0, rtol=2e-3)
    assert shared.spread < 0.7 * shared.spread_before


def test_mean_is_met_and_no_heater_gives_more_than_it_can(block):
    model, surface = heated(block, (300.0, 100.0))
    shared = share_power(model, surface, np.full(model.size, 20.0), mean=120.0)
    assert shared.mean == pytest.approx(120.0, abs=0.05)
    bound = 0.9 * float(shared.powers.max())
    with pytest.raises(NotConverged, match="bounds"):
        share_power(model, surface, np.full(model.size, 20.0), mean=120.0, most=bound)


def test_power_for_a_wanted_time_solves_the_lumped_mold(block):
    # C T' = s P - G T reaches the target at -C/G ln(1 - G T / (s P)).
    capacity, loss, power, target = 4e4, 5.0, 3000.0, 175.0

    def warmup(factor):
        share = loss * target / (factor * power)
        return None if share >= 1.0 else -capacity / loss * np.log1p(-share)

    for wanted in (600.0, 1200.0, 2400.0, 9000.0):
        factor, runs = scale_for_warmup(wanted, warmup)
        assert warmup(factor) == pytest.approx(wanted, rel=2e-4)
        assert runs <= 12


def test_a_scaled_heater_keeps_the_course_of_its_power():
    heater = Heater("h", np.ones(1), Table(np.array([0.0, 10.0, 20.0]), np.array([5.0, 20.0, 0.0])))
    found = scaled(heater, 3.0)
    assert found.x.tolist() == [0.0, 10.0, 20.0]
    assert found.y.tolist() == [15.0, 60.0, 0.0]


@pytest.mark.parametrize("power", [1.0, 3.0, 6.0])
@pytest.mark.parametrize("wanted", [10.0, 100.0])
def test_a_wanted_time_is_met_however_bent_its_law(power, wanted):
    """300 s at full power, less with its ``power``: false position alone would creep in from one side."""
    factor, runs = scale_for_warmup(wanted, lambda s: 300.0 / s**power)
    assert factor == pytest.approx((300.0 / wanted) ** (1.0 / power), rel=1e-4)
    assert runs <= 12


def test_a_time_that_no_power_tells_apart_from_rest_is_refused_with_the_times_beside_it():
    def warmup(factor):
        return -1000.0 * np.log1p(-1.0 / factor) if factor > 1.0 + 1e-9 else None

    assert scale_for_warmup(3000.0, warmup)[0] == pytest.approx(1.0 / (1.0 - np.exp(-3.0)), rel=1e-4)
    with pytest.raises(NotConverged, match=r"40000 s .* times never gets there; ask for a shorter one"):
        scale_for_warmup(40000.0, warmup)
