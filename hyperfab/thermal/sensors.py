"""What sensors that follow late show, of many runs at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def lagging(times: Array, values: Array, lag_s: Array) -> Array:
    """Return what sensors with a first-order lag show: values (b, t, p), linear between the times.

    ``lag_s`` [s] is (b,), or (b, p) where each sensor has its own.

    >>> lagging(np.array([0.0, 1.0]), np.array([[[0.0], [1.0]]]), np.array([0.0]))[0, :, 0]
    array([0., 1.])
    """
    found = values.copy()
    each = lag_s if lag_s.ndim == 2 else lag_s[:, None]
    slow = np.flatnonzero(np.any(each > 0.0, axis=1))
    if len(slow) == 0:
        return found
    tau = np.maximum(each[slow], 1e-9)
    now = values[slow, 0]
    for i in range(1, len(times)):
        ratio = (times[i] - times[i - 1]) / tau
        keep = np.exp(-ratio)
        share = -np.expm1(-ratio) / ratio
        change = values[slow, i] - values[slow, i - 1]
        # The exact answer of a first-order lag to a ramp.
        now = values[slow, i] + keep * (now - values[slow, i - 1]) - share * change
        found[slow, i] = now
    return found
