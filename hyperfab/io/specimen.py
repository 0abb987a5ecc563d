"""From what a machine records (extension, force, true stress) to stretch and nominal stress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.io.csv_numbers import numbers, other_unit, quantities
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.headings import KIND, unread_unit
from hyperfab.io.kinds_of_tests import Pressed
from hyperfab.io.role_words import missing, no_stress, no_stretch, unitless
from hyperfab.io.roles import STRESSES, STRETCHES, Column, Roles
from hyperfab.io.stated import amount, conflicting, perhaps_gauge_length, stated, untaken

#: Columns that tell where a grip is, or how long the specimen.
_LENGTHS = ("extension", "length", "position")
#: A strain without a unit beyond this is a percentage somebody forgot to mark: no fabric stretches twenty-fold, and
#: few test machines export a strain of more than three without its per cent.
MAX_STRAIN, MAX_MACHINE_STRAIN = 20.0, 3.0


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
class Loading:
    """Stretch and stress of the rows of a sheet; ``used`` are the columns that were taken."""

    curve: TestCurve
    notes: tuple[str, ...]
    used: tuple[Column, ...]

    @property
    def extended(self) -> bool:
        """Whether the stretch is how much longer the whole gauge length became."""
        return self.used[0].name in _LENGTHS


def read_geometry(sheet: CsvSheet, options: Geometry, decimal: str, notes: list[str]) -> Geometry:
    """Return the specimen's sizes: those given as options, else those the file states in one way.

    What a machine's preamble states without a unit, or twice, is not taken, and ``notes`` says so.
    """
    found = {}
    for key in ("gauge_length", "width", "thickness", "diameter", "area"):
        value = getattr(options, key)
        if value is None:
            kind = "area" if key == "area" else "length"
            value = amount(sheet, key.replace("_", " "), kind, decimal, notes)
            if value is None and key == "gauge_length":
                value = amount(sheet, "grip distance", kind, decimal, notes)
            if value is not None and value <= 0.0:
                entry = stated(sheet, key.replace("_", " "))
                raise InputError(
                    "is not positive",
                    file=sheet.name,
                    line=entry.line if entry else None,
                    key=key.replace("_", " "),
                    remedy="write the size of the undeformed specimen",
                )
        found[key] = value
    return Geometry(**found)


def read_loading(
    sheet: CsvSheet,
    roles: Roles,
    test: str,
    sizes: Geometry,
    decimal: str,
    options: Geometry,
    pressed: Pressed = "no",
) -> Loading:
    """Return stretch and nominal stress of all rows, taken as a test of kind ``test``.

    - stretch: ``stretch``, else ``strain`` + 1 (true and Green strains after their definitions), else 1 +
      ``extension`` / gauge length (the diameter of a disc); a machine's position counts from its first row, a gap is a
      length.
    - nominal stress: ``stress``; else ``true stress`` / stretch, which is the same for uniaxial, planar and
      biaxial tension of an incompressible sheet, since force and area share the direction; else ``membrane stress``
      or ``force`` / width (a disc's radial force: / (pi diameter)), in N/mm, divided by the thickness where it is
      known; else force / area.

    Where it is told to be ``pressed``, or a column counts pushing as positive, signs are those of mechanics in what is
    returned.

    Raises InputError where columns or sizes are missing.
    """
    reader = _Reader(sheet, roles, test, sizes, decimal, options, pressed == "yes")
    notes = reader.notes
    if pressed == "pulled":
        reader.turn()
    stretch = reader.stretch("")
    if stretch is None:
        raise no_stretch(sheet, roles)
    stretch2 = reader.stretch(" 2")
    stress, membrane, sd = reader.stress("", stretch)
    if stress is None:
        raise no_stress(sheet, roles)
    second = roles.first(STRESSES, " 2")
    if second is not None and stretch2 is None and not test.startswith("biaxial"):
        first = roles.first(STRESSES)
        raise sheet.two(
            [one.heading for one in (first, second) if one is not None], second.name.removesuffix(" 2")
        )
    stress2, membrane2, _ = reader.stress(" 2", stretch2)
    if stress2 is not None and membrane2 != membrane:
        raise sheet.wrong(
            "the two directions are in different units (MPa and N/mm)",
            remedy="give the thickness, so that both are in MPa",
        )
    if test == "biaxial-general" and (stretch2 is None or stress2 is None):
        raise missing(
            sheet, roles, "the second direction of a general biaxial test", '"stretch 2" and "stress 2 [MPa]"'
        )
    if pressed == "perhaps" and test == "uniaxial":
        _refuse_either_way(sheet, reader.used, stretch, stress)
    column = roles.first(("force",))
    pulled = test == "uniaxial" and stretch[int(np.abs(stretch - 1.0).argmax())] > 1.0
    if pulled and column is not None and not column.minus and stress.max() < 0.05 * -stress.min():
        # A rheometer's normal force, a load cell that counts pulling as negative; a stress is as stated.
        stress = 0.0 - stress
        notes.append(f"{column.heading.title} counts pushing as positive: what pulls is taken as positive")
    if pressed == "yes" and test in ("uniaxial", "confined-compression"):
        if stretch[int(np.abs(stretch - 1.0).argmax())] > 1.0:
            stretch = 2.0 - stretch
            notes.append("a compression test: its strain, counted positive in the file, is taken as negative")
        if stress[int(np.abs(stress).argmax())] > 0.0:
            stress = -stress
            notes.append("a compression test: its stress, counted positive in the file, is taken as negative")
    mode = "biaxial-general" if test == "biaxial" and stretch2 is not None and stress2 is not None else test
    curve = TestCurve(
        mode, stretch, stress, stretch2=stretch2, stress2=stress2, stress_sd=sd, membrane=membrane
    )
    return Loading(curve, tuple(notes), tuple(reader.used))


def _refuse_either_way(sheet: CsvSheet, used: Sequence[Column], stretch: Array, stress: Array) -> None:
    """InputError where a word says compression, nothing says that it is of the test, and the readings are of a pull."""
    pull, push = used[:2]
    if stretch[int(np.abs(stretch - 1.0).argmax())] <= 1.0 or pull.compressive or push.compressive:
        return
    if all(sheet.layout.choice(one.heading, sheet.headings) for one in (pull, push)):
        return
    behind = "-" if stress[int(np.abs(stress).argmax())] < 0.0 else ""

    def option(sign: str, other: str) -> str:
        signed = ((sign, pull), (other, push))
        return sheet.option(
            [
                (
                    one.heading.title,
                    f"{minus}{one.name}" + (f" [{one.heading.unit}]" if one.heading.unit else ""),
                )
                for minus, one in signed
            ]
        )

    raise sheet.wrong(
        f"a word says compression, and {pull.heading.title} grows: was the specimen pressed, or is that what it is of?",
        remedy=f"if it was pulled, say {option('', behind)}; if it was pressed, "
        f'{option("-", "" if behind else "-")}, or add a first line "# test: compression"',
    )


@dataclass
class _Reader:
    """Reads the rows of a sheet as a test; tells in ``notes`` what it took for what, and which columns it ``used``."""

    sheet: CsvSheet
    roles: Roles
    test: str
    sizes: Geometry
    decimal: str
    options: Geometry
    pressed: bool = False
    down: bool = False
    notes: list[str] = field(default_factory=list)
    used: list[Column] = field(default_factory=list)

    def _values(self, column: Column, kind: str, name: str) -> Array:
        return quantities(self.sheet, column.heading, kind, self.decimal, name=name)

    def turn(self) -> None:
        """Count a pull up whose stretch and stress both go down, as of a stand that counts pushing as positive."""
        pull, push = self.roles.first(("extension", "position", "strain")), self.roles.first(STRESSES)
        if pull is None or push is None or self.roles.first(STRETCHES) is not pull:
            return
        both = (pull, push)
        if any(one.compressive or self.sheet.layout.choice(one.heading, self.sheet.headings) for one in both):
            return
        readings = [numbers(self.sheet, one.heading, self.decimal) for one in both]
        if pull.name == "position":
            readings[0] = readings[0] - readings[0][0]
        self.down = all(values[int(np.abs(values).argmax())] < 0.0 for values in readings)
        if self.down:
            titles = " and ".join(one.heading.title for one in both)
            self.notes.append(f"a pull: {titles} count down and are turned round")

    def _signed(self, values: Array, column: Column) -> Array:
        """Return readings with the signs of mechanics: pulling is positive."""
        if column.minus or self.down:
            return 0.0 - values
        if column.compressive and len(values) and values[int(np.abs(values).argmax())] > 0.0:
            self.notes.append(f"{column.heading.title} counts pushing as positive and is taken as negative")
            return -values
        return values

    def stretch(self, place: str) -> Array | None:
        """Return the stretch (or shear strain) of a place, the first or the second direction."""
        names = (
            ("shear strain",)
            if self.test == "simple-shear"
            else tuple(one for one in STRETCHES if one != "shear strain")
        )
        column = self.roles.first(names, place)
        if column is None:
            return None
        self.used.append(column)
        name, head = column.name.removesuffix(" 2"), column.heading
        if name in _LENGTHS:
            found = self._from_lengths(column, name)
        else:
            chosen = self.sheet.layout.choice(head, self.sheet.headings)
            if chosen is None and (unit := unread_unit(head)) is not None:
                raise other_unit(self.sheet, head, unit, "dimensionless", column.name)
            values = self._values(column, "dimensionless", name)
            largest = float(np.abs(values).max()) if len(values) else 0.0
            contract = head.name.rstrip(" 12") in ("strain", "engineering strain")
            percent = any("%" in cell for cell in self.sheet.columns[head.index][:1])
            if (
                name != "stretch"
                and head.unit is None
                and not percent
                and largest > (MAX_STRAIN if contract else MAX_MACHINE_STRAIN)
            ):
                row = int(np.abs(values).argmax())
                raise self.sheet.wrong(
                    f"a strain of {values[row]:g} without a unit",
                    head,
                    row=row,
                    remedy=f'name the column "{head.title} [%]" if it is in percent, "{head.title} [-]" if not, or say '
                    + self.sheet.option([(head.title, f"{name} [%]")]),
                )
            values = self._signed(values, column)
            if name == "shear strain":
                return values
            if name == "true strain":
                found = np.exp(values)
            elif name == "green strain":
                found = np.sqrt(np.maximum(1.0 + 2.0 * values, 0.0))
            else:
                found = values if name in ("stretch", "volume ratio") else 1.0 + values
        wrong = np.flatnonzero(found <= 0.0)
        if wrong.size:
            row = int(wrong[0])
            raise self.sheet.wrong(
                f"a stretch of {found[row]:g} is impossible, it is the length over the first length",
                head,
                row=row,
                remedy="correct the cell; is the column a strain, or are columns swapped?",
            )
        return found

    def _from_lengths(self, column: Column, name: str) -> Array:
        head = column.heading
        if head.unit is None:
            raise no_unit(self.sheet, column, self.roles)
        if self.options.gauge_length is None:
            conflicting(self.sheet, self.decimal)
        length = self.sizes.gauge_length or (self.sizes.diameter if self.test.startswith("biaxial") else None)
        values = self._values(column, "length", name)
        if name == "length":
            if length is None:
                length = float(values[0])
                self.notes.append(
                    f"{head.title} is the length; its first, {length:g} mm, is taken as the gauge length"
                )
            return values / length
        if length is None:
            self._refuse_untaken("gauge length", "grip distance")
            raise InputError(
                "needs the gauge length to become a stretch",
                file=self.sheet.name,
                column=head.title,
                remedy=perhaps_gauge_length(self.sheet, self.decimal, self.pressed or column.compressive),
            )
        values = self._signed(values, column)
        if name == "position":
            values = values - values[0]
            self.notes.append(f"{head.title} is counted from its first row")
        return 1.0 + values / length

    def stress(self, place: str, stretch: Array | None) -> tuple[Array | None, bool, Array | None]:
        """Return (nominal stress, whether it is N/mm, its standard deviation)."""
        names = (
            ("shear stress", "force")
            if self.test == "simple-shear"
            else tuple(one for one in STRESSES if one != "shear stress")
        )
        column = self.roles.first(names, place)
        if column is None:
            return None, False, None
        self.used.append(column)
        name, head = column.name.removesuffix(" 2"), column.heading
        if head.unit is None:
            raise no_unit(
                self.sheet, column, self.roles, f"{head.title} [{'N' if name == 'force' else 'MPa'}]"
            )
        deviation = self.roles.columns.get("stress sd") if not place else None
        kind, per_width = ("membrane-stress", True) if name == "membrane stress" else ("stress", False)
        factor: float | Array = 1.0
        if name == "force":
            kind = "force"
            far = 1.0 if stretch is None else stretch[int(np.abs(stretch - 1.0).argmax())]
            factor, per_width = self._over(column, self.pressed or column.compressive or bool(far < 1.0))
        found = self._signed(self._values(column, kind, name), column) / factor
        sd = None
        if deviation is not None:
            self.used.append(deviation)
            found_sd = self._deviation(deviation, kind if name != "force" else "stress", found, stretch)
            if name == "force" and per_width:
                if self.sizes.thickness is None:
                    raise InputError(
                        "needs the thickness",
                        file=self.sheet.name,
                        column=deviation.heading.title,
                        remedy='give --thickness, or add a line "# thickness: 0.6 mm" on top',
                    )
                found_sd = found_sd * self.sizes.thickness
            sd = found_sd
        if name == "true stress" and self.test != "volumetric":
            if stretch is None:
                raise missing(
                    self.sheet, self.roles, f"the stretch that belongs to {head.title}", f'"stretch{place}"'
                )
            found = found / stretch
            sd = None if sd is None else sd / stretch
            self.notes.append("true stress taken as nominal stress times the stretch (no change of volume)")
        if per_width and self.sizes.thickness is None:
            self._refuse_untaken("thickness")
        if per_width and self.sizes.thickness is not None:
            found, per_width = found / self.sizes.thickness, False
            sd = None if sd is None else sd / self.sizes.thickness
        return found, per_width, sd

    def _refuse_untaken(self, *keys: str) -> None:
        """InputError where the file states a size that is needed and cannot be taken."""
        for key in keys:
            if (error := untaken(self.sheet, key, self.decimal)) is not None:
                raise error

    def _over(self, column: Column, pressed: bool) -> tuple[float, bool]:
        """Return what a force is divided by, and whether that is a width [mm] and no area [mm^2]."""
        if self.test.startswith("biaxial") and self.sizes.diameter is not None:
            return math.pi * self.sizes.diameter, True
        if self.test in ("uniaxial", "shear", "confined-compression"):
            area = self._area(pressed)
            if area is not None:
                return area, False
        if self.sizes.width is not None:
            return self.sizes.width, True
        if self.sizes.area is not None:
            return self.sizes.area, False
        if self.sizes.diameter is not None:
            return math.pi * self.sizes.diameter**2 / 4.0, False
        self._refuse_untaken("width")
        disc = " or diameter" if self.test.startswith("biaxial") else ""
        raise InputError(
            f"needs the width{disc} of the specimen to become a stress",
            file=self.sheet.name,
            column=column.heading.title,
            remedy='give --width 25mm, or add a line "# width: 25 mm" on top',
        )

    def _area(self, pressed: bool) -> float | None:
        """Return the section [mm^2] where the file states it, or a block that is pressed; None where it is to be made.

        A block that is pressed along its height, or thickness, stands on length times width. InputError where an area
        gainsays the other sizes; those given as options count more than it.
        """
        sizes, area, given = self.sizes, self.sizes.area, self.options
        if sizes.width is None or sizes.diameter is not None:
            return area
        if not (given.width is None and given.thickness is None):
            return None
        across, name = sizes.thickness, "thickness"
        cube = across == sizes.width == sizes.gauge_length
        if pressed and not cube and (sizes.gauge_length is None or across in (None, sizes.gauge_length)):
            across, name = (
                amount(self.sheet, "specimen length", "length", self.decimal, []),
                "specimen length",
            )
        if area is None:
            if name == "thickness":
                return None
            if across is None:
                raise self._no_area(sizes.width)
            return sizes.width * across
        if across is None or abs(area - sizes.width * across) <= AREA * area:
            return area if across is None or name != "thickness" else None
        one, two = stated(self.sheet, "area"), stated(self.sheet, name)
        options = (
            f"--width {sizes.width:g}mm --thickness {across:g}mm, or for the area --width {sizes.width:g}mm "
        )
        raise InputError(
            f"states an area of {area:g} mm^2, and a width and {name} of {sizes.width * across:g} mm^2",
            file=self.sheet.name,
            line=one.line if one else None,
            remedy=f"correct it, or line {two.line if two else 0}"
            if name != "thickness"
            else f"say which: {options}--thickness {area / sizes.width:g}mm",
        )

    def _no_area(self, width: float) -> InputError:
        """Return the error that of a block that is pressed the section is not known."""
        thickness = self.sizes.thickness
        section = (
            f"if it is width times thickness, give --width {width:g}mm --thickness {thickness or 0.0:g}mm; "
        )
        return InputError(
            "needs the area that is pressed" + (": the thickness may be the height" if thickness else ""),
            file=self.sheet.name,
            remedy=(section if thickness else "")
            + f'if it is as long as wide, add a line "# area: {width**2:g} mm^2" on top',
        )

    def _deviation(self, column: Column, kind: str, stress: Array, stretch: Array | None) -> Array:
        """Return standard deviations; one of zero at rest, where a reading was zeroed, the smallest of the others."""
        values = self._values(column, kind, "stress sd")
        rest = np.abs(stress) <= 1e-9 * float(np.abs(stress).max())
        if stretch is not None:
            rest |= np.abs(stretch - 1.0) <= 1e-9
        known = values[values > 0.0]
        if len(known):
            values = np.where((values == 0.0) & rest, known.min(), values)
        wrong = np.flatnonzero(values <= 0.0)
        if wrong.size:
            raise self.sheet.wrong(
                f"a standard deviation of {values[wrong[0]]:g}",
                column.heading,
                row=wrong[0],
                remedy="it is positive; leave the column out where it is not known",
            )
        return values


def no_unit(sheet: CsvSheet, column: Column, roles: Roles, example: str = "") -> InputError:
    """Return the error that a column lacks its unit, with an example of it and the option that gives it."""
    name = column.name.removesuffix(" 2")
    if (unit := unread_unit(column.heading)) is not None:
        return other_unit(sheet, column.heading, unit, KIND[name], column.name)
    return sheet.wrong(
        "has no unit",
        column.heading,
        remedy=f'write it behind the name, as in "{example or f"{column.heading.title} [mm]"}", or say '
        f"{unitless(sheet, [*roles.columns.values()])}",
    )
