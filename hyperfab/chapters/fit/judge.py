"""How a law carries over to tests its constants have not seen, and which law is best by that."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting, along_direction, identify, without_test
from hyperfab.curve import TestCurve
from hyperfab.materials.identification.quality import Figures
from hyperfab.materials.identification.transfer import stretch_at, transfer_risk
from hyperfab.materials.law import Law
from hyperfab.materials.modes import MODES, nominal_stress, way

#: Below this stretch beyond rest constants have no stable range to speak of.
_AT_REST = 1.001
#: Another law is pointed at where the best misses the tests by more than this share of their peak, and by so many times
#: what that law does.
_PLAIN, _CLOSER = 0.02, 3.0
#: Levels of I1 at which laws are compared.
_LEVELS = 24
#: Curves of each direction of the fabric; None is the fabric as a whole.
Sets = Mapping[str | None, Sequence[TestCurve]]


@dataclass(frozen=True)
class Judged:
    """One law on all sets of curves, with its verdict.

    ``carry_over`` is the relative rms expected in tests the constants have not seen: measured on the tests that took
    no part, else on each fitted test left out in turn, else estimated from the law (one test alone).
    """

    law: Law
    results: Mapping[str | None, Identified | str]
    carry_over: float
    stable: bool
    accepted: bool

    @property
    def failure(self) -> str | None:
        """Why the law has no constants, or None."""
        return next((found for found in self.results.values() if isinstance(found, str)), None)

    @property
    def parts(self) -> list[tuple[str | None, Identified]]:
        """What is written: the constants of each direction by its name, those of the whole where there is none."""
        found = [(name, part) for name, part in self.results.items() if isinstance(part, Identified)]
        return [(name, part) for name, part in found if name is not None] or found

    @property
    def best_first(self) -> tuple[bool, float, float, int]:
        """Sorting key: accepted and stable laws first, then by what is expected in unseen tests."""
        found = self.results[None]
        error = found.total.relative_rms if isinstance(found, Identified) else math.inf
        return (not (self.accepted and self.stable), self.carry_over, error, len(self.law.names))


def judge(law: Law, sets: Sets, setting: Setting) -> Judged:
    """Fit ``law`` to every set of curves, and find how it carries over (a law with directions of its own: infinite)."""
    results = _results(law, sets, setting)
    names: list[str | None] = [name for name in sets if name is not None] or [None]
    good = [part for name in names if isinstance(part := results[name], Identified)]
    if len(good) < len(names) or isinstance(results[None], str):
        return Judged(law, results, math.inf, False, False)
    carry = math.inf
    if law.isotropic:
        carry = max(_carry_over(sets[name], setting, part) for name, part in zip(names, good, strict=True))
    return Judged(
        law,
        results,
        carry_over=carry,
        stable=all(part.stable for part in good),
        accepted=all(_carries(part, setting) for part in good),
    )


def _carries(part: Identified, setting: Setting) -> bool:
    """Whether a fit is within the limit, by the figure that was minimised, and its sheet does not give way at rest."""
    error = part.total.relative_rms if setting.relative else part.total.nrmse
    return error <= setting.accept and all(
        one.high > _AT_REST for ranges in part.every_range for one in ranges.values()
    )


def _results(law: Law, sets: Sets, setting: Setting) -> dict[str | None, Identified | str]:
    """Fit every set; a law with directions of its own is fitted once and seen along each."""
    if law.isotropic:
        return {name: identify(law, curves, setting) for name, curves in sets.items()}
    whole = identify(law, sets[None], setting)
    if isinstance(whole, str):
        return dict.fromkeys(sets, whole)
    found: dict[str | None, Identified | str] = {None: whole}
    for name, curves in sets.items():
        if name is not None:
            found[name] = along_direction(whole, name, curves, setting)
    return found


def _carry_over(curves: Sequence[TestCurve], setting: Setting, found: Identified) -> float:
    unseen = [figures for figures, _, predicted in found.tests.values() if predicted]
    if unseen:
        return _pooled(unseen)
    fitted = [mode for mode in found.tests if mode in setting.fit_on]
    if len(fitted) > 1:
        return _pooled(without_test(found, mode, curves, setting) for mode in fitted)
    if (mode := way(fitted[0])) not in MODES:
        return found.total.relative_rms
    return math.hypot(found.total.relative_rms, transfer_risk(found.fit, mode))


def _pooled(parts: Iterable[Figures | None]) -> float:
    total, points = 0.0, 0
    for figures in parts:
        if figures is None or not math.isfinite(figures.E2):
            return math.inf
        total += figures.E2
        points += figures.points
    return math.sqrt(total / points)


def closer(ranking: Sequence[Judged]) -> str | None:
    """Return what is to be said where another sound law carries these tests much more closely than the best in all.

    The best is that which is expected to carry over; where only these tests count, another may be wanted.
    """
    sound = [
        (one, part.total.nrmse)
        for one in ranking
        if one.accepted and one.stable and isinstance(part := one.results[None], Identified)
    ]
    if not sound:
        return None
    (best, missed), (other, least) = sound[0], min(sound, key=lambda pair: pair[1])
    if missed < _PLAIN or missed < _CLOSER * least:
        return None
    name = other.law.name
    return (
        f"{best.law.name} is expected to carry over best to tests that were not made, but misses these by "
        f"{missed:.2g} of their peak (NRMSE), {name} by {least:.2g}: where only these tests count, take --model {name}"
    )


def law_spread(ranking: Sequence[Judged], name: str | None) -> float | None:
    """Return how far the stress of accepted and stable laws is from that of the best, relative, up to the I1 tested.

    The median over the laws of the root mean square, over all modes, of ln(stress / stress of the best): one law that
    runs away in a mode nobody tested is no measure of the others. None where fewer than two laws are accepted.
    """
    parts = [one.results[name] for one in ranking if one.accepted and one.stable]
    good = [part for part in parts if isinstance(part, Identified)]
    if len(good) < 2:
        return None
    levels = np.linspace(0.02, 1.0, _LEVELS) * good[0].fit.problem.rows.extent.x
    stretch = {mode: stretch_at(mode, levels) for mode in MODES}
    with np.errstate(all="ignore"):
        found = np.log([[nominal_stress(part.material, mode, lam) for mode, lam in stretch.items()] for part in good])
        away = np.sqrt(np.mean((found[1:] - found[0]) ** 2, axis=(1, 2)))
    known = away[np.isfinite(away)]
    return float(np.median(known)) if len(known) else None
