"""Inner products without BLAS: on long vectors its threads cost more than they bring, and their number changes sums."""

from __future__ import annotations

import math

import numpy as np

from hyperfab.arrays import Array


def dot(a: Array, b: Array) -> float:
    """Return the inner product of two vectors, the same on any number of processors.

    >>> dot(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    11.0
    """
    return float(np.einsum("i,i->", a, b))


def norm(a: Array) -> float:
    """Return the Euclidean norm of a vector.

    >>> norm(np.array([3.0, 4.0]))
    5.0
    """
    return math.sqrt(dot(a, a))
