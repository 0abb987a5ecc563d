"""A plateau that is flatter than any stable law of a foam has: where it is, and the loading as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.numerics.doubt import scatter
from hyperfab.numerics.hygiene import first_loading
from hyperfab.numerics.monotone import never_falling

#: Compression whose stress times the stretch falls by more than this share is carried by no stable law.
_FALLS = 0.05
#: In standard deviations of a reading about its neighbours: a fall by less may be chance.
_SURE = 4.0
#: Rows of the table: each is the mean of the readings around it.
_ROWS = 60


@dataclass(frozen=True)
class Plateau:
    """Where ``source``, a test of kind ``mode``, falls behind 1 / stretch, by ``share`` between two stretches."""

    source: str
    mode: str
    begins: float
    ends: float
    share: float

    def __str__(self) -> str:
        return (
            f"{self.source}: between stretches of {self.begins:.2f} and {self.ends:.2f} the stress falls behind "
            f"1 / stretch by {100.0 * self.share:.0f} %: no stable law has a plateau so flat, of however many terms; "
            "what is nearest to all tests is taken, and the press takes a compression as a table too"
        )


def plateau(curves: Sequence[TestCurve]) -> Plateau | None:
    """Return the test, the worst of all, that presses a foam on a plateau that no stable law has; None without one.

    An energy that is convex in the logarithmic strains (Hill) has a Kirchhoff stress along the load, stress times
    stretch where the sides are free or held, that grows with the compression.
    """
    found: list[Plateau] = []
    for curve in curves:
        if curve.mode not in ("uniaxial", "confined-compression"):
            continue
        part = _loading(curve)
        if len(part.stretch) < 3:
            continue
        kirchhoff = -part.stress * part.stretch
        # The least of three: one reading that is high by chance is no peak.
        steady = np.minimum(np.minimum(kirchhoff[:-2], kirchhoff[1:-1]), kirchhoff[2:])
        peak = np.maximum.accumulate(steady)
        later = np.maximum(np.maximum(kirchhoff[:-2], kirchhoff[1:-1]), kirchhoff[2:])
        falls = np.where(peak > 0.0, 1.0 - later / np.where(peak > 0.0, peak, 1.0), 0.0)
        # Of a plateau far below the largest stress the readings' scatter is a large share.
        falls[peak - later <= _SURE * scatter(kirchhoff)] = 0.0
        worst = int(np.argmax(falls))
        if falls[worst] > _FALLS:
            begins = float(part.stretch[1 + int(np.argmax(steady[: worst + 1]))])
            ends = float(part.stretch[1 + worst])
            found.append(Plateau(curve.source, curve.mode, begins, ends, float(falls[worst])))
    return max(found, key=lambda one: one.share, default=None)


def table_of(curves: Sequence[TestCurve], mode: str) -> tuple[Array, Array, float]:
    """Return the mean loading of compression tests of a kind, strain (n,) and stress (n,) [MPa], both positive, and
    the largest share of the peak by which it was levelled.

    Where the nominal stress falls the press has no single answer: there the table is the nearest that never falls.
    """
    parts = [part for part in (_loading(c) for c in curves if c.mode == mode) if len(part.stretch) > 2]
    means = [_steps(1.0 - part.stretch, -part.stress) for part in parts]
    strain = min(float(own[-1]) for own, _ in means) * np.arange(1, _ROWS + 1) / _ROWS
    levels = [np.interp(strain, np.append(0.0, own), np.append(0.0, stress)) for own, stress in means]
    mean = np.mean(levels, axis=0)
    level = np.maximum(never_falling(mean), 0.0)
    return strain, level, float(np.abs(level - mean).max() / mean.max())


def _steps(strain: Array, stress: Array) -> tuple[Array, Array]:
    """Return the means of readings over steps of strain: what scatters would level the table."""
    row = np.minimum((strain / strain.max() * _ROWS).astype(np.int64), _ROWS - 1)
    count = np.bincount(row, minlength=_ROWS)
    known = count > 0
    own, mean = (np.bincount(row, each, _ROWS)[known] / count[known] for each in (strain, stress))
    return own, mean


def _loading(curve: TestCurve) -> TestCurve:
    """Return the rows of the first way down, from rest on."""
    part = curve.take(first_loading(curve.principal, curve.branch, curve.cycle) & (curve.stretch < 1.0))
    return part.take(np.argsort(-part.stretch, kind="stable"))
