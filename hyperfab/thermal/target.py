"""What a run waits for: a mean temperature."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Target:
    """``sensor`` (n,) weighs nodal temperatures into the watched mean; ``value`` [degC] is waited for."""

    sensor: Array
    value: float
