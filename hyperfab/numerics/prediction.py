"""Where a reading of one more specimen is to be expected, by specimens of one kind alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.propagation import LEVEL

#: Stretches at which a band is told: between them it goes straight.
_KNOTS = 12
#: Where a specimen has no reading between two knots its curve goes on without a bend: how much that counts.
_SMOOTH = 1e-3

#: Stretch and stress of the first loading of one specimen, in the order of stretch.
Loading = tuple[Array, Array]


def band(specimens: Sequence[Loading], reach: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Return stretches, and the least and greatest stress between which a reading of one more specimen is expected.

    The prediction interval of a normal distribution, at each stretch: the variance between n specimens times 1 + 1/n,
    with n - 1 degrees of freedom, and that of readings about their specimen's own curve, with as many as readings near
    there leave; of both together by Satterthwaite. No law takes part: what a law misses is no scatter.
    Hahn and Meeker (1991), Statistical Intervals, 4.8.

    >>> steps = np.linspace(1.0, 2.0, 30)
    >>> stretch, low, high = band([(steps, k * (steps - 1.0)) for k in (0.9, 1.0, 1.1)], (1.0, 2.0))
    >>> round(float(low[-1]), 3), round(float(high[-1]), 3)  # 1 -+ 4.303 times 0.1 times the root of 4/3
    (0.503, 1.497)
    """
    from scipy.special import stdtrit

    step = (reach[1] - reach[0]) / (_KNOTS - 1)
    least = min(float(stretch.min()) for stretch, _ in specimens)
    most = max(float(stretch.max()) for stretch, _ in specimens)
    before = max(int(np.ceil((reach[0] - least) / step - 1e-9)), 0)
    after = max(int(np.ceil((most - reach[1]) / step - 1e-9)), 0)
    knots = reach[0] + step * np.arange(-before, _KNOTS + after)
    bends = _SMOOTH * np.diff(np.eye(len(knots)), 2, axis=0)
    own, squares, weights = [], np.zeros(len(knots)), np.zeros(len(knots))
    for stretch, stress in specimens:
        near = np.array([np.interp(stretch, knots, unit) for unit in np.eye(len(knots))]).T
        system = np.vstack([near, bends])
        values = np.linalg.lstsq(system, np.append(stress, np.zeros(len(bends))), rcond=None)[0]
        own.append(values)
        squares += near.T @ (stress - near @ values) ** 2
        weights += near.sum(axis=0)
    told, count = slice(before, before + _KNOTS), len(specimens)
    curves = np.array(own)[:, told]
    between = curves.var(axis=0, ddof=1) * (1.0 + 1.0 / count)
    left = np.maximum(weights[told] - count, 1.0)  # each specimen's curve takes one number a knot
    noise = squares[told] / left
    total = between + noise
    with np.errstate(all="ignore"):
        freedom = total**2 / (between**2 / (count - 1) + noise**2 / left)
    half = stdtrit(np.where(total > 0.0, freedom, 1.0), 0.5 + 0.5 * LEVEL) * np.sqrt(total)
    middle = curves.mean(axis=0)
    return np.asarray(knots[told]), np.asarray(middle - half), np.asarray(middle + half)
