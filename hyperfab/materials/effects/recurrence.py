"""Recurrences along curves, compiled."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.law import Array
from hyperfab.numerics.kernels import kernel


def along(keep: Array, gain: Array) -> Array:
    """Return x with ``x[i] = keep[i] x[i-1] + gain[i]``; a curve begins where ``keep`` is zero.

    >>> along(np.array([0.0, 0.5, 0.5, 0.0]), np.array([1.0, 1.0, 1.0, 4.0]))
    array([1.  , 1.5 , 1.75, 4.  ])
    """
    found: Array = _along(np.ascontiguousarray(keep), np.ascontiguousarray(gain))
    return found


def towards(keep: Array, aim: Array) -> Array:
    """Return x that comes nearer to ``aim`` by ``1 - keep`` of what it lacks, and never back; 0 where a curve begins.

    A curve begins where ``keep`` is zero.

    >>> towards(np.array([0.0, 0.5, 0.5, 0.0]), np.array([1.0, 1.0, 0.2, 4.0]))
    array([0. , 0.5, 0.5, 0. ])
    """
    found: Array = _towards(np.ascontiguousarray(keep), np.ascontiguousarray(aim))
    return found


@kernel
def _towards(keep, aim):  # type: ignore[no-untyped-def]
    found = np.empty_like(aim)
    last = 0.0
    for i in range(len(aim)):
        last = last + (1.0 - keep[i]) * max(aim[i] - last, 0.0) if keep[i] > 0.0 else 0.0
        found[i] = last
    return found


@kernel
def _along(keep, gain):  # type: ignore[no-untyped-def]
    found = np.empty_like(gain)
    last = 0.0
    for i in range(len(gain)):
        last = keep[i] * last + gain[i]
        found[i] = last
    return found
