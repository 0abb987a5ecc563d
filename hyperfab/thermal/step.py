"""One time step: Alexander's SDIRK2 (SIAM J. Numer. Anal. 14 (1977) 1006), L-stable, of second order.

Both stages have the same matrix. The error estimate compares with weights of third order (for linear problems) on
the two stages and the flow at the start, filtered through the stage matrix so that stiff parts do not spoil it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, overload

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.numerics.vectors import norm
from hyperfab.thermal.condition import Prescribed

GAMMA = 1.0 - 1.0 / math.sqrt(2.0)

#: Weights of third order on (start, stage 1, stage 2): they satisfy sum b = 1, sum b c = 1/2, sum b a c = 1/6.
_B1 = (1.0 / 6.0 - 0.25) / (GAMMA**2 - 0.5 * GAMMA)
_B2 = 0.5 - GAMMA * _B1
_ERROR = (1.0 - _B1 - _B2, _B1 - (1.0 - GAMMA), _B2 - GAMMA)


class Flows(Protocol):
    """A boundary condition, as a step asks it."""

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the heat flow into the body [W]."""


class Model(Protocol):
    """What a step asks of a mold: by nodes (``HeatModel``), or by the coordinates of a basis (``ProjectedModel``)."""

    free: Flags
    last_matrix: Any
    prescribed: Sequence[Prescribed]

    @property
    def conditions(self) -> Sequence[Flows]:
        """Return the boundary conditions."""

    def stored(self, temperature: Array) -> Array:
        """Return the heat stored [J]."""

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the heat flow [W]."""

    def total(self, by_node: Array) -> float:
        """Return heat or flow of the whole mold."""

    def moved(self, stored: Array) -> float:
        """Return how much of a change of the stored heat has changed its place [J]."""

    def hold(self, time: float, temperature: Array) -> Array:
        """Return the temperatures with those held set to their values."""

    def solve_stage(
        self,
        time: float,
        interval: float,
        target: Array,
        guess: Array,
        *,
        reference: float | None,
    ) -> tuple[Array, float]:
        """Solve E(T) - interval f(time, T) = target."""

    def solve(self, matrix: Any, right: Array, tolerance: float) -> Array:
        """Solve with the last stage's matrix."""

    def changed(self) -> None:
        """Forget the matrices: a condition was switched."""

    def capacity_norm(self, field: Array) -> float:
        """Return the root of the mean square [K]."""

    def speed(self, rate: Array) -> float:
        """Return how fast a change of the flow heats [K/s]."""


@dataclass(frozen=True)
class State:
    """Temperatures (n,) [degC], the heat stored at each node and its rate of change [J, W] at ``time`` [s].

    ``slope`` [K/s] is how fast the temperatures change, ``bend`` [K/s^2] how fast that does, where a step has found
    them and nothing has jumped since.
    """

    time: float
    temperature: Array
    stored: Array
    rate: Array
    slope: Array | None = None
    bend: Array | None = None


@dataclass(frozen=True)
class Stage:
    """Temperatures (n,) [degC] at ``time`` [s], and the rate of the stored heat [W], that stand for ``lasts`` [s]."""

    time: float
    temperature: Array
    rate: Array
    lasts: float


@dataclass(frozen=True)
class Step:
    """A step taken: the state at its end, its stages, and the estimated error [K] where it was asked for.

    ``moved`` is the heat that changed its node [J], ``residual`` the largest residual of its stages [K].
    """

    state: State
    stages: tuple[Stage, Stage]
    error: float
    moved: float
    residual: float

    def entered(self, model: Model) -> Array:
        """Return the heat that entered through each condition of its model, then each group of held nodes [J]."""
        return np.sum(
            [one.lasts * _entering(model, one.time, one.temperature, one.rate) for one in self.stages], axis=0
        )


def initial_state(model: Model, time: float, temperature: Array) -> State:
    """Return the state at the start; held nodes keep their start temperature until the first step."""
    rate = model.flow(time, temperature)
    return State(time, temperature, model.stored(temperature), rate)


def take_step(
    model: Model,
    start: State,
    length: float,
    *,
    estimate: bool = True,
    guesses: tuple[Array, Array] | None = None,
) -> Step:
    """Advance by ``length`` [s], with an ``estimate`` of the error; NotConverged where a stage does not settle.

    ``guesses`` are by how much the temperatures change to each stage (n,) [K], where something foretells it.
    """
    g = GAMMA * length
    t1, t2 = start.time + g, start.time + length
    ahead: Array | float = 0.0 if start.slope is None else g * start.slope
    if start.bend is not None:
        ahead += g**2 * start.bend
    reference = g * norm(start.rate * model.free)
    guess = model.hold(t1, start.temperature + (ahead if guesses is None else guesses[0]))
    first, residual1 = model.solve_stage(t1, g, start.stored, guess, reference=reference or None)
    stored1 = model.stored(first)
    rate1 = (stored1 - start.stored) / g
    slope1 = (first - start.temperature) / g
    target = start.stored + (length - g) * rate1
    ahead = length * slope1
    if start.slope is not None:
        ahead += (0.5 * length / g - 1.0) * length * (slope1 - start.slope)
    guess = model.hold(t2, start.temperature + (ahead if guesses is None else guesses[1]))
    reference = g * norm(rate1 * model.free)
    second, residual2 = model.solve_stage(t2, g, target, guess, reference=reference or None)
    stored2 = model.stored(second)
    rate2 = (stored2 - target) / g
    slope2 = (second - start.temperature - (length - g) * slope1) / g
    gone_through = Stage(t1, first, rate1, length - g), Stage(t2, second, rate2, g)
    error = _error(model, start, length, rate1, rate2) if estimate else math.nan
    state = State(t2, second, stored2, rate2, slope2, (slope2 - slope1) / (length - g))
    moved = model.moved(stored2 - start.stored)
    return Step(state, gone_through, error, moved, max(residual1, residual2))


@overload
def along(rise: float, begin: float, end: float, share: float) -> tuple[float, float]: ...
@overload
def along(rise: Array, begin: Array, end: Array, share: float) -> tuple[Array, Array]: ...
@overload
def along(rise: float, begin: float, end: float, share: Array) -> tuple[Array, Array]: ...
def along(rise: Any, begin: Any, end: Any, share: Any) -> tuple[Any, Any]:
    """Return how far a cubic has risen at a ``share`` of a step, and its slope there.

    ``rise`` is its rise over the whole step, ``begin`` and ``end`` its slopes, of the whole step as well.

    >>> along(1.0, 0.0, 0.0, 0.5)
    (0.5, 1.5)
    """
    rest = 1.0 - share
    risen = rise * share**2 * (1.0 + 2.0 * rest) + begin * share * rest**2 - end * share**2 * rest
    slope = 6.0 * rise * share * rest + begin * rest * (1.0 - 3.0 * share) + end * share * (share - 2.0 * rest)
    return risen, slope


def stages(change: Array, slope: Array, length: float) -> tuple[Array, Array]:
    """Return the changes to the stages of a step of ``length`` [s], from that to its end and the ``slope`` there."""
    g = GAMMA * length
    return g * (change - g * slope) / (length - g), change


def _entering(model: Model, time: float, temperature: Array, rate: Array) -> Array:
    """Return the power through each condition, and through each group of held nodes as their imbalance."""
    through = [model.total(condition.flow(time, temperature)) for condition in model.conditions]
    if model.prescribed:
        reaction = rate - model.flow(time, temperature)
        done = model.free.copy()
        for held in model.prescribed:
            mine = held.nodes[~done[held.nodes]]
            through.append(float(reaction[mine].sum()))
            done[mine] = True
    return np.array(through)


def _error(model: Model, start: State, length: float, rate1: Array, rate2: Array) -> float:
    """Return the estimated error of the step, root of the mean square over the heat capacity [K]."""
    right = length * (_ERROR[0] * start.rate + _ERROR[1] * rate1 + _ERROR[2] * rate2)
    right[~model.free] = 0.0
    assert model.last_matrix is not None
    difference = model.solve(model.last_matrix, right, 1e-3)
    return model.capacity_norm(difference)
