"""What a draped sheet changes by with its law: the tangent at the answer, and one solve a number.

At the answer the forces that the mold leaves to each node are zero, r = Q f(x; p) = 0. Other constants leave Q df/dp,
and the nodes move by K dx/dp = Q df/dp with the tangent K there, each node in the subspace Q that its contact allows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array

from .answers import Answers, answers
from .balance import Balance
from .depth import Cut
from .linear import Solver, Tangent, apply, project
from .mold import Mold
from .net import Sheet
from .state import Equilibrium

#: The tangent's systems are solved so well: figures are then right to about as much.
_SOLVED, _MOST = 1e-9, 400
#: What is of second order already is found to this part: more is of the third.
_CLOSER = 1e-2
#: Slack springs keep this part of the stiffest spring's stiffness, so that their nodes have some.
_FLOOR = 1e-9


class Neighbourhood:
    """An equilibrium without friction on a ``mold``, and those beside it with the same contact."""

    def __init__(self, sheet: Sheet, mold: Mold, found: Equilibrium, deepest: Cut) -> None:
        self._mold, self._found, self._deepest = mold, found, deepest
        self._balance = Balance(sheet, mold, 1e-6)
        state = found.state.copy()
        self._balance.before = state.slot.copy()
        self._balance.forces(state)
        self._balance.settle(state)
        self._tangent = Tangent.empty(sheet.n, sheet.m, self._balance.model.directions, self._balance.q)
        self._balance.model.tangent(state.x, _FLOOR * self._balance.stiffness, self._tangent)
        self._solver = Solver(sheet.n, sheet.m, self._balance.model.directions)

    def slopes(self, up: Sheet, down: Sheet, step: float) -> tuple[Array, Answers, Answers]:
        """Return how the nodes move (n, m, 3) with a number, and what the sheets with it a ``step`` up and down answer
        with their nodes moved so far."""
        x = self._found.state.x
        pair = [(up, step, self._forces(up, x)), (down, -step, self._forces(down, x))]
        right = (pair[0][2].f - pair[1][2].f) / (2.0 * step)
        project(self._balance.q, right, 0, len(right))
        moved, pulled = np.zeros_like(right), np.zeros_like(right)
        self._solver(self._tangent, right, moved, _SOLVED, _MOST)
        everywhere = np.broadcast_to(np.array([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]), self._tangent.q.shape).copy()
        apply(replace(self._tangent, q=everywhere), moved, pulled)
        work = float((self._balance.f * moved).sum())
        found = []
        for sheet, way, forces in pair:
            there = forces
            if len(forces.model.springs):  # laid over edges: how they run there is to be found anew
                there = self._forces(sheet, x + way * moved)
            else:  # of second order off, and up as down
                there.f -= way * pulled
                there.energy -= way * work
            found.append(self._answers(sheet, there, x + way * moved))
        return moved, found[0], found[1]

    def answers(self, sheet: Sheet, moved: Array) -> tuple[Answers, Array]:
        """Return what another sheet answers with its nodes moved (n, m, 3), but for how deep it is in the mold, and how
        they are moved: the forces that this leaves, of second order, are brought to rest by the same tangent once more.
        """
        there = self._forces(sheet, self._found.state.x + moved)
        left = self._left(there)
        more = np.zeros_like(left)
        self._solver(self._tangent, left, more, _CLOSER, _MOST)
        nearer = self._forces(sheet, self._found.state.x + moved + more)
        # Springs that go slack or taut on the way are not what the tangent takes them for.
        if np.linalg.norm(self._left(nearer)) < np.linalg.norm(left):
            moved, there = moved + more, nearer
        return self._answers(sheet, there, self._found.state.x + moved), moved

    def _left(self, there: Balance) -> Array:
        """Return the forces (n, m, 3) that the contact leaves to the nodes."""
        left = there.f.copy()
        project(self._balance.q, left, 0, len(left))
        return left

    def _answers(self, sheet: Sheet, there: Balance, x: Array) -> Answers:
        there.r = self._left(there)  # next to nothing: the rest is of mold and clamps
        ended = there.ended(self._found.state.copy()._replace(x=x), "", [])
        return answers(sheet, self._mold, ended, self._deepest)

    def _forces(self, sheet: Sheet, x: Array) -> Balance:
        found = Balance(sheet, self._mold, 1e-6)
        found.model.straight = self._balance.model.straight
        found.forces(self._found.state.copy()._replace(x=x))
        return found
