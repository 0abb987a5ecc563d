"""Prediction of whole tests that took no part: to first order at the cost of one fit, or by fits without each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.fitting import Fit, fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve, Problem
from hyperfab.loop.thresholds import MOST, TOLD

Rows = slice | Ints


@dataclass(frozen=True)
class HeldOut:
    """Whitened residual of each curve as predicted from the others, nan where they cannot tell; which count.

    ``places`` are the rows of each.
    """

    residual: Array
    counted: tuple[int, ...]
    rms: Array
    places: tuple[slice, ...]

    def rows(self, tests: Sequence[int]) -> list[slice]:
        """Return where the rows of some tests are."""
        return [self.places[test] for test in tests]

    def in_stiffness(self, noise: Noise) -> HeldOut:
        """Return what of it is as another stiffness would be: of each specimen of the ``noise`` one value, nan where
        not all of its rows are told."""
        off = noise.along_stiffness(self.residual)
        told = tuple(int(one) for one in np.flatnonzero(np.isfinite(off)))
        return HeldOut(off, told, np.abs(off), tuple(slice(k, k + 1) for k in range(len(off))))


def leave_curves_out(fit: Fit, curves: Sequence[Curve]) -> HeldOut:
    """Predict each curve from all others: a Gauss-Newton step away from the joint optimum, exact for linear models."""
    left = np.full(len(fit.residual), np.nan)
    counted, rms = [], np.full(len(curves), np.nan)
    for index, curve in enumerate(curves):
        without = _without(fit, curve.rows)
        if without is None:
            continue
        left[curve.rows] = without
        counted.append(index)
        rms[index] = np.sqrt(np.mean(without**2))
    return HeldOut(left, tuple(counted), rms, tuple(curve.rows for curve in curves))


def _without(fit: Fit, rows: Rows) -> Array | None:
    """Return the whitened residual of rows that had no say in the fit, to first order; None if the rest cannot tell."""
    part = fit.jacobian[rows]
    others = fit.precision - part.T @ part
    scale = 1.0 / np.sqrt(np.maximum(np.diag(fit.precision), 1e-300))
    values, vectors = np.linalg.eigh(others * np.outer(scale, scale))
    sure = values > 1e-9
    reach = (part * scale) @ vectors
    if np.any(np.abs(reach[:, ~sure]) > 1e-3):
        return None
    # What the others know less well than one reading would tell it is not known.
    if float(np.sqrt(np.mean(np.sum(reach[:, sure] ** 2 / values[sure], axis=1)))) > 1.0:
        return None
    r = fit.residual[rows]
    return np.asarray(r + (reach[:, sure] / values[sure]) @ (reach[:, sure].T @ r))


@dataclass(frozen=True)
class Forecast:
    """What a model says of each test, fitted anew to all the others; nan where they cannot tell. ``tests`` are told."""

    predicted: Array
    tests: tuple[str, ...]


def forecast(problem: Problem, noise: Noise, found: Fit) -> Forecast:
    """Predict each test from a fit to all others: a test is all that was read of one specimen, or one probe."""
    tests: dict[str, list[Ints]] = {}
    for number, curve in enumerate(problem.curves):
        if not curve.beforehand:
            name = curve.specimen or f"{number} {curve.name}"
            tests.setdefault(name, []).append(np.arange(curve.start, curve.stop))
    predicted, told = np.full(len(problem.measured), np.nan), []
    for name, parts in tests.items():
        rows: Ints = np.concatenate(parts)
        if len(tests) == 1 or _without(found, rows) is None:
            continue
        # A reading with no end of noise has no say.
        silent = noise.plain.sd.copy()
        silent[rows] = np.inf
        again = fit(problem, replace(noise.plain, sd=silent), found.forms, found.x)
        if np.all(np.isfinite(again.predicted[rows])):
            predicted[rows] = again.predicted[rows]
            told.append(name)
    return Forecast(predicted, tuple(told))


@dataclass(frozen=True)
class Help:
    """What a term does for tests that took no part: share of the structured error taken, share of tests helped."""

    taken: float
    helped: float
    tests: int


def help_of(before: HeldOut, after: HeldOut, gone: Array) -> Help | None:
    """Compare two models on the tests both can predict; None where there are fewer than two.

    Also None where most of what the second explains (``gone`` from the square of each row's residual) is in tests that
    the others cannot predict, as the only one at a temperature: how the rest move by chance says nothing then.
    """
    both = sorted(set(before.counted) & set(after.counted))
    seen = sum(float(np.sum(gone[rows])) for rows in before.rows(both))
    if len(both) < 2 or seen < MOST * float(np.sum(gone)):
        return None
    old, new = before.rms[both], after.rms[both]
    structured = np.median(np.maximum(old**2 - 1.0, 0.0))
    if structured <= 0.0:
        structured = float(np.mean(np.maximum(old**2 - 1.0, 1e-3)))
        taken = float(np.mean(old**2 - new**2)) / structured
    else:
        means = float(np.mean(old**2 - new**2)) / float(np.mean(np.maximum(old**2 - 1.0, 0.0)))
        # One test that no law foresees, as the only one of its mode, must not speak for all others: by logarithms.
        typical = -float(np.expm1(np.mean(np.log(np.maximum(new, 1.0) ** 2 / np.maximum(old, 1.0) ** 2))))
        taken = max(float(np.median(old**2 - new**2)) / float(structured), means, typical)
    matters = np.abs(old - new) > 0.02 * np.maximum(old, 1.0)
    # Two predictions that lie nearer to each other than readings can tell are neither better nor worse.
    moved = [float(np.sum((before.residual[rows] - after.residual[rows]) ** 2)) for rows in before.rows(both)]
    matters &= np.array(moved) > TOLD**2
    # What was noise and stays so moves by chance alone: the less it moves beside the others, the less it says.
    change = np.abs(old**2 - new**2)
    voice = np.minimum(change / max(float(np.mean(change)), 1e-300), 1.0)
    voice = np.where(matters, np.where(np.maximum(old, new) > TOLD, 1.0, voice), 0.0)
    helped = float(np.sum(voice[new < old]) / np.sum(voice)) if np.any(matters) else 0.0
    return Help(taken, helped, len(both))
