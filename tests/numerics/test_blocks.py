"""Block matrices and the door to the solvers."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse

from hyperfab.numerics.blocks import BlockPattern
from hyperfab.numerics.linear import SingularMatrixError, SuperLUFactor


def _random(seed=0):
    random = np.random.default_rng(seed)
    elements = np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4]])
    free = np.ones((5, 3), bool)
    free[0] = False
    free[4, 1] = False
    return BlockPattern(elements, 5, free), random


def test_matrix_holds_each_block_at_its_place():
    pattern, random = _random()
    blocks = random.normal(size=(pattern.blocks, 3, 3))
    dense = np.zeros((5, 3, 5, 3))
    for e, element in enumerate([[0, 1, 2], [1, 3, 2], [2, 3, 4]]):
        for a, i in enumerate(element):
            for b, j in enumerate(element):
                dense[i, :, j, :] = blocks[pattern.block_of[e, a, b]]
    keep = pattern.free.ravel()
    np.testing.assert_array_equal(pattern.matrix(blocks).toarray(), dense.reshape(15, 15)[np.ix_(keep, keep)])


def test_diagonal_names_the_nodes_own_blocks():
    pattern, _ = _random()
    blocks = np.zeros((pattern.blocks, 3, 3))
    blocks[pattern.diagonal] = np.eye(3)
    np.testing.assert_array_equal(pattern.matrix(blocks).toarray(), np.eye(pattern.unknowns))


def test_restrict_and_extend_are_inverse_on_free_values():
    pattern, random = _random()
    vector = random.normal(size=pattern.unknowns)
    np.testing.assert_array_equal(pattern.restrict(pattern.extend(vector)), vector)
    assert not pattern.extend(vector)[~pattern.free].any()


def test_factor_solves_and_counts_negative_eigenvalues():
    random = np.random.default_rng(1)
    basis, _ = np.linalg.qr(random.normal(size=(30, 30)))
    values = np.concatenate([np.linspace(1, 3, 27), [-0.5, -1.0, -2.0]])
    matrix = sparse.csc_matrix(basis @ np.diag(values) @ basis.T)
    factor = SuperLUFactor(matrix)
    right = random.normal(size=30)
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-12)
    assert factor.negative_pivots() == 3


def test_a_singular_matrix_is_told():
    with pytest.raises(SingularMatrixError):
        SuperLUFactor(sparse.csc_matrix([[1.0, 1.0], [1.0, 1.0]])).solve(np.ones(2))
