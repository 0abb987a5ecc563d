"""The hierarchy where what is stored and what is conducted cancel between neighbours, as in some short time step."""

from unittest import mock

import numpy as np
import pytest
from scipy import sparse

from hyperfab.numerics import multilevel
from hyperfab.numerics.multilevel import Direct, conjugate_gradients


def cube(nodes: int, ratio: float) -> sparse.csr_matrix:
    """Mass and ``ratio`` times stiffness of trilinear elements of edge 1, insulated."""
    ends = sparse.diags([[-1.0] * (nodes - 1), [1.0, *[2.0] * (nodes - 2), 1.0], [-1.0] * (nodes - 1)], [-1, 0, 1])
    mass = sparse.diags(
        [[1 / 6] * (nodes - 1), [1 / 3, *[2 / 3] * (nodes - 2), 1 / 3], [1 / 6] * (nodes - 1)], [-1, 0, 1]
    )

    def box(x, y, z):
        return sparse.kron(sparse.kron(x, y), z)

    stiffness = box(ends, mass, mass) + box(mass, ends, mass) + box(mass, mass, ends)
    return sparse.csr_matrix(box(mass, mass, mass) + ratio * stiffness)


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.3, 1.0, 10.0, 1000.0])
def test_no_step_length_has_its_large_matrix_factorised(ratio):
    matrix = cube(18, ratio)
    sizes: list[int] = []
    begin = Direct.__init__

    def noted(self, small, free=None):
        sizes.append(small.shape[0])
        begin(self, small, free)

    with mock.patch.object(Direct, "__init__", noted):
        cycle = multilevel.hierarchy(matrix, coarsest=100)
    right = np.random.default_rng(0).standard_normal(matrix.shape[0])
    found = conjugate_gradients(matrix, right, cycle, tolerance=1e-8)
    assert len(sizes) == 1
    assert sizes[0] <= 100
    assert found.iterations <= 15
    assert np.linalg.norm(matrix @ found.x - right) <= 2e-8 * np.linalg.norm(right)


def test_unknowns_that_are_not_coupled_are_solved_each_for_itself():
    values = np.linspace(1.0, 5.0, 3000)
    diagonal = sparse.csr_matrix(sparse.diags(values))
    assert multilevel.hierarchy(diagonal).apply(values) == pytest.approx(np.ones(3000))
