"""Weighted least squares with bounds and priors: the model's own constants and those of its terms together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Form, Problem, split

#: A step is accepted as the last one where it lowers chi-squared by less than this share, or this much; coarser where
#: fits are only compared: the gain is then below a tenth of what one constant has to earn.
_SHARE, _AMOUNT, _COARSE = 1e-5, 2e-3, 0.3
#: How steep the wall is before constants that no material has, in units of what the model misses by.
_WALL = 1e4


@dataclass(frozen=True)
class Fit:
    """A model fitted to data.

    ``x`` holds the own constants, then those of each term in order. ``residual`` (rows) and ``jacobian``
    (rows, constants)
    are whitened: in units of the noise, uncorrelated. ``chi2`` is of the data alone, ``cost`` with the priors.
    """

    forms: Mapping[str, Form]
    x: Array
    predicted: Array
    residual: Array
    jacobian: Array
    precision: Array
    chi2: float
    cost: float
    prior: Array
    own: int

    @property
    def terms(self) -> dict[str, tuple[str, Array]]:
        """The terms as ``Problem.predict`` takes them."""
        return split(self.x[self.own :], self.forms)

    @property
    def sd(self) -> Array:
        """One standard deviation of each constant, from the curvature at the optimum."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def covariance(self) -> Array:
        """Covariance of the constants, from the curvature at the optimum."""
        return inverse(self.precision, 1e-13)

    def place(self, effect: str) -> slice:
        """Return where in ``x`` the constants of a term stand."""
        at = self.own
        for name, form in self.forms.items():
            if name == effect:
                return slice(at, at + len(form.constants))
            at += len(form.constants)
        raise KeyError(effect)


def inverse(matrix: Array, rcond: float) -> Array:
    """Return the pseudo-inverse of a positive semi-definite matrix; ``rcond`` is of its rows scaled to a diagonal of 1.

    >>> inverse(np.diag([4.0, 1e-20, 0.0]), 1e-9).diagonal()
    array([2.5e-01, 1.0e+20, 0.0e+00])
    """
    size = np.diag(matrix)
    unit = np.where(size > 0.0, 1.0 / np.sqrt(np.maximum(size, 1e-300)), 0.0)
    both = np.outer(unit, unit)
    return np.asarray(np.linalg.pinv(matrix * both, rcond=rcond, hermitian=True) * both)


def fit(
    problem: Problem,
    noise: Noise,
    forms: Mapping[str, Form],
    start: Sequence[float] | Array,
    *,
    data: Array | None = None,
    iterations: int = 30,
    coarse: bool = False,
) -> Fit:
    """Fit all constants to ``data`` (the measured values by default) from ``start``, Levenberg-Marquardt.

    Priors pull towards the constants' values; bounds hold by projection, what is forbidden by a wall. The fit weighs
    rows by their standard deviations alone: in a metric that forgives each specimen its stiffness, a wrong model would
    drift off the data. What is left is then given in the full metric of the noise. ``coarse`` stops where what can
    still be gained no longer matters in a comparison.
    """
    constants = [*problem.own, *(constant for form in forms.values() for constant in form.constants)]
    low, high = _column(constants, "low"), _column(constants, "high")
    scale, prior_sd = _column(constants, "scale"), _column(constants, "prior_sd")
    centre = _column(constants, "value")
    weight = np.where(np.isfinite(prior_sd), 1.0 / prior_sd**2, 0.0)
    target = problem.measured if data is None else data
    own = len(problem.own)
    full, noise = noise, noise.plain

    def predict(x: Array) -> Array:
        return problem.predict(x[:own], split(x[own:], forms))

    def state(x: Array) -> tuple[Array, Array, float]:
        value = predict(x)
        if not np.all(np.isfinite(value)):
            return value, value, np.inf
        # A model that has run away misses by more than a number can hold: infinitely.
        with np.errstate(over="ignore"):
            left = noise.whiten(target - value)
            return value, left, float(left @ left)

    def beyond(x: Array) -> Array:
        return np.array(list(problem.forbidden(x[:own], split(x[own:], forms)).values()))

    def slopes(x: Array, outside: Array) -> Array:
        """Return how what is forbidden (k,) changes with each constant, (k, constants)."""
        if not np.any(outside > 0.0):
            return np.zeros((len(outside), len(x)))
        step = 1e-5 * np.maximum(np.abs(x), scale)
        moved = np.stack([beyond(x + step[i] * np.eye(len(x))[i]) - outside for i in range(len(x))], axis=1)
        return np.asarray(moved / step) * (outside > 0.0)[:, None]

    def holds(left: Array) -> Array:
        # While the model is wrong its misfit counts as noise: else a wrong model would break what is known before.
        return weight * max(float(left @ left) / len(left), 1.0)

    x = np.clip(np.asarray(start, dtype=np.float64), low, high)
    value, left, misfit = state(x)
    if not np.isfinite(misfit):
        x = centre.copy()
        x[:own] = np.asarray(start, dtype=np.float64)[:own]
        value, left, misfit = state(x)
    if not np.isfinite(misfit):
        return _nowhere(forms, x, value, weight, own)
    jacobian = _jacobian(problem, forms, x, value, scale, low, high, noise)
    damping = 1e-4
    prior = holds(left)
    outside = beyond(x)
    for _ in range(iterations):
        prior = holds(left)
        wall = _WALL**2 * max(misfit / len(left), 1.0)
        cost = misfit + float(prior @ (x - centre) ** 2) + wall * float(outside @ outside)
        gradient = jacobian.T @ left - prior * (x - centre)
        normal = jacobian.T @ jacobian + np.diag(prior)
        if np.any(outside > 0.0):
            slope = slopes(x, outside)
            gradient = gradient - wall * slope.T @ outside
            normal = normal + wall * slope.T @ slope
        held = ((x <= low) & (gradient < 0.0)) | ((x >= high) & (gradient > 0.0))
        size = np.diag(normal) + 1e-12 / scale**2
        moved = False
        for _ in range(8):
            step = _step(normal, size, gradient, damping, x, low, high, ~held)
            trial = np.clip(x + step, low, high)
            new_value, new_left, new_misfit = state(trial)
            new_outside = beyond(trial)
            new_cost = new_misfit + float(prior @ (trial - centre) ** 2)
            new_cost += wall * float(new_outside @ new_outside)
            if new_cost < cost:
                moved = True
                break
            damping = max(damping, 1e-6) * 10.0
        if not moved:
            break
        small = cost - new_cost < _SHARE * cost + _AMOUNT
        # In units of what is left: a misfit counts as noise.
        small = small or (coarse and cost - new_cost < _COARSE * max(new_misfit / len(left), 1.0))
        # A step that a bound cuts short is not the end: the next one goes along the bound.
        cut = bool(np.any(trial != x + step)) and not np.array_equal(trial, x)
        x, value, left, misfit, outside = trial, new_value, new_left, new_misfit, new_outside
        jacobian = _jacobian(problem, forms, x, value, scale, low, high, noise)
        damping = max(damping / 10.0, 1e-9)
        if small and not cut:
            break
    if full.gain_sd or full.correlation:
        full = full.at(value)
        left, jacobian = full.whiten(target - value), full.whiten(jacobian * noise.sd[:, None])
    return Fit(
        forms=dict(forms),
        x=x,
        predicted=value,
        residual=left,
        jacobian=jacobian,
        precision=jacobian.T @ jacobian + np.diag(prior),
        chi2=float(left @ left),
        cost=misfit + float(prior @ (x - centre) ** 2),
        prior=prior,
        own=own,
    )


def _step(
    normal: Array,
    size: Array,
    gradient: Array,
    damping: float,
    x: Array,
    low: Array,
    high: Array,
    free: NDArray[np.bool_],
) -> Array:
    """Return the damped step of the ``free`` constants; those at a bound that it would carry out of it stay there."""
    step = np.zeros_like(x)
    for _ in range(len(x)):
        # In units of what the data tell of each constant: their own units lie many powers of ten apart.
        unit = 1.0 / np.sqrt(size[free])
        matrix = normal[np.ix_(free, free)] * np.outer(unit, unit) + damping * np.eye(len(unit))
        step[:] = 0.0
        step[free] = unit * np.linalg.lstsq(matrix, unit * gradient[free], rcond=1e-14)[0]
        out = ((x <= low) & (step < 0.0)) | ((x >= high) & (step > 0.0))
        if not np.any(out):
            break
        free = free & ~out
    return step


def least_misfits(problem: Problem, metrics: Sequence[Noise], found: Fit) -> Array:
    """Return the least chi-squared near a fit in each of several metrics: one step of Gauss and Newton away.

    The metrics differ in what rows have in common alone.
    """
    constants = [*problem.own, *(constant for form in found.forms.values() for constant in form.constants)]
    low, high, scale = (_column(constants, name) for name in ("low", "high", "scale"))
    plain = metrics[0].plain
    slope = _jacobian(problem, found.forms, found.x, found.predicted, scale, low, high, plain)
    slope = slope[:, (found.x > low) & (found.x < high)] * plain.sd[:, None]
    misfits = []
    for metric in metrics:
        left, columns = metric.whiten(problem.measured - found.predicted), metric.whiten(slope)
        size = np.sqrt(np.sum(columns**2, axis=0))
        columns = columns[:, size > 0.0] / size[size > 0.0]
        step = np.linalg.lstsq(columns, left, rcond=1e-9)[0]
        misfits.append(float(left @ left - (columns @ step) @ (columns @ step)))
    return np.array(misfits)


def _nowhere(forms: Mapping[str, Form], x: Array, value: Array, weight: Array, own: int) -> Fit:
    """Return the fit of a model that has no prediction at ``x``: infinitely bad."""
    empty = np.zeros((len(value), len(x)))
    far = np.full_like(value, np.inf)
    return Fit(dict(forms), x, value, far, empty, np.diag(weight), np.inf, np.inf, weight, own)


def _column(constants: Sequence[Constant], name: str) -> Array:
    return np.array([getattr(constant, name) for constant in constants], dtype=np.float64)


def _jacobian(
    problem: Problem,
    forms: Mapping[str, Form],
    x: Array,
    value: Array,
    scale: Array,
    low: Array,
    high: Array,
    noise: Noise,
) -> Array:
    """Return the whitened derivative of the prediction, by one-sided differences inside the bounds."""
    step = 1e-5 * np.maximum(np.abs(x), scale)
    step = np.where(x + step > high, -step, step)
    moved = x + np.diag(step)
    own = len(problem.own)
    found = (problem.predict_many(moved[:, :own], forms, moved[:, own:]) - value) / step[:, None]
    # What is held has no say: no other constant has to make up for it.
    found[low == high] = 0.0
    return noise.whiten(np.where(np.isfinite(found), found, 0.0).T)
