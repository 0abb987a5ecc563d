"""The door to sparse direct solvers."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import scipy.sparse as sparse

from hyperfab.numerics import linear


def test_factorising_leaves_the_warnings_of_other_threads_alone(monkeypatch):
    """What becomes of warnings is told once for all threads: as errors here, an overflow elsewhere was a defect."""
    told, real = [], linear.splu

    def factorised(*args, **options):
        told.append(list(warnings.filters))
        return real(*args, **options)

    monkeypatch.setattr(linear, "splu", factorised)
    before = list(warnings.filters)
    found = linear.SuperLUFactor(sparse.csc_matrix([[4.0, 1.0], [1.0, 3.0]])).solve(np.array([5.0, 4.0]))
    np.testing.assert_allclose(found, 1.0)
    assert told == [before]


def test_a_matrix_without_inverse_is_told():
    with pytest.raises(linear.SingularMatrixError):
        linear.SuperLUFactor(sparse.csc_matrix([[1.0, 1.0], [1.0, 1.0]]))
