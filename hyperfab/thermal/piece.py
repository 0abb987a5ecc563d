"""A flat piece of layers laid on faces of the mold: conduction through its thickness, a column of cells to each facet.

Along the faces it conducts nothing: it is thin, and its foam is a poor conductor. Cells hold their heat at their
middle, so that the flow from cell to cell is second order in their height (finite volumes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.facet_operator import FacetOperator

#: Cells through the whole thickness, about; shared among the layers by the time that heat takes through each.
CELLS = 16


@dataclass(frozen=True)
class Layer:
    """A layer: ``thickness`` [m], ``conductivity`` [W/m/K], ``capacity`` per volume [J/m^3/K]."""

    thickness: float
    conductivity: float
    capacity: float


@dataclass(frozen=True)
class Column:
    """Cells through the thickness, from the mold outward, for one square metre.

    ``capacity`` (n,) [J/m^2/K]; ``between`` (n - 1,) the conductance from middle to middle, ``inner`` and ``outer``
    from the faces to the first and the last middle [W/m^2/K]; ``height`` (n,) of the middles above the mold [m].
    """

    capacity: Array
    between: Array
    inner: float
    outer: float
    height: Array


def column(layers: Sequence[Layer], cells: int = CELLS) -> Column:
    """Cut layers into cells, two a layer at least.

    >>> found = column([Layer(0.004, 0.04, 7e4)], cells=4)
    >>> found.capacity.tolist(), found.between.round(6).tolist(), found.inner
    ([70.0, 70.0, 70.0, 70.0], [40.0, 40.0, 40.0], 80.0)
    """
    times = np.array([layer.thickness * np.sqrt(layer.capacity / layer.conductivity) for layer in layers])
    counts = np.maximum(2, np.round(cells * times / times.sum()).astype(int))
    size = np.repeat([layer.thickness for layer in layers] / counts, counts)
    half = 0.5 * size / np.repeat([layer.conductivity for layer in layers], counts)
    return Column(
        capacity=size * np.repeat([layer.capacity for layer in layers], counts),
        between=1.0 / (half[:-1] + half[1:]),
        inner=float(1.0 / half[0]),
        outer=float(1.0 / half[-1]),
        height=np.cumsum(size) - 0.5 * size,
    )


class Piece:
    """A piece on ``facets``; the cells of facet f are the nodes ``first`` + f n .. of the model, n cells a column.

    ``h`` [W/m^2/K] is the conductance of its contact with the mold; its other face meets ``other``: a conductance
    [W/m^2/K] and a temperature [degC], or is insulated where that is None.
    """

    name = "piece"
    linear = True

    def __init__(
        self,
        facets: FacetOperator,
        first: int,
        layers: Sequence[Layer],
        h: float,
        other: tuple[float, float] | None,
    ) -> None:
        self.other = other
        self.cells = column(layers)
        count, n = len(facets.nodes), len(self.cells.capacity)
        self.area = facets.weights.sum(axis=1)
        self.own = first + np.arange(count * n).reshape(count, n)
        self._nodes = np.concatenate([facets.nodes, self.own], axis=1)
        shares = facets.matrices(np.ones_like(facets.weights)).sum(axis=2) / self.area[:, None]
        unit = np.zeros((count, 6 + n, 6 + n))
        across = np.zeros((count, 6 + n))  # the mold's mean over the facet, less the first cell
        across[:, :6], across[:, 6] = shares, -1.0
        unit += _series(h, self.cells.inner) * across[:, :, None] * across[:, None, :]
        for i, g in enumerate(self.cells.between, start=6):
            unit[:, i, i] += g
            unit[:, i + 1, i + 1] += g
            unit[:, i, i + 1] -= g
            unit[:, i + 1, i] -= g
        self._outer = 0.0 if other is None else _series(other[0], self.cells.outer)
        unit[:, -1, -1] += self._outer
        self._matrices = self.area[:, None, None] * unit

    @property
    def nodes(self) -> Ints:
        """Return the nodes of each facet and its column (f, 6 + n)."""
        return self._nodes

    @property
    def capacity(self) -> Array:
        """Heat capacity of the cells, column by column [J/K]."""
        return (self.area[:, None] * self.cells.capacity).ravel()

    def heat(self, temperature: Array, fresh: float) -> float:
        """Return what the piece has taken up since it was at ``fresh`` [J]."""
        return float(self.capacity @ (temperature[self.own.ravel()] - fresh))

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow [W]: what the mold loses the cells gain; the other side's enters."""
        at = temperature[self._nodes]
        # Differences to the first cell: a piece as warm as the mold exchanges nothing, to the last digit.
        away = at - at[:, 6:7]
        flows: Array = -np.einsum("fij,fj->fi", self._matrices, away)
        if self.other is not None:
            flows[:, -1] += self._outer * self.area * (self.other[1] - at[:, 6])
        return np.bincount(self._nodes.ravel(), flows.ravel(), len(temperature)).astype(np.float64)

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return the matrices of facets with their columns (f, 6 + n, 6 + n)."""
        return self._matrices


def _series(one: float, other: float) -> float:
    return one * other / (one + other)
