"""What the model of a draped sheet lacks on markers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataContext:
    """How far the effects may go: added prestretch (down, up), coefficient of friction, shear modulus [MPa], mass per
    area [g/m^2]."""

    prestretch: tuple[float, float]
    friction: float
    shear: float
    mass: float
