"""A loop between loading and unloading that does not depend on the rate."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import erf

from hyperfab.materials.effects.path import Path
from hyperfab.materials.effects.recurrence import along
from hyperfab.materials.effects.state import Acts
from hyperfab.materials.kinematics import Array

#: Forms of friction: of each set of yarns, whether it slides at a share of the load or at a stress.
FRICTION = {
    "friction": ("share",),
    "dry": ("stress",),
    "friction-dry": ("share", "stress"),
    "friction-two": ("share", "share"),
    "dry-two": ("stress", "stress"),
    "stop": ("stress",),
    "stop-two": ("stress", "stress"),
}


def friction(path: Path, stretch: Array, slip: Array, strain: float) -> Array:
    """Return the stress of dry friction between yarns: towards +slip when pulled, -slip when let go.

    It builds up over a stretch ``strain``: Dahl (1968), A solid friction model, Aerospace Corp. TOR-158.
    ``slip`` is the stress at which yarns slide, a row each.
    """
    first = list(path.starts[:-1])
    moved = np.empty_like(stretch)
    np.abs(stretch[1:] - stretch[:-1], out=moved[1:])
    moved[first] = np.abs(stretch[first] - 1.0)
    keep = np.exp(-moved / strain)
    gain = path.up * slip * -np.expm1(-moved / strain)
    keep[first] = 0.0
    return along(keep, gain)


def sliding(path: Path, stretch: Array, stress: Array, form: str, values: Array) -> Array:
    """Return the friction of a form: one or two sets of yarns, each in proportion to the load or constant.

    ``values`` are pairs of a level (a share of the stress, or a stress [MPa]) and the strain over which it turns.
    """
    kinds = FRICTION[form]
    total = np.zeros_like(stress)
    if form.startswith("stop"):
        # The slide follows the stress rather than the strain: Prandtl's stop operator, rounded.
        stretch = 1.0 + stress
    for number, kind in enumerate(kinds):
        level, strain = values[2 * number], values[2 * number + 1]
        slip = level * np.abs(stress) if kind == "share" else np.full_like(stress, level)
        total = total + friction(path, stretch, slip, strain)
    return total


def returning(path: Path, stretch: Array, amount: float, power: float) -> Array:
    """Return the factor ``1 - amount (1 - (strain/turning strain)^power)`` on the way down, 1 on every way up.

    Softening measured in strain from the last turn: the form of Zuniga & Beatty (2002),
    doi:10.1016/S0020-7225(02)00140-4, healed when the pull begins anew.
    """
    top = stretch[np.maximum(path.turn, 0)] - 1.0
    share = np.clip((stretch - 1.0) / np.where(top > 0.0, top, 1.0), 1e-12, 1.0)
    return np.asarray(np.where((path.turn >= 0) & (top > 0.0), 1.0 - amount * (1.0 - share**power), 1.0))


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


def _sliding(form: str) -> Acts:
    return lambda at, stress, values: stress + sliding(at.path, at.stretch, stress, form, values)


#: What each form makes of the stress.
FORMS: Mapping[str, Acts] = {
    "pseudo-elastic": lambda at, stress, values: stress * unloading(at.path, at.energy, *values),
    "returning": lambda at, stress, values: stress * returning(at.path, at.stretch, *values),
    "bent": lambda at, stress, values: bent(at.path, stress, values[0]),
    **{form: _sliding(form) for form in FRICTION},
}
