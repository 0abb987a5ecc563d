"""What specimens of one kind say of each other: how far they differ, and where the next one is to be expected."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fit.identify import kind_of, specimen_of
from hyperfab.curve import TestCurve
from hyperfab.documents.certainty import NextSpecimen, Replicates
from hyperfab.numerics.hygiene import first_loading
from hyperfab.numerics.propagation import LEVEL

#: Stretches at which a band is told: between them it goes straight.
_KNOTS = 12
#: Where a specimen has no reading between two knots its curve goes on without a bend: how much that counts.
_SMOOTH = 1e-3

#: Stretch and stress of the first loading of one specimen, in the order of stretch.
_Loading = tuple[Array, Array]


def replicates(curves: Sequence[TestCurve]) -> list[Replicates]:
    """Return how far specimens of one kind differ, over the stretches they share."""
    found = []
    for group, branches, (low, high) in _kinds(curves):
        grid = np.linspace(low, high, 21)
        stress = np.array([np.interp(grid, stretch, stress) for stretch, stress in branches])
        spread = stress.std(axis=0, ddof=1)
        found.append(
            Replicates(
                **group,
                scatter=float(np.sqrt(np.mean(spread**2)) / np.abs(stress).max()),
            )
        )
    return found


def next_specimens(curves: Sequence[TestCurve]) -> list[NextSpecimen]:
    """Return, of each kind of test with replicates, where a reading of one more specimen is to be expected."""
    found = []
    for group, branches, reach in _kinds(curves):
        stretch, low, high = band(branches, reach)
        found.append(
            NextSpecimen(
                **group,
                level=LEVEL,
                stretch=stretch.tolist(),
                low_MPa=low.tolist(),
                high_MPa=high.tolist(),
            )
        )
    return found


def band(specimens: Sequence[_Loading], reach: tuple[float, float]) -> tuple[Array, Array, Array]:
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


def _kinds(
    curves: Sequence[TestCurve],
) -> Iterator[tuple[dict[str, Any], list[_Loading], tuple[float, float]]]:
    """Yield what specimens of each kind with replicates have in common, the loading of each, and what all reach."""
    kinds: dict[Hashable, dict[Hashable, list[TestCurve]]] = {}
    for curve in curves:
        kinds.setdefault(kind_of(curve), {}).setdefault(specimen_of(curve), []).append(curve)
    for specimens in kinds.values():
        branches = [_loading(own) for own in specimens.values()]
        low = max(float(stretch.min()) for stretch, _ in branches)
        high = min(float(stretch.max()) for stretch, _ in branches)
        if len(branches) > 1 and low < high:
            one = next(iter(specimens.values()))[0]
            alike = {"test": one.mode, "direction": one.direction_name, "temperature_degC": one.temperature}
            yield alike | {"specimens": len(branches)}, branches, (low, high)


def _loading(curves: Sequence[TestCurve]) -> _Loading:
    first = [curve.take(first_loading(curve.principal, curve.branch, curve.cycle)) for curve in curves]
    stretch, stress = (np.concatenate([getattr(one, name) for one in first]) for name in ("stretch", "stress"))
    order = np.argsort(stretch, kind="stable")
    return stretch[order], stress[order]
