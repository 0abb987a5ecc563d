"""Fabric, foam, fabric between two molds: what a gap does to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.arrays import Array
from hyperfab.pressing.foam_law import FoamLaw


class State(IntEnum):
    """What happens at a point of the male surface."""

    OPEN = 0
    TOUCHING = 1
    BOTTOMED = 2
    INTERFERING = 3


@dataclass(frozen=True)
class Sandwich:
    """Foam of thickness ``foam`` [mm] with fabric of ``fabric`` [mm] in all on its two sides; numbers or (n,) arrays.

    Fabric counts as incompressible through its thickness: it is thin and some hundred times stiffer than foam.

    >>> from hyperfab.pressing.foam_law import linear
    >>> s = Sandwich(foam=4.0, fabric=1.0, law=linear(0.02))
    >>> s.thickness, s.pressure(3.0).item(), s.state(np.array([6.0, 4.0, 0.5, -1.0])).tolist()
    (5.0, 0.01, [0, 1, 2, 3])
    """

    foam: float | Array
    fabric: float | Array
    law: FoamLaw

    @property
    def thickness(self) -> float | Array:
        """Whole thickness [mm] when nothing presses."""
        return self.foam + self.fabric

    @property
    def uneven(self) -> bool:
        """Whether its thickness varies from place to place."""
        return np.ndim(self.thickness) > 0

    def strain(self, gap: ArrayLike) -> Array:
        """Engineering compression of the foam in a ``gap`` [mm]; zero where it is not touched."""
        return np.maximum((self.thickness - np.asarray(gap, dtype=float)) / self.foam, 0.0)

    def pressure(self, gap: ArrayLike) -> Array:
        """Pressure [MPa] of the sandwich in a ``gap`` [mm]."""
        return self.law.stress(self.strain(gap))

    def stiffness(self, gap: ArrayLike) -> Array:
        """Pressure gained per gap closed [MPa/mm]."""
        return self.law.slope(self.strain(gap)) / self.foam

    def energy(self, gap: ArrayLike) -> Array:
        """Energy stored per area [N/mm] in a ``gap`` [mm]."""
        return self.law.energy(self.strain(gap)) * self.foam

    def state(self, gap: ArrayLike) -> NDArray[np.int64]:
        """State of each point: open, touching, bottomed (the law's last strain) or interfering (metal in metal)."""
        gap = np.asarray(gap, dtype=float)
        strain = self.strain(gap)
        state = np.where(strain > 0.0, int(State.TOUCHING), int(State.OPEN))
        state = np.where(strain >= self.law.limit, int(State.BOTTOMED), state)
        return np.where(gap <= 0.0, int(State.INTERFERING), state)

    def thinned(self, factor: Array) -> Sandwich:
        """The sandwich with all layers thinner by ``factor`` (n,), as stretching over the mold leaves them."""
        return Sandwich(self.foam * factor, self.fabric * factor, self.law)

    def of_vertices(self, chosen: NDArray[np.int64]) -> Sandwich:
        """The sandwich at some of the vertices it is given for."""

        def pick(value: float | Array) -> float | Array:
            return value if np.ndim(value) == 0 else np.asarray(value)[chosen]

        return Sandwich(pick(self.foam), pick(self.fabric), self.law)

    def at(self, interpolate: Callable[[Array], Array]) -> Sandwich:
        """The sandwich elsewhere, given what carries values at its vertices there."""

        def carry(value: float | Array) -> float | Array:
            return value if np.ndim(value) == 0 else interpolate(np.asarray(value))

        return Sandwich(carry(self.foam), carry(self.fabric), self.law)
