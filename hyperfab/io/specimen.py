"""From what a machine records (extension, force, true stress) to stretch and nominal stress."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hyperfab.errors import InputError
from hyperfab.io.csv_dialect import Heading, Sheet
from hyperfab.io.csv_numbers import quantities
from hyperfab.io.units import quantity

Array = NDArray[np.float64]

#: A strain without a unit beyond this is a percentage somebody forgot to mark: no fabric stretches twenty-fold.
MAX_STRAIN = 20.0


@dataclass(frozen=True)
class Geometry:
    """The undeformed specimen [mm]; what is not known is None. A biaxial disc has a ``diameter`` and no width."""

    gauge_length: float | None = None
    width: float | None = None
    thickness: float | None = None
    diameter: float | None = None


@dataclass(frozen=True)
class Reading:
    """Stretch and nominal stress of the rows of a file; ``membrane``: the stress is in N/mm."""

    stretch: Array
    stress: Array
    membrane: bool
    stretch2: Array | None
    stress2: Array | None
    stress_sd: Array | None
    notes: tuple[str, ...]

    def rows(self, chosen: NDArray[np.int64]) -> Reading:
        """Return the reading of some rows."""

        def pick(column: Array | None) -> Array | None:
            return None if column is None else column[chosen]

        return replace(
            self,
            stretch=self.stretch[chosen],
            stress=self.stress[chosen],
            stretch2=pick(self.stretch2),
            stress2=pick(self.stress2),
            stress_sd=pick(self.stress_sd),
        )


def read_geometry(sheet: Sheet, options: Geometry) -> Geometry:
    """Return the specimen's sizes: those given as options, else those the file's metadata state."""
    found = {}
    for key in ("gauge_length", "width", "thickness", "diameter"):
        value = getattr(options, key)
        entry = sheet.meta(key.replace("_", " "))
        if value is None and entry is not None:
            try:
                value = quantity(entry.value, "length")
            except InputError as error:
                raise InputError(
                    error.message,
                    file=sheet.name,
                    line=entry.line,
                    key=key.replace("_", " "),
                    remedy=error.remedy,
                ) from None
            if value <= 0.0:
                raise InputError(
                    "is not positive",
                    file=sheet.name,
                    line=entry.line,
                    key=key.replace("_", " "),
                    remedy="write the size of the undeformed specimen",
                )
        found[key] = value
    return Geometry(**found)


def read_loading(sheet: Sheet, test: str, sizes: Geometry, decimal: str) -> Reading:
    """Return stretch and nominal stress of all rows, taken as a test of kind ``test``.

    - stretch: ``stretch``, else ``strain`` + 1, else 1 + ``extension`` / gauge length (the diameter of a disc).
    - nominal stress: ``stress``; else ``true stress`` / stretch, which is the same for uniaxial, planar and
      biaxial tension of an incompressible sheet, since force and area share the direction; else ``membrane stress``
      or ``force`` / width (a disc's radial force: / (pi diameter)), in N/mm, divided by the thickness where it is
      known.

    Raises InputError where columns or sizes are missing.
    """
    notes: list[str] = []
    stretch = _stretch(sheet, "", test, sizes, decimal)
    if stretch is None:
        raise _missing(sheet, "a stretch", '"stretch", "strain [%]" or "extension [mm]"')
    stretch2 = _stretch(sheet, " 2", test, sizes, decimal)
    stress, membrane, sd = _stress(sheet, "", test, sizes, decimal, stretch, notes)
    if stress is None:
        raise _missing(
            sheet, "a stress", '"stress [MPa]", "true stress [MPa]", "membrane stress [N/mm]" or "force [N]"'
        )
    stress2, membrane2, _ = _stress(sheet, " 2", test, sizes, decimal, stretch2, notes)
    if stress2 is not None and membrane2 != membrane:
        raise InputError(
            "the two directions are in different units (MPa and N/mm)",
            file=sheet.name,
            line=sheet.header_line,
            remedy="give the thickness, so that both are in MPa",
        )
    if test == "biaxial-general" and (stretch2 is None or stress2 is None):
        raise _missing(
            sheet, "the second direction of a general biaxial test", '"stretch 2" and "stress 2 [MPa]"'
        )
    return Reading(stretch, stress, membrane, stretch2, stress2, sd, tuple(notes))


def _stretch(sheet: Sheet, place: str, test: str, sizes: Geometry, decimal: str) -> Array | None:
    direct = _find(sheet, place, "stretch", *(("volume ratio",) if test == "volumetric" else ()))
    strain = _find(sheet, place, "strain", "engineering strain")
    extension = _find(sheet, place, "extension", "displacement", "elongation")
    if direct is not None:
        found, heading = quantities(sheet, direct, "dimensionless", decimal), direct
    elif strain is not None:
        values = quantities(sheet, strain, "dimensionless", decimal)
        if strain.unit is None and np.abs(values).max() > MAX_STRAIN:
            row = int(np.abs(values).argmax())
            raise InputError(
                f"a strain of {values[row]:g} without a unit",
                file=sheet.name,
                line=sheet.lines[row],
                column=strain.title,
                remedy=f'name the column "{strain.title} [%]" if it is in percent, "{strain.title} [-]" if not',
            )
        found, heading = 1.0 + values, strain
    elif extension is not None:
        length = sizes.gauge_length or (sizes.diameter if test.startswith("biaxial") else None)
        if length is None:
            raise InputError(
                "needs the gauge length to become a stretch",
                file=sheet.name,
                column=extension.title,
                remedy='give --gauge-length, or add a line "# gauge length: 50 mm" on top',
            )
        found, heading = 1.0 + quantities(sheet, extension, "length", decimal) / length, extension
    else:
        return None
    wrong = np.flatnonzero(found <= 0.0)
    if wrong.size:
        row = int(wrong[0])
        raise InputError(
            f"a stretch of {found[row]:g} is impossible, it is the length over the first length",
            file=sheet.name,
            line=sheet.lines[row],
            column=heading.title,
            remedy="correct the cell; is the column a strain, or are columns swapped?",
        )
    return found


def _stress(
    sheet: Sheet,
    place: str,
    test: str,
    sizes: Geometry,
    decimal: str,
    stretch: Array | None,
    notes: list[str],
) -> tuple[Array | None, bool, Array | None]:
    """Return (nominal stress, whether it is N/mm, its standard deviation)."""
    nominal = _find(sheet, place, "stress", "nominal stress", "engineering stress")
    true = _find(sheet, place, "true stress", "cauchy stress")
    membrane = _find(sheet, place, "membrane stress")
    force = _find(sheet, place, "force", "load")
    deviation = _find(sheet, place, "stress sd", "membrane stress sd") if not place else None
    sd = None
    if nominal is not None:
        found, per_width = quantities(sheet, nominal, "stress", decimal), False
        if deviation is not None:
            sd = _deviation(sheet, deviation, "stress", decimal)
    elif true is not None:
        if stretch is None:
            raise _missing(sheet, f"the stretch that belongs to {true.title}", f'"stretch{place}"')
        found, per_width = quantities(sheet, true, "stress", decimal), False
        if deviation is not None:
            sd = _deviation(sheet, deviation, "stress", decimal)
        if test != "volumetric":
            found = found / stretch
            sd = None if sd is None else sd / stretch
            notes.append("true stress taken as nominal stress times the stretch (no change of volume)")
    elif membrane is not None:
        found, per_width = quantities(sheet, membrane, "membrane-stress", decimal), True
        if deviation is not None:
            sd = _deviation(sheet, deviation, "membrane-stress", decimal)
    elif force is not None:
        found, per_width = (
            quantities(sheet, force, "force", decimal) / _width(sheet, force, test, sizes),
            True,
        )
        if deviation is not None:
            sd = _deviation(sheet, deviation, "stress", decimal)
            sd = sd if sizes.thickness is None else sd * sizes.thickness
            if sizes.thickness is None:
                raise InputError(
                    "needs the thickness",
                    file=sheet.name,
                    column=deviation.title,
                    remedy='give --thickness, or add a line "# thickness: 0.6 mm" on top',
                )
    else:
        return None, False, None
    if per_width and sizes.thickness is not None:
        found, sd, per_width = found / sizes.thickness, None if sd is None else sd / sizes.thickness, False
    return found, per_width, sd


def _width(sheet: Sheet, force: Heading, test: str, sizes: Geometry) -> float:
    if test.startswith("biaxial") and sizes.diameter is not None:
        return math.pi * sizes.diameter
    if sizes.width is None:
        disc = " or diameter" if test.startswith("biaxial") else ""
        raise InputError(
            f"needs the width{disc} of the specimen to become a stress",
            file=sheet.name,
            column=force.title,
            remedy='give --width, or add a line "# width: 25 mm" on top',
        )
    return sizes.width


def _deviation(sheet: Sheet, heading: Heading, kind: str, decimal: str) -> Array:
    values = quantities(sheet, heading, kind, decimal)
    wrong = np.flatnonzero(values <= 0.0)
    if wrong.size:
        raise InputError(
            f"a standard deviation of {values[wrong[0]]:g}",
            file=sheet.name,
            line=sheet.lines[int(wrong[0])],
            column=heading.title,
            remedy="it is positive; leave the column out where it is not known",
        )
    return values


def _find(sheet: Sheet, place: str, *names: str) -> Heading | None:
    places = (place,) if place else ("", " 1")
    return sheet.find(*(f"{name}{where}" for name in names for where in places))


def _missing(sheet: Sheet, what: str, columns: str) -> InputError:
    titles = ", ".join(heading.title or '""' for heading in sheet.headings[:8])
    return InputError(
        f"no column gives {what}; the columns are {titles}",
        file=sheet.name,
        line=sheet.header_line,
        remedy=f"name one {columns}",
    )
