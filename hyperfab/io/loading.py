"""From what a machine records (extension, force, true stress) to stretch and nominal stress."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.io.angles import shear_strain
from hyperfab.io.cells import is_number
from hyperfab.io.csv_numbers import numbers, other_unit, quantities
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import axis_of, plain
from hyperfab.io.headings import is_of, meaning, unread_unit
from hyperfab.io.kinds_of_tests import Pressed
from hyperfab.io.lengths import first_length, is_counted_anew
from hyperfab.io.role_words import missing, no_stress, no_unit
from hyperfab.io.roles import STRESSES, STRETCHES, Column, Roles
from hyperfab.io.signs import counts_down, farthest, of_mechanics, perhaps_pulled, refuse_either_way
from hyperfab.io.specimen import Specimen
from hyperfab.io.stated import conflicting, perhaps_gauge_length

#: Columns that tell where a grip is, or how long the specimen.
_LENGTHS = ("extension", "length", "position")
#: A strain is not that of the extension beside it where they are apart by this factor: grips slip and yield by less.
#: Where no gauge length is known, between these lengths of a specimen [mm].
_GAINSAID, _SPECIMENS = 30.0, (1.0, 2000.0)
#: Up to this strain a fabric's test in per cent may well be one in shares.
_LITTLE = 0.0101
#: A strain without a unit beyond this is a percentage somebody forgot to mark: no fabric stretches twenty-fold, and
#: few test machines export a strain of more than three without its per cent.
MAX_STRAIN, MAX_MACHINE_STRAIN = 20.0, 3.0


#: Up to this share of the largest load a pull has not begun.
_UNLOADED = 0.1


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


def read_loading(specimen: Specimen, roles: Roles, test: str, pressed: Pressed = "no") -> Loading:
    """Return stretch and nominal stress of all rows, taken as a test of kind ``test``.

    - stretch: ``stretch``, else ``strain`` + 1 (true and Green strains after their definitions), else 1 +
      ``extension`` / gauge length (the diameter of a disc); a machine's position counts from its first row, a gap is a
      length.
    - nominal stress: ``stress``; else ``true stress`` / stretch, which is the same for uniaxial, planar and
      biaxial tension of an incompressible sheet, since force and area share the direction; else ``membrane stress``
      or ``force`` / width (a disc's radial force: / (pi diameter)), in N/mm, divided by the thickness where it is
      known; else force / area.
    - in simple shear: ``shear strain``, else ``extension`` / thickness of the layer; ``shear stress``, else ``force`` /
      area that is sheared.

    Where it is told to be ``pressed``, or a column counts pushing as positive, signs are those of mechanics in what is
    returned.

    Raises InputError where columns or sizes are missing.
    """
    sheet, notes = specimen.sheet, list[str]()
    down = counts_down(sheet, roles, specimen.decimal) if pressed in ("pulled", "no") else None
    turned = down is not None and pressed == "pulled"
    if down is not None and turned:
        notes.append(f"a pull: {' and '.join(one.heading.title for one in down)} count down and are turned round")
    reader = _Reader(specimen, roles, test, pressed == "yes", turned, notes)
    stretch = reader.stretch("")
    if stretch is None and test == "simple-shear":
        raise missing(sheet, roles, "a shear strain", '"shear strain" or "displacement [mm]"')
    if stretch is None and (sheared := roles.first(("shear strain",))) is not None:
        raise sheet.wrong(
            f"a shear strain is of simple shear, and of no {test.replace('shear', 'planar shear')} test",
            sheared.heading,
            remedy='give the file as it is, without --uniaxial, --shear or --biaxial, or say "# test: simple-shear"',
        )
    if stretch is None:
        raise missing(sheet, roles, "a stretch", '"stretch", "strain [%]" or "extension [mm]"')
    stretch2 = reader.stretch(" 2")
    stress, membrane, sd = reader.stress("", stretch)
    if stress is None and test == "simple-shear":
        raise missing(sheet, roles, "a shear stress", '"shear stress [MPa]" or "force [N]"')
    if stress is None:
        raise no_stress(sheet, roles)
    second = roles.first(STRESSES, " 2")
    if second is not None and stretch2 is None and not test.startswith("biaxial"):
        first = roles.first(STRESSES)
        raise sheet.two([one.heading for one in (first, second) if one is not None], second.name.removesuffix(" 2"))
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
        refuse_either_way(sheet, reader.used, stretch, stress)
    if down is not None and not turned and test == "uniaxial" and down[0].name in _LENGTHS:
        notes.append(perhaps_pulled(sheet, down, stretch))
    stretch, stress = of_mechanics(test, pressed, roles.first(("force",)), stretch, stress, notes)
    mode = "biaxial-general" if test == "biaxial" and stretch2 is not None and stress2 is not None else test
    curve = TestCurve(mode, stretch, stress, stretch2=stretch2, stress2=stress2, stress_sd=sd, membrane=membrane)
    return Loading(curve, tuple(notes), tuple(reader.used))


@dataclass
class _Reader:
    """Reads the rows of a sheet as a test; tells in ``notes`` what it took for what, and which columns it ``used``."""

    specimen: Specimen
    roles: Roles
    test: str
    pressed: bool
    down: bool
    notes: list[str]
    used: list[Column] = field(default_factory=list)

    @property
    def sheet(self) -> CsvSheet:
        """The sheet of the specimen."""
        return self.specimen.sheet

    def _values(self, column: Column, kind: str, name: str) -> Array:
        return quantities(self.sheet, column.heading, kind, self.specimen.decimal, name=name)

    def _axis(self, column: Column) -> str:
        """Return the axis, 1 or 2, of a column of a biaxial test; nothing in another."""
        if not self.test.startswith("biaxial"):
            return ""
        found = meaning(column.heading)
        return axis_of(found.axis if found and found.axis else column.name[-1]) or "1"

    def _signed(self, values: Array, column: Column) -> Array:
        """Return readings with the signs of mechanics: pulling is positive."""
        if column.minus or self.down:
            return 0.0 - values
        if column.compressive and len(values) and farthest(values) > 0.0:
            self.notes.append(f"{column.heading.title} counts pushing as positive and is taken as negative")
            return -values
        return values

    def stretch(self, place: str) -> Array | None:
        """Return the stretch (or shear strain) of a place, the first or the second direction."""
        names = (
            ("shear strain", "strain", "extension")
            if self.test == "simple-shear"
            else tuple(one for one in STRETCHES if one != "shear strain")
        )
        column = self.roles.first(names, place)
        if column is None:
            return None
        column = self._through(column)
        self.used.append(column)
        name, head = column.name.removesuffix(" 2"), column.heading
        if self.test == "simple-shear" and name in _LENGTHS:
            return self._from_displacement(column)
        if name in _LENGTHS:
            found = self._from_lengths(column, name)
        else:
            chosen = self.sheet.layout.choice(head, self.sheet.headings)
            if chosen is None and (unit := unread_unit(head)) is not None:
                raise other_unit(self.sheet, head, unit, "dimensionless", column.name)
            values = (
                shear_strain(self.sheet, head, self.specimen.decimal)
                if name == "shear strain"
                else self._values(column, "dimensionless", name)
            )
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
            if self.test == "simple-shear":
                return values
            if name == "strain":
                self._refuse_gainsaid(column, place, values)
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

    def _refuse_gainsaid(self, column: Column, place: str, strain: Array) -> None:
        """Raise InputError where an extension beside a strain makes it a hundred times another: the heading's unit is
        not that of the cells. Where there is none, a strain in per cent that is as little as a share is told."""
        beside, head = self.roles.first(("extension",), place), column.heading
        if self.sheet.layout.choice(head, self.sheet.headings) is not None:
            return
        if beside is None:
            largest = float(np.abs(strain).max(initial=0.0))
            if head.unit == "%" and 0.0 < largest <= _LITTLE:
                self.notes.append(
                    f"{head.title} is {100.0 * largest:.3g} % at most; where its cells are shares, say "
                    + self.sheet.option([(head.title, "strain [-]")])
                )
            return
        if not is_of(beside.heading.unit or "", "length") or not all(
            map(is_number, self.sheet.columns[beside.heading.index])
        ):
            return
        far, way = float(np.ptp(strain)), float(np.ptp(self._values(beside, "length", "extension")))
        known = self.specimen.along(self._axis(column), "gauge length", "grip distance")
        least, most = (known / _GAINSAID, known * _GAINSAID) if known else _SPECIMENS
        if far <= 0.0 or least * far <= way <= most * far:
            return
        over = f" over {known:g} mm" if known else f", which is that of {0.001 * way / far:.3g} m"
        unit = "-" if way > most * far else "%"
        raise self.sheet.wrong(
            f"a strain of {np.abs(strain).max():.3g} beside an extension of {way:.3g} mm{over}",
            head,
            remedy=f"where the cells are {'shares' if unit == '-' else 'per cent'}, say "
            f"{self.sheet.option([(head.title, f'strain [{unit}]')])}; where the heading is right, "
            f"{self.sheet.option([(beside.heading.title, 'aside')])}",
        )

    def _from_displacement(self, column: Column) -> Array:
        """Return the shear strain of a layer whose faces moved along each other."""
        if column.heading.unit is None:
            raise no_unit(self.sheet, column, self.roles)
        thickness = self.specimen.sizes.thickness
        if thickness is None:
            self.specimen.refuse_untaken("thickness")
            raise InputError(
                "needs the thickness of the sheared layer to become a shear strain",
                column=column.heading.title,
                remedy='give --thickness 2mm, or add a line "# thickness: 2 mm" on top',
            )
        self.notes.append(f"{column.heading.title} is over a sheared layer of {thickness:g} mm")
        return self._signed(self._values(column, "length", column.name), column) / thickness

    def _whole(self, column: Column) -> Column | None:
        """Return the column of the length of what an extension is told of, where it has a number in every row."""
        whole = self.roles.first(("length",), " 2" if column.name.endswith(" 2") else "")
        known = whole and is_of(whole.heading.unit or "", "length")
        return whole if whole and known and all(map(is_number, self.sheet.columns[whole.heading.index])) else None

    def _through(self, column: Column) -> Column:
        """Return the length beside an extension that is counted anew for each part, in which both move alike."""
        whole = self._whole(column)
        if whole is None or column.name.removesuffix(" 2") != "extension":
            return column
        if not is_counted_anew(*(self._values(one, "length", one.name) for one in (column, whole))):
            return column
        self.notes.append(f"{column.heading.title} begins anew in mid-test; {whole.heading.title} is taken")
        return whole

    def _from_lengths(self, column: Column, name: str) -> Array:
        head = column.heading
        if head.unit is None:
            raise no_unit(self.sheet, column, self.roles)
        sizes = self.specimen.sizes
        if self.specimen.given.gauge_length is None:
            conflicting(self.sheet, self.specimen.decimal)
        axis = self._axis(column)
        own = self.specimen.stated("extensometer length") if "extensometer" in plain(head.label) else None
        length = own or self.specimen.along(axis, "gauge length", "grip distance")
        length = length or (sizes.diameter if self.test.startswith("biaxial") else None)
        values = self._values(column, "length", name)
        whole = self._whole(column) if length is None and name == "extension" else None
        if whole and (length := first_length(values, self._values(whole, "length", whole.name))):
            self.notes.append(f"{whole.heading.title} less {head.title}, {length:g} mm, is the gauge length")
        if name == "length":
            if length is None:
                length = float(values[0])
                self.notes.append(f"{head.title} is the length; its first, {length:g} mm, is taken as the gauge length")
            return values / length
        if length is None:
            self.specimen.refuse_untaken("gauge length", "grip distance")
            pressed = self.pressed or column.compressive
            force = self.roles.first(STRESSES, " 2" if column.name.endswith(" 2") else "")
            too = force is not None and force.name.startswith("force") and not self.specimen.tells_section(axis)
            raise InputError(
                "needs the gauge length to become a stretch",
                column=head.title,
                remedy=perhaps_gauge_length(self.sheet, self.specimen.decimal, pressed)
                + (f"; {force.heading.title} needs a width too, --width 25mm" if force is not None and too else ""),
            )
        values = self._signed(values, column)
        if sizes.gauge_length is None and axis and sizes.diameter is None:
            self.notes.append(f"{head.title} is over a gauge length of {length:g} mm")
        if name == "position" or self._is_place(values, column):
            values = values - values[0]
            self.notes.append(f"{head.title} is counted from its first row")
        return 1.0 + values / length

    def _is_place(self, values: Array, column: Column) -> bool:
        """Whether an extension is where the crosshead stands: more than it changes by, with next to no load yet."""
        force = self.roles.first(STRESSES, " 2" if column.name.endswith(" 2") else "")
        if column.name.removesuffix(" 2") != "extension" or force is None or not abs(values[0]) > np.ptp(values) > 0.0:
            return False
        loads = np.abs(numbers(self.sheet, force.heading, self.specimen.decimal))
        return bool(loads[0] <= _UNLOADED * loads.max())

    def stress(self, place: str, stretch: Array | None) -> tuple[Array | None, bool, Array | None]:
        """Return (nominal stress, whether it is N/mm, its standard deviation)."""
        names = (
            ("shear stress", "stress", "membrane stress", "force")
            if self.test == "simple-shear"
            else tuple(one for one in STRESSES if one != "shear stress")
        )
        column = self.roles.first(names, place)
        if column is None:
            return None, False, None
        self.used.append(column)
        name, head = column.name.removesuffix(" 2"), column.heading
        if head.unit is None:
            raise no_unit(self.sheet, column, self.roles)
        deviation = self.roles.columns.get("stress sd") if not place else None
        kind, per_width = ("membrane-stress", True) if name == "membrane stress" else ("stress", False)
        found = self._signed(self._values(column, "force" if name == "force" else kind, name), column)
        if name == "force":
            pressed = self.pressed or column.compressive or (stretch is not None and farthest(stretch, 1.0) < 1.0)
            over, per_width = self.specimen.over(self.test, head.title, pressed, self._axis(column))
            found = found / over
            if per_width and self.specimen.sizes.width is None and self.specimen.sizes.diameter is None:
                self.notes.append(f"{head.title} is over a width of {over:g} mm")
        sd = None
        thickness = self.specimen.sizes.thickness
        if deviation is not None:
            self.used.append(deviation)
            sd = self._deviation(deviation, kind, found, stretch)
            if name == "force" and per_width and thickness is None:
                raise InputError(
                    "needs the thickness",
                    column=deviation.heading.title,
                    remedy='give --thickness, or add a line "# thickness: 0.6 mm" on top',
                )
        if name == "true stress" and self.test != "volumetric":
            if stretch is None:
                raise missing(self.sheet, self.roles, f"the stretch that belongs to {head.title}", f'"stretch{place}"')
            found, sd = found / stretch, None if sd is None else sd / stretch
            self.notes.append("true stress taken as nominal stress times the stretch (no change of volume)")
        if per_width and thickness is None:
            self.specimen.refuse_untaken("thickness")
        if per_width and thickness is not None:
            found, per_width = found / thickness, False
            sd = sd if sd is None or name == "force" else sd / thickness
        return found, per_width, sd

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
