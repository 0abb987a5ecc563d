"""What entries of the catalogue are scaled to, beside tests of a fabric, and the entries of one that has none yet."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.catalogue.fabric import DataContext, entries
from hyperfab.loop.fabric_tests import curves_of, path_of, ridden_states, setups_of
from hyperfab.loop.problem import Effect
from hyperfab.materials.effects.path import Path
from hyperfab.materials.law import Law


def context_of(
    law: Law,
    warp: Sequence[float],
    path: Path,
    tests: Sequence[TestCurve],
    stress: Array,
    ridden: Collection[str],
    *,
    both: bool = False,
    turns: bool = False,
) -> DataContext:
    """Return what the entries of the catalogue are scaled to; ``both``: warp and weft have constants of their own.

    ``ridden`` are states that no replicates differ in, ``turns`` says that each direction answers in its own way.
    """
    setups = setups_of(path, tests, sized=False, ridden=ridden)
    replicated = sum(setups.count(one) > 1 for one in setups) > len(setups) / 2
    marked = all(test.on_specimen for test in tests)
    across = any(test.contraction is not None and bool(np.all(np.isfinite(test.contraction))) for test in tests)
    return DataContext(law, tuple(warp), path, stress, both, across, replicated, turns, marked)


def bare_effects(law: Law, warp: Sequence[float], tests: Sequence[TestCurve]) -> tuple[dict[str, Effect], bool]:
    """Return what may lack beside tests of a fabric that has no effects yet, by id, and whether these state times.

    As the problem of it tells, which takes as long again: the fit of its own constants is not begun.
    """
    path, _ = path_of(tests)
    stress = np.concatenate([test.stress for test in tests])
    curves, _, measured = curves_of(path, tests, stress)
    context = context_of(law, warp, path, tests, stress, ridden_states(tests, curves, measured))
    return {effect.id: effect for effect in entries(context)}, path.knows_time
