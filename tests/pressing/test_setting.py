"""The set of a foam against its closed form, its own constants, and histories that come to the same."""

import numpy as np
import pytest
from scipy.integrate import quad

from hyperfab.pressing.setting import GAS, ZERO_CELSIUS, Arrhenius, Share, Table, identified, stays

LAW = Arrhenius(rate=3e8, activation=95e3)


def isothermal(celsius, seconds):
    return 1.0 - np.exp(-3e8 * np.exp(-95e3 / (GAS * (celsius + ZERO_CELSIUS))) * seconds)


def tabulated(temperatures, dwells):
    shares = isothermal(np.array(temperatures)[:, None], np.array(dwells)[None, :])[:, :, None]
    return Table(np.array(temperatures, float), np.array(dwells, float), np.zeros(1), shares)


def test_constants_come_back_from_their_own_curve_and_from_noise_within_its_error():
    temperature, dwell = (v.ravel() for v in np.meshgrid([150.0, 170.0, 190.0, 210.0], [10.0, 30.0, 90.0, 240.0]))
    exact = isothermal(temperature, dwell)
    found, rms = identified(temperature, dwell, exact)
    assert (found.rate, found.activation) == pytest.approx((3e8, 95e3), rel=1e-6)
    assert rms < 1e-9
    noisy = exact + 0.01 * np.random.default_rng(7).standard_normal(exact.shape)
    found, rms = identified(temperature, dwell, noisy)
    assert found.activation == pytest.approx(95e3, rel=0.06)
    assert rms == pytest.approx(0.01, rel=0.5)


@pytest.mark.parametrize(("temperature", "share"), [([180.0, 180.0], [0.2, 0.4]), ([160.0, 180.0], [0.0, 1.0])])
def test_readings_that_tell_no_constants_are_refused(temperature, share):
    with pytest.raises(ValueError, match="two temperatures or more"):
        identified(np.array(temperature), np.array([10.0, 20.0]), np.array(share))


def test_the_set_of_a_slab_that_warms_is_the_integral_over_time_and_depth():
    def at(t, x):
        return 200.0 - 160.0 * np.exp(-t / 8.0) * np.sin(np.pi * x)

    def speed(t, x):
        return 3e8 * np.exp(-95e3 / (GAS * (at(t, x) + ZERO_CELSIUS)))

    exact = quad(lambda x: -np.expm1(-quad(speed, 0.0, 40.0, args=(x,), epsabs=1e-12)[0]), 0.0, 1.0)[0]
    found, hottest = stays(LAW, lambda t, x: np.stack([at(t, one)[:, None] for one in x]), 40.0, np.ones(1))
    assert found[0] == pytest.approx(exact, abs=1e-4)  # 0.2 micrometres of a foam pressed by 2 mm
    assert hottest[0] == pytest.approx(200.0, abs=1.0)


def test_a_table_of_the_law_says_what_the_law_says_at_its_rows_and_over_a_history():
    table = tabulated([120.0, 200.0], [30.0, 60.0])
    assert table.at([120.0, 200.0, 200.0], [60.0, 30.0, 60.0], 0.5) == pytest.approx(
        isothermal(np.array([120.0, 200.0, 200.0]), np.array([60.0, 30.0, 60.0])), rel=1e-12
    )
    # In two spans as in one; half way between two temperatures half way between their shares.
    one = table.after(np.full((1, 1), 160.0), np.array([50.0]), np.ones(1))
    two = table.after(np.full((2, 1), 160.0), np.array([20.0, 30.0]), np.ones(1))
    assert two == pytest.approx(one, rel=1e-12)
    assert table.at(160.0, 60.0, 0.5) == pytest.approx(isothermal(np.array([120.0, 200.0]), 60.0).mean(), rel=1e-12)
    # A fine table follows a warming place as the law itself does.
    fine = tabulated(np.arange(20.0, 221.0, 2.0), np.geomspace(0.01, 600.0, 400))
    warming = np.linspace(40.0, 210.0, 200)[:, None]
    spans = np.full(200, 0.3)
    assert fine.after(warming, spans, np.ones(1)) == pytest.approx(LAW.after(warming, spans, np.ones(1)), abs=2e-4)


def test_a_table_knows_strains_and_sets_nothing_when_cold():
    shares = np.array([[[0.2, 0.4]], [[0.6, 0.8]]])
    table = Table(np.array([150.0, 190.0]), np.array([60.0]), np.array([0.2, 0.6]), shares)
    assert table.at(150.0, 60.0, [0.1, 0.2, 0.4, 0.9]) == pytest.approx([0.2, 0.2, 0.3, 0.4])
    assert table.at([149.0, 400.0], 600.0, 0.2) == pytest.approx([0.0, 0.6])
    # Foam comes to its mold's temperature from below, and never quite.
    assert table.at([150.0 - 1e-6, 149.9], 60.0, 0.2) == pytest.approx([0.2, 0.0])
    # Warm, then cold: what has set stays.
    history = np.array([[190.0], [20.0]])
    assert table.after(history, np.array([30.0, 100.0]), np.array([0.2])) == pytest.approx([0.3])


def test_a_plain_share_is_that_share():
    found, _ = stays(Share(0.7), lambda t, x: np.full((len(x), len(t), 3), 25.0), 10.0, np.zeros(3))
    assert found == pytest.approx([0.7] * 3)
