"""Headings of columns: what a column holds, by its label and the unit beside it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from hyperfab.io import heading_words
from hyperfab.io.dictionary import (
    Meaning,
    fold,
    is_filler,
    is_known,
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

    >>> from hyperfab.io.titles import heading
    >>> meaning(heading("Standardkraft [N]", 0)), meaning(heading("Deformation [mm]", 0)).name
    (Meaning(name='force', axis='', compressive=False, rank=0), 'extension')
    """
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
        found = [one for one in looked_up(core) if one.name in ("strain", "stretch", "extension")]
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


def is_of(unit: str, kind: str) -> bool:
    """Whether ``unit`` is one of the ``kind`` of quantity."""
    try:
        column_factor(unit, kind)
    except UnitError:
        return False
    return True


def suffixed(head: Heading) -> Heading:
    """Read ``membrane_stress_N_mm``, the way this program names columns, as ``membrane stress [N/mm]``."""
    parts = head.title.split("_")
    for cut in range(1, len(parts)):
        unit = "/".join(parts[cut:])
        if head.unit is not None or not unit or unit.isdigit() or is_known(head.title):  # eps_t is no tonne
            continue
        if is_unit(unit) and (not parts[cut].isdigit() or is_of(unit, "rate")):  # rate_1_s, but force_1_N
            return Heading(head.title, "_".join(parts[:cut]), unit, head.index)
    return head
