"""From starts to the optimum: variable projection with Levenberg-Marquardt steps, all starts at once.

The linear constants are eliminated at every point; the step uses Kaufman's form of the derivative of the
projected residual. Golub & Pereyra (1973), SIAM J. Numer. Anal. 10, 413, doi:10.1137/0710036; Kaufman (1975),
BIT 15, 49, doi:10.1007/BF01932995.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.materials.identification.design import Problem
from hyperfab.materials.identification.linear import Projection, project
from hyperfab.materials.law import Array

_ROUGH_STEPS = 25
_FINE_STEPS = 200
_NEWTON_STEPS = 8
#: A start is good enough to be compared, and the best one to be finished, when a step gains no more than this.
_ROUGH_GAIN, _FINE_GAIN = 1e-6, 1e-9
#: A step that does not improve is tried again damped by at least this, and eight times more each time. A point that no
#: step of so many has improved, the last of them a twentieth of the first, is at rest.
_DAMPED, _REST = 1e-4, 7


@dataclass(frozen=True)
class State:
    """A stack of points: coordinates ``u`` (points, axes), their projection, whether they are admissible."""

    u: Array
    projection: Projection
    sse: Array


def evaluate(problem: Problem, u: Array) -> State:
    """Return the best linear constants at each point; the square sum is infinite where a point is not allowed."""
    with np.errstate(all="ignore"):
        A = problem.design(u)
        bad = np.asarray(~np.isfinite(A).all(axis=(-2, -1)))
        A = np.where(bad[..., None, None], 0.0, A)
        found = project(A, problem.b)
    signs = problem.signs(u)
    if signs is not None:
        bad = bad | ~(found.c * signs >= 0.0).all(axis=-1)
    return State(u, found, np.where(bad, np.inf, found.sse))


def polish(problem: Problem, points: Array, finish: bool = True) -> State:
    """Improve all ``points`` together, keep the best, and, to ``finish``, drive it to where no step is left."""
    state = _descend(problem, evaluate(problem, points), _ROUGH_STEPS, _ROUGH_GAIN)
    if not np.isfinite(state.sse).any():
        return state
    # Where the tests cannot tell two optima apart (the sign of a power in planar shear) the larger values are taken.
    equal = state.sse <= state.sse.min() * (1.0 + 1e-9) + 1e-20 * (problem.b @ problem.b)
    best = int(np.argmax(np.where(equal, state.u.sum(axis=1), -np.inf)))
    found = _pick(state, [best])
    return _settle(problem, _descend(problem, found, _FINE_STEPS, _FINE_GAIN)) if finish else found


def _settle(problem: Problem, state: State) -> State:
    """Take Newton steps on the slope itself: the square sum is flat to rounding long before its slope is zero.

    The curvature comes from differences of the exact slope, so that a step leaves 1e-6 of the error or less.
    """
    low, high = _bounds(problem)
    last = np.inf
    for _ in range(_NEWTON_STEPS):
        inside = (state.u[0] > low) & (state.u[0] < high)
        if not inside.any():
            return state
        h = 1e-5 * (high - low)
        count = len(h)
        points = state.u[0] + np.concatenate([np.zeros((1, count)), np.diag(h), -np.diag(h)])
        with np.errstate(all="ignore"):
            slopes = _slope(problem, evaluate(problem, points))
        if not np.isfinite(slopes).all():
            return state
        H = (slopes[1 : count + 1] - slopes[count + 1 :]) / (2.0 * h[:, None])
        H = (0.5 * (H + H.T))[np.ix_(inside, inside)]
        if np.linalg.eigvalsh(H)[0] <= 0.0:
            return state
        step = np.zeros(count)
        step[inside] = -np.linalg.solve(H, slopes[0, inside])
        size = float(np.abs(step / (high - low)).max())
        trial = evaluate(problem, np.clip(state.u + step, low, high))
        if size >= last or not trial.sse[0] <= state.sse[0] * (1.0 + 1e-9) + 1e-28 * (problem.b @ problem.b):
            return state
        state, last = trial, size
    return state


def _slope(problem: Problem, state: State) -> Array:
    """Half the exact derivative of the square sum by each coordinate, shape (points, axes)."""
    p = state.projection
    change = [np.einsum("sij,sj->si", slope, p.c) for slope in problem.slopes(state.u)]
    return -np.stack([np.einsum("si,si->s", one, p.residual) for one in change], axis=-1)


def _bounds(problem: Problem) -> tuple[Array, Array]:
    return np.array([axis.low for axis in problem.axes]), np.array([axis.high for axis in problem.axes])


def _pick(state: State, numbers: list[int]) -> State:
    p = state.projection
    chosen = Projection(p.c[numbers], p.residual[numbers], p.sse[numbers], p.Q[numbers])
    return State(state.u[numbers], chosen, state.sse[numbers])


def _descend(problem: Problem, state: State, steps: int, gain: float) -> State:
    """Take damped steps from every point until none gains more than a share ``gain`` of its square sum."""
    low, high = _bounds(problem)
    floor = 1e-30 * float(problem.b @ problem.b)
    damping = np.full(len(state.u), 1e-3)
    resting = np.zeros(len(state.u), dtype=np.int64)
    for _ in range(steps):
        step, fixed = _step(problem, state, damping, low, high)
        trial = evaluate(problem, np.clip(state.u + step, low, high))
        better = trial.sse < state.sse
        gained = better & (trial.sse < (1.0 - gain) * state.sse - floor)
        resting = np.where(gained, 0, np.where(better, _REST, resting + 1))
        damping = np.where(better, damping * 0.1, np.maximum(damping * 8.0, _DAMPED)).clip(1e-14, 1e12)
        state = _merge(better, trial, state)
        if (fixed | (resting >= _REST)).all():
            break
    return state


def _step(problem: Problem, state: State, damping: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return the Levenberg-Marquardt step of each point, and which points have no direction left."""
    p = state.projection
    with np.errstate(all="ignore"):
        slopes = problem.slopes(state.u)
        columns = []
        for slope in slopes:
            change = np.einsum("sij,sj->si", np.nan_to_num(slope), p.c)
            inside = np.einsum("sij,si->sj", p.Q, change)
            columns.append(change - np.einsum("sij,sj->si", p.Q, inside))
        J = np.stack(columns, axis=-1)
        g = np.einsum("sij,si->sj", J, p.residual)
        H = np.einsum("sij,sik->sjk", J, J)
        # At an edge of the box a constant that pushes outward rests.
        rests = ((state.u <= low) & (g < 0.0)) | ((state.u >= high) & (g > 0.0))
        scale = np.einsum("sjj->sj", H)
        scale = np.where(scale > 0.0, scale, 1.0)
        H = H + (damping[:, None] * scale)[..., None] * np.eye(H.shape[-1])
        H = np.where(rests[:, :, None] | rests[:, None, :], np.eye(H.shape[-1]), H)
        finite = np.isfinite(H).all(axis=(1, 2)) & np.isfinite(g).all(axis=1) & np.isfinite(state.sse)
        H = np.where(finite[:, None, None], H, np.eye(H.shape[-1]))
        g = np.where(finite[:, None] & ~rests, g, 0.0)
        step = np.linalg.solve(H, g[..., None])[..., 0]
    return step, ~finite | rests.all(axis=1)


def _merge(better: Array, new: State, old: State) -> State:
    def choose(a: Array, b: Array) -> Array:
        return np.where(better.reshape(-1, *(1,) * (a.ndim - 1)), a, b)

    n, o = new.projection, old.projection
    return State(
        choose(new.u, old.u),
        Projection(choose(n.c, o.c), choose(n.residual, o.residual), choose(n.sse, o.sse), choose(n.Q, o.Q)),
        choose(new.sse, old.sse),
    )
