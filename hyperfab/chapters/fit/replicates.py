"""What specimens of one kind say of each other: how far they differ, and where the next one is to be expected."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np

from hyperfab.chapters.fit.identify import kind_of, specimen_of
from hyperfab.curve import TestCurve
from hyperfab.documents.certainty import NextSpecimen, Replicates
from hyperfab.numerics.hygiene import first_loading
from hyperfab.numerics.prediction import Loading, band
from hyperfab.numerics.propagation import LEVEL


def replicates(curves: Sequence[TestCurve]) -> list[Replicates]:
    """Return how far specimens of one kind differ, over the stretches they share."""
    found = []
    for group, branches, (low, high) in _kinds(curves):
        grid = np.linspace(low, high, 21)
        stress = np.array([np.interp(grid, stretch, stress) for stretch, stress in branches])
        spread = stress.std(axis=0, ddof=1)
        found.append(
            Replicates(
                **group,
                scatter=float(np.sqrt(np.mean(spread**2)) / np.abs(stress).max()),
            )
        )
    return found


def next_specimens(curves: Sequence[TestCurve]) -> list[NextSpecimen]:
    """Return, of each kind of test with replicates, where a reading of one more specimen is to be expected."""
    found = []
    for group, branches, reach in _kinds(curves):
        stretch, low, high = band(branches, reach)
        found.append(
            NextSpecimen(
                **group,
                level=LEVEL,
                stretch=stretch.tolist(),
                low_MPa=low.tolist(),
                high_MPa=high.tolist(),
            )
        )
    return found


def _kinds(
    curves: Sequence[TestCurve],
) -> Iterator[tuple[dict[str, Any], list[Loading], tuple[float, float]]]:
    """Yield what specimens of each kind with replicates have in common, the loading of each, and what all reach."""
    kinds: dict[Hashable, dict[Hashable, list[TestCurve]]] = {}
    for curve in curves:
        kinds.setdefault(kind_of(curve), {}).setdefault(specimen_of(curve), []).append(curve)
    for specimens in kinds.values():
        branches = [_loading(own) for own in specimens.values()]
        low = max(float(stretch.min()) for stretch, _ in branches)
        high = min(float(stretch.max()) for stretch, _ in branches)
        if len(branches) > 1 and low < high:
            one = next(iter(specimens.values()))[0]
            alike = {"test": one.mode, "direction": one.direction_name, "temperature_degC": one.temperature}
            yield alike | {"specimens": len(branches)}, branches, (low, high)


def _loading(curves: Sequence[TestCurve]) -> Loading:
    first = [curve.take(first_loading(curve.principal, curve.branch, curve.cycle)) for curve in curves]
    stretch, stress = (np.concatenate([getattr(one, name) for one in first]) for name in ("stretch", "stress"))
    order = np.argsort(stretch, kind="stable")
    return stretch[order], stress[order]
