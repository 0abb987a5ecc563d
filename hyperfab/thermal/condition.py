"""What conditions are to the rest: heat flows into the body, and how they change with temperature.

Heaters, convection, radiation and contact; conditions that act for a while, a film on a face that is bare, a piece
that lies on it; nodes held at a temperature; and parts that are taken out and replaced by fresh ones, the cold
sandwich of each press cycle.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.tables import Table


class Condition(Protocol):
    """Heat that enters the body through a face, a volume or a joint.

    ``name`` says which in messages and in the energy balance. ``nodes`` (m, k) are the groups of nodes it couples
    (facets, or both sides of a joint).
    """

    name: str

    @property
    def nodes(self) -> Ints:
        """Return the node groups (m, k) coupled by the condition."""

    @property
    def linear(self) -> bool:
        """Whether the flow is linear in temperature, with a slope that never changes."""

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body (n,) [W] at nodal temperatures (n,) [degC]."""

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return minus the derivative of the flow by temperature, one matrix a group (m, k, k) [W/K]."""


@dataclass(eq=False)
class Convection:
    """A film on ``facets``: heat leaves as h(T) (T - T_ambient).

    ``film`` [W/m^2/K] is a function of the surface temperature, ``ambient`` [degC] of time.
    """

    name: str
    facets: FacetOperator
    film: Table
    ambient: Table

    @property
    def nodes(self) -> Ints:
        """Return the facets' nodes."""
        return self.facets.nodes

    @property
    def linear(self) -> bool:
        """Whether the film coefficient is constant."""
        return self.film.is_constant

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body [W]."""
        # The difference is taken at the nodes: at ambient temperature the flow is zero to the last digit.
        ambient = self.ambient.at(time)
        away = self.facets.at_points(temperature - ambient)
        return self.facets.load(-self.film(ambient + away) * away)

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return minus the derivative of the flow; a film that falls steeply counts as insulated, never negative."""
        at = self.facets.at_points(temperature)
        return self.facets.matrices(np.maximum(self.rates(at, self.ambient.at(time))[0], 0.0))

    def lost(self, at: Array, ambient: float) -> Array:
        """Return the heat lost per area [W/m^2] at surface temperatures ``at`` [degC]."""
        return np.asarray(self.film(at) * (at - ambient))

    def rates(self, at: Array, ambient: float) -> tuple[Array, Array]:
        """Return its derivative by the surface's temperature, and minus that by the ambient's ``level``."""
        film = self.film(at)
        return film + self.film.slope(at) * (at - ambient), film

    def level(self, ambient: float) -> float:
        """Return what of the surroundings the loss is straight in: their temperature."""
        return ambient


#: Stefan-Boltzmann constant [W/m^2/K^4] (CODATA 2018, exact).
SIGMA = 5.670374419e-8
#: 0 degC [K].
ZERO_CELSIUS = 273.15

T = TypeVar("T", float, Array)


def fourth_power(kelvin: T) -> T:
    """Return T^4, ten times as fast as NumPy's power.

    >>> fourth_power(2.0)
    16.0
    """
    square = kelvin * kelvin
    return square * square


@dataclass(eq=False)
class Radiation:
    """A grey face to large surroundings: heat leaves as emissivity sigma (T^4 - T_ambient^4).

    ``emissivity`` 0 to 1, ``ambient`` [degC] against time.
    """

    name: str
    facets: FacetOperator
    emissivity: float
    ambient: Table

    @property
    def nodes(self) -> Ints:
        """Return the facets' nodes."""
        return self.facets.nodes

    @property
    def linear(self) -> bool:
        """Whether it radiates nothing."""
        return self.emissivity == 0.0

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body [W]."""
        return self.facets.load(-self.lost(self.facets.at_points(temperature), self.ambient.at(time)))

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return minus the derivative of the flow, 4 emissivity sigma T^3."""
        return self.facets.matrices(self.rates(self.facets.at_points(temperature), self.ambient.at(time))[0])

    def lost(self, at: Array, ambient: float) -> Array:
        """Return the heat lost per area [W/m^2] at surface temperatures ``at`` [degC]."""
        hot = np.maximum(at + ZERO_CELSIUS, 0.0)
        return np.asarray(self.emissivity * SIGMA * (fourth_power(hot) - self.level(ambient)))

    def rates(self, at: Array, ambient: float) -> tuple[Array, Array]:
        """Return its derivative by the surface's temperature, and minus that by the ambient's ``level``."""
        hot, grey = np.maximum(at + ZERO_CELSIUS, 0.0), self.emissivity * SIGMA
        return 4.0 * grey * (hot * hot * hot), np.full_like(at, grey)

    def level(self, ambient: float) -> float:
        """Return what of the surroundings the loss is straight in: the fourth power of their temperature [K]."""
        return fourth_power(ambient + ZERO_CELSIUS)


@dataclass(eq=False)
class Contact:
    """A joint, where the temperature jumps: ``near`` and ``far`` are its two sides, node by node opposite each other.

    ``conductance`` [W/m^2/K]; ``closed`` against time scales it (1 closed, 0 open): a press that opens.
    """

    name: str
    near: FacetOperator
    far: FacetOperator
    conductance: float
    closed: Table

    def __post_init__(self) -> None:
        self.linear = self.closed.is_constant
        unit = self.near.matrices(np.ones_like(self.near.weights))
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


@dataclass(eq=False)
class Switched:
    """``condition`` while it is ``on``; whoever turns it tells the model that its matrices have changed."""

    condition: Condition
    on: bool = field(kw_only=True)

    def __post_init__(self) -> None:
        self.name = self.condition.name

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


@dataclass(frozen=True)
class Prescribed:
    """Nodes (k,) held at ``value`` [degC] against time."""

    name: str
    nodes: Ints
    value: Table

    def apply(self, time: float, temperature: Array) -> None:
        """Set the held nodes of ``temperature`` in place."""
        temperature[self.nodes] = self.value.at(time)
