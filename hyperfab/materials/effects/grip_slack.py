"""What grips take of the extension that is measured: play, and what gives or slips under the load."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hyperfab.materials.effects.path import Path
from hyperfab.materials.effects.smooth import CLOSER, through
from hyperfab.materials.law import Array

#: Places on the way to the reach at which it is asked what the specimen had.
_PLACES = np.linspace(0.0, 1.0, 401)


def taken_up(stretch: Array, slack: float | Array, toe: float | Array = 0.0) -> Array:
    """Return the specimen's stretch: ``max(stretch - slack, 1)``, rounded over a strain ``toe`` where the play ends.

    A negative slack is a specimen mounted taut. ASTM D412 and D638 (toe compensation).

    >>> taken_up(np.array([1.0, 1.02, 1.5]), 0.02)
    array([1.  , 1.  , 1.48])
    """
    strain = stretch - 1.0 - slack
    pulled = 0.5 * (strain + np.sqrt(strain**2 + np.square(toe)))
    return np.asarray(1.0 + np.where(np.asarray(slack) < 0.0, strain, pulled))


def given(stretch: Array, reach: float, values: Array) -> Array:
    """Return the specimen's stretch where what the grips give is a smooth function of the strain read.

    ``values`` are what they give at even parts of the logarithm of the strain, ``ln(1 + 20 e/reach)`` to the reach:
    most of it is given at the start. They never give more than they part by: the specimen keeps what stretch it had.

    >>> given(np.array([1.0, 1.5]), 0.5, np.array([0.01, 0.02]))
    array([1.  , 1.48])
    >>> early, late = given(np.array([1.1, 1.5]), 0.5, np.array([0.0, 0.45]))
    >>> bool(late >= early > 1.09)
    True
    """
    strain = stretch - 1.0
    less = strain - _smoothly(strain, reach, values)
    before = reach * np.expm1(np.log1p(CLOSER) * _PLACES) / CLOSER
    kept = np.maximum.accumulate(before - _smoothly(before, reach, values))
    less = np.maximum(less, kept[np.searchsorted(before, np.maximum(strain, 0.0), side="right") - 1])
    return np.asarray(1.0 + np.where(strain > 0.0, np.maximum(less, 0.0), strain))


def yielded(stretch: Array, steps: Array, gives: Array, stays: bool = False) -> Array:
    """Return the stretch (n,) of a specimen in one test whose grips give as it is stretched.

    ``steps`` (m,) are stretches of the specimen, rising from 1, and ``gives`` (m,) what the grips give there: the
    strain read is both together. What ``stays`` is not taken back on the way back.

    >>> steps = np.array([1.0, 1.1, 1.2])
    >>> yielded(np.array([1.0, 1.12, 1.01]), steps, 0.2 * (steps - 1.0)).round(9)
    array([1.        , 1.1       , 1.00833333])
    >>> yielded(np.array([1.0, 1.12, 1.05]), steps, 0.2 * (steps - 1.0), stays=True).round(9)
    array([1.  , 1.1 , 1.03])
    """
    reads = np.maximum.accumulate(steps + gives)
    if stays:
        most = np.maximum(np.maximum.accumulate(stretch), 1.0)
        found = np.maximum(stretch - most + np.interp(most, reads, steps), 1.0)
    else:
        found = np.interp(stretch, reads, steps)
    return np.asarray(np.where(stretch > 1.0, found, stretch))


def _smoothly(measure: Array, far: float, values: Array) -> Array:
    place = np.log1p(CLOSER * np.maximum(measure, 0.0) / far) / np.log1p(CLOSER)
    return through(place, values)


def _curved(share: Array, curve: float) -> Array:
    """Return what rises from 0 to 1 with the share, and less and less the larger ``curve`` is.

    >>> _curved(np.array([0.0, 0.5, 1.0]), 2.0).round(6), _curved(np.array([0.5]), 0.0)
    (array([0.      , 0.731059, 1.      ]), array([0.5]))
    """
    return np.asarray(share if curve < 1e-6 else np.expm1(-curve * share) / np.expm1(-curve))


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


def _askew(stretch: Array, slack: Array, width: float) -> Array:
    """Return the stretch of specimens mounted askew: the more that one edge is longer, the wider the toe."""
    return taken_up(stretch, slack, width * slack)


#: The specimen's stretch in each form: of the path, the stretch read, and the form's constants.
_Takes = Callable[[Path, Array, Array], Array]


def _as_length(takes: _Takes) -> _Takes:
    """Return a form of what grips take as a length: as strain of the first specimen whose length is stated."""

    def found(path: Path, stretch: Array, values: Array) -> Array:
        if path.shorter is None:
            return takes(path, stretch, values)
        return np.asarray(1.0 + (takes(path, 1.0 + (stretch - 1.0) / path.shorter, values) - 1.0) * path.shorter)

    return found


_FORMS: Mapping[str, _Takes] = {
    "play": lambda path, stretch, values: taken_up(stretch, *values),
    "toe": lambda path, stretch, values: taken_up(stretch, *values),
    "each": lambda path, stretch, values: taken_up(stretch, of_each(path, values)),
    "each-toe": lambda path, stretch, values: taken_up(stretch, of_each(path, values[:-1]), values[-1]),
    "each-askew": lambda path, stretch, values: _askew(stretch, of_each(path, values[:-1]), values[-1]),
    "smooth": lambda path, stretch, values: given(stretch, values[0], values[1:]),
}
FORMS: Mapping[str, _Takes] = {name: _as_length(takes) for name, takes in _FORMS.items()}
#: What the grips give in the forms that ask for it: of the load [MPa], never below zero, that the specimen bears.
OF_LOAD: Mapping[str, Callable[[Array, Array], Array]] = {
    "yields": lambda load, values: values[1] / values[0] * load,
    "yields-curved": lambda load, values: values[1] * _curved(load / values[0], values[2]),
    "slips": lambda load, values: values[1] / values[0] * np.maximum(load - values[2], 0.0),
    "smooth-force": lambda load, values: _smoothly(load, values[0], values[1:]),
    "smooth-slip": lambda load, values: _smoothly(load, values[0], values[1:]),
}
#: The forms that are smooth functions: of the strain read, or of the load.
_SMOOTH = ("smooth", "smooth-force", "smooth-slip")
#: The forms that bend the curve as another law would.
BENDS = ("smooth", "yields", "yields-curved", "smooth-force")
#: Those of the load by which the specimen has slipped: what was given is not taken back.
STAYS = ("slips", "smooth-slip")


def taken_back(form: str, values: Array, reach: float) -> Array:
    """Return by how much the grips give less at each place told than at the one before, over the strain ``reach``: what
    rises under a rising load as the specimen is pulled on is not taken back on the way. None of forms that only rise.

    >>> taken_back("smooth", np.array([0.5, 0.01, 0.03, 0.02]), 0.5)
    array([-0.04,  0.02])
    """
    return np.asarray(-np.diff(values[1:]) / reach if form in _SMOOTH else np.empty(0))
