"""Tests of which a table gives no stretch and stress: by their titles, a pressure that bulges, results of curves."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

from hyperfab.io import heading_words
from hyperfab.io.dictionary import plain, words
from hyperfab.io.named_tests import PARTS

#: Titles of such tests, and what to do instead.
_UNREAD = {
    "picture frame; picture frame test; picture frame shear; trellis; trellis frame; trellis frame test; bilderrahmen":
        "a frame shears the whole cloth; a strip cut at 45 degrees tells that shear, with a line direction: 45 deg",
    "peel; peel test; 90deg peel; 180deg peel; t peel; schalversuch; tear; tear test; tear strength; trouser tear; "
    "weiterreissversuch; essai de pelage; essai de dechirure":
        "the load of a peel or a tear is at its tip, no stress of the sheet",
    "ball burst; ball burst test; ball penetration; ball penetration test; puncture; puncture test":
        "a sheet under a ball is of hf close-loop with the document of hf fabric-contact; "
        "hf fit takes strips and biaxial tests",
    "loop; looped; loop test; looped specimen; looped specimens; loop specimen; loop specimens; astm d4964; d4964":
        "a loop pulls two layers at once, so that --width is twice that of the strip",
}  # fmt: skip
#: Words of a test in which a pressure bulges a sheet.
_BULGES = "bulge; bulging; bubble; inflation; inflated; pole; apex; dome; berstdruck; wolbung; wolbhohe; polhohe"
#: What is said where a pressure is offered as the stress of a bulge.
BULGED = (
    "a pressure p that bulges a sheet is no stress of it: with the radius r of curvature at the pole, the stretch l "
    "there and the first thickness t the nominal stress is p r l / (2 t), along both axes"
)
#: Words of what is read off a whole curve.
_OF_RESULTS = re.compile(
    r"\b(max\w*|fmax|peak|break\w*|rupture|failure|yield|strength|toughness|modulus|e modul\w*|hochst\w*|bruch\w*|"
    r"reiss\w*|\w*festigkeit|lt|wt|emt|2hg5?|2hb|miu|mmd|smd|lc|wc|rottura|rotura|ruptura|massim\w|resisten\w*|resistance)\b"
)
#: What is said of a table of them, and what to do.
RESULTS = "results, a row a specimen, and hf reads the curves behind them"
READINGS = "export the readings (raw data)"


@cache
def unread(text: str) -> str | None:
    """Return what to do with a test of which no stretch and stress are read, where a title names one.

    >>> unread("Picture frame test, PES") is not None, unread("Knit for picture frames")
    (True, None)
    """
    named = {plain(part) for part in PARTS.split(text)}
    return next((told for names, told in _UNREAD.items() if named & words(names)), None)


def is_bulge(titles: Sequence[str], told: Sequence[str]) -> bool:
    """Whether the ``titles`` of columns have a pressure, and they or what is ``told`` say that it bulges a sheet.

    >>> is_bulge(["Pressure", "Pole height"], []), is_bulge(["Druck", "Stauchung"], ["PU foam"])
    (True, False)
    """
    labels = [plain(title) for title in titles]
    pressed = any(label in words(heading_words.PRESSURES) for label in labels)
    return pressed and any(words(_BULGES) & set(one.split()) for one in (*labels, *map(plain, told)))


def is_result(title: str) -> bool:
    """Whether the ``title`` of a column is of what is read off a whole curve.

    >>> is_result("Elongation at break [%]"), is_result("Load [N]"), is_result("Young's modulus")
    (True, False, True)
    """
    return _OF_RESULTS.search(plain(title)) is not None
