"""Many points with rows of numbers made few: neighbours in the rows count as one, with their weights together."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.facet_operator import FacetOperator

#: Points that stand for a face in what is not linear there.
POINTS = 1000
#: Directions in which means scatter by less than this part of the most are left as they are [squared].
_FLAT = 1e-12


class Alike:
    """Points of faces that count as one: as warm as each other in all ``states`` (n,) [degC], which stand for a run.

    They pass the corners of a film's table together.
    """

    def __init__(self, states: Sequence[Array]) -> None:
        self._states = states
        self._found: dict[int, tuple[FacetOperator, list[Ints]]] = {}

    def groups(self, facets: FacetOperator) -> list[Ints]:
        """Return the numbers of the points in each group, POINTS groups at most."""
        if id(facets) not in self._found:  # kept with the facets: an id alone may come again for others
            rows = np.stack([facets.at_points(state).ravel() for state in self._states], axis=1)
            self._found[id(facets)] = facets, groups(rows, facets.weights.ravel(), POINTS)
        return self._found[id(facets)][1]


def lumped(rows: Array, weights: Array, count: int) -> tuple[Array, Array]:
    """Return at most ``count`` rows (k, r) and weights (k,) for points with ``rows`` (q, r), ``weights`` (q,).

    Groups of neighbours count as one each. Their means scatter less than the points do; they are drawn apart until
    they scatter alike, so that what is of second degree in the rows sums up to the same.

    >>> rows, weights = lumped(np.array([[0.0], [0.1], [5.0], [5.2]]), np.ones(4), 2)
    >>> rows.ravel().round(3).tolist(), weights.tolist()
    ([0.049, 5.101], [2.0, 2.0])
    """
    found = groups(rows, weights, count)
    total = np.array([weights[group].sum() for group in found])
    means = np.stack([weights[group] @ rows[group] / weights[group].sum() for group in found])
    mean = weights @ rows / weights.sum()
    away, few = rows - mean, means - mean
    values, axes = np.linalg.eigh(few.T @ (total[:, None] * few))
    kept = values > _FLAT * values[-1]
    root, back = axes[:, kept] * np.sqrt(values[kept]), axes[:, kept] / np.sqrt(values[kept])
    # The one symmetric matrix that makes the scatter of the means that of the points: it moves them least.
    seen = np.sqrt(weights)[:, None] * (away @ root)
    values, axes = np.linalg.eigh(seen.T @ seen)
    drawn = back @ ((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T) @ back.T
    return mean + few @ drawn, total


def groups(rows: Array, weights: Array, count: int) -> list[Ints]:
    """Return the points of at most ``count`` groups, by their numbers.

    The group that scatters most is halved by weight along its main axis, again and again.

    >>> [group.tolist() for group in groups(np.array([[0.0], [0.1], [5.0], [5.2]]), np.ones(4), 2)]
    [[0, 1], [2, 3]]
    """
    whole = np.arange(len(weights))
    heap: list[tuple[float, int, Ints, Array]] = []
    number = 0

    def push(group: Ints) -> None:
        nonlocal number
        w = weights[group]
        centred = rows[group] - (w @ rows[group]) / w.sum()
        values, axes = np.linalg.eigh(centred.T @ (w[:, None] * centred))
        heapq.heappush(heap, (-float(values[-1]), number, group, centred @ axes[:, -1]))
        number += 1

    push(whole)
    while len(heap) < count and -heap[0][0] > 0.0 and len(heap[0][2]) > 1:
        _, _, group, along = heapq.heappop(heap)
        order = np.argsort(along, kind="stable")
        share = np.cumsum(weights[group[order]])
        cut = min(int(np.searchsorted(share, 0.5 * share[-1])) + 1, len(group) - 1)
        push(group[order[:cut]])
        push(group[order[cut:]])
    return [group for _, _, group, _ in sorted(heap, key=lambda entry: int(entry[2].min()))]
