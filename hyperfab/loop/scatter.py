"""Readings at scattered places: their noise from neighbours, and their order along a path through them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hyperfab.loop.noise import third_differences
from hyperfab.loop.problem import Array, Curve

#: Neighbours a plane is laid through, and of a normal distribution: standard deviation over median deviation.
_NEIGHBOURS, _MAD = 9, 1.4826
#: Two readings nearer than this share of the cloud's size are repeats of each other.
_SAME = 1e-6


def cloud_noise(places: Array, values: Array) -> tuple[float, float]:
    """Return the standard deviation of readings (n,) at ``places`` (n, d), and its degrees of freedom.

    From repeats at the same place where there are six or more, else from what each reading misses the plane through
    its neighbours by.

    >>> x = np.random.default_rng(1).uniform(0.0, 1.0, (400, 2))
    >>> y = 3.0 * x[:, 0] + 0.1 * np.random.default_rng(2).standard_normal(400)
    >>> abs(cloud_noise(x, y)[0] - 0.1) < 0.02
    True
    """
    size = float(np.max(np.ptp(places, axis=0), initial=0.0)) or 1.0
    tree = cKDTree(places)
    pairs = tree.query_pairs(_SAME * size, output_type="ndarray")
    if len(pairs) >= 6:
        apart = (values[pairs[:, 0]] - values[pairs[:, 1]]) / np.sqrt(2.0)
        return float(np.sqrt(np.mean(apart**2))), float(len(pairs))
    top = float(np.max(np.abs(values), initial=0.0)) or 1.0
    count = min(_NEIGHBOURS, len(values) - 1)
    if count < 5:
        return 0.02 * top, 2.0
    _, near = tree.query(places, count + 1)
    left = np.empty(len(values))
    for i, (mine, others) in enumerate(zip(near[:, 0], near[:, 1:], strict=True)):
        away = places[others] - places[mine]
        design = np.hstack([np.ones((count, 1)), _plan(away)])
        weights = np.linalg.pinv(design)[0]
        left[i] = (values[mine] - weights @ values[others]) / np.sqrt(1.0 + weights @ weights)
    return max(_size(left), 1e-6 * top), max(0.5 * len(values), 2.0)


def _size(left: Array) -> float:
    """Return the standard deviation of differences: their rms, those beyond three median deviations taken as three."""
    most = 3.0 * _MAD * float(np.median(np.abs(left)))
    return float(np.sqrt(np.mean(np.minimum(np.abs(left), most) ** 2)))


def _plan(away: Array) -> Array:
    """Return coordinates (k, 2) in the plane the neighbours lie in."""
    if away.shape[1] <= 2:
        return away
    _, _, axes = np.linalg.svd(away - away.mean(axis=0), full_matrices=False)
    return np.asarray(away @ axes[:2].T)


def patches(places: Array, most: int = 8, least: int = 12) -> list[NDArray[np.int64]]:
    """Cut a cloud (n, d) into patches of neighbours, halving the widest; rows of each in order along a path.

    >>> [len(p) for p in patches(np.random.default_rng(0).uniform(0.0, 1.0, (96, 2)))]
    [12, 12, 12, 12, 12, 12, 12, 12]
    """
    found = [np.arange(len(places))]
    while len(found) < most:
        widths = [float(np.max(np.ptp(places[p], axis=0))) if len(p) >= 2 * least else -1.0 for p in found]
        widest = int(np.argmax(widths))
        if widths[widest] < 0.0:
            break
        part = found.pop(widest)
        axis = int(np.argmax(np.ptp(places[part], axis=0)))
        order = part[np.argsort(places[part, axis], kind="stable")]
        found += [order[: len(order) // 2], order[len(order) // 2 :]]
    return [_path(places, part) for part in found]


def _path(places: Array, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Order rows so that each is near the one before: always on to the nearest that is left."""
    left = list(rows[np.argsort(places[rows, 0], kind="stable")])
    path = [left.pop(0)]
    while left:
        gaps = np.sum((places[left] - places[path[-1]]) ** 2, axis=1)
        path.append(left.pop(int(np.argmin(gaps))))
    return np.array(path, dtype=np.int64)


def level_of_curve(values: Array, abscissa: Array, time_s: Array | None = None) -> tuple[float, float]:
    """Return the standard deviation of readings (n,) along a smooth curve, and its degrees of freedom.

    Readings at one place of it, as where a press holds, are smooth in time where that is known.
    """
    order = np.lexsort((abscissa if time_s is None else time_s, abscissa))
    found, _ = third_differences(values[order], Curve("", 0, len(values), abscissa[order]))
    if time_s is not None:
        same = np.diff(abscissa[order]) <= _SAME * max(float(np.ptp(abscissa)), 1e-12)
        starts = np.concatenate([[0], np.flatnonzero(~same) + 1, [len(order)]])
        held = [order[a:b] for a, b in pairwise(starts) if b - a > 4]
        more = [third_differences(values[rows], Curve("", 0, len(rows), time_s[rows]))[0] for rows in held]
        found = np.concatenate([found, *more])
    top = float(np.max(np.abs(values), initial=0.0)) or 1.0
    if len(found) < 4:
        return 0.02 * top, 2.0
    return max(_size(found), 1e-6 * top), max(0.4 * len(found), 2.0)
