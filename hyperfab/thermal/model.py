"""The heated mold as a system of equations: stored heat, heat flow, and the linear systems of a time step.

With nodal temperatures T the model is dE/dt = f(t, T): E the heat stored at each node, f the heat that flows to it
by conduction and through the boundary conditions. Held nodes follow their table instead, and the flow that this
takes is read off the balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.numerics.product import product
from hyperfab.numerics.vectors import dot, norm
from hyperfab.thermal.assembly import Pattern, add
from hyperfab.thermal.condition import Condition, Heater, Prescribed
from hyperfab.thermal.medium import Medium, ThermalMaterial
from hyperfab.thermal.mesh import HeatMesh
from hyperfab.thermal.step_solver import StageEquation, StepSolver

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
NEWTON_STEPS, STEADY_STEPS = 40, 120
#: A step after which the residual is larger is halved so often, one after the other.
MOST_HALVINGS = 6
#: The bottom along a step towards the steady state is where the slope has fallen to this share, or after so many looks.
FLAT, LOOKS = 1e-2, 30
#: Least share of a step that is taken in a steady state whose conductivity depends on temperature.
LEAST_SHARE = 0.1


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

    def __post_init__(self) -> None:
        groups = [c.nodes for c in self.conditions if len(c.nodes) and c.nodes.shape[1] != 6]
        self.pattern = Pattern(len(self.mesh.points), [self.mesh.elements, *groups])
        self.medium = Medium(self.mesh, self.materials, self.pattern, self.loose)
        self.free = np.ones(len(self.mesh.points), dtype=bool)
        for held in self.prescribed:
            self.free[held.nodes] = False
        self.linear = self.medium.linear and all(c.linear for c in self.conditions)
        self._capacity = self.pattern.matrix(self.medium.capacity(np.zeros(self.size)))
        diagonal = self._capacity.diagonal()
        self._total_capacity = float(self._capacity.sum())
        #: Heat capacity of each node [J/K], all positive (diagonal scaling: row sums of degree 2 are not).
        self.lumped_capacity = diagonal * (self._total_capacity / diagonal.sum())
        self.last_matrix: sparse.csr_matrix | None = None
        self._assembled: tuple[float, float] | None = None
        #: The conditions that couple nodes, and where their matrices come to stand.
        self._coupling = [(c, self.pattern.places(c.nodes)) for c in self.conditions if len(c.nodes)]
        faces = [condition for condition, _ in self._coupling]
        self._solver = StepSolver(self.mesh, self.medium, faces, self.free, self.lumped_capacity)
        #: Room for the matrix of a step: as large as all states of many steps, to be asked for once.
        self._entries = np.empty(self.pattern.entries)

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
        return self._solver.name

    @property
    def iterations(self) -> int:
        """Conjugate-gradient steps so far."""
        return self._solver.iterations

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
        temperature, stage = guess.copy(), StageEquation(time, interval, storage)
        matrix = self._stage_matrix(stage, temperature)
        scale = norm(self.pattern.diagonal(matrix) * self.free)
        goal, size, moved, tolerance = 0.0, np.inf, np.inf, np.inf
        residual = change = np.zeros(0)
        halved, share = 0, 1.0
        lagged = not storage and self.medium.conduction_varies
        for step in range(NEWTON_STEPS if storage else STEADY_STEPS):
            if step == 0 or not self.linear:
                residual = self._residual(stage, target, temperature)
            else:
                residual = np.where(self.free, residual - product(matrix, change), 0.0)
            before, size = size, norm(residual)
            if step == 0:
                goal = max(RESIDUAL * (size if reference is None else reference), ROUNDING * scale)
            elif size > before and not (storage or self.linear or lagged):
                temperature, residual = self._least(stage, target, temperature, change, residual)
                size = norm(residual)
            elif size > before and not (self.linear or lagged) and halved < MOST_HALVINGS:
                # A peak of the specific heat, that of melting, throws whole steps to and fro across it.
                change *= 0.5
                temperature -= change
                size, moved, halved = before, 0.5 * moved, halved + 1
                continue
            halved = 0
            if size <= goal or moved <= STILL:
                uniform = self.free.astype(float)
                capacity = dot(uniform, product(matrix, uniform))
                if step and self.linear:  # what was carried along has gathered rounding
                    residual = self._residual(stage, target, temperature)
                for _ in range(BALANCINGS):
                    shift = float(residual.sum()) / capacity
                    temperature[self.free] += shift
                    if self.linear or abs(shift) < STILL:
                        break
                    residual = self._residual(stage, target, temperature)
                return temperature, size / scale
            anew = (step and not storage) or size > max(3.0 * tolerance, SLOW) * before
            if anew and not self.linear:
                matrix = self.last_matrix = self._step_matrix(stage, temperature)
            least = 0.0 if self.linear else NEWTON_SOLVE
            tolerance = min(max(0.5 * goal / size, least), 0.1)
            last, change = change, self.solve(matrix, residual, tolerance)
            # What k(T) adds to the tangent is not symmetric and left out: nothing else holds the steps where nothing
            # is stored, and a residual that rises for once says nothing of them.
            share = _share(share, last, change) if lagged and step > 1 else 1.0
            temperature += share * change
            moved = float(np.abs(change).max())
            if not np.isfinite(moved) or moved > 1e7:
                break
        raise NotConverged(
            f"the temperatures at {time:.6g} s did not settle (residual {size:.2g})",
            remedy="check film coefficients and material tables for jumps",
        )

    def _least(
        self, stage: StageEquation, target: Array, beyond: Array, change: Array, residual: Array
    ) -> tuple[Array, Array]:
        """Return where along the last ``change``, which led to ``beyond``, the bowl that the flow is the slope of is
        deepest, and the residual there.

        A film that jumps throws whole steps to and fro across the jump, and the residual's size says nothing there.
        """
        low, high, share = 0.0, 1.0, 1.0
        slope = first = -float(dot(change, residual))
        for _ in range(LOOKS):
            if slope <= 0.0:
                low = share
            else:
                high = share
            if low == high:
                break
            share = 0.5 * (low + high)
            residual = self._residual(stage, target, beyond - (1.0 - share) * change)
            slope = -float(dot(change, residual))
            if abs(slope) <= FLAT * first:
                break
        return beyond - (1.0 - share) * change, residual

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
        return self._solver.solve(matrix, right, tolerance)

    def step_matrix(self, time: float, interval: float, temperature: Array) -> sparse.csr_matrix:
        """Return the matrix of an implicit step of ``interval`` [s] and make ``solve`` ready for it."""
        return self._stage_matrix(StageEquation(time, interval), temperature, anew=True)

    def steady_matrix(self, time: float, temperature: Array) -> sparse.csr_matrix:
        """Return minus the flow's derivative [W/K] and make ``solve`` ready for it."""
        return self._stage_matrix(StageEquation(time, 1.0, 0.0), temperature, anew=True)

    def changed(self) -> None:
        """Forget the matrices: a condition was switched."""
        self._assembled = None
        self._solver.forget()

    def _residual(self, stage: StageEquation, target: Array, temperature: Array) -> Array:
        residual = target + stage.interval * self.flow(stage.time, temperature)
        if stage.storage:
            residual -= stage.storage * self.medium.stored(temperature)
        residual[~self.free] = 0.0
        return residual

    def _stage_matrix(self, stage: StageEquation, temperature: Array, *, anew: bool = False) -> sparse.csr_matrix:
        """Return the matrix to start a stage with, and be ready to solve: the last one of this step, or made anew."""
        same = self._assembled == stage[1:]
        if not same or self.last_matrix is None or (anew and not self.linear):
            matrix = self._step_matrix(stage, temperature)
            self._solver.make_ready(stage, temperature, matrix)
            self.last_matrix, self._assembled = matrix, stage[1:]
        return self.last_matrix

    def _step_matrix(self, stage: StageEquation, temperature: Array) -> sparse.csr_matrix:
        """Return storage times the capacity and ``interval`` times what conducts; it is written over by the next."""
        data = np.multiply(self.medium.conduction(temperature), stage.interval, out=self._entries)
        if stage.storage:
            capacity = self.medium.capacity(temperature)
            data += capacity if stage.storage == 1.0 else stage.storage * capacity
        self._add_conditions(stage.time, stage.interval, temperature, data)
        return self.pattern.matrix(data)

    def _add_conditions(self, time: float, interval: float, temperature: Array, data: Array) -> None:
        for condition, places in self._coupling:
            add(places, (interval * condition.tangent(time, temperature)).ravel(), data)


def _share(share: float, last: Array, change: Array) -> float:
    """Return which share of a step to take after ``share`` of the ``last`` one (Aitken's relaxation, between bounds).

    Irons and Tuck, Int. J. Numer. Meth. Eng. 1 (1969) 275.
    """
    turned = change - last
    return float(np.clip(-share * dot(last, turned) / max(dot(turned, turned), 1e-300), LEAST_SHARE, 1.0))


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
