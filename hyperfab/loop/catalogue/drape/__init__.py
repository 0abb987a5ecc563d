"""What the model of a draped sheet lacks on markers."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.loop.problem import Effect


@dataclass(frozen=True)
class DrapeEffect(Effect):
    """An entry for a draped sheet, by how surely effects are told apart there."""

    smooth: bool = False
    confounded_share: float = 0.95
    mimic_left: float = 0.5


@dataclass(frozen=True)
class DataContext:
    """How far the effects may go: added prestretch (down, up), coefficient of friction, shear modulus [MPa], mass per
    area [g/m^2]."""

    prestretch: tuple[float, float]
    friction: float
    shear: float
    mass: float
