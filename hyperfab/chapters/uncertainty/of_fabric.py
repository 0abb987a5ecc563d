"""What a command says of how sure it is that computes with a fabric, and with nothing else that heat changes."""

from __future__ import annotations

import os

from hyperfab.cases.case import Case
from hyperfab.chapters.fabric import FabricDocument
from hyperfab.chapters.uncertainty.sources import Origins, origins, read_as
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.inputs import Inputs
from hyperfab.io.units import tolerance

#: The place of the temperature in a case.
_TEMPERATURE = "temperature_degC"
#: How far beside a temperature its constants are asked for, over its standard deviation: what they do there, as slopes.
_NEAR = 0.01


def origins_of_fabric(inputs: Inputs, case: Case, name: str, asked: float | None) -> Origins:
    """Return what ``case`` and the material document ``name`` say of how sure they are, at the temperature [degC]
    ``asked`` for.

    A temperature that is stated with a tolerance, and that the constants do not follow, is left out by name: the tests
    do not tell what it does, which is not that it does nothing.
    """
    found = origins(inputs, case, {name: asked})
    sd = tolerance(asked)
    if asked is None or sd == 0.0:
        return found
    fabric = FabricDocument(read_as(inputs, name, MaterialDocument)[0], name)
    near = _NEAR * sd
    if not fabric.follows(asked - near, asked, asked + near):
        found.found = [one for one in found.found if [number.name for number in one.numbers] != [_TEMPERATURE]]
        base = os.path.basename(name)
        found.left_out.append(f"{_TEMPERATURE}: {base} does not say what it does to the constants at {asked:g} degC")
    return found
