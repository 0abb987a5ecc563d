"""A loop between loading and unloading that does not depend on the rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.effects.path import Acts, Path, State
from hyperfab.materials.effects.recurrence import along
from hyperfab.materials.effects.ways import each_way
from hyperfab.materials.law import Array


@dataclass(frozen=True)
class Yarns:
    """Sets of yarns that slide, each at a ``share`` of the load or at a ``stress``.

    ``by_stress``: the slide follows the stress rather than the strain: Prandtl's stop operator, rounded.
    """

    kinds: tuple[str, ...]
    by_stress: bool = False

    def __call__(self, at: State, stress: Array, values: Array) -> Array:
        """Return the stress with the friction of all sets.

        ``values`` are pairs of a level (a share of the stress, or a stress [MPa]) and the strain over which it turns.
        """
        total = np.zeros_like(stress)
        stretch = 1.0 + stress if self.by_stress else at.stretch
        for number, kind in enumerate(self.kinds):
            level, strain = values[2 * number], values[2 * number + 1]
            slip = level * np.abs(stress) if kind == "share" else np.full_like(stress, level)
            total = total + friction(at.path, stretch, slip, strain)
        return stress + total


def friction(path: Path, stretch: Array, slip: Array, strain: Array | float) -> Array:
    """Return the stress of dry friction between yarns: towards +slip when pulled, -slip when let go.

    It builds up over a stretch ``strain``: Dahl (1968), A solid friction model, Aerospace Corp. TOR-158.
    ``slip`` is the stress at which yarns slide, a row each.
    """
    first = list(path.starts[:-1])
    moved = np.empty_like(stretch)
    np.abs(stretch[1:] - stretch[:-1], out=moved[1:])
    moved[first] = np.abs(stretch[first] - 1.0)
    keep = np.exp(-moved / strain)
    gain = path.longer * slip * -np.expm1(-moved / strain)
    keep[first] = 0.0
    return along(keep, gain)


def friction_of_many(at: State, stress: Array, values: Array) -> Array:
    """Return the stress with the friction of four sets of yarns that turn over a hundredth to a half of ``reach``.

    ``values`` are the reach, the share of the load at which each set slides, the stress [MPa] at which it slides
    beside that, the power of the stretch with which both grow, and that with which the strains do over which sets turn
    (1: friction by the logarithm of the stretch). The spectrum of Prandtl and Ishlinskii, rounded: Visintin (1994),
    Differential Models of Hysteresis, ch. III.
    """
    reach, *loads, growth, widening = values
    shares, levels = np.split(np.array(loads), 2)
    grown, wider = at.stretch**growth, at.stretch**widening
    total = np.zeros_like(stress)
    for strain, share, level in zip(np.geomspace(0.01, 0.5, len(shares)), shares, levels, strict=True):
        if share or level:
            slip = (share * np.abs(stress) + level) * grown
            total = total + friction(at.path, at.stretch, slip, reach * strain * wider)
    return np.asarray(stress + total)


def returning(path: Path, stretch: Array, amount: float, power: float) -> Array:
    """Return the factor ``1 - amount (1 - (strain/turning strain)^power)`` on the way down, 1 on every way up.

    Softening measured in strain from the last turn: the form of Zuniga & Beatty (2002),
    doi:10.1016/S0020-7225(02)00140-4, healed when the pull begins anew.
    """
    top = stretch[np.maximum(path.turn, 0)] - 1.0
    share = np.clip((stretch - 1.0) / np.where(top != 0.0, top, 1.0), 1e-12, 1.0)
    return np.asarray(np.where((path.turn >= 0) & (top != 0.0), 1.0 - amount * (1.0 - share**power), 1.0))


def unloading(path: Path, energy: Array, amount: float, scale: float) -> Array:
    """Return the factor ``1 - amount erf((Wt - W)/scale)`` on unloading from energy Wt, 1 on every loading.

    The pseudo-elastic loop that closes at each turn: Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431, with the
    damage healed when the pull begins anew.
    """
    from scipy.special import erf

    top = energy[np.maximum(path.turn, 0)]
    factor = 1.0 - amount * erf(np.maximum(top - energy, 0.0) / scale)
    return np.asarray(np.where(path.turn >= 0, factor, 1.0))


def bent(path: Path, stress: Array, amount: float) -> Array:
    """Return the stress with each way down bent: ``Pt (P/Pt)^(1 + amount)`` from the stress Pt where it turned.

    A power law between the turn and rest, as measured ways down of knitted fabrics are often described.
    """
    if amount == 0.0:
        return stress  # to the bit
    top = stress[np.maximum(path.turn, 0)]
    share = np.clip(stress / np.where(top != 0.0, top, 1.0), 1e-12, None)
    alike = (path.turn >= 0) & (top * stress > 0.0)
    return np.asarray(np.where(alike, top * share ** (1.0 + amount), stress))


#: What each form makes of the stress.
FORMS: Mapping[str, Acts] = {
    "pseudo-elastic": lambda at, stress, values: stress * unloading(at.path, at.energy, *values),
    "returning": lambda at, stress, values: stress * returning(at.path, at.stretch, *values),
    "bent": lambda at, stress, values: bent(at.path, stress, values[0]),
    "friction": Yarns(("share",)),
    "dry": Yarns(("stress",)),
    "friction-dry": Yarns(("share", "stress")),
    "friction-two": Yarns(("share", "share")),
    "dry-two": Yarns(("stress", "stress")),
    "smooth": friction_of_many,
    "smooth-each-way": each_way(friction_of_many),
    "stop": Yarns(("stress",), by_stress=True),
    "stop-two": Yarns(("stress", "stress"), by_stress=True),
}
#: Forms that ride on the energy.
OF_ENERGY = ("pseudo-elastic",)
#: Forms that leave a first pull as the law has it.
SPARES_FIRST_PULL = ("pseudo-elastic", "returning", "bent")
