"""The hierarchy's operators against dense matrices."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from hyperfab.cloth.galerkin import OX, OY, _sandwich
from hyperfab.cloth.multigrid import Level, Multigrid, left, parents_of, sweep_from_zero


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
    index, weight = parents_of(n)
    p = np.zeros((n, index.max() + 1))
    for i in range(n):
        np.add.at(p[i], index[i], weight[i])
    return p


def random_grids(n: int, m: int, sheared: bool) -> Multigrid:
    random = np.random.default_rng(1)

    half = random.normal(size=(n, m, 3, 3))
    own = half @ half.swapaxes(-1, -2) + 20.0 * np.eye(3)
    diag = own[..., [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    off = random.normal(size=(n, m, 4 if sheared else 2, 9))
    free = np.zeros((n, m, 6))
    free[..., [0, 3, 5]] = 1.0
    grids = Multigrid(n, m, off.shape[2])
    grids.build(diag, off, free)
    return grids


@pytest.mark.parametrize(("n", "m", "sheared"), [(9, 9, False), (10, 7, True), (6, 3, False), (4, 8, True)])
def test_a_coarser_operator_is_the_finer_one_between_interpolations(n, m, sheared):
    levels = random_grids(n, m, sheared).levels
    for fine, coarse in pairwise(levels):
        a, b = fine.q.shape[:2]
        p = np.kron(np.kron(interpolation(a), interpolation(b)), np.eye(3))
        product = p.T @ dense(fine) @ p
        assert np.abs(dense(coarse) - product).max() <= 1e-6 * np.abs(product).max()


@pytest.mark.parametrize("sheared", [False, True])
def test_what_a_sweep_from_zero_leaves_is_the_residual(sheared):
    level = random_grids(7, 6, sheared).levels[0]
    b = np.random.default_rng(2).normal(size=(7, 6, 3))
    u, r = np.full_like(b, np.nan), np.empty_like(b)
    sweep_from_zero(level.inverse, level.off, b, u)
    left(level.off, u, r, 0, len(u))
    exact = b.ravel() - dense(level) @ u.ravel()
    assert np.abs(r.ravel() - exact).max() <= 1e-5 * np.abs(b).max()


def test_a_block_between_nodes_on_their_planes_is_q_b_r():
    """Projections on any planes, in six numbers each, and a full block between them."""
    rng = np.random.default_rng(8)
    block, out = rng.standard_normal((3, 3)), np.empty(9, np.float32)
    planes = []
    for _ in range(2):
        normal = rng.standard_normal(3)
        planes.append(np.eye(3) - np.outer(normal, normal) / (normal @ normal))
    six = [plane[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]] for plane in planes]
    getattr(_sandwich, "py_func", _sandwich)(six[0], block, six[1], np.empty((3, 3)), out)
    np.testing.assert_allclose(out.reshape(3, 3), planes[0] @ block @ planes[1], rtol=1e-5, atol=1e-6)
