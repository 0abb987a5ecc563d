"""An extension beside the length of the specimen itself: over what, and whether it is counted anew."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array

#: By how much of its way an extension steps from the length beside it where it is counted anew, and at most elsewhere.
_ANEW, _ALIKE = 0.02, 0.005


def is_counted_anew(extension: Array, length: Array) -> bool:
    """Whether an extension (n,) begins anew in mid-test, and moves as the length beside it does but for that."""
    apart = np.abs(np.diff(extension - length))
    anew = apart > _ANEW * np.ptp(length)
    return bool(anew.any()) and bool(np.max(apart[~anew], initial=0.0) <= _ALIKE * np.ptp(length))


def first_length(extension: Array, length: Array) -> float | None:
    """Return by how much a length is more than the extension (n,) beside it, the gauge length; None where that changes.

    >>> far = np.array([0.0, 1.0, 4.0])
    >>> first_length(far, far + 22.0), first_length(far, 2.0 * far + 22.0)
    (22.0, None)
    """
    first = length - extension
    if np.ptp(first) > _ALIKE * np.ptp(extension) or np.min(first) <= 0.0:
        return None
    return float(np.median(first))
