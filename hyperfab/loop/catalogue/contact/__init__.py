"""What the model of a punched sheet lacks on its force over depth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataContext:
    """The temperatures met [degC], how far prestretch (down, up), friction and slip
    [mm per N/mm] may go, and the pull of the rim [N/mm] at the deepest."""

    temperatures: tuple[float, ...]
    reference_degC: float
    prestretch: tuple[float, float]
    friction: float
    slip: float
    pull: float
