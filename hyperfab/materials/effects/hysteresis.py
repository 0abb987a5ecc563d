"""A loop between loading and unloading that does not depend on the rate."""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from hyperfab.materials.effects.path import Path
from hyperfab.materials.effects.recurrence import along
from hyperfab.materials.kinematics import Array


def friction(path: Path, stretch: Array, slip: Array, strain: float) -> Array:
    """Return the stress of dry friction between yarns: towards +slip when pulled, -slip when let go.

    It builds up over a stretch ``strain``: Dahl (1968), A solid friction model, Aerospace Corp. TOR-158.
    ``slip`` is the stress at which yarns slide, a row each.
    """
    first = list(path.starts[:-1])
    moved = np.abs(np.diff(stretch, prepend=1.0))
    moved[first] = np.abs(stretch[first] - 1.0)
    keep = np.exp(-moved / strain)
    gain = path.up * slip * -np.expm1(-moved / strain)
    keep[first] = 0.0
    return along(keep, gain, path.longest)


def unloading(path: Path, energy: Array, amount: float, scale: float) -> Array:
    """Return the factor ``1 - amount erf((Wt - W)/scale)`` on unloading from energy Wt, 1 on every loading.

    The pseudo-elastic loop that closes at each turn: Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431, with the
    damage healed when the pull begins anew.
    """
    top = energy[np.maximum(path.turn, 0)]
    factor = 1.0 - amount * erf(np.maximum(top - energy, 0.0) / scale)
    return np.asarray(np.where(path.turn >= 0, factor, 1.0))


def bent(path: Path, stress: Array, amount: float) -> Array:
    """Return the stress with each way down bent: ``Pt (P/Pt)^(1 + amount)`` from the stress Pt where it turned.

    A power law between the turn and rest, as measured ways down of knitted fabrics are often described.
    """
    top = stress[np.maximum(path.turn, 0)]
    share = np.clip(stress / np.where(top > 0.0, top, 1.0), 1e-12, None)
    return np.asarray(
        np.where((path.turn >= 0) & (top > 0.0) & (stress > 0.0), top * share ** (1.0 + amount), stress)
    )
