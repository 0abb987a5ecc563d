"""Nodes whose temperature is held at a value, or follows a table in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.thermal.tables import Table

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Prescribed:
    """Nodes (k,) held at ``value`` [degC] against time."""

    name: str
    nodes: Index
    value: Table

    def apply(self, time: float, temperature: Array) -> None:
        """Set the held nodes of ``temperature`` in place."""
        temperature[self.nodes] = self.value.at(time)
