"""What is read off a sheet in equilibrium: stretches and stresses at the nodes, wrinkles, where things are largest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hyperfab.membrane.contact import Frictionless
from hyperfab.membrane.equilibrium import Press
from hyperfab.membrane.recovery import recovered_strain
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.tension_field import TAUT

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fields:
    """Smooth fields at the nodes (n,): principal stretches (n, 2), Cauchy stresses (n, 2) [MPa], thickness [mm]."""

    stretch: Array
    cauchy: Array
    thickness: Array


def fields(sheet: Sheet, places: Array) -> Fields:
    """Return smooth fields at the nodes."""
    found = sheet.law.principal(recovered_strain(sheet.mesh, places))
    return Fields(found.stretch, found.cauchy, sheet.thickness * found.thickness)


def mounted_energy(press: Press) -> float:
    """Return the energy [N mm] of the mounted sheet before the punch touches it; a clamp that gives has given."""
    sheet = press.sheet
    if sheet.clamp is None or sheet.prestretch <= 1.0:
        return sheet.energy(sheet.flat)
    below = -sheet.reach
    nothing = np.zeros(len(sheet.flat), bool)
    return replace(press, tangential=Frictionless()).equilibrium(below, sheet.flat, nothing).energy


def wrinkled_fraction(sheet: Sheet, places: Array) -> float:
    """Return the part of the undeformed area that is wrinkled or slack."""
    weights = sheet.mesh.weights.ravel()
    loose = sheet.response(places).state != TAUT
    return float(weights[loose].sum() / weights.sum()) if loose.any() else 0.0
