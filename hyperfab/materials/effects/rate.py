"""Stress that relaxes with time: linear viscosity on top of the elastic law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.materials.effects.path import Path
from hyperfab.materials.kinematics import Array


def relaxing(path: Path, stress: Array, weights: Sequence[float], times_s: Sequence[float]) -> Array:
    """Return the stress of Maxwell branches beside the elastic one: ``sum g_k int exp(-(t-s)/tau_k) dP(s)``.

    ``stress`` is the relaxed elastic stress at each row, taken linear in time between rows. Quasi-linear
    viscoelasticity:
    Fung (1981), Biomechanics, ch. 7; recursion of Taylor, Pister & Goudreau (1970), doi:10.1002/nme.1620020106.
    """
    index, real = path.ladder
    first = list(path.starts[:-1])
    change = np.diff(stress, prepend=0.0)
    change[first] = stress[first]
    elapsed = np.maximum(path.elapsed, 0.0)
    total = np.zeros(index.shape)
    for weight, tau in zip(weights, times_s, strict=True):
        ratio = elapsed / tau
        decay = np.exp(-ratio)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(ratio > 1e-9, -np.expm1(-ratio) / ratio, 1.0)
        keep, gain = decay[index], (weight * share * change)[index]
        now = np.zeros(index.shape[0])
        for step in range(index.shape[1]):
            now = keep[:, step] * now + gain[:, step]
            total[:, step] += now
    found = np.empty_like(stress)
    found[index[real]] = total[real]
    return found


def quickened(speed: Array, reference: float, amount: float) -> Array:
    """Return the factor ``1 + amount ln(speed/reference)`` of a strain-rate hardening law on the strain rate [1/s].

    The logarithmic law of Johnson & Cook (1983) for short ranges of rate.

    >>> quickened(np.array([0.1]), 0.1, 0.05)
    array([1.])
    """
    return np.asarray(1.0 + amount * np.log(np.maximum(speed, 1e-12) / reference))
