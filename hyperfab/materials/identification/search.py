"""Where to start: the box of the nonlinear constants scanned, the linear ones solved for at every point."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from hyperfab.materials.identification.design import Problem
from hyperfab.materials.law import Array, Axis

#: Points along one axis, by the number of axes.
_POINTS = {1: 61, 2: 49, 3: 13}
#: Rows that the scan looks at; the polish sees all.
_ROWS = 240
#: How many starts are polished.
STARTS = 12


def starts(problem: Problem) -> Array:
    """Return the most promising points of the box, shape (STARTS, axes), none beside another."""
    axes = problem.axes
    problem = thinned(problem, _ROWS)
    if problem.law.exchangeable and len(axes) > 1:
        return _scan_of_equals(problem)
    count = _POINTS[len(axes)]
    points = box_points(axes, count)
    sse = scan(problem, points).reshape((count,) * len(axes))
    return points[_valleys(sse)]


def beside(problem: Problem, u: Array) -> Array:
    """Return the most promising points (any number, axes) that differ from ``u`` (axes,) in the last coordinate alone.

    Where the others are the best of a law with one term less they tell what one more adds.
    """
    points = np.tile(u, (_POINTS[1], 1))
    points[:, -1] = np.linspace(problem.axes[-1].low, problem.axes[-1].high, _POINTS[1])
    sse = scan(thinned(problem, _ROWS), points)
    points, sse = points[np.isfinite(sse)], sse[np.isfinite(sse)]
    return points[_valleys(sse)] if len(sse) else points


def box_points(axes: Sequence[Axis], count: int) -> Array:
    """Return the points of a grid over the box, ``count`` along each axis, shape (points, axes)."""
    lines = [np.linspace(axis.low, axis.high, count) for axis in axes]
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(axes))


def thinned(problem: Problem, rows: int) -> Problem:
    """Return the problem with no more than ``rows`` of its rows, evenly taken, in the same box."""
    if len(problem.rows) <= rows:
        return problem
    chosen = np.unique(np.linspace(0, len(problem.rows) - 1, rows).astype(int))
    fewer = Problem(problem.law, problem.rows.take(chosen))
    fewer.__dict__["axes"] = problem.axes
    return fewer


def scan(problem: Problem, u: Array) -> Array:
    """Square sum at each point with free constants, infinite where the law does not exist there."""
    with np.errstate(all="ignore"):
        A = problem.design(u)
        length = np.sqrt(np.einsum("gij,gij->gj", A, A))
        A = A / np.where(length > 0.0, length, 1.0)[:, None, :]
        bad = ~np.isfinite(A).all(axis=(1, 2))
        A[bad] = 0.0
        G = np.einsum("gij,gik->gjk", A, A)
        h = np.einsum("gij,i->gj", A, problem.b)
        c = _solve(G, h)
        sse = problem.b @ problem.b - np.einsum("gj,gj->g", c, h)
    signs = problem.signs(u)
    if signs is not None:
        bad |= ~(c * signs >= 0.0).all(axis=1)
    return np.where(bad, np.inf, sse)


def _solve(G: Array, h: Array) -> Array:
    """Normal equations with a trace of damping: good enough to rank the points of a scan."""
    return np.asarray(np.linalg.solve(G + 1e-11 * np.eye(G.shape[-1]), h[..., None])[..., 0])


def _valleys(sse: Array) -> Array:
    """Return the flat indices of the lowest points that no neighbour along an axis undercuts."""
    low = np.isfinite(sse)
    for axis in range(sse.ndim):
        for shift in (1, -1):
            other = np.roll(sse, shift, axis=axis)
            edge = [slice(None)] * sse.ndim
            edge[axis] = slice(0, 1) if shift == 1 else slice(-1, None)
            other[tuple(edge)] = np.inf
            low &= sse <= other
    found = np.flatnonzero(low)
    if not len(found):
        found = np.arange(sse.size)
    return found[np.argsort(sse.ravel()[found], kind="stable")[:STARTS]]


def _scan_of_equals(problem: Problem) -> Array:
    """Scan a law whose terms are alike and differ by one constant each: all sets of different points of one axis.

    Only sets with every constant of the right sign count: any other is a law of lower order, no better.
    """
    axes = problem.axes
    order = len(axes)
    count = {2: 49, 3: 41}[order]
    # Denser where the exponents are small and the terms change most.
    bend = np.linspace(-1.0, 1.0, count + count % 2)
    line = axes[0].high * np.sinh(3.0 * bend) / np.sinh(3.0)
    with np.errstate(all="ignore"):
        columns = problem.columns(problem.theta([line[:, None]] * order))[..., 0]
    columns = columns * np.sign(line)[:, None]
    sets = np.array(list(combinations(range(len(line)), order)))
    gain = np.zeros(len(sets))
    for group in range(problem.rows.groups):
        A = columns * (problem.rows.group == group)
        A = A / np.sqrt((A * A).sum(axis=1))[:, None]
        G, h = A @ A.T, (A @ problem.b)[sets]
        c = _solve(G[sets[:, :, None], sets[:, None, :]], h)
        gain += np.where((c >= 0.0).all(axis=1), np.einsum("gj,gj->g", c, h), -np.inf)
    ranked = np.lexsort(
        (-sets.sum(axis=1), -np.round(gain / np.abs(gain).max(where=np.isfinite(gain), initial=1e-300), 12))
    )
    taken: list[int] = []
    for number in ranked[: 60 * STARTS]:
        if not np.isfinite(gain[number]):
            break
        if all(np.abs(sets[number] - sets[other]).max() > 1 for other in taken):
            taken.append(int(number))
        if len(taken) == STARTS:
            break
    if not taken:
        taken = [int(ranked[0])]
    return line[sets[taken]]
