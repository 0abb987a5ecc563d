"""A shear that was read as an angle."""

from __future__ import annotations

import re

import numpy as np

from hyperfab.arrays import Array
from hyperfab.io.csv_numbers import quantities
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import plain
from hyperfab.io.headings import Heading, is_of

#: Words of a title that say that it is an angle.
_ANGLE = re.compile(r"\b(?:angle|angulo|angolo)\b|winkel\b")


def shear_strain(sheet: CsvSheet, head: Heading, decimal: str) -> Array:
    """Return the shear strains (n,) of a column: its numbers, or the tangents where they are angles.

    InputError where the title says an angle and has no unit: 8 degrees would be a shear of eight.
    """
    if head.unit is not None and is_of(head.unit, "angle"):
        return np.tan(np.radians(quantities(sheet, head, "angle", decimal)))
    if head.unit is None and _ANGLE.search(plain(head.title)):
        option = sheet.option([(head.title, "shear strain [deg]")])
        raise sheet.wrong("an angle without a unit", head, remedy=f"if it is in degrees, say {option}")
    return quantities(sheet, head, "dimensionless", decimal, name="shear strain")
