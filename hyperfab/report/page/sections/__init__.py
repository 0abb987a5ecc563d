"""One file a kind of document: what its section says first, and what it shows."""

from __future__ import annotations

import importlib

from hyperfab.errors import HyperfabError
from hyperfab.report.page import sure
from hyperfab.report.page.parts import Section, Source

#: Kinds of document that have a section of their own.
KINDS = ("material", "contact", "drape", "heat", "press", "loop", "sweep")

_NAMES = {
    "material": "Fabric",
    "contact": "Sheet under the sphere",
    "drape": "Drape",
    "heat": "Mold heat",
    "press": "Press",
    "loop": "Model against measurement",
    "sweep": "Study",
}


def build(source: Source) -> Section:
    """Return the section of a document. What cannot be read in it costs this section, not the page."""
    module = importlib.import_module(f"{__name__}.{source.kind}")
    try:
        section: Section = module.section(source)
        section.parts += sure.parts(source)
        section.warnings = [str(text) for text in source.data.get("warnings") or []]
    except (HyperfabError, KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        reason = str(error) if isinstance(error, HyperfabError) else f"{type(error).__name__}: {error}"
        return Section("", None, f"Cannot be shown: {reason}. Make the document again with this hf.")
    left_out = source.data.get("left_out")
    if left_out and isinstance(left_out, list):  # of a fit they are rows, by reason
        section.notes.append(f"Left out: {', '.join(left_out)}.")
    missing = [name for name in source.data.get("files", []) if not _there(source, name)]
    if missing:
        section.notes.append(f"Gone from beside the document, and missing here: {', '.join(missing)}.")
    return section


def heading(source: Source) -> str:
    """Return the title of a document's section."""
    return _NAMES[source.kind]


def _there(source: Source, name: str) -> bool:
    if (
        not name.endswith((".vtu", ".csv", ".png"))
        or name.removesuffix(".vtu").rpartition(".")[2].isdecimal()
    ):
        return True
    return source.sibling(name) is not None
