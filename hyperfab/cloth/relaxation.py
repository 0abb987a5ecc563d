"""The relaxation of the report (its Algorithm 1) as it stands, for comparison.

Each node steps along its unbalanced force by the sum of its springs' elongations over a constant c, and is set back
onto the mold. That step does not vanish at equilibrium, where the elongations stay: the nodes end by trembling about
it, and the residual floors near 1/c however many steps are made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel

from .balance import Balance
from .features import distance2
from .march import march
from .mold import Mold
from .net import Arrays, Sheet, neighbour
from .state import Equilibrium, State, Step

#: Every so many steps a line of the history is kept.
EVERY = 10


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
    return march(balance, start, step, largest, EVERY, report, unfinished)
