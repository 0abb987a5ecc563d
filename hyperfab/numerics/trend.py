"""What goes along with a few numbers, from where it is known."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array

#: What places tell of the coefficients by less than this part of what they tell best, they do not tell: places along
#: a few lines say nothing of what numbers do together, and places drawn at random tell all by 0.015 and more.
_TOLD = 0.01


class Trend:
    """A vector that goes with numbers (k,) as a polynomial of second degree, by least squares.

    It is known from a quarter as many places more on than it has coefficients, and stays what it is then. What these
    places do not tell is left out of it.

    >>> trend = Trend()
    >>> for x, y in np.random.default_rng(1).normal(size=(9, 2)):
    ...     trend.add(np.array([x, y]), np.array([1.0 + x * y]))
    >>> trend.at(np.array([2.0, 3.0])).round(9).tolist()
    [7.0]
    """

    def __init__(self) -> None:
        self._rows: list[Array] = []
        self._values: list[Array] = []
        self._found: Array | None = None

    def _row(self, numbers: Array) -> Array:
        return np.concatenate([[1.0], numbers, np.outer(numbers, numbers)[np.triu_indices(len(numbers))]])

    def add(self, numbers: Array, value: Array) -> None:
        """Take in what there is at some numbers."""
        if self._found is not None:
            return
        self._rows.append(self._row(numbers))
        self._values.append(value)
        if 4 * len(self._rows) >= 5 * len(self._rows[0]):
            rows = np.array(self._rows)
            scale = np.abs(rows).max(axis=0)
            scale[scale == 0.0] = 1.0
            found, *_ = np.linalg.lstsq(rows / scale, np.array(self._values), rcond=_TOLD)
            self._found = found / scale[:, None]

    def at(self, numbers: Array) -> Array | None:
        """Return what there is at other numbers, None where it is not known yet."""
        return None if self._found is None else np.asarray(self._row(numbers) @ self._found)
