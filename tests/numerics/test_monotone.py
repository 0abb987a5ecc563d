"""The nearest curve that never falls, beside SciPy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import isotonic_regression

from hyperfab.numerics.monotone import never_falling


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=60))
def test_it_is_the_isotonic_regression(values: list[float]) -> None:
    found = never_falling(np.array(values))
    np.testing.assert_allclose(found, isotonic_regression(values).x, rtol=1e-12, atol=1e-9)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=60, unique=True))
def test_what_rises_stays_as_it_is(values: list[float]) -> None:
    rising = np.sort(np.array(values))
    np.testing.assert_array_equal(never_falling(rising), rising)
