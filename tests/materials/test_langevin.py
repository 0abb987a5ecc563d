"""The Langevin function, its slope and its inverse, against fifty digits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from hyperfab.materials.laws.arruda_boyce_langevin import SMALL, inverse_langevin, langevin

PLACES = [1e-8, 1e-3, 0.05, 0.1, 0.2, SMALL - 1e-9, SMALL, SMALL + 1e-9, 0.5, 1.0, 3.0, 10.0, 80.0]


@pytest.mark.parametrize("b", PLACES)
def test_value_and_slope_are_right_to_rounding(b: float) -> None:
    with mp.workdps(50):
        x = mp.mpf(b)
        value, slope = mp.coth(x) - 1 / x, 1 / x**2 - 1 / mp.sinh(x) ** 2
    found = langevin(np.array(b))
    assert float(found[0]) == pytest.approx(float(value), rel=2e-14)
    assert float(found[1]) == pytest.approx(float(slope), rel=2e-12)


@pytest.mark.parametrize("b", PLACES)
def test_the_inverse_finds_back(b: float) -> None:
    with mp.workdps(50):
        r = float(mp.coth(mp.mpf(b)) - 1 / mp.mpf(b))
    # Near 1 a rounding of r is one of (1 - r) = 1/b.
    assert float(inverse_langevin(np.array(r))) == pytest.approx(b, rel=1e-12 + 4e-16 * b)


def test_beyond_the_chain_s_length_there_is_none() -> None:
    assert np.isnan(inverse_langevin(np.array([-0.1, 1.0, 1.2]))).all()
