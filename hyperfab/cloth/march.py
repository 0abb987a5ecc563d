"""Solve without a tangent: a sheet steps along its unbalanced forces until none is left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .balance import Balance
from .law import Floats
from .state import Equilibrium, State, Step

#: Finds the step (n, m, 3) of all nodes at a place whose forces and contact are known.
Direction = Callable[[State], Floats]


def march(
    balance: Balance,
    start: State,
    direction: Direction,
    largest: int,
    every: int,
    report: Callable[[Step], None] | None,
    unfinished: str,
) -> Equilibrium:
    """Make at most ``largest`` steps from ``start``, a line of history ``every`` so many.

    ``unfinished`` is the status where an unbalanced force is left above the balance's tolerance.
    """
    now, trial = start.copy(), start.copy()
    history: list[Step] = []
    for iteration in range(largest + 1):
        balance.forces(now)
        balance.settle(now)
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
