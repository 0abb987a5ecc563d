"""What the model of a press lacks on readings between the molds."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DataContext:
    """Half the male's width [mm], the largest force [N], the travel from the first touch [mm]; whether strokes and
    times were read, and the longest time [s]; whether the female floats, and whether the press was set by its force.
    """

    half_mm: float
    force_N: float
    travel_mm: float
    strokes: bool
    timed: bool
    time_s: float
    floats: bool = False
    forced: bool = False
