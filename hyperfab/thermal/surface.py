"""How even a surface is: mean, least and greatest temperature over facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.facet_operator import FacetOperator


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
