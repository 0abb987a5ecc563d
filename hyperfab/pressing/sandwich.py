"""Fabric, foam, fabric between two molds: what a gap does to it, and how thick it is at each place of the mold."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.curved import barycentric
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.series import Series, Shared
from hyperfab.surface import Surface


class State(IntEnum):
    """What happens at a point of the male surface."""

    OPEN = 0
    TOUCHING = 1
    BOTTOMED = 2
    INTERFERING = 3


@dataclass(frozen=True)
class Sandwich:
    """Foam of thickness ``foam`` [mm] with fabric of ``fabric`` [mm] in all on its two sides; numbers or (n,) arrays.

    Fabric without a law of its own counts as rigid through its thickness; with one, ``fabric_law`` of both layers
    together, it carries the foam's pressure and gives way to it.

    >>> from hyperfab.pressing.foam_law import linear
    >>> s = Sandwich(foam=4.0, fabric=1.0, law=linear(0.02))
    >>> s.thickness, s.pressure(3.0).item(), s.state(np.array([6.0, 4.0, 0.5, -1.0])).tolist()
    (5.0, 0.01, [0, 1, 2, 3])
    """

    foam: float | Array
    fabric: float | Array
    law: FoamLaw
    fabric_law: FoamLaw | None = None

    @cached_property
    def _series(self) -> Series | None:
        return None if self.fabric_law is None else Series(self.law, self.fabric_law)

    def _shared(self, series: Series, gap: ArrayLike) -> Shared:
        return series.at(self.thickness - np.asarray(gap, dtype=float), self.foam, self.fabric)

    @property
    def thickness(self) -> float | Array:
        """Whole thickness [mm] when nothing presses."""
        return self.foam + self.fabric

    @property
    def uneven(self) -> bool:
        """Whether its thickness or its foam varies from place to place."""
        return np.ndim(self.thickness) > 0 or self.law.places is not None

    def strain(self, gap: ArrayLike) -> Array:
        """Engineering compression of the foam in a ``gap`` [mm]; zero where it is not touched."""
        if self._series is not None:
            return self._shared(self._series, gap).strain
        return np.maximum((self.thickness - np.asarray(gap, dtype=float)) / self.foam, 0.0)

    def pressure(self, gap: ArrayLike) -> Array:
        """Pressure [MPa] of the sandwich in a ``gap`` [mm]."""
        if self._series is not None:
            return self._shared(self._series, gap).pressure
        return self.law.stress(self.strain(gap))

    def stiffness(self, gap: ArrayLike) -> Array:
        """Pressure gained per gap closed [MPa/mm]."""
        if self._series is not None:
            return self._shared(self._series, gap).stiffness
        return self.law.slope(self.strain(gap)) / self.foam

    def energy(self, gap: ArrayLike) -> Array:
        """Energy stored per area [N/mm] in a ``gap`` [mm]."""
        return self.borne(gap)[1]

    def borne(self, gap: ArrayLike) -> tuple[Array, Array]:
        """Pressure [MPa] and energy per area [N/mm] in a ``gap`` [mm], what is shared out found once."""
        if self._series is not None:
            shared = self._shared(self._series, gap)
            return shared.pressure, shared.energy
        strain = self.strain(gap)
        return self.law.stress(strain), self.law.energy(strain) * self.foam

    def pressed(self, gap: ArrayLike) -> tuple[Array, Array]:
        """Thickness [mm] of the foam and of both fabrics in a ``gap`` [mm].

        >>> from hyperfab.pressing.foam_law import linear
        >>> [part.item() for part in Sandwich(3.0, 3.0, linear(0.02), linear(0.06)).pressed(4.0)]
        [1.5, 2.5]
        """
        gap = np.asarray(gap, dtype=float)
        fabric = np.broadcast_to(np.asarray(self.fabric, dtype=float), gap.shape)
        if self._series is None:
            return np.clip(gap - fabric, 0.0, self.foam), fabric
        shared = self._shared(self._series, gap)
        foam = np.broadcast_to(np.asarray(self.foam, dtype=float), gap.shape)
        return foam * (1.0 - np.minimum(shared.strain, 1.0)), fabric * (1.0 - np.minimum(shared.second, 1.0))

    def state(self, gap: ArrayLike) -> Ints:
        """State of each point: open, touching, bottomed (the law's last strain) or interfering (metal in metal)."""
        gap = np.asarray(gap, dtype=float)
        strain = self.strain(gap)
        state = np.where(strain > 0.0, int(State.TOUCHING), int(State.OPEN))
        state = np.where(strain >= self.law.limit, int(State.BOTTOMED), state)
        return np.where(gap <= 0.0, int(State.INTERFERING), state)

    def thinned(self, foam: Array | float, fabric: Array | float) -> Sandwich:
        """The sandwich with its foam and its fabrics thinner by these factors, (n,) or numbers, as stretching over
        the mold leaves them."""
        return replace(self, foam=self.foam * foam, fabric=self.fabric * fabric)

    def of_vertices(self, chosen: Ints) -> Sandwich:
        """The sandwich at some of the vertices it is given for."""
        return self.at(lambda values: values[chosen])

    def at(self, interpolate: Callable[[Array], Array]) -> Sandwich:
        """The sandwich elsewhere, given what carries values at its vertices there."""

        def carry(value: float | Array) -> float | Array:
            return value if np.ndim(value) == 0 else interpolate(np.asarray(value))

        law = self.law.at(interpolate)
        found = replace(self, foam=carry(self.foam), fabric=carry(self.fabric), law=law)
        if law is self.law:  # what was worked out of it stays too
            found.__dict__["_series"] = self._series
        return found


def thinning_at(points: Array, nodes: Array, quads: Ints, factor: Array) -> Array:
    """Return the thinning (n,) at ``points`` (n, 3) [mm]: that of the sheet's nearest place.

    ``nodes`` (k, 3) [mm] and ``quads`` (m, 4) are the draped sheet, ``factor`` (m,) its thickness over that of the
    flat sheet in each quad. Between the middles of the quads it is interpolated.

    >>> import numpy as np
    >>> nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> thinning_at(np.array([[0.3, 0.3, 5.0]]), nodes, np.array([[0, 1, 2, 3]]), np.array([0.5])).tolist()
    [0.5]
    """
    count = np.bincount(quads.ravel(), minlength=len(nodes))
    total = np.bincount(quads.ravel(), weights=np.repeat(factor, 4), minlength=len(nodes))
    at_node = total / np.maximum(count, 1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    sheet = Surface(nodes, triangles)
    near = sheet.nearest(points)
    weights = barycentric(sheet, near.face, near.point)
    return np.asarray((weights * at_node[triangles[near.face]]).sum(axis=1))


def thickness_factor(points: Array, terms: Mapping[str, float]) -> Array:
    """Return the foam's thickness (n,) at ``points`` (n, 3) [mm], as a share of its nominal one.

    ``terms`` are the coefficients of a polynomial in the coordinates, each scaled to -1 to 1 over the points: a term
    is named by its coordinates, as ``x`` or ``xy``.

    >>> import numpy as np
    >>> thickness_factor(np.array([[0, 0, 0], [10, 4, 0.0]]), {"x": 0.05, "xy": -0.01}).tolist()
    [0.94, 1.04]
    """
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.5 * (high - low)
    scaled = (points - 0.5 * (low + high)) / np.where(half > 0.0, half, 1.0)
    factor = np.ones(len(points))
    for name, coefficient in terms.items():
        factor += coefficient * np.prod([scaled[:, "xyz".index(axis)] for axis in name], axis=0)
    return factor
