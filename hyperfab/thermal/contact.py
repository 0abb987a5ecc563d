"""Thermal contact conductance: the temperature jumps where two parts touch; the flow is h (T_far - T_near)."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.tables import Table


class Contact:
    """A joint: ``near`` and ``far`` are its two sides, node by node opposite each other.

    ``conductance`` [W/m^2/K]; ``closed`` against time scales it (1 closed, 0 open): a press that opens.
    """

    def __init__(self, name: str, near: FacetOperator, far: FacetOperator, conductance: float, closed: Table) -> None:
        self.name = name
        self.near = near
        self.far = far
        self.conductance = conductance
        self.closed = closed
        self.linear = closed.is_constant
        unit = near.matrices(np.ones_like(near.weights))
        upper = np.concatenate([unit, -unit], axis=2)
        self._unit = np.concatenate([upper, -upper], axis=1)

    @property
    def nodes(self) -> Ints:
        """Return near and far nodes of each facet (f, 12)."""
        return np.concatenate([self.near.nodes, self.far.nodes], axis=1)

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow [W]; what one side gains the other loses."""
        h = self.conductance * self.closed.at(time)
        across = h * (self.far.at_points(temperature) - self.near.at_points(temperature))
        return self.near.load(across) - self.far.load(across)

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return the joint matrices (f, 12, 12)."""
        return self.conductance * self.closed.at(time) * self._unit
