"""What a draped sheet changes by with its law: the tangent at the answer, and one solve a number.

At the answer the forces that the mold leaves to each node are zero, r = Q f(x; p) = 0. Other constants leave Q df/dp,
and the nodes move by K dx/dp = Q df/dp with the tangent K there, each node in the subspace Q that its contact allows.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array

from .answers import Answers, answers
from .balance import Balance
from .cuts import Cut
from .linear import Solver, Tangent
from .mold import Mold
from .multigrid import project
from .net import Sheet
from .state import Equilibrium

#: The tangent's systems are solved so well: figures are then right to about as much.
_SOLVED, _MOST = 1e-9, 400
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

    def move(self, up: Sheet, down: Sheet, step: float) -> Array:
        """Return how the nodes move (n, m, 3) with a number, from the sheets with it a ``step`` up and down."""
        x = self._found.state.x
        right = (self._forces(up, x).f - self._forces(down, x).f) / (2.0 * step)
        project(self._balance.q, right)
        moved = np.zeros_like(right)
        self._solver(self._tangent, right, moved, _SOLVED, _MOST)
        return moved

    def answers(self, sheet: Sheet, moved: Array) -> Answers:
        """Return what another sheet answers with its nodes moved (n, m, 3), but for how deep it is in the mold."""
        x = self._found.state.x + moved
        there = self._forces(sheet, x)
        there.r = there.f.copy()
        project(self._balance.q, there.r)  # next to nothing: the rest is of mold and clamps
        ended = there.ended(self._found.state.copy()._replace(x=x), "", [])
        return answers(sheet, self._mold, ended, self._deepest)

    def _forces(self, sheet: Sheet, x: Array) -> Balance:
        found = Balance(sheet, self._mold, 1e-6)
        found.model.straight = self._balance.model.straight
        found.forces(self._found.state.copy()._replace(x=x))
        return found
