"""The hierarchy's operators against dense matrices."""

from __future__ import annotations

import os
from itertools import pairwise
from unittest import mock

import numpy as np
import pytest

from hyperfab.cloth.galerkin import OX, OY, sandwich_all
from hyperfab.cloth.multigrid import (
    Level,
    Multigrid,
    kept,
    left,
    prolong,
    restrict,
    sweep_back,
    sweep_from_zero,
)
from hyperfab.numerics import threads
from hyperfab.numerics.bands import in_bands


def dense(level: Level) -> np.ndarray:
    n, m = level.q.shape[:2]
    a = np.zeros((n, m, 3, n, m, 3))
    for i in range(n):
        for j in range(m):
            a[i, j, :, i, j] = level.diag[i, j][[[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
            for k in range(level.off.shape[2]):
                p, q = i + OX[k], j + OY[k]
                if p < n and 0 <= q < m:
                    a[i, j, :, p, q] = level.off[i, j, k].reshape(3, 3)
                    a[p, q, :, i, j] = a[i, j, :, p, q].T
    return a.reshape(3 * n * m, -1)


def interpolation(n: int) -> np.ndarray:
    """The matrix from a coarser line to one of n nodes: each is interpolated between those that are kept."""
    return np.array([np.interp(np.arange(n), kept(n), one) for one in np.eye(len(kept(n)))]).T


def random_grids(n: int, m: int, sheared: bool) -> Multigrid:
    random = np.random.default_rng(1)

    half = random.normal(size=(n, m, 3, 3))
    own = half @ half.swapaxes(-1, -2) + 20.0 * np.eye(3)
    diag = own[..., [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    off = random.normal(size=(n, m, 4 if sheared else 2, 9))
    free = np.zeros((n, m, 6))
    free[..., [0, 3, 5]] = 1.0
    grids = Multigrid(n, m, off.shape[2])
    grids.build(np.ascontiguousarray(diag), off, free)
    return grids


@pytest.mark.parametrize(("n", "m", "sheared"), [(9, 9, False), (10, 7, True), (6, 3, False), (4, 8, True)])
def test_a_coarser_operator_is_the_finer_one_between_interpolations(n, m, sheared):
    levels = random_grids(n, m, sheared).levels
    for fine, coarse in pairwise(levels):
        a, b = fine.q.shape[:2]
        p = np.kron(np.kron(interpolation(a), interpolation(b)), np.eye(3))
        product = p.T @ dense(fine) @ p
        assert np.abs(dense(coarse) - product).max() <= 1e-6 * np.abs(product).max()


@pytest.mark.parametrize(("n", "m"), [(9, 9), (10, 7), (6, 3), (5, 8)])
@pytest.mark.parametrize("most", [1, 2, 100])
def test_the_way_to_the_coarser_grid_and_back_is_interpolation(n, m, most):
    r = np.random.default_rng(3).normal(size=(n, m, 3)).astype(np.float32)
    p = np.kron(np.kron(interpolation(n), interpolation(m)), np.eye(3))
    coarse = np.full((len(kept(n)), len(kept(m)), 3), np.nan, np.float32)
    fine = r.copy()
    for first in range(0, len(coarse), most):
        restrict(r, kept(n), kept(m), coarse, first, min(first + most, len(coarse)))
    np.testing.assert_allclose(coarse.ravel(), p.T @ r.ravel(), atol=1e-5)
    for first in range(0, len(coarse), most):
        prolong(coarse, kept(n), kept(m), fine, first, min(first + most, len(coarse)))
    np.testing.assert_allclose(fine.ravel(), r.ravel() + p @ coarse.ravel(), atol=1e-5)


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize("sheared", [False, True])
def test_sweeps_solve_with_either_triangle_whoever_sweeps(sheared, number):
    n, m = 19, 36  # several bands of rows, and pieces of columns
    level = random_grids(n, m, sheared).levels[0]
    b = np.random.default_rng(2).normal(size=(n, m, 3)).astype(np.float32)
    u, r = np.full_like(b, np.nan), np.empty_like(b)
    whole = dense(level)
    own = np.kron(np.eye(n * m), np.ones((3, 3))) * whole
    with mock.patch.object(threads, "NODES", 1), mock.patch.dict(os.environ, {threads.LIMIT: str(number)}):
        in_bands(lambda done: sweep_from_zero(level.inverse, level.off, b, u, done), n, m)
        lower = own + np.tril(whole - own)
        assert np.abs(u.ravel() - np.linalg.solve(lower, b.ravel())).max() <= 1e-5 * np.abs(b).max()
        left(level.off, u, r, 0, n)
        exact = b.ravel() - whole @ u.ravel()
        assert np.abs(r.ravel() - exact).max() <= 1e-5 * np.abs(b).max()
        after = np.linalg.solve(lower.T, b.ravel() - np.tril(whole - own) @ u.ravel())
        in_bands(lambda done: sweep_back(level.inverse, level.off, b, u, done), n, m)
        assert np.abs(u.ravel() - after).max() <= 1e-5 * np.abs(b).max()


def test_a_block_between_nodes_on_their_planes_is_q_b_r():
    """Projections on any planes, in six numbers each, and a full block between them."""
    rng = np.random.default_rng(8)
    block, own = rng.standard_normal((3, 3)), np.zeros((2, 1, 6), np.float32)
    out = np.empty((2, 1, 1, 9), np.float32)
    planes = []
    for _ in range(2):
        normal = rng.standard_normal(3)
        planes.append(np.eye(3) - np.outer(normal, normal) / (normal @ normal))
    six = [plane[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]] for plane in planes]
    between = np.tile(block.reshape(9), (2, 1, 1, 1))
    sandwich_all(np.stack(six).reshape(2, 1, 6), np.zeros((2, 1, 6)), between, own, out, 0, 2)
    np.testing.assert_allclose(out[0].reshape(3, 3), planes[0] @ block @ planes[1], rtol=1e-5, atol=1e-6)
