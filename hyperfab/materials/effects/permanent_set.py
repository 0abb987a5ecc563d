"""Length that a pulled fabric does not give back."""

from __future__ import annotations

import numpy as np

from hyperfab.materials.kinematics import Array


def returned(stretch: Array, peak: Array, share: float) -> Array:
    """Return the elastic stretch where ``share`` of the largest strain so far stays when the load is gone.

    The first pull is the law's own; coming down, and up again to the old peak, the strain runs from the set to the peak
    on a scale of its own: ``(strain - set) peak / (peak - set)``. Below the set the fabric is slack.

    >>> returned(np.array([1.5, 1.1]), np.array([1.5, 1.5]), 0.2)
    array([1.5, 1. ])
    """
    most = peak - 1.0
    kept = share * most
    strain = (stretch - 1.0 - kept) * most / np.maximum(most - kept, 1e-12)
    return np.asarray(np.where(stretch >= peak, stretch, 1.0 + np.maximum(strain, 0.0)))


def grown(stretch: Array, peak: Array, share: float) -> Array:
    """Return the elastic stretch where the rest length has grown by ``share`` of the largest strain so far.

    With ``peak`` the largest stretch including the present pull this is plastic flow as it happens; with that of the
    earlier pulls it is a set that shows from the second pull on.

    >>> grown(np.array([1.5]), np.array([1.5]), 0.0)
    array([1.5])
    """
    return np.asarray(np.maximum(stretch / (1.0 + share * (peak - 1.0)), 1.0))
