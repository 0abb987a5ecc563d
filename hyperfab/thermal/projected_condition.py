"""What happens on the faces and in the volumes of a mold, in the coordinates of a basis.

What is linear about the origin is projected to the last digit. What is left of a film or of radiation, of second order
in how far it is from there, is taken at a few points of its faces.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.condition import Condition
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.radiation import SIGMA, ZERO_CELSIUS, Radiation, fourth_power
from hyperfab.thermal.tables import Table
from hyperfab.thermal.trail import Lift


class Projected(Protocol):
    """A condition in coordinates."""

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow into each basis vector (r,) [W]."""

    def tangent(self, time: float, coordinates: Array) -> Array:
        """Return minus its derivative (r, r) [W/K]."""


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


@dataclass(frozen=True)
class Scaled:
    """A condition whose flow is ``by`` times as much."""

    condition: Projected
    by: float

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow into each basis vector (r,) [W]."""
        return self.by * self.condition.flow(time, coordinates)

    def tangent(self, time: float, coordinates: Array) -> Array:
        """Return minus its derivative (r, r) [W/K]."""
        return self.by * self.condition.tangent(time, coordinates)


def scaled(condition: Projected, by: float) -> Projected:
    """Return a condition whose flow is ``by`` times as much."""
    if isinstance(condition, _Source):
        return replace(condition, shape=by * condition.shape)
    return Scaled(condition, by)


@dataclass(frozen=True)
class Together:
    """Conditions that act at once."""

    conditions: tuple[Projected, ...]

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow into each basis vector (r,) [W]."""
        return np.asarray(sum(one.flow(time, coordinates) for one in self.conditions))

    def tangent(self, time: float, coordinates: Array) -> Array:
        """Return minus its derivative (r, r) [W/K]."""
        return np.asarray(sum(one.tangent(time, coordinates) for one in self.conditions))


class Face:
    """A film or a radiating face, linear about the origin but for what is seen at a few points."""

    def __init__(self, condition: Convection | Radiation, lift: Lift, time: float) -> None:
        self.condition = condition
        self._at = condition.ambient.at(time)
        facets = condition.facets
        basis, origin = lift.basis[facets.all_nodes], lift.origin[facets.all_nodes]
        loss, rate, cooling = _loss(condition, facets.at_points(lift.origin), self._at)
        self._flow = -(facets.own_load(loss) @ basis)
        self._matrix = basis.T @ (facets.own_matrix(rate) @ basis)
        self._air = facets.own_load(cooling) @ basis
        chosen = [] if condition.linear else (lift.alike or Alike([lift.origin])).groups(facets)
        means, weights = facets.means(chosen)
        rows, origin = means @ basis, means @ origin
        self._rows, self._weighted, self._origin = rows, rows * weights[:, None], origin
        self._base = _loss(condition, origin, self._at)

    def warmer(self, by: float) -> Face:
        """Return the face with its surroundings warmer by so much [K]."""
        found, condition = copy.copy(self), copy.copy(self.condition)
        condition.ambient = Table(condition.ambient.x, condition.ambient.y + by)
        found.condition = condition
        return found

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow into each basis vector (r,) [W]."""
        ambient = self.condition.ambient.at(time)
        found = (
            self._flow - self._matrix @ coordinates + _warmer(self.condition, self._at, ambient) * self._air
        )
        if len(self._origin):
            away = self._rows @ coordinates
            loss, rate, cooling = self._base
            now = _lost(self.condition, self._origin + away, ambient)
            linear = loss + rate * away - _warmer(self.condition, self._at, ambient) * cooling
            found -= (now - linear) @ self._weighted
        return found

    def tangent(self, time: float, coordinates: Array) -> Array:
        """Return minus its derivative (r, r) [W/K]."""
        if len(self._origin) == 0:
            return self._matrix
        at = self._origin + self._rows @ coordinates
        _, rate, _ = _loss(self.condition, at, self.condition.ambient.at(time))
        return self._matrix + self._weighted.T @ ((rate - self._base[1])[:, None] * self._rows)


def _lost(condition: Convection | Radiation, at: Array, ambient: float) -> Array:
    """Return the heat lost per area at surface temperatures."""
    if isinstance(condition, Convection):
        return np.asarray(condition.film(at) * (at - ambient))
    hot = np.maximum(at + ZERO_CELSIUS, 0.0)
    grey = condition.emissivity * SIGMA
    return np.asarray(grey * (fourth_power(hot) - fourth_power(ambient + ZERO_CELSIUS)))


def _loss(condition: Convection | Radiation, at: Array, ambient: float) -> tuple[Array, Array, Array]:
    """Return the heat lost per area at surface temperatures, its rate by them, and by the ambient's ``_warmer``."""
    if isinstance(condition, Convection):
        film = condition.film(at)
        return film * (at - ambient), film + condition.film.slope(at) * (at - ambient), film
    hot = np.maximum(at + ZERO_CELSIUS, 0.0)
    grey = condition.emissivity * SIGMA
    loss = grey * (fourth_power(hot) - fourth_power(ambient + ZERO_CELSIUS))
    return loss, 4.0 * grey * (hot * hot * hot), np.full_like(at, grey)


def _warmer(condition: Convection | Radiation, before: float, now: float) -> float:
    """Return by how much the surroundings are warmer: in kelvin to a film, in its fourth power to radiation."""
    if isinstance(condition, Convection):
        return now - before
    return fourth_power(now + ZERO_CELSIUS) - fourth_power(before + ZERO_CELSIUS)


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
