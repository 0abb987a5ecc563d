"""The heated mold as a system of equations: stored heat, heat flow, and the linear systems of a time step.

With nodal temperatures T the model is dE/dt = f(t, T): E the heat stored at each node, f the heat that flows to it
by conduction and through the boundary conditions. Held nodes follow their table instead, and the flow that this
takes is read off the balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.numerics.aggregation import hierarchy
from hyperfab.numerics.multilevel import (
    Direct,
    Preconditioner,
    TwoLevel,
    conjugate_gradients,
    largest_eigenvalue,
)
from hyperfab.numerics.product import product
from hyperfab.numerics.vectors import dot, norm
from hyperfab.thermal.assembly import Pattern, add
from hyperfab.thermal.condition import Condition
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.medium import Medium, ThermalMaterial
from hyperfab.thermal.mesh import HeatMesh
from hyperfab.thermal.prescribed import Prescribed

#: Below this number of unknowns a factorisation of the whole matrix is cheaper than the two-level cycle.
SMALL = 2000
#: Coarse spaces up to this size are factorised; larger ones are aggregated further.
COARSE = 6000
#: A stage is solved when its residual has fallen to this share, is as small as rounding makes it (per degree), or a
#: Newton step moves no node by more than STILL [K]. The linear solves inside Newton need not be sharper than this.
RESIDUAL = 1e-6
ROUNDING = 1e-13
STILL = 1e-9
NEWTON_SOLVE = 1e-4
#: The matrix of a time step serves from iteration to iteration, and in both stages, as long as each leaves less than
#: this of a residual.
SLOW = 0.02
#: Uniform shifts that close the balance of a nonlinear stage; the second one is already tiny.
BALANCINGS = 3
NEWTON_STEPS = 40
#: A coarse solver serves a step whose matrix is up to this many times, or down to one so-manyth of, its own.
ALIKE = 4.0
#: Coarse solvers that are kept, the last used, till a system takes more conjugate-gradient steps than this.
KEPT, TIRED = 8, 40


@dataclass(frozen=True)
class _Prepared:
    """What is dear in a preconditioner, and the step it was made for, as ``solve_stage`` has it.

    ``coarse`` solves on the coarse space, or the whole of a small mold; ``largest`` is as in ``TwoLevel``.
    """

    interval: float
    storage: float
    coarse: Preconditioner
    largest: float


@dataclass
class HeatModel:
    """A mesh, its materials (one a part), and what happens on faces, in volumes and at joints.

    ``loose`` [J/K] is the heat capacity of the mesh's loose nodes.
    """

    mesh: HeatMesh
    materials: Sequence[ThermalMaterial]
    conditions: Sequence[Condition]
    prescribed: Sequence[Prescribed] = ()
    loose: Array = field(default_factory=lambda: np.zeros(0))
    #: Conjugate-gradient steps so far.
    iterations: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        groups = [c.nodes for c in self.conditions if len(c.nodes) and c.nodes.shape[1] != 6]
        self.pattern = Pattern(len(self.mesh.points), [self.mesh.elements, *groups])
        self.medium = Medium(self.mesh, self.materials, self.pattern, self.loose)
        self.free = np.ones(len(self.mesh.points), dtype=bool)
        for held in self.prescribed:
            self.free[held.nodes] = False
        self.linear = self.medium.linear and all(c.linear for c in self.conditions)
        self._is_small = int(self.free.sum()) <= SMALL
        self._prolongation = _degree_two_on_one(self.mesh, self.free)
        self._capacity = self.pattern.matrix(self.medium.capacity(np.zeros(self.size)))
        diagonal = self._capacity.diagonal()
        self._total_capacity = float(self._capacity.sum())
        #: Heat capacity of each node [J/K], all positive (diagonal scaling: row sums of degree 2 are not).
        self.lumped_capacity = diagonal * (self._total_capacity / diagonal.sum())
        self.last_matrix: sparse.csr_matrix | None = None
        self._assembled: tuple[float, float] | None = None
        self._prepared: list[_Prepared] = []  # the last used at the end
        self._preconditioner: Preconditioner | None = None
        self._tired = False  # a contact that has closed is nothing that solvers from before know of

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.mesh.points)

    @property
    def heaters(self) -> list[Heater]:
        """The heaters among the conditions."""
        return [c for c in self.conditions if isinstance(c, Heater)]

    @property
    def solver_name(self) -> str:
        """What solves the linear systems."""
        return "sparse factorisation" if self._is_small else "conjugate gradients, degree 2 on degree 1"

    def total_capacity(self, temperature: Array) -> float:
        """Return the heat capacity of all parts at nodal temperatures [J/K]."""
        return float(self.medium.capacity(temperature).sum())

    def stored(self, temperature: Array) -> Array:
        """Return the heat stored at each node [J]."""
        return self.medium.stored(temperature)

    def total(self, by_node: Array) -> float:
        """Return the heat, or the flow, of the whole mold."""
        return float(by_node.sum())

    def moved(self, stored: Array) -> float:
        """Return how much heat has changed its node, of the change of what is stored [J]."""
        return 0.5 * float(np.abs(stored).sum())

    def speed(self, rate: Array) -> float:
        """Return how fast a change of the flow [W] heats, root of the mean square [K/s]."""
        return self.capacity_norm(rate * self.free / self.lumped_capacity)

    def hold(self, time: float, temperature: Array) -> Array:
        """Return the temperatures with the held nodes set to their values at ``time``."""
        result = temperature.copy()
        for held in self.prescribed:
            held.apply(time, result)
        return result

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the heat flow to each node (n,) [W]."""
        # A uniform temperature conducts nothing; taking one off keeps its rounding out of the account of heat. What
        # is laid on the mold has nodes of its own, which may be far colder and conduct nothing here.
        solid = temperature[: self.mesh.solid]
        level = 0.5 * (float(solid.min()) + float(solid.max()))
        total = -product(self.pattern.matrix(self.medium.conduction(temperature)), temperature - level)
        for condition in self.conditions:
            total += condition.flow(time, temperature)
        return total

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return the data of minus the flow's derivative (its symmetric part in k(T)) [W/K]."""
        data = self.medium.conduction(temperature).copy()
        self._add_conditions(time, 1.0, temperature, data)
        return data

    def solve_stage(
        self,
        time: float,
        interval: float,
        target: Array,
        guess: Array,
        storage: float = 1.0,
        reference: float | None = None,
    ) -> tuple[Array, float]:
        """Solve storage E(T) - interval f(time, T) = target for T, from a guess with the held nodes set.

        ``interval`` [s]; ``storage`` is 1 in a time step and 0 in the steady state. The residual falls to RESIDUAL
        of ``reference`` [J], by default of what it is at the guess. Returns the temperatures and
        the residual as a temperature [K]: its norm over that of the matrix's diagonal. The last thing done is a
        uniform shift that makes the residuals of the free nodes sum to zero: it closes the energy balance, which
        the iteration leaves open by its tolerance.
        """
        temperature = guess.copy()
        matrix = self._stage_matrix(time, interval, storage, temperature)
        scale = norm(self.pattern.diagonal(matrix) * self.free)
        goal, size, moved, tolerance = 0.0, np.inf, np.inf, np.inf
        residual = change = np.zeros(0)
        for step in range(NEWTON_STEPS):
            if step == 0 or not self.linear:
                residual = self._residual(time, interval, storage, target, temperature)
            else:
                residual = np.where(self.free, residual - product(matrix, change), 0.0)
            before, size = size, norm(residual)
            if step == 0:
                goal = max(RESIDUAL * (size if reference is None else reference), ROUNDING * scale)
            if size <= goal or moved <= STILL:
                uniform = self.free.astype(float)
                capacity = dot(uniform, product(matrix, uniform))
                if step and self.linear:  # what was carried along has gathered rounding
                    residual = self._residual(time, interval, storage, target, temperature)
                for _ in range(BALANCINGS):
                    shift = float(residual.sum()) / capacity
                    temperature[self.free] += shift
                    if self.linear or abs(shift) < STILL:
                        break
                    residual = self._residual(time, interval, storage, target, temperature)
                return temperature, size / scale
            anew = (step and not storage) or size > max(3.0 * tolerance, SLOW) * before
            if anew and not self.linear:
                matrix = self.last_matrix = self._step_matrix(time, interval, storage, temperature)
            least = 0.0 if self.linear else NEWTON_SOLVE
            tolerance = min(max(0.5 * goal / size, least), 0.1)
            change = self.solve(matrix, residual, tolerance)
            temperature += change
            moved = float(np.abs(change).max())
            if not np.isfinite(moved) or moved > 1e7:
                break
        raise NotConverged(
            f"the temperatures at {time:.6g} s did not settle (residual {size:.2g})",
            remedy="check film coefficients and material tables for jumps",
        )

    def solve_steady(self, time: float, guess: Array) -> tuple[Array, float]:
        """Solve f(time, T) = 0 from a guess with the held nodes set; the body must lose heat somewhere."""
        return self.solve_stage(time, 1.0, np.zeros(self.size), guess, storage=0.0)

    def capacity_norm(self, field: Array) -> float:
        """Return the root of the mean square of a nodal field, weighted with the heat capacity.

        Loose nodes have a mean of their own, and the larger one counts: a light piece on a heavy mold counts.
        """
        whole, loose = dot(field, product(self._capacity, field)), 0.0
        if len(self.loose):
            mine, weight = field[self.mesh.solid :], float(self.loose.sum())
            loose = dot(mine, self.loose * mine)
            whole -= loose
            return float(np.sqrt(max(whole / (self._total_capacity - weight), loose / weight, 0.0)))
        return float(np.sqrt(max(whole, 0.0) / self._total_capacity))

    def solve(self, matrix: sparse.csr_matrix, right: Array, tolerance: float) -> Array:
        """Solve with the step's matrix by preconditioned conjugate gradients."""
        assert self._preconditioner is not None
        found = conjugate_gradients(matrix, right, self._preconditioner, self.free, tolerance=tolerance)
        self.iterations += found.iterations
        self._tired = self._tired or found.iterations > TIRED
        return found.x

    def step_matrix(self, time: float, interval: float, temperature: Array) -> sparse.csr_matrix:
        """Return the matrix of an implicit step of ``interval`` [s] and make ``solve`` ready for it."""
        return self._stage_matrix(time, interval, 1.0, temperature, anew=True)

    def steady_matrix(self, time: float, temperature: Array) -> sparse.csr_matrix:
        """Return minus the flow's derivative [W/K] and make ``solve`` ready for it."""
        return self._stage_matrix(time, 1.0, 0.0, temperature, anew=True)

    def changed(self) -> None:
        """Forget the matrices: a condition was switched."""
        self._assembled = self._preconditioner = None
        self._tired = False
        self._prepared.clear()

    def _serving(self, interval: float, storage: float) -> _Prepared | None:
        """Return what was made for this step, or, where that is no factorisation of it all, for one like it."""
        alike = [one for one in self._prepared if one.storage == storage]
        nearest = min(alike, key=lambda one: abs(np.log(interval / one.interval)), default=None)
        if nearest is None or nearest.interval == interval:
            return nearest
        if self._is_small:
            return None
        # Steps that are short for the smallest elements have nearly the same matrix: what stores.
        fast = self._fastest if storage else np.inf
        ratio = (1.0 / fast + interval) / (1.0 / fast + nearest.interval)
        return nearest if 1.0 / ALIKE < ratio < ALIKE else None

    def _residual(
        self, time: float, interval: float, storage: float, target: Array, temperature: Array
    ) -> Array:
        residual = target + interval * self.flow(time, temperature)
        if storage:
            residual -= storage * self.medium.stored(temperature)
        residual[~self.free] = 0.0
        return residual

    def _stage_matrix(
        self, time: float, interval: float, storage: float, temperature: Array, *, anew: bool = False
    ) -> sparse.csr_matrix:
        """Return the matrix to start a stage with, its preconditioner made; the last one of this step, or made anew."""
        same = self._assembled == (interval, storage)
        if not same or self.last_matrix is None or (anew and not self.linear):
            matrix = self._step_matrix(time, interval, storage, temperature)
            if self._tired:
                self.changed()
            serving = self._serving(interval, storage)
            if serving is None or serving is not self._prepared[-1] or self._preconditioner is None:
                self._prepare(time, interval, storage, temperature, matrix, serving)
            self.last_matrix, self._assembled = matrix, (interval, storage)
        return self.last_matrix

    def _step_matrix(
        self, time: float, interval: float, storage: float, temperature: Array
    ) -> sparse.csr_matrix:
        """Return storage times the capacity and ``interval`` times what conducts; it is written over by the next."""
        data = np.multiply(self.medium.conduction(temperature), interval, out=self._entries)
        if storage:
            capacity = self.medium.capacity(temperature)
            data += capacity if storage == 1.0 else storage * capacity
        self._add_conditions(time, interval, temperature, data)
        return self.pattern.matrix(data)

    @cached_property
    def _entries(self) -> Array:
        """Room for a matrix of a step: as large as all states of many steps, to be asked for once."""
        return np.empty(self.pattern.entries)

    def _add_conditions(self, time: float, interval: float, temperature: Array, data: Array) -> None:
        for condition, places in self._coupling:
            add(places, (interval * condition.tangent(time, temperature)).ravel(), data)

    @cached_property
    def _coupling(self) -> list[tuple[Condition, NDArray[np.int32]]]:
        """The conditions that couple nodes, and where their matrices come to stand."""
        return [(c, self.pattern.places(c.nodes)) for c in self.conditions if len(c.nodes)]

    @cached_property
    def _fastest(self) -> float:
        """How fast the quickest field dies away, roughly [1/s]."""
        conduction = self.pattern.matrix(self.medium.conduction(np.zeros(self.size)))
        return largest_eigenvalue(conduction, self.free / self.lumped_capacity)

    @cached_property
    def _on_the_coarse_space(self) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """What conducts [W/K] and what stores [J/K], where neither changes with temperature."""
        nothing = np.zeros(self.size)
        return self._coarse(self.medium.conduction(nothing)), self._coarse(self.medium.capacity(nothing))

    def _coarse_conditions(self, time: float, temperature: Array) -> sparse.csr_matrix:
        """Return what the conditions conduct on the coarse space [W/K]: of few nodes, so by a matrix of these alone."""
        p, total = self._prolongation, sparse.csr_matrix((self._prolongation.shape[1],) * 2)
        for condition, _ in self._coupling:
            nodes, blocks = condition.nodes, condition.tangent(time, temperature)
            own, number = np.unique(nodes, return_inverse=True)
            number = number.reshape(nodes.shape)
            rows = np.repeat(number, nodes.shape[1], axis=1).ravel()
            columns = np.tile(number, (1, nodes.shape[1])).ravel()
            matrix = sparse.csr_matrix((blocks.ravel(), (rows, columns)), shape=(len(own), len(own)))
            total = total + p[own].T @ (matrix @ p[own])
        return total

    def _coarse(self, data: Array) -> sparse.csr_matrix:
        """Return a matrix of the pattern on the coarse space of the preconditioner."""
        matrix, p = self.pattern.matrix(data).copy(), self._prolongation
        matrix.eliminate_zeros()
        return sparse.csr_matrix(p.T @ (matrix @ p))

    def _prepare(
        self,
        time: float,
        interval: float,
        storage: float,
        temperature: Array,
        matrix: sparse.csr_matrix,
        serving: _Prepared | None,
    ) -> None:
        """Make the preconditioner for a step length, of what is ``serving`` it; a matrix that drifts keeps it."""
        largest = None if serving is None else serving.largest
        if serving is not None:
            coarse = serving.coarse
        elif self._is_small:
            coarse = Direct(matrix, self.free)
        elif self.medium.linear:  # what conducts and stores is taken to the coarse space once
            conduction, capacity = self._on_the_coarse_space
            faces = self._coarse_conditions(time, temperature)
            coarse = hierarchy(interval * (conduction + faces) + storage * capacity, COARSE)
        else:
            coarse = hierarchy(self._coarse(matrix.data), COARSE)
        if self._is_small:
            self._preconditioner, largest = coarse, 1.0
        else:
            whole = TwoLevel(matrix, self._prolongation, coarse, self.free, largest=largest)
            self._preconditioner, largest = whole, whole.largest
        used = serving or _Prepared(interval, storage, coarse, largest)
        self._prepared = [*[one for one in self._prepared if one is not used][1 - KEPT :], used]


def _degree_two_on_one(mesh: HeatMesh, free: NDArray[np.bool_]) -> sparse.csr_matrix:
    """Return the prolongation from free vertices and loose nodes to free nodes: edges' are means of their ends."""
    n, v, loose = mesh.solid, mesh.vertices, len(mesh.points) - mesh.solid
    rows = np.concatenate([np.arange(v), np.repeat(np.arange(v, n), 2), n + np.arange(loose)])
    columns = np.concatenate([np.arange(v), mesh.edge_ends.ravel(), v + np.arange(loose)])
    entries = np.concatenate([np.ones(v), np.full(2 * (n - v), 0.5), np.ones(loose)])
    whole = sparse.csr_matrix((entries * free[rows], (rows, columns)), shape=(n + loose, v + loose))
    return sparse.csr_matrix(whole[:, np.flatnonzero(np.concatenate([free[:v], free[n:]]))])


def without_route(model: HeatModel) -> int | None:
    """Return a node of a piece that no film, radiation or held face lets heat out of; None where there is none."""
    n = model.size
    ambient = np.full(n, 20.0)
    touched = ~model.free
    for condition in model.conditions:
        if len(condition.nodes):
            loss = condition.tangent(0.0, ambient).sum(axis=(1, 2))
            leaks = condition.nodes[loss > 1e-12 * max(float(np.abs(loss).max()), 1e-300)]
            touched[leaks.ravel()] = True
    linked = model.pattern.matrix(model.tangent(0.0, ambient))
    linked.data = np.abs(linked.data)
    _, piece = connected_components(linked, directed=False)
    open_pieces = np.unique(piece[touched])
    closed = np.flatnonzero(~np.isin(piece, open_pieces))
    return int(closed[0]) if closed.size else None
