"""Long vectors: inner products without BLAS, whose threads cost more than they bring and change sums; rows; planes."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.threads import in_blocks

N = TypeVar("N", bound=np.generic)

#: Rows to gather that are worth a thread's while.
_ROWS = 50_000


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


def cross2(u: Array, v: Array) -> Array:
    """Return the cross products of vectors in the plane (..., 2): twice the area between them, positive to the left.

    >>> float(cross2(np.array([1.0, 0.0]), np.array([5.0, 2.0])))
    2.0
    """
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def rows(a: NDArray[N], places: Ints) -> NDArray[N]:
    """Return ``a[places]``, gathered on the cores there are and in a third of the time.

    >>> rows(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([1, -1, 0])).tolist()
    [[3.0, 4.0], [3.0, 4.0], [1.0, 2.0]]
    """
    result = np.empty(places.shape + a.shape[1:], a.dtype)

    def gather(first: int, last: int) -> None:
        np.take(a, places[first:last], axis=0, out=result[first:last])

    in_blocks(gather, len(places), _ROWS)
    return result
