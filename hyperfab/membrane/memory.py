"""What friction remembers from one load step to the next, and where nodes land on the punch in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.sphere import Nearness, Punch


@dataclass(frozen=True)
class Memory:
    """An equilibrium at ``depth`` [mm] as friction sees it, for all nodes, in the frame of the punch.

    ``places`` (n, 3) [mm]; ``gap`` (n,) and ``normal`` (n, 3) to the punch; ``touching`` and ``sticking`` (n,);
    ``friction`` (n, 3) [N] on the sheet; ``ways`` (n, 3): directions of slip; ``dissipated`` [N mm] so far by what
    is meshed; ``drift`` (n, 3): how places move per mm of depth, None where that is not known.
    """

    depth: float
    places: Array
    gap: Array
    normal: Array
    touching: Flags
    friction: Array
    ways: Array
    sticking: Flags
    dissipated: float = 0.0
    drift: Array | None = None


def mounted(flat: Array, punch: Punch) -> Memory:
    """Return the memory of the mounted sheet, places (n, 3), before the punch moves: nothing touches."""
    near = punch.near(flat, 0.0)
    nothing, zeros = np.zeros(len(flat), bool), np.zeros_like(flat)
    return Memory(0.0, flat, near.gap, near.normal, nothing, zeros, zeros, nothing)


def remembered(
    before: Memory,
    anchors: Array,
    depth: float,
    places: Array,
    near: Nearness,
    touching: Flags,
    pull: Array,
    sticking: Flags,
) -> Memory:
    """Return the memory of the equilibrium that followed ``before``.

    ``places`` (n, 3) are those in space, ``pull`` (n, 3) the sheet's nodal forces, ``anchors`` (n, 3) where the nodes
    began to rub. The energy that slip has cost is the mean of the friction before and after times the slip.
    """
    own = places - np.array([0.0, 0.0, depth])
    across = pull - (pull * near.normal).sum(axis=1)[:, None] * near.normal
    friction = np.where(touching[:, None], across, 0.0)
    size = np.linalg.norm(friction, axis=1)
    ways = -friction / np.where(size > 0.0, size, 1.0)[:, None]
    slip = np.where(touching[:, None], own - anchors, 0.0)
    # A node that has just landed was rubbed with its present friction from the start.
    first = np.where(before.touching[:, None], before.friction, friction)
    spent = -float((0.5 * (first + friction) * slip).sum())
    return Memory(
        depth,
        own,
        near.gap,
        near.normal,
        touching,
        friction,
        ways,
        sticking & touching,
        before.dissipated + spent,
    )


def landings(memory: Memory, punch: Punch, depth: float) -> Array:
    """Return where each node touches, or comes to touch, the punch on the way to ``depth`` (n, 3).

    A touching node stays where it is. Near the edge of contact the gap closes as the square of the way that is left,
    so a node lands after 2 gap / (closing speed); until then it keeps its drift. The mounted sheet is taken straight
    down onto the punch.
    """
    if memory.drift is None:
        height = punch.height(memory.places[:, :2], 0.0)
        below = np.isfinite(height)
        lands = memory.places - memory.gap[:, None] * memory.normal
        lands[below] = np.column_stack([memory.places[below, :2], height[below]])
        return np.asarray(lands)
    step = depth - memory.depth
    closing = -(memory.normal * memory.drift).sum(axis=1)
    way = np.where(closing > 0.0, 2.0 * memory.gap / np.where(closing > 0.0, closing, 1.0), step)
    way = np.where(memory.touching, 0.0, np.clip(way, 0.0, step))
    places = memory.places + way[:, None] * memory.drift
    near = punch.near(places, 0.0)
    return np.asarray(places - near.gap[:, None] * near.normal)
