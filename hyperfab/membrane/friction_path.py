"""The sphere test with friction: one mesh for the whole path, because an equilibrium hangs on how it was reached."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil

import numpy as np

from hyperfab.membrane.contact_edge import contact_edge
from hyperfab.membrane.equilibrium import Press, State
from hyperfab.membrane.path import Followed, Path, Watch, follow
from hyperfab.membrane.sphere_contact import Outcome, Solved, SphereTest, fitted_mesh, press_on, rough_path

#: Load steps of a path with friction, at least. Coulomb's force hangs little on it, full stick is of first order.
LOAD_STEPS = 40


def run_with_friction(
    tests: Sequence[SphereTest],
    depths: Sequence[float],
    watch: Watch = lambda state: None,
    followed: Followed = lambda paths: None,
) -> list[Outcome]:
    """Press several sheets that differ in their law alone, all with the same friction, on one mesh.

    The path is followed on a rough mesh, and again on a mesh that is fine wherever the edge of contact came by.
    Where the step's length counts (full stick) the rough path is followed with steps of half the length too, and
    ``Outcome.extrapolated`` is the force to which ever shorter steps lead. ``followed`` sees the rough paths.
    """
    parts = ceil(LOAD_STEPS / len(depths))
    steps = _divided(depths, parts)
    roughs = [rough_path(test, steps, watch) for test in tests]
    followed([path for _, path in roughs])
    edges = [
        edge
        for press, path in roughs
        for state in _rows(path, depths)
        if (edge := contact_edge(press, state)) is not None
    ]
    if not edges:
        return [_outcome(press, path, depths) for press, path in roughs]
    mesh = fitted_mesh(tests[0], edges)
    outcomes = []
    for test, (_, rough_way) in zip(tests, roughs, strict=True):
        press = press_on(test, mesh)
        outcome = _outcome(press, follow(press, steps, watch), depths)
        outcome.path.iterations += rough_way.iterations
        if outcome.solved and rough_way.states:
            _judge(test, outcome, rough_way, _divided(depths, 2 * parts), watch)
        outcomes.append(outcome)
    return outcomes


def _divided(depths: Sequence[float], parts: int) -> list[float]:
    """Return the depths and, between them, ``parts`` equal steps each."""
    ends = [0.0, *depths]
    return [float(depth) for start, end in pairwise(ends) for depth in np.linspace(start, end, parts + 1)[1:]]


def _rows(path: Path, depths: Sequence[float]) -> list[State]:
    """Return the states at the depths asked for, and the last one where a path ended early."""
    found = [state for state in path.states if any(abs(state.depth - depth) < 1e-9 for depth in depths)]
    if path.states and (not found or found[-1] is not path.states[-1]):
        found.append(path.states[-1])
    return found


def _outcome(press: Press, path: Path, depths: Sequence[float]) -> Outcome:
    solved = [Solved(press, state) for state in _rows(path, depths)]
    return Outcome(press, path, solved, trace=[(state.depth, state.force) for state in path.states])


def _judge(test: SphereTest, outcome: Outcome, rough: Path, halves: Sequence[float], watch: Watch) -> None:
    """Estimate the error of the last force from the rough mesh and, for stick, from shorter steps."""
    last = outcome.solved[-1].state
    same = [state for state in rough.states if abs(state.depth - last.depth) < 1e-9]
    if not same or last.force <= 0.0:
        return
    error = abs(last.force - same[0].force) / last.force / 3.0
    if test.friction.holds:
        _, shorter = rough_path(test, halves, watch)
        finer = [state for state in shorter.states if abs(state.depth - last.depth) < 1e-9]
        if finer:
            growth = 2.0 * (finer[0].force - same[0].force)
            outcome.extrapolated = last.force + growth
            error += abs(growth) / last.force
    outcome.solved[-1] = Solved(outcome.solved[-1].press, last, error)
