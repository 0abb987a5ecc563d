"""Stress that relaxes with time: linear viscosity on top of the elastic law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.materials.effects.path import Path
from hyperfab.materials.effects.recurrence import along
from hyperfab.materials.kinematics import Array


def relaxing(path: Path, stress: Array, weights: Sequence[float], times_s: Sequence[float]) -> Array:
    """Return the stress of Maxwell branches beside the elastic one: ``sum g_k int exp(-(t-s)/tau_k) dP(s)``.

    ``stress`` is the relaxed elastic stress at each row, taken linear in time between rows. Quasi-linear
    viscoelasticity:
    Fung (1981), Biomechanics, ch. 7; recursion of Taylor, Pister & Goudreau (1970), doi:10.1002/nme.1620020106.
    """
    first = list(path.starts[:-1])
    change = np.empty_like(stress)
    np.subtract(stress[1:], stress[:-1], out=change[1:])
    change[first] = stress[first]
    elapsed = path.waited
    total = np.zeros_like(stress)
    for weight, tau in zip(weights, times_s, strict=True):
        ratio = elapsed / tau
        keep = np.exp(-ratio)
        keep[first] = 0.0
        share = np.where(ratio > 1e-9, -np.expm1(-ratio) / np.maximum(ratio, 1e-9), 1.0)
        total += along(keep, weight * share * change)
    return total


def relaxing_bent(
    path: Path, stress: Array, weights: Sequence[float], times_s: Sequence[float], bend: float
) -> Array:
    """Return the stress of Maxwell branches driven by ``stress stretch^bend``: they stiffen or weaken.

    At ``bend`` 0 that of ``relaxing``; with a negative one the branch follows the strain rather than the stress.
    Simo (1987), doi:10.1016/0045-7825(87)90107-1: an energy of its own for the overstress.
    """
    return relaxing(path, stress * path.stretch**bend, weights, times_s)


def quickened(speed: Array, reference: float, amount: float) -> Array:
    """Return the factor ``1 + amount ln(speed/reference)`` of a strain-rate hardening law on the strain rate [1/s].

    The logarithmic law of Johnson & Cook (1983) for short ranges of rate.

    >>> quickened(np.array([0.1]), 0.1, 0.05)
    array([1.])
    """
    return np.asarray(1.0 + amount * np.log(np.maximum(speed, 1e-12) / reference))
