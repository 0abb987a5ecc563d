"""A thermostat switches a heater by the temperature of a probe: off at set + band/2, on at set - band/2."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.arrays import Array
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.heater import Heater


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
