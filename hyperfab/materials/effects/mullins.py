"""Softening of rubber and fabric below the largest stretch they have seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hyperfab.materials.effects.path import Acts, Path, State
from hyperfab.materials.effects.recurrence import towards
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.effects.ways import amount as amount_of_each_way
from hyperfab.materials.effects.ways import each_way
from hyperfab.materials.law import Array


def softened(energy: Array, greatest: Array, amount: float, scale: float, beta: float = 0.0) -> Array:
    """Return the factor ``1 - amount erf((Wm - W) / (scale + beta Wm))`` on the stress, 1 on the first pull.

    ``amount`` is 1/r. Ogden & Roxburgh (1999), Proc. R. Soc. A 455, 2861, doi:10.1098/rspa.1999.0431, with
    the ``beta`` of Mars and of Dorfmann.

    >>> softened(np.array([1.0]), np.array([1.0]), 0.5, 0.1)
    array([1.])
    """
    from scipy.special import erf

    return np.asarray(1.0 - amount * erf(np.maximum(greatest - energy, 0.0) / (scale + beta * greatest)))


def weakened(
    stretch: Array, peak: Array, amount: float, power: float, outer: float = 1.0, growth: float = 0.0
) -> Array:
    """Return ``1 - amount (1 - (strain/peak strain)^power)^outer``: softening measured in strain, 1 at the peak.

    With ``growth`` the amount goes with that power of the peak strain (over 1/2). A factor of strain amplification
    that is 1 on the first pull: Zuniga & Beatty (2002), doi:10.1016/S0020-7225(02)00140-4.

    >>> weakened(np.array([1.5]), np.array([1.5]), 0.3, 1.0)
    array([1.])
    """
    most = np.maximum(peak - 1.0, 1e-12)
    share = np.clip((stretch - 1.0) / most, 1e-12, 1.0)
    below = np.maximum(1.0 - share**power, 0.0)
    if outer != 1.0:
        below = np.where(below > 0.0, np.maximum(below, 1e-300) ** outer, 0.0)
    return np.asarray(np.maximum(1.0 - amount * (most / 0.5) ** growth * below, 0.0))


def worn(stretch: Array, peak: Array, turns: Array, amount: float, power: float, kept: float) -> Array:
    """Return the factor of ``weakened`` where each turn takes its share: ``amount (1 - kept^turns)``.

    ``turns`` counts how often the specimen was let go so far. At ``kept`` 0 the first turn does it all.
    Diani, Fayolle & Gilormini (2009), doi:10.1016/j.eurpolymj.2008.11.017: softening goes on over some cycles.

    >>> worn(np.array([1.5]), np.array([2.0]), np.array([1.0]), 0.4, 1.0, 0.0)
    array([0.8])
    """
    share = np.clip((stretch - 1.0) / np.maximum(peak - 1.0, 1e-12), 1e-12, 1.0)
    return np.asarray(1.0 - amount * (1.0 - kept**turns) * (1.0 - share**power))


def damaged(peak: Array, amount: float, strain: float, power: float = 1.0) -> Array:
    """Return the factor ``1 - amount (1 - exp(-((peak - 1)/strain)^power))``: damage by the largest stretch.

    Simo (1987), Comput. Methods Appl. Mech. Eng. 60, 153, doi:10.1016/0045-7825(87)90107-1.

    >>> damaged(np.array([1.0]), 0.5, 0.3)
    array([1.])
    """
    return np.asarray(1.0 + amount * np.expm1(-(((peak - 1.0) / strain) ** power)))


def damaged_on_the_way(path: Path, amount: float, strain: float, power: float, way: float) -> Array:
    """Return the factor of damage that comes as the specimen is led on, out and back, over a strain ``way``.

    It nears ``amount (1 - exp(-(em/strain)^power))`` of the largest strain em so far, and never goes back: the first
    cycles to a stretch go on softening. Lion (1996), Continuum Mech. Thermodyn. 8, 153, doi:10.1007/BF01181853.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> pulls = uniaxial_pull(np.array([1.0, 1.5, 1.0, 1.5]))
    >>> damaged_on_the_way(pulls, 0.5, 0.1, 1.0, 0.5).round(3)
    array([1.   , 0.686, 0.571, 0.528])
    """
    first = list(path.starts[:-1])
    keep = np.exp(-np.abs(np.diff(path.stretch, prepend=1.0)) / way)
    keep[first] = 0.0
    return np.asarray(1.0 - towards(keep, 1.0 - damaged(path.peak, amount, strain, power)))


def worn_smoothly(at: State, stress: Array, values: Array, *, by_energy: bool = False) -> Array:
    """Return the stress of a fabric whose wear is a smooth function of the largest strain em so far.

    ``P (1 - lost(em/reach) - depth(em/reach) (1 - kept^n) (1 - (e/em)^power)^outer)``, n the number of returns:
    ``values`` are the reach, ``power``, ``outer`` and ``kept``, then ``depth`` and ``lost`` at thirds of the reach.
    ``by_energy`` the root of the strain energy stands for the strain, the reach is one of energy [MPa].
    """
    reach, power, outer, kept = values[:4]
    if by_energy:
        most, now = np.sqrt(np.maximum(at.greatest, 0.0) / reach), np.sqrt(np.maximum(at.energy, 0.0) / reach)
    else:
        most, now = (at.path.peak - 1.0) / reach, (at.path.stretch - 1.0) / reach
    most = np.maximum(most, 1e-12 / reach)
    depth, lost = (through(most, part) for part in np.split(values[4:], 2))
    share = np.clip(now / most, 1e-12, 1.0)
    below = np.maximum(1.0 - share**power, 1e-300) ** outer * (share < 1.0)
    gone = 1.0 - np.power(max(kept, 1e-12), np.maximum(at.path.returns, 1.0))
    return np.asarray(stress * np.maximum(1.0 - lost - depth * gone * below, 0.0))


def taken_at_rest(path: Path, form: str, values: Array) -> float:
    """Return the greatest share of the load that softening takes, towards rest, from specimens on their way back.

    Where it is 1 and more a specimen is slack over a stretch, which is a set and no softening. Of a smooth law it is
    told where that has its values; 0 of the forms whose own bounds hold it.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> taken_at_rest(uniaxial_pull(np.array([2.0, 1.5])), "strain-shape", np.array([0.3, 1.0, 1.0, 1.0]))
    0.6
    """
    back = path.stretch < path.peak
    taken = TAKES.get(form)
    return 0.0 if taken is None or not np.any(back) else float(np.max(taken(path, values)[back]))


def _taken_by_strain(path: Path, values: Array) -> Array:
    amount, _, _, growth = values
    return np.asarray(amount * (np.maximum(path.peak - 1.0, 1e-12) / 0.5) ** growth)


def _taken_smoothly(path: Path, values: Array) -> Array:
    depth, lost = np.split(values[4:], 2)
    gone = 1.0 - np.power(max(values[3], 1e-12), np.maximum(path.returns, 1.0))
    return np.asarray(np.max(lost + np.outer(gone, np.maximum(depth, 0.0)), axis=1))


def _taken_each_way(path: Path, values: Array) -> Array:
    return np.asarray(amount_of_each_way(path, *values[-2:]) * _taken_smoothly(path, values[:-2]))


def _worn_by_energy(at: State, stress: Array, values: Array) -> Array:
    return worn_smoothly(at, stress, values, by_energy=True)


def _by_energy(at: State, stress: Array, values: Array) -> Array:
    return stress * softened(at.energy, at.greatest, *values)


def _by_strain(at: State, stress: Array, values: Array) -> Array:
    return stress * weakened(at.path.stretch, at.path.peak, *values)


def _by_damage(at: State, stress: Array, values: Array) -> Array:
    return stress * damaged(at.path.peak, *values)


#: What each form makes of the stress, and those that ride on the energy.
FORMS: Mapping[str, Acts] = {
    "pseudo-elastic": _by_energy,
    "pseudo-elastic-beta": _by_energy,
    "strain": _by_strain,
    "strain-shape": _by_strain,
    "strain-cycles": lambda at, stress, values: stress * worn(at.path.stretch, at.path.peak, at.path.returns, *values),
    "smooth": worn_smoothly,
    "smooth-energy": _worn_by_energy,
    "smooth-each-way": each_way(worn_smoothly),
    "smooth-energy-each-way": each_way(_worn_by_energy),
    "damage": _by_damage,
    "damage-power": _by_damage,
    "damage-way": lambda at, stress, values: stress * damaged_on_the_way(at.path, *values),
}
#: What those forms take towards rest, as a share of the load, whose bounds do not hold it.
TAKES: Mapping[str, Callable[[Path, Array], Array]] = {
    "strain-shape": _taken_by_strain,
    "smooth": _taken_smoothly,
    "smooth-energy": _taken_smoothly,
    "smooth-each-way": _taken_each_way,
    "smooth-energy-each-way": _taken_each_way,
}
#: Forms that leave a first pull as the law has it.
SPARES_FIRST_PULL = ("pseudo-elastic", "pseudo-elastic-beta", "strain", "strain-shape", "strain-cycles")
