"""Sizes that are told in a sentence: Gauge length was 100 mm and width 50 mm; strips 50 mm wide."""

from __future__ import annotations

import re
from collections.abc import Iterator

from hyperfab.io.dictionary import plain, setting, words
from hyperfab.io.unit_table import UnitError
from hyperfab.io.units import column_factor

#: An amount, and what stands in the place of its unit.
_AMOUNT = re.compile(r"(?<![\w.,])(\d+(?:[.,]\d+)?) ?(\"|[^\W\d]{1,2})(?![\w/*^\u00b2\u00b3])")
#: Where a clause ends; in a number no blank follows the mark.
_CLAUSE = re.compile(r"[,;:()]\s|\.\s|\.$|\s[-\u2013]\s")
#: What stands between a size and its amount, and what joins a size to another.
_BETWEEN = words("of; was; is; were; are; about; approx; ca; the; ist; war; von; betrug; est; de; era; es; fue; e; em")
_JOINS = words("and; with; und; mit; et; avec; y; con; e; com; a; at; the; of; its; in; x")
#: How an amount is said to be a size behind it, and of what, in the same sentence.
_BEHIND = {
    "width": "wide; width; broad; breit; breite; de largeur; de ancho; larghi; largos; de largo",
    "thickness": "thick; thickness; dick; dicke; d epaisseur; de espesor; spessi; de espessura",
    "gauge length": "apart",
}
_OF = words("""strip; strips; specimen; specimens; sample; samples; streifen; probe; proben; eprouvette; eprouvettes;
    bande; bandes; probeta; probetas; tira; tiras; provini; provino; strisce; benchmarks; marks""")
_MARKS = words("benchmarks; bench marks; marks; gauge marks")
#: Of a machine, no size of a specimen.
_NOT_OF = words("jaw; jaws; grip; grips; clamp; clamps; klemme; klemmen; backen; ball; sphere; kugel; mors; mordazas")


def sizes_in_sentence(text: str) -> Iterator[tuple[str, str]]:
    """Yield what a sentence says of the sizes of a specimen: the setting and its value.

    A size is named before its amount, and begins the clause or is joined to another; or behind the amount, of strips or
    specimens that the sentence is about.

    >>> dict(sizes_in_sentence("Gauge length was 100 mm and width 50mm, preload 0.1 N"))
    {'gauge length': '100 mm', 'width': '50 mm'}
    >>> dict(sizes_in_sentence("Streifen 50 mm breit, 0,6 mm dick")), dict(sizes_in_sentence("Jaws 60 mm wide"))
    ({'width': '50 mm', 'thickness': '0,6 mm'}, {})
    >>> dict(sizes_in_sentence("Grip width 60 mm"))
    {}
    """
    for match in _AMOUNT.finditer(text):
        if not _is_length(match[2]):
            continue
        sentence = re.split(r"[.;]\s", text[: match.start()])[-1]
        before = plain(_CLAUSE.split(text[: match.start()])[-1]).split()
        while before and before[-1] in _BETWEEN:
            before.pop()
        after = plain(_CLAUSE.split(text[match.end() :])[0])
        named = None
        for count in range(min(len(before), 5), 0, -1):
            known = setting(" ".join(before[-count:]))
            joined = len(before) == count or before[-count - 1] in _JOINS or before[-count - 1][:1].isdigit()
            if known in ("width", "thickness", "gauge length", "grip distance") and joined:
                named = known
                break
        about = {*plain(sentence).split()}
        if named is None and about & _OF and not about & _NOT_OF:
            behind = {
                key: any(f"{after} ".startswith(f"{one} ") for one in words(told)) for key, told in _BEHIND.items()
            }
            named = next((key for key, one in behind.items() if one), None)
            named = None if named == "gauge length" and not about & _MARKS else named
        if named is not None:
            yield named, f"{match[1]} {match[2]}"


def _is_length(unit: str) -> bool:
    try:
        column_factor("in" if unit == '"' else unit, "length")
    except UnitError:
        return False
    return True
