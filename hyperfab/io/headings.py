"""Headings of columns: what a column holds, by its label and the unit beside it, however the title sets them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

from hyperfab.io import heading_words
from hyperfab.io.dictionary import (
    BRACKETS,
    Meaning,
    fold,
    is_filler,
    is_known,
    is_tensor,
    looked_up,
    measured,
    plain,
    qualifiers,
    setting,
    without_brackets,
    words,
)
from hyperfab.io.unit_table import UnitError
from hyperfab.io.units import column_factor, is_unit

#: The kind of quantity each column holds.
KIND: Mapping[str, str] = {
    "stretch": "dimensionless", "strain": "dimensionless", "true strain": "dimensionless",
    "green strain": "dimensionless",
    "shear strain": "dimensionless", "volume ratio": "dimensionless", "extension": "length",
    "position": "length", "length": "length",
    "force": "force", "stress": "stress", "true stress": "stress", "shear stress": "stress", "stress sd": "stress",
    "membrane stress": "membrane-stress", "time": "time", "temperature": "temperature",
    "chamber": "temperature", "rate": "rate",
}  # fmt: skip
#: What a label means when its unit is of another kind: tension [N] is a force, deformation [mm] an extension.
_BY_UNIT: Mapping[str, Mapping[str, str]] = {
    "strain": {"length": "extension"},
    "extension": {"dimensionless": "strain"},
    "position": {"dimensionless": "strain"},
    "force": {"membrane-stress": "membrane stress", "stress": "stress"},
    "stress": {"membrane-stress": "membrane stress", "force": "force"},
    "membrane stress": {"stress": "stress", "force": "force"},
    "time": {"temperature": "temperature"},
}
#: What reads a specimen's own elongation, with its number: Extensometer 1 strain, Strain (video).
_GAUGE = re.compile(rf"\b(?:{'|'.join(sorted(words(heading_words.GAUGES), reverse=True))})(?: \d)?\b")
_AXES = {"1": "1", "2": "2", "11": "1", "22": "2", "x": "x", "y": "y", "xx": "x", "yy": "y"}


@dataclass(frozen=True)
class Heading:
    """One column's heading: ``title`` as written, its ``label`` without the unit, ``unit`` or None, its place."""

    title: str
    label: str
    unit: str | None
    index: int

    @property
    def name(self) -> str:
        """The label as it is compared."""
        return fold(self.label)


def meaning(head: Heading) -> Meaning | None:
    """Return what a column holds by its words and its unit, or None where neither is known.

    >>> meaning(heading("Standardkraft [N]", 0)), meaning(heading("Deformation [mm]", 0)).name
    (Meaning(name='force', axis='', compressive=False, rank=0), 'extension')
    """
    if is_tensor(head.title):
        return None
    label = plain(without_brackets(head.label))
    found = list(looked_up(label))
    axis = ""
    match = None if found else re.fullmatch(r"(.*?) ?(11|22|xx|yy|[12xy])", label)
    if match and match[1] and (found := list(looked_up(match[1]))):
        axis = _AXES[match[2]]
    before = re.fullmatch(r"([xy]) ?([a-z]{4,})", label)  # XForce, YDisplacement
    if not found and before and (found := list(looked_up(before[2]))):
        axis = before[1]
    if not found:
        core = " ".join(word for word in label.split() if word not in qualifiers())
        found = list(looked_up(core))
    # Of a gauge alone its last word tells: Laser extensometer.
    if not found and (core := _GAUGE.sub(" ", label).strip() or label.rpartition(" ")[2]) != label:
        told = looked_up(core)
        # DIC displacement X; of a second gauge a number says nothing.
        along = None if told else re.fullmatch(r"(.*?) ?(xx|yy|[xy])", core)
        found = [
            one for one in (looked_up(along[1]) if along else told) if one.name in ("strain", "stretch", "extension")
        ]
        axis = _AXES[along[2]] if found and along else axis
    if not found:
        first, _, last = label.rpartition(" ")
        if last in ("nr", "no", "id", "num"):
            return Meaning("aside")
        if setting(last) is not None and is_known(re.sub(r"[ 0-9]+$", "", first)):
            return Meaning("aside")  # a size that the channel was set up with: Extensometer 1.L0
        if first and len(last) <= 2 and last not in _AXES:  # a symbol: Kraft F, Zeit t
            found = [replace(one, rank=1) for one in looked_up(first)]
            own = {one.name for one in looked_up(last)} & {"length"}
            if own and found and not own & {one.name for one in found}:
                return None  # word and symbol gainsay each other: Extensometer L
    if not found:
        core = " ".join(word for word in label.split() if not is_filler(word))
        found = [replace(one, rank=2) for one in looked_up(core)] if core != label else []
    # A group of channels before the one: Analog input: Force, Extensometer 1.ΔL, C_1_Force.
    group = re.fullmatch(r"(?:.*(?::|[^\W_]\.(?=[^\W\d]))|[A-WZa-wz]_\d{1,2}_)(.+)", head.label)
    if not found and group:
        behind = meaning(replace(head, label=group[1].strip()))
        return behind and replace(behind, rank=2)
    found = [replace(one, name=name) for one in found if (name := measured(one.name, head.title))]
    fitting = [one for one in (in_unit(one, head.unit) for one in found) if one is not None]
    exact = [one for one in fitting if head.unit is None or one.name not in KIND or is_of(head.unit, KIND[one.name])]
    if not fitting:
        return None
    letter = label.removesuffix(match[2]).strip() if axis and match else label
    kind = KIND.get(fitting[0].name)
    bare = head.unit is None and not (axis and kind == "dimensionless")  # eyy has none
    if len(letter) == 1 and kind is not None and (bare or not exact):
        return None  # a letter says nothing without its unit
    best = (exact or fitting)[0]
    return replace(best, axis=axis or best.axis)


def in_unit(found: Meaning, unit: str | None) -> Meaning | None:
    """Return what words mean beside their unit; None where they cannot mean anything beside it."""
    kind = KIND.get(found.name)
    if unit is None or kind is None or is_of(unit, kind):
        return found
    if found.axis and is_of(unit, "length"):
        return Meaning("aside")  # a change of width whose width nobody told
    if found.name == "rate" and is_of(unit, "velocity"):
        return found
    for other, name in _BY_UNIT.get(found.name, {}).items():
        if is_of(unit, other):
            return replace(found, name=name)
    return found  # the reader says which unit is due


def is_unread(head: Heading) -> bool:
    """Whether a title names a measure of strain or stress that is not read: no guess may take it for another."""
    return any(measured(name, head.title) == "" for name in heading_words.MEASURES)


def is_gauged(head: Heading) -> bool:
    """Whether a title says that what reads the specimen itself made its readings, not the machine's crosshead."""
    return _GAUGE.search(plain(head.label)) is not None


def is_on_specimen(told: str) -> bool:
    """Whether a file that states by what strain was read tells of the specimen itself, not of the grips.

    >>> is_on_specimen("Video extensometer 1"), is_on_specimen("marker pins"), is_on_specimen("Crosshead")
    (True, True, False)
    """
    label = plain(told)
    return _GAUGE.search(label) is not None or not words(heading_words.MARKS).isdisjoint(label.split())


def is_of(unit: str, kind: str) -> bool:
    """Whether ``unit`` is one of the ``kind`` of quantity."""
    try:
        column_factor(unit, kind)
    except UnitError:
        return False
    return True


def suffixed(head: Heading) -> Heading:
    """Read ``membrane_stress_N_mm``, the way this program names columns, as ``membrane stress [N/mm]``.

    A number behind the unit is the column's, as in ``force_N_2``, the second force.
    """
    *parts, number = head.title.split("_")
    numbered = len(parts) > 1 and number.isdigit() and not parts[-1].isdigit()
    behind = [number] if numbered else []
    parts += [] if numbered else [number]
    for cut in range(1, len(parts)):
        unit = "/".join(parts[cut:])
        if head.unit is not None or not unit or unit.isdigit() or is_known(head.title):  # eps_t is no tonne
            continue
        if unit == "S" and fold(parts[0]) == "time":
            unit = "s"
        if is_unit(unit) and (not parts[cut].isdigit() or is_of(unit, "rate")):  # rate_1_s, but force_1_N
            return Heading(head.title, "_".join([*parts[:cut], *behind]), unit, head.index)
    for cut in range(1, 0 if head.unit is not None or is_known(head.title) else len(parts)):
        last = " ".join(parts[cut:])  # stress_mpa, force_n, temp_deg_c, as tools tidy names
        for small in (_UNIT_WORDS.get(last, ""), last.upper()):
            made = Heading(head.title, "_".join([*parts[:cut], *behind]), small, head.index)
            found = meaning(made) if small and last.islower() and is_unit(small) else None
            if found is not None and found.name in KIND and is_of(small, KIND[found.name]):
                return made
    return head


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
#: Degrees before the name of a probe, as loggers write it: [°C] cup, °C [1] cup.
_BEFORE = re.compile(r"\[?(\u00b0[CF])\]?(?: ?\[\d+\])? +([^\W\d].*)")
_UNIT_WORDS = {word: unit for unit, told in heading_words.UNITS.items() for word in words(told)}


def heading(title: str, index: int) -> Heading:
    """Read a column's title: ``Kraft [N]``, ``Force (N)``, ``Load / N``, ``Load, N``, ``Weg in mm``, ``Dehnung %``.

    >>> heading("Tensile strain (Displacement) (%)", 0)
    Heading(title='Tensile strain (Displacement) (%)', label='Tensile strain', unit='%', index=0)
    """
    if before := _BEFORE.fullmatch(title[:200]):
        return Heading(title, before[2], before[1], index)
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
    probe = last in ("°C", "°F") and not re.search(r"(?:^| )[\d.,]+$", first)  # cup °C, but no Stress 20 °C
    if first and (probe or (last in ("%", "°C", "°F", "‰") and is_known(first))):
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
    if (
        unit := next((one for one, told in heading_words.TIMES.items() if plain(label) in words(told)), None)
    ) is not None:
        # Beside a clock milliseconds are its fraction.
        return Heading(title, "time" if unit != "ms" else label, unit, index)
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
