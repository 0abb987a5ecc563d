"""What few columns of many rows need, by the small matrix of their products."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array


def inverse(matrix: Array, rcond: float) -> Array:
    """Return the pseudo-inverse of a positive semi-definite matrix; ``rcond`` is of its rows scaled to a diagonal of 1.

    What no number is large enough for is known beyond doubt: there the inverse is 0.

    >>> inverse(np.diag([4.0, 1e-20, 0.0]), 1e-9).diagonal()
    array([2.5e-01, 1.0e+20, 0.0e+00])
    >>> inverse(np.array([[4.0, np.inf], [np.inf, np.inf]]), 1e-9).diagonal()
    array([0.25, 0.  ])
    """
    size = np.diag(matrix)
    unit = np.where(size > 0.0, 1.0 / np.sqrt(np.maximum(size, 1e-300)), 0.0)
    both = np.outer(unit, unit)
    scaled = np.multiply(matrix, both, out=np.zeros_like(both), where=both > 0.0)
    return np.asarray(np.linalg.pinv(scaled, rcond=rcond, hermitian=True) * both)


def orthonormal(matrix: Array) -> Array:
    """Return an orthonormal basis (rows, k) of what the columns of a tall matrix span."""
    norms = np.sqrt(np.sum(matrix**2, axis=0))
    scaled = matrix[:, norms > 0.0] / norms[norms > 0.0]
    # By the small Gram matrix: much quicker than a decomposition of the tall one, and exact enough to project with.
    sizes, vectors = np.linalg.eigh(scaled.T @ scaled)
    sure = sizes > 1e-11 * max(float(sizes[-1]), 1.0) if len(sizes) else np.zeros(0, dtype=bool)
    return np.asarray(scaled @ (vectors[:, sure] / np.sqrt(sizes[sure])))
