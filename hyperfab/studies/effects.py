"""What a study says: the effect of each axis on each figure, the Pareto front of two figures, the best cases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.documents.sweep import Effect
from hyperfab.studies.axes import Axis, Layout
from hyperfab.studies.table import Table

#: Values that were drawn are gathered into this many classes of equal size, and so are axes of more levels than
#: ``MOST_LEVELS``.
CLASSES = 5
MOST_LEVELS = 100


def main_effects(table: Table, axes: Sequence[Axis]) -> list[Effect]:
    """Return the effect of each axis on each figure that is a number and varies.

    Its ``variance_share`` is the part of the figure's variance that lies between the levels: the correlation ratio eta
    squared.
    """
    found = []
    for axis in axes:
        names, groups = _levels(table, axis)
        if not names:
            continue
        for figure in table.figures:
            values = table.numbers(figure)
            if values is None:
                continue
            known = np.isfinite(values)
            if known.sum() < 2 or np.ptp(values[known]) == 0.0:
                continue
            parts = [values[group & known] for group in groups]
            used = [(name, part) for name, part in zip(names, parts, strict=True) if len(part)]
            mean = float(np.mean(values[known]))
            between = sum(len(part) * (float(np.mean(part)) - mean) ** 2 for _, part in used)
            total = float(np.sum((values[known] - mean) ** 2))
            levels, means = [name for name, _ in used], [float(np.mean(part)) for _, part in used]
            found.append(
                Effect(
                    axis=table.axes[axis.name],
                    figure=figure,
                    levels=levels,
                    means=means,
                    variance_share=float(between / total),
                )
            )
    return found


def idle(table: Table, layout: Layout) -> list[str]:
    """Return the axes along which no case finds anything else, where two or more came to their end along them; those
    that are drawn move together and are asked for together.
    """
    shape = (*(len(axis.levels) for axis in layout.listed), layout.samples)
    found = np.where(table.done, np.array(table.found, dtype=np.float64), np.nan).reshape(shape)
    names = [*([axis.name] for axis in layout.listed), [axis.name for axis in layout.drawn]]
    still = []
    for place, together in enumerate(names):
        line = np.moveaxis(found, place, 0)
        line = line[:, np.isfinite(line).sum(axis=0) > 1]
        if line.size and (np.nanmax(line, axis=0) == np.nanmin(line, axis=0)).all():
            still += together
    return still


def pareto_front(first: Array, second: Array) -> Ints:
    """Return the rows that no other row beats: less or equal in both figures and less in one. NaN never is in front.

    >>> pareto_front(np.array([1.0, 2.0, 3.0, 2.0]), np.array([3.0, 2.0, 1.0, 2.5])).tolist()
    [0, 1, 2]
    """
    rows = np.flatnonzero(np.isfinite(first) & np.isfinite(second))
    order = rows[np.lexsort((second[rows], first[rows]))]
    front, least = [], np.inf
    last: tuple[float, float] | None = None
    for row in order:
        pair = (float(first[row]), float(second[row]))
        if pair[1] < least or pair == last:
            front.append(int(row))
            least, last = min(least, pair[1]), pair
    return np.array(sorted(front), dtype=np.int64)


def _levels(table: Table, axis: Axis) -> tuple[list[float | str], list[Flags]]:
    column = table.columns[axis.column]
    few = len(axis.levels) <= MOST_LEVELS
    if not few and any(isinstance(level.value, str) for level in axis.levels):
        return [], []  # names in their thousands have no order to be gathered by
    if few and not axis.drawn:
        names = [level.value if isinstance(level.value, (int, float)) else str(level.value) for level in axis.levels]
        return names, [np.array([cell == name for cell in column]) for name in names]
    values = np.array([float(cell) for cell in column])  # type: ignore[arg-type]
    edges = np.quantile(values, np.linspace(0.0, 1.0, CLASSES + 1))
    classes = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, CLASSES - 1)
    groups = [classes == number for number in range(CLASSES)]
    kept = [group for group in groups if group.any()]
    return [float(f"{np.median(values[group]):.6g}") for group in kept], kept
