"""A condition that acts for a while: a film on a face that is bare, a piece that lies on it."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.condition import Condition


class Switched:
    """``condition`` while it is ``on``; whoever turns it tells the model that its matrices have changed."""

    def __init__(self, condition: Condition, *, on: bool) -> None:
        self.condition = condition
        self.name = condition.name
        self.on = on

    @property
    def nodes(self) -> Ints:
        """Return the condition's node groups, on or off: the pattern of the matrices stays."""
        return self.condition.nodes

    @property
    def linear(self) -> bool:
        """Whether the condition is linear between its turns."""
        return self.condition.linear

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body [W], none while it is off."""
        return self.condition.flow(time, temperature) if self.on else np.zeros(len(temperature))

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return minus the derivative of the flow [W/K]."""
        found = self.condition.tangent(time, temperature)
        return found if self.on else np.zeros_like(found)
