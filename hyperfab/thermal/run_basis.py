"""A basis for a long run of a mold: the states on the way, and what the mold answers to what jumps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array
from hyperfab.thermal.condition import Convection, Heater, Radiation, Thermostat
from hyperfab.thermal.history import History
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.projected import by_vector
from hyperfab.thermal.step import GAMMA, State
from hyperfab.thermal.trail import Lift, examples

#: Time scales of the answers to heaters, from the shortest stage to all that is left.
SCALES = 10
#: Directions in which the states differ by less, root of the mean square [K], are left out.
DROP = 1e-9
#: States that a basis is made of at most.
SNAPSHOTS = 100
#: How sharply the answers are solved for: they are directions.
SOLVE = 1e-6


def duration(history: History, now: float) -> float:
    """Return how long a stretch takes, the mean of the last few [s]."""
    before = [history.states.times[i] for i in history.jumps[-4:] if history.states.times[i] < now]
    return (now - before[0]) / len(before)


def lift_of(
    model: HeatModel,
    thermostats: Sequence[Thermostat],
    history: History,
    state: State,
    until: float,
    most: int,
) -> Lift:
    """Return the mold about ``state`` on ``most`` vectors or less, orthonormal in the heat capacity, the first uniform.

    They span the states that the history has in full, what the mold answers to each jump within the lengths of
    its steps (rational Krylov vectors), and where it drifts, up to ``until`` [s]. Grimme (1997), Krylov projection
    methods for model reduction.
    """
    origin = state.temperature
    most = min(most, len(origin))  # more than that are told apart by rounding alone
    capacity = model.pattern.matrix(model.medium.capacity(origin))
    first = max(len(history.states) - SNAPSHOTS, history.jumps[0] - 2, 1)
    columns, lengths, seen = [], [], []
    for i in range(first, len(history.states)):
        past = history.states[i]
        length = past.time - history.states.times[i - 1]
        if past.is_reduced or length <= 0.0:
            continue
        columns.append(past.temperature - origin)
        if past.slope is not None:
            columns.append(length * past.slope)
        lengths.append(length)
        seen.append(past)
    recent = lengths[-20:]
    stretch = duration(history, state.time)
    scales = np.geomspace(GAMMA * min(recent), max(until - state.time, stretch), SCALES)
    loads = _loads(model, thermostats, state.time)
    lost = [c.flow(state.time, origin) for c in model.conditions if not isinstance(c, Heater)]
    drift = capacity @ (columns[0] / (seen[0].time - state.time))
    for scale in scales:
        matrix = model.step_matrix(state.time, float(scale), origin)
        slow = [drift, *([np.sum(lost, axis=0)] if lost else [])] if scale > 0.5 * stretch else []
        answers = [model.solve(matrix, scale * load, SOLVE) for load in (*loads, *slow)]
        # A kelvin each: what a heater does in all that is left is no better a direction than what it does in a step.
        columns += [one / model.capacity_norm(one) for one in answers]
    uniform = np.full((len(origin), 1), 1.0 / np.sqrt(float(capacity.sum())))
    alike = Alike([origin, *examples(seen)])
    return Lift.with_room(origin, uniform, most, alike).wider(origin, beside_uniform(columns, capacity, DROP, most - 1))


def beside_uniform(columns: list[Array], capacity: sparse.csr_matrix, threshold: float, most: int) -> Array:
    """Return at most so many vectors that span ``columns`` together with the uniform one, as ``orthonormal`` does.

    The list of columns is emptied.
    """
    basis = np.empty((capacity.shape[0], len(columns)), order="F")
    for number in range(len(columns) - 1, -1, -1):  # each as large as a state: let go of one by one
        basis[:, number] = columns.pop()
    weights = np.asarray(capacity.sum(axis=0)).ravel() / float(capacity.sum())
    for least in (threshold, 0.0):  # once more, against rounding
        basis -= weights @ basis
        basis = orthonormal(basis, capacity, least, most)
    return basis


def orthonormal(vectors: Array, capacity: sparse.csr_matrix, threshold: float, most: int) -> Array:
    """Return at most so many vectors that span them, orthonormal in the heat capacity, the largest first."""
    _, gram = by_vector(vectors, capacity, 0)
    values, axes = np.linalg.eigh(0.5 * (gram + gram.T))
    keep = np.flatnonzero(values > threshold**2 * float(capacity.sum()))[::-1][:most]
    return np.asarray((vectors @ axes[:, keep]) / np.sqrt(values[keep]))


def _loads(model: HeatModel, thermostats: Sequence[Thermostat], time: float) -> list[Array]:
    """Return the loads [W] that jump or follow the clock; heaters that switch together are one."""
    together: dict[tuple[float, ...], Array] = {}
    alone: list[Array] = []
    asked = {id(one.heater): one for one in thermostats}
    for heater in model.heaters:
        load = float(np.abs(heater.power.y).max()) * heater.shape
        one = asked.get(id(heater))
        if one is None:
            if not heater.power.is_constant:
                alone.append(load)
            continue
        key = (float(id(one.sensor)), one.set_point, one.band)
        together[key] = together.get(key, 0.0) + load
    for condition in model.conditions:
        if isinstance(condition, Convection) and not condition.ambient.is_constant:
            reach = float(np.ptp(condition.ambient.y))
            alone.append(condition.facets.load(reach * condition.film.at(condition.ambient.at(time))))
        elif isinstance(condition, Radiation) and not condition.ambient.is_constant:
            alone.append(condition.facets.load(5.0 * float(np.ptp(condition.ambient.y))))
    return [*together.values(), *alone]
