"""The strains of a foam's free sides, and the slopes of its tests by its constants, compiled."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel

#: Newton's steps to the strains of free sides, and the largest of them.
_STEPS, _STEP = 60, 0.5


@kernel
def free_strains(e: Array, free: Array, start: Array, mu: Array, alpha: Array, beta: Array) -> None:
    """Write the strain of the free sides into ``e`` (n, 3), by Newton's method from ``start`` (n,); nan where there is
    none."""
    many = free.sum()
    for i in range(len(e)):
        E, t, slope, step = e[i].sum(), start[i], 0.0, 0.0
        for _ in range(_STEPS):
            # All free sides are alike: one force and its slope, not those of three axes.
            force = slope = 0.0
            for k in range(len(mu)):
                side, volume = np.expm1(alpha[k] * t), np.expm1(-alpha[k] * beta[k] * (E + many * t))
                force += mu[k] / alpha[k] * (side - volume)
                slope += mu[k] * (1.0 + side + many * beta[k] * (1.0 + volume))
            step = -force / slope
            step = 0.0 if np.isnan(step) else min(max(step, -_STEP), _STEP)
            t += step
            if abs(step) < 1e-14:
                break
        if not (abs(step) < 1e-9 and slope > 0.0):
            t = np.nan
        for a in range(3):
            if free[a] > 0.0:
                e[i, a] += t


@kernel
def slopes(
    e: Array,
    free: Array,
    along: Array,
    lever: Array,
    mu: Array,
    alpha: Array,
    beta: Array,
    change: Array,
    moved: Array,
) -> None:
    """Write the derivatives of the stress and of the free strain by mu, alpha and nu of all terms, in this order
    (n, 3 terms), the free sides giving way."""
    terms = len(mu)
    pull, across = np.empty(3 * terms), np.empty(3 * terms)
    for i in range(len(e)):
        E = e[i].sum()
        # How the pull, and what is on the free sides, change as these move; of a pull and of a free side by constants.
        carried = stiff = 0.0
        pull[:] = 0.0
        across[:] = 0.0
        for k in range(terms):
            a, volume = alpha[k], np.exp(-alpha[k] * beta[k] * E)
            ratio = 2.0 * mu[k] * E * volume * (1.0 + 2.0 * beta[k]) ** 2
            for j in range(3):
                side = np.exp(a * e[i, j])
                part = 2.0 * (np.expm1(a * e[i, j]) - np.expm1(-a * beta[k] * E)) / a
                turn = mu[k] * (2.0 * (e[i, j] * side + beta[k] * E * volume) - part) / a
                pull[k] += along[j] * part
                pull[terms + k] += along[j] * turn
                pull[2 * terms + k] += along[j] * ratio
                across[k] += free[j] * part
                across[terms + k] += free[j] * turn
                across[2 * terms + k] += free[j] * ratio
                bulk = free.sum() * beta[k] * volume
                carried += 2.0 * mu[k] * along[j] * (free[j] * side + bulk)
                stiff += 2.0 * mu[k] * free[j] * (free[j] * side + bulk)
        for c in range(3 * terms):
            if stiff != 0.0:
                moved[i, c] = -across[c] / stiff
            change[i, c] = (pull[c] + carried * moved[i, c]) / lever[i]
