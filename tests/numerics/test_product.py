"""A sparse product by blocks of rows: SciPy's, bit for bit, on any number of cores."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from hyperfab.numerics import product as module
from hyperfab.numerics.threads import LIMIT


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("entries", [1, 37, 10**6])
def test_a_product_has_the_bits_of_scipy(monkeypatch: pytest.MonkeyPatch, threads: int, entries: int) -> None:
    rng = np.random.default_rng(3)
    a = sparse.random(211, 150, 0.1, random_state=rng, format="csr")  # some rows empty, not square
    a.data *= 10.0 ** rng.integers(-8, 8, a.nnz)
    x = rng.standard_normal(150)
    monkeypatch.setenv(LIMIT, str(threads))
    monkeypatch.setattr(module, "ENTRIES", entries)
    assert module.product(a, x).tobytes() == (a @ x).tobytes()
