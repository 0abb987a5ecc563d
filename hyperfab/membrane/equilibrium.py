"""Equilibrium of a sheet on a punch at one depth: Newton's method with an exact, node-wise active contact set."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.contact import (
    STIFF,
    Coulomb,
    Frictionless,
    Grip,
    Memory,
    Tangential,
    Terms,
    counted,
    landings,
    mounted,
    remembered,
)
from hyperfab.membrane.punch import Nearness, Punch
from hyperfab.membrane.sheet import Assembled, Sheet
from hyperfab.numerics.linear import Factor, SingularMatrixError

#: Largest way of a node in one iteration, relative to the distance from the punch's axis to the rim.
_LARGEST_STEP = 0.15
#: Where no part of a step down to this one lowers the energy, this one is taken.
_SMALLEST_PART = 1e-2
#: With full stick, a node that comes to touch this often in one step is not let go again.
_KEPT_AFTER = 2
#: Artificial tension never falls below this part of the mean stress, so that slack nodes have some stiffness; that of a
#: careful iteration never below the other.
_LEAST_SUPPORT, _LEAST_CAREFUL = 1e-6, 1e-9
#: A careful iteration begins with this support; it shrinks to a part after each step that lowers the energy as a whole,
#: and grows after each that does not (Levenberg and Marquardt), up to all of the mean stress.
_CAREFUL_SUPPORT, _LESS_SUPPORT, _MORE_SUPPORT = 1e-2, 0.3, 10.0
#: A careful iteration may take so many times as many steps, and of a sheet mounted slack it ends at this residual: at
#: the border of what hangs points go to and fro between slack and wrinkled. More may be left (strains of 1e-6 there)
#: where a step could lower the energy by no more than this part. From an equilibrium with more the next will hang, too.
_MORE_STEPS, _SLACK_RESIDUAL = 16, 1e-6
_HANGING_RESIDUAL, _NO_GAIN, _HANGS = 3e-4, 1e-7, 1e-7
#: The same where the next, shorter creep begins: what hangs is told by the last one alone.
_PASSING_RESIDUAL, _PASSING_GAIN = 1e-2, 1e-4
#: A sheet with less than this part of (modulus times volume) as energy is slack.
_SLACK_ENERGY = 1e-14
#: Touching nodes lie on the punch to this [mm].
_GAP_TOLERANCE = 1e-9
#: Where Newton's method finds no way between sticking and slipping, friction grows over slips (relative to the distance
#: from the punch's axis to the rim) that shrink from more than a load step brings about to as good as none.
_FIRST_CREEP, _LAST_CREEP = 1e-2, 1.1e-8
#: From one to the next they shrink to this part, or to its root where that is too far at once.
_LESS_CREEP, _LEAST_CHANGE = 0.1, 0.5
#: On facets a node may be pulled off by this part of the largest nodal force and still touches.
_FLAT = 1e-9


class NoEquilibriumError(Exception):
    """Newton's method found no equilibrium from the given start."""


@dataclass(frozen=True)
class State:
    """The sheet in equilibrium with the punch at ``depth`` [mm].

    ``places`` (n, 3) [mm] and ``touching`` (n,) of the nodes; ``pressure`` (n,) [N]: normal contact force of each
    node; ``energy`` [N mm], ``force`` (of the punch) and ``reaction`` (of the rim) along z [N] of the whole sheet;
    ``residual``: largest unbalanced nodal force over the punch's force; ``iterations`` of Newton's method;
    ``memory``: what friction remembers.
    """

    depth: float
    places: Array
    touching: Flags
    pressure: Array
    energy: float
    force: float
    reaction: float
    residual: float
    iterations: int
    memory: Memory


@dataclass(frozen=True)
class Tangent:
    """Newton's equations at an equilibrium.

    ``per_depth`` (n, 3): how the places move per mm of depth; ``factor`` of the stiffness; ``hold`` (k, 3) [N/mm]:
    stiff springs along the normals of the touching nodes; ``force`` (n, 3) [N] of the sheet; ``lift`` (n, 3) [N/mm]:
    what its force along z on the rim changes by with each place.
    """

    per_depth: Array
    factor: Factor
    hold: Array
    force: Array
    lift: Array


@dataclass(frozen=True)
class _Linearised:
    """Newton's equations at given places: what the sheet and the punch contribute."""

    sheet: Assembled
    near: Nearness
    nodes: Ints
    terms: Terms
    spring: Array
    unbalanced: Array
    worst: float

    @property
    def gap(self) -> float:
        return float(np.abs(self.near.gap[self.nodes]).max(initial=0.0))


@dataclass(frozen=True)
class Press:
    """A sheet and the punch that is pushed into it.

    ``tolerance`` is on the largest unbalanced nodal force relative to the punch's force. ``frame`` [mm/N] is what the
    machine yields by that reads the depth; depths here are the punch's own.
    """

    sheet: Sheet
    punch: Punch
    tangential: Tangential = field(default_factory=Frictionless)
    tolerance: float = 1e-10
    max_iterations: int = 20
    frame: float = 0.0

    def equilibrium(
        self,
        depth: float,
        places: Array,
        touching: Flags,
        memory: Memory | None = None,
        *,
        cold: bool = False,
        careful: bool = False,
    ) -> State:
        """Return the equilibrium at ``depth`` from a start (places and touching nodes) nearby.

        ``memory`` is that of the last equilibrium on the path, of the mounted sheet where there is none.

        ``cold``: the start is a guess, not an equilibrium: the whole sheet is then carried by an artificial tension
        in the stiffness alone, which goes to zero with the unbalanced forces. ``careful``: each step must lower the
        energy; slower, and surer where much of the sheet is slack. Raises NoEquilibriumError.
        """
        memory = memory or mounted(self.sheet.flat, self.punch)
        if careful and isinstance(self.tangential, Coulomb):
            return self._creeping(self.tangential, depth, places, touching, memory, careful=True)
        try:
            return self._settled(depth, places, touching, memory, cold, careful)
        except NoEquilibriumError as error:
            if not isinstance(self.tangential, Coulomb):
                raise
            try:
                return self._creeping(self.tangential, depth, places, touching, memory)
            except NoEquilibriumError:
                raise error from None

    def nearby(self, depth: float, places: Array, touching: Flags, left: float, memory: Memory | None = None) -> State:
        """Return the equilibrium from a start made of one with ``left`` as residual, careful where parts of it hang."""
        if not ((may_hang := self.sheet.prestretch < 1.0) and left > _HANGS):
            try:
                return self.equilibrium(depth, places, touching, memory)
            except NoEquilibriumError:
                if not may_hang:
                    raise
        return self.equilibrium(depth, places, touching, memory, cold=True, careful=True)

    def _creeping(
        self, friction: Coulomb, depth: float, places: Array, touching: Flags, memory: Memory, careful: bool = False
    ) -> State:
        """Return the equilibrium with friction that grows over ever shorter slips, each from the one before.

        Nodes that stick slip by about the last of them, 1e-8 of the way from the axis to the rim.
        """
        creep, part = _FIRST_CREEP * self.sheet.reach, _LESS_CREEP

        def rubbing(creep: float) -> Press:
            return replace(self, tangential=replace(friction, creep=creep))

        state = rubbing(creep)._settled(depth, places, touching, memory, careful, careful, True)
        while creep > _LAST_CREEP * self.sheet.reach:
            # What sticks is to rub as much after the shorter slip.
            away = np.where(state.memory.sticking[:, None], state.memory.places - memory.origins, 0.0)
            away -= (away * state.memory.normal).sum(axis=1)[:, None] * state.memory.normal
            start = state.places - (1.0 - part) * away
            passing = part * creep > _LAST_CREEP * self.sheet.reach
            try:
                state = rubbing(part * creep)._settled(depth, start, state.touching, memory, careful, careful, passing)
            except NoEquilibriumError:
                if part > _LEAST_CHANGE:
                    raise
                part **= 0.5
                continue
            creep *= part
        return state

    def _settled(
        self, depth: float, places: Array, touching: Flags, memory: Memory,
        cold: bool = False, careful: bool = False, passing: bool = False,
    ) -> State:  # fmt: skip
        """Return where Newton's method settles, in what hangs but nearly if ``passing``. Raises NoEquilibriumError."""
        anchors = landings(memory, self.punch, depth)
        grip = self.tangential.begin(memory, anchors)
        touching = touching & self._movable
        away, settled, step = 1.0, False, np.zeros_like(places)
        most = self.max_iterations * (_MORE_STEPS if careful else 1)
        hangs = careful and self.sheet.prestretch < 1.0
        hold, gain = _CAREFUL_SUPPORT, np.inf
        most_left, least_gain = (_PASSING_RESIDUAL, _PASSING_GAIN) if passing else (_HANGING_RESIDUAL, _NO_GAIN)
        entered = np.zeros(len(places), int)
        last, facet = touching, None
        for iteration in range(most + 1):
            support = hold if careful else max(_LEAST_SUPPORT, min(1.0, away)) * (1.0 if cold else 0.1)
            system = self._linearise(depth, places, touching, grip, support, cold, facet)
            facet = system.near.facet
            if not np.isfinite(system.worst):
                # Beyond the limit of the law (Gent's Im, a chain's length): half the way back.
                step = 0.5 * step
                if np.abs(step).max() < _GAP_TOLERANCE:
                    raise NoEquilibriumError("the sheet is stretched beyond the limit of its law")
                places, settled = places - step, False
                continue
            left = most_left if gain < least_gain * system.sheet.energy else _SLACK_RESIDUAL
            enough = max(self.tolerance, left if hangs else 0.0)
            if settled and grip.settled and system.worst < enough and system.gap < _GAP_TOLERANCE:
                return self._state(depth, places, touching, system, iteration, (memory, anchors, grip))
            if careful and self._is_slack(system):
                return self._state(depth, places, touching & False, system, iteration, (memory, anchors, grip))
            away = system.worst + system.gap / self.sheet.reach
            step, chosen, part = self._step(depth, places, system, grip if careful else None)
            gain = -float((system.unbalanced * step).sum()) / part
            hold = max(hold * _LESS_SUPPORT, _LEAST_CAREFUL) if part == 1.0 else min(hold * _MORE_SUPPORT, 1.0)
            if self.tangential.holds:
                # A node that sticks where it lands jumps there: one that was let go and came back is kept.
                entered += chosen & ~touching
                chosen |= entered >= _KEPT_AFTER
            settled = bool((chosen == touching).all())
            if not settled and iteration > 2 and bool((chosen == last).all()):
                # Going to and fro between two sets of touching nodes: half a step leads out.
                step = 0.5 * step
                chosen = touching | ((self.punch.near(places + step, depth).gap < 0) & self._movable)
            last = touching
            places, touching = places + step, chosen
        raise NoEquilibriumError(f"Newton's method did not settle within {most} iterations")

    def tangent(self, state: State) -> Tangent:
        """Return Newton's equations at an equilibrium, factorised."""
        grip = self.tangential.begin(state.memory, state.memory.places)
        system = self._linearise(state.depth, state.places, state.touching, grip, 1e-9, False)
        factor = self._factor(system)
        right = np.zeros_like(state.places)
        # Contact hangs on places relative to the punch: as it rises, also the normals of its rounding turn.
        right[system.nodes] = system.terms.blocks[:, :, 2]
        hold = system.spring[:, None] * system.near.normal[system.nodes]
        rim = np.isin(self.sheet.pattern.rows, self.sheet.mesh.rim)
        lift = np.zeros_like(state.places)
        np.add.at(lift, self.sheet.pattern.columns[rim], system.sheet.blocks[rim, 2])
        return Tangent(self._solve(factor, right), factor, hold, system.sheet.force, lift)

    def imbalance(self, state: State, places: Array, depth: float, hold: Array) -> tuple[Array, Assembled]:
        """Return the right side (n, 3) of the ``tangent`` of another press, with its ``hold``, at ``places`` and
        ``depth`` of this one, without friction and touching as in ``state``; and the sheet there."""
        grip = self.tangential.begin(state.memory, state.memory.places)
        system = self._linearise(depth, places, state.touching, grip, 1e-9, False)
        right = -system.unbalanced
        right[system.nodes] -= hold * system.near.gap[system.nodes, None]
        return right, system.sheet

    @property
    def _movable(self) -> Flags:
        return np.asarray(self.sheet.pattern.free[:, 2])

    def _linearise(
        self,
        depth: float,
        places: Array,
        touching: Flags,
        grip: Grip,
        support: float,
        everywhere: bool,
        facet: Ints | None = None,
    ) -> _Linearised:
        found = self.sheet.assemble(places, support, everywhere)
        near = self.punch.near(places, depth).along(self.sheet.pattern.free)
        nodes = np.flatnonzero(touching)
        mine = near.at(nodes, facet)
        spring = STIFF * np.trace(found.blocks[self.sheet.pattern.diagonal[nodes]], axis1=1, axis2=2)
        relative = places[nodes] - np.array([0.0, 0.0, depth])
        terms = grip.terms(
            nodes, relative, np.where(self.sheet.pattern.free[nodes], found.force[nodes], 0.0), mine, spring
        )
        unbalanced = found.force.copy()
        unbalanced[nodes] -= terms.force
        unbalanced[~self.sheet.pattern.free] = 0.0
        pushed = float(np.linalg.norm(terms.force, axis=1).sum())
        least = 1e-5 * self.sheet.modulus * self.sheet.thickness * self.sheet.reach
        # No iteration takes the forces of a clamp that gives little below their rounding.
        rounded = self.sheet.clamp.rounding / self.tolerance if self.sheet.clamp else 0.0
        worst = float(np.abs(unbalanced).max() / max(pushed, least, rounded))
        return _Linearised(found, near, nodes, terms, spring, unbalanced, worst)

    def _factor(self, system: _Linearised) -> Factor:
        blocks = system.sheet.blocks
        if system.terms.mix is not None:
            place = np.full(len(self.sheet.mesh.nodes), -1)
            place[system.nodes] = np.arange(len(system.nodes))
            mine = np.flatnonzero(place[self.sheet.pattern.rows] >= 0)
            mix = system.terms.mix[place[self.sheet.pattern.rows[mine]]]
            blocks[mine] = np.einsum("kij,kjl->kil", mix, blocks[mine])
        blocks[self.sheet.pattern.diagonal[system.nodes]] += system.terms.blocks
        pattern = self.sheet.pattern
        return pattern.solver.factorise(pattern.matrix(blocks), symmetric=self.tangential.symmetric)

    def _solve(self, factor: Factor, right: Array) -> Array:
        return self.sheet.pattern.extend(factor.solve(self.sheet.pattern.restrict(right)))

    def _step(
        self, depth: float, places: Array, system: _Linearised, careful: Grip | None
    ) -> tuple[Array, Flags, float]:
        """Return a Newton step (n, 3), the nodes that touch after it, and the part of it taken where ``careful``."""
        right = -system.unbalanced
        if system.terms.mix is not None:
            right[system.nodes] = np.einsum("kij,kj->ki", system.terms.mix, right[system.nodes])
        right[system.nodes] += system.terms.right
        try:
            step = self._solve(self._factor(system), right)
        except SingularMatrixError as error:
            raise NoEquilibriumError(f"the stiffness is singular ({error})") from error
        nodes, near, normal = system.nodes, system.near, system.near.normal[system.nodes]
        change = -system.spring * ((step[nodes] * normal).sum(axis=1) + near.gap[nodes])
        pressed = (system.terms.force * normal).sum(axis=1) + change
        step *= min(1.0, _LARGEST_STEP * self.sheet.reach / max(float(np.abs(step).max()), 1e-300))
        part = self._part_that_descends(depth, places, system, step, careful) if careful else 1.0
        step *= part
        # On a flat facet a taut sheet lies without pressing: rounding must not decide there.
        flat = near.facet is not None
        chosen = (self.punch.near(places + step, depth).gap < (-_GAP_TOLERANCE if flat else 0.0)) & self._movable
        chosen[nodes] = pressed > (-_FLAT * float(np.abs(pressed).max(initial=0.0)) if flat else 0.0)
        return step, chosen, part

    def _is_slack(self, system: _Linearised) -> bool:
        """Whether the sheet carries nothing and the punch is nowhere inside it."""
        # A law that is not stable has less energy than none where it is stretched far.
        return abs(system.sheet.energy) < self._no_energy and float(system.near.gap.min()) > -_GAP_TOLERANCE

    @property
    def _no_energy(self) -> float:
        return _SLACK_ENERGY * self.sheet.modulus * self.sheet.thickness * float(self.sheet.mesh.weights.sum())

    def _part_that_descends(self, depth: float, places: Array, system: _Linearised, step: Array, grip: Grip) -> float:
        """Return the part of a step (1, 1/2, 1/4, ...) that lowers the energy and what contact counts beside it."""
        up, force, normal = np.array([0.0, 0.0, depth]), system.terms.force, system.near.normal[system.nodes]
        beside = partial(counted, grip, system.nodes, force, normal)
        # In a sheet that carries nothing there is nothing to lower, and nodes are still to come out of the punch.
        now, part = max(system.sheet.energy + beside(places - up, system.near), self._no_energy), 1.0
        while part > _SMALLEST_PART:
            moved = places + part * step
            energy = self.sheet.energy(moved) / self.sheet.mesh.copies
            if energy + beside(moved - up, self.punch.near(moved, depth)) < now:
                break
            part *= 0.5
        return part

    def _state(
        self,
        depth: float,
        places: Array,
        touching: Flags,
        system: _Linearised,
        iteration: int,
        rubbing: tuple[Memory, Array, Grip],
    ) -> State:
        copies = self.sheet.mesh.copies
        pressure = np.zeros(len(places))
        nodes = np.flatnonzero(touching)
        forces = system.terms.force if len(nodes) else np.zeros((0, 3))
        pressure[nodes] = (forces * system.near.normal[nodes]).sum(axis=1)
        before, anchors, grip = rubbing
        whole = system.sheet.force
        # What the symmetry lines carry is no contact force.
        pull = np.where(self.sheet.pattern.free, whole, 0.0)
        return State(
            depth=depth,
            places=places,
            touching=touching,
            pressure=pressure,
            energy=copies * system.sheet.energy,
            force=copies * float(forces[:, 2].sum()),
            reaction=-copies * float(whole[self.sheet.mesh.rim, 2].sum()),
            residual=system.worst,
            iterations=iteration,
            memory=remembered(before, anchors, depth, places, system.near, touching, pull, grip.sticking),
        )
