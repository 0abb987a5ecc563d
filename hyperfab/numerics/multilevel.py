"""Preconditioned conjugate gradients and the preconditioners for symmetric positive definite matrices.

A preconditioner is made for one matrix and may be kept while the matrix changes a little: the conjugate gradients
run on the true matrix. Unknowns that are held are marked; their residual counts as zero.

Levels without a coarser mesh are those of smoothed aggregation, for matrices of diffusion type, after Vanek, Mandel and
Brezina, Computing 56 (1996) 179: neighbours that are strongly coupled become one coarse unknown; the piecewise constant
prolongation is smoothed by one Jacobi step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import NotConverged
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.product import advance, begin, product, relax, remainder
from hyperfab.numerics.vectors import dot, norm

#: Couplings below this share of the geometric mean of the diagonals are weak; or below half, a quarter ... of it, until
#: there are at most a LEFT-th as many aggregates: what is stored and what is conducted may cancel between neighbours.
STRONG, LEFT = 0.08, 3
#: Matrices up to this size are factorised.
COARSEST = 1000
#: Couplings as weak as this are none.
ROUNDING = 1e-6


class Preconditioner(Protocol):
    """Something that solves A z = r roughly, by a fixed symmetric positive definite operation."""

    def apply(self, residual: Array) -> Array:
        """Return z."""


@dataclass(frozen=True)
class Solution:
    """The result of conjugate gradients: the solution, the steps it took, and |b - A x| / |b|."""

    x: Array
    iterations: int
    residual: float


def conjugate_gradients(
    matrix: sparse.csr_matrix,
    right: Array,
    preconditioner: Preconditioner,
    free: Flags | None = None,
    *,
    tolerance: float = 1e-10,
    iterations: int = 500,
) -> Solution:
    """Solve ``matrix x = right`` for a symmetric positive definite matrix, from x = 0.

    ``free`` marks the unknowns; the others stay zero. Ends when the residual has fallen by ``tolerance`` in the
    Euclidean norm, or after ``iterations`` steps: look at ``residual``.

    >>> import numpy as np; from scipy import sparse
    >>> a = sparse.csr_matrix(np.array([[4.0, 1.0], [1.0, 3.0]]))
    >>> conjugate_gradients(a, np.array([1.0, 2.0]), Direct(a)).x.round(6)
    array([0.090909, 0.636364])
    """
    mask = np.ones(len(right), dtype=bool) if free is None else free
    x = np.zeros_like(right)
    r = np.where(mask, right, 0.0)
    start = norm(r)
    if start == 0.0:
        return Solution(x, 0, 0.0)
    z = preconditioner.apply(r)
    p = z.copy()
    rho = dot(r, z)
    size = start
    for step in range(1, iterations + 1):
        q = np.where(mask, product(matrix, p), 0.0)
        alpha = rho / dot(p, q)
        advance(alpha, p, q, x, r)
        size = norm(r)
        if size <= tolerance * start:
            return Solution(x, step, size / start)
        z = preconditioner.apply(r)
        rho, before = dot(r, z), rho
        p *= rho / before
        p += z
    return Solution(x, iterations, size / start)


class Direct:
    """A sparse factorisation: exact for its matrix; memory grows like n^(4/3), so for small matrices."""

    def __init__(self, matrix: sparse.csr_matrix, free: Flags | None = None) -> None:
        self._free = np.ones(matrix.shape[0], dtype=bool) if free is None else free
        kept = matrix[self._free][:, self._free]
        self._factor = _factorise(kept)

    def apply(self, residual: Array) -> Array:
        """Return the solution for this right-hand side."""
        z = np.zeros_like(residual)
        z[self._free] = self._factor.solve(residual[self._free])
        return z


class TwoLevel:
    """A smoother on all unknowns and a coarse space below it: for degree 2 on degree 1 the fastest found.

    ``coarse`` is Pᵀ A P for the prolongation ``prolongation`` P (rows of held unknowns empty), whose transpose may be
    given as ``restriction`` where many are made on the same. The smoother is a Chebyshev polynomial of ``degree`` in
    the Jacobi-scaled matrix, before and after the coarse correction, up to its ``largest`` eigenvalue, which is
    estimated where none is given. It reads the matrix in single precision, a third less to fetch from memory: what is
    solved is the caller's own matrix.
    """

    def __init__(
        self,
        matrix: sparse.csr_matrix,
        prolongation: sparse.csr_matrix,
        coarse: Preconditioner,
        free: Flags,
        degree: int = 2,
        largest: float | None = None,
        restriction: sparse.csr_matrix | None = None,
    ) -> None:
        self._matrix = sparse.csr_matrix(
            (matrix.data.astype(np.float32), matrix.indices, matrix.indptr), shape=matrix.shape, copy=False
        )
        self._prolongation = prolongation
        self._restriction = sparse.csr_matrix(prolongation.T) if restriction is None else restriction
        self._coarse = coarse
        self._inverse = np.where(free, 1.0 / matrix.diagonal(), 0.0)
        self._degree = degree
        self.largest = 1.15 * largest_eigenvalue(matrix, self._inverse) if largest is None else largest
        self._centre, self._spread = self.largest * 0.5 * (1 + 1 / 6), self.largest * 0.5 * (1 - 1 / 6)

    def apply(self, residual: Array) -> Array:
        """Return one symmetric V-cycle from zero."""
        z = self._smooth(residual)
        r = remainder(self._matrix, z, residual)
        z += product(self._prolongation, self._coarse.apply(product(self._restriction, r)))
        z += self._smooth(remainder(self._matrix, z, residual))
        return z

    def _smooth(self, residual: Array) -> Array:
        """Return p(D^-1 A) D^-1 r, p the Chebyshev polynomial over the upper part of the spectrum."""
        change, z = begin(residual, self._inverse, self._centre)
        sigma = self._centre / self._spread
        rho = 1.0 / sigma
        for _ in range(self._degree - 1):
            rho, before = 1.0 / (2.0 * sigma - rho), rho
            weights = (2.0 * rho / self._spread) * self._inverse
            z = relax(self._matrix, z, residual, weights, change, rho * before)
        return z


def largest_eigenvalue(matrix: sparse.csr_matrix, inverse_diagonal: Array, steps: int = 15) -> float:
    """Estimate the largest eigenvalue of D^-1 A, from below, by power iteration from a fixed rough vector.

    >>> line = sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(500, 500), format="csr")
    >>> 1.85 < largest_eigenvalue(line, np.full(500, 0.5)) < 2.0
    True
    """
    x = np.random.default_rng(1).standard_normal(len(inverse_diagonal))
    x[inverse_diagonal == 0] = 0.0
    value = 1.0
    for _ in range(steps):
        x /= norm(x)
        x = inverse_diagonal * product(matrix, x)
        value = norm(x)
    return value


def _factorise(matrix: sparse.csr_matrix):  # type: ignore[no-untyped-def]
    try:
        return splu(
            sparse.csc_matrix(matrix),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        remedy = "check the orders of magnitude of the material values and loads"
        raise NotConverged(f"the equations cannot be solved ({error})", remedy=remedy) from error


def hierarchy(matrix: sparse.csr_matrix, coarsest: int = COARSEST, degree: int = 2) -> Preconditioner:
    """Return a V-cycle over aggregated levels, or a factorisation where the matrix is small.

    ``degree`` is that of the smoother.

    >>> from scipy import sparse
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
