"""The door to sparse direct solvers: one name for all, the fastest that can be used behind it.

- Symmetric and positive definite, on a mesh: Cholesky front by front (multifrontal.py). Always there.
- Not symmetric: PARDISO where PyPardiso is installed (``pip install hyperfab[fast]``), about twice SuperLU's speed.
- Everything else, and wherever those give up: scipy's SuperLU.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from hyperfab.arrays import Array
from hyperfab.errors import HyperfabError
from hyperfab.numerics import pardiso
from hyperfab.numerics.multifrontal import CholeskyFactor, Elimination, NotPositiveDefiniteError


class SingularMatrixError(HyperfabError):
    """The matrix has no inverse."""


class SuperLUFactor:
    """A matrix factorised by scipy's SuperLU, minimum degree on A + A', pivots on the diagonal.

    >>> SuperLUFactor(sparse.csc_matrix([[4.0, 1.0], [1.0, 3.0]])).solve(np.array([1.0, 2.0])).round(6)
    array([0.090909, 0.636364])
    """

    name = "SuperLU"

    def __init__(self, matrix: sparse.csc_matrix) -> None:
        try:
            self._factor = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularMatrixError(str(error)) from error

    def solve(self, right: Array) -> Array:
        """Return x with A x = right, a vector or columns; SingularMatrixError where it is not finite."""
        return _finite(np.asarray(self._factor.solve(right)))

    def negative_pivots(self, noise: float = 0.0) -> int:
        """Return the number of pivots below zero by more than ``noise`` of the median one.

        For a symmetric matrix it is the number of negative eigenvalues.
        """
        pivots = self._factor.U.diagonal()
        return int((pivots < -noise * float(np.median(np.abs(pivots)))).sum())


@dataclass
class _Behind:
    """Cholesky's factor behind the door, or PARDISO's, of a matrix that is not symmetric."""

    name: str
    factor: CholeskyFactor | pardiso.PardisoFactor

    def solve(self, right: Array) -> Array:
        return _finite(self.factor.solve(right))

    def negative_pivots(self, noise: float = 0.0) -> int:
        if not isinstance(self.factor, CholeskyFactor):
            raise NotImplementedError("pivots of a matrix that is not symmetric")
        return 0


#: A factorised matrix; ``name`` is the solver's.
Factor = SuperLUFactor | _Behind


class DirectSolver:
    """Factorises matrices of one pattern, and keeps what hangs on the pattern alone.

    ``plan`` says how to eliminate front by front, where the mesh is known.
    """

    def __init__(self, plan: Callable[[], Elimination] | None = None) -> None:
        self._plan = plan
        #: Names of the solvers that have been used.
        self.used: set[str] = set()
        self._pardiso = pardiso.Solver()

    def factorise(self, matrix: sparse.csc_matrix, *, symmetric: bool = True) -> Factor:
        """Factorise a matrix. The last factor alone can be relied on. Raises SingularMatrixError."""
        factor = self._factor(matrix, symmetric)
        self.used.add(factor.name)
        return factor

    def _factor(self, matrix: sparse.csc_matrix, symmetric: bool) -> Factor:
        if symmetric and self._plan is not None:
            try:
                return _Behind("Cholesky by fronts", CholeskyFactor(self._plan(), matrix.data))
            except NotPositiveDefiniteError:
                pass
        if not symmetric and pardiso.installed():
            try:
                return _Behind("PARDISO", self._pardiso.factorise(matrix))
            except pardiso.PardisoError as error:
                raise SingularMatrixError(str(error)) from error
        return SuperLUFactor(matrix)


def _finite(found: Array) -> Array:
    if not np.isfinite(found).all():
        raise SingularMatrixError("the solution is not finite")
    return found
