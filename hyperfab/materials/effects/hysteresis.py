"""A loop between loading and unloading that does not depend on the rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Flags
from hyperfab.materials.effects.path import Acts, Path, State
from hyperfab.materials.effects.recurrence import along
from hyperfab.materials.effects.ways import each_way
from hyperfab.materials.law import Array
from hyperfab.numerics.kernels import inlined, kernel

#: Steps over a turn of friction, and between two rows at most.
_STEPS, _MOST_STEPS = 12.0, 120


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


def slid(at: State, stress: Array, values: Array) -> Array:
    """Return the stress with the friction of yarns that come to slide as sharply, and turn as stiffly, as is told.

    The load's share that slides and the stress [MPa] that does beside it, times z between -1 and 1 with
    ``dz = sign(dl) (1 - |z|^power (1 - closing + closing sign(z dl))) |dl|/turn_strain``; ``values`` are these five
    constants. Bouc (1971), Acustica 24, 16; Wen (1976), J. Eng. Mech. Div. 102, 249. ``power`` and ``closing`` 1 are
    Dahl's friction, a great ``power`` and ``closing`` 1/2 Prandtl's stop.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> pull = uniaxial_pull(np.array([1.0, 1.1, 1.5]))
    >>> state = State(pull, pull.stretch, 0.0 * pull.stretch, 20.0, None)
    >>> slid(state, np.zeros(3), np.array([0.0, 0.2, 0.1, 1.0, 1.0])).round(4)
    array([0.    , 0.1264, 0.1987])
    """
    share, level, turn, power, closing = values
    led, begins = _led(at)
    z: Array = _bouc_wen(led / turn, begins, float(power), float(closing))
    return np.asarray(stress + (share * np.abs(stress) + level) * z)


def _led(at: State) -> tuple[Array, Flags]:
    """Return by how much each row is longer than the one before, from rest, and which rows begin a test."""
    begins = np.zeros(len(at.stretch), dtype=np.bool_)
    begins[list(at.path.starts[:-1])] = True
    moved = np.abs(np.diff(at.stretch, prepend=1.0))
    moved[begins] = np.abs(at.stretch[begins] - 1.0)
    return at.path.longer * moved, begins


@kernel
def _bouc_wen(led, begins, power, closing):  # type: ignore[no-untyped-def]
    found = np.empty_like(led)
    z = 0.0
    for i in range(len(led)):
        if begins[i]:
            z = 0.0
        steps = min(int(abs(led[i]) * _STEPS) + 1, _MOST_STEPS)
        h = led[i] / steps
        for _ in range(steps):
            a = h * _pace(z, h, power, closing)
            b = h * _pace(z + 0.5 * a, h, power, closing)
            c = h * _pace(z + 0.5 * b, h, power, closing)
            d = h * _pace(z + c, h, power, closing)
            z = min(max(z + (a + 2.0 * b + 2.0 * c + d) / 6.0, -1.0), 1.0)
        found[i] = z
    return found


@inlined
def _pace(z, h, power, closing):  # type: ignore[no-untyped-def]
    along = closing if z * h > 0.0 else -closing
    return 1.0 - min(abs(z), 1.0) ** power * (1.0 - closing + along)


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
    "bouc-wen": slid,
    "stop": Yarns(("stress",), by_stress=True),
    "stop-two": Yarns(("stress", "stress"), by_stress=True),
}
#: Forms that ride on the energy.
OF_ENERGY = ("pseudo-elastic",)
#: Forms that leave a first pull as the law has it.
SPARES_FIRST_PULL = ("pseudo-elastic", "returning", "bent")
