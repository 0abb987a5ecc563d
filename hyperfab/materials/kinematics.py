"""The plane-stress state of an incompressible sheet: two in-plane stretches, the thickness follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


@dataclass(frozen=True)
class Sheet:
    """In-plane principal stretches ``l1``, ``l2`` (same shape, dimensionless) of a sheet with l1 l2 l3 = 1.

    All derivatives are along the two in-plane stretches, with the thickness stretch eliminated. The
    invariants are measured from rest and computed without cancellation, so that stresses keep their digits
    at small strain.

    >>> Sheet.of(2.0, 1.0).x
    array(2.25)
    """

    l1: Array
    l2: Array

    @classmethod
    def of(cls, l1: ArrayLike, l2: ArrayLike) -> Sheet:
        """Return the state for stretches of any shape that broadcast against each other."""
        first, second = np.broadcast_arrays(np.asarray(l1), np.asarray(l2))
        kind = np.result_type(first, second, np.float64)
        return cls(first.astype(kind), second.astype(kind))

    @cached_property
    def l3(self) -> Array:
        """Thickness stretch."""
        return 1.0 / (self.l1 * self.l2)

    @cached_property
    def logs(self) -> tuple[Array, Array, Array]:
        """Logarithms of the three stretches."""
        one, two = np.log(self.l1), np.log(self.l2)
        return one, two, -(one + two)

    @cached_property
    def x(self) -> Array:
        """I1 - 3 = l1^2 + l2^2 + l3^2 - 3."""
        return _from_rest(self.l1, self.l2)

    @cached_property
    def y(self) -> Array:
        """I2 - 3 = l1^-2 + l2^-2 + l3^-2 - 3."""
        return _from_rest(1.0 / self.l1, 1.0 / self.l2)

    @cached_property
    def x_1(self) -> Array:
        """d I1 / d l1."""
        return np.asarray(2.0 * (self.l1 - self.l3) * (self.l1 + self.l3) / self.l1)

    @cached_property
    def x_2(self) -> Array:
        """d I1 / d l2."""
        return np.asarray(2.0 * (self.l2 - self.l3) * (self.l2 + self.l3) / self.l2)

    @cached_property
    def x_second(self) -> tuple[Array, Array, Array]:
        """Second derivatives of I1: 11, 12, 22."""
        a, b = self.l3 / self.l1, self.l3 / self.l2
        return 2.0 + 6.0 * a * a, 4.0 * a * b, 2.0 + 6.0 * b * b

    @cached_property
    def y_second(self) -> tuple[Array, Array, Array]:
        """Second derivatives of I2: 11, 12, 22."""
        one, two = self.l1, self.l2
        return 6.0 / one**4 + 2.0 * two**2, 4.0 * one * two, 6.0 / two**4 + 2.0 * one**2


def _from_rest(a: Array, b: Array) -> Array:
    """Return a^2 + b^2 + (a b)^-2 - 3 as a sum of squares."""
    p = a * b
    return np.asarray((a - b) ** 2 + ((p - 1.0) / p) ** 2 * (2.0 * p + 1.0))
