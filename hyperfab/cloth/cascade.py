"""Equilibrium from a coarse grid to the fine one: each grid starts from the interpolated answer of the one before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array

from .depth import stands_out, vertices
from .dynamic import swing
from .mirror import mirrors
from .mold import Mold, raised
from .net import Sheet, X, Y
from .newton import equilibrium
from .start import lowered, refined, settled
from .state import Equilibrium, State, Step

#: The first grid has at most this many nodes a side; a few hundred unknowns find the contact at no cost.
COARSEST = 24
#: Residual to which the coarse grids are brought; their error of discretisation is far above it.
COARSE_TOLERANCE = 1e-4
#: Where no step of Newton's lowers the energy though the residual is below the first, the sheet swings for so many time
#: steps before Newton goes on; this often at most. Facets that meet in a valley can hold a node up between them.
NEARLY, SWINGS, ROUNDS = 1.0, 200, 3
#: A membrane whose first step on a finer grid is cut below this share swings for so many time steps first.
CUT, EASING = 0.5, 15
#: A membrane that its net does not lead to is pushed up in so many steps, halved down to one part in so many.
PUSHES, LEAST_PUSH = 8, 100
#: A mold that stands out through a grid by so many of its spacings has passed between its nodes.
PASSED = 2.0


class BeyondLaw(Exception):
    """The sheet would be stretched beyond what its law answers to."""


def grid_sizes(n: int, m: int) -> list[tuple[int, int]]:
    """Grids from the coarsest to n by m nodes, each with about half the spacing of the one before.

    Sides of an odd number of nodes stay odd, even ones even: a tip in the middle meets a node on all grids or on none.

    >>> grid_sizes(101, 50)
    [(27, 14), (51, 26), (101, 50)]
    """
    sizes = [(n, m)]
    while max(n, m) > COARSEST + 3:
        n, m = (_halved(k) for k in (n, m))
        sizes.append((n, m))
    return sizes[::-1]


def _halved(nodes: int) -> int:
    """Nodes of a side with about twice the spacing, odd or even as before."""
    half = max((nodes + 1) // 2, min(nodes, 3))
    return half + (half - nodes) % 2 if half < nodes else nodes


def _begun(sheet: Sheet, mold: Mold) -> State:
    """Where the first grid starts: lowered, and for a membrane where a net of its uniaxial laws comes to rest.

    Lowered, some cells are torn apart beyond what its law may answer to; a net's curves go on straight. Beside a free
    edge a membrane that is narrower than it would be by itself rests in wrinkles, at no cost: from the net, which is
    too wide, half steps come to its own width from above.
    """
    start = lowered(sheet, mold)
    if sheet.membrane is None:
        return start
    net = replace(sheet, membrane=None)  # sought as its membrane is, not among even shapes
    start = equilibrium(net, mold, start, COARSE_TOLERANCE, even_shapes=False, leaps=True).state
    if not np.isfinite(equilibrium(sheet, mold, start, COARSE_TOLERANCE, largest=0).energy):
        start = _pushed_up(sheet, mold)
    if all(bits & (X | Y) == X | Y for bits in sheet.edges):
        return start
    return equilibrium(sheet, mold, start, COARSE_TOLERANCE, longest=0.5).state


def _pushed_up(sheet: Sheet, mold: Mold) -> State:
    """Where a membrane rests that the mold is pushed into bit by bit: its law ends before the strains of its net do.

    Raises BeyondLaw where the law has no answer to a further push, however small.
    """
    depth = float(mold.bounds[0, 5])
    reached, push, state = 0.0, depth / PUSHES, None
    while reached < depth:
        push = min(push, depth - reached)
        up = raised(mold, reached + push - depth)
        if state is None:
            net = replace(sheet, membrane=None)
            start = equilibrium(net, up, lowered(sheet, up), COARSE_TOLERANCE, even_shapes=False, leaps=True).state
        else:
            x = state.x.copy()
            x[:, :, 2] *= (reached + push) / reached
            start = settled(x, up, sheet)
        found = equilibrium(sheet, up, start, COARSE_TOLERANCE)
        if np.isfinite(found.energy):
            reached, state = reached + push, found.state
        elif push < depth / LEAST_PUSH:
            raise BeyondLaw
        else:
            push *= 0.5
    if state is None:  # the mold only just touches the sheet
        raise BeyondLaw
    return state


def _eased(sheet: Sheet, mold: Mold, start: State, report: Callable[[Step], None] | None) -> tuple[State, list[Step]]:
    """Where Newton goes on from a coarser grid's answer, and the steps to there.

    Beside sharp edges the nodes between those of the coarser grid stand off the mold or across the edge. Where that
    cuts a membrane's first step, those that follow would be cut as well; a swing puts right what lies so near by.
    """
    tried = equilibrium(sheet, mold, start, COARSE_TOLERANCE, largest=1, report=report)
    if not tried.history or tried.history[-1].step_length >= CUT:
        return tried.state, tried.history
    swung = swing(sheet, mold, start, COARSE_TOLERANCE, EASING, report)
    return swung.state, tried.history + swung.history


def _passed(state: State, sheet: Sheet, mold: Mold, corners: Array) -> bool:
    """Whether part of the mold, a thin wall or a pin, has passed between the nodes of a sheet at rest.

    That takes one of its ``corners`` (k, 3) so high above the node next to it, seen from above (every second node
    tells); a net that is as steep has one too, so where one is found the net's cells are asked.
    """
    far = PASSED * max(sheet.spacing)
    nodes = state.x[::2, ::2].reshape(-1, 3)
    high = corners[corners[:, 2] > nodes[:, 2].min() + far]
    near = cKDTree(nodes[:, :2]).query(high[:, :2])[1]
    if not (high[:, 2] > nodes[near, 2] + far).any():
        return False
    return stands_out(state.x, sheet, mold)[0] > far


def _rested(
    grid: Sheet, mold: Mold, start: State, goal: float, last: bool, report: Callable[[Step], None] | None
) -> Equilibrium:
    """Where the sheet comes to rest on one grid, with the history of the way there; ``last``: the one asked for."""
    found = equilibrium(grid, mold, start, goal, report=report)
    history = list(found.history)
    net, sharp = grid.membrane is None, len(mold.creases.corners) > 0
    if sharp and net and not last:  # of several rests beside a sharp edge, the lower one
        other = equilibrium(grid, mold, start, goal, report=report, leaps=True)
        history += other.history
        found = min(found, other, key=lambda one: (not one.converged, one.energy))
    if not np.isfinite(found.energy):
        raise BeyondLaw
    for _ in range(ROUNDS):
        if found.converged or found.residual_relative > NEARLY:
            break
        swung = swing(grid, mold, found.state, goal, SWINGS, report)
        history += swung.history
        again = swung if swung.converged else equilibrium(grid, mold, swung.state, goal, report=report)
        history += [] if again is swung else again.history
        found = min(found, again, key=lambda one: one.residual_relative)
    # On the grid asked for a shape that leans may be, where no even one is found.
    if not found.converged and last and mirrors(grid, mold):
        free = equilibrium(grid, mold, start, goal, report=report, even_shapes=False, leaps=True)
        history += free.history
        found = min(found, free, key=lambda one: one.residual_relative)
    found.history = history
    return found


def drape(
    sheet: Sheet, mold: Mold, tolerance: float = 1e-6, report: Callable[[Step], None] | None = None
) -> Equilibrium:
    """Equilibrium of a flat sheet lowered onto a mold from above.

    Returns the state on the sheet's own grid, with the history of all grids. A grid starts from the answer of the one
    before, unless the mold has passed between the nodes of that: a wall with nodes on both sides of it comes back over
    none that is finer. Then, and where it passes on the way from there, the grid is lowered anew.
    Raises HeldNodeInside where the mold reaches a clamped node, BeyondLaw where a membrane has no answer to begin with.

    >>> from trimesh.creation import icosphere
    >>> from hyperfab.cloth import Sheet, drape, mold_of, piecewise_linear
    >>> from hyperfab.surface import Surface
    >>> ball = icosphere(subdivisions=3, radius=40.0)
    >>> mold = mold_of(Surface(ball.vertices - [0.0, 0.0, 35.0], ball.faces))
    >>> law = piecewise_linear([1.0, 2.0], [0.0, 1.0])
    >>> found = drape(Sheet(21, 21, (100.0, 100.0), 1.0, law, law), mold)
    >>> found.converged, bool(found.state.contact[10, 10])
    (True, True)
    """
    state, history, corners = None, [], vertices(mold)
    sizes = grid_sizes(sheet.n, sheet.m)
    for n, m in sizes:
        grid, last = sheet.coarser(n, m), (n, m) == sizes[-1]
        goal, passed = tolerance if last else max(tolerance, COARSE_TOLERANCE), True
        if state is not None:
            start = refined(state, grid, mold)
            if sheet.membrane is not None and len(mold.creases.corners) > 0:
                start, steps = _eased(grid, mold, start, report)
                history += steps
            found = _rested(grid, mold, start, goal, last, report)
            history += found.history
            passed = _passed(found.state, grid, mold, corners)
        if passed:
            found = _rested(grid, mold, _begun(grid, mold), goal, last, report)
            history += found.history
            passed = not last and _passed(found.state, grid, mold, corners)
        state = None if passed else found.state
    found.history = history
    return found
