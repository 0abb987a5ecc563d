"""Slack in the grips: part of the measured extension only takes up play before the specimen feels it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hyperfab.materials.effects.path import Path, second_stretch
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.kinematics import Array

#: How much more closely what the grips give is told at the start than at the end.
_CLOSE = 20.0


def taken_up(stretch: Array, slack: float | Array, toe: float = 0.0) -> Array:
    """Return the specimen's stretch: ``max(stretch - slack, 1)``, rounded over a strain ``toe`` where the play ends.

    A negative slack is a specimen mounted taut. ASTM D412 and D638 (toe compensation).

    >>> taken_up(np.array([1.0, 1.02, 1.5]), 0.02)
    array([1.  , 1.  , 1.48])
    """
    strain = stretch - 1.0 - slack
    if np.ndim(slack):
        return np.asarray(np.where(np.asarray(slack) < 0.0, 1.0 + strain, 1.0 + np.maximum(strain, 0.0)))
    if slack < 0.0:
        return np.asarray(1.0 + strain)
    if toe > 0.0:
        return np.asarray(1.0 + 0.5 * (strain + np.sqrt(strain**2 + toe**2)))
    return np.asarray(1.0 + np.maximum(strain, 0.0))


def given(stretch: Array, reach: float, values: Array, load: Array | None = None) -> Array:
    """Return the specimen's stretch where what the grips give is a smooth function of the strain read, or of ``load``.

    ``values`` are what they give at even parts of the logarithm of the strain, ``ln(1 + 20 e/reach)`` to the reach:
    most of it is given at the start.

    >>> given(np.array([1.0, 1.5]), 0.5, np.array([0.01, 0.02]))
    array([1.  , 1.48])
    """
    strain = stretch - 1.0
    measure = np.maximum(strain if load is None else load, 0.0)
    place = np.log1p(_CLOSE * measure / reach) / np.log1p(_CLOSE)
    less = strain - through(place, values)
    return np.asarray(1.0 + np.where(strain > 0.0, np.maximum(less, 0.0), strain))


def pulls(path: Path, stretch: Array) -> Array:
    """Return the load of a sheet at a stretch, over a third of its Young's modulus: that of neo-Hooke's in each mode.

    >>> from hyperfab.materials.effects.path import uniaxial_pull
    >>> pulls(uniaxial_pull(np.array([1.0, 2.0])), np.array([1.0, 2.0]))
    array([0.  , 1.75])
    """
    side = second_stretch(path.mode, stretch, stretch**-0.5, path.across)
    return np.asarray(stretch - 1.0 / (stretch**3 * side**2))


def of_each(path: Path, values: Array) -> Array:
    """Return one value a row: the first of ``values`` for the first curve, and that plus its own for each other.

    Curves beyond those told, not measured yet, get the mean.
    """
    return by_curve(path, np.concatenate([values[:1], values[0] + values[1:]]))


def by_curve(path: Path, told: Array) -> Array:
    """Return one value a row, as ``told`` of its curve; of curves beyond those told the mean."""
    found = np.full(len(path.stretch), float(np.mean(told)))
    for value, rows in zip(told, path.curves, strict=False):
        found[rows] = value
    return found


#: The specimen's stretch in each form: of the path, the stretch read, and the form's constants.
FORMS: Mapping[str, Callable[[Path, Array, Array], Array]] = {
    "play": lambda path, stretch, values: taken_up(stretch, *values),
    "toe": lambda path, stretch, values: taken_up(stretch, *values),
    "each": lambda path, stretch, values: taken_up(stretch, of_each(path, values)),
    "smooth": lambda path, stretch, values: given(stretch, values[0], values[1:]),
    "smooth-load": lambda path, stretch, values: given(stretch, values[0], values[1:], pulls(path, stretch)),
}
