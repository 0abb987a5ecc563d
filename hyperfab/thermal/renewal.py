"""Parts that are taken out and replaced by fresh ones: the cold sandwich of each press cycle."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.switched import Switched


@dataclass(frozen=True)
class Renewal:
    """At each of ``times`` [s] the nodes (k,), which no other part shares, are set to ``temperature`` [degC].

    The heat that the old piece carries out, less what the new one brings, counts as lost. Then the conditions ``on``
    begin and those of ``off`` end.
    """

    name: str
    nodes: Ints
    temperature: float
    times: tuple[float, ...]
    on: tuple[Switched, ...] = ()
    off: tuple[Switched, ...] = ()

    def apply(self, temperature: Array) -> None:
        """Put in the fresh part: set the nodal temperatures in place."""
        temperature[self.nodes] = self.temperature
        for condition in (*self.on, *self.off):
            condition.on = condition in self.on
