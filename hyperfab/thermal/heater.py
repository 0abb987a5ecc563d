"""Heaters: a power spread evenly over faces or over the volume of a part, by schedule, by thermostat, or constant.

A thermostat switches a heater by the temperature of a probe: off at set + band/2, on at set - band/2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.tables import Table


@dataclass(eq=False)
class Heater:
    """A heat source of unit ``shape`` (n,), nodal loads that sum to 1, times ``power`` [W] against time.

    ``on`` is switched by a thermostat; without one it stays on.
    """

    name: str
    shape: Array
    power: Table
    on: bool = True
    linear: ClassVar[bool] = True

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


@dataclass(frozen=True)
class Thermostat:
    """``sensor`` (n,) weighs nodal temperatures into the probe's; ``set_point`` [degC], ``band`` [K]."""

    heater: Heater
    sensor: Array
    set_point: float
    band: float

    @property
    def threshold(self) -> float:
        """The temperature at which it switches next."""
        return self.set_point + (0.5 if self.heater.on else -0.5) * self.band

    def excess(self, temperature: Array) -> float:
        """Return how far the probe is past the switching temperature: >= 0 means switch [K]."""
        beyond = dot(self.sensor, temperature) - self.threshold
        return beyond if self.heater.on else -beyond

    def switch(self) -> None:
        """Turn the heater off or on."""
        self.heater.on = not self.heater.on
