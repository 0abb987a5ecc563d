"""The heated mold on a basis: the same equations, sought in the basis' span and tested with it (Galerkin).

Temperatures are an origin, a state that the mold has been in, and r coordinates times basis vectors. A uniform
temperature is in the span, so that the account of heat closes as it does in the full model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg, sparse

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.thermal.condition import Condition, Contact, Convection, Heater, Prescribed, Radiation
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.medium import Medium
from hyperfab.thermal.model import HeatModel
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


#: Newton's method ends where a step moves the mean square by less [K].
STILL = 1e-9
NEWTON_STEPS = 30
#: What conditions conduct serves from step to step as long as each iteration leaves less than this part of the way.
SLOW = 0.05
#: Vectors that are multiplied at a time.
BLOCK = 32


def why_not(model: HeatModel) -> str | None:
    """Return what of a mold has no projection, in words; None where all has."""
    if model.prescribed:
        return "temperatures are held"
    if not model.medium.linear:
        return "constants change with temperature"
    for condition in model.conditions:
        if not isinstance(condition, Heater | Contact | Convection | Radiation):
            return f"{condition.name} is no heater, film, radiation or contact"
    return None


@dataclass(frozen=True)
class ProjectedMedium:
    """What stores and conducts, in coordinates: capacity (r, r), what it weighs each vector with (r,) and its sum
    [J/K], what is stored at the origin (r,) [J]; conduction (r, r) [W/K], and what the origin conducts (r,) [W]."""

    mass: Array
    weights: Array
    capacity: float
    stored: Array
    conduction: Array
    conducted: Array

    @staticmethod
    def of(medium: Medium, lift: Lift, narrow: ProjectedMedium | None = None) -> ProjectedMedium:
        """Return a medium without tables in coordinates; ``narrow`` is the same on the first vectors of the basis."""
        basis, origin, pattern = lift.basis, lift.origin, medium.pattern
        known = 0 if narrow is None else len(narrow.mass)
        capacity = pattern.matrix(medium.capacity(origin))
        conduction = pattern.matrix(medium.conduction(origin))
        level = 0.5 * (float(origin.min()) + float(origin.max()))
        (weights, mass), (_, conducting) = (by_vector(basis, one, known) for one in (capacity, conduction))
        if narrow is not None:
            mass, conducting = _bordered(narrow.mass, mass), _bordered(narrow.conduction, conducting)
            weights = np.concatenate([narrow.weights, weights])
        return ProjectedMedium(
            mass,
            weights,
            float(capacity.sum()),
            medium.stored(origin) @ basis,
            conducting,
            (conduction @ (origin - level)) @ basis,
        )

    @cached_property
    def uniform(self) -> Array:
        """The uniform field of one kelvin (r,), in coordinates."""
        return np.asarray(np.linalg.solve(self.mass, self.weights))


def by_vector(basis: Array, matrix: sparse.csr_matrix, first: int) -> tuple[Array, Array]:
    """Return the sums (k,) of a matrix times the vectors of a basis (n, r) from ``first`` on, and basis.T times it."""
    last = max(basis.shape[1], first + 1)  # where there are no more, a block of none
    columns = range(first, last, BLOCK)
    products = (matrix @ np.ascontiguousarray(basis[:, at : at + BLOCK]) for at in columns)
    found = [(one.sum(axis=0), basis.T @ one) for one in products]
    return np.concatenate([sums for sums, _ in found]), np.hstack([rows for _, rows in found])


def _bordered(known: Array, new: Array) -> Array:
    """Return the symmetric matrix whose first rows and columns are ``known``, and last columns ``new``."""
    size = len(known)
    return np.block([[known, new[:size]], [new[:size].T, new[size:]]])


class ProjectedModel:
    """``model`` on the basis of ``lift``, linear about its origin at ``time``; asked as the full model is.

    ``narrow`` is the model on the first vectors of that basis, about any origin.
    """

    prescribed: Sequence[Prescribed] = ()

    def __init__(self, model: HeatModel, lift: Lift, time: float, narrow: ProjectedModel | None = None) -> None:
        self.lift = lift
        self.full = model
        basis, origin = lift.basis, lift.origin
        found = [project(condition, lift, time) for condition in model.conditions]
        self.conditions: list[Projected] = [condition for condition in found if condition is not None]
        self.medium: ProjectedMedium = ProjectedMedium.of(model.medium, lift, None if narrow is None else narrow.medium)
        self.free = np.ones(len(self.mass), dtype=bool)
        self.last_matrix: tuple[Array, Array] | None = None
        self._factorised_for = (0.0, 0.0)
        self._tangent: Array | None = None
        capacity = model.pattern.matrix(model.medium.capacity(origin))
        shapes = [heater.shape / model.lumped_capacity for heater in model.heaters]
        self._shapes = np.array([heater.shape @ basis for heater in model.heaters]).reshape(-1, len(self.mass))
        self._speeds = np.array([[float(one @ (capacity @ other)) for other in shapes] for one in shapes]).reshape(
            len(shapes), len(shapes)
        )

    @property
    def mass(self) -> Array:
        """Heat capacity (r, r) [J/K]."""
        return self.medium.mass

    def stored(self, coordinates: Array) -> Array:
        """Return the heat stored, by basis vector [J]."""
        return self.medium.stored + self.mass @ coordinates

    def total(self, by_vector: Array) -> float:
        """Return the heat, or the flow, of the whole mold."""
        return float(self.medium.uniform @ by_vector)

    def moved(self, stored: Array) -> float:
        """What moves inside is not counted: the account is then held against less."""
        return 0.0

    def flow(self, time: float, coordinates: Array) -> Array:
        """Return the heat flow to each basis vector [W]."""
        found = -(self.medium.conducted + self.medium.conduction @ coordinates)
        for condition in self.conditions:
            found = found + condition.flow(time, coordinates)
        return found

    def hold(self, time: float, coordinates: Array) -> Array:
        """Nothing is held."""
        return coordinates

    def changed(self) -> None:
        """No condition that this mold has is switched but heaters, which are in no matrix."""

    def solve_stage(
        self,
        time: float,
        interval: float,
        target: Array,
        guess: Array,
        storage: float = 1.0,
        reference: float | None = None,
    ) -> tuple[Array, float]:
        """Solve storage E - interval f(time) = target as ``HeatModel.solve_stage`` does."""
        found, before = guess.copy(), np.inf
        if self._factorised_for != (interval, storage):
            self.last_matrix = None
        for _ in range(NEWTON_STEPS):
            residual = target + interval * self.flow(time, found) - storage * self.stored(found)
            if self.last_matrix is None:
                self.last_matrix = self._factor(time, interval, found, storage)
                self._factorised_for = interval, storage
            change = self.solve(self.last_matrix, residual, 0.0)
            found += change
            moved = self.capacity_norm(change)
            if not np.isfinite(moved):
                break
            if moved <= STILL:
                return found, moved
            if moved > SLOW * before:
                self.last_matrix = self._tangent = None
            before = moved
        raise NotConverged(f"the reduced mold at {time:.6g} s did not settle", remedy="set reduced = false")

    def _factor(self, time: float, interval: float, coordinates: Array, storage: float) -> tuple[Array, Array]:
        if self._tangent is None:
            self._tangent = np.asarray(sum(one.tangent(time, coordinates) for one in self.conditions))
        matrix = storage * self.mass + interval * (self.medium.conduction + self._tangent)
        return linalg.lu_factor(matrix, check_finite=False)

    def solve(self, matrix: tuple[Array, Array], right: Array, tolerance: float) -> Array:
        """Solve with the step's factorised matrix."""
        return np.asarray(linalg.lu_solve(matrix, right, check_finite=False))

    def capacity_norm(self, coordinates: Array) -> float:
        """Return the root of the mean square of a field, weighted with the heat capacity [K]."""
        return float(np.sqrt(max(float(coordinates @ self.mass @ coordinates), 0.0) / self.medium.capacity))

    def speed(self, rate: Array) -> float:
        """Return what ``HeatModel.speed`` says of a change of the flow [K/s]; heaters by their own, sharper shapes."""
        powers = np.linalg.lstsq(self._shapes.T, rate, rcond=None)[0]
        rest = np.linalg.solve(self.mass, rate - powers @ self._shapes)
        heaters = float(powers @ self._speeds @ powers) / self.medium.capacity
        return float(np.sqrt(max(heaters, 0.0) + self.capacity_norm(rest) ** 2))
