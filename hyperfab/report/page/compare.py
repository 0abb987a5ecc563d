"""Two and more molds side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hyperfab.report.page.parts import Cell, Source, Table, number, warmup_cell, word


def molds(sources: Sequence[Source]) -> Table | None:
    """Return the figures of all molds in one table; None where there are fewer than two."""
    heated = [source for source in sources if source.kind == "heat"]
    if len(heated) < 2:
        return None
    rows = []
    for title, unit, find in _ROWS:
        cells = [_cell(source, find, unit) for source in heated]
        if any(cell.number for cell in cells):
            rows.append([word(title), *cells])
    names = [source.name.rsplit("/", 1)[-1].removesuffix(".json") for source in heated]
    return Table("The molds of this page", ["", *names], rows)


_ROWS: tuple[tuple[str, str, Callable[[Any], Any]], ...] = (
    ("warm-up", "min", warmup_cell),
    ("spread at warm-up", "K", lambda data: data["work_surface"]["at_warmup"]["spread_K"]),
    ("heat supplied", "MJ", lambda data: data["energy"]["supplied_J"] / 1e6),
    ("heat lost", "MJ", lambda data: data["energy"]["lost_J"] / 1e6),
    ("heat stored", "MJ", lambda data: data["energy"]["stored_J"] / 1e6),
    ("efficiency", "%", lambda data: 100.0 * data["efficiency"]),
    ("mass", "kg", lambda data: data["mass_kg"]),
)


def _cell(source: Source, find: Callable[[Any], Any], unit: str) -> Cell:
    try:
        value = find(source.data)
    except (KeyError, TypeError):
        return Cell("")
    if isinstance(value, Cell):
        return value
    return number(value, unit) if isinstance(value, (int, float)) else Cell("")
