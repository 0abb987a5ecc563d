"""Intel's PARDISO through PyPardiso, an optional extra (``pip install hyperfab[fast]``)."""

from __future__ import annotations

import os
import weakref
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.sparse as sparse

from hyperfab.arrays import Array

#: Matrix type: not symmetric in value, symmetric in pattern.
_TYPE = 1
_ANALYSE, _FACTORISE, _SOLVE = 11, 22, 33
#: Where the manual's one-based numbers differ from all defaults: parameters given (1), METIS (2), pivots below
#: 1e-13 disturbed (10), no scaling or matching for large entries far from the diagonal (11, 13), at most two
#: refinements (8).
_SETTINGS = {1: 1, 2: 2, 8: 2, 10: 13, 11: 0, 13: 0, 18: 0, 19: 0}


class PardisoError(ArithmeticError):
    """PARDISO gave up."""


@cache
def installed() -> bool:
    """Whether PyPardiso is there. One that cannot be loaded (no library for this machine) counts as absent."""
    if find_spec("pypardiso") is None:
        return False
    try:
        found = _new().libmkl._name
    except (ImportError, OSError):
        return False
    # PyPardiso looks through all that is installed for its library, each time anew, unless it is told where it lies.
    os.environ.setdefault("PYPARDISO_MKL_RT", found)
    return True


def _new() -> Any:
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=_TYPE)
    for number, value in _SETTINGS.items():
        solver.set_iparm(number, value)
    return solver


class Solver:
    """Matrices of one pattern: analysed once, factorised again and again."""

    def __init__(self) -> None:
        self._solver: Any = None
        self._end: weakref.finalize | None = None
        self._pattern: tuple[Array, Array] | None = None
        self.made = 0

    def factorise(self, matrix: sparse.csc_matrix) -> PardisoFactor:
        """Factorise; earlier factors end with this. Raises PardisoError."""
        # The columns of A are the rows of A'; the transposed system is solved.
        rows = sparse.csr_matrix((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape)
        known = self._pattern is not None and (
            np.array_equal(self._pattern[0], rows.indptr) and np.array_equal(self._pattern[1], rows.indices)
        )
        nothing = np.zeros(matrix.shape[0])
        if not known:
            if self._end is not None:
                self._end()
            self._solver = _new()
            self._end = weakref.finalize(self, _release, self._solver)
            # At exit the memory goes anyway, and PyPardiso can no longer be called.
            self._end.atexit = False
            self._call(_ANALYSE, rows, nothing)
            self._pattern = rows.indptr.copy(), rows.indices.copy()
        self._call(_FACTORISE, rows, nothing)
        self.made += 1
        return PardisoFactor(self, rows, self.made)

    def _call(self, phase: int, rows: sparse.csr_matrix, right: Array) -> Array:
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._solver.set_phase(phase)
        try:
            return np.asarray(self._solver._call_pardiso(rows, right))
        except PyPardisoError as error:
            raise PardisoError(str(error)) from error

    def solve(self, rows: sparse.csr_matrix, right: Array) -> Array:
        """Solve the transposed system of ``rows`` with the factor last made."""
        self._solver.set_iparm(12, 2)
        return self._call(_SOLVE, rows, right)


def _release(solver: Any) -> None:
    """Give PARDISO's memory back."""
    solver.free_memory(everything=True)


class PardisoFactor:
    """The factor last made by a solver."""

    def __init__(self, solver: Solver, rows: sparse.csr_matrix, number: int) -> None:
        self._solver, self._rows, self._number = solver, rows, number

    def solve(self, right: Array) -> Array:
        """Return x with A x = right (n,)."""
        if self._number != self._solver.made:
            raise RuntimeError("another matrix has been factorised since")
        return self._solver.solve(self._rows, np.array(right, float))
