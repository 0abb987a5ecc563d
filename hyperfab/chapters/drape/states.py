"""The sheet at each depth asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hyperfab.cases.drape import DYNAMIC_STEPS, LOAD_STEPS, RELAXATION_STEPS
from hyperfab.chapters.drape.model import Model
from hyperfab.cloth import Answers, Equilibrium, Mold, Rest, Step, answers, drape, follow, load_steps, raised
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.relaxation import relax
from hyperfab.cloth.start import lowered


@dataclass(frozen=True)
class State:
    """The sheet at one depth of the mold; ``rest``: what rubbing took on the way, where something rubs."""

    depth: float
    mold: Mold
    found: Equilibrium
    fields: Answers
    rest: Rest | None = None


def at_depths(model: Model, report: Callable[[float, Step], None]) -> Iterator[State]:
    """States at the depths that are wanted, until one finds no equilibrium.

    Without friction each depth is computed on its own: the equilibrium does not hang on the way there.
    Raises HeldNodeInside where the mold reaches a clamped node.
    """
    if model.case.has_friction:
        yield from _rubbing(model, report)
        return
    for depth in model.case.wanted:
        up = raised(model.mold, depth)

        def told(step: Step, depth: float = depth) -> None:
            report(depth, step)

        found = _solved(model, up, told)
        yield State(depth, up, found, answers(model.sheet, up, found))
        if not found.converged:
            return


def _solved(model: Model, mold: Mold, told: Callable[[Step], None]) -> Equilibrium:
    case, sheet = model.case, model.sheet
    if case.solver == "newton":
        return drape(sheet, mold, case.tolerance, told)
    start = lowered(sheet, mold)
    if case.solver == "dynamic":
        return swing(sheet, mold, start, case.tolerance, case.steps or DYNAMIC_STEPS, told)
    return relax(sheet, mold, start, case.divisor, case.tolerance, case.steps or RELAXATION_STEPS, told)


def _rubbing(model: Model, report: Callable[[float, Step], None]) -> Iterator[State]:
    case, sheet, mold = model.case, model.sheet, model.mold
    heights = load_steps(case.wanted, case.load_steps or LOAD_STEPS)
    wanted = np.array(case.wanted)
    reached = 0.0

    def told(step: Step) -> None:
        report(reached, step)

    for rest in follow(sheet, mold, heights, case.friction, case.tolerance, wanted, told):
        reached = rest.height
        if rest.found.converged and not np.isclose(wanted, rest.height, rtol=0.0, atol=1e-9).any():
            continue
        up = raised(mold, rest.height)
        yield State(rest.height, up, rest.found, answers(sheet, up, rest.found), rest)
