"""Constants that fit best among those that are Drucker-stable.

For given nonlinear constants the stability matrix of each state is linear in the linear constants, so the fit
under stability is convex: a least-squares problem with one linear inequality for every state and direction of
strain. The inequalities are added where they are violated most, until none is. The nonlinear constants are
sought around it in their box.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.identification.design import Problem
from hyperfab.materials.identification.linear import least_norm, lengths, nonnegative
from hyperfab.materials.identification.search import box_points, scan
from hyperfab.materials.law import Array, Sheet
from hyperfab.materials.modes import second_stretch

#: Stretches looked at in each mode: far finer than any test.
_POINTS = 400
#: The smaller eigenvalue is kept above this share of the largest stress: rounding must not decide. Where a finer check
#: finds that it did, more is taken.
SLACKS = (1e-7, 1e-5, 1e-4, 1e-3, 1e-2)
#: The stretches are followed this share beyond the data, so that the end itself is inside.
_BEYOND = 1e-5
_ROUNDS = 60
#: Below the first, scaled columns are copies of each other, whose constants count by the second beside the rows.
_ALIKE, _SMALL = 1e-13, 1e-6
_SCAN = {1: 61, 2: 21}


@dataclass(frozen=True)
class States:
    """The stability matrices of every term at every state: shape (states, terms) each."""

    d11: Array
    d12: Array
    d22: Array


@dataclass(frozen=True)
class Stable:
    """The fit of a ``problem`` that is stable over the stretches of ``reach`` (mode: lowest, highest) and at ``pairs``
    of them (n, 2), by a ``share`` of the largest stress."""

    problem: Problem
    reach: Mapping[str, tuple[float, float]]
    share: float = SLACKS[0]
    pairs: Array | None = None

    def states(self, theta: list[float]) -> States:
        """Return the matrices dt/de of each free term at all these stretches."""
        problem, pairs = self.problem, self.pairs
        nu = problem.law.contraction(theta)
        stretch, second = [], []
        for mode, (low, high) in self.reach.items():
            lam = np.geomspace(low / (1.0 + _BEYOND), high * (1.0 + _BEYOND), _POINTS)
            stretch.append(lam)
            second.append(second_stretch(mode, lam, nu))
        if pairs is not None:
            stretch.append(pairs[:, 0])
            second.append(pairs[:, 1])
        sheet = Sheet.of(np.concatenate(stretch), np.concatenate(second))
        parts: list[list[Array]] = [[], [], []]
        with np.errstate(all="ignore"):
            terms = problem.law.terms(sheet, theta)
            for number in problem.free:
                found = terms[number].membrane(sheet)
                parts[0].append(sheet.l1 * (found.P1 + sheet.l1 * found.A11))
                parts[1].append(sheet.l1 * sheet.l2 * found.A12)
                parts[2].append(sheet.l2 * (found.P2 + sheet.l2 * found.A22))
        return States(*(np.stack(part, axis=-1) for part in parts))

    def constants(self, u: Array) -> tuple[Array, float] | None:
        """Return the best linear constants at ``u`` that are stable, and their square sum; None where there are none.

        With several groups of rows each group's constants are stable.
        """
        problem = self.problem
        with np.errstate(all="ignore"):
            A = problem.design(u)
        theta = [float(value) for value in problem.theta(list(u))]
        D = self.states(theta)
        if not (np.isfinite(A).all() and all(np.isfinite(part).all() for part in (D.d11, D.d12, D.d22))):
            return None
        groups, width = problem.rows.groups, len(problem.free)
        cuts: list[Array] = []
        slack = self.share * float(np.abs(problem.rows.stress).max())
        c = least_norm(A, problem.b)
        for _ in range(_ROUNDS):
            fresh = []
            for group in range(groups):
                for cut in _violated(D, c[group * width : (group + 1) * width], 0.5 * slack):
                    wide = np.zeros(groups * width)
                    wide[group * width : (group + 1) * width] = cut
                    fresh.append(wide)
            if not fresh:
                residual = problem.b - A @ c
                return c, float(residual @ residual)
            cuts += fresh
            found = constrained(A, problem.b, np.array(cuts), slack)
            if found is None:
                return None
            c = found
        return None

    def optimum(self) -> tuple[Array, Array] | None:
        """Return ``u`` and the linear constants of the best stable fit, or None where no constants are stable.

        Linear laws need one convex problem. For the others the box is scanned and the best points improved by a
        pattern of shrinking steps: the stable optimum often sits on a kink, where slopes do not help.
        """
        problem = self.problem
        if not problem.axes:
            found = self.constants(np.zeros(0))
            return None if found is None else (np.zeros(0), found[0])
        points = box_points(problem.axes, _SCAN[min(len(problem.axes), 2)])
        # Without stability the fit is no worse: points that lose even so need no convex problem.
        bound = scan(problem, points)
        value, best = np.inf, None
        for k in np.argsort(bound, kind="stable"):
            if not bound[k] < value:
                break
            found = self.constants(points[k])
            if found is not None and found[1] < value:
                value, best = found[1], points[k]
        if best is None:
            return None
        best = self._pattern(best)
        found = self.constants(best)
        return None if found is None else (best, found[0])

    def _pattern(self, u: Array) -> Array:
        """Walk downhill from ``u`` in steps along the axes and along the last success, halving where none helps."""
        low = np.array([axis.low for axis in self.problem.axes])
        high = np.array([axis.high for axis in self.problem.axes])
        size = 1.0 / _SCAN[min(len(low), 2)]
        value = np.inf if (start := self.constants(u)) is None else start[1]
        directions = [sign * one for one in np.diag(high - low) for sign in (1.0, -1.0)]
        while size > 1e-6:
            before = u
            for direction in directions:
                trial = np.clip(u + size * direction, low, high)
                found = self.constants(trial)
                if found is not None and found[1] < value:
                    u, value = trial, found[1]
            if u is before:
                size *= 0.4
            else:
                # Valleys lie askew: the sum of the last steps is tried next.
                askew = (u - before) / size
                directions = [*directions[: 2 * len(low)], askew, -askew]
        return u


def _violated(D: States, c: Array, least: float) -> list[Array]:
    """Return the inequalities g . c >= least that the constants break worst, one at each low point along the states."""
    d11, d12, d22 = D.d11 @ c, D.d12 @ c, D.d22 @ c
    middle, radius = 0.5 * (d11 + d22), np.hypot(0.5 * (d11 - d22), d12)
    lower = middle - radius
    low = lower < least
    low[1:] &= lower[1:] <= lower[:-1]
    low[:-1] &= lower[:-1] <= lower[1:]
    found = []
    for k in np.flatnonzero(low):
        angle = 0.5 * np.arctan2(2.0 * d12[k], d11[k] - d22[k]) + 0.5 * np.pi
        x, y = np.cos(angle), np.sin(angle)
        found.append(x * x * D.d11[k] + 2.0 * x * y * D.d12[k] + y * y * D.d22[k])
    return found


def constrained(A: Array, b: Array, G: Array, least: float = 0.0) -> Array | None:
    """Return c that minimises |b - A c| with G c >= least, or None (Lawson & Hanson's least-distance form).

    >>> constrained(np.eye(2), np.array([1.0, -1.0]), np.array([[0.0, 1.0]])).round(12) + 0.0
    array([1., 0.])
    """
    length = lengths(A)
    Q, R = np.linalg.qr(A / length)
    if np.abs(np.diag(R)).min() < _ALIKE:
        # What the rows cannot tell apart, as I1 and I2 in planar tension, is taken small.
        small = _SMALL * np.eye(A.shape[1])
        Q, R = np.linalg.qr(np.vstack([A / length, small]))
        b = np.concatenate([b, np.zeros(A.shape[1])])
    q = Q.T @ b
    E = np.linalg.solve(R.T, (G / length).T).T
    scale = np.sqrt((E * E).sum(axis=1))
    scale = np.where(scale > 0.0, scale, 1.0)
    E = E / scale[:, None]
    f = least / scale - E @ q
    size = float(np.abs(q).max()) or 1.0
    M = np.vstack([E.T, f / size])
    target = np.zeros(len(M))
    target[-1] = 1.0
    y = nonnegative(M, target)
    r = M @ y - target
    if abs(r[-1]) < 1e-12:
        return None
    z = -r[:-1] / r[-1] * size
    return np.asarray(np.linalg.solve(R, z + q) / length)
