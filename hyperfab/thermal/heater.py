"""Heaters: a power spread evenly over faces or over the volume of a part, by schedule, by thermostat, or constant."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.tables import Table


class Heater:
    """A heat source of unit ``shape`` (n,), nodal loads that sum to 1, times ``power`` [W] against time.

    ``on`` is switched by a thermostat; without one it stays on.
    """

    linear = True

    def __init__(self, name: str, shape: Array, power: Table) -> None:
        self.name = name
        self.shape = shape
        self.power = power
        self.on = True

    @property
    def nodes(self) -> Ints:
        """A heater couples no nodes."""
        return np.zeros((0, 1), dtype=np.int64)

    def power_at(self, time: float) -> float:
        """Return the power given off now [W]."""
        return self.power.at(time) if self.on else 0.0

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body [W]."""
        return self.power_at(time) * self.shape

    def tangent(self, time: float, temperature: Array) -> Array:
        """A heater does not feel the temperature."""
        return np.zeros((0, 1, 1))
