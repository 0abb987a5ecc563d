"""The door to sparse direct solvers: one name for all, the fastest that is installed behind it."""

from __future__ import annotations

import warnings
from typing import Protocol

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from hyperfab.errors import HyperfabError

Array = NDArray[np.float64]


class SingularMatrixError(HyperfabError):
    """The matrix has no inverse."""


class Factor(Protocol):
    """A factorised matrix."""

    def solve(self, right: Array) -> Array:
        """Return x with A x = right, for a vector or for columns."""
        ...


class SuperLUFactor:
    """A symmetric matrix factorised by scipy's SuperLU, minimum degree on A + A', pivots on the diagonal."""

    def __init__(self, matrix: sparse.csc_matrix) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self._factor = splu(
                    matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
                )
        except (RuntimeError, Warning) as error:
            raise SingularMatrixError(str(error)) from error

    def solve(self, right: Array) -> Array:
        """Return the solution; SingularMatrixError where it is not finite."""
        found = np.asarray(self._factor.solve(right))
        if not np.isfinite(found).all():
            raise SingularMatrixError("the solution is not finite")
        return found

    def negative_pivots(self, noise: float = 0.0) -> int:
        """Return the number of pivots below zero by more than ``noise`` of the median one.

        For a symmetric matrix it is the number of negative eigenvalues.
        """
        pivots = self._factor.U.diagonal()
        return int((pivots < -noise * float(np.median(np.abs(pivots)))).sum())


def factorise(matrix: sparse.csc_matrix) -> SuperLUFactor:
    """Factorise a symmetric sparse matrix.

    Raises SingularMatrixError.

    >>> factorise(sparse.csc_matrix([[4.0, 1.0], [1.0, 3.0]])).solve(np.array([1.0, 2.0])).round(6)
    array([0.090909, 0.636364])
    """
    return SuperLUFactor(matrix)
