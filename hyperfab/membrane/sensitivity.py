"""What an equilibrium of the sphere test changes by when something of the test does: direct sensitivities.

At an equilibrium the unbalanced force R(x; p) is zero. With another number p in the test it is not, and the places move
by dx/dp = -K^-1 dR/dp with the stiffness K that is there: one back-solve a number, and no second equilibrium. Figures
follow by the chain rule, taken at places and numbers moved together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.membrane.equilibrium import NoEquilibriumError, Press
from hyperfab.membrane.sphere_contact import Solved, SphereTest, press_on

#: The test, and how deep it goes [mm], with a number of it changed by so much.
Change = Callable[[float], tuple[SphereTest, float]]

#: Neighbours are found to this, unbalanced over the punch's force: far below what numbers change forces by.
_FOUND = 1e-7


class Neighbourhood:
    """An equilibrium without friction, and those beside it on the same mesh.

    Raises ValueError where the contact remembers its way: its neighbours are those of another way.
    """

    def __init__(self, solved: Solved) -> None:
        if solved.press.tangential.remembers:
            raise ValueError("an equilibrium with friction hangs on how it was reached")
        self.solved = solved
        self._tangent = solved.press.tangent(solved.state)

    def slopes(
        self, test: Change, step: float, figures: Callable[[Solved], Mapping[str, float | Array]]
    ) -> tuple[Array, dict[str, float | Array]]:
        """Return how the places move (n, 3) with a number of the test, and what ``figures`` of the equilibrium's
        places, force and energy, numbers or fields (n,), change by with it.

        ``test`` gives the test with the number changed; differences are central, ``step`` either way: exact for the
        balance where the number is a constant that is a stress, which enters it as a factor.
        """
        press, state, tangent = self.solved.press, self.solved.state, self._tangent
        copies, rim = press.sheet.mesh.copies, press.sheet.mesh.rim
        right, held = np.zeros_like(state.places), np.zeros_like(state.places)
        energy = force = 0.0
        pair = []
        for way in (-step, step):
            other, depth = test(way)
            beside, places = self._beside(other)
            unbalanced, sheet = beside.imbalance(state, places, depth, tangent.hold)
            share = 0.5 / way
            right += share * unbalanced
            held += share * (places - state.places)
            energy += share * copies * sheet.energy
            force -= share * copies * float(sheet.force[rim, 2].sum())
            pair.append((way, beside, depth))
        pattern = press.sheet.pattern
        solved = pattern.extend(tangent.factor.solve(pattern.restrict(right)))
        moved = held + solved
        energy += copies * float((tangent.force * solved).sum())
        # In balance the punch pushes as the rim pulls.
        force -= copies * float((tangent.lift * solved).sum())
        total: dict[str, float | Array] = {}
        for way, beside, depth in pair:
            seen = replace(
                state,
                depth=depth,
                places=state.places + way * moved,
                energy=state.energy + way * energy,
                force=state.force + way * force,
            )
            for name, value in figures(Solved(beside, seen)).items():
                total[name] = total.get(name, 0.0) + 0.5 / way * value
        return moved, total

    def equilibrium(self, test: SphereTest, depth: float, moved: Array) -> Solved:
        """Return the equilibrium of another test, from places ``moved`` (n, 3). Raises NoEquilibriumError."""
        press, state = self.solved.press, self.solved.state
        beside, places = self._beside(test)
        free = beside.sheet.pattern.free
        beside = replace(beside, tolerance=max(press.tolerance, _FOUND))
        found = beside.equilibrium(depth, np.where(free, state.places + moved, places), state.touching)
        return Solved(beside, found)

    def _beside(self, test: SphereTest) -> tuple[Press, Array]:
        """Return the press of another test, and the places with the rim where it is held then."""
        press, state = self.solved.press, self.solved.state
        beside = press_on(test, press.sheet.mesh)
        if beside.sheet.pattern is not press.sheet.pattern:
            raise NoEquilibriumError("the clamp gives where it held, or the other way round")
        places = np.where(beside.sheet.pattern.free, state.places, state.places + beside.sheet.flat - press.sheet.flat)
        return beside, places
