"""The constants of a fabric's law as the loop moves them, and where it begins: combinations where they cancel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.curve import TestCurve
from hyperfab.loop.problem import Constant
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import BIAXIAL, GENERAL, MODE_NAMES, Path
from hyperfab.materials.hyperfoam import HyperfoamLaw
from hyperfab.materials.identification.design import Problem as LawProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.law import Law

#: Rows that are enough to find the valley of a law's constants; the loop's own fit sees all.
_VALLEY = 240
#: Constants of a law are combined where tests tell one combination of them so much less than another; what is told so
#: little as not at all.
_TOLD_APART, _TOLD = 1e-3, 1e-9
#: How many times the largest stress that one of a law's constants makes they may come to make where tests do not tell.
_STAYS = 3.0


def constants_of(
    fabric: Fabric,
    ways: Mapping[str, Sequence[float]],
    stress: Array,
    had: Sequence[Constant],
    fixed: Sequence[str] = (),
    prior: float | None = None,
) -> tuple[tuple[Constant, ...], tuple[Array, ...], Array | None]:
    """Return the model's own constants, where fits of them begin beside their values, and ``combinations``.

    ``ways`` are the values of the law's constants by what comes before their names; ``had`` follow them. Where the
    constants of a polynomial cancel, so far off that no number tells how their sum changes, the own ones are
    combinations that the tests ``fabric`` predicts tell apart: their columns (constants, combinations), else None.
    """
    law, size = fabric.law, float(np.max(np.abs(stress)))
    columns = None
    if prior is None and not fixed and law.isotropic and not law.nonlinear and not isinstance(law, HyperfoamLaw):
        columns = np.stack([fabric.stress(one, None, {}) for one in np.eye(len(law.names))], axis=1)
    combinations = None if columns is None else _combinations(columns, size)
    if columns is None or combinations is None:
        own = [one for way, values in ways.items() for one in _plain(law, values, way, size, fixed, prior)]
        return (*own, *had), _best_by_law(law, fabric.path, stress, [*own, *had], len(ways)), None
    made = np.linalg.norm(columns, axis=0) / (size * np.sqrt(len(columns)))
    own = [one for way, values in ways.items() for one in _combined(combinations, made, values, way)]
    best = np.linalg.lstsq(columns @ combinations, stress, rcond=None)[0]
    return (*own, *had), (np.array([*np.tile(best, len(ways)), *(one.value for one in had)]),), combinations


def _plain(
    law: Law, values: Sequence[float], way: str, size: float, fixed: Sequence[str], prior: float | None
) -> list[Constant]:
    """Return the constants of a law themselves."""
    found = []
    for name, value in zip(law.names, values, strict=True):
        low, high = law.bounds.get(name, (-np.inf, np.inf))
        low, high = min(low, value), max(high, value)  # a document's own constants stand
        scale = max(abs(value), 0.01 * size if name in law.stresses else 0.1)
        sd = np.inf if prior is None else max(prior * abs(value), 1e-9 * size)
        if name in law.held or name in fixed or f"{way}{name}" in fixed:
            low = high = value
        found.append(Constant(f"{way}{name}", value, low, high, scale, sd))
    return found


def _combinations(columns: Array, size: float) -> Array | None:
    """Return the combinations of constants, each of which makes a stress of ``size`` in the mean of all rows.

    ``columns`` (rows, constants) are the stresses of each constant at one. None where the constants themselves serve.
    """
    norms = np.linalg.norm(columns, axis=0)
    if not np.all(np.isfinite(norms)) or not np.all(norms):
        return None
    _, told, combined = np.linalg.svd(columns / norms, full_matrices=False)
    if len(told) < len(norms) or told[-1] > _TOLD_APART * told[0]:
        return None
    length = size * np.sqrt(len(columns)) / np.maximum(told, _TOLD * told[0])
    return np.asarray(combined.T / norms[:, None] * length)


def _combined(combinations: Array, made: Array, values: Sequence[float], way: str) -> list[Constant]:
    """Return the combinations that make the ``values`` of a law's constants, and how near to these they stay.

    ``made`` is the mean stress of each constant at one. What no test tells else wanders as far as its noise asks for.
    """
    given = np.asarray(values, dtype=np.float64)
    own = np.linalg.solve(combinations, given)
    far = _STAYS * float(np.max(np.abs(given) * made)) / np.linalg.norm(combinations * made[:, None], axis=0)
    pairs = enumerate(zip(own, far, strict=True), 1)
    return [Constant(f"{way}combination {number}", float(value), prior_sd=float(sd)) for number, (value, sd) in pairs]


def _best_by_law(law: Law, path: Path, stress: Array, own: Sequence[Constant], sets: int) -> tuple[Array, ...]:
    """Return the constants of ``law`` that fit all rows best, ``sets`` times (warp and weft), before the others.

    None for a law that is linear in its constants, whose one optimum any start finds, and of a foam, whose fit seeks it
    among many. A document's constants, from few tests, may lie in another valley than these data, or beyond the
    stretch where the law ends.
    """
    if not law.nonlinear or not law.isotropic or isinstance(law, HyperfoamLaw):
        return ()
    rows = np.flatnonzero((path.mode != GENERAL) & (path.stretch > 0.0) & np.isfinite(stress))
    if len(rows) == 0:
        return ()
    # The farthest row of each mode among them: a law must not end before it.
    modes = np.unique(path.mode[rows])
    ends = [max(rows[path.mode[rows] == mode], key=lambda row: path.stretch[row]) for mode in modes]
    rows = np.union1d(rows[:: max(len(rows) // _VALLEY, 1)], ends)
    weight = np.full(len(rows), 1.0 / max(float(np.max(np.abs(stress))), 1e-300))
    curves = [
        TestCurve(MODE_NAMES[mode], path.stretch[rows][there], stress[rows][there], weight[there])
        for mode in range(BIAXIAL + 1)
        if np.any(there := path.mode[rows] == mode)
    ]
    found = fit_law(LawProblem(law, Rows.of(curves)))
    if found is None:
        return ()
    values = np.array([found.material.parameters[name] for name in law.names])
    given = np.array([constant.value for constant in own])
    given[: sets * len(values)] = np.tile(values, sets)
    held: Flags = np.array([constant.low == constant.high for constant in own])
    return (np.where(held, [constant.value for constant in own], given),)
