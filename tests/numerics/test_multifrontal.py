"""Nested dissection and Cholesky front by front, against dense linear algebra."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.spatial import Delaunay

from hyperfab.numerics.blocks import BlockPattern
from hyperfab.numerics.dissection import dissect
from hyperfab.numerics.lapack import addresses
from hyperfab.numerics.multifrontal import CholeskyFactor, NotPositiveDefiniteError
from hyperfab.numerics.threads import LIMIT


def _pattern(count: int, size: int = 3, dimensions: int = 2, seed: int = 0) -> BlockPattern:
    random = np.random.default_rng(seed)
    points = random.uniform(size=(count, dimensions))
    elements = Delaunay(points).simplices.astype(np.int64)
    free = random.uniform(size=(count, size)) < 0.9
    return BlockPattern(elements, count, free, points)


def _definite(pattern: BlockPattern, seed: int = 1) -> sparse.csc_matrix:
    random = np.random.default_rng(seed)
    matrix = pattern.matrix(random.normal(size=(pattern.blocks, pattern.size, pattern.size)))
    matrix = sparse.csc_matrix(matrix + matrix.T)
    matrix.setdiag(np.asarray(abs(matrix).sum(axis=0)).ravel() + 1.0)
    matrix.sort_indices()
    return matrix


@pytest.mark.parametrize(("count", "size", "dimensions"), [(5, 3, 2), (40, 1, 2), (400, 3, 2), (200, 2, 3)])
def test_factor_solves_as_dense_algebra_does(count, size, dimensions):
    pattern = _pattern(count, size, dimensions)
    matrix = _definite(pattern)
    right = np.random.default_rng(2).normal(size=pattern.unknowns)
    factor = pattern.solver.factorise(matrix)
    assert factor.name == "Cholesky by fronts"
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(matrix.toarray(), right), atol=1e-13)
    assert factor.negative_pivots() == 0


def test_every_unknown_is_eliminated_once_and_children_before_parents():
    pattern = _pattern(300)
    found = dissect(pattern._elements, pattern._points, pattern.free)
    np.testing.assert_array_equal(np.sort(found.order), np.arange(pattern.unknowns))
    assert (found.firsts[0], found.firsts[-1]) == (0, pattern.unknowns)
    assert (np.diff(found.firsts) >= 0).all()
    assert (found.children < np.arange(len(found.children))[:, None]).all()
    parent = np.full(len(found.children), -1)
    inner = found.children[:, 0] >= 0
    parent[found.children[inner]] = np.flatnonzero(inner)[:, None]
    ties = np.array([set(), *map(set, _tied(pattern, found.order))], dtype=object)[1:]
    for front, (begin, end) in enumerate(itertools.pairwise(found.firsts)):
        rest, above = (values[slice(*found.rest_starts[front : front + 2])] for values in (found.rest, found.above))
        below = [
            found.rest[slice(*found.rest_starts[child : child + 2])] for child in found.children[front] if inner[front]
        ]
        wanted = set().union(*ties[begin:end], *map(set, below))
        assert {number for number in wanted if number >= end} <= set(rest)
        assert (np.diff(rest) > 0).all()
        assert (rest >= end).all()
        if len(rest):
            first, last = found.firsts[parent[front] : parent[front] + 2]
            row = np.concatenate(
                [
                    np.arange(first, last),
                    found.rest[slice(*found.rest_starts[parent[front] : parent[front] + 2])],
                ]
            )
            np.testing.assert_array_equal(row[above], rest)


def _tied(pattern: BlockPattern, order: np.ndarray) -> list[np.ndarray]:
    """Return which unknowns, by their turn, each unknown shares an element with, by its turn."""
    matrix = _definite(pattern)[order][:, order].tocsr()
    return [matrix.indices[slice(*matrix.indptr[k : k + 2])] for k in range(len(order))]


def test_fill_grows_as_nested_dissection_promises():
    """n log n entries in the plane, where a band would have n^1.5."""
    sizes = []
    for count in (1000, 4000):
        pattern = _pattern(count, 1)
        sizes.append(pattern.elimination.size / (pattern.unknowns * np.log2(pattern.unknowns)))
    assert sizes[1] < 1.25 * sizes[0]


def test_an_indefinite_matrix_is_told_and_solved_by_another_solver():
    pattern = _pattern(60)
    matrix = _definite(pattern).tolil()
    matrix[3, 3] = -50.0
    matrix = matrix.tocsc()
    matrix.sort_indices()
    with pytest.raises(NotPositiveDefiniteError):
        CholeskyFactor(pattern.elimination, matrix.data)
    factor = pattern.solver.factorise(matrix)
    right = np.ones(pattern.unknowns)
    assert factor.name == "SuperLU"
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-10)
    assert factor.negative_pivots() == 1


def test_same_matrix_gives_the_same_bits():
    pattern = _pattern(200)
    matrix, right = _definite(pattern), np.ones(pattern.unknowns)
    first, again = (pattern.solver.factorise(matrix).solve(right) for _ in range(2))
    assert first.tobytes() == again.tobytes()


@pytest.fixture(scope="module")
def large():
    """So many entries that branches are worked side by side."""
    pattern = _pattern(6000)
    matrix = _definite(pattern)
    assert len(pattern.elimination.stages) > 3
    return pattern, matrix


def test_a_large_matrix_is_solved_whatever_the_number_of_threads(large, monkeypatch):
    pattern, matrix = large
    right = np.random.default_rng(2).normal(size=pattern.unknowns)
    found = []
    for number in ("1", "2", "3"):
        monkeypatch.setenv(LIMIT, number)
        found.append(pattern.solver.factorise(matrix).solve(right).tobytes())
    assert len(set(found)) == 1
    residual = matrix @ np.frombuffer(found[0]) - right
    assert np.abs(residual).max() < 1e-12 * np.abs(right).max()
    factor = pattern.solver.factorise(matrix)
    assert factor.name == "Cholesky by fronts"


def test_ranges_of_a_stage_hang_on_stages_before_alone(large):
    plan = large[0].elimination
    done = np.zeros(len(plan.fronts.pivots), bool)
    for stage in plan.stages:
        for first, last in stage:
            for front in range(first, last):
                children = plan.fronts.children[slice(*plan.fronts.child_starts[front : front + 2])]
                assert all(done[child] or first <= child < front for child in children)
        for first, last in stage:
            assert not done[first:last].any()
            done[first:last] = True
    assert done.all()


def test_a_large_matrix_that_is_indefinite_is_told(large):
    pattern, matrix = large
    values = matrix.data.copy()
    values[matrix.indptr[700] + np.searchsorted(matrix.indices[slice(*matrix.indptr[700:702])], 700)] = -50.0
    with pytest.raises(NotPositiveDefiniteError):
        CholeskyFactor(pattern.elimination, values)


def test_a_routine_that_scipy_lacks_is_named():
    with pytest.raises(ValueError, match="scipy has no dpotrf_none"):
        addresses("dsyrk", "dpotrf_none")
