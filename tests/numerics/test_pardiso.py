"""PARDISO where it is installed: the same answers as scipy's solver."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse

from hyperfab.numerics import pardiso
from hyperfab.numerics.linear import DirectSolver, SingularMatrixError, SuperLUFactor

if not pardiso.installed():
    pytest.skip("PyPardiso is not installed (pip install hyperfab[fast])", allow_module_level=True)


def _matrix(seed: int = 0) -> sparse.csc_matrix:
    random = np.random.default_rng(seed)
    pattern = sparse.random_array((200, 200), density=0.03, rng=np.random.default_rng(5))
    pattern = (abs(pattern) + abs(pattern.T) + sparse.eye_array(200)).tocsc()
    pattern.data = random.normal(size=pattern.nnz)
    pattern = pattern + 20.0 * sparse.eye_array(200)
    return sparse.csc_matrix(pattern)


def test_solves_as_superlu_does_and_keeps_its_analysis():
    solver, right = DirectSolver(), np.arange(200.0)
    for seed in range(3):
        factor = solver.factorise(_matrix(seed), symmetric=False)
        assert factor.name == "PARDISO"
        np.testing.assert_allclose(factor.solve(right), SuperLUFactor(_matrix(seed)).solve(right), rtol=1e-9, atol=1e-9)


def test_another_pattern_is_analysed_anew():
    solver = DirectSolver()
    solver.factorise(_matrix(), symmetric=False)
    small = sparse.csc_matrix([[2.0, 1.0], [-1.0, 2.0]])
    np.testing.assert_allclose(solver.factorise(small, symmetric=False).solve(np.array([3.0, 1.0])), [1.0, 1.0])


def test_an_old_factor_does_not_answer():
    solver = DirectSolver()
    old = solver.factorise(_matrix(0), symmetric=False)
    solver.factorise(_matrix(1), symmetric=False)
    with pytest.raises(RuntimeError):
        old.solve(np.ones(200))


def test_a_singular_matrix_is_told():
    matrix = sparse.csc_matrix([[0.0, 1.0], [1.0, 0.0]]) * np.nan
    with pytest.raises(SingularMatrixError):
        DirectSolver().factorise(matrix, symmetric=False).solve(np.ones(2))
