"""Constants of a law from tests: the global least-squares optimum without start values, and how sure it is."""

from __future__ import annotations

from hyperfab.materials.identification.design import Problem
from hyperfab.materials.identification.fit import Fit, fit_law
from hyperfab.materials.identification.rows import Rows

__all__ = ["Fit", "Problem", "Rows", "fit_law"]
