"""Where the constants of a law that is not linear in them may begin, beside the values of the document."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hyperfab.loop.problem import Array, Constant
from hyperfab.materials.effects.path import BIAXIAL, GENERAL, MODE_NAMES, Path
from hyperfab.materials.identification.design import Problem as LawProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Curve, Rows
from hyperfab.materials.law import Law

#: Rows that are enough to find the valley; the loop's own fit sees all.
_ROWS = 240


def best_by_law(law: Law, path: Path, stress: Array, own: Sequence[Constant], sets: int) -> tuple[Array, ...]:
    """Return the constants of ``law`` that fit all rows best, ``sets`` times (warp and weft), before the others.

    None for a law that is linear in its constants, whose one optimum any start finds. A document's constants, from few
    tests, may lie in another valley than these data, or beyond the stretch where the law ends.
    """
    if not law.nonlinear or not law.isotropic:
        return ()
    rows = np.flatnonzero((path.mode != GENERAL) & (path.stretch > 0.0) & np.isfinite(stress))
    if len(rows) == 0:
        return ()
    # The farthest row of each mode among them: a law must not end before it.
    modes = np.unique(path.mode[rows])
    ends = [max(rows[path.mode[rows] == mode], key=lambda row: path.stretch[row]) for mode in modes]
    rows = np.union1d(rows[:: max(len(rows) // _ROWS, 1)], ends)
    weight = np.full(len(rows), 1.0 / max(float(np.max(np.abs(stress))), 1e-300))
    curves = [
        Curve(MODE_NAMES[mode], path.stretch[rows][there], stress[rows][there], weight[there])
        for mode in range(BIAXIAL + 1)
        if np.any(there := path.mode[rows] == mode)
    ]
    found = fit_law(LawProblem(law, Rows.of(curves)))
    if found is None:
        return ()
    values = np.array([found.material.parameters[name] for name in law.names])
    given = np.array([constant.value for constant in own])
    given[: sets * len(values)] = np.tile(values, sets)
    held: NDArray[np.bool_] = np.array([constant.low == constant.high for constant in own])
    return (np.where(held, [constant.value for constant in own], given),)
