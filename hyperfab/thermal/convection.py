"""Convection: heat leaves through a face as h(T) (T - T_ambient)."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.tables import Table


class Convection:
    """A film on ``facets``.

    ``film`` [W/m^2/K] is a function of the surface temperature, ``ambient`` [degC] of time.
    """

    def __init__(self, name: str, facets: FacetOperator, film: Table, ambient: Table) -> None:
        self.name = name
        self.facets = facets
        self.film = film
        self.ambient = ambient

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
