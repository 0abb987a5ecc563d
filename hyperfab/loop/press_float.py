"""The tilt a floating female finds on a table of gaps: no moment about its joint."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.loop.press_table import PressTable
from hyperfab.loop.problem import Array

#: Steps of Newton's method, and the difference its slopes are taken over [mm, rad].
_STEPS = 12
_DIFFERENCE = np.array([1e-4, 1e-6, 1e-6])
#: A tilt [rad] beyond which the table no longer holds.
_MOST = 0.05


def loads(table: PressTable, opening: float, tilt: Array) -> Array:
    """Return the closing force [N] and the moments [N mm] about the joint at an opening and further ``tilt`` (2,)."""
    at = np.array([opening])
    turns = np.stack([table.at(at, table.shift[:, :, i])[0] for i in (0, 1)], axis=1)
    bent = turns + 0.5 * table.bend @ tilt
    pressure = table.law.stress(table.strain(table.at(at, table.gap)[0] + bent @ tilt))
    force = float(pressure @ table.at(at, table.push)[0])
    # By virtual work: the pressure acts on how the gap changes with the turn.
    return np.array([force, *((pressure * table.area) @ (turns + table.bend @ tilt))])


def found_tilt(
    table: PressTable, off: Array, opening: float, unbalanced: Callable[[float, float], float]
) -> Array:
    """Return the tilt (2,) [rad] a floating female adds to the one the table stands at.

    ``off`` (2,) [mm] is where the table's own sum has the force's arm though it balances: what a thinned sum misses.
    ``unbalanced`` tells of an opening and the table's force there what has to vanish; ``opening`` is where it does
    without the tilt.
    """
    here = np.array([opening, 0.0, 0.0])

    def residual(place: Array) -> Array:
        load = loads(table, float(place[0]), place[1:])
        return np.array([unbalanced(float(place[0]), float(load[0])), *(load[1:] - off * load[0])])

    left = residual(here)
    for _ in range(_STEPS):
        slope = np.stack([(residual(here + d) - left) / d.sum() for d in np.diag(_DIFFERENCE)], axis=1)
        if not np.all(np.isfinite(slope)) or np.linalg.matrix_rank(slope) < 3:
            break
        step = -np.linalg.solve(slope, left)
        trial = here + step * min(
            1.0, 0.2 / max(abs(step[0]), 1e-30), 0.01 / max(np.abs(step[1:]).max(), 1e-30)
        )
        trial[1:] = np.clip(trial[1:], -_MOST, _MOST)
        done = bool(np.abs(trial - here)[1:].max() < 1e-10)
        here, left = trial, residual(trial)
        if done:
            break
    return here[1:]
