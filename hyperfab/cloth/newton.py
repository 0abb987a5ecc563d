"""Equilibrium of a sheet on a mold on one grid: Newton's method on the energy with an active contact set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .contact import move, settle
from .energy import ROWS, Energy
from .friction import Friction
from .law import Floats
from .linear import Solver, Tangent, dot
from .mold import FREE, Ints, Mold, States
from .net import FIXED, Sheet

#: Springs whose forces stay below their section's stiffness times this are unstretched but for rounding.
RELAXED = 1e-8
#: Steps after which springs around corners of the mold are taken for what keeps the equilibrium away.
PATIENCE = 25
#: The linear systems are solved at least this well: setting them up costs more than a few inner steps.
FORCING = 5e-3


@dataclass
class State:
    """Where the nodes are, and how each stands to the mold."""

    x: Floats  # (n, m, 3) mm
    contact: States  # (n, m) FREE, or 1 + feature
    slot: Ints  # (n, m) facet on or near
    clear: Floats  # (n, m) mm, free of the mold at least this far
    crossed: States  # (n, m) 1: its last step led over a sharp edge

    def copy(self) -> State:
        """Arrays of its own."""
        return State(
            self.x.copy(), self.contact.copy(), self.slot.copy(), self.clear.copy(), self.crossed.copy()
        )


@dataclass(frozen=True)
class Step:
    """One line of the energy history."""

    nodes: tuple[int, int]
    iteration: int
    energy: float  # N mm
    residual: float  # relative
    contacts: int
    step_length: float
    inner: int  # conjugate gradient steps
    set_changed: bool


@dataclass
class Equilibrium:
    """What a solve ended with."""

    state: State
    converged: bool
    energy: float  # N mm
    residual_max: float  # N
    residual_relative: float
    worst: tuple[int, int]
    press: Floats  # (n, m) N
    force: Floats  # (n, m, 3) N spring forces and weight
    residual: Floats  # (n, m, 3) N
    largest_force: float
    bent: Ints  # (k, 4) springs laid over sharp edges: node, direction, crease
    bent_length: Floats  # (k,) mm
    push: Floats  # (3,) N, of the sharp edges on the springs laid over them
    status: str = ""
    history: list[Step] = field(default_factory=list)


def step_to(
    x: Floats,
    d: Floats,
    alpha: float,
    mold: Mold,
    state: State,
    out: State,
    bent: Ints,
    ways: Floats,
    hinges: Ints,
) -> None:
    """``out`` = nodes at ``x + alpha d``, back on the mold where they touch it."""
    rows = max(1, ROWS // x.shape[1])
    for i in range(0, x.shape[0], rows):
        move(
            x,
            d,
            alpha,
            mold,
            state.contact,
            state.slot,
            state.clear,
            out.x,
            out.contact,
            out.slot,
            out.clear,
            state.crossed,
            out.crossed,
            bent,
            ways,
            hinges,
            i,
            min(i + rows, x.shape[0]),
        )


def equilibrium(
    sheet: Sheet,
    mold: Mold,
    start: State,
    tolerance: float = 1e-6,
    largest: int = 60,
    report: Callable[[Step], None] | None = None,
    friction: Friction | None = None,
) -> Equilibrium:
    """Move a sheet from ``start`` to where no node feels an unbalanced force.

    At each step the contact set is decided by the forces (released where pulled outward, kept on edges by the cone of
    normals), Newton's step is found in the allowed subspace of every node, and shortened until the energy has fallen.
    Nodes that would enter the mold are set on it. Ends when the largest unbalanced nodal force is below ``tolerance``
    times the largest spring force. ``friction`` resists within one load step.
    """
    n, m = sheet.n, sheet.m
    model, fixed = Energy(sheet, mold), sheet.fixed
    net = model.net
    now, trial = start.copy(), start.copy()
    tangent, solver = Tangent.empty(n, m, net.sheared), Solver(n, m, net.sheared)
    f, ft = np.zeros((n, m, 3)), np.zeros((n, m, 3))
    r, d, press = np.zeros((n, m, 3)), np.zeros((n, m, 3)), np.zeros((n, m))
    before = np.full((n, m), -1)
    reference = stiffness_scale(sheet)
    unstretched = RELAXED * reference * float(net.rest.max())
    energy, strongest = model.forces(now.x, now.clear, f)
    history: list[Step] = []
    alpha, inner, relative_old, retried = 1.0, 0, 1.0, False
    status = "no equilibrium within the allowed steps"
    for iteration in range(largest + 1):
        changed = 0
        while True:
            slack = 1e-3 * tolerance * strongest
            worst, where, contacts, let_go, moved = settle(
                now.x,
                f,
                mold,
                net,
                model.springs,
                model.ways,
                model.hinges(),
                fixed,
                slack,
                now.contact,
                now.slot,
                before,
                now.clear,
                tangent.q,
                r,
                press,
            )
            changed += let_go
            if not moved:
                break
            energy, strongest = model.forces(now.x, now.clear, f)
        if friction is not None:
            worst, where = friction.resist(now.x, now.contact, press, tangent.q, r)
        relative = worst / max(strongest, unstretched)
        history.append(Step((n, m), iteration, energy, relative, contacts, alpha, inner, changed > 0))
        if report:
            report(history[-1])
        if relative <= tolerance:
            status = ""
            break
        if iteration == largest:
            break
        floor = reference * min(1e-3, 0.1 * relative)
        model.tangent(now.x, floor, tangent)
        if friction is not None:
            friction.stiffen(tangent.q, tangent.extra)
        forcing = min(FORCING, max(1e-3, 0.5 * (relative / relative_old) ** 2)) if iteration else FORCING
        forcing = min(0.1, max(forcing, 0.3 * tolerance / relative))
        relative_old = relative
        solver(tangent, r, d, forcing)
        inner = solver.iterations
        slope = dot(r, d)
        alpha, bent, ways, hinges = 1.0, model.springs, model.ways, model.hinges()
        while True:
            step_to(now.x, d, alpha, mold, now, trial, bent, ways, hinges)
            spent = 0.0
            if friction is not None:
                friction.catch(trial.x, trial.contact, trial.slot, trial.clear)
                spent = friction.cost(now.x, trial.x, tangent.q)
            energy_t, strongest_t = model.forces(trial.x, trial.clear, ft)
            rounding = 1e-14 * abs(energy) + 1e-300
            if energy_t + spent <= energy - 1e-4 * alpha * slope + rounding:
                break
            alpha *= 0.5
            if alpha < 1e-6:
                break
        if (alpha < 1e-6 or iteration == PATIENCE) and model.leave_corners(now.x):
            energy, strongest = model.forces(now.x, now.clear, f)
            continue
        if alpha < 1e-6 and friction is not None and friction.blocked.any() and not retried:
            retried = True  # nodes that were let go slid backwards: they stick after all
            continue
        if alpha < 1e-6:
            status = "no step lowers the energy further"
            break
        if friction is not None:
            friction.blocked[:] = False
        retried = False
        before, old = now.slot, now
        now, trial = trial, old
        before = before.copy()
        f, ft = ft, f
        energy, strongest = energy_t, strongest_t
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


def stiffness_scale(sheet: Sheet) -> float:
    """Stiffness of the stiffest spring at rest, N/mm."""
    net = sheet.arrays
    warp, weft = sheet.warp(1.0 + 1e-9)[2][0], sheet.weft(1.0 + 1e-9)[2][0]
    return float(max(warp * net.warp_area.max() / net.rest[0], weft * net.weft_area.max() / net.rest[1]))


__all__ = ["FIXED", "FREE", "Equilibrium", "State", "Step", "equilibrium", "step_to"]
