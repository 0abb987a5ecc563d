"""Dynamic relaxation: the sheet swings under its own forces and is stopped whenever its motion is at its height.

Nodes get fictitious masses by which every mode is slower than the time step; at each peak of the kinetic energy all
velocities are set to zero (kinetic damping; Barnes, Int. J. Space Structures 14, 1999). A swing that gains energy,
where springs stiffened beyond their masses, is taken back to where it began, with heavier nodes. No matrix, no line
search and no coarser grid: slow, and independent of Newton's method, whose answers it confirms.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel

from .balance import Balance
from .galerkin import times
from .linear import Tangent
from .march import march
from .mirror import even
from .mold import Mold
from .net import Sheet
from .state import Equilibrium, State, Step

#: Every so many steps a line of the history is kept.
EVERY = 100
#: Masses are this many times what keeps the fastest mode stable: springs stiffen between two peaks.
SAFETY = 1.5
#: A swing is unstable whose springs come to store more than they began with, by this share of what they gave away.
GAIN = 0.1
#: Where masses this many times heavier do not keep it, the sheet flies apart.
HEAVIEST = 1e12
#: Where a sheet on a mold that is its own mirror image is not at rest after so many time steps, it may lean to a side.
EVEN_STEPS = 6000


@kernel
def _push(r: Array, q: Array, mass: Array, v: Array) -> float:
    """v += r / mass, kept in the allowed subspaces; the kinetic energy."""
    total = 0.0
    for i in range(v.shape[0]):
        for j in range(v.shape[1]):
            w = 1.0 / mass[i, j]
            a, b, c, p = v[i, j, 0] + w * r[i, j, 0], v[i, j, 1] + w * r[i, j, 1], v[i, j, 2], q[i, j]
            c += w * r[i, j, 2]
            v[i, j, 0], v[i, j, 1], v[i, j, 2] = times(p, a, b, c)
            total += mass[i, j] * (v[i, j, 0] ** 2 + v[i, j, 1] ** 2 + v[i, j, 2] ** 2)
    return 0.5 * total


def swing(
    sheet: Sheet,
    mold: Mold,
    start: State,
    tolerance: float = 1e-6,
    largest: int = 100_000,
    report: Callable[[Step], None] | None = None,
) -> Equilibrium:
    """Let a sheet swing from ``start`` until no node feels an unbalanced force; at most ``largest`` time steps."""
    balance = Balance(sheet, mold, tolerance)
    tangent = Tangent.empty(sheet.n, sheet.m, balance.model.directions)
    v = np.zeros((sheet.n, sheet.m, 3))
    steps = 0
    last, mass, heavier = np.inf, np.zeros((0, 0)), 1.0
    began, energy, released = start.copy(), np.inf, 0.0  # of the present swing, and the most it gave away

    def begin(now: State) -> None:
        nonlocal mass, began, energy, released
        mass = heavier * _masses(balance, now, tangent)
        began, energy, released = now.copy(), balance.energy, 0.0
        v[:] = 0.0

    def take_back(now: State) -> None:
        nonlocal last, heavier, released
        released = max(released, energy - balance.energy)
        if not mass.size or balance.energy <= energy + GAIN * released + balance.rounding or heavier > HEAVIEST:
            return
        heavier *= 4.0
        now.assign(began)
        balance.forces(now)
        balance.settle(now)
        begin(now)
        last = np.inf

    def velocity(now: State) -> Array:
        nonlocal last, heavier, steps
        steps += 1
        if steps == EVEN_STEPS and balance.mirrors:
            balance.lean()
            balance.settle(now)
            begin(now)
            last = np.inf
        if not mass.size:
            begin(now)
        kinetic = _push(balance.r, balance.q, mass, v)
        if kinetic < last < np.inf:  # past the peak: begin anew from here
            heavier = max(1.0, 0.5 * heavier)
            begin(now)
            kinetic = _push(balance.r, balance.q, 2.0 * mass, v)
        last = kinetic
        even(v, balance.r, balance.q, balance.worst)
        return v

    unfinished = "no equilibrium within the allowed steps"
    return march(balance, start, velocity, largest, EVERY, report, unfinished, take_back)


def _masses(balance: Balance, now: State, tangent: Tangent) -> Array:
    """Mass of each node for a time step of 1: half the stiffness of its springs, taut or about to be (Gershgorin)."""
    balance.model.tangent(now.x, balance.stiffness / 3.0, tangent)
    # Pieces that push instead of pulling, as an angle's may, take off the trace, not off the stiffness.
    trace = tangent.diag[..., 0] + tangent.diag[..., 3] + tangent.diag[..., 5]
    return np.asarray(0.5 * SAFETY * np.abs(trace))
