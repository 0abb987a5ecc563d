"""What happens on the faces and in the volumes of a mold, in the coordinates of a basis.

What is linear about the origin is projected to the last digit. What is left of a film or of radiation, of second order
in how far it is from there, is taken at a few points of its faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.condition import Condition
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.radiation import Radiation
from hyperfab.thermal.trail import Lift


@dataclass(frozen=True)
class _Source:
    """A heater; the full model's own is asked whether it is on."""

    heater: Heater
    shape: Array

    def flow(self, time: float, coordinates: Array) -> Array:
        return self.heater.power_at(time) * self.shape

    def tangent(self, time: float, coordinates: Array) -> Array:
        return np.zeros((len(self.shape), len(self.shape)))


@dataclass(frozen=True)
class _Joint:
    """A contact: its jump at the origin and its matrix, closed."""

    contact: Contact
    jump: Array
    matrix: Array

    def flow(self, time: float, coordinates: Array) -> Array:
        return -self.contact.closed.at(time) * (self.jump + self.matrix @ coordinates)

    def tangent(self, time: float, coordinates: Array) -> Array:
        return self.contact.closed.at(time) * self.matrix


class Face:
    """A film or a radiating face, linear about the origin but for what is seen at a few points."""

    def __init__(self, condition: Convection | Radiation, lift: Lift, time: float) -> None:
        self.condition = condition
        self._at = condition.ambient.at(time)
        facets = condition.facets
        basis, origin = lift.basis[facets.all_nodes], lift.origin[facets.all_nodes]
        there = facets.at_points(lift.origin)
        loss, (rate, cooling) = condition.lost(there, self._at), condition.rates(there, self._at)
        self._flow = -(facets.own_load(loss) @ basis)
        self._matrix = basis.T @ (facets.own_matrix(rate) @ basis)
        self._air = facets.own_load(cooling) @ basis
        chosen = [] if condition.linear else (lift.alike or Alike([lift.origin])).groups(facets)
        means, weights = facets.means(chosen)
        rows, origin = means @ basis, means @ origin
        self._rows, self._weighted, self._origin = rows, rows * weights[:, None], origin
        self._base = condition.lost(origin, self._at), *condition.rates(origin, self._at)

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow into each basis vector (r,) [W]."""
        ambient = self.condition.ambient.at(time)
        warmer = self.condition.level(ambient) - self.condition.level(self._at)
        found = self._flow - self._matrix @ coordinates + warmer * self._air
        if len(self._origin):
            away = self._rows @ coordinates
            loss, rate, cooling = self._base
            now = self.condition.lost(self._origin + away, ambient)
            found -= (now - (loss + rate * away - warmer * cooling)) @ self._weighted
        return found

    def tangent(self, time: float, coordinates: Array) -> Array:
        """Return minus its derivative (r, r) [W/K]."""
        if len(self._origin) == 0:
            return self._matrix
        at = self._origin + self._rows @ coordinates
        rate, _ = self.condition.rates(at, self.condition.ambient.at(time))
        return self._matrix + self._weighted.T @ ((rate - self._base[1])[:, None] * self._rows)


#: A condition in coordinates.
Projected = _Source | _Joint | Face


def project(condition: Condition, lift: Lift, time: float) -> Projected | None:
    """Return a condition in coordinates; None for a kind that has none."""
    if isinstance(condition, Heater):
        return _Source(condition, condition.shape @ lift.basis)
    if isinstance(condition, Contact):
        near, far = condition.near, condition.far
        rows = near.at_points_of(lift.basis) - far.at_points_of(lift.basis)
        weighted = rows * (condition.conductance * near.weights.ravel())[:, None]
        jump = (near.at_points(lift.origin) - far.at_points(lift.origin)).ravel()
        return _Joint(condition, jump @ weighted, weighted.T @ rows)
    if isinstance(condition, Convection | Radiation):
        return Face(condition, lift, time)
    return None
