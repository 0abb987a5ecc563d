"""The undeformed specimen: its sizes, as options or the file state them, and the section that a force is over."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hyperfab.errors import InputError
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.stated import amount, stated, untaken

#: How far a stated area may be from width times thickness: a thickness is written to a tenth of a millimetre.
AREA = 0.05


@dataclass(frozen=True)
class Geometry:
    """The undeformed specimen [mm]; what is not known is None.

    A biaxial disc has a ``diameter`` and no width, so has a round specimen that is pulled or compressed; ``area``
    [mm^2] is its section, where that is stated.
    """

    gauge_length: float | None = None
    width: float | None = None
    thickness: float | None = None
    diameter: float | None = None
    area: float | None = None

    @property
    def aspect(self) -> float | None:
        """Length over width, where both are known."""
        if self.gauge_length is None or self.width is None:
            return None
        return self.gauge_length / self.width


@dataclass(frozen=True)
class Specimen:
    """The specimen of a sheet: its ``sizes``, and of them those ``given`` as options, which count more than the file's.

    ``decimal`` is the mark that the file's numbers have.
    """

    sheet: CsvSheet
    sizes: Geometry
    given: Geometry
    decimal: str

    def along(self, axis: str, *keys: str) -> float | None:
        """Return the first of some sizes [mm], where the two axes have one each that of the ``axis``, 1 or 2."""
        both = (getattr(self.sizes, key.replace(" ", "_"), None) for key in keys)
        own = (amount(self.sheet, key, "length", self.decimal, [], axis) for key in keys if axis)
        return next((one for one in (*both, *own) if one is not None), None)

    def stated(self, key: str) -> float | None:
        """Return a length [mm] that the file states, or None."""
        return amount(self.sheet, key, "length", self.decimal, [])

    def tells_section(self, axis: str) -> bool:
        """Return whether a size is known that a force along an ``axis``, 1 or 2 in a biaxial test, can be over."""
        sizes = self.sizes
        return self.along(axis, "width") is not None or (sizes.area or sizes.diameter) is not None

    def refuse_untaken(self, *keys: str) -> None:
        """InputError where the file states a size that is needed and cannot be taken."""
        for key in keys:
            if (error := untaken(self.sheet, key, self.decimal)) is not None:
                raise error

    def over(self, test: str, title: str, pressed: bool, axis: str) -> tuple[float, bool]:
        """Return what a force is divided by, and whether that is a width [mm] and no area [mm^2].

        ``title`` is the force's, for the error that no size is known; ``axis`` 1 or 2 in a biaxial test.
        """
        sizes = self.sizes
        if test.startswith("biaxial") and sizes.diameter is not None:
            return math.pi * sizes.diameter, True
        if test == "simple-shear":
            return self._sheared_area(title), False
        if test in ("uniaxial", "shear", "confined-compression"):
            area = self._area(pressed)
            if area is not None:
                return area, False
        if (width := self.along(axis, "width")) is not None:
            return width, True
        if sizes.area is not None:
            return sizes.area, False
        if sizes.diameter is not None:
            return math.pi * sizes.diameter**2 / 4.0, False
        self.refuse_untaken("width")
        disc = " or diameter" if test.startswith("biaxial") else ""
        raise InputError(
            f"needs the width{disc} of the specimen to become a stress",
            column=title,
            remedy='give --width 25mm, or add a line "# width: 25 mm" on top',
        )

    def _sheared_area(self, title: str) -> float:
        """Return the area [mm^2] of the face that a force shears: stated, of a disc, or length times width."""
        sizes, length = self.sizes, self.stated("specimen length")
        if sizes.area is not None:
            return sizes.area
        if sizes.diameter is not None:
            return math.pi * sizes.diameter**2 / 4.0
        if sizes.width is not None and length is not None:
            return sizes.width * length
        self.refuse_untaken("area", "specimen length", "width")
        raise InputError(
            "needs the area that is sheared to become a stress",
            column=title,
            remedy='add a line "# area: 500 mm2" on top, that of all faces which bear the force',
        )

    def _area(self, pressed: bool) -> float | None:
        """Return the section [mm^2] where the file states it, or a block that is pressed; None where it is to be made.

        A block that is pressed along its height, or thickness, stands on length times width. InputError where an area
        gainsays the other sizes; those given as options count more than it.
        """
        sizes, area = self.sizes, self.sizes.area
        if sizes.width is None or sizes.diameter is not None:
            return area
        if not (self.given.width is None and self.given.thickness is None):
            return None
        across, name = sizes.thickness, "thickness"
        cube = across == sizes.width == sizes.gauge_length
        if pressed and not cube and (sizes.gauge_length is None or across in (None, sizes.gauge_length)):
            across, name = self.stated("specimen length"), "specimen length"
        if area is None and name == "thickness":
            return None
        if area is None and across is None:
            raise self._no_area(sizes.width)
        if area is None or across is None:
            return area if across is None else sizes.width * across
        if abs(area - sizes.width * across) <= AREA * area:
            return area if name != "thickness" else None
        one, two = stated(self.sheet, "area"), stated(self.sheet, name)
        options = f"--width {sizes.width:g}mm --thickness {across:g}mm, or for the area --width {sizes.width:g}mm "
        raise InputError(
            f"states an area of {area:g} mm^2, and a width and {name} of {sizes.width * across:g} mm^2",
            line=one.line if one else None,
            remedy=f"correct it, or line {two.line if two else 0}"
            if name != "thickness"
            else f"say which: {options}--thickness {area / sizes.width:g}mm",
        )

    def _no_area(self, width: float) -> InputError:
        """Return the error that of a block that is pressed the section is not known."""
        thickness = self.sizes.thickness
        section = f"if it is width times thickness, give --width {width:g}mm --thickness {thickness or 0.0:g}mm; "
        return InputError(
            "needs the area that is pressed" + (": the thickness may be the height" if thickness else ""),
            remedy=(section if thickness else "")
            + f'if it is as long as wide, add a line "# area: {width**2:g} mm^2" on top',
        )


def read_specimen(sheet: CsvSheet, given: Geometry, decimal: str, notes: list[str]) -> Specimen:
    """Return the specimen, its sizes those ``given`` as options, else those the file states in one way.

    What a machine's preamble states without a unit, or twice, is not taken, and ``notes`` says so.
    """
    found = {}
    for key in ("gauge_length", "width", "thickness", "diameter", "area"):
        value = getattr(given, key)
        if value is None:
            kind = "area" if key == "area" else "length"
            value = amount(sheet, key.replace("_", " "), kind, decimal, notes)
            if value is None and key == "gauge_length":
                value = amount(sheet, "grip distance", kind, decimal, notes)
            if value is not None and value <= 0.0:
                entry = stated(sheet, key.replace("_", " "))
                raise InputError(
                    "is not positive",
                    line=entry.line if entry else None,
                    key=key.replace("_", " "),
                    remedy="write the size of the undeformed specimen",
                )
        found[key] = value
    return Specimen(sheet, Geometry(**found), given, decimal)
