"""How far the mold is pushed up: the depth, the states asked for on the way, and the load steps between them."""

from __future__ import annotations

import numpy as np

from hyperfab.cloth.law import Floats
from hyperfab.errors import UsageError
from hyperfab.io import units

#: Load steps to the full depth where friction makes the way matter.
LOAD_STEPS = 20
MOST_STATES = 1000


def read_depths(depth: str, states: int | None, depths: str | None) -> list[float]:
    """Depths in mm at which the sheet is wanted, rising; the last is how far the mold is pushed."""
    if depths is not None:
        if states is not None:
            raise UsageError("--states and --depths both say where the sheet is wanted; give one of them")
        found = [
            units.quantity(part, "length", option="--depths") for part in depths.split(",") if part.strip()
        ]
        if not found or min(found) < 0.0 or len(set(found)) < len(found) or len(found) > MOST_STATES:
            raise UsageError(f"--depths {depths}: different depths of 0mm or more; write 20mm,40mm,60mm")
        return sorted(found)
    rise = units.quantity(depth, "length", option="--depth")
    if rise < 0.0:
        raise UsageError(f"--depth {depth}: the mold is pushed up by 0mm or more")
    if states is None or rise == 0.0:
        return [rise]
    if not 1 <= states <= MOST_STATES:
        raise UsageError(f"--states {states}: from 1 to {MOST_STATES}; write 6 for six equal depths")
    return [rise * (k + 1) / states for k in range(states)]


def load_steps(depths: list[float], steps: int | None) -> Floats:
    """Heights of the mold at which a sheet that rubs comes to rest: about equal steps that meet all ``depths``."""
    if steps is not None and steps < 1:
        raise UsageError(f"--load-steps {steps}: 1 or more")
    if depths[-1] == 0.0:
        return np.zeros(1)
    pace = depths[-1] / (steps or LOAD_STEPS)
    heights, last = [], 0.0
    for depth in depths:
        count = max(1, round((depth - last) / pace)) if depth > last else 0
        heights += [last + (depth - last) * (k + 1) / count for k in range(count)]
        last = depth
    if depths[0] == 0.0:
        heights.insert(0, 0.0)
    return np.array(heights)
