"""A sparse product by blocks of rows: right to rounding, and the same bits on any number of cores."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from hyperfab.numerics import product as module
from hyperfab.numerics.threads import LIMIT


def rough_matrix(rows: int, columns: int) -> sparse.csr_matrix:
    """Entries of many sizes, rows of any length, some of them empty."""
    rng = np.random.default_rng(3)
    a = sparse.random(rows, columns, 0.1, random_state=rng, format="csr")
    a.data *= 10.0 ** rng.integers(-8, 8, a.nnz)
    return a


@pytest.mark.parametrize("entries", [1, 37, 10**6])
def test_a_product_is_right_to_rounding_with_the_same_bits_on_all_cores(
    monkeypatch: pytest.MonkeyPatch, entries: int
) -> None:
    a = rough_matrix(211, 150)
    x = np.random.default_rng(4).standard_normal(150)
    monkeypatch.setattr(module, "ENTRIES", entries)
    found = []
    for threads in (1, 2, 3):
        monkeypatch.setenv(LIMIT, str(threads))
        found.append(module.product(a, x))
    assert np.all(np.abs(found[0] - a @ x) <= 1e-15 * (abs(a) @ np.abs(x)))
    assert len({one.tobytes() for one in found}) == 1


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("entries", [37, 10**6])
def test_what_is_made_of_a_product_in_its_pass(monkeypatch: pytest.MonkeyPatch, threads: int, entries: int) -> None:
    a = rough_matrix(180, 180)
    rng = np.random.default_rng(5)
    x, right, weights, change = rng.standard_normal((4, 180))
    monkeypatch.setenv(LIMIT, str(threads))
    monkeypatch.setattr(module, "ENTRIES", entries)
    scale = abs(a) @ np.abs(x) + np.abs(right)
    rest = module.remainder(a, x, right)
    assert np.all(np.abs(rest - (right - a @ x)) <= 1e-15 * scale)
    wanted = x + 0.3 * change + weights * rest
    after = module.relax(a, x, right, weights, change, 0.3)
    np.testing.assert_allclose(after, wanted, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(change, after - x, rtol=1e-9, atol=1e-9)
