"""What happens at a node that touches the punch.

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
from hyperfab.membrane.memory import Memory
from hyperfab.membrane.sphere import Nearness

#: Stiff spring of a touching node relative to its own stiffness: large enough to hold the node, and far from the
#: 1e16 at which the solver would lose the sheet.
STIFF = 1e6


@dataclass(frozen=True)
class Terms:
    """What contact adds to Newton's equations at the touching nodes (k of them).

    ``force`` (k, 3) [N]: contact force on the sheet; ``right`` (k, 3): addition to the right-hand side beyond the
    balance of forces; ``blocks`` (k, 3, 3): addition to the diagonal blocks; ``drive`` (k, 3): right-hand side per mm
    of depth. ``mix`` (k, 3, 3), where there is friction, first multiplies the balance and its stiffness at these
    nodes: it takes the stiff spring out of the tangential equations, and ``right``, ``blocks`` and ``drive`` are
    what remains of them.
    """

    force: Array
    right: Array
    blocks: Array
    drive: Array
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
            drive=(spring * normal[:, 2])[:, None] * normal,
        )
