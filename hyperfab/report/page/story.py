"""The order in which documents tell their story, and which was made from which, by the hash of what was read."""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.report.page.parts import Source

#: The line: material, sheet, drape, heat, press; then what was learnt from measurement, and studies.
ORDER = ("material", "contact", "drape", "heat", "press", "loop", "sweep")


def parents(source: Source, sources: Sequence[Source]) -> list[Source]:
    """Return the documents among ``sources`` that ``source`` was made from."""
    provenance = source.data.get("provenance") or {}
    read = {item.get("sha256") for item in provenance.get("inputs", []) if isinstance(item, dict)}
    return [other for other in sources if other.sha256 in read and other is not source]


def in_order(sources: Sequence[Source]) -> list[Source]:
    """Return the documents as the line runs; within a kind, as they were given."""
    known = {kind: place for place, kind in enumerate(ORDER)}
    return sorted(sources, key=lambda source: known.get(source.kind, len(ORDER)))
