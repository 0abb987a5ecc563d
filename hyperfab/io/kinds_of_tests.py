"""Which test a file holds: as it says, or as its columns, its title and its name tell."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath
from typing import Literal

from hyperfab.errors import InputError
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import word_for
from hyperfab.io.named_tests import Named, is_pull, named_test, surest
from hyperfab.io.other_tests import unread
from hyperfab.io.role_words import no_stress, no_test
from hyperfab.io.roles import STRESSES, Roles

#: The deformation modes a test can be in.
TESTS = (
    "uniaxial",
    "confined-compression",
    "shear",
    "simple-shear",
    "biaxial",
    "biaxial-general",
    "volumetric",
)
#: Whether a test is told to be a compression; perhaps, where words say it that may be of what is tested; pulled, where
#: it is told to be a pull.
Pressed = Literal["no", "perhaps", "yes", "pulled"]
#: Tests that an option of that name takes.
_OPTIONS = ("uniaxial", "shear", "biaxial", "volumetric")
#: Tests by the letters that papers give them, where a file states its test.
_LETTERS = {
    "ut": "uniaxial", "uc": "compression", "ps": "shear", "et": "biaxial", "eb": "biaxial", "ebt": "biaxial",
    "bt": "biaxial", "ss": "simple-shear",
}  # fmt: skip


#: What to do with a file that is one of ours, whatever its title says.
_OTHERWISE = 'if it is one of these all the same, add a first line "# test: uniaxial"'


def said(sheet: CsvSheet, given: str | None) -> str | None:
    """Return which test a file is said to be: by an option, a line, or words above its table.

    InputError where it is said to be one of which no stretch and stress are read.
    """
    told = sheet.metadata.get("test", [])
    for entry in [] if any(one.sure for one in told) else told:
        if (instead := unread(entry.value)) is not None:
            raise InputError(f"says {entry.value[:40]}: {instead}", line=entry.line, remedy=_OTHERWISE)
    if given is not None:
        return given
    declared = next((_declared(entry.value) for entry in told if entry.sure), None)
    named = surest(entry.value for entry in told)
    return declared or (named.kind if named else None)


def _declared(test: str | None) -> str | None:
    if test is None:
        return None
    folded = test.strip().casefold().replace("_", "-")
    folded = _LETTERS.get(folded, folded)
    found = folded if folded in TESTS else word_for(folded, "TESTS")
    if found is None:
        raise InputError(f"{test[:40]} is no test", key="test", remedy=f"one of {', '.join(TESTS)}")
    return "uniaxial" if found == "compression" else found


def tests_of_rows(sheet: CsvSheet, columns: Roles, given: str | None) -> tuple[list[str], Pressed]:
    """Return the test each row belongs to, and whether it is told to be a compression.

    The command line, the column and the metadata must agree; a file that does not say is recognised by its columns, by
    the words above the table, or by its name.
    """
    column = columns.columns.get("test")
    entry = next((one for one in sheet.metadata.get("test", []) if one.sure), None)
    told: Sequence[str] = sheet.columns[column.heading.index] if column else [entry.value] if entry else []
    texts = [_LETTERS.get(text.strip().casefold(), text) for text in told]
    where = [*sheet.lines] if column else [entry.line] if entry else []
    known: dict[str, str] = {}
    compression = False
    for text, line in zip(texts, where, strict=True):
        if text in known:
            continue
        compression = compression or word_for(text, "TESTS") == "compression"
        try:
            known[text] = _declared(text) or ""
        except InputError as error:
            raise InputError(error.message, line=line, column="test" if column else None, remedy=error.remedy) from None
        plain = known[text].removesuffix("-general")
        if given is not None and plain != given.removesuffix("-general"):
            raise InputError(
                f"says the test is {known[text]}, but it was given as {given}",
                line=line,
                remedy=f"give it as --{plain}, or correct the line"
                if plain in _OPTIONS and sheet.over is None and not sheet.label
                else "give the file without the option, for it says which test each is, or correct what it says",
            )
    count = len(sheet.lines)
    if texts:
        told_so: Pressed = "yes" if compression else "pulled" if is_pulled(sheet) else "no"
        return ([known[text] for text in texts] if column else [known[texts[0]]] * count), told_so
    named = _recognised(sheet, columns)
    guess = named.kind if named else None
    pressed: Pressed = "pulled" if is_pulled(sheet) else "no"
    if named is not None and guess == "compression":
        pressed = "yes" if named.sure else "perhaps"
    if given is not None:
        return [_declared(given) or ""] * count, pressed
    if guess is None and columns.first(STRESSES) is None:
        raise no_stress(sheet, columns)
    if guess is None:
        raise no_test(sheet, TESTS)
    return ["uniaxial" if guess == "compression" else guess] * count, pressed


def names_of(name: str) -> list[str]:
    """Return what a table is called: its sheet in a workbook, then the file without its ending.

    >>> names_of("lab/k17_uniaxial.xlsx:Warp"), names_of("k9_weft.csv")
    (['Warp', 'k17_uniaxial'], ['k9_weft'])
    """
    file, _, title = name.partition(".xlsx:")
    return [*([title] if title else []), PurePath(file).stem if not title else PurePath(file).name]


def is_pulled(sheet: CsvSheet) -> bool:
    """Whether a line or words above a table say that the test is a pull and no other."""
    told = [entry.value for entry in sheet.metadata.get("test", [])]
    found = surest(told)
    return any(map(is_pull, told)) and found is not None and found.kind == "uniaxial"


def _recognised(sheet: CsvSheet, columns: Roles) -> Named | None:
    """Return the test that columns, words above the table or the file's name tell, the surest first.

    What the heads of columns say counts more than a word that may be of what is tested; where they cannot both be so,
    nothing is told.
    """
    names = columns.columns
    if "shear stress" in names or "shear strain" in names:
        return Named("simple-shear", True)
    if any(name.endswith(" 2") and name[:-2] in STRESSES for name in names):
        return Named("biaxial-general", True)
    if "volume ratio" in names:
        return Named("volumetric", True)
    above = surest(entry.value for entry in sheet.metadata.get("test", []))
    if above is not None and above.sure:
        return above
    titles = named_test(" | ".join(one.heading.title for one in names.values()))
    told = above or next(filter(None, map(named_test, names_of(sheet.name))), None)
    if titles is None or titles.kind not in ("uniaxial", "compression") or told == titles:
        return told
    if told is None or (not told.sure and told.kind in ("uniaxial", "compression")):
        return Named(titles.kind, True)
    return told if told.sure and told.kind not in ("uniaxial", "compression") else None
