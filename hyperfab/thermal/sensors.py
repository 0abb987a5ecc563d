"""What sensors that follow late show, of many runs at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel


def lagging(times: Array, values: Array, lag_s: Array) -> Array:
    """Return what sensors with a first-order lag show: values (b, t, p), linear between the times.

    ``lag_s`` [s] is (b,), or (b, p) where each sensor has its own.

    >>> lagging(np.array([0.0, 1.0]), np.array([[[0.0], [1.0]]]), np.array([0.0]))[0, :, 0]
    array([0., 1.])
    """
    found = values.copy()
    each = lag_s if lag_s.ndim == 2 else np.repeat(lag_s[:, None], values.shape[2], axis=1)
    if np.any(each > 0.0):
        _follow(times, values, each, found)
    return found


def as_shown(times: Array, values: Array, lags: Sequence[float]) -> Array:
    """Return what one sensor shows of ``values`` (t,): it follows by each of ``lags`` [s], one after the other.

    >>> as_shown(np.array([0.0, 1.0, 100.0]), np.array([0.0, 1.0, 100.0]), [2.0, 0.0]).round(6).tolist()
    [0.0, 0.213061, 98.0]
    """
    found = values[None, :, None]
    for lag in lags:
        found = lagging(times, found, np.array([lag]))
    return np.asarray(found[0, :, 0])


@kernel
def _follow(times, values, lag_s, found):  # type: ignore[no-untyped-def]
    for run in range(values.shape[0]):
        for probe in range(values.shape[2]):
            tau = lag_s[run, probe]
            if tau <= 0.0:
                continue
            now = values[run, 0, probe]
            known, keep, share = -1.0, 0.0, 0.0
            for i in range(1, len(times)):
                step = times[i] - times[i - 1]
                if step != known:
                    ratio = step / tau
                    known, keep, share = step, np.exp(-ratio), -np.expm1(-ratio) / ratio
                change = values[run, i, probe] - values[run, i - 1, probe]
                # The exact answer of a first-order lag to a ramp.
                now = values[run, i, probe] + keep * (now - values[run, i - 1, probe]) - share * change
                found[run, i, probe] = now
