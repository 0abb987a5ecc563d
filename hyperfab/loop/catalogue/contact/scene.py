"""The test an entry is scaled to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scene:
    """The deepest reading [mm], the temperatures met [degC], and how far prestretch (down, up), friction and slip
    [mm per N/mm] may go."""

    deepest_mm: float
    temperatures: tuple[float, ...]
    reference_degC: float
    prestretch: tuple[float, float]
    friction: float
    slip: float
