"""Conditions that act for a while, a film on a face that is bare, a piece that lies on it; and parts that are taken out
and replaced by fresh ones, the cold sandwich of each press cycle."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True)
class Renewal:
    """At each of ``times`` [s] the nodes (k,), which no other part shares, are set to ``temperature`` [degC].

    The heat that the old piece carries out, less what the new one brings, counts as lost. Then the conditions ``on``
    begin and those of ``off`` end.
    """

    name: str
    nodes: Ints
    temperature: float
    times: tuple[float, ...]
    on: tuple[Switched, ...] = ()
    off: tuple[Switched, ...] = ()

    def apply(self, temperature: Array) -> None:
        """Put in the fresh part: set the nodal temperatures in place."""
        temperature[self.nodes] = self.temperature
        for condition in (*self.on, *self.off):
            condition.on = condition in self.on
