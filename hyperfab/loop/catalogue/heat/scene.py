"""The experiment an entry is scaled to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scene:
    """Length and sampling of the experiment, its rise of temperature, and what the mold has.

    ``opened`` counts joints that conduct perfectly in the model; ``bench`` says whether faces have no film.
    """

    duration_s: float
    step_s: float
    rise_K: float
    films: int
    heaters: int
    opened: int
    probes: int
    bench: bool
    emits: bool
    typical_film: float
