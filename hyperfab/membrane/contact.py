"""What happens at a node that touches the punch.

The constraint is exact: at the solution touching nodes lie on the punch. In each Newton step a touching node gets a
very stiff spring along the normal; the contact force itself is taken from the sheet's own nodal force, so the spring
leaves no error behind, needs no rotated axes and does not change the matrix pattern.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hyperfab.membrane.sphere import Nearness

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Stiff spring of a touching node relative to its own stiffness: large enough to hold the node, and far from the
#: 1e16 at which the solver would lose the sheet.
STIFF = 1e6


@dataclass(frozen=True)
class Terms:
    """What contact adds to Newton's equations at the touching nodes (k of them).

    ``force`` (k, 3) [N]: contact force on the sheet; ``right`` (k, 3): addition to the right-hand side beyond the
    balance of forces; ``blocks`` (k, 3, 3): addition to the diagonal blocks.
    """

    force: Array
    right: Array
    blocks: Array


class Tangential(Protocol):
    """How the punch holds a touching node along its surface."""

    def terms(
        self, nodes: NDArray[np.int64], places: Array, pull: Array, near: Nearness, spring: Array
    ) -> Terms:
        """Return the contact terms.

        ``nodes`` (k,) touch; ``places`` and ``pull`` (k, 3) are their places relative to the punch [mm] and the
        sheet's nodal forces [N]; ``near`` and ``spring`` (k,) [N/mm] belong to them.
        """
        ...


@dataclass(frozen=True)
class Frictionless:
    """The sheet slides freely: the contact force is normal."""

    def terms(
        self, nodes: NDArray[np.int64], places: Array, pull: Array, near: Nearness, spring: Array
    ) -> Terms:
        """Return the contact terms of free sliding."""
        pressure = (pull * near.normal).sum(axis=1)
        outer = near.normal[:, :, None] * near.normal[:, None, :]
        return Terms(
            force=pressure[:, None] * near.normal,
            right=-(spring * near.gap)[:, None] * near.normal,
            blocks=spring[:, None, None] * outer - pressure[:, None, None] * near.turning,
        )
