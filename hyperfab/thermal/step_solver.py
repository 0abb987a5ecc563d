"""The linear solver of time steps: what is dear in its preconditioner is made once for all steps that are alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Flags
from hyperfab.numerics.multilevel import (
    Direct,
    Preconditioner,
    TwoLevel,
    conjugate_gradients,
    hierarchy,
    largest_eigenvalue,
)
from hyperfab.thermal.condition import Condition
from hyperfab.thermal.medium import Medium
from hyperfab.thermal.mesh import HeatMesh

#: Below this number of unknowns a factorisation of the whole matrix is cheaper than the two-level cycle.
SMALL = 2000
#: Degree of the smoothers: where most is stored, two more cheap steps of the conjugate gradients in ten are faster than
#: smoothers of degree 2 (by a twelfth on the fine space at 50,000 and at 350,000 unknowns, by a tenth on coarse ones,
#: where a long step asks for one more in ten).
DEGREE = 1
#: A coarse solver serves a step whose matrix is up to this many times, or down to one so-manyth of, its own.
ALIKE = 4.0
#: Coarse solvers that are kept, the last used, till a system takes more conjugate-gradient steps than this.
KEPT, TIRED = 8, 40


class StageEquation(NamedTuple):
    """An implicit stage: storage E(T) - interval f(time, T) = target; ``storage`` is 1 in a step, 0 if steady."""

    time: float
    interval: float
    storage: float = 1.0


@dataclass(frozen=True)
class _Prepared:
    """What is dear in a preconditioner, and the step that it was made for.

    ``coarse`` solves on the coarse space, or the whole of a small mold; ``largest`` is as in ``TwoLevel``.
    """

    interval: float
    storage: float
    coarse: Preconditioner
    largest: float


class StepSolver:
    """Preconditioned conjugate gradients for the matrices of stages, of degree 2 on degree 1.

    ``faces`` are the conditions that couple nodes; ``capacity`` (n,) [J/K] is all positive.
    """

    def __init__(
        self, mesh: HeatMesh, medium: Medium, faces: Sequence[Condition], free: Flags, capacity: Array
    ) -> None:
        self.medium, self.faces, self.free, self.capacity = medium, faces, free, capacity
        self.direct = int(free.sum()) <= SMALL
        #: Conjugate-gradient steps so far.
        self.iterations = 0
        self._prolongation = _degree_two_on_one(mesh, free)
        self._restriction = sparse.csr_matrix(self._prolongation.T)
        self._prepared: list[_Prepared] = []  # the last used at the end
        self._preconditioner: Preconditioner | None = None
        self._tired = False  # a contact that has closed is nothing that solvers from before know of

    @property
    def name(self) -> str:
        """What solves the linear systems."""
        return "sparse factorisation" if self.direct else "conjugate gradients, degree 2 on degree 1"

    def solve(self, matrix: sparse.csr_matrix, right: Array, tolerance: float) -> Array:
        """Solve with a matrix of the stage that all is ready for."""
        assert self._preconditioner is not None
        found = conjugate_gradients(matrix, right, self._preconditioner, self.free, tolerance=tolerance)
        self.iterations += found.iterations
        self._tired = self._tired or found.iterations > TIRED
        return found.x

    def make_ready(self, stage: StageEquation, temperature: Array, matrix: sparse.csr_matrix) -> None:
        """Be ready to ``solve`` for a stage whose ``matrix`` is taken at a temperature; one that drifts will do."""
        if self._tired:
            self.forget()
        serving = self._serving(stage)
        if serving is not None and serving is self._prepared[-1] and self._preconditioner is not None:
            return
        coarse = self._coarse_solver(stage, temperature, matrix) if serving is None else serving.coarse
        if self.direct:
            self._preconditioner, largest = coarse, 1.0
        else:
            known = None if serving is None else serving.largest
            p, transposed = self._prolongation, self._restriction
            whole = TwoLevel(matrix, p, coarse, self.free, DEGREE, known, transposed)
            self._preconditioner, largest = whole, whole.largest
        used = serving or _Prepared(stage.interval, stage.storage, coarse, largest)
        self._prepared = [*[one for one in self._prepared if one is not used][1 - KEPT :], used]

    def forget(self) -> None:
        """Forget all that was made for other matrices."""
        self._preconditioner = None
        self._tired = False
        self._prepared.clear()

    def _serving(self, stage: StageEquation) -> _Prepared | None:
        """Return what was made for this stage, or, where that is no factorisation of it all, for one like it."""
        alike = [one for one in self._prepared if one.storage == stage.storage]
        nearest = min(alike, key=lambda one: abs(np.log(stage.interval / one.interval)), default=None)
        if nearest is None or nearest.interval == stage.interval:
            return nearest
        if self.direct:
            return None
        # Steps that are short for the smallest elements have nearly the same matrix: what stores.
        fast = self._fastest if stage.storage else np.inf
        ratio = (1.0 / fast + stage.interval) / (1.0 / fast + nearest.interval)
        return nearest if 1.0 / ALIKE < ratio < ALIKE else None

    @cached_property
    def _fastest(self) -> float:
        """How fast the quickest field dies away, roughly [1/s]."""
        conduction = self.medium.pattern.matrix(self.medium.conduction(np.zeros(len(self.free))))
        return largest_eigenvalue(conduction, self.free / self.capacity)

    def _coarse_solver(self, stage: StageEquation, temperature: Array, matrix: sparse.csr_matrix) -> Preconditioner:
        if self.direct:
            return Direct(matrix, self.free)
        if self.medium.linear:  # what conducts and stores is taken to the coarse space once
            conduction, capacity = self._on_the_coarse_space
            faces = self._coarse_faces(stage.time, temperature)
            coarse = stage.interval * (conduction + faces) + stage.storage * capacity
        else:
            coarse = self._coarse(matrix.data)
        return hierarchy(coarse, degree=DEGREE)

    @cached_property
    def _on_the_coarse_space(self) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """What conducts [W/K] and what stores [J/K], where neither changes with temperature."""
        nothing = np.zeros(len(self.free))
        return self._coarse(self.medium.conduction(nothing)), self._coarse(self.medium.capacity(nothing))

    def _coarse_faces(self, time: float, temperature: Array) -> sparse.csr_matrix:
        """Return what the conditions conduct on the coarse space [W/K]: of few nodes, so by a matrix of these alone."""
        p, total = self._prolongation, sparse.csr_matrix((self._prolongation.shape[1],) * 2)
        for condition in self.faces:
            nodes, blocks = condition.nodes, condition.tangent(time, temperature)
            own, number = np.unique(nodes, return_inverse=True)
            rows = np.repeat(number, nodes.shape[1], axis=1).ravel()
            columns = np.tile(number, (1, nodes.shape[1])).ravel()
            matrix = sparse.csr_matrix((blocks.ravel(), (rows, columns)), shape=(len(own), len(own)))
            total = total + p[own].T @ (matrix @ p[own])
        return total

    def _coarse(self, data: Array) -> sparse.csr_matrix:
        """Return a matrix of the pattern on the coarse space of the preconditioner."""
        matrix, p = self.medium.pattern.matrix(data).copy(), self._prolongation
        matrix.eliminate_zeros()
        return sparse.csr_matrix(self._restriction @ (matrix @ p))


def _degree_two_on_one(mesh: HeatMesh, free: Flags) -> sparse.csr_matrix:
    """Return the prolongation from free vertices and loose nodes to free nodes: edges' are means of their ends."""
    n, v, loose = mesh.solid, mesh.vertices, len(mesh.points) - mesh.solid
    rows = np.concatenate([np.arange(v), np.repeat(np.arange(v, n), 2), n + np.arange(loose)])
    columns = np.concatenate([np.arange(v), mesh.edge_ends.ravel(), v + np.arange(loose)])
    entries = np.concatenate([np.ones(v), np.full(2 * (n - v), 0.5), np.ones(loose)])
    whole = sparse.csr_matrix((entries * free[rows], (rows, columns)), shape=(n + loose, v + loose))
    return sparse.csr_matrix(whole[:, np.flatnonzero(np.concatenate([free[:v], free[n:]]))])
