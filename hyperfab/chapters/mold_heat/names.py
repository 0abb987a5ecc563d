"""Names of faces and parts in a mold document, checked before the mesher runs: a mistake is told at once."""

from __future__ import annotations

import difflib

from hyperfab.documents.mold import FacesInBox, MoldDocument
from hyperfab.errors import InputError

#: Where ``exposed`` stands: every outer face without another condition.
EXPOSED = "exposed"
#: The ways a face can look.
WAYS = ("x-", "x+", "y-", "y+", "z-", "z+", "all")


def refuse_unknown_names(document: MoldDocument, file: str) -> None:
    """Raise InputError with the nearest names where a place names no body of the document ``file``."""
    bodies = [*document.part, *document.cavity]
    known = [b.name for b in bodies] + [s.name for b in bodies for s in b.shapes or [] if s.name]
    parts = [part.name for part in document.part]
    for key, place in document.places():
        if isinstance(place, FacesInBox):
            _known(file, key, place.part, parts, "part")
        elif place != EXPOSED:
            body, _, way = place.rpartition(".")
            if not body or way not in WAYS:
                raise InputError(
                    f"{place!r} names no face",
                    file=file,
                    key=key,
                    remedy=f"write NAME.WAY, as {known[0]}.z+, with WAY one of {' '.join(WAYS)}",
                )
            _known(file, key, body, known, "body", f".{way}")
    for number, heater in enumerate(document.heater):
        if heater.volume is not None:
            _known(file, f"heater.{number}.volume", heater.volume, parts, "part")
    for number, contact in enumerate(document.contact):
        for part in contact.between:
            _known(file, f"contact.{number}.between", part, parts, "part")


def refuse_exposed(document: MoldDocument, file: str) -> None:
    """Raise InputError where ``exposed`` stands for anything but one film and one radiation."""
    seen: dict[str, str] = {}
    for key, place in document.places():
        kind = key.split(".")[0]
        if place != EXPOSED:
            continue
        if kind not in ("convection", "radiation"):
            raise InputError(
                "exposed is where convection and radiation act",
                file=file,
                key=key,
                remedy="name the faces",
            )
        if kind in seen:
            raise InputError(
                f"exposed has a {kind} already, {seen[kind]}",
                file=file,
                key=key,
                remedy="take one of the two out, or name its faces",
            )
        seen[kind] = key


def _known(file: str, key: str, name: str, known: list[str], what: str, tail: str = "") -> None:
    if name not in known:
        near = difflib.get_close_matches(name, known, 4, 0.4) or known[:8]
        offered = ", ".join(other + tail for other in near)
        raise InputError(
            f"there is no {what} {name!r}",
            file=file,
            key=key,
            remedy=f"the nearest names are {offered}",
        )
