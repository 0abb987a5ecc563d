"""The sheet's path as the mold is pushed up in steps: what rubs remembers how it got there.

Without friction the equilibrium at a depth hangs on that depth alone, and ``cascade.drape`` finds it at once. With
friction on the mold or under a blank holder each load step starts from the one before: nodes on the mold are carried
up by it, the others go on as in the step before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array

from .cascade import drape
from .friction import STUCK, Friction
from .mold import FREE, Mold, raised
from .net import FIXED, Sheet
from .newton import equilibrium
from .start import settled
from .state import Equilibrium, State, Step

#: Steps in between are brought to this residual at least; the ones asked for to the tolerance.
BETWEEN = 1e-5
#: Free nodes nearer to the mold than this many steps' rise may land in the next one.
REACH = 3.0
#: A step that finds no equilibrium is halved at most this often.
HALVINGS = 4
#: Steps of Newton's method allowed from the step before, and from a sheet lowered without friction.
FEW, MANY = 25, 60


@dataclass(frozen=True)
class Rest:
    """Where the sheet rests at one height of the mold, and what it took to get there.

    ``work`` of the press and ``rubbed`` (on the mold) and ``drawn`` (under the blank holder) in N mm are sums over the
    ``steps`` of the way from height 0, where the energy was ``unstressed``.
    """

    height: float
    found: Equilibrium
    friction: Friction
    work: float
    rubbed: float
    drawn: float
    unstressed: float
    steps: int


def load_steps(depths: Sequence[float], steps: int) -> Array:
    """Heights of the mold at which a sheet that rubs comes to rest: about equal steps that meet all rising ``depths``.

    >>> load_steps([20.0, 60.0], 4).tolist()
    [20.0, 33.333333333333336, 46.66666666666667, 60.0]
    """
    if depths[-1] == 0.0:
        return np.zeros(1)
    pace = depths[-1] / steps
    heights, last = [], 0.0
    for depth in depths:
        count = max(1, round((depth - last) / pace)) if depth > last else 0
        heights += [last + (depth - last) * (k + 1) / count for k in range(count)]
        last = depth
    if depths[0] == 0.0:
        heights.insert(0, 0.0)
    return np.array(heights)


def follow(
    sheet: Sheet,
    mold: Mold,
    heights: Array,
    mu: float,
    tolerance: float = 1e-6,
    wanted: Array | None = None,
    report: Callable[[Step], None] | None = None,
    enough: float = 0.0,
) -> Iterator[Rest]:
    """Rest positions as ``mold``, whose top touches the flat sheet at height 0, is pushed up to ``heights`` mm.

    ``mu`` is the coefficient of Coulomb friction on the mold. Heights in ``wanted`` (default: the last) are brought to
    ``tolerance``, the others to a looser one. Ends early where no equilibrium is found, to ``enough`` where no
    step gets nearer.
    """
    wanted = heights[-1:] if wanted is None else wanted
    loaded = sheet.mass > 0.0
    flat = drape(clamped(sheet), mold, BETWEEN).state if loaded else settled(sheet.flat(), mold, sheet)
    rubbing = _rubbing(sheet, mold, flat, mu, 0.0)

    def asked_for(height: float) -> bool:
        return bool(np.isclose(wanted, height, rtol=0.0, atol=1e-9).any())

    # Neither stretched nor loaded it is at rest but for rounding, of which no step makes less.
    begun = not loaded and max(sheet.prestretch) <= 1.0 and not asked_for(0.0)
    found = equilibrium(sheet, mold, flat, tolerance, 0 if begun else None, report, rubbing)
    rest = Rest(0.0, found, rubbing, 0.0, 0.0, 0.0, found.energy, 0)
    before, pace = flat, 0.0
    lost = not begun and not found.converged and found.residual_relative > enough
    if 0.0 in heights or lost:
        yield rest
    if lost:
        return
    for height in heights[heights > 0.0]:
        goal = tolerance if asked_for(height) else max(tolerance, BETWEEN)
        done, rise, halved = rest.height, height - rest.height, 0
        while done < height - 1e-9:
            step = min(rise, height - done)
            ratio = step / pace if pace > 0.0 else 0.0
            after = _step(sheet, mold, rest, before, step, ratio, mu, goal, report, enough)
            reached = after.found.converged or after.found.residual_relative <= enough
            if not reached and halved < HALVINGS:
                rise, halved = 0.5 * step, halved + 1
                continue
            before, pace, rest, done = rest.found.state, step, after, done + step
            if not reached:
                yield rest
                return
        yield rest


def _step(
    sheet: Sheet,
    mold: Mold,
    rest: Rest,
    before: State,
    rise: float,
    ratio: float,
    mu: float,
    goal: float,
    report: Callable[[Step], None] | None,
    enough: float,
) -> Rest:
    """The rest position ``rise`` mm above ``rest``."""
    below, above = raised(mold, rest.height), raised(mold, rest.height + rise)
    old = rest.found.state
    rubbing = _rubbing(sheet, below, old, mu, rise)
    # A sheet that is not stretched yet has no stiffness to start from: it is lowered onto the mold without friction,
    # as is one whose way on from the step before leads nowhere.
    for carried in (True, False):
        if carried and rest.height == 0.0:
            continue
        if carried:
            start = _carried(sheet, above, old, before, rise, ratio)
        else:
            start = drape(clamped(sheet), above, BETWEEN).state
        largest = FEW if carried else MANY
        found = equilibrium(sheet, above, start, goal, largest, report, rubbing)
        if found.converged or found.residual_relative <= enough:
            break
    rubbed, drawn = _spent(sheet, rest.friction, rubbing, old, found)
    work = 0.5 * (_push(rest.found) + _push(found)) * rise
    return Rest(
        rest.height + rise,
        found,
        rubbing,
        rest.work + work,
        rest.rubbed + rubbed,
        rest.drawn + drawn,
        rest.unstressed,
        rest.steps + 1,
    )


def clamped(sheet: Sheet) -> Sheet:
    """The sheet with its edges under the blank holder clamped."""
    edges = [FIXED if force > 0.0 else bits for bits, force in zip(sheet.edges, sheet.holder, strict=True)]
    return replace(sheet, edges=(edges[0], edges[1], edges[2], edges[3]), holder=(0.0, 0.0, 0.0, 0.0))


def _rubbing(sheet: Sheet, mold: Mold, state: State, mu: float, rise: float) -> Friction:
    """Friction in a step from ``state`` on ``mold``, which is about to move up by ``rise`` mm.

    A node that does not touch yet would land about where it is nearest to the mold.
    """
    holder = sheet.holder_force
    upright = (sheet.fixed & 4) == 0
    touching = (state.contact != FREE) & upright
    ahead = np.where(touching | ~upright, 0.0, max(REACH * rise, 0.0))
    near = settled(state.x, mold, sheet, ahead)
    landing = (near.contact != FREE) & ~touching & upright
    anchor = np.where(landing[:, :, None], near.x, state.x)
    anchor[:, :, 2] += np.where(touching | landing, rise, 0.0)
    return Friction.begun(
        mu,
        STUCK * min(sheet.spacing),
        holder,
        anchor,
        touching | landing | (holder > 0.0),
        np.where(landing, near.contact, state.contact),
        np.where(landing, near.slot, state.slot),
    )


def _carried(sheet: Sheet, mold: Mold, state: State, before: State, rise: float, ratio: float) -> State:
    """Where a step starts: touching nodes carried up by ``mold``, free ones going on as in the step before.

    ``ratio``: this step's rise over that of the step before, 0 where there was none.
    """
    upright = (sheet.fixed & 4) == 0
    touching = (state.contact != FREE) & upright
    x = state.x.copy()
    going = ~touching & (before.contact == FREE) & upright & (sheet.holder_force == 0.0)
    x[going] += ratio * (state.x - before.x)[going]
    x[touching, 2] += rise
    clear = np.maximum(state.clear - rise - np.linalg.norm(x - state.x, axis=2), 0.0)
    start = settled(x, mold, sheet, known=(np.where(touching, 0.0, clear), state.slot.copy()))
    start.x[touching], start.clear[touching] = x[touching], 0.0
    start.contact[touching], start.slot[touching] = state.contact[touching], state.slot[touching]
    return start


def _push(found: Equilibrium) -> float:
    """Force of the press along z, N."""
    touching = found.state.contact != FREE
    return float((found.residual - found.force)[touching, 2].sum() + found.push[2])


def _spent(sheet: Sheet, before: Friction, after: Friction, old: State, found: Equilibrium) -> tuple[float, float]:
    """Energy in N mm that rubbing on the mold and under the blank holder took in a step."""
    way = found.state.x - after.anchor
    slid = np.where(after.stick_slip > 0, np.linalg.norm(way, axis=2), 0.0)
    holder = sheet.holder_force
    on_mold = np.where(found.state.contact != FREE, np.maximum(after.most - holder, 0.0), 0.0)
    first = np.where(old.contact != FREE, np.maximum(before.most - holder, 0.0), 0.0)
    return float((0.5 * (first + on_mold) * slid).sum()), float((holder * slid).sum())
