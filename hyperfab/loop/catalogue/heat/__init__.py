"""What the model of a heated mold lacks on thermocouple readings."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataContext:
    """Length of the experiment, its rise of temperature, and what the mold has.

    ``opened`` counts joints that conduct perfectly in the model, ``declared`` the others; ``bench`` says whether
    faces have no film.
    """

    duration_s: float
    rise_K: float
    power_W: float
    films: int
    heaters: int
    opened: int
    declared: int
    probes: int
    bench: bool
    emits: bool
    typical_film: float
