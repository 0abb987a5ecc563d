"""How well constants carry readings, and how sure the constants are."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.materials.identification.fit import Fit
from hyperfab.materials.identification.linear import lengths
from hyperfab.materials.identification.scatter import Scatter, Weighed, by_readings, by_specimen
from hyperfab.materials.law import Array


@dataclass(frozen=True)
class Figures:
    """``E2 = sum((1 - model/measured)^2)``, its root mean square, and the rms error over the largest stress.

    Where the noise is known a reading near zero counts by its absolute error.
    """

    E2: float
    relative_rms: float
    nrmse: float
    points: int


def figures(measured: Array, model: Array, floor: Array | float = 0.0) -> Figures | None:
    """Return the figures of a test; None without a model value.

    A reading below its ``floor`` (rows,) counts by its error over that; one of zero without a floor in ``nrmse`` alone.

    >>> round(figures(np.array([1.0, 2.0]), np.array([1.1, 2.0])).relative_rms, 12)
    0.070710678119
    """
    if not len(measured) or not np.isfinite(model).all():
        return None
    size = np.maximum(np.abs(measured), floor)
    seen = size > 0.0
    ratio = (measured - model)[seen] / size[seen]
    E2 = float(ratio @ ratio)
    error = model - measured
    peak = float(np.abs(measured).max())
    return Figures(
        E2=E2,
        relative_rms=float(np.sqrt(E2 / max(int(seen.sum()), 1))),
        nrmse=float(np.sqrt(error @ error / len(measured)) / peak) if peak > 0.0 else 0.0,
        points=len(measured),
    )


@dataclass(frozen=True)
class Certainty:
    """Standard deviations and correlations of the constants, in the order of ``names``, and the condition number.

    The condition number is that of the Jacobian with columns of length one: 1 where the constants do not disturb
    each other. ``covariance`` (p, p) is from ``scatter`` between specimens; where that is None, from the readings
    alone, whose own deviations are ``stated`` or follow from what the law misses. ``leverage`` is each row's share in
    its own prediction, ``studentised`` its residual over the residual's own standard deviation with the row left out.
    """

    names: tuple[str, ...]
    sd: Array
    covariance: Array
    correlation: Array
    condition_number: float
    leverage: Array
    studentised: Array
    scatter: Scatter | None
    stated: bool

    def reordered(self, order: Sequence[int]) -> Certainty:
        """Return the certainty with the constants, under the same names, in another order."""
        square = np.ix_(order, order)
        scatter = None if self.scatter is None else self.scatter.reordered(order)
        covariance, correlation = self.covariance[square], self.correlation[square]
        return replace(self, sd=self.sd[order], covariance=covariance, correlation=correlation, scatter=scatter)


def certainty(
    fit: Fit,
    group: int = 0,
    specimens: Sequence[Hashable] | None = None,
    kinds: Sequence[Hashable] | None = None,
    deviation: Array | None = None,
) -> Certainty:
    """Return how sure the constants of one group of rows are: by how specimens scatter, where there are replicates.

    ``specimens`` and ``kinds`` are those of ``scatter.by_specimen``. Without replicates the standard deviations are
    from the curvature at the optimum: each reading errs by itself, by the ``deviation`` (rows,) [MPa] that is stated of
    it, or else with its neighbours, by what the law misses (``scatter.by_readings``). How specimens scatter is not in
    them.
    """
    rows = fit.problem.rows
    weighed = None if deviation is None else rows.weight * deviation
    found = Weighed(fit.jacobian, fit.residual, fit.problem.b - fit.residual, rows.curve, weighed)
    return sure_of(found, fit.material.law.names, _by_parameter(fit, group), specimens, kinds)


def sure_of(
    fit: Weighed,
    names: Sequence[str],
    change: Array,
    specimens: Sequence[Hashable] | None = None,
    kinds: Sequence[Hashable] | None = None,
) -> Certainty:
    """Return how sure constants ``names`` are that move by ``change`` (p, q) with the columns of a Jacobian."""
    J = fit.jacobian
    rows, count = J.shape
    length = lengths(J)
    U, s, Vt = np.linalg.svd(J / length, full_matrices=False)
    kept = s > 1e-14 * s[0] if len(s) else s > 0
    inverse = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)
    freedom = max(rows - count, 1)
    sse = float(fit.residual @ fit.residual)
    root = (Vt.T * inverse) / length[:, None]
    leverage = (U[:, kept] ** 2).sum(axis=1)
    spread = change @ root
    scatter = by_specimen(fit, change, specimens, kinds) if specimens and kinds else None
    if scatter is not None:
        covariance = scatter.covariance
    elif fit.deviation is not None:
        moved = spread @ U.T * _stated(fit, leverage)
        covariance = moved @ moved.T
    else:
        covariance = by_readings(fit, U, spread)
    sd = np.sqrt(np.diag(covariance))
    with np.errstate(all="ignore"):
        correlation = covariance / np.outer(sd, sd)
    return Certainty(
        names=tuple(names),
        sd=sd,
        covariance=covariance,
        correlation=correlation,
        condition_number=float(s[0] / s[-1]) if len(s) and s[-1] > 0.0 else np.inf,
        leverage=leverage,
        studentised=_studentised(fit.residual, leverage, sse, freedom),
        scatter=scatter,
        stated=scatter is None and fit.deviation is not None,
    )


def _stated(fit: Weighed, leverage: Array) -> Array:
    """Return the standard deviation of each row, of those that are no stresses as what they leave tells it."""
    sd = np.asarray(fit.deviation)
    others = np.isnan(sd)
    freedom = max(np.count_nonzero(others) - leverage[others].sum(), 1.0)
    return np.where(others, np.linalg.norm(fit.residual[others]) / np.sqrt(freedom), sd)


def _studentised(residual: Array, leverage: Array, sse: float, freedom: int) -> Array:
    open_share = 1.0 - leverage
    # A reading that decides its own prediction leaves a residual of rounding: nothing to judge it by.
    judged = open_share > 1e-3
    open_share = np.where(judged, open_share, 1.0)
    without = np.clip(sse - residual**2 / open_share, 1e-12 * sse + 1e-300, None) / max(freedom - 1, 1)
    return np.asarray(np.where(judged, residual / np.sqrt(without * open_share), 0.0))


def _by_parameter(fit: Fit, group: int) -> Array:
    """Derivative of the published constants of a group by the free constants of the Jacobian's columns."""
    problem, law = fit.problem, fit.problem.law
    width, total = len(problem.free), fit.jacobian.shape[1]
    material = fit.materials[group]
    free_theta = [number for number, name in enumerate(law.nonlinear) if name not in law.held]
    base = np.array(list(material.parameters.values()))
    change = np.zeros((len(base), total))
    moves = [(0, number, group * width + k) for k, number in enumerate(problem.free)]
    moves += [(1, number, total - len(free_theta) + k) for k, number in enumerate(free_theta)]
    for which, number, column in moves:
        values = [list(material.c), list(material.theta)]
        step = 1e-6 * max(abs(values[which][number]), 1e-12)
        sides = []
        for sign in (1.0, -1.0):
            moved = [list(part) for part in values]
            moved[which][number] += sign * step
            sides.append(np.array(list(law.join(*moved).values())))
        change[:, column] = (sides[0] - sides[1]) / (2.0 * step)
    return change
