"""How even a surface is: mean, least and greatest temperature over facets."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.trail import Past


@dataclass(frozen=True)
class Evenness:
    """Temperatures of a surface [degC]."""

    mean: float
    least: float
    greatest: float

    @property
    def spread(self) -> float:
        """Greatest less least [K]."""
        return self.greatest - self.least


def evenness(surface: FacetOperator, temperature: Array) -> Evenness:
    """Return the mean over the area, and the least and greatest of the surface's nodes."""
    nodal = temperature[np.unique(surface.nodes)]
    return Evenness(surface.mean(temperature), float(nodal.min()), float(nodal.max()))


def of_all(surface: FacetOperator, states: Iterable[Past]) -> list[Evenness]:
    """Return the evenness at each state; of reduced ones only the surface is lifted."""
    nodes, mean = np.unique(surface.nodes), surface.mean_weights
    found = []
    for state in states:
        if not state.is_reduced:
            found.append(evenness(surface, state.temperature))
            continue
        nodal = state.on(nodes)
        found.append(Evenness(state.reading(mean)[0], float(nodal.min()), float(nodal.max())))
    return found
