"""What a sphere test says of itself and of its constants: energy balance, first instability, difference of two laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.membrane.equilibrium import NoEquilibriumError, Press, State
from hyperfab.membrane.path import cold_start, taut_at
from hyperfab.membrane.recovery import recovered_strain
from hyperfab.membrane.sphere_contact import Outcome, Solved
from hyperfab.membrane.work import work as path_work

_SEARCH_ROUNDS = 30
#: The depth of the first instability is found to this part of itself.
_SEARCH_TOLERANCE = 1e-4


@dataclass(frozen=True)
class Instability:
    """Where the constants first break Drucker's condition: ``depth`` [mm], undeformed place [mm], stretches there."""

    depth: float
    at: tuple[float, float]
    stretches: tuple[float, float]


def first_instability(outcome: Outcome) -> Instability | None:
    """Return where the law is first unstable over the stretches that occur in the sheet, or None."""
    stable = 0.0
    for solved in outcome.solved:
        if _margin(solved.press, solved.state)[0] < 0.0:
            return _located(outcome, stable, solved)
        stable = solved.state.depth
    return None


def _margin(press: Press, state: State) -> tuple[float, int]:
    """Return the least stability margin over the nodes, and the node."""
    strain = recovered_strain(press.sheet.mesh, state.places)
    found = press.sheet.law.margin(strain)
    node = int(np.nanargmin(np.where(np.isnan(found), np.inf, found)))
    return float(found[node]), node


def _located(outcome: Outcome, stable: float, unstable: Solved) -> Instability:
    """Search the first unstable depth between a stable and an unstable one, on the rough mesh."""
    low, high = stable, unstable.state.depth
    press, state, start = unstable.press, unstable.state, None
    for known in sorted((footing.state for footing in outcome.path.footings), key=lambda one: one.depth):
        if known.depth <= low:
            start = known
        elif known.depth < high:
            if _margin(outcome.rough, known)[0] < 0.0:
                high, press, state = known.depth, outcome.rough, known
                break
            low, start = known.depth, known
    for _ in range(_SEARCH_ROUNDS):
        if high - low < _SEARCH_TOLERANCE * high:
            break
        middle = 0.5 * (low + high)
        try:
            if start is None or start.force == 0.0:
                found = cold_start(outcome.rough, middle)
            else:
                found = outcome.rough.equilibrium(middle, start.places, start.touching)
        except NoEquilibriumError:
            break
        if _margin(outcome.rough, found)[0] < 0.0:
            high, press, state = middle, outcome.rough, found
        else:
            low, start = middle, found
    _, node = _margin(press, state)
    strain = recovered_strain(press.sheet.mesh, state.places)[[node]]
    stretch = press.sheet.law.principal(strain).stretch[0]
    place = press.sheet.mesh.nodes[node]
    return Instability(high, (float(place[0]), float(place[1])), (float(stretch[0]), float(stretch[1])))


def work(outcome: Outcome) -> float:
    """Return the work of the punch [N mm] up to the last depth."""
    limit, trace = outcome.path.limit, outcome.trace
    return path_work(trace, limit.turning_point if limit else None, taut_at(outcome.rough, trace))


def stress_difference(first: Solved, second: Solved) -> tuple[float, Array]:
    """Return e = 100 max|sB - sA| / max|sA| and, at each node (n,), the larger |sB - sA| [MPa] of the two stresses.

    Both are solved on the same mesh, so that nodes are the same material points.
    """
    a = first.fields.cauchy
    b = second.fields.cauchy
    difference = np.abs(b - a).max(axis=1)
    largest = float(np.abs(a).max())
    return 100.0 * float(difference.max()) / largest if largest > 0.0 else 0.0, difference
