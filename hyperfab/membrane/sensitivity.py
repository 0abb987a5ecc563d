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

#: Differences of fourth order, at one and two steps either way: what small steps leave is rounding.
_POINTS = ((1.0, 8.0 / 12.0), (-1.0, -8.0 / 12.0), (2.0, -1.0 / 12.0), (-2.0, 1.0 / 12.0))


class Neighbourhood:
    """An equilibrium without friction, and those beside it on the same mesh.

    Raises ValueError where the contact remembers its way: its neighbours are those of another way.
    """

    def __init__(self, solved: Solved) -> None:
        if solved.press.tangential.remembers:
            raise ValueError("an equilibrium with friction hangs on how it was reached")
        self.solved = solved
        _, self._factor = solved.press.tangent(solved.state)

    def move(self, test: Change, step: float) -> Array:
        """Return how the places move (n, 3) with a number; ``test`` gives the test with the number changed."""
        press, state = self.solved.press, self.solved.state
        right, held = np.zeros_like(state.places), np.zeros_like(state.places)
        for way, weight in _POINTS:
            other, depth = test(way * step)
            beside, places = self._beside(other)
            right += weight / step * beside.imbalance(state, places, depth)
            held += weight / step * (places - state.places)
        pattern = press.sheet.pattern
        return held + pattern.extend(self._factor.solve(pattern.restrict(right)))

    def slopes(
        self,
        test: Change,
        step: float,
        moved: Array,
        figures: Callable[[Solved], Mapping[str, float | Array]],
    ) -> dict[str, float | Array]:
        """Return what ``figures`` of the equilibrium, numbers or fields (n,), change by with a number, where the places
        move as ``moved``."""
        total: dict[str, float | Array] = {}
        for way, weight in _POINTS:
            other, depth = test(way * step)
            beside, _ = self._beside(other)
            places = self.solved.state.places + way * step * moved
            found = figures(Solved(beside, beside.seen(self.solved.state, places, depth)))
            for name, value in found.items():
                total[name] = total.get(name, 0.0) + weight / step * value
        return total

    def equilibrium(self, test: SphereTest, depth: float, moved: Array) -> Solved:
        """Return the equilibrium of another test, from places ``moved`` (n, 3). Raises NoEquilibriumError."""
        state = self.solved.state
        beside, places = self._beside(test)
        free = beside.sheet.pattern.free
        found = beside.equilibrium(depth, np.where(free, state.places + moved, places), state.touching)
        return Solved(beside, found)

    def _beside(self, test: SphereTest) -> tuple[Press, Array]:
        """Return the press of another test, and the places with the rim where it is held then."""
        press, state = self.solved.press, self.solved.state
        beside = press_on(test, press.sheet.mesh)
        beside = replace(beside, tolerance=press.tolerance)
        if beside.sheet.pattern is not press.sheet.pattern:
            raise NoEquilibriumError("the clamp gives where it held, or the other way round")
        places = np.where(
            beside.sheet.pattern.free, state.places, state.places + beside.sheet.flat - press.sheet.flat
        )
        return beside, places
