"""Solve without a tangent: a sheet steps along its unbalanced forces until none is left.

So does the relaxation of the report (its Algorithm 1), which stands here as it is, for comparison. Each node steps
along its unbalanced force by the sum of its springs' elongations over a constant c, and is set back onto the mold. That
step does not vanish at equilibrium, where the elongations stay: the nodes end by trembling about it, and the residual
floors near 1/c however many steps are made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel

from .balance import Balance
from .features import distance2
from .mold import Mold
from .net import Arrays, Sheet, neighbour
from .state import Equilibrium, State, Step

#: Finds the step (n, m, 3) of all nodes at a place whose forces and contact are known.
Direction = Callable[[State], Array]

#: All springs at this stretch store more than any sheet on its way to rest.
APART = 100.0
#: Every so many steps of the report's a line of the history is kept.
_EVERY = 10


def bounded(balance: Balance, first: float) -> float:
    """Energy in N mm that a sheet passes only on its way to infinity; ``first`` is what it began with."""
    rest = float(balance.model.net.rest[:2].max())
    return 2.0 * abs(first) + balance.f[..., 0].size * balance.stiffness * (APART * rest) ** 2


def march(
    balance: Balance,
    start: State,
    direction: Direction,
    largest: int,
    every: int,
    report: Callable[[Step], None] | None,
    unfinished: str,
    take_back: Callable[[State], None] | None = None,
) -> Equilibrium:
    """Make at most ``largest`` steps from ``start``, a line of history ``every`` so many.

    ``unfinished`` is the status where an unbalanced force is left above the balance's tolerance. A sheet that flies
    apart, its steps growing without end, ends where it was one step before. ``take_back`` may set it to a place before.
    """
    now, trial = start.copy(), start.copy()
    history: list[Step] = []
    limit = np.inf
    balance.even(now)
    for iteration in range(largest + 1):
        balance.forces(now)
        if take_back is not None:
            take_back(now)
        if not balance.energy <= limit:
            balance.forces(trial)
            balance.settle(trial)
            return balance.ended(trial, f"the sheet flew apart after {iteration} steps", history)
        balance.settle(now)
        limit = min(limit, bounded(balance, balance.energy))
        done = balance.residual <= balance.tolerance
        if iteration % every == 0 or done or iteration == largest:
            history.append(balance.line(iteration))
            if report:
                report(history[-1])
        if done or iteration == largest:
            break
        step = direction(now)
        np.copyto(balance.before, now.slot)
        balance.move(now, step, 1.0, trial)
        now, trial = trial, now
    return balance.ended(now, "" if done else unfinished, history)


@kernel
def _steps(x: Array, net: Arrays, r: Array, c: float, d: Array) -> None:
    """d = direction of the unbalanced force r times the sum of the node's elongations over c."""
    n, m = x.shape[0], x.shape[1]
    for i in range(n):
        for j in range(m):
            size = np.sqrt(r[i, j, 0] ** 2 + r[i, j, 1] ** 2 + r[i, j, 2] ** 2)
            if size == 0.0:
                d[i, j, 0], d[i, j, 1], d[i, j, 2] = 0.0, 0.0, 0.0
                continue
            total = 0.0
            for side in range(4):
                k, l = neighbour(i, j, side)
                if k < 0 or l < 0 or k >= n or l >= m:
                    continue
                total += max(np.sqrt(distance2(x[k, l], x[i, j])) - net.rest[side // 2], 0.0)
            for a in range(3):
                d[i, j, a] = r[i, j, a] / size * total / c


def relax(
    sheet: Sheet,
    mold: Mold,
    start: State,
    c: float = 40.0,
    tolerance: float = 1e-6,
    largest: int = 400,
    report: Callable[[Step], None] | None = None,
) -> Equilibrium:
    """Relax a sheet from ``start`` by at most ``largest`` of the report's steps with its constant ``c``.

    The result says what residual was reached; ``converged`` only where it is within ``tolerance``.
    """
    balance = Balance(sheet, mold, tolerance)
    d = np.zeros((sheet.n, sheet.m, 3))

    def step(now: State) -> Array:
        _steps(now.x, balance.model.net, balance.r, c, d)
        return d

    unfinished = f"the relaxation's step does not vanish: its residual floors near 1/c, c = {c:g}"
    return march(balance, start, step, largest, _EVERY, report, unfinished)
