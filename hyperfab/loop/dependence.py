"""What the residual rides on, and a short formula that would take most of it: a hint, never a term."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from hyperfab.arrays import Array, Ints

_BINS = 8
#: Products that a formula has at most.
_MOST_TERMS = 3


def dependence(
    residual: Array, states: Mapping[str, Array], left: Array | None = None, specimens: Sequence[Ints] = ()
) -> dict[str, float]:
    """Return, for each state variable, the share of the residual's variance its means in bins explain.

    The share that noise of the same size would give by chance is taken off. Of a state that each of some ``specimens``
    (rows) has to itself it is the share of what is ``left`` before their scatter is taken out, by chance as of so many.
    """
    found = {}
    for name, values in states.items():
        own = left is not None and all(len(np.unique(values[rows])) == 1 for rows in specimens)
        of, count = (left, len(specimens)) if left is not None and own else (residual, len(residual))
        known = np.isfinite(values)
        distinct = np.unique(values[known])
        if _is_constant(distinct) or not np.any(of):
            continue
        if len(distinct) <= _BINS:
            label = np.searchsorted(distinct, values[known])
        else:
            edges = np.unique(np.quantile(values[known], np.linspace(0.0, 1.0, _BINS + 1)[1:-1]))
            label = np.searchsorted(edges, values[known])
        part = of[known]
        size = np.bincount(label)
        means = np.bincount(label, weights=part) / np.maximum(size, 1)
        share = float(np.sum(size * means**2) / np.sum(part**2)) if np.any(part) else 0.0
        chance = np.count_nonzero(size) / (count * np.mean(known))
        found[name] = max(share - float(chance), 0.0)
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def _is_constant(values: Array) -> bool:
    """Whether values are one but for rounding, as are rates told from the clocks of tests at one speed."""
    return len(values) == 0 or float(np.ptp(values)) <= 1e-9 * float(np.abs(values).max())


def period(residual: Array, time: Array) -> tuple[float, float] | None:
    """Return the period [s] of what swings in a residual (n,) over ``time`` (n,), and its share of the squares.

    None where no sine, beside what changes slowly, carries half of it. Two to sixty periods are looked for, of four
    readings at least, by least squares at each frequency (Lomb 1976), so that the times need not be even.

    >>> time = np.linspace(0.0, 40.0, 200)
    >>> round(period(np.sin(2.0 * np.pi * 0.11 * time + 0.3), time)[0], 1)
    9.1
    """
    known = np.isfinite(time)
    at, left = time[known], residual[known]
    span = float(np.ptp(at)) if len(at) else 0.0
    if len(at) < 16 or span <= 0.0 or np.any(np.diff(at) < 0.0):
        return None
    at = (at - at[0]) / span
    slow = np.vander(at, 4)
    beside = left - slow @ np.linalg.lstsq(slow, left, rcond=None)[0]
    total = float(beside @ beside)

    def share(turns: float) -> float:
        wave = np.column_stack([slow, np.sin(2.0 * np.pi * turns * at), np.cos(2.0 * np.pi * turns * at)])
        rest = left - wave @ np.linalg.lstsq(wave, left, rcond=None)[0]
        return 1.0 - float(rest @ rest) / max(total, 1e-300)

    coarse = np.arange(2.0, min(60.0, len(at) / 4.0), 1.0 / 6.0)
    near = max(coarse, key=share)
    turns = max(np.linspace(near - 0.15, near + 0.15, 31), key=share)
    carried = share(turns) * total / max(float(left @ left), 1e-300)
    return (span / float(turns), carried) if carried > 0.5 else None


def suggestion(residual: Array, sd: Array, states: Mapping[str, Array]) -> tuple[str, float] | None:
    """Return a sparse formula for the raw residual in products of state variables, and the share it takes.

    Orthogonal matching pursuit over products of up to two scaled state variables; a product stays where it pays in BIC.
    """
    scaled: dict[str, Array] = {}
    for name, values in states.items():
        known = np.isfinite(values)
        if not np.all(known) or _is_constant(values):
            continue
        middle, half = (values.max() + values.min()) / 2.0, (values.max() - values.min()) / 2.0
        sign = "-" if middle >= 0.0 else "+"
        scaled[f"({name} {sign} {abs(middle):.3g})/{half:.2g}"] = (values - middle) / half
    columns = dict(scaled)
    for one, two in itertools.combinations_with_replacement(scaled, 2):
        columns[f"{one}^2" if one == two else f"{one} {two}"] = scaled[one] * scaled[two]
    if not columns:
        return None
    matrix = np.stack([np.ones(len(residual)), *columns.values()], axis=1) / sd[:, None]
    labels = ["", *columns]
    target = residual / sd
    total = float(target @ target)
    chosen: list[int] = []
    left: Array = target
    best = total
    coefficients: Array = np.empty(0)
    norms = np.sqrt(np.sum(matrix**2, axis=0))
    for _ in range(_MOST_TERMS):
        gains = np.abs(matrix.T @ left) / norms
        gains[chosen] = 0.0
        trial = [*chosen, int(np.argmax(gains))]
        solved = np.linalg.lstsq(matrix[:, trial], target, rcond=None)[0]
        rest = target - matrix[:, trial] @ solved
        power = float(rest @ rest)
        if (best - power) / max(power / len(target), 1.0) < 3.0 * np.log(len(target)):
            break
        chosen, left, best, coefficients = trial, rest, power, np.asarray(solved, dtype=np.float64)
    if not chosen:
        return None
    text = " ".join(
        f"{value:+.2g}{' ' + labels[index] if labels[index] else ''}"
        for value, index in zip(coefficients, chosen, strict=True)
    )
    return text, 1.0 - best / total
