"""The words of headings and settings: how they are compared, and what the dictionary has for them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from hyperfab.io import heading_words, setting_words

#: Brackets of any kind and what stands in them.
BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}|<([^<>]*)>")
_GREEK = str.maketrans(
    {"ε": "epsilon", "ϵ": "epsilon", "σ": "sigma", "λ": "lambda", "τ": "tau", "γ": "gamma",
        "Δ": "delta ", "δ": "delta ", "∆": "delta ", "ı": "i", "ł": "l"}
)  # fmt: skip
#: A channel's own name, before or behind what it records: ai0, E1, CH02, Dev1.
_CHANNEL = re.compile(r"[a-z]{1,4}\d{1,2}")


@dataclass(frozen=True)
class Meaning:
    """What a column holds: a ``name`` of ``heading_words.COLUMNS`` or ``aside``, and along which axis of the sheet.

    ``axis`` is 1, 2, x or y, or nothing where the heading tells none; ``compressive`` columns count pushing as
    positive. Of two columns of one name that of the lower ``rank`` is the better told.
    """

    name: str
    axis: str = ""
    compressive: bool = False
    rank: int = 0


def fold(text: str) -> str:
    """Return a name as it is compared: lower case, single spaces for ``_`` and ``-``.

    >>> fold("Gauge_Length ")
    'gauge length'
    """
    return " ".join(text.casefold().replace("_", " ").replace("-", " ").split())


@cache
def plain(text: str) -> str:
    """Return words as they are looked up: lower case, without accents, punctuation as spaces.

    >>> plain("Längenänderung ΔL"), plain("Déformation_(nominale)")
    ('langenanderung delta l', 'deformation nominale')
    """
    text = unicodedata.normalize("NFKD", text[:120].translate(_GREEK).casefold().translate(_GREEK))
    kept = (mark for mark in text if not unicodedata.combining(mark))
    return " ".join("".join(mark if mark.isalnum() else " " for mark in kept).split())


@cache
def words(text: str) -> frozenset[str]:
    """Return the phrases of a list that semicolons part, as they are looked up."""
    return frozenset(plain(one) for one in text.split(";")) - {""}


@cache
def looked_up(label: str) -> tuple[Meaning, ...]:
    """Return what the dictionary has for a label that ``plain`` made."""
    if label in heading_words.COLUMNS:  # the contract's own names need no dictionary
        return (Meaning(label),)
    return _dictionary().get(label, ())


@cache
def reading(label: str) -> str | None:
    """Return what a column of a pushed sheet or of a press holds by its label, or None.

    >>> reading("Eindringtiefe"), reading("Épaisseur"), reading("Weg")
    ('depth', 'thickness', None)
    """
    told = (name for name, phrases in heading_words.READINGS.items() if plain(label) in words(phrases))
    return next(told, None)


@cache
def _dictionary() -> dict[str, tuple[Meaning, ...]]:
    found: dict[str, list[Meaning]] = {}
    told = [(Meaning(name), phrases) for name, phrases in heading_words.COLUMNS.items()]
    told += [(Meaning(name, compressive=True), one) for name, one in heading_words.COMPRESSIVE.items()]
    told += [(Meaning(name, axis="2"), one) for name, one in heading_words.ACROSS.items()]
    for one, phrases in [*told, (Meaning("aside"), heading_words.ASIDE)]:
        for phrase in words(phrases):
            found.setdefault(phrase, []).append(one)
    return {phrase: tuple(ones) for phrase, ones in found.items()}


def is_known(label: str) -> bool:
    """Whether a label is in the dictionary as it stands."""
    return bool(looked_up(plain(label)))


#: A tensor's symbol, and its unit: of words beside it in round brackets none is one.
_TENSOR = re.compile(r"[ES]_?(?:11|22|xx|yy) ?(?:\[[^\]]*\]|\((?:[-%]|[kM]?Pa|psi|N/mm\S{1,2})\))?")


def measured(name: str, title: str) -> str:
    """Return a strain or stress by the measure that its title names beside it; nothing for one that is not read.

    >>> measured("strain", "exx [1] - Lagrange"), measured("stress", "Spannung (wahr) [MPa]")
    ('green strain', 'true stress')
    """
    beside = set(plain(title).split())
    for measure, phrases in heading_words.MEASURES.get(name, {}).items():
        if beside & words(phrases):
            return measure
    symbols = {("strain", "E"): "green strain", ("stress", "S"): ""}
    return symbols.get((name, title.strip()[0]), name) if is_tensor(title) else name


def is_tensor(title: str) -> bool:
    """Whether a title is the symbol of a tensor's component alone: E of Green, S of Piola or, in FE programs, Cauchy.

    Programs of image correlation write Exx for engineering strains too: a proposal, nothing to be taken.

    >>> is_tensor("S_11 [MPa]"), is_tensor("E11 (engineering)"), is_tensor("eyy")
    (True, False, False)
    """
    return _TENSOR.fullmatch(title.strip()) is not None


def is_filler(word: str) -> bool:
    """Whether a word beside the name of a channel changes nothing."""
    return word in words(heading_words.FILLERS) or _CHANNEL.fullmatch(word) is not None


@cache
def qualifiers() -> frozenset[str]:
    """Return the words that tell a second reading of a quantity, or the measure of a strain or stress."""
    measures = [one for table in heading_words.MEASURES.values() for one in table.values()]
    return frozenset().union(*map(words, [heading_words.MENDED, *measures]))


def setting(key: str) -> str | None:
    """Return which setting a line above the table states, ``quiet`` for those that change nothing, None if unknown.

    >>> setting("Probenbreite b0"), setting("Epaisseur"), setting("Operador")
    ('width', 'thickness', None)
    """
    return setting_along(key)[0]


@cache
def setting_along(key: str) -> tuple[str | None, str]:
    """Return a setting, and the axis, 1 or 2, that is told behind its name, or nothing.

    >>> setting_along("Width Y"), setting_along("Gauge length warp"), setting_along("Width w")
    (('width', '2'), ('gauge length', '1'), ('width', ''))
    """
    label = plain(without_brackets(key))
    for name, phrases in _settings().items():
        if label in phrases:
            of_gauge = name == "gauge length" and "extensometer" in plain(key)  # Gage length (Extensometer)
            return ("extensometer length" if of_gauge else name), ""
    head, _, last = label.rpartition(" ")
    axis = axis_of(last)
    if not head or not (axis or len(last) <= 2):
        return None, ""
    found = setting(head)
    if len(last) > 2 and found not in ("width", "gauge length", "grip distance"):
        return None, ""
    return found, axis


def axis_of(word: str) -> str:
    """Return the axis of a biaxial test, 1 or 2, that a number, a letter or the word of a direction stands for."""
    named = {"warp": "1", "weft": "2", "x": "1", "y": "2", "1": "1", "2": "2"}
    return named.get(word_for(word, "DIRECTIONS") or word.casefold(), "")


@cache
def _settings() -> dict[str, frozenset[str]]:
    found = {name: words(phrases) for name, phrases in setting_words.SETTINGS.items()}
    return {**found, "quiet": words(setting_words.QUIET)}


@cache
def word_for(text: str, table: str) -> str | None:
    """Return the entry of ``heading_words.TESTS``, ``DIRECTIONS`` or ``BRANCHES`` that ``text`` is a word for."""
    label = plain(text) if text.strip() not in ("+1", "-1") else text.strip()
    entries: Mapping[str, str] = getattr(heading_words, table)
    for name, phrases in entries.items():
        if label in words(phrases) or label in (one.strip() for one in phrases.split(";")):
            return name
    return None


def is_closing(text: str) -> bool:
    """Whether a cell begins a row of means or the like.

    >>> is_closing("s"), is_closing("Mean 2"), is_closing("2.5 s")
    (True, True, False)
    """
    label = plain(text)
    if re.match(r"[-+.,]?\d", text):  # a time
        return False
    core = " ".join(word for word in label.split() if not word.isdigit())
    return not words(heading_words.CLOSING).isdisjoint((label, core))


def without_brackets(label: str) -> str:
    """Return a label without what stands in its brackets."""
    return BRACKETS.sub(" ", label)
