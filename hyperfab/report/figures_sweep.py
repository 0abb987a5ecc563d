"""Pictures of a study: main effects, and all cases as lines across axes and figures."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hyperfab.report.labels import png

if TYPE_CHECKING:
    from hyperfab.documents.sweep import Effect
    from hyperfab.studies.table import Table

#: More lines than this are a grey area; every n-th case is drawn then.
MAX_LINES = 2000


def effects_png(effects: Sequence[Effect]) -> bytes:
    """Draw the mean of each figure (a row) at each level of each axis (a column)."""
    axes = list(dict.fromkeys(effect.axis for effect in effects))
    figures = list(dict.fromkeys(effect.figure for effect in effects))
    figure = Figure(figsize=(2.6 * len(axes) + 1.2, 2.1 * len(figures) + 0.8), layout="constrained")
    grid = figure.subplots(len(figures), len(axes), squeeze=False, sharey="row")
    for effect in effects:
        panel = grid[figures.index(effect.figure), axes.index(effect.axis)]
        numbers = all(isinstance(level, (int, float)) for level in effect.levels)
        places = effect.levels if numbers else range(len(effect.levels))
        panel.plot(places, effect.means, "o-", color="#1f5fa8")
        if not numbers or len(effect.levels) <= 6:
            words = [f"{level:g}" if numbers else str(level) for level in effect.levels]
            panel.set_xticks(list(places), words, fontsize=7)
        panel.set_title(f"{100 * effect.variance_share:.0f} % of the variance", fontsize=8)
        panel.tick_params(labelsize=7)
        panel.grid(alpha=0.3)
    for row, name in enumerate(figures):
        grid[row, 0].set_ylabel(f"mean {name}", fontsize=8)
    for column, name in enumerate(axes):
        grid[-1, column].set_xlabel(name, fontsize=8)
    return png(figure, 110)


def cases_png(table: Table, front: Collection[str] | None) -> bytes:
    """Draw each case as a line across all axes and figures, each scaled to its range; the Pareto front stands out."""
    names = [*table.axes.values(), *table.figures]
    scaled = []
    labels = []
    for name in names:
        values = table.numbers(name)
        if values is None:
            words = sorted({str(cell) for cell in table.columns[name]})
            values = np.array([words.index(str(cell)) for cell in table.columns[name]], dtype=float)
            ends = (words[0], words[-1])
        else:
            known = values[np.isfinite(values)]
            ends = (f"{known.min():.4g}", f"{known.max():.4g}") if len(known) else ("", "")
        known = values[np.isfinite(values)]
        low, width = (float(known.min()), float(np.ptp(known)) or 1.0) if len(known) else (0.0, 1.0)
        scaled.append((values - low) / width)
        labels.append((name, *ends))
    lines = np.array(scaled).T
    figure = Figure(figsize=(1.5 * len(names) + 1.0, 4.2), layout="constrained")
    panel = figure.add_subplot()
    chosen = set(front or ())
    places = np.arange(len(names))
    for index in range(0, len(table), -(-len(table) // MAX_LINES)):
        panel.plot(places, lines[index], color="#7d8794", alpha=0.35, linewidth=0.7)
    for index, case in enumerate(table.columns["case"]):
        if case in chosen:
            panel.plot(places, lines[index], color="#c2410c", linewidth=1.4)
    panel.set_xticks(places, [f"{name}\n{low}" for name, low, _ in labels], fontsize=7)
    top = panel.secondary_xaxis("top")
    top.set_xticks(places, [high for _, _, high in labels], fontsize=7)
    told = f"{len(table)} cases" + ("; red: those that none beats" if chosen else "")
    figure.suptitle(told, fontsize=9)
    panel.set_yticks([])
    panel.set_xlim(-0.2, len(names) - 0.8)
    for place in range(len(names)):
        panel.axvline(place, color="black", linewidth=0.6)
    return png(figure, 110)
