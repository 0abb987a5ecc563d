"""Curves of tests in panels: one for each kind of test, by what the tests differ in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.report.labels import value_names

#: States that tell tests apart, in the order they are named, and what they may wander by within a test; one that moves
#: more does not.
_TELL = {"mode": 0.0, "direction_deg": 1.0, "temperature_degC": 2.0, "probe": 0.0}


def kinds_of_test(
    curves: Sequence[slice], states: Mapping[str, Array], words: Mapping[str, Sequence[str]]
) -> dict[str, list[int]]:
    """Return the numbers of the curves of each kind of test, named by what the kinds differ in, in that order.

    ``words`` name what the values of a state number.

    >>> curves = [slice(0, 2), slice(2, 4), slice(4, 6)]
    >>> hot = np.array([23.0, 23.1, 80.0, 80.0, 80.2, 80.1])
    >>> kinds_of_test(curves, {"temperature_degC": hot}, {})
    {'23 °C': [0], '80 °C': [1, 2]}
    """
    told: list[tuple[list[float], list[str]]] = [([], []) for _ in curves]
    for name, wander in _TELL.items():
        values = states.get(name)
        if values is None:
            continue
        means = _means([values[rows] for rows in curves], wander)
        if means is None:
            continue
        groups = clusters(means, wander)
        if len(np.unique(groups)) < 2:
            continue
        for number, group in enumerate(groups):
            told[number][0].append(float(group))
            told[number][1].append(_word(name, group, words.get(name, ())))
    found: dict[str, list[int]] = {}
    for number in sorted(range(len(curves)), key=lambda k: told[k][0]):
        found.setdefault(", ".join(told[number][1]), []).append(number)
    return found


def clusters(values: Array, apart: float) -> Array:
    """Return for each value the mean of those it stands together with, none further than ``apart`` from the next.

    >>> clusters(np.array([1.0, 5.0, 1.5]), 1.0).tolist()
    [1.25, 5.0, 1.25]
    """
    order = np.argsort(values)
    group = np.concatenate([[0], np.cumsum(np.diff(values[order]) > apart)])
    means = np.bincount(group, weights=values[order]) / np.bincount(group)
    found = np.empty_like(values)
    found[order] = means[group]
    return found


def _means(parts: Sequence[Array], wander: float) -> Array | None:
    """Return the value of each test; None where it is unknown or moves within one."""
    still = all(len(part) and np.all(np.isfinite(part)) and np.ptp(part) <= wander for part in parts)
    return np.array([float(np.mean(part)) for part in parts]) if still and parts else None


def _word(name: str, value: float, known: Sequence[str]) -> str:
    if name == "temperature_degC":
        return f"{value:.0f} °C"
    if name == "direction_deg":
        along = {0: "warp", 90: "weft"}
        return (
            along.get(round(value), f"{value:.0f}°") if abs(value - round(value)) < 0.5 else f"{value:.1f}°"
        )
    return value_names(name, [round(value)], known)[0]
