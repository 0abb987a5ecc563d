"""A linear recurrence along curves, in a few passes over whole arrays."""

from __future__ import annotations

from hyperfab.materials.kinematics import Array


def along(keep: Array, gain: Array, longest: int) -> Array:
    """Return x with ``x[i] = keep[i] x[i-1] + gain[i]``; a curve begins where ``keep`` is zero.

    ``longest`` is the number of rows of the longest curve. Prefix doubling: Hillis & Steele (1986),
    doi:10.1145/7902.7903.

    >>> import numpy as np
    >>> along(np.array([0.0, 0.5, 0.5, 0.0]), np.array([1.0, 1.0, 1.0, 4.0]), 3)
    array([1.  , 1.5 , 1.75, 4.  ])
    """
    keep, found = keep.copy(), gain.copy()
    reach = 1
    while reach < longest:
        found[reach:] += keep[reach:] * found[:-reach]
        keep[reach:] = keep[reach:] * keep[:-reach]
        reach *= 2
    return found
