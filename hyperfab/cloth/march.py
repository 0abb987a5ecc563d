"""Solve without a tangent: a sheet steps along its unbalanced forces until none is left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.arrays import Array

from .balance import Balance
from .state import Equilibrium, State, Step

#: Finds the step (n, m, 3) of all nodes at a place whose forces and contact are known.
Direction = Callable[[State], Array]

#: All springs at this stretch store more than any sheet on its way to rest.
APART = 100.0


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
