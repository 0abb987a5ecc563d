"""What the model of a press lacks on readings between the molds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Effect


@dataclass(frozen=True)
class PressEffect(Effect):
    """An entry that says itself what it changes of a press."""

    @abstractmethod
    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Add what the effect changes where its constants are ``at`` these values by name: a simpler form has fewer."""


@dataclass(frozen=True)
class FoamContext:
    """What the model has of the sandwich: how thick [mm] its fabrics are, whether they give way across, whether a law
    says what stays of the foam's strain, and at which temperature [degC] its stiffness holds, None where several are
    told; whether it is as hot at each place as both molds."""

    fabric_mm: float = 0.0
    across: bool = False
    sets: bool = False
    law_degC: float | None = None
    even: bool = True


@dataclass(frozen=True)
class DataContext:
    """Half the male's width [mm], the largest force [N], the travel from the first touch [mm]; whether strokes and
    times were read, and the longest time [s]; whether the female floats, and whether the press was set by its force.

    ``pressure_MPa`` is the foam's at half its thickness, ``temperatures`` [degC] those of the molds as readings were
    taken, ``molds_degC`` that of the model; ``formed`` tells whether thickness was read after the press had opened.
    """

    half_mm: float
    force_N: float
    travel_mm: float
    strokes: bool
    timed: bool
    time_s: float
    floats: bool = False
    forced: bool = False
    pressure_MPa: float = 0.005
    foam: FoamContext = FoamContext()
    temperatures: tuple[float, ...] = (20.0,)
    molds_degC: float = 20.0
    formed: bool = False
