"""Tests led alike that differ by more than specimens of one cloth do: a width, thickness or gauge length misread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.known import SURE
from hyperfab.loop.problem import Curve
from hyperfab.loop.thresholds import FEWEST, ONE_CLOTH
from hyperfab.materials.effects.path import GENERAL, MODE_NAMES

#: How much faster one of two tests led alike may be: with another gauge length it seems to be.
_PACE = 2.0


@dataclass(frozen=True)
class Misread:
    """A test with ``factor`` times the stress of ``other``, led alike, at the same stretch.

    ``sure``: it is this one that is odd, as two or more others agree; of a pair either may be.
    """

    name: str
    other: str
    factor: float
    sure: bool

    def __str__(self) -> str:
        who = self.name if self.sure else "both"
        return (
            f"{self.name} has {self.factor:.3g} times the stress of {self.other}, which was led alike: more than "
            f"specimens of one cloth differ; check the width, thickness and gauge length of {who}"
        )


def misread(curves: Sequence[Curve], measured: Array) -> list[Misread]:
    """Return, of tests led alike, the one that differs from the others by a factor no cloth scatters by.

    First pulls are compared: a test read with another gauge length seems to have gone elsewhere, and turned there.
    Not so where a second stretch was led with it: tests of other ratios are not led alike.
    """
    groups: dict[str, list[Curve]] = {}
    for curve in curves:
        if curve.channel == 0 and curve.setup:
            both = curve.setup.startswith(MODE_NAMES[GENERAL])
            led = curve.setup if both else " ".join(curve.setup.split()[:4])  # but for its pace
            groups.setdefault(led, []).append(curve)
    found = []
    for members in groups.values():
        logs = np.log(factors_of(measured, members))
        if len(members) < 2 or not np.all(np.isfinite(logs)):
            continue
        away = np.abs(logs - np.median(logs))
        worst = int(np.argmax(away))
        sure = len(members) > 2
        like = int(np.argmin(away)) if sure else 1 - worst
        if abs(logs[worst] - logs[like]) > SURE * np.sqrt(2.0) * ONE_CLOTH:
            factor = float(np.exp(logs[worst] - logs[like]))
            found.append(Misread(members[worst].name, members[like].name, factor, sure))
    return found


def factors_of(measured: Array, curves: Sequence[Curve]) -> Array:
    """Return how many times the stress of the first of some curves each has on its first pull, nan where they have no
    stretch in common."""
    pulls = [_first_pull(curve) for curve in curves]
    return np.asarray(np.cumprod([1.0, *(_factor(measured, one, other) for one, other in pairwise(pulls))]))


def _first_pull(curve: Curve) -> Curve:
    """Return the rows of a test before it first turns: later ones differ by how far it went."""
    rows = curve.pieces()[0]
    count = rows.stop - rows.start
    place = None if curve.place is None else curve.place[:count]
    return replace(curve, stop=rows.stop, cuts=(), abscissa=curve.abscissa[:count], place=place)


def _pace(curve: Curve) -> float:
    """Return how fast a test goes, in strain over what it is smooth in: time where that is known."""
    return float(np.ptp(curve.places)) / max(float(np.ptp(curve.abscissa)), 1e-300)


def _factor(y: Array, one: Curve, other: Curve) -> float:
    """Return how many times the first test's stress the second has at the same stretch; nan where none is in common."""
    x1, x2 = one.places, other.places
    order = np.argsort(x1, kind="stable")
    inside = (x2 >= x1[order[0]]) & (x2 <= x1[order[-1]])
    if np.count_nonzero(inside) < FEWEST or not 1.0 / _PACE < _pace(one) / _pace(other) < _PACE:
        return np.nan
    there = np.interp(x2[inside], x1[order], y[one.rows][order])
    factor = float(there @ y[other.rows][inside]) / max(float(there @ there), 1e-300)
    return factor if factor > 0.0 else np.nan
