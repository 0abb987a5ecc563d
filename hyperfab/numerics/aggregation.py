"""Smoothed aggregation: an algebraic hierarchy for symmetric positive definite matrices of diffusion type.

After Vanek, Mandel and Brezina, Computing 56 (1996) 179. Neighbours that are strongly coupled become one coarse
unknown; the piecewise constant prolongation is smoothed by one Jacobi step.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from hyperfab.arrays import Ints
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.multilevel import Direct, Preconditioner, TwoLevel, largest_eigenvalue

#: Couplings below this share of the geometric mean of the diagonals are weak; or below half, a quarter ... of it, until
#: there are at most a LEFT-th as many aggregates: what is stored and what is conducted may cancel between neighbours.
STRONG, LEFT = 0.08, 3
#: Matrices up to this size are factorised.
COARSEST = 1000
#: Couplings as weak as this are none.
ROUNDING = 1e-6


def hierarchy(matrix: sparse.csr_matrix, coarsest: int = COARSEST, degree: int = 2) -> Preconditioner:
    """Return a V-cycle over aggregated levels, or a factorisation where the matrix is small.

    ``degree`` is that of the smoother.

    >>> from scipy import sparse
    >>> from hyperfab.numerics.multilevel import conjugate_gradients
    >>> line = sparse.diags([-1.0, 2.001, -1.0], [-1, 0, 1], shape=(3000, 3000), format="csr")
    >>> conjugate_gradients(line, np.ones(3000), hierarchy(line)).iterations < 25
    True
    """
    size = matrix.shape[0]
    if size <= coarsest:
        return Direct(matrix)
    aggregate, count = aggregates(matrix)
    if count == size:
        return Direct(matrix)  # a diagonal, but for rounding
    inverse = 1.0 / matrix.diagonal()
    rows = np.arange(size)
    constant = sparse.csr_matrix((np.ones(size), (rows, aggregate)), shape=(size, count))
    damping = 4.0 / 3.0 / largest_eigenvalue(matrix, inverse)
    step = sparse.diags(damping * inverse) @ (matrix @ constant)
    prolongation = sparse.csr_matrix(constant - step)
    coarse = sparse.csr_matrix(prolongation.T @ (matrix @ prolongation))
    free = np.ones(size, dtype=bool)
    return TwoLevel(matrix, prolongation, hierarchy(coarse, coarsest, degree), free, degree)


def aggregates(matrix: sparse.csr_matrix) -> tuple[Ints, int]:
    """Return the aggregate of each unknown (n,) and their number."""
    strong, diagonal = STRONG, matrix.diagonal()
    while True:
        found, count = _aggregate(matrix.indptr, matrix.indices, matrix.data, diagonal, strong)
        if count * LEFT <= len(diagonal) or strong < ROUNDING:
            return found, int(count)
        strong *= 0.5


@kernel
def _aggregate(indptr, indices, data, diagonal, strong):  # type: ignore[no-untyped-def]
    n = len(indptr) - 1
    aggregate = np.full(n, -1, dtype=np.int64)
    count = 0
    for i in range(n):  # a node all of whose strong neighbours are still free starts an aggregate of them
        if aggregate[i] >= 0:
            continue
        alone = True
        for p in range(indptr[i], indptr[i + 1]):
            j = indices[p]
            if data[p] ** 2 > strong**2 * diagonal[i] * diagonal[j] and aggregate[j] >= 0:
                alone = False
                break
        if alone:
            for p in range(indptr[i], indptr[i + 1]):
                j = indices[p]
                if data[p] ** 2 > strong**2 * diagonal[i] * diagonal[j]:
                    aggregate[j] = count
            aggregate[i] = count
            count += 1
    started = count
    joined = aggregate.copy()
    for i in range(n):  # the rest join the aggregate they are coupled to most strongly
        if aggregate[i] >= 0:
            continue
        best, best_value = -1, 0.0
        for p in range(indptr[i], indptr[i + 1]):
            j = indices[p]
            if j != i and 0 <= aggregate[j] < started and abs(data[p]) > best_value:
                best, best_value = aggregate[j], abs(data[p])
        if best >= 0:
            joined[i] = best
        else:
            joined[i] = count
            count += 1
    return joined, count
