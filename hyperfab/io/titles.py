"""What names tell of a test: the direction it was cut in, and how warm it was, in a file's, a sheet's, a specimen's
name or in the lines above a table."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from typing import TypeVar
from unicodedata import normalize

from hyperfab.curve import DIRECTIONS
from hyperfab.errors import InputError
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import plain, word_for
from hyperfab.io.kinds_of_tests import names_of
from hyperfab.io.stated import stated

#: Degrees from the warp by the words of a direction.
DEGREES_OF = {**DIRECTIONS, "bias": 45.0}
#: Words of a direction that mean another thing in a name.
_UNSURE = (
    "bias", "diagonal", "length", "width", "machine", "fill", "filling", "cross", "columna", "columnas", "fila",
    "colonne", "teia",
)  # fmt: skip
#: Those that mean another thing in a sentence too, unless a direction is spoken of: a textile course, a tester MD 5.
_IN_PROSE = ("course", "courses", "md", "cd", "xd", "td", "rd", "quer", "langs", "rangee", "pasada", "pasadas", "trama")
#: What one of these stands before is measured that way, not cut: transverse strain; or is of the yarn or the cloth.
_MEASURED = ("strain", "stretch", "contraction", "extension", "deformation", "dehnung", "gauge", "extensometer", "wave")
_OF_CLOTH = ("knit", "wirk", "yarn", "thread", "rib", "garn", "faden", "inser", "count", "densit", "beam", "effect")
#: What turns a direction into the other.
_TURNED = {"zur", "across", "perpendicular", "senkrecht"}
#: An angle in a name, ``45deg`` or ``45 \u00b0``, but no temperature; strips are cut at multiples of 15.
_ANGLE = re.compile(
    r"(?<![\d.,])(\d{1,3})\s?(?:deg(?:rees?)?|\u00b0|grad|graden|grados|gradi|degres|graus)(?!\s?[cfk]\b|[a-z])"
)
_CUT = 15
#: What makes the number of degrees beside it a temperature, or the angle of a peel or a bend: washed_60deg, 90deg peel.
_BESIDE = r"(?:wash|bath|water|oven|temp|heat|cured|annealed|peel|bend|gewaschen|ofen|bad)[a-z]*"
_DEGREES = r"\d{1,3}\s?(?:deg|\u00b0|grad)[a-z]*"
_NO_CUT = re.compile(rf"(?<![a-z]){_BESIDE}(?: at)?[ -]*{_DEGREES}|{_DEGREES}[ -]{_BESIDE}")
#: How warm a test was, ``105C``, ``-20 \u00b0C``, ``176 \u00b0F``: a bare C of two figures or more, for ``3C`` numbers
#: a specimen.
_WARM = re.compile(
    r"(?<![\w.,/])((?:(?<![^ ])[-\u2212])?\d{1,3}(?:[.,]\d{1,2})?) ?"
    r"(?:(?:\u00b0|[dD]eg(?:rees)?\.?|[gG]rad) ?([CF])|(?<=\d\d)(C)|(?<=\d\d )(C))(?![\w%/])"
)
#: Below this a bare C behind a number is one of a specimen.
_BARE = 15.0
#: What was done to the cloth before, at the temperature beside it.
_DONE = (
    r"(?:wash|dri|dry|bath|water|oven|cur|anneal|age|aging|set|mold|mould|press|iron|steam|dye|fix|treat|heat|melt|lamin|bond"
    r"|gewasch|ofen|getrock|gealtert|geb\u00fcgelt|lav|sec|s\u00e9ch|tein|trat)[^\W\d]*"
)
_NO_TEST = re.compile(
    rf"\b{_DONE}(?:[ :=-]|at|bei|a|\u00e0|@)*{_WARM.pattern}|{_WARM.pattern}[ -]{_DONE}", re.IGNORECASE
)
#: Where a range begins, 25 to 150 \u00b0C, and what a bare C behind a number is a name of.
_RANGE = re.compile(
    r"(?<![\w.])\d+(?:[.,]\d+)?[ \u00b0C]*(?:[-\u2013/]|\b(?:to|bis|a|\u00e0)\b) ?(?=\d+ ?\u00b0? ?[CF]\b)"
)
_NUMBERED = re.compile(r"\b((?:sample|specimen|lot|batch|probe|nr|no|cotton)\.? ?)(?=\d+ ?C\b)", re.IGNORECASE)
#: What brackets hold is of the cloth, as (elastane weft), where it is no direction by itself nor an angle.
_REMARK = re.compile(r"[(\[](?![^()\[\]]*(?:\u00b0|deg))([^()\[\]]*)[)\]]")
_ROOM = re.compile(r"\b(?:RT|[rR]oom[- ]?[tT]emp(?:erature)?|Raumtemperatur)\b")
_T = TypeVar("_T")


def direction_told(sheet: CsvSheet) -> float | None:
    """Return the degrees from the warp that the names of a table tell, or the lines above it; None where none does.

    InputError where a name and a line gainsay each other.
    """
    named = next((told for told in map(in_name, names_of(sheet.name)) if told is not None), None)
    line, titled = _above(sheet, in_title)
    if named is not None and titled is not None and named != titled:
        ways = {one: word for word, one in DEGREES_OF.items()}
        first, second = (ways.get(one, f"{one:g} deg") for one in (named, titled))
        raise InputError(
            f"says {second} here and is called {first}",
            line=line,
            remedy=f'say which in a first line, "# direction: {second}" or "# direction: {first}"',
        )
    return titled if named is None else named


def temperature_told(sheet: CsvSheet) -> float | None:
    """Return the temperature [degC] that the names of a table tell, or else the lines above it; None where none does
    or they tell several."""
    named = next((told for told in map(warmth, names_of(sheet.name)) if told is not None), None)
    return _above(sheet, warmth)[1] if named is None else named


def _above(sheet: CsvSheet, told_by: Callable[[str], _T | None]) -> tuple[int, _T | None]:
    """Return what the specimen's name and the titles above a table tell, with the line; None where they tell two."""
    specimen = stated(sheet, "specimen")
    lines = [*([specimen] if specimen else []), *sheet.metadata.get("test", []), *sheet.metadata.get("title", [])]
    found = {told: one.line for one in reversed(lines) if (told := told_by(one.value)) is not None}
    [(told, line)] = found.items() if len(found) == 1 else [(None, 0)]
    return line, told


def in_name(name: str, prose: bool = False) -> float | None:
    """Return the degrees from the warp that the name of a file or a sheet tells; none where it tells two of them.

    A warp knit, a weft yarn, a transverse strain, a machine and a temperature are none; in ``prose`` nor is a course.

    >>> in_name("k9_weft-3"), in_name("warp_knit"), in_name("warp_weft"), in_name("PET transverse 2")
    (90.0, None, None, 90.0)
    >>> in_name("jersey_45deg_1"), in_name("rib 45degC"), in_name("vhb_20deg"), in_name("foil machine direction")
    (45.0, None, None, 0.0)
    >>> in_name("pull on the old machine"), in_name("washed_60deg"), in_name("washed 60deg_bias 45deg")
    (None, None, 45.0)
    >>> in_name("Bias extension test"), in_name("bias corrected")
    (45.0, None)
    """
    found = set()
    words = plain(name).split()
    if prose and not _TURNED.isdisjoint(words):
        return None
    for word, after in pairwise([*words, ""]):
        unsure = word in _UNSURE or (prose and word in _IN_PROSE and "dire" not in after)
        told = (word_for(f"{word} {after}", "DIRECTIONS") if after else None) or (
            word_for(word, "DIRECTIONS") if not unsure else None
        )
        if told and (told == "bias" or after not in _MEASURED) and not after.startswith(_OF_CLOTH):
            found.add(DEGREES_OF[told])
    text = name.replace("_", " ").casefold()
    angles = _ANGLE.findall(_NO_CUT.sub(" ", text))
    found.update(float(angle) for angle in angles if int(angle) % _CUT == 0 and int(angle) < 180)
    return found.pop() if len(found) == 1 else None


def in_title(line: str) -> float | None:
    """Return the direction that a line above a table tells: in a part of one or two words as a name does, in others by
    words that mean nothing else.

    >>> in_title("Zugversuch Jersey, Querrichtung, 80 °C"), in_title("Tensile test of knit K7 - course direction")
    (90.0, 90.0)
    >>> in_title("Strip test - MD"), in_title("Textile testing course 3"), in_title("Strip of a warp knitted net")
    (0.0, None, None)
    >>> in_title("Stretch denim (elastane weft)"), in_title("Dehnung quer zur Kette, Probe 3")
    (None, None)
    """
    line = _REMARK.sub(lambda one: one[0] if word_for(one[1], "DIRECTIONS") or "dir" in one[1] else " ", line)
    parts = [part for part in re.split(r"[,;:()\[\]|@]|\s[-\u2013\u2014/]\s", line) if part.strip()]
    found = {told for part in parts if (told := in_name(part, prose=len(part.split()) > 2)) is not None}
    return found.pop() if len(found) == 1 else None


def warmth(name: str) -> float | None:
    """Return the temperature [degC] that a name tells; none where it tells two, or one of a treatment.

    >>> warmth("K7_course_105C_01"), warmth("Knit K7 WALE @ 176 °F"), warmth("warp_-20degC"), warmth("warp-23C")
    (105.0, 80.0, -20.0, 23.0)
    >>> warmth("K7-105C-weft"), warmth("Sample 25C"), warmth("25 to 150 °C"), warmth("Sample 2, 25 °C")
    (105.0, None, None, 25.0)
    >>> warmth("K7_wale_RT_1"), warmth("CRT 5")
    (23.0, None)
    >>> warmth("K7_3C"), warmth("washed 60 °C"), warmth("23-105C"), warmth("100 C at 80 C"), warmth("50C/50P")
    (None, None, None, None, None)
    """
    text = re.sub(r"\bT ?= ?(?=\d)|\bT(?=\d)", " ", normalize("NFKC", name).replace("_", " "))
    text = _NUMBERED.sub(r"\1x", _RANGE.sub("x", text))
    found = set()
    for match in _WARM.finditer(_NO_TEST.sub(" ", text)):
        value = float(match[1].replace(",", ".").replace("\u2212", "-"))
        if match[2] or value >= _BARE:
            found.add(round((value - 32.0) / 1.8, 4) if match[2] == "F" else value)
    if not found and _ROOM.search(text):
        return 23.0  # ISO 291
    return found.pop() if len(found) == 1 else None
