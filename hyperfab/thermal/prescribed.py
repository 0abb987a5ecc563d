"""Nodes whose temperature is held at a value, or follows a table in time."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.tables import Table


@dataclass(frozen=True)
class Prescribed:
    """Nodes (k,) held at ``value`` [degC] against time."""

    name: str
    nodes: Ints
    value: Table

    def apply(self, time: float, temperature: Array) -> None:
        """Set the held nodes of ``temperature`` in place."""
        temperature[self.nodes] = self.value.at(time)
