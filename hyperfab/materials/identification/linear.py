"""Least squares with scaled columns: alone, for a stack of matrices, with constants of a given sign; and of curved
equations in a box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.materials.law import Array

#: A column this small beside the first one after elimination is a copy of the others.
_RANK = 1e-14


@dataclass(frozen=True)
class Projection:
    """min |b - A c| for a stack of matrices: constants ``c``, residual, its square sum, and the basis Q of A."""

    c: Array
    residual: Array
    sse: Array
    Q: Array


def project(A: Array, b: Array) -> Projection:
    """Solve min |b - A c| by QR of A with columns of length one; A has shape (..., rows, constants).

    >>> project(np.array([[1.0], [1.0]]), np.array([1.0, 3.0])).c
    array([2.])
    """
    length = np.sqrt(np.einsum("...ij,...ij->...j", A, A))
    length = np.where(length > 0.0, length, 1.0)
    Q, R = np.linalg.qr(A / length[..., None, :])
    diagonal = np.einsum("...jj->...j", R)
    weak = np.abs(diagonal) < _RANK
    if weak.any():
        R = R + weak[..., None] * np.eye(R.shape[-1]) * _RANK
    beta = np.einsum("...ij,i->...j", Q, b)
    c = np.linalg.solve(R, beta[..., None])[..., 0]
    residual = b - np.einsum("...ij,...j->...i", Q, beta)
    # One step of refinement: what rounding left along Q is taken out too.
    correction = np.einsum("...ij,...i->...j", Q, residual)
    residual = residual - np.einsum("...ij,...j->...i", Q, correction)
    return Projection(c / length, residual, np.einsum("...i,...i->...", residual, residual), Q)


def lengths(A: Array) -> Array:
    """Return the lengths of the columns of a matrix, 1 where there is nothing in one."""
    length = np.sqrt((A * A).sum(axis=0))
    return np.where(length > 0.0, length, 1.0)


def least_norm(A: Array, b: Array) -> Array:
    """Solve min |b - A c|; where columns are copies of each other, share the constants evenly among them.

    >>> least_norm(np.ones((2, 2)), np.array([2.0, 2.0])).round(12)
    array([1., 1.])
    """
    found = project(A, b)
    length = lengths(A)
    s = np.linalg.svd(A / length, compute_uv=False)
    if s[-1] > 1e-13 * s[0]:
        return found.c
    return np.asarray(np.linalg.lstsq(A / length, b, rcond=1e-13)[0] / length)


def nonnegative(A: Array, b: Array) -> Array:
    """Return c >= 0 that minimises |b - A c| (Lawson & Hanson, on columns of length one).

    >>> nonnegative(np.eye(2), np.array([1.0, -1.0]))
    array([1., 0.])
    """
    from scipy.optimize import nnls  # half a fit's time to load: only constants held stable need it

    length = lengths(A)
    return np.asarray(nnls(A / length, b, maxiter=100 * A.shape[1])[0] / length)


def least_in_box(
    equations: Callable[[Array], tuple[Array, Array]],
    start: Array,
    bounds: tuple[Array, Array],
    steps: int,
    scale: ArrayLike | str = 1.0,
    gain: float = 1e-15,
) -> tuple[Array, float]:
    """Return where the square sum of curved ``equations`` is least near a ``start`` (k,) inside a box, and half of it.

    ``equations`` returns errors (n,) and their derivatives (n, k) at a place; what is not finite there counts as far
    off. ``scale`` are the sizes of natural steps, ``jac`` those that the derivatives tell; it ends where a step lowers
    the sum by less than a share ``gain``.

    >>> box = np.zeros(1), np.full(1, 9.0)
    >>> least_in_box(lambda z: (z**2 - 2.0, np.diag(2.0 * z)), np.ones(1), box, 50)[0].round(9)
    array([1.41421356])
    """
    from scipy.optimize import least_squares  # 0.3 s to load: only fits of foams and whole sheets need it

    last: dict[bytes, tuple[Array, Array]] = {}

    def both(z: Array) -> tuple[Array, Array]:
        if z.tobytes() not in last:
            last.clear()
            error, slope = equations(z)
            last[z.tobytes()] = np.nan_to_num(np.clip(error, -1e6, 1e6), nan=1e6), np.nan_to_num(slope)
        return last[z.tobytes()]

    with np.errstate(all="ignore"):
        found = least_squares(
            lambda z: both(z)[0], start, jac=lambda z: both(z)[1], bounds=bounds, x_scale=scale,
            xtol=1e-15, ftol=gain, gtol=1e-15, max_nfev=steps,
        )  # fmt: skip
    return found.x, float(found.cost)
