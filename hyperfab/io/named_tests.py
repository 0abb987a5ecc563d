"""Which kind of test words name: those of a method, a title, a file's name or the heads of columns."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

from hyperfab.io import heading_words
from hyperfab.io.dictionary import plain, words

#: What parts a title into words of a test and words of what is tested.
PARTS = re.compile(r"[,;:()\[\]|]|\s[-\u2013\u2014/]\s")
#: A word that a kind stands before (compression test), or behind (ensayo de compresión), and what links them then.
_ENDS = frozenset(
    ["test", "tests", "testing", "versuch", "versuche", "prufung", "method", "methode", "testi", "deneyi"]
)
_BEGINS = frozenset(["test", "tests", "ensayo", "essai", "prova", "ensaio", "proba"])
_LINKS = frozenset(["de", "di", "do", "da", "a", "en", "in", "of"])
#: Words that join kinds: Zug- und Druckversuch.
_JOINS = frozenset(["and", "und", "et", "y", "e", "or", "oder", "ou", "o"])
#: Phrases that say by themselves that they are of a test: Zugversuch, ISO 13934-1.
_OF_A_TEST = re.compile(r".*(?:versuche?|prufung|proef)|(?:iso|astm|en|msaj)\b.*")


@dataclass(frozen=True)
class Named:
    """The kind of test that words name; ``sure`` where they say so of a test, or say nothing else.

    Others may be words of what is tested: a compression garment, a biaxial fabric.
    """

    kind: str
    sure: bool


@dataclass
class _Run:
    """Words of kinds that stand together; ``of_test`` where they are said of a test."""

    phrases: list[tuple[str, str]]
    of_test: bool = False

    @property
    def kinds(self) -> set[str]:
        found = {kind for kind, _ in self.phrases}
        pulls = [phrase for kind, phrase in self.phrases if kind == "uniaxial"]
        axial = all(phrase.startswith("uniaxial") for phrase in pulls)
        # That it is a pull does not say along how many axes; uniaxial, not which way.
        if len(found) > 1 and axial == ("compression" in found):
            found.discard("uniaxial")
        return found


def kind_named(text: str) -> str | None:
    """Return the test that words tell somewhere, as in a file's name or the name of a method; None if none or several.

    >>> kind_named("warp_uniaxial_3"), kind_named("ISO 13934-1 strip"), kind_named("planar or biaxial")
    ('uniaxial', 'uniaxial', None)
    >>> kind_named("Biaxial tensile test"), kind_named("uniaxial and biaxial")
    ('biaxial', None)
    """
    found = named_test(text)
    return found.kind if found else None


def named_test(text: str) -> Named | None:
    """Return the kind of test that words name, those said of a test before others; None if none or several.

    >>> named_test("Tensile test - compression garment"), named_test("compression_sock_warp")
    (Named(kind='uniaxial', sure=True), Named(kind='compression', sure=False))
    """
    weak: set[str] = set()
    sure: set[str] = set()
    for part in PARTS.split(text):
        runs, rest = _runs(part)
        for run in runs:
            (sure if run.of_test or not rest else weak).update(run.kinds)
    found = sure or weak
    return Named(next(iter(found)), bool(sure)) if len(found) == 1 else None


def is_test(text: str) -> bool:
    """Whether words name a test and nothing else: ``Tensile test ISO 13934-1``, but no ``Tensile test speed``."""
    runs, rest = _runs(text)
    return not rest and any(run.of_test for run in runs)


def is_pull(text: str) -> bool:
    """Whether words say of a test that it pulls along one axis: Tensile test, Zugversuch, ISO 13934-1; not uniaxial.

    >>> is_pull("Zugversuch Jersey"), is_pull("uniaxial"), is_pull("biaxial tensile test")
    (True, False, False)
    """
    runs = [(run, rest) for part in PARTS.split(text) for found, rest in [_runs(part)] for run in found]
    return any(
        (run.of_test or not rest)
        and run.kinds == {"uniaxial"}
        and any(phrase != "uniaxial" for _, phrase in run.phrases)
        for run, rest in runs
    )


def surest(names: Iterable[str]) -> Named | None:
    """Return the first of the kinds that ``names`` tell that is sure, else the first."""
    found = [one for one in map(named_test, names) if one is not None]
    return next((one for one in found if one.sure), found[0] if found else None)


@cache
def _phrases() -> dict[tuple[str, ...], str]:
    return {tuple(phrase.split()): name for name, phrases in heading_words.TESTS.items() for phrase in words(phrases)}


def _runs(text: str) -> tuple[list[_Run], bool]:
    """Return the kinds that stand together in a text, and whether it has other words, numbers not counted."""
    left = plain(text).split()
    found: list[_Run] = []
    run, begun, rest = _Run([]), False, False
    while left:
        count = next((n for n in range(min(len(left), 5), 0, -1) if tuple(left[:n]) in _phrases()), 0)
        word, phrase = left[0], " ".join(left[:count])
        ended = False
        if count:
            run.phrases.append((_phrases()[tuple(left[:count])], phrase))
            ended = left[count - 1] in _ENDS
            run.of_test |= begun or ended or word in _BEGINS or _OF_A_TEST.fullmatch(phrase) is not None
        elif word in _ENDS and run.phrases:
            run.of_test = ended = True
        elif word in _BEGINS or (begun and word in _LINKS):
            begun = True
        elif not (word in _JOINS and run.phrases):
            begun, ended = False, True
            rest |= not word.isdigit()
        if ended and run.phrases:
            found.append(run)
            run, begun = _Run([]), False
        left = left[max(count, 1) :]
    return [*found, run] if run.phrases else found, rest
