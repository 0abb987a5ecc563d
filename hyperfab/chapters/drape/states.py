"""The sheet at each depth asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.drape.depths import load_steps
from hyperfab.cloth import Answers, Equilibrium, Mold, Rest, Sheet, Step, answers, drape, follow, raised
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.relaxation import relax
from hyperfab.cloth.start import lowered

#: By name: Newton's method on nested grids, dynamic relaxation, the report's relaxation.
SOLVERS = ("newton", "dynamic", "relaxation")
DYNAMIC_STEPS, RELAXATION_STEPS = 100_000, 400


@dataclass(frozen=True)
class Solver:
    """``name`` of SOLVERS; ``steps`` at most of the slow ones, ``divisor`` of the relaxation; ``load_steps`` where it
    rubs.
    """

    name: str
    tolerance: float
    steps: int | None
    divisor: float
    load_steps: int | None


@dataclass(frozen=True)
class State:
    """The sheet at one depth of the mold; ``rest``: what rubbing took on the way, where something rubs."""

    depth: float
    mold: Mold
    found: Equilibrium
    fields: Answers
    rest: Rest | None = None


def at_depths(
    sheet: Sheet,
    mold: Mold,
    depths: list[float],
    friction: float,
    solver: Solver,
    report: Callable[[float, Step], None],
) -> Iterator[State]:
    """States at the ``depths`` in mm, until one finds no equilibrium. ``mold`` touches the flat sheet.

    Without friction each depth is computed on its own: the equilibrium does not hang on the way there.
    Raises HeldNodeInside where the mold reaches a clamped node.
    """
    if friction > 0.0 or any(sheet.holder):
        yield from _rubbing(sheet, mold, depths, friction, solver, report)
        return
    for depth in depths:
        up = raised(mold, depth)

        def told(step: Step, depth: float = depth) -> None:
            report(depth, step)

        found = _solved(sheet, up, solver, told)
        yield State(depth, up, found, answers(sheet, up, found))
        if not found.converged:
            return


def _solved(sheet: Sheet, mold: Mold, solver: Solver, told: Callable[[Step], None]) -> Equilibrium:
    if solver.name == "newton":
        return drape(sheet, mold, solver.tolerance, told)
    start = lowered(sheet, mold)
    if solver.name == "dynamic":
        return swing(sheet, mold, start, solver.tolerance, solver.steps or DYNAMIC_STEPS, told)
    return relax(sheet, mold, start, solver.divisor, solver.tolerance, solver.steps or RELAXATION_STEPS, told)


def _rubbing(
    sheet: Sheet,
    mold: Mold,
    depths: list[float],
    friction: float,
    solver: Solver,
    report: Callable[[float, Step], None],
) -> Iterator[State]:
    heights = load_steps(depths, solver.load_steps)
    reached = 0.0

    def told(step: Step) -> None:
        report(reached, step)

    for rest in follow(sheet, mold, heights, friction, solver.tolerance, np.array(depths), told):
        reached = rest.height
        if rest.found.converged and not np.isclose(depths, rest.height, rtol=0.0, atol=1e-9).any():
            continue
        up = raised(mold, rest.height)
        yield State(rest.height, up, rest.found, answers(sheet, up, rest.found), rest)
