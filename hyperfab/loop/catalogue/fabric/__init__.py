"""What a strain-energy law lacks on tests of a fabric."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.curve import TestCurve
from hyperfab.loop.catalogue.fabric.context import DataContext as DataContext
from hyperfab.loop.catalogue.fabric.context import context_of as context_of
from hyperfab.loop.catalogue.fabric.history import hysteresis, mullins, permanent_set
from hyperfab.loop.catalogue.fabric.mounting import grip_slack, load_offset
from hyperfab.loop.catalogue.fabric.relaxation import rate
from hyperfab.loop.catalogue.fabric.response import anisotropy, compressibility, elastic_law, thermal_softening
from hyperfab.loop.fabric_tests import curves_of, path_of, ridden_states
from hyperfab.loop.problem import Effect
from hyperfab.materials.law import Law


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    return (
        anisotropy(context),
        compressibility(context),
        elastic_law(context),
        grip_slack(context),
        hysteresis(context),
        load_offset(context),
        mullins(context),
        permanent_set(context),
        rate(context),
        thermal_softening(context),
    )


def bare_effects(law: Law, warp: Sequence[float], tests: Sequence[TestCurve]) -> tuple[dict[str, Effect], bool]:
    """Return what may lack beside tests of a fabric that has no effects yet, by id, and whether these state times.

    As the problem of it tells, which takes as long again: the fit of its own constants is not begun.
    """
    path, _ = path_of(tests)
    stress = np.concatenate([test.stress for test in tests])
    curves, rows, measured = curves_of(path, tests, stress)
    context = context_of(law, warp, path, tests, stress, ridden_states(tests, curves, measured), len(rows) > 0)
    return {effect.id: effect for effect in entries(context)}, path.knows_time
