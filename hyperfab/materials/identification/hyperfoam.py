"""The constants of a hyperfoam from its tests: a search from many starts, of terms of either sign too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve, largest_stress, of_deviations
from hyperfab.materials.hyperfoam import ALPHAS, RATIOS, Hyperfoam, HyperfoamLaw, Rows
from hyperfab.materials.identification.linear import least_in_box
from hyperfab.materials.identification.scatter import Weighed

#: Stresses over the largest one measured, at most.
_MU = 30.0
#: Starts of the search by terms, drawn the same each time, rows a test it is done on, optima followed to the end.
_STARTS, _ROWS, _POLISHED = (16, 48, 48), 40, 3
#: Exponents and ratios of which one more term is begun beside the law of one term less, and how many are tried.
_FURTHER = [(power, ratio) for power in (-40, -20, -10, -5, -2, 2, 5, 10, 20, 40) for ratio in (0.0, 0.15, 0.3, 0.45)]
_BESIDE = 6
#: Starts are followed until a step gains less than this share: those that come out lowest are followed to the end.
_NEAR = 1e-3
#: How near to its bound a ratio has run to it.
_END = 1e-3
#: A stress over the largest one measured that is none.
_NO_TERM = 1e-8
#: What the square sum of signed terms and negative ratios counts beside that of positive ones.
_DEARER = 1.05


def identify(tests: Sequence[TestCurve], terms: int, near: Hyperfoam | None = None) -> Hyperfoam:
    """Return the constants of least squares that are stable at every state of the tests.

    Terms of either sign and negative Poisson's ratios are tried, and taken where they are stable and better, by more
    than noise makes, than positive ones, whose stability is sure. With ``near`` its exponents and ratios are kept and
    stresses alone are sought.
    """
    if near is not None:
        return _Sought(tests, terms).stresses(near)
    error, law = np.inf, None
    for n in range(1, terms + 1):
        error, law = _nested(tests, n, error, law)
    assert law is not None
    order = sorted(range(terms), key=lambda i: -law.alpha[i])
    return Hyperfoam(*(tuple(values[i] for i in order) for values in (law.mu, law.alpha, law.nu)))


def _nested(tests: Sequence[TestCurve], terms: int, most: float, less: Hyperfoam | None) -> tuple[float, Hyperfoam]:
    """Return the optimum of so many terms and half its square sum, given those of one term ``less``.

    Laws are nested: one more term, of no stress, makes the same law, so that no optimum above it is one.
    """
    every = _Sought(tests, terms)
    fewer = _Sought([one.thinned(_ROWS) for one in tests], terms)
    random = np.random.default_rng(1979)
    best: list[tuple[float, float, Hyperfoam]] = []
    if less is not None:
        idle = Hyperfoam((*less.mu, 0.0), (*less.alpha, 2.0), (*less.nu, less.nu[0]))
        best.append((most, most, idle))
    for signed in (False, True):
        starts = [fewer.drawn(random, signed) for _ in range(_STARTS[terms - 1])]
        if less is not None:
            starts += fewer.beside(less, signed)
        found = [fewer.polished(one, signed, 60, _NEAR) for one in starts]
        # One of each optimum that was reached, and of terms of either sign those alone that are stable.
        sound = {round(float(np.log(max(error, 1e-300))), 3): law for error, law in found if fewer.stable(law)}
        for _, law in sorted(sound.items(), key=lambda one: one[0])[:_POLISHED]:
            error, law = every.polished(every.vector(law), signed, 400)
            # A ratio that runs to the end of what is allowed is what no foam has, and no optimum.
            if error <= most and every.stable(law) and min(law.nu) > RATIOS[0] + _END:
                best.append((error * (_DEARER if signed else 1.0), error, law))
    _, error, law = min(best, key=lambda one: one[0])
    return error, law


def optimum(law: Hyperfoam, tests: Sequence[TestCurve], kept: bool = False) -> tuple[tuple[str, ...], Weighed]:
    """Return the names of the constants of ``law`` that ``tests`` moved, and the weighted equations there by them.

    Those that ended where they may go no further are held, and where exponents and ratios were ``kept`` these are too.
    The curve of each row is the number of its test.
    """
    sought, terms = _Sought(tests, len(law.mu)), len(law.mu)
    z, (low, high) = sought.vector(law), sought.bounds(min(*law.mu, *law.nu) < 0.0)
    room = np.repeat([_NO_TERM, *(_END * (end[1] - end[0]) for end in (ALPHAS, RATIOS))], terms)
    free = (z > low + room) & (z < high - room) & (np.arange(3 * terms) < (terms if kept else 3 * terms))
    residual, jacobian = sought.equations(law)
    stated = of_deviations(tests)
    deviation = None if stated is None else np.concatenate(_read(stated))
    read = _read(tests)
    curve = np.repeat(np.arange(len(tests)), [len(one) for one in read])
    stress = residual + np.concatenate(read)
    known = HyperfoamLaw(terms)
    names = np.array([*known.linear, *known.nonlinear])[free]
    by_constant = jacobian / np.repeat([sought.scale, 1.0, 1.0], terms)
    return tuple(names.tolist()), Weighed(by_constant[:, free], residual, np.nan_to_num(stress), curve, deviation)


def _read(tests: Sequence[TestCurve]) -> list[Array]:
    """Return the weighted stresses of the equations of each test; of a stretch across there is no number."""
    return [
        np.concatenate([one.stress * one.weights, np.full(0 if one.contraction is None else len(one.stress), np.nan)])
        for one in tests
    ]


def nearest_foam(own: Mapping[str, float], tests: Sequence[TestCurve]) -> dict[str, float]:
    """Return the constants whose stresses are of least squares in ``tests``, all else as ``own``."""
    law = Hyperfoam.of(own)
    return identify(tests, len(law.mu), law).parameters


@dataclass(frozen=True)
class _Sought:
    """Constants as a vector z: stresses over the largest one measured, exponents, ratios."""

    tests: Sequence[TestCurve]
    terms: int

    @cached_property
    def scale(self) -> float:
        """The largest stress [MPa]."""
        return largest_stress(self.tests)

    @cached_property
    def rows(self) -> list[Rows]:
        """The rows of each test in logarithmic strains."""
        return [
            Rows.of(one.mode, one.stretch, one.stretch2 if one.mode == "biaxial-general" else None)
            for one in self.tests
        ]

    def vector(self, law: Hyperfoam) -> Array:
        return np.concatenate([np.asarray(law.mu) / self.scale, law.alpha, law.nu])

    def law(self, z: Array) -> Hyperfoam:
        mu, alpha, nu = z.reshape(3, self.terms).tolist()
        return Hyperfoam(tuple(self.scale * one for one in mu), tuple(alpha), tuple(nu))

    def bounds(self, signed: bool) -> tuple[Array, Array]:
        """Return the least and the greatest of z; ``signed``: terms of either sign, and ratios below zero."""
        # A single term below zero is no foam.
        low = (-_MU if signed and self.terms > 1 else 0.0, ALPHAS[0], RATIOS[0] if signed else 0.0)
        return np.repeat(low, self.terms), np.repeat([_MU, ALPHAS[1], RATIOS[1]], self.terms)

    def drawn(self, random: np.random.Generator, signed: bool) -> Array:
        mu = np.exp(random.normal(-1.0, 1.0, self.terms))
        mu = mu * (random.choice([1.0, 1.0, -1.0], self.terms) if signed and self.terms > 1 else 1.0)
        return np.concatenate([mu, random.uniform(-12.0, 25.0, self.terms), random.uniform(0.0, 0.45, self.terms)])

    def beside(self, less: Hyperfoam, signed: bool) -> list[Array]:
        """Return starts of a law of one term less and one more, whose first stress lowers the square sum the most."""
        found = []
        for power, ratio in _FURTHER:
            error, slope = self.equations(Hyperfoam((*less.mu, 0.0), (*less.alpha, power), (*less.nu, ratio)))
            slope = slope[:, self.terms - 1]
            step = -float(slope @ error / (slope @ slope))
            gain = step * step * float(slope @ slope) if signed or step > 0.0 else 0.0
            # The terms that are there give way too: half the step.
            law = Hyperfoam((*less.mu, 0.5 * step * self.scale), (*less.alpha, power), (*less.nu, ratio))
            found.append((gain, self.vector(law)))
        return [start for _, start in sorted(found, key=lambda one: -one[0])[:_BESIDE]]

    def equations(self, law: Hyperfoam) -> tuple[Array, Array]:
        """Return weighted errors and their derivatives by z."""
        errors, slopes = [], []
        unit = np.concatenate([np.full(self.terms, self.scale), np.ones(2 * self.terms)])
        for one, rows in zip(self.tests, self.rows, strict=True):
            e = rows.strain(law)
            change, moved = rows.slopes(law, e)
            errors.append((rows.stress(law, e) - one.stress) * one.weights)
            slopes.append(change * one.weights[:, None] * unit)
            if one.contraction is not None and one.weight2 is not None:
                across = np.exp(e[:, 2])
                errors.append((across - one.contraction) * one.weight2)
                slopes.append((across * one.weight2)[:, None] * moved * unit)
        return np.concatenate(errors), np.concatenate(slopes)

    def polished(self, start: Array, signed: bool, steps: int, gain: float = 1e-15) -> tuple[float, Hyperfoam]:
        """Return the optimum near a start, up to steps that ``gain`` less than a share, and half its square sum."""
        least, most = self.bounds(signed)
        inside = np.clip(start, least + 1e-9, most - 1e-9)
        scale = np.repeat([0.3, 5.0, 0.1], self.terms)
        found, cost = least_in_box(lambda z: self.equations(self.law(z)), inside, (least, most), steps, scale, gain)
        return cost, self.law(found)

    def stresses(self, near: Hyperfoam) -> Hyperfoam:
        """Return ``near`` with stresses of least squares, each at least zero where it was above zero."""
        positive = min(near.mu) >= 0.0
        least = np.full(self.terms, 0.0 if positive else -_MU)
        kept = self.vector(near)[self.terms :]

        def equations(z: Array) -> tuple[Array, Array]:
            error, slope = self.equations(self.law(np.concatenate([z, kept])))
            return error, slope[:, : self.terms]

        # All stresses times one factor leave the strains as they are: that factor first.
        model = np.concatenate(
            [
                one.weights * rows.stress(near, rows.strain(near))
                for one, rows in zip(self.tests, self.rows, strict=True)
            ]
        )
        there = np.concatenate([one.weights * one.stress for one in self.tests])
        start = max(float(model @ there / (model @ model)), 1e-6) * np.asarray(near.mu) / self.scale
        inside = np.clip(start, least + 1e-12, _MU - 1e-9)
        found, _ = least_in_box(equations, inside, (least, np.full(self.terms, _MU)), 200)
        law = self.law(np.concatenate([found, kept]))
        return law if positive or self.stable(law) else self.law(np.concatenate([start, kept]))

    def stable(self, law: Hyperfoam) -> bool:
        """Whether the law is stable at rest, where tests have no reading that counts, and at every state of theirs."""
        with np.errstate(all="ignore"):
            states = [np.zeros((1, 3)), *(rows.strain(law) for rows in self.rows)]
            return all(bool(law.stable(e).all()) for e in states)
