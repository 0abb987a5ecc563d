"""Rows of the tests of a sheet: of all tests together, and of one at strains taken as known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.curve import TestCurve
from hyperfab.materials.orthotropic.energy import Orthotropic
from hyperfab.materials.orthotropic.specimen import Frame

#: Threads that are strained by less than this share of the largest strain are not pulled.
SLIGHT = 0.01


def across(test: TestCurve) -> Array:
    """Return the stretch of the second axis of a test whose edges are held."""
    if test.mode == "shear":
        return np.ones_like(test.stretch)
    return test.stretch if test.stretch2 is None or test.mode == "biaxial" else test.stretch2


def strained(tests: Sequence[TestCurve], angle: float) -> float:
    """Return the largest strain I - 1 of threads at ``angle`` [deg] to the warp, on either side of it, in tests of a
    sheet that does not shear; below zero where all of them draw in.

    >>> lam = np.array([1.0, 2.0]); pull = TestCurve("uniaxial", lam, lam - 1.0, direction=0.0)
    >>> strained([pull], 0.0), round(strained([pull], 60.0), 9), strained([pull], 90.0)
    (3.0, 0.75, 0.0)
    """
    found = []
    for test in tests:
        second = across(test) if test.mode != "uniaxial" or test.stretch2 is not None else np.ones_like(test.stretch)
        turned = np.radians(np.array([angle, -angle]) - (test.direction or 0.0))[:, None]
        found.append(float(np.max(test.stretch**2 * np.cos(turned) ** 2 + second**2 * np.sin(turned) ** 2)) - 1.0)
    return max(found)


@dataclass(frozen=True)
class Rows:
    """The rows of several tests of one kind; ``second`` says where a second measured value is."""

    curve: Ints
    angle: Array
    stretch: Array
    stress: Array
    weight: Array
    stretch2: Array
    stress2: Array
    weight2: Array
    second: Flags

    @classmethod
    def of(cls, tests: Sequence[tuple[int, TestCurve]]) -> Rows:
        def joined(pick: Callable[[TestCurve], Array | None]) -> Array:
            parts = [(pick(test), len(test.stretch)) for _, test in tests]
            return np.concatenate([np.zeros(0), *(np.zeros(n) if one is None else one for one, n in parts)])

        def told(test: TestCurve) -> bool:
            if test.mode == "uniaxial":
                return test.contraction is not None and test.weight2 is not None
            return test.stress2 is not None and test.mode.startswith("biaxial")

        counts = [len(test.stretch) for _, test in tests]
        return cls(
            curve=np.repeat([number for number, _ in tests], counts).astype(np.int64),
            angle=np.repeat([test.direction or 0.0 for _, test in tests], counts),
            stretch=joined(lambda test: test.stretch),
            stress=joined(lambda test: test.stress),
            weight=joined(lambda test: test.weights),
            stretch2=joined(lambda test: test.stretch2 if test.mode == "uniaxial" else across(test)),
            stress2=joined(lambda test: test.stress2),
            weight2=joined(lambda test: test.weights if test.weight2 is None else test.weight2),
            second=np.repeat([told(test) for _, test in tests], counts).astype(bool),
        )


@dataclass(frozen=True)
class Gathered:
    """All rows, those of strips and those of tests with held edges."""

    strips: Rows
    held: Rows

    @classmethod
    def of(cls, tests: Sequence[TestCurve]) -> Gathered:
        numbered = list(enumerate(tests))
        return cls(
            Rows.of([one for one in numbered if one[1].mode == "uniaxial"]),
            Rows.of([one for one in numbered if one[1].mode != "uniaxial"]),
        )

    @property
    def curve(self) -> Ints:
        """The number of each equation's test."""
        parts = [(rows.curve, rows.curve[rows.second]) for rows in (self.strips, self.held)]
        return np.concatenate([part for pair in parts for part in pair])

    @property
    def stresses(self) -> Array:
        """The weighted measured stress of each equation; no number where it is one of width."""
        s, h = self.strips, self.held
        across = (h.stress2 * h.weight2)[h.second]
        return np.concatenate([s.stress * s.weight, np.full(int(s.second.sum()), np.nan), h.stress * h.weight, across])


@dataclass(frozen=True)
class LinearRows:
    """A test at strains taken as known: weighted stress equations, and free edges where the width was measured."""

    C: Array
    along: Array
    across: Array | None
    right: Array

    def of(self, law: Orthotropic) -> Array:
        terms = law.stress_terms(self.C)
        rows = [np.einsum("nj,nkj->nk", self.along, terms)]
        if self.across is not None:
            rows.append(np.einsum("nj,nkj->nk", self.across, terms))
        return np.concatenate(rows)


def linear_rows(test: TestCurve, nu: float) -> LinearRows:
    frame = Frame.at(np.full(len(test.stretch), test.direction or 0.0))
    if test.mode == "uniaxial":
        second = test.stretch**-nu if test.stretch2 is None else test.stretch2
    else:
        second = across(test)
    C = frame.strain(test.stretch**2, second**2, np.zeros_like(second))
    along = (test.weights * test.stretch)[:, None] * frame.tt
    right = test.weights * test.stress
    known = test.stress2 if test.mode.startswith("biaxial") else None
    if test.contraction is not None:
        known = np.zeros_like(test.stress)
    if known is None:
        return LinearRows(C, along, None, right)
    weight = test.weights if test.weight2 is None or test.contraction is not None else test.weight2
    return LinearRows(C, along, (weight * second)[:, None] * frame.nn, np.concatenate([right, weight * known]))
