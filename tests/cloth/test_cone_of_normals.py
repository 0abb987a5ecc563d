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


@pytest.mark.parametrize("count", [4, 12, 64, 1024])
@pytest.mark.parametrize("slope", [0.01, 0.3, 1.0, 3.0])
def test_a_force_straight_onto_a_tip_is_borne_however_little_it_leans(count: int, slope: float) -> None:
    """Leaning by less than a facet's slope it is borne; rounding leans it by anything from nothing on."""
    random = np.random.default_rng(count)
    for begin in (0.0, 0.1, 0.5):
        turned = 2.0 * np.pi * (np.arange(count) + begin) / count
        normals = np.stack([slope * np.cos(turned), slope * np.sin(turned), np.ones(count)], axis=1)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        mold = Mold(np.ascontiguousarray(np.repeat(normals[:, None], 7, axis=1)))
        for lean in np.concatenate([[0.0], np.geomspace(1e-17, 1e-3, 29)]):
            for angle in random.uniform(0.0, 2.0 * np.pi, 8):
                force = -np.array([lean * slope * np.cos(angle), lean * slope * np.sin(angle), 1.0])
                assert borne(mold, np.arange(count), 3.0 * force, np.empty(3)), (begin, lean, angle)
