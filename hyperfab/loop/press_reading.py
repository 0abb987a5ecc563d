"""What was read in a press, and how the press was set; foam whose thickness varies over the plan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from hyperfab.arrays import Array, Ints

Kind = Literal["pressure", "contact", "thickness", "force"]

#: Units the readings are told in.
UNITS: dict[str, str] = {"pressure": "MPa", "contact": "-", "thickness": "mm", "force": "N"}


@dataclass(frozen=True)
class Reading:
    """One file: ``kind`` and values (m,); at places of the male (``corners`` (m, 3) of the table of the places with
    their ``weights``) or at machine ``stroke`` (m,) [mm]; ``time_s`` since the foam was first
    pressed; ``index`` is where the rows stand in the file."""

    name: str
    kind: Kind
    values: Array
    corners: Ints | None = None
    weights: Array | None = None
    places: Array | None = None
    stroke: Array | None = None
    time_s: Array | None = None
    index: Array | None = None

    def rows(self, chosen: Ints) -> Reading:
        """Return some of the rows, in that order."""
        parts: dict[str, Any] = {
            key: None if value is None else value[chosen]
            for key, value in vars(self).items()
            if key not in ("name", "kind")
        }
        return Reading(self.name, self.kind, **parts)


@dataclass(frozen=True)
class Setting:
    """How the press was set: the opening [mm] without a yielding frame, or the force [N]; ``compliance`` [mm/N] of
    the frame the model has already; ``zero_rate`` (2,) is what resetting the clearance hot gives back per strain of
    male and female [mm]; ``recovery`` the share of its compression the foam gives back, None where thickness was read
    under the press; a ``floating`` female turns until nothing has a moment about its joint, whatever lies between.
    Terms of the foam's thickness are shares of ``thickness`` [mm]."""

    opening: float
    force: float | None = None
    compliance: float = 0.0
    zero_rate: tuple[float, float] = (0.0, 0.0)
    recovery: float | None = None
    floating: bool = False
    thickness: float | None = None


#: Where a term of the thickness is added: ``variation.xxy`` is the coefficient of x^2 y.
VARIATION = "variation."


def variation(plan: Array, amounts: Mapping[str, float]) -> Array | float:
    """Return the relative change (n,) of foam thickness over the plan (n, 2); 0 where no term is among ``amounts``."""
    x, y = plan[:, 0], plan[:, 1]
    return sum(
        coefficient * x ** name.count("x", len(VARIATION)) * y ** name.count("y", len(VARIATION))
        for name, coefficient in amounts.items()
        if name.startswith(VARIATION)
    )
