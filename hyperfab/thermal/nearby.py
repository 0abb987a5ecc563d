"""Runs beside one that a mold has gone through: in its own states, and what it answers to what is changed.

The basis holds the states of the run, and for every change the answer to what it makes flow, within a few spans of time
(rational Krylov vectors; Grimme 1997). Runs on it take the steps that the run took, up to the target, so that what they
differ by is what was changed: neither meshes nor steps that choose themselves stand between.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.history import History, Ledger, Target
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.medium import Medium
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.projected import ProjectedMedium, ProjectedModel
from hyperfab.thermal.projected_condition import Face, Together, scaled, warmer
from hyperfab.thermal.radiation import Radiation
from hyperfab.thermal.step import State, initial_state, take_step
from hyperfab.thermal.tables import Table
from hyperfab.thermal.trail import Lift, Trail, examples
from hyperfab.thermal.transient import shortened

#: Spans of time of the answers, as shares of the run.
SPANS = (0.5, 0.06, 0.008)
#: How sharply they are solved for: they are directions.
SOLVE = 1e-3
#: Directions in which vectors of length 1 differ by less are left out.
DROP = 1e-6
#: Steps past the last one of the run until the target counts as not reached.
MORE = 40


@dataclass(frozen=True)
class Change:
    """What is another thing than in the run.

    ``flow`` are factors on the flow of conditions, ``ambient`` [K] how much warmer their surroundings are, by the
    number of the condition; ``conductivity`` and ``capacity`` are factors by the number of the material among the
    model's, ``start`` [K] by the number of the part; ``film`` by how many standard deviations a condition's film is
    off.
    """

    flow: Mapping[int, float] = field(default_factory=dict)
    ambient: Mapping[int, float] = field(default_factory=dict)
    conductivity: Mapping[str, float] = field(default_factory=dict)
    capacity: Mapping[str, float] = field(default_factory=dict)
    start: Mapping[int, float] = field(default_factory=dict)
    film: Mapping[int, float] = field(default_factory=dict)


class Neighbourhood:
    """A run of ``model``, from which those beside it are found; ``changes`` are units of what is to be changed."""

    def __init__(
        self,
        model: HeatModel,
        history: History,
        target: Target | None,
        stops: bool,
        changes: Sequence[Change],
    ) -> None:
        self._model, self._history, self._stops = model, history, stops
        self._times = [time for k, time in enumerate(history.states.times) if stops or k == 0 or k != history.reached]
        self._jumps = {history.states.times[k] for k in history.jumps}
        last = history.states[-1]
        uniform = len({material.name for material in model.materials}) == 1
        touched = {name for change in changes for name in (*change.conductivity, *change.capacity)}
        self._media = {name: model.medium if uniform else _of_material(model, name) for name in sorted(touched)}
        alike = Alike([last.temperature, *examples(history.states)])
        self.lift = Lift(last.temperature, self._basis(last.time, changes), alike)
        self._base = ProjectedModel(model, self.lift, last.time)
        self._parts = {
            name: self._base.medium if uniform else ProjectedMedium.of(medium, self.lift)
            for name, medium in self._media.items()
        }
        self._spreads = {
            number: Face(_spread(model, number), self.lift, last.time) for change in changes for number in change.film
        }
        self._start = self._coordinates(history.states[0].temperature - last.temperature)
        self._warmer = {part: self._coordinates(self._began(part)) for change in changes for part in change.start}
        self._target = target
        if target is not None:
            row, at_origin = self.lift.sensor(target.sensor)
            self._target = Target(row, target.value - at_origin)

    def run(self, change: Change) -> History:
        """Return the run with a change: as far as to the target, or to the end it had."""
        model = self._changed(change)
        start = self._start + sum(by * self._warmer[part] for part, by in change.start.items())
        state = initial_state(model, 0.0, np.asarray(start))
        trail = Trail()
        trail.append(state, self.lift)
        history = History(trail, Ledger.begin(self._model, model.total(state.stored)))
        target = self._target
        if target is not None and dot(target.sensor, state.temperature) >= target.value:
            history.reached = 0
        times = list(self._times)
        if self._stops and len(times) > 2:
            # The last step was shortened to the target: it may end elsewhere now.
            length = max(times[-1] - times[-2], times[-2] - times[-3])
            times[-1:] = [times[-2] + length * k for k in range(1, MORE)]
        for time in times[1:]:
            while state.time < time:
                step = take_step(model, state, time - state.time, estimate=False)
                waiting = target is not None and history.reached is None
                hit = waiting and target is not None and dot(target.sensor, step.state.temperature) >= target.value
                if hit and target is not None:
                    watched = target
                    step = shortened(model, state, step, lambda x: dot(watched.sensor, x) - watched.value)  # noqa: B023
                else:
                    step = replace(step, state=replace(step.state, time=time))
                state = step.state
                history.states.append(state, self.lift)
                history.ledger.add(step.entered(model), model.total(state.stored), step.moved)
                if hit:
                    history.reached = len(history.states) - 1
                    if self._stops:
                        return history
            if time in self._jumps:
                history.jumps.append(len(history.states) - 1)
                state = State(time, state.temperature, state.stored, model.flow(time, state.temperature))
        return history

    def _changed(self, change: Change) -> ProjectedModel:
        medium = self._base.medium
        for name in {*change.conductivity, *change.capacity}:
            more = change.capacity.get(name, 1.0) - 1.0, change.conductivity.get(name, 1.0) - 1.0
            medium = medium.with_more(self._parts[name], *more)
        conditions = list(self._base.conditions)
        spreads = dict(self._spreads)
        for number, kelvin in change.ambient.items():
            face = conditions[number]
            assert isinstance(face, Face)
            conditions[number] = face.warmer(kelvin)
            if number in spreads:
                spreads[number] = spreads[number].warmer(kelvin)
        for number, by in change.film.items():
            conditions[number] = Together((conditions[number], scaled(spreads[number], by)))
        for number, by in change.flow.items():
            conditions[number] = scaled(conditions[number], by)
        return self._base.changed_to(medium, conditions)

    def _began(self, part: int) -> Array:
        """Return by how much the start of each node (n,) follows that of a part."""
        solid = self._model.mesh.solid
        found = np.zeros(self._model.size)
        found[:solid] = self._model.medium.joined(np.eye(len(self._model.materials))[part] + np.zeros((solid, 1)))
        return found

    def _coordinates(self, nodal: Array) -> Array:
        model = self._model
        capacity = model.pattern.matrix(model.medium.capacity(nodal))
        return np.asarray(np.linalg.solve(self._base.mass, self.lift.basis.T @ (capacity @ nodal)))

    def _basis(self, end: float, changes: Sequence[Change]) -> Array:
        """Return vectors (n, r), orthonormal in the heat capacity, the first one uniform."""
        model, states = self._model, self._history.states
        origin = states[-1].temperature
        columns = []
        for k in range(len(states) - 1):
            past, after = states[k], states[k + 1]
            columns.append(past.temperature - origin)
            if after.slope is not None:
                columns.append((after.time - past.time) * after.slope)
        columns += [self._began(part) for change in changes for part in change.start]
        loads: list[Array] = []
        for change in changes:
            for load in self._loads(change):
                _take(loads, load)
        for span in SPANS:
            matrix = model.step_matrix(end, span * end, origin)
            columns += [model.solve(matrix, load, SOLVE) for load in loads]
        capacity = model.pattern.matrix(model.medium.capacity(origin))
        total = float(capacity.sum())
        uniform = np.full(len(origin), 1.0 / np.sqrt(total))
        held = capacity @ uniform
        basis = np.stack(columns, axis=1)
        size = np.sqrt(np.maximum(np.einsum("nr,nr->r", basis, capacity @ basis), 0.0))
        basis = basis[:, size > 0.0] / size[size > 0.0]
        for threshold in (DROP, 0.0):  # once more, against rounding
            basis = basis - uniform[:, None] * (held @ basis)
            gram = basis.T @ (capacity @ basis)
            values, axes = np.linalg.eigh(0.5 * (gram + gram.T))
            keep = np.flatnonzero(values > threshold**2)[::-1]
            basis = (basis @ axes[:, keep]) / np.sqrt(values[keep])
        return np.ascontiguousarray(np.column_stack([uniform, basis]))

    def _loads(self, change: Change) -> list[Array]:
        """Return what a change makes flow or store, in the middle of the run and at its end."""
        model, states = self._model, self._history.states
        found: list[Array] = []
        for past in (states[-1], states[len(states) // 2]):
            time, at = past.time, past.temperature
            load = np.zeros(model.size)
            for number in change.flow:
                load += model.conditions[number].flow(time, at)
            for number, kelvin in change.ambient.items():
                condition = model.conditions[number]
                assert isinstance(condition, Convection | Radiation)
                load += warmer(condition, kelvin).flow(time, at) - condition.flow(time, at)
            for number in change.film:
                load += _spread(model, number).flow(time, at)
            for name in change.conductivity:
                medium = self._media[name]
                load += medium.pattern.matrix(medium.conduction(at)) @ (at - at.mean())
            for name in change.capacity:
                medium = self._media[name]
                if past.slope is not None:
                    load += medium.pattern.matrix(medium.capacity(at)) @ past.slope
            for part in change.start:
                began = self._began(part)
                for condition in model.conditions:
                    if isinstance(condition, Convection | Radiation):
                        load += condition.flow(time, at + began) - condition.flow(time, at)
            found.append(load)
        return found


def _take(loads: list[Array], load: Array) -> None:
    """Add a load to others but where it is nothing, or one of them over again."""
    known = any(abs(dot(load, other)) > (1.0 - 1e-9) * _size(load) * _size(other) for other in loads)
    if load.any() and not known:
        loads.append(load)


def _size(load: Array) -> float:
    return float(np.sqrt(dot(load, load)))


def _spread(model: HeatModel, number: int) -> Convection:
    """Return a film with its standard deviation as coefficient."""
    film = model.conditions[number]
    assert isinstance(film, Convection)
    return Convection(film.name, film.facets, film.film.spread, film.ambient)


def _of_material(model: HeatModel, name: str) -> Medium:
    """Return the medium with nothing but the parts of one material."""
    nothing = Table.constant(0.0)
    materials = [
        one if one.name == name else replace(one, conductivity=nothing, specific_heat=nothing)
        for one in model.materials
    ]
    return Medium(model.mesh, materials, model.pattern, 0.0 * model.loose)
