"""The time steps of a reduced mold, compiled: small dense matrices, one run at a time."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def march(  # type: ignore[no-untyped-def]
    grid,
    start,
    mass0,
    conduct0,
    joint,
    jumps,
    closed,
    mean,
    numbers,
    rows,
    weights,
    owner,
    scale,
    extra,
    grey,
    air,
    knots,
    values,
    first,
    sources,
    powers,
):
    """Step through ``grid``; one Newton step a stage from a guess of first order, exact for linear films."""
    n, r = len(grid), len(start)
    reference, capacity_rate, conduction_rate, lost, lost_rate, exponent = numbers
    states, slopes = np.zeros((n, r)), np.zeros((n, r))
    states[0] = start
    slope = np.zeros(r)
    for number in range(n - 1):
        step = grid[number + 1] - grid[number]
        g = 0.2928932188134524 * step
        a = states[number]
        base = a.copy()
        guess = a + g * slope
        mass = mass0 * (1.0 + capacity_rate * (mean @ (a + 0.5 * step * slope) - reference))
        for stage in range(2):
            warm = mean @ guess - reference
            tangent = conduct0 * (1.0 + conduction_rate * warm)
            for j in range(len(joint)):
                tangent = tangent + joint[j] * closed[number, stage, j] * jumps[j]
            flow = -(tangent @ guess)
            at = rows @ guess
            rate = np.zeros(len(at))
            loss = np.zeros(len(at))
            for q in range(len(at)):
                face = owner[q]
                away = at[q] - air[number, stage, face]
                h = extra[face]
                if scale[face] != 0.0:
                    film = np.interp(
                        at[q], knots[first[face] : first[face + 1]], values[first[face] : first[face + 1]]
                    )
                    film = film * scale[face]
                    if exponent != 0.0:
                        film = film * (max(abs(away), 0.5) / 30.0) ** exponent
                    h += film
                loss[q] = h * away
                rate[q] = h * (1.0 + max(exponent, 0.0))
                if grey[face] != 0.0:
                    hot, cold = at[q] + 273.15, air[number, stage, face] + 273.15
                    loss[q] += grey[face] * 5.670374419e-8 * (hot**4 - cold**4)
                    rate[q] += 4.0 * grey[face] * 5.670374419e-8 * hot**3
            flow -= rows.T @ (loss * weights)
            weighted = rows.copy()
            for q in range(len(at)):
                weighted[q] *= rate[q] * weights[q]
            tangent = tangent + rows.T @ weighted
            share = 1.0 - lost - lost_rate * warm
            for j in range(sources.shape[0]):
                flow += share * powers[number, stage, j] * sources[j]
            residual = mass @ (base - guess) + g * flow
            end = guess + np.linalg.solve(mass + g * tangent, residual)
            if stage == 0:
                rise = (end - base) / g
                base = a + (step - g) * rise
                guess = base + g * rise
            else:
                slope = (end - base) / g
        states[number + 1] = end
        slopes[number + 1] = slope
    return states, slopes
