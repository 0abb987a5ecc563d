"""A loop between loading and unloading that does not depend on the rate."""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from hyperfab.materials.effects.path import Path
from hyperfab.materials.kinematics import Array


def friction(path: Path, stretch: Array, slip: Array, strain: float) -> Array:
    """Return the stress of dry friction between yarns: towards +slip when pulled, -slip when let go.

    It builds up over a stretch ``strain``: Dahl (1968), A solid friction model, Aerospace Corp. TOR-158.
    ``slip`` is the stress at which yarns slide, a row each.
    """
    index, real = path.ladder
    before = np.concatenate([stretch[:1], stretch[:-1]])
    moved = np.abs(stretch - before)
    moved[list(path.starts[:-1])] = np.abs(stretch[list(path.starts[:-1])] - 1.0)
    decay = np.exp(-moved / strain)[index]
    goal = (path.up * slip)[index]
    held = np.zeros(index.shape)
    now = np.zeros(index.shape[0])
    for step in range(index.shape[1]):
        now = goal[:, step] + (now - goal[:, step]) * decay[:, step]
        held[:, step] = now
    found = np.empty_like(stretch)
    found[index[real]] = held[real]
    return found


def unloading(path: Path, energy: Array, amount: float, scale: float) -> Array:
    """Return the factor ``1 - amount erf((Wt - W)/scale)`` on unloading from energy Wt, 1 on every loading.

    The pseudo-elastic loop that closes at each turn: Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431, with the
    damage healed when the pull begins anew.
    """
    top = energy[np.maximum(path.turn, 0)]
    factor = 1.0 - amount * erf(np.maximum(top - energy, 0.0) / scale)
    return np.asarray(np.where(path.turn >= 0, factor, 1.0))
