"""What happens at a node that touches the punch, and what friction remembers of it from load step to load step.

The constraint is exact: at the solution touching nodes lie on the punch. In each Newton step a touching node gets a
very stiff spring along the normal (and along the surface where it sticks); the contact force itself is taken from the
sheet's own nodal force, so the spring leaves no error behind, needs no rotated axes and does not change the matrix
pattern.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.punch import Nearness, Punch

#: Stiff spring of a touching node relative to its own stiffness: large enough to hold the node, and far from the
#: 1e16 at which the solver would lose the sheet.
STIFF = 1e6


@dataclass(frozen=True)
class Terms:
    """What contact adds to Newton's equations at the touching nodes (k of them).

    ``force`` (k, 3) [N]: contact force on the sheet; ``right`` (k, 3): addition to the right-hand side beyond the
    balance of forces; ``blocks`` (k, 3, 3): addition to the diagonal blocks. ``mix`` (k, 3, 3), where there is
    friction, first multiplies the balance and its stiffness at these nodes: it takes the stiff spring out of the
    tangential equations, and ``right`` and ``blocks`` are what remains of them.
    """

    force: Array
    right: Array
    blocks: Array
    mix: Array | None = None


class Grip(Protocol):
    """How the punch holds touching nodes along its surface during one load step."""

    def terms(self, nodes: Ints, places: Array, pull: Array, near: Nearness, spring: Array) -> Terms:
        """Return the contact terms.

        ``nodes`` (k,) touch; ``places`` and ``pull`` (k, 3) are their places relative to the punch [mm] and the
        sheet's nodal forces [N]; ``near`` and ``spring`` (k,) [N/mm] belong to them.
        """

    @property
    def settled(self) -> bool:
        """Whether the last call changed no node from sticking to slipping or back."""

    @property
    def sticking(self) -> Flags:
        """Which nodes (n,) stick, should they touch."""


class Tangential(Protocol):
    """A law of friction."""

    @property
    def symmetric(self) -> bool:
        """Whether its stiffness is symmetric."""

    @property
    def remembers(self) -> bool:
        """Whether an equilibrium hangs on how it was reached."""

    @property
    def holds(self) -> bool:
        """Whether a touching node stays where it landed, so that the result is of first order in the load step."""

    def begin(self, memory: Memory, anchors: Array) -> Grip:
        """Start a load step from what is remembered of the last one; ``anchors`` (n, 3): where nodes begin to rub."""


@dataclass(frozen=True)
class Frictionless:
    """The sheet slides freely: the contact force is normal."""

    symmetric = True
    remembers = False
    holds = False

    def begin(self, memory: Memory, anchors: Array) -> _Sliding:
        """Start a load step; nothing is remembered."""
        return _Sliding(np.zeros(len(anchors), bool))


@dataclass(frozen=True)
class _Sliding:
    sticking: Flags
    settled = True

    def terms(self, nodes: Ints, places: Array, pull: Array, near: Nearness, spring: Array) -> Terms:
        """Return the contact terms of free sliding."""
        normal = near.normal
        pressure = (pull * normal).sum(axis=1)
        outer = normal[:, :, None] * normal[:, None, :]
        return Terms(
            force=pressure[:, None] * normal,
            right=-(spring * near.gap)[:, None] * normal,
            blocks=spring[:, None, None] * outer - pressure[:, None, None] * near.turning,
        )


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

    @property
    def origins(self) -> Array:
        """Points (n, 3) [mm] of the punch nearest to the nodes, from where slip is counted in the step that follows."""
        return np.asarray(self.places - self.gap[:, None] * self.normal)


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
