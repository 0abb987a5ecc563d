"""A force on a tip: is it borne by the facets that meet there? Against SciPy's non-negative least squares."""

from __future__ import annotations

from collections import namedtuple

import numpy as np
import pytest
from numba import njit
from scipy.optimize import nnls

from hyperfab.cloth.features import _in_cone

Mold = namedtuple("Mold", "normals")


@njit
def borne(mold, slots, force, rest):
    return _in_cone(mold, slots, len(slots), force, rest)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 64, 4096])
def test_a_force_is_borne_where_it_is_a_sum_of_normals(count: int) -> None:
    random = np.random.default_rng(count)
    turned = 2.0 * np.pi * np.arange(count) / count
    for slope in (0.01, 0.3, 1.0, 3.0):
        normals = np.stack([slope * np.cos(turned), slope * np.sin(turned), np.ones(count)], axis=1)
        normals = normals @ np.linalg.qr(random.normal(size=(3, 3)))[0]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        mold = Mold(np.ascontiguousarray(np.repeat(normals[:, None], 7, axis=1)))
        inside = -1e-3 * random.uniform(0.0, 1.0, 3) @ normals[random.integers(count, size=3)]
        for force in (inside, random.normal(size=3), -normals[0]):
            rest = np.empty(3)
            found = borne(mold, np.arange(count), force, rest)
            _, left = nnls(normals.T, -force, maxiter=5000)
            size = np.linalg.norm(force)
            assert found == (left < 1e-9 * size)
            assert np.linalg.norm(rest) == pytest.approx(left, abs=1e-9 * size)
