"""The picture of a closed loop: measured against predicted, the residual before and after, and the candidates."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

Array = NDArray[np.float64]

_BEFORE, _AFTER, _DATA = "#D55E00", "#0072B2", "0.25"
_MOST_CURVES, _MOST_STATES, _MOST_ENTRIES = 12, 5, 10


def loop_figure(
    *,
    abscissa: Array,
    label: str,
    unit: str,
    curves: Sequence[slice],
    names: Sequence[str],
    measured: Array,
    before: Array,
    after: Array,
    sd: Array,
    states: Mapping[str, Array],
    scores: Mapping[str, float],
    scores_label: str,
    verdict: str,
    added: Sequence[str],
) -> bytes:
    """Return the picture as PNG.

    ``curves`` are the rows of each test, ``states`` the state variables the residual (in units of ``sd``)
    is drawn against.
    """
    shown = {name: values for name, values in states.items() if _varies(values)}
    shown = dict(list(shown.items())[:_MOST_STATES])
    columns = max(len(shown), 2)
    figure = Figure(figsize=(3.1 * columns + 1.0, 8.2), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, columns, height_ratios=[1.25, 1.0])
    split = max(columns - max(columns // 3, 1), 1)
    _curves(
        figure.add_subplot(grid[0, :split]), abscissa, label, unit, curves, names, measured, before, after
    )
    _scores(figure.add_subplot(grid[0, split:]), scores, scores_label, added)
    scale = np.maximum(sd, 1e-300)
    for column, (name, values) in enumerate(shown.items()):
        axes = figure.add_subplot(grid[1, column])
        _residual(axes, name, values, (measured - before) / scale, (measured - after) / scale)
        if column == 0:
            axes.set_ylabel("measured - model, in sd of the noise")
            axes.legend(fontsize=8, loc="best")
    title = f"verdict: {verdict}" + (f" ({', '.join(added)})" if added else "")
    figure.suptitle(title)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100, metadata={"Software": None})
    return buffer.getvalue()


def _varies(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 0 and float(np.ptp(known)) > 0.0


def _curves(axes, abscissa, label, unit, curves, names, measured, before, after) -> None:  # type: ignore[no-untyped-def]
    chosen = list(range(len(curves)))
    if len(chosen) > _MOST_CURVES:
        chosen = [round(i) for i in np.linspace(0, len(curves) - 1, _MOST_CURVES)]
    for number, index in enumerate(chosen):
        rows = curves[index]
        first = number == 0
        axes.plot(
            abscissa[rows], measured[rows], ".", ms=2.5, color=_DATA, label="measured" if first else None
        )
        axes.plot(abscissa[rows], before[rows], "-", lw=0.9, color=_BEFORE, label="before" if first else None)
        axes.plot(abscissa[rows], after[rows], "-", lw=1.2, color=_AFTER, label="after" if first else None)
    axes.set(xlabel=label, ylabel=f"[{unit}]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    if len(chosen) < len(curves):
        axes.set_title(f"{len(chosen)} of {len(curves)} tests", fontsize=9)


def _scores(axes, scores: Mapping[str, float], label: str, added: Sequence[str]) -> None:  # type: ignore[no-untyped-def]
    rows = sorted(scores.items(), key=lambda item: item[1])[-_MOST_ENTRIES:]
    colours = [_AFTER if name in added else "0.7" for name, _ in rows]
    values = np.array([max(value, 0.0) for _, value in rows])
    axes.barh(range(len(rows)), values, color=colours)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=8)
    if len(values) and values.max() > 0.0:
        axes.set_xscale("symlog", linthresh=10.0)
        axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel(label)


def _residual(axes, name: str, values: Array, before: Array, after: Array) -> None:  # type: ignore[no-untyped-def]
    spread = 0.0
    distinct = np.unique(values[np.isfinite(values)])
    if len(distinct) <= 8:
        spread = 0.12 * float(np.min(np.diff(distinct)))
    axes.axhspan(-2.0, 2.0, color="0.9")
    axes.plot(values - spread, before, ".", ms=2, color=_BEFORE, alpha=0.5, label="before")
    axes.plot(values + spread, after, ".", ms=2, color=_AFTER, alpha=0.5, label="after")
    axes.set_xlabel(name)
