"""Titles of columns as they are written, parted into the label and the unit, however that is set beside it."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

from hyperfab.io.dictionary import BRACKETS, is_filler, is_known, looked_up, plain, qualifiers, setting
from hyperfab.io.headings import KIND, Heading, in_unit, is_of, meaning
from hyperfab.io.units import is_unit

#: Anything that starts like a number: enough to tell a row of data from a row of words.
NUMBER_LIKE = re.compile(r"[+-]?[.,]?\d[\d.,eE+-]*", re.ASCII)
_TAIL = re.compile(r"(?:\s*(?:\[[^\[\]]*\]|\([^()]*\)|\{[^{}]*\}|<[^<>]*>))+\s*$")
_SQUARE = re.compile(r"\bsq\b[. ]*([a-z]+)", re.IGNORECASE)
_LIKE_A_NUMBER = re.compile(r"[x*\u00d7] ?\d|\d")
#: A number and what stands behind it: 12.5 N; per cent is read with the number.
_AMOUNT = re.compile(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?\s*([^\d\s.,%].*)")
#: An amount in a unit, in the place of one: Load (100 N).
COUNTED = re.compile(r"([\d.,]*\d) ?(?![\d.,])(\D.*)")
#: Per cent in a title, by its sign or a word, and what stands before it.
_PER_CENT = re.compile(
    r"(.*?)[\s_(\[{,/]*(?:%|\b(?:percent(?:age)?|per ?cent|pct|perc|prozent|porcentaje|por ciento|pourcent|percento)\b"
    r"|[(\[]\s*(?:pc|v\.? ?h\.?)\s*[)\]]).*",
    re.IGNORECASE,
)
#: A remark behind a unit, parted by a dash: exx [1] - Lagrange.
_DASHED = re.compile(r"(.*[\])}])\s*[-\u2013]\s*([^\W\d][\w .]*)")
#: Units in words, as offices write them.
_UNIT_WORDS = {
    "newton": "N", "newtons": "N", "kilonewton": "kN", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "sek": "s", "sekunden": "s",
    "sekunde": "s", "seg": "s", "segundos": "s", "segundo": "s", "secondes": "s", "seconde": "s",
    "secondi": "s", "minute": "min",
    "minutes": "min", "minuten": "min", "minutos": "min", "minuti": "min", "millimeter": "mm",
    "millimeters": "mm", "millimetre": "mm",
    "millimetres": "mm", "milimetros": "mm", "millimetri": "mm", "megapascal": "MPa", "kilopascal": "kPa",
    "mpa": "MPa", "kpa": "kPa",
    "kn": "kN", "kgf": "kgf", "lbf": "lbf", "gf": "gf", "ozf": "ozf", "prozent": "%", "percent": "%",
    "per cent": "%", "pct": "%",
    "porcentaje": "%", "pourcent": "%", "grad c": "degC", "grad celsius": "degC", "deg c": "degC",
    "celsius": "degC", "grados c": "degC",
    "degres c": "degC", "gradi c": "degC", "graus c": "degC", "kelvin": "K", "dimensionless": "-",
    "none": "-", "inch": "in", "pulg": "in",
    "kg": "kg", "kgs": "kg", "kilogram": "kg", "kilograms": "kg", "kilos": "kg", "gm": "g", "gms": "g", "lbs": "lb",
    "pounds": "lb", "ounces": "oz", "kips": "kip", "kg f": "kgf", "g f": "gf", "lb f": "lbf", "lbs f": "lbf",
    "lbs force": "lbf", "lb force": "lbf", "pound force": "lbf", "pounds force": "lbf", "kg force": "kgf",
    "tonf": "tf", "ton force": "tf", "nt": "N", "microstrain": "ppm", "micro strain": "ppm", "\u03bcepsilon": "ppm",
    "н": "N", "кн": "kN", "кгс": "kgf", "гс": "gf", "па": "Pa", "кпа": "kPa", "мпа": "MPa", "гпа": "GPa",
    "м": "m", "см": "cm", "мм": "mm", "мм2": "mm2", "см2": "cm2", "с": "s", "сек": "s", "мин": "min",
}  # fmt: skip


def heading(title: str, index: int) -> Heading:
    """Read a column's title: ``Kraft [N]``, ``Force (N)``, ``Load / N``, ``Load, N``, ``Weg in mm``, ``Dehnung %``.

    >>> heading("Tensile strain (Displacement) (%)", 0)
    Heading(title='Tensile strain (Displacement) (%)', label='Tensile strain', unit='%', index=0)
    """
    text = _DASHED.sub(r"\1 (\2)", title) if len(title) <= 200 else ""
    tail = _TAIL.search(text)
    groups = list(BRACKETS.finditer(text, tail.start() if tail else 0))
    inner = [next(part for part in group.groups() if part is not None).strip() for group in groups]
    units = [None if tail is None and part.isdigit() else beside(part) for part in inner]
    chosen = next((k for k in reversed(range(len(groups))) if units[k] is not None), None)
    if chosen is None and (part := _per_cent(title, index)) is not None:
        return part
    if chosen is None and tail is not None:  # a square bracket holds the unit, whatever stands in it
        chosen = next((k for k in reversed(range(len(groups))) if groups[k][1] is not None), None)
    if chosen is not None:
        label = _bare(text[: groups[chosen].start()] + " " + text[groups[chosen].end() :])
        return Heading(title, label, units[chosen] or inner[chosen] or "-", index)
    label = _bare(text) if groups else text
    first, _, last = label.rpartition(" ")
    if last in ("%", "°C", "°F", "‰") and is_known(first):
        return Heading(title, first, last, index)
    if is_known(first) and first[-1] not in "/," and not is_known(label) and (unit := unit_of(last)):
        kinds = [KIND.get(made.name) for one in looked_up(plain(first)) if (made := in_unit(one, unit))]
        if last != "1" and any(is_of(unit, kind) for kind in kinds if kind):
            return Heading(title, first, unit, index)
    # A slash last: behind a comma, or "in", a unit may hold one, as in Spannung, N/mm2.
    for pattern in (r"(.+),\s*(\S.*)", r"(.+?)\s+in\s+(\S+)", r"(.+?)\s*/\s*(.+)"):
        match = re.fullmatch(pattern, label)
        if match and (unit := beside(match[2])) is not None and not is_known(label):
            return Heading(title, match[1].strip(), unit, index)
    return Heading(title, label or title, None, index)


def beside(part: str) -> str | None:
    """Return the unit in brackets beside a name, with its factor; an amount of one stands to be refused."""
    if (unit := unit_of(part)) is not None:
        return unit
    scaled = _LIKE_A_NUMBER.match(part) is not None or re.search(r"[x*\u00d7] ?\d+$", part) is not None
    counted = COUNTED.fullmatch(part)
    amount = counted is not None and unit_of(counted[2]) is not None
    return part if (scaled and not part.isdigit() and is_unit(part)) or amount else None


def _per_cent(title: str, index: int) -> Heading | None:
    """Read a title with a per cent sign or word anywhere, where what stands before it is a strain: Strain (%GL)."""
    match = _PER_CENT.fullmatch(title.replace("_", " ")) if len(title) <= 200 else None
    if match is None or not match[1].strip():
        return None
    factor = re.search(r"%\s*[/x*]\s*\d+", title)
    head = Heading(title, match[1].strip(" :;,_="), factor[0] if factor else "%", index)
    found = meaning(replace(head, unit="%"))
    return head if found is not None and KIND.get(found.name) == "dimensionless" else None


def unread_unit(head: Heading) -> str | None:
    """Return what stands in the place of a unit and is none: quux of Load (quux), but no remark (filtered)."""
    if head.unit is not None:
        return None if is_unit(head.unit) else head.unit
    tail = _TAIL.search(head.title)
    inner = [part.strip("[](){}<> ") for part in re.findall(r"[\[({<][^\[\](){}<>]*", tail[0])] if tail else []
    return next((part for part in inner if not _is_remark(part)), None)


def _is_remark(part: str) -> bool:
    """Whether words in brackets are known ones, or as long as those of no unit."""
    return all(
        len(word) > 4 or word.isdigit() or is_filler(word) or word in qualifiers() or looked_up(word)
        or setting(word) is not None for word in plain(part).split()
    )  # fmt: skip


def unit_behind(cell: str) -> str | None:
    """Return the unit that stands behind the number of a cell, as in 0.5 MPa, or None."""
    match = _AMOUNT.fullmatch(cell)
    return match[1] if match and unit_of(match[1]) is not None else None


@cache
def unit_of(text: str) -> str | None:
    """Return ``text`` as a unit of ``hyperfab.io.unit_table``, or None where it is none.

    >>> unit_of("Newton"), unit_of(" N/mm² "), unit_of("Mpa"), unit_of("Ch1")
    ('N', 'N/mm²', 'MPa', None)
    """
    text = text.strip().rstrip(".").strip()
    if not text or len(text) > 40:
        return None
    if _LIKE_A_NUMBER.match(text):  # a factor is one beside a title alone, in a cell it is a value
        return text if text == "1" or (text.startswith("1/") and is_unit(text)) else None
    if text == "mPa" or is_unit(text):
        return text
    if len(text) > 1 and text.isupper() and is_unit(text.lower()):  # EXTENSION (MM)
        return text.lower()
    text = _SQUARE.sub(r"\1^2", text)
    if is_unit(text):
        return text
    if text.count("/") == 1:  # Kg/cm2
        parts = [unit_of(part) for part in text.split("/")]
        if all(parts):
            return "/".join(map(str, parts))
    return _UNIT_WORDS.get(plain(text))


def _bare(label: str) -> str:
    """Return a label without remarks in brackets, colons and underscores at its ends."""
    return " ".join(_TAIL.sub("", label).split()).strip(" :;,_=") or label.strip()
