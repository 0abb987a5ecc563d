"""Design aids: the power for a wanted warm-up time, and the shares of the heaters for an even surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.condition import Heater
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.tables import Table

#: The wanted warm-up time is met to this share.
TIME_TOLERANCE = 1e-4
MOST_RUNS = 15
#: Shares are found anew about the state they lead to until no power moves by more than this share of the total.
SHARE_TOLERANCE = 1e-4
MOST_ROUNDS = 8


@dataclass(frozen=True)
class Shared:
    """Heater powers [W] and the steady spread of the surface [K] before and with them, and its mean [degC]."""

    powers: Array
    spread_before: float
    spread: float
    mean: float


def scaled(heater: Heater, factor: float) -> Table:
    """Return the heater's power times a factor."""
    return Table(heater.power.x, factor * heater.power.y)


def scale_for_warmup(wanted: float, warmup: Callable[[float], float | None]) -> tuple[float, int]:
    """Return the factor on all powers with which the target is reached in ``wanted`` [s], and the runs it took.

    ``warmup`` gives the time for a factor, None where the target is never reached. One over the time is nearly
    linear in the power, so false position on it is quick. Raises NotConverged where no power up to a thousandfold
    does it.

    >>> factor, runs = scale_for_warmup(100.0, lambda s: 300.0 / (s - 0.5) if s > 0.5 else None)
    >>> round(factor, 3), runs < 6
    (3.5, True)
    """
    rate = 1.0 / wanted
    times: dict[float, float | None] = {0.0: None}

    def miss(factor: float) -> float:
        time = times[factor] = warmup(factor)
        return (0.0 if time is None else (1.0 / time if time > 0.0 else np.inf)) - rate

    low, high = 0.0, 1.0
    low_miss, high_miss = -rate, miss(1.0)
    runs = 1
    while high_miss < 0.0:
        low, low_miss = high, high_miss
        high *= float(np.clip(rate / (high_miss + rate), 1.3, 2.5)) if high_miss > -rate else 2.0
        high_miss = miss(high)
        runs += 1
        if high > 1e3:
            raise NotConverged("no power reaches the target in the wanted time", remedy="ask for a longer one")
    best, best_miss, side = high, high_miss, 0
    while abs(best_miss) > TIME_TOLERANCE * rate and runs < MOST_RUNS:
        best = high - high_miss * (high - low) / (high_miss - low_miss)
        best_miss = miss(best)
        runs += 1
        if best_miss >= 0.0:
            high, high_miss = best, best_miss
            low_miss *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            low, low_miss = best, best_miss
            high_miss *= 0.5 if side < 0 else 1.0
            side = -1
    if abs(best_miss) > 100 * TIME_TOLERANCE * rate:
        slow = times[low]
        raise NotConverged(
            f"the power for a warm-up of {wanted:g} s was not found: {high:.6g} times what is given takes "
            f"{times[high] or 0.0:.4g} s, {low:.6g} times {'never gets there' if slow is None else f'{slow:.4g} s'}",
            remedy="ask for a shorter one: near its rest a mold's time says nothing of its power",
        )
    return best, runs


def share_power(
    model: HeatModel,
    surface: FacetOperator,
    start: Array,
    *,
    most: float | None = None,
    mean: float | None = None,
) -> Shared:
    """Set the heaters to the powers that make a surface most even in the steady state.

    The sum of the powers is kept, or, with ``mean`` [degC], the surface's mean temperature is that; no heater gives
    more than ``most`` [W] or less than nothing. The state is linear in the powers but for films and radiation:
    least spread is a linear program, solved about each new state until the powers stay. Raises NotConverged where
    the bounds leave no solution.
    """
    heaters: Sequence[Heater] = model.heaters
    powers = np.array([heater.power_at(0.0) for heater in heaters])
    total = float(powers.sum())
    nodes = surface.all_nodes
    weights = surface.mean_weights
    temperature, _ = model.solve_steady(0.0, model.hold(0.0, start))
    before = surface.evenness(temperature).spread
    for _ in range(MOST_ROUNDS):
        matrix = model.steady_matrix(0.0, temperature)
        answers = np.stack([model.solve(matrix, heater.shape * model.free, 1e-8) for heater in heaters], axis=1)
        moved = _least_spread(
            temperature[nodes],
            answers[nodes],
            powers,
            most,
            np.ones(len(heaters)) if mean is None else weights @ answers,
            0.0 if mean is None else mean - dot(weights, temperature),
        )
        powers = powers + moved
        for heater, power in zip(heaters, powers, strict=True):
            heater.power = Table.constant(float(power))
        temperature, _ = model.solve_steady(0.0, model.hold(0.0, temperature))
        if np.abs(moved).max() <= SHARE_TOLERANCE * max(total, float(powers.sum())):
            break
    found = surface.evenness(temperature)
    return Shared(powers, before, found.spread, found.mean)


def _least_spread(now: Array, answers: Array, powers: Array, most: float | None, row: Array, wanted: float) -> Array:
    """Return the change of the powers that makes max - min of ``now + answers change`` least, row . change = wanted."""
    from scipy.optimize import linprog  # 0.1 s to load: only a design needs it

    count = len(powers)
    above = np.column_stack([answers, -np.ones(len(now)), np.zeros(len(now))])
    below = np.column_stack([-answers, np.zeros(len(now)), np.ones(len(now))])
    bounds = [(-p, None if most is None else most - p) for p in powers] + [(None, None)] * 2
    found = linprog(
        np.concatenate([np.zeros(count), [1.0, -1.0]]),
        A_ub=np.concatenate([above, below]),
        b_ub=np.concatenate([-now, now]),
        A_eq=np.concatenate([row, [0.0, 0.0]])[None, :],
        b_eq=[wanted],
        bounds=bounds,
        method="highs",
    )
    if found.x is None:
        raise NotConverged(
            "no powers within the bounds keep the total, or reach the mean",
            remedy="allow more power a heater",
        )
    return np.asarray(found.x[:count])
