"""Weighted least squares with bounds and priors: the model's own constants and those of its terms together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Constant, Form, Problem, split
from hyperfab.loop.steps import Box, Ground, Walls, step_along, step_inside
from hyperfab.numerics.gram import inverse, orthonormal

#: A step is accepted as the last one where it lowers chi-squared by less than this share, or this much; coarser where
#: fits are only compared: the gain is then below a tenth of what one constant has to earn.
_SHARE, _AMOUNT, _COARSE = 1e-5, 2e-3, 0.3
#: Damping a descent begins with (where it takes more the valley is curved), how often it is raised by ten before no
#: step is thought to lower the misfit, and by what share a step may miss what was foretold for its slopes to serve on.
_DAMPING, _TRIES, _FORESEEN = 1e-4, 8, 0.25
#: Where the second derivative along a step is read, as a share of it; a bend beside it is at most so long.
_NEAR, _BENT = 0.1, 0.75
#: Steps from each of two starts or more, those after which half of as many starts as this are left, and steps of a fit
#: in another metric.
_FEW, _FEWER, _SEVERAL, _REFIT = 5, 3, 4, 10
#: How steep the wall is before constants that no material has, in units of what the model misses by.
_WALL = 1e4


@dataclass(frozen=True)
class Fit:
    """A model fitted to data.

    ``x`` holds the own constants, then those of each term in order. ``residual`` (rows) and ``jacobian``
    (rows, constants)
    are whitened: in units of the noise, uncorrelated. ``chi2`` is of the data alone, ``cost`` with the priors.
    ``predicted`` is what the model says, ``by_model``, with what common causes of the noise are likely to have done.
    ``in_metric`` is the Jacobian in the ``metric`` that the readings counted in.
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
    by_model: Array
    in_metric: Array
    metric: Noise

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

    def errors(self, noise: Noise) -> tuple[Array, Array]:
        """Return the covariance of the constants by how readings err, and what they err by as specimens differ.

        Of readings counted as they were: specimens led alike have in common what they differ from others by, and it
        counted as the model's. The curvature in the full metric is that of another estimate, which would forgive it.
        Of weighted least squares: Huber (1967), Proc. 5th Berkeley Symp. 1, 221.
        """
        readings, specimens = noise.at(self.by_model).covariances(self.metric.weights(self.in_metric))
        normal = inverse(self.in_metric.T @ self.in_metric + np.diag(self.prior), 1e-13)
        return normal @ (readings + np.diag(self.prior)) @ normal, normal @ specimens @ normal

    def place(self, effect: str) -> slice:
        """Return where in ``x`` the constants of a term stand."""
        at = self.own
        for name, form in self.forms.items():
            if name == effect:
                return slice(at, at + len(form.constants))
            at += len(form.constants)
        raise KeyError(effect)


def fit(
    problem: Problem,
    noise: Noise,
    forms: Mapping[str, Form],
    start: Sequence[float] | Array,
    *,
    data: Array | None = None,
    iterations: int = 30,
) -> Fit:
    """Fit all constants to ``data`` (the measured values by default) from ``start``: a whole ``Descent``."""
    if data is not None:
        return Descent(problem, noise, forms, start, data=data).advance(iterations).fit(noise)
    return descent(problem, noise, forms, [start], iterations=iterations).fit(noise)


def descent(
    problem: Problem,
    noise: Noise,
    forms: Mapping[str, Form],
    starts: Sequence[Sequence[float] | Array],
    *,
    iterations: int = 30,
    coarse: bool = False,
) -> Descent:
    """Return the descent from that of several starts that leads on, each made once for a problem.

    The same fits are asked for again where all that changes is what readings of one specimen have in common: that has
    no say in them where no two were led alike.
    """
    names = tuple((effect, form.name) for effect, form in forms.items())
    begins = tuple(np.asarray(start, dtype=np.float64).tobytes() for start in starts)
    key = (names, begins, hash(noise.sd.tobytes()), noise.about, iterations, coarse)
    if key not in problem.descents:
        # A few steps from each start tell which of them leads on; where the constants are well known, so that a fit
        # starts from what is known of them as well, the worse half is left before.
        tries = [Descent(problem, noise, forms, start, coarse=coarse) for start in starts]
        several = len(tries) >= _SEVERAL and problem.well_known
        if len(tries) > 1:
            tries = [one.advance(_FEWER if several else _FEW) for one in tries]
        if several:
            half = sorted(tries, key=lambda one: one.cost)[: (len(tries) + 1) // 2]
            tries = [one.advance(_FEW - _FEWER) for one in half]
        problem.descents[key] = min(tries, key=lambda one: one.cost).advance(iterations)
    found: Descent = problem.descents[key]
    return found


class Descent:
    """A fit under way, by Levenberg and Marquardt: where it is, and what is known there.

    Priors pull towards the constants' values; bounds hold by projection, what is forbidden by a wall. The fit forgives
    specimens that were led alike what they differ by in stiffness, not what they have in common: in a metric that
    forgives that too a wrong model would drift off the data. What is left is then given in the full metric of the
    noise. ``coarse`` stops where what can still be gained no longer matters in a comparison. ``metric`` is another
    that the misfit is counted in.
    """

    def __init__(
        self,
        problem: Problem,
        noise: Noise,
        forms: Mapping[str, Form],
        start: Sequence[float] | Array,
        *,
        data: Array | None = None,
        coarse: bool = False,
        metric: Noise | None = None,
    ) -> None:
        constants = [*problem.own, *(constant for form in forms.values() for constant in form.constants)]
        self.problem, self.forms = problem, forms
        self.metric = noise.about_means if metric is None else metric
        self.low, self.high = _column(constants, "low"), _column(constants, "high")
        self.scale, prior_sd = _column(constants, "scale"), _column(constants, "prior_sd")
        self.centre, self.own = _column(constants, "value"), len(problem.own)
        self.weight = np.where(np.isfinite(prior_sd), 1.0 / prior_sd**2, 0.0)
        self.target = problem.measured if data is None else data
        self.coarse, self.damping = coarse, _DAMPING
        self.x = np.clip(np.asarray(start, dtype=np.float64), self.low, self.high)
        self.value, self.left, self.misfit = self._answer(self.x)
        if not np.isfinite(self.misfit):
            self.x = self.centre.copy()
            self.x[: self.own] = np.asarray(start, dtype=np.float64)[: self.own]
            self.value, self.left, self.misfit = self._answer(self.x)
        self.ended = not np.isfinite(self.misfit)
        self.prior = self.weight if self.ended else self._holds()
        self.beyond = np.zeros(0) if self.ended else self._beyond(self.x)
        self.jacobian = np.empty((0, len(self.x)))
        #: Whether the Jacobian may serve the next step, and whether it was asked for where the descent is.
        self.serves = self.exact = False

    @property
    def cost(self) -> float:
        """Chi-squared with the priors, infinite where the model has no prediction."""
        return self.misfit + float(self.prior @ (self.x - self.centre) ** 2)

    def advance(self, steps: int) -> Descent:
        """Go on by so many steps, or to the end."""
        for _ in range(steps):
            if self.ended:
                break
            self._advance()
        return self

    def fit(self, noise: Noise) -> Fit:
        """Return the model as it is fitted so far, in the full metric of the ``noise``."""
        forms, x, value = dict(self.forms), self.x, self.value
        if not np.isfinite(self.misfit):
            empty, far = np.zeros((len(value), len(x))), np.full_like(value, np.inf)
            prior = np.diag(self.weight), np.inf, np.inf, self.weight
            return Fit(forms, x, value, far, empty, *prior, self.own, value, empty, self.metric)
        if not self.exact:
            self.ask()
        left, jacobian = self.left, self.jacobian
        if noise.gain_sd or noise.across_sd or noise.is_correlated:
            full = noise.at(value)
            left = full.whiten(self.target - value)
            jacobian = full.whiten(self.metric.coloured(jacobian))
        precision = jacobian.T @ jacobian + np.diag(self.prior)
        chi2 = float(left @ left)
        shown = value + self.metric.owed(self.target - value)
        known = precision, chi2, self.cost, self.prior
        return Fit(forms, x, shown, left, jacobian, *known, self.own, value, self.jacobian, self.metric)

    # What no number holds is no way to go, and is looked at below.
    @np.errstate(over="ignore", invalid="ignore")
    def _advance(self) -> None:
        """Take a step: by slopes asked for, or by those of the step before as it has changed them.

        That asks for no prediction (Broyden 1965, doi:10.1090/S0025-5718-1965-0198670-6), and serves as long as a step
        brings what it foretold. A descent ends by slopes that were asked for.
        """
        if not self.serves:
            self.ask()
        x, jacobian = self.x, self.jacobian
        self.prior = self._holds()
        wall = _WALL**2 * max(self.misfit / len(self.left), 1.0)
        outside = np.maximum(self.beyond, 0.0)
        cost = self.cost + wall * float(outside @ outside)
        gradient = jacobian.T @ self.left - self.prior * (x - self.centre)
        normal = jacobian.T @ jacobian + np.diag(self.prior)
        box, size = Box(x, self.low, self.high), np.diag(normal) + 1e-12 / self.scale**2
        if not (np.all(np.isfinite(gradient)) and np.all(np.isfinite(normal))):
            self.ended, self.serves = True, False
            return
        known, beyond, slopes = outside > 0.0, self.beyond.copy(), np.zeros((len(outside), len(x)))
        if np.any(known):
            slopes = self._slopes_beyond(x, beyond)
        tries = _TRIES if self.exact else 1
        while tries > 0:
            ground = Ground(gradient, normal, size, self.damping)
            step, free, walls = step_inside(ground, box, Walls(beyond, slopes).of(known))
            if self.exact and self.damping > _DAMPING:
                step = step + self._bend(step, ground, free, walls)
            trial = np.clip(x + step, self.low, self.high)
            value, left, misfit = self._answer(trial)
            reached = self._beyond(trial)
            outside = np.maximum(reached, 0.0)
            gained = cost - misfit - float(self.prior @ (trial - self.centre) ** 2)
            gained -= wall * float(outside @ outside)
            if gained > 0.0:
                break
            # Where no number tells how far off a step is, it has gone too far.
            met = (outside > 0.0) & ~known & np.all(np.isfinite(outside))
            if self.exact and np.any(met):
                # A step into a wall: the next one knows of it.
                slopes[met] = self._slopes_beyond(trial, reached)[met]
                beyond[met] = reached[met] - slopes[met] @ (trial - x)
                known = known | met
                continue
            tries -= 1
            if self.exact:
                self.damping = max(self.damping, 1e-6) * 10.0
                if tries < _TRIES // 2:
                    # What the data tell next to nothing of runs to its bounds however much a step is damped.
                    size = np.maximum(size, np.abs(gradient) / self.scale)
        else:
            self.ended, self.serves = self.exact, False
            return
        small = gained < _SHARE * cost + _AMOUNT
        # In units of what is left: a misfit counts as noise.
        small = small or (self.coarse and gained < _COARSE * max(misfit / len(left), 1.0))
        # A step that a bound cuts short is not the end: the next one goes along the bound.
        cut = bool(np.any(trial != x + step)) and not np.array_equal(trial, x)
        went, told = trial - x, self.left - left
        foretold = 2.0 * float(gradient @ went) - float(went @ normal @ went)
        self.x, self.value, self.left, self.misfit, self.beyond = trial, value, left, misfit, reached
        self.damping = max(self.damping / 10.0, 1e-12)
        self.ended = small and self.exact and not cut
        self.serves = abs(gained - foretold) < _FORESEEN * foretold and not small and not cut
        if self.ended or self.serves:
            along = size * went
            self.jacobian = jacobian + np.outer(told - jacobian @ went, along / float(along @ went))
        self.exact = self.ended

    def _bend(self, step: Array, ground: Ground, free: Flags, walls: Walls) -> Array:
        """Return what a damped step is bent by to follow a curved valley: half the geodesic acceleration.

        Transtrum & Sethna (2012), arXiv:1201.5885: from the second derivative along the step, one prediction more.
        """
        near = np.clip(self.x + _NEAR * step, self.low, self.high)
        _, left, misfit = self._answer(near)
        if not np.isfinite(misfit):
            return np.zeros_like(step)
        second = 2.0 / _NEAR * ((self.left - left) / _NEAR - self.jacobian @ ((near - self.x) / _NEAR))
        there = ground._replace(gradient=-self.jacobian.T @ second)
        bend = 0.5 * step_along(there, Box(self.x, self.low, self.high), walls.met, free)
        far = float(ground.size @ bend**2) > _BENT**2 * float(ground.size @ step**2)
        return np.zeros_like(step) if far else bend

    def _answer(self, x: Array) -> tuple[Array, Array, float]:
        """Return the prediction, what it leaves in units of the noise, and chi-squared."""
        value = self.problem.predict(x[: self.own], split(x[self.own :], self.forms))
        if not np.all(np.isfinite(value)):
            return value, value, np.inf
        # A model that has run away misses by more than a number can hold: infinitely.
        with np.errstate(over="ignore"):
            left = self.metric.whiten(self.target - value)
            return value, left, float(left @ left)

    def ask(self) -> None:
        """Ask for the slopes where the descent is, by one-sided differences inside the bounds."""
        step = 1e-5 * np.maximum(np.abs(self.x), self.scale)
        step = np.where(self.x + step > self.high, -step, step)
        # What is held has no say: no other constant has to make up for it.
        free = self.low < self.high
        moved = (self.x + np.diag(step))[free]
        slopes = np.zeros((len(step), len(self.value)))
        if len(moved):
            found = self.problem.predict_near(self.x, self.forms, moved)
            slopes[free] = (found - self.value) / step[free, None]
        self.jacobian = self.metric.whiten(np.where(np.isfinite(slopes), slopes, 0.0).T)
        self.serves = self.exact = True

    def _beyond(self, x: Array) -> Array:
        """Return by how much the constants are forbidden ones, (walls,), below 0 where they are not."""
        return np.array(list(self.problem.forbidden(x[: self.own], split(x[self.own :], self.forms)).values()))

    def _slopes_beyond(self, x: Array, beyond: Array) -> Array:
        """Return how what is forbidden at ``x``, ``beyond``, changes with each constant, (walls, constants)."""
        step = 1e-5 * np.maximum(np.abs(x), self.scale)
        slopes = np.zeros((len(beyond), len(x)))
        for place in np.flatnonzero(self.low < self.high):
            moved = x.copy()
            moved[place] += step[place]
            slopes[:, place] = (self._beyond(moved) - beyond) / step[place]
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def _holds(self) -> Array:
        """Return the weight of each prior."""
        # While the model is wrong its misfit counts as noise: else a wrong model would break what is known before.
        return self.weight * max(float(self.left @ self.left) / len(self.left), 1.0)


def stepped_misfits(problem: Problem, metrics: Sequence[Noise], found: Fit) -> tuple[Array, Array]:
    """Return the least chi-squared near a fit in each of several metrics, and what telling its constants takes from the
    logarithm of the determinant of each metric's covariance, (metrics,).

    It is one step of Gauss and Newton away. The metrics differ in what rows have in common alone. What is taken is as
    in restricted likelihood, over what it is without anything in common: Patterson & Thompson (1971),
    doi:10.1093/biomet/58.3.545.
    """
    plain = metrics[0].plain
    there = Descent(problem, plain, found.forms, found.x, metric=plain)
    there.ask()
    moving = (found.x > there.low) & (found.x < there.high)
    span = orthonormal(there.jacobian[:, moving]) * plain.sd[:, None]
    misfits, taken = np.empty((2, len(metrics)))
    for k, metric in enumerate(metrics):
        left, columns = metric.whiten(problem.measured - found.by_model), metric.whiten(span)
        basis = orthonormal(columns)
        rest = left - basis @ (basis.T @ left)
        misfits[k] = rest @ rest
        taken[k] = -np.linalg.slogdet(columns.T @ columns)[1]
    return misfits, taken


def fitted_misfit(problem: Problem, metric: Noise, found: Fit) -> Array:
    """Return the least chi-squared of a model in a metric, by kind of reading (kinds,), by a fit that begins at one.

    Each is made once for a problem.
    """
    names = tuple((effect, form.name) for effect, form in found.forms.items())
    rows = tuple(hash(np.asarray(one).tobytes()) for one in (metric.sd, metric.pattern, metric.correlation))
    key = (names, found.x.tobytes(), metric.gain_sd, metric.across_sd, rows)
    if key not in problem.misfits:
        near = Descent(problem, metric, found.forms, found.x, coarse=True, metric=metric).advance(_REFIT)
        kinds = [problem.channel == kind for kind in np.unique(problem.channel)]
        problem.misfits[key] = np.array([float(np.sum(near.left[kind] ** 2)) for kind in kinds])
    known: Array = problem.misfits[key]
    return known


def _column(constants: Sequence[Constant], name: str) -> Array:
    return np.array([getattr(constant, name) for constant in constants], dtype=np.float64)
