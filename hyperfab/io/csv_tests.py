"""Fabric tests as testing machines export them, read into stretch and nominal stress."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hyperfab.errors import InputError
from hyperfab.io.csv_dialect import Heading, Sheet, open_sheet
from hyperfab.io.csv_numbers import numbers, quantities, settle_decimal, words
from hyperfab.io.specimen import Geometry, Reading, read_geometry, read_loading
from hyperfab.io.units import quantity

#: The deformation modes a test can be in.
TESTS = ("uniaxial", "shear", "biaxial", "biaxial-general", "volumetric")
_TEST_NAMES = {
    "planar": "shear", "planar tension": "shear", "pure shear": "shear", "planar shear": "shear",
    "equibiaxial": "biaxial", "equi biaxial": "biaxial", "biaxial general": "biaxial-general",
    "tension": "uniaxial", "tensile": "uniaxial",
}  # fmt: skip
_DIRECTIONS = {"warp": 0.0, "weft": 90.0, "wale": 0.0, "course": 90.0}
_BRANCHES = {"load": 1, "loading": 1, "unload": -1, "unloading": -1}

Array = NDArray[np.float64]

#: Beyond these no fabric or rubber was ever tested: a wrong unit or a wrong column. The stress is the largest of a
#: test, in MPa or N/mm.
LARGEST_STRETCH = 50.0
PEAK_STRESS = (1e-9, 1e6)


@dataclass(frozen=True)
class TestData:
    """One test of one specimen in one direction: every row of the file, in its order.

    Arrays have one entry a row. ``stress`` is nominal [MPa], or force per undeformed width [N/mm] where ``membrane``
    is true (no thickness is known). ``direction`` is in degrees from the warp. ``branch`` is 1 on loading and -1 on
    unloading. For a volumetric test ``stretch`` is the volume ratio and ``stress`` the mean stress.
    What the file does not tell is None.
    """

    __test__ = False  # no test class for pytest

    source: str
    test: str
    stretch: Array
    stress: Array
    lines: NDArray[np.int64]
    membrane: bool = False
    stretch2: Array | None = None
    stress2: Array | None = None
    stress_sd: Array | None = None
    time_s: Array | None = None
    temperature_degC: Array | None = None
    rate_1_s: Array | None = None
    cycle: NDArray[np.int64] | None = None
    branch: NDArray[np.int64] | None = None
    direction: float | None = None
    specimen: str | None = None
    thickness_mm: float | None = None
    left_out: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)

    @property
    def direction_name(self) -> str | None:
        """``warp``, ``weft``, or the angle from the warp as text."""
        if self.direction is None:
            return None
        return {0.0: "warp", 90.0: "weft"}.get(self.direction, f"{self.direction:g} deg")

    @property
    def stress_unit(self) -> str:
        """``MPa``, or ``N/mm`` for membrane stress."""
        return "N/mm" if self.membrane else "MPa"


def read_tests(
    data: bytes,
    name: str,
    *,
    test: str | None = None,
    geometry: Geometry | None = None,
    decimal: str | None = None,
) -> list[TestData]:
    """Read the tests of one CSV file: one TestData a test, direction and specimen, in the order of the file.

    ``test`` is what the command line says the file is; a file that says otherwise is refused. ``geometry`` holds
    the specimen's sizes given as options, which take precedence over the file's own. Every row with a reading is
    kept; ``left_out`` counts the others by reason.

    Raises InputError with file, line and column where the file cannot be understood in exactly one way, or tells
    what no test can have shown.

    >>> [found] = read_tests(b"# test: shear\\nstrain [%],stress [kPa]\\n10,120\\n20,210\\n", "shear.csv")
    >>> found.test, found.stretch, found.stress
    ('shear', array([1.1, 1.2]), array([0.12, 0.21]))
    """
    sheet = open_sheet(data, name)
    given = _declared_test(test, name)
    tests = _tests_of_rows(sheet, given)
    numeric = [heading for heading in sheet.headings if heading.name in _NUMERIC]
    mark = settle_decimal(sheet, numeric, decimal)
    sizes = read_geometry(sheet, geometry or Geometry())
    directions = _directions(sheet)
    specimens = _words_or_meta(sheet, "specimen")
    groups = _groups(tests, directions, specimens)
    kinds = sorted({kind for kind, _, _ in groups})
    readings = {kind: read_loading(sheet, kind, sizes, mark) for kind in kinds}
    columns = _columns(sheet, mark)
    notes = _unused(sheet)
    left_out = {"blank row": sheet.blank_rows} if sheet.blank_rows else {}
    metadata = {key: entries[0].value for key, entries in sheet.metadata.items()}
    lines = np.array(sheet.lines, dtype=np.int64)
    found = []
    for (kind, direction, specimen), rows in groups.items():
        reading = readings[kind].rows(rows)
        part = TestData(
            source=name,
            test=_refined(kind, reading),
            stretch=reading.stretch,
            stress=reading.stress,
            lines=lines[rows],
            membrane=reading.membrane,
            stretch2=reading.stretch2,
            stress2=reading.stress2,
            stress_sd=reading.stress_sd,
            direction=direction,
            specimen=specimen,
            thickness_mm=sizes.thickness,
            left_out=left_out,
            notes=(*reading.notes, *notes),
            metadata=metadata,
            **{key: None if column is None else column[rows] for key, column in columns.items()},
        )
        _check(part, sheet)
        found.append(part)
    if sum(len(part.stretch) for part in found) < 2:
        raise InputError(
            "has one row, a curve needs at least two",
            file=name,
            line=sheet.lines[0],
            remedy="export the whole test",
        )
    return found


_NUMERIC = frozenset(
    f"{kind}{place}"
    for kind in (
        "strain", "stretch", "stress", "nominal stress", "engineering stress", "engineering strain", "true stress",
        "cauchy stress", "membrane stress", "extension", "force", "displacement", "elongation", "load",
        "volume ratio", "stress sd", "membrane stress sd", "time", "temperature", "rate", "cycle",
    )
    for place in ("", " 1", " 2")
)  # fmt: skip


def _declared_test(test: str | None, name: str) -> str | None:
    if test is None:
        return None
    folded = test.strip().casefold().replace("_", "-")
    found = folded if folded in TESTS else _TEST_NAMES.get(folded.replace("-", " "))
    if found is None:
        raise InputError(
            f"{test[:40]} is no test", file=name, key="test", remedy=f"one of {', '.join(TESTS)}"
        )
    return found


def _tests_of_rows(sheet: Sheet, given: str | None) -> list[str]:
    """Return the test each row belongs to; the command line, the column and the metadata must agree."""
    column = sheet.find("test")
    entry = sheet.meta("test")
    stated = list(words(sheet, column)) if column else [entry.value] if entry else []
    where = [*sheet.lines] if column else [entry.line] if entry else []
    known: dict[str, str] = {}
    for text, line in zip(stated, where, strict=True):
        if text in known:
            continue
        try:
            known[text] = _declared_test(text, sheet.name) or ""
        except InputError as error:
            raise InputError(
                error.message,
                file=sheet.name,
                line=line,
                column="test" if column else None,
                remedy=error.remedy,
            ) from None
        if given is not None and not _agree(known[text], given):
            raise InputError(
                f"says the test is {known[text]}, but it was given as {given}",
                file=sheet.name,
                line=line,
                remedy=f"give it as --{known[text].removesuffix('-general')}, or correct the line",
            )
    if not stated and given is None:
        raise InputError(
            "does not say which test it is",
            file=sheet.name,
            remedy=f'add a first line "# test: uniaxial" ({", ".join(TESTS)})',
        )
    rows = (
        [known[text] for text in stated]
        if column
        else [known[stated[0]] if stated else given or ""] * len(sheet.lines)
    )
    return rows


def _agree(stated: str, given: str) -> bool:
    return stated.removesuffix("-general") == given.removesuffix("-general")


def _refined(kind: str, reading: Reading) -> str:
    """A biaxial test with both directions measured is a general one."""
    if kind == "biaxial" and reading.stretch2 is not None and reading.stress2 is not None:
        return "biaxial-general"
    return kind


def _directions(sheet: Sheet) -> list[float | None]:
    column = sheet.find("direction")
    if column is None:
        entry = sheet.meta("direction")
        value = None if entry is None else _direction(entry.value, None, sheet, entry.line)
        return [value] * len(sheet.lines)
    known = {}
    for text, line in zip(words(sheet, column), sheet.lines, strict=True):
        if text not in known:
            known[text] = _direction(text, column, sheet, line)
    return [known[text] for text in words(sheet, column)]


def _direction(text: str, column: Heading | None, sheet: Sheet, line: int) -> float:
    folded = text.strip().casefold()
    if folded in _DIRECTIONS:
        return _DIRECTIONS[folded]
    match = re.fullmatch(r"([+-]?\d{1,3}(?:\.\d{1,6})?)\s*(?:deg|degrees|°)?", folded, re.ASCII)
    if match and abs(float(match[1])) <= 360.0:
        return float(match[1])
    raise InputError(
        f"{text[:40] or 'an empty cell'} is no direction",
        file=sheet.name,
        line=line,
        column=column.title if column else None,
        key=None if column else "direction",
        remedy="write warp, weft or degrees from the warp",
    )


def _words_or_meta(sheet: Sheet, name: str) -> list[str | None]:
    column = sheet.find(name)
    if column is not None:
        return [text or None for text in words(sheet, column)]
    entry = sheet.meta(name)
    return [entry.value or None if entry else None] * len(sheet.lines)


def _groups(
    tests: Sequence[str], directions: Sequence[float | None], specimens: Sequence[str | None]
) -> dict[tuple[str, float | None, str | None], NDArray[np.int64]]:
    found: dict[tuple[str, float | None, str | None], list[int]] = {}
    for row, key in enumerate(zip(tests, directions, specimens, strict=True)):
        found.setdefault(key, []).append(row)
    return {key: np.array(rows, dtype=np.int64) for key, rows in found.items()}


def _columns(sheet: Sheet, decimal: str) -> dict[str, NDArray | None]:
    """Return what else is known of each row, from a column or from the metadata of the file."""
    return {
        "time_s": _amount(sheet, "time", "time", decimal, constant=False),
        "temperature_degC": _amount(sheet, "temperature", "temperature", decimal),
        "rate_1_s": _amount(sheet, "rate", "rate", decimal),
        "cycle": _cycles(sheet, decimal),
        "branch": _branches(sheet),
    }


def _amount(sheet: Sheet, name: str, kind: str, decimal: str, constant: bool = True) -> Array | None:
    heading = sheet.find(name)
    if heading is not None:
        return quantities(sheet, heading, kind, decimal)
    entry = sheet.meta(name) if constant else None
    if entry is None:
        return None
    value = _stated(entry.value, kind, name, sheet, entry.line)
    return np.full(len(sheet.lines), value)


def _stated(text: str, kind: str, name: str, sheet: Sheet, line: int) -> float:
    try:
        return quantity(text, kind)
    except InputError as error:
        raise InputError(error.message, file=sheet.name, line=line, key=name, remedy=error.remedy) from None


def _cycles(sheet: Sheet, decimal: str) -> NDArray[np.int64] | None:
    heading = sheet.find("cycle")
    entry = sheet.meta("cycle")
    if heading is not None:
        values = numbers(sheet, heading, decimal)
    elif entry is not None and re.fullmatch(r"\d{1,9}", entry.value, re.ASCII):
        values = np.full(len(sheet.lines), float(entry.value))
    elif entry is not None:
        raise InputError(
            f"{entry.value[:40]} is no cycle number",
            file=sheet.name,
            line=entry.line,
            remedy="write # cycle: 1",
        )
    else:
        return None
    wrong = np.flatnonzero((values != np.round(values)) | (np.abs(values) > 1e9))
    if wrong.size:
        raise InputError(
            f"{values[wrong[0]]:g} is no cycle number",
            file=sheet.name,
            line=sheet.lines[int(wrong[0])],
            column="cycle",
            remedy="number the cycles 1, 2, 3",
        )
    return values.astype(np.int64)


def _branches(sheet: Sheet) -> NDArray[np.int64] | None:
    stated = _words_or_meta(sheet, "branch")
    if all(text is None for text in stated):
        return None
    found = []
    for text, line in zip(stated, sheet.lines, strict=True):
        branch = _BRANCHES.get((text or "").casefold())
        if branch is None:
            raise InputError(
                f"{text or 'an empty cell'} is no branch",
                file=sheet.name,
                line=line,
                column="branch",
                remedy="write load or unload",
            )
        found.append(branch)
    return np.array(found, dtype=np.int64)


def _unused(sheet: Sheet) -> list[str]:
    known = _NUMERIC | {"direction", "branch", "specimen", "test", ""}
    titles = [
        heading.title for heading in sheet.headings if heading.name not in known and sheet.find(heading.name)
    ]
    return [f"columns not used: {', '.join(titles[:8])}"] if titles else []


def _check(found: TestData, sheet: Sheet) -> None:
    """Refuse what no test can have shown; what is merely odd is the fit's to judge."""
    if found.test == "volumetric":
        return
    stretch, stress = found.stretch, found.stress

    def refuse(row: int, message: str, remedy: str) -> InputError:
        return InputError(message, file=sheet.name, line=int(found.lines[row]), remedy=remedy)

    if len(stretch) > 1 and np.ptp(stretch) == 0.0:
        raise refuse(
            0, f"the stretch is {stretch[0]:g} in all {len(stretch)} rows", "export the stretch of every row"
        )
    peak = float(np.abs(stress).max())
    swapped = (
        np.flatnonzero((stretch < 0.9) & (stress > 0.05 * peak)) if peak > 0.0 else np.array([], dtype=int)
    )
    if swapped.size:
        row = int(swapped[0])
        raise refuse(
            row,
            f"tension ({stress[row]:g} {found.stress_unit}) at a stretch of {stretch[row]:g}, below 1",
            "are the columns of stretch and stress swapped?",
        )
    if found.time_s is not None:
        back = np.flatnonzero(np.diff(found.time_s) < 0.0)
        if back.size and found.cycle is None and found.branch is None and found.rate_1_s is None:
            raise refuse(
                int(back[0]) + 1,
                f"the time goes back from {found.time_s[back[0]]:g} s to {found.time_s[back[0] + 1]:g} s",
                "sort the rows, or tell the specimens apart in a column named specimen",
            )
    row = int(stretch.argmax())
    if stretch[row] > LARGEST_STRETCH or stretch.min() < 1.0 / LARGEST_STRETCH:
        row = row if stretch[row] > LARGEST_STRETCH else int(stretch.argmin())
        raise refuse(row, f"no fabric reaches a stretch of {stretch[row]:g}", "check the unit of the column")
    if peak > 0.0 and not PEAK_STRESS[0] < peak < PEAK_STRESS[1]:
        row = int(np.abs(stress).argmax())
        raise refuse(
            row, f"no fabric carries {peak:g} {found.stress_unit} at most", "check the unit of the column"
        )
