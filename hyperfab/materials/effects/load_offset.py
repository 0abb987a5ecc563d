"""A load cell that does not read zero at rest."""

from __future__ import annotations

from hyperfab.materials.kinematics import Array


def shifted(stress: Array, offset: float, time: Array | None = None, drift: float = 0.0) -> Array:
    """Return ``stress + offset + drift time``: offset in the stress's unit, drift in it per second.

    >>> import numpy as np
    >>> shifted(np.array([0.0, 1.0]), 0.01)
    array([0.01, 1.01])
    """
    return stress + offset if time is None else stress + offset + drift * time
