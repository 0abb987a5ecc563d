"""A sparse matrix times a vector, and what a smoother makes of it in the same pass, on the cores there are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.threads import in_blocks

#: Entries of a matrix, and numbers of a vector, that are worth a thread's while.
ENTRIES, NUMBERS = 200_000, 50_000


def product(matrix: sparse.csr_matrix, x: Array) -> Array:
    """Return ``matrix @ x``; each row's sum, and with it the bits, do not depend on the threads.

    >>> a = sparse.csr_matrix(np.array([[4.0, 1.0], [0.0, 3.0]]))
    >>> product(a, np.array([1.0, 2.0]))
    array([6., 6.])
    """
    if matrix.nnz < 2 * ENTRIES:
        return np.asarray(matrix @ x)
    y = np.empty(matrix.shape[0])
    _in_blocks_of_rows(matrix, _rows, x, y)
    return y


def remainder(matrix: sparse.csr_matrix, x: Array, right: Array) -> Array:
    """Return ``right - matrix @ x``.

    >>> a = sparse.csr_matrix(np.array([[4.0, 1.0], [0.0, 3.0]]))
    >>> remainder(a, np.array([1.0, 2.0]), np.array([6.0, 7.0]))
    array([0., 1.])
    """
    rest = np.empty(len(right))
    _in_blocks_of_rows(matrix, _remainders, x, right, rest)
    return rest


def relax(matrix: sparse.csr_matrix, x: Array, right: Array, weights: Array, change: Array, keep: float) -> Array:
    """Return x + d for d = keep d + weights (right - matrix @ x); d is the last change and is changed in place.

    A step of a smoother with memory (Chebyshev's), the residual of each row used as soon as it is known.
    """
    after = np.empty(len(right))
    _in_blocks_of_rows(matrix, _relax, x, right, weights, change, keep, after)
    return after


def begin(right: Array, inverse: Array, centre: float) -> tuple[Array, Array]:
    """Return d = inverse right / centre, a smoother's first change, and x = d, to be relaxed further."""
    change, x = np.empty(len(right)), np.empty(len(right))
    in_blocks(lambda first, last: _begin(right, inverse, centre, change, x, first, last), len(right), NUMBERS)
    return change, x


def advance(alpha: float, p: Array, q: Array, x: Array, r: Array) -> None:
    """Add alpha p to x, and take alpha q off r, in place: a step of the conjugate gradients.

    >>> x, r = np.array([1.0, 2.0]), np.array([3.0, 4.0])
    >>> advance(2.0, np.array([1.0, 0.0]), np.array([0.0, 1.0]), x, r)
    >>> x.tolist(), r.tolist()
    ([3.0, 2.0], [3.0, 2.0])
    """
    in_blocks(lambda first, last: _advance(alpha, p, q, x, r, first, last), len(x), NUMBERS)


def _in_blocks_of_rows(matrix: sparse.csr_matrix, work: Callable[..., None], *given: Array | float) -> None:
    """Call ``work`` with a matrix and what else is ``given`` for the first and last row of each block.

    Where rows begin, and their columns, are unsigned numbers: numba asks no sign, a fourth of the time.
    """
    kind = np.uint32 if matrix.indices.itemsize == 4 else np.uint64
    arrays = matrix.indptr.view(kind), matrix.indices.view(kind), matrix.data
    rows = max(1, matrix.shape[0] * ENTRIES // max(1, matrix.nnz))
    in_blocks(lambda first, last: work(*arrays, *given, first, last), matrix.shape[0], rows)


@kernel
def _begin(right: Array, inverse: Array, centre: float, change: Array, x: Array, first: int, last: int) -> None:
    for i in range(first, last):
        change[i] = inverse[i] * right[i] / centre
        x[i] = change[i]


@kernel
def _advance(alpha: float, p: Array, q: Array, x: Array, r: Array, first: int, last: int) -> None:
    for i in range(first, last):
        x[i] += alpha * p[i]
        r[i] -= alpha * q[i]


# Each row is summed in two sums that do not wait for each other: a fifth less time. The loop stands three times: in a
# function of its own, inlined or not, it takes nearly twice as long.


@kernel
def _rows(indptr: Ints, indices: Ints, data: Array, x: Array, y: Array, first: int, last: int) -> None:
    one = np.uint32(1)  # as the indices, without a sign
    for i in range(first, last):
        even, odd, k, end = 0.0, 0.0, indptr[i], indptr[i + 1]
        while k + one < end:
            even += data[k] * x[indices[k]]
            odd += data[k + one] * x[indices[k + one]]
            k += np.uint32(2)
        if k < end:
            even += data[k] * x[indices[k]]
        y[i] = even + odd


@kernel
def _remainders(
    indptr: Ints, indices: Ints, data: Array, x: Array, right: Array, rest: Array, first: int, last: int
) -> None:
    one = np.uint32(1)  # as the indices, without a sign
    for i in range(first, last):
        even, odd, k, end = 0.0, 0.0, indptr[i], indptr[i + 1]
        while k + one < end:
            even += data[k] * x[indices[k]]
            odd += data[k + one] * x[indices[k + one]]
            k += np.uint32(2)
        if k < end:
            even += data[k] * x[indices[k]]
        rest[i] = right[i] - (even + odd)


@kernel
def _relax(
    indptr: Ints, indices: Ints, data: Array, x: Array, right: Array, weights: Array, change: Array, keep: float,
    after: Array, first: int, last: int,
) -> None:  # fmt: skip
    one = np.uint32(1)  # as the indices, without a sign
    for i in range(first, last):
        even, odd, k, end = 0.0, 0.0, indptr[i], indptr[i + 1]
        while k + one < end:
            even += data[k] * x[indices[k]]
            odd += data[k + one] * x[indices[k + one]]
            k += np.uint32(2)
        if k < end:
            even += data[k] * x[indices[k]]
        change[i] = keep * change[i] + weights[i] * (right[i] - (even + odd))
        after[i] = x[i] + change[i]
