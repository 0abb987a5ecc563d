"""The relaxation of the report (its Algorithm 1) as it stands, for comparison.

Each node steps along its unbalanced force by the sum of its springs' elongations over a constant c, and is set back
onto the mold. That step does not vanish at equilibrium, where the elongations stay: the nodes end by trembling about
it, and the residual floors near 1/c however many steps are made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.numerics.kernels import kernel

from .contact import settle
from .energy import Energy
from .law import Floats
from .mold import Mold
from .net import Arrays, Sheet
from .newton import RELAXED, Equilibrium, State, Step, step_to, stiffness_scale

#: Every so many steps a line of the history is kept.
EVERY = 10


@kernel
def _steps(x: Floats, net: Arrays, r: Floats, c: float, d: Floats) -> None:
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
                k, l = i, j
                if side == 0:
                    k = i + 1
                elif side == 1:
                    k = i - 1
                elif side == 2:
                    l = j + 1
                else:
                    l = j - 1
                if k < 0 or l < 0 or k >= n or l >= m:
                    continue
                length = 0.0
                for a in range(3):
                    length += (x[k, l, a] - x[i, j, a]) ** 2
                total += max(np.sqrt(length) - net.rest[side // 2], 0.0)
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
    n, m = sheet.n, sheet.m
    model, fixed = Energy(sheet, mold), sheet.fixed
    now, trial = start.copy(), start.copy()
    f, r, d, q = np.zeros((n, m, 3)), np.zeros((n, m, 3)), np.zeros((n, m, 3)), np.zeros((n, m, 6))
    press, before = np.zeros((n, m)), np.full((n, m), -1)
    unstretched = RELAXED * stiffness_scale(sheet) * float(model.net.rest.max())
    history: list[Step] = []
    status = f"the relaxation's step does not vanish: its residual floors near 1/c, c = {c:g}"
    for iteration in range(largest + 1):
        energy, strongest = model.forces(now.x, now.clear, f)
        laid = (model.springs, model.ways, model.hinges())
        slack = 1e-3 * tolerance * strongest
        worst, where, contacts, changed, _ = settle(
            now.x,
            f,
            mold,
            model.net,
            *laid,
            fixed,
            slack,
            now.contact,
            now.slot,
            before,
            now.clear,
            q,
            r,
            press,
        )
        relative = worst / max(strongest, unstretched)
        done = relative <= tolerance
        if iteration % EVERY == 0 or done or iteration == largest:
            history.append(Step((n, m), iteration, energy, relative, contacts, 1.0, 0, changed > 0))
            if report:
                report(history[-1])
        if done:
            status = ""
            break
        if iteration < largest:
            _steps(now.x, model.net, r, c, d)
            before = now.slot.copy()
            step_to(now.x, d, 1.0, mold, now, trial, *laid)
            now, trial = trial, now
    return Equilibrium(
        now,
        not status,
        energy,
        worst,
        relative,
        divmod(where, m),
        press,
        f,
        r,
        strongest,
        model.springs,
        model.ways[:, 12],
        model.push,
        status,
        history,
    )
