"""Equilibrium of a sheet on a mold on one grid: Newton's method on the energy with an active contact set."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .balance import Balance
from .friction import Friction
from .linear import Solver, Tangent, dot
from .mirror import even
from .mold import Mold
from .net import Sheet
from .state import Equilibrium, State, Step

#: Steps without progress after which springs that jump over edges of the mold are taken for what keeps it away.
PATIENCE = 12
#: Where two steps in a row are cut below this share and the way of a spring jumps, that spring is left straight.
SHORT = 2.0**-6
#: Rises of the residual after which the steps of a sheet that rubs begin at half their length, at this share at least.
ROCKS, SLOWEST = 2, 2.0**-4
#: Steps allowed, and where nodes stop on sharp edges one by one.
STEPS, SHARP_STEPS = 60, 240
#: The linear systems are solved at least this well: setting them up costs more than a few inner steps.
FORCING = 5e-3


class Pace:
    """The share of Newton's step that is tried first, at most ``longest``.

    Friction goes by the normal forces of the step before. Where those answer strongly to the place, whole steps of a
    sheet that ``rubs`` rock to and fro: they are halved where the residual rises again and again, and doubled where it
    falls as they tell.
    """

    def __init__(self, longest: float, rubs: bool) -> None:
        self.share, self._longest, self._rubs, self._rises = longest, longest, rubs, 0

    def after(self, ratio: float) -> None:
        """Heed a step that took the residual to ``ratio`` of what it was."""
        self._rises += self._rubs and ratio > 1.0
        if self._rises == ROCKS:
            self.share, self._rises = max(0.5 * self.share, SLOWEST), 0
        elif self._rubs and ratio < 1.0 - 0.5 * self.share:
            self.share = min(2.0 * self.share, self._longest)


def equilibrium(
    sheet: Sheet,
    mold: Mold,
    start: State,
    tolerance: float = 1e-6,
    largest: int | None = None,
    report: Callable[[Step], None] | None = None,
    friction: Friction | None = None,
    longest: float = 1.0,
    even_shapes: bool = True,
    leaps: bool | None = None,
) -> Equilibrium:
    """Move a sheet from ``start`` to where no node feels an unbalanced force.

    At each step the contact set is decided by the forces (released where pulled outward, kept on edges by the cone of
    normals), Newton's step is found in the allowed subspace of every node, and shortened until the energy has fallen.
    Nodes that would enter the mold are set on it. Ends when the largest unbalanced nodal force is below ``tolerance``
    times the largest spring force. ``friction`` resists within one load step. ``longest``: the share of Newton's step
    that is tried first. ``even_shapes``: a net and a mold that are their own mirror image rest so. ``leaps``: behind
    a jump at a sharp edge a step is cut by a parabola, not in half, and springs that jump are left straight. By default
    membranes leap; nets, so that of several rests they come to the same when a constant changes a little, do not.
    """
    n, m = sheet.n, sheet.m
    balance = Balance(sheet, mold, tolerance, even_shapes)
    model = balance.model
    sharp = len(mold.creases.corners) > 0
    leaps = sharp and (sheet.membrane is not None if leaps is None else leaps)
    if largest is None:
        largest = SHARP_STEPS if sharp else STEPS
    now, trial = start.copy(), start.copy()
    tangent, solver = Tangent.empty(n, m, model.directions, balance.q), Solver(n, m, model.directions)
    spare, d = np.zeros((n, m, 3)), np.zeros((n, m, 3))
    balance.even(now)
    balance.forces(now)
    history: list[Step] = []
    if not np.isfinite(balance.energy):
        return balance.ended(now, "the law has no answer where the sheet begins", history)
    alpha, inner, relative_old, retried = 1.0, 0, 1.0, False
    lowest, least, idle = np.inf, np.inf, 0  # energy and residual, and steps since either fell
    pace = Pace(longest, friction is not None)
    crawls = False  # the step before was cut below SHORT
    across = 0  # steps in a row that led over an edge of the mold to no lower energy
    status = "no equilibrium within the allowed steps"
    for iteration in range(largest + 1):
        balance.settle(now, friction)
        if friction is not None:
            balance.worst, balance.where = friction.resist(now.x, now.contact, balance.press, balance.q, balance.r)
        relative = balance.residual
        history.append(balance.line(iteration, alpha, inner))
        if report:
            report(history[-1])
        if relative <= tolerance:
            status = ""
            break
        if iteration == largest:
            break
        model.tangent(now.x, balance.stiffness * min(1e-3, 0.1 * relative), tangent)
        if friction is not None:
            friction.stiffen(balance.q, tangent.diag)
        forcing = min(FORCING, max(1e-3, 0.5 * (relative / relative_old) ** 2)) if iteration else FORCING
        forcing = min(0.1, max(forcing, 0.3 * tolerance / relative))
        pace.after(relative / relative_old)
        relative_old = relative
        solver(tangent, balance.r, d, forcing)
        even(d, balance.r, balance.q, balance.worst)
        inner, slope = solver.iterations, dot(balance.r, d)
        energy = balance.energy
        alpha, laid, stops, valleys, left = pace.share, balance.laid(), False, False, False
        while True:
            balance.move(now, d, alpha, trial, laid)
            spent = 0.0 if friction is None else friction.spent(now.x, trial, balance.q)
            energy_t, strongest_t = balance.found(trial, spare)
            rounding = 1e-14 * abs(energy) + 1e-300
            if energy_t + spent <= energy - 1e-4 * alpha * slope + rounding:
                break
            if sharp and not stops:  # a way over a sharp edge may lead uphill: nodes stop on it first
                now.crossed[:], stops = 1, True
            elif alpha < SHORT and not valleys:  # nodes that step from slope to slope of a valley stop in it
                now.crossed[:], valleys, alpha = 2, True, pace.share
            elif leaps:  # by the parabola through slope and energies: behind a jump the energy rises steeply
                rise = energy_t + spent - energy
                alpha *= min(0.5, max(0.1, 0.5 * slope * alpha / (rise + slope * alpha)))
            else:
                alpha *= 0.5
            left = alpha < SHORT and leaps and crawls and model.leave(now, trial)
            if left or alpha < 1e-6:
                break
        fell = energy < lowest - 1e-9 * abs(lowest) or relative < 0.9 * least
        lowest, least, idle = min(energy, lowest), min(relative, least), 0 if fell else idle + 1
        stalled = sharp and (alpha < 1e-6 or idle > PATIENCE)
        if left or (stalled and (model.leave(now, trial) or model.leave(now, trial, balance.where))):
            lowest, least = np.inf, np.inf
            balance.forces(now)
            continue
        if alpha < 1e-6 and friction is not None and friction.blocked.any() and not retried:
            retried = True  # nodes that were let go slid backwards: they stick after all
            continue
        if alpha < 1e-6 and across < PATIENCE and (trial.slot != now.slot).any():
            across += 1  # a valley just ahead: over it the energy rises, on it the node rests
        elif alpha < 1e-6:
            status = "no step lowers the energy further"
            balance.forces(now)
            break
        else:
            across = 0
        crawls = alpha < SHORT
        if friction is not None:
            friction.blocked[:] = False
        retried = False
        balance.before = now.slot.copy()
        now, trial = trial, now
        balance.f, spare = spare, balance.f
        balance.energy, balance.strongest = energy_t, strongest_t
    return balance.ended(now, status, history)
