"""Slack in the grips: part of the measured extension only takes up play before the specimen feels it."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.kinematics import Array


def taken_up(stretch: Array, slack: float, toe: float = 0.0) -> Array:
    """Return the specimen's stretch: ``max(stretch - slack, 1)``, rounded over a strain ``toe`` where the play ends.

    A negative slack is a specimen mounted taut. ASTM D412 and D638 (toe compensation).

    >>> taken_up(np.array([1.0, 1.02, 1.5]), 0.02)
    array([1.  , 1.  , 1.48])
    """
    strain = stretch - 1.0 - slack
    if slack < 0.0:
        return np.asarray(1.0 + strain)
    if toe > 0.0:
        return np.asarray(1.0 + 0.5 * (strain + np.sqrt(strain**2 + toe**2)))
    return np.asarray(1.0 + np.maximum(strain, 0.0))
