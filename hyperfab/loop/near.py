"""Slopes of several tests from one prediction, where each test has constants of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hyperfab.arrays import Array, Ints


def predicted_near(
    x: Array, moved: Array, of_one: Mapping[int, int], test: Ints, predict: Callable[[Array], Array]
) -> Array:
    """Return what ``predict`` does of the sets ``moved`` (b, constants) next to ``x``, (b, rows): what one test alone
    asks for is moved in all tests at once.

    ``of_one`` are these constants, by their places in ``x``, and the number of the test of each; ``test`` (rows,) that
    of each row. Curtis, Powell & Reid (1974), doi:10.1093/imamat/13.1.117.

    >>> asked = []
    >>> def predict(sets):
    ...     asked.append(len(sets))
    ...     return sets[:, [0]] + 2.0 * sets[:, 1:]
    >>> x, one_more = np.zeros(4), np.eye(4)
    >>> predicted_near(x, one_more, {1: 0, 2: 1, 3: 2}, np.arange(3), predict).tolist()
    [[1.0, 1.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> asked  # at x, the three tests together, and what all of them ask for
    [3]
    """
    alone: dict[int, tuple[int, int]] = {}
    times = np.zeros(int(np.max(test)) + 1, dtype=np.int64)
    for number, one in enumerate(moved):
        away = np.flatnonzero(one != x)
        if len(away) == 1 and int(away[0]) in of_one:
            own = of_one[int(away[0])]
            alone[number] = own, int(times[own])
            times[own] += 1
    rest = [number for number in range(len(moved)) if number not in alone]
    together = np.tile(x, (int(max(times)), 1))
    for number, (_, at) in alone.items():
        together[at] = np.where(moved[number] != x, moved[number], together[at])
    here, *told = predict(np.concatenate([x[None], together, moved[rest]]))
    found = np.empty((len(moved), len(test)))
    found[rest] = told[len(together) :] if rest else 0.0
    for number, (own, at) in alone.items():
        found[number] = np.where(test == own, told[at], here)
    return found
