"""The picture of a closed loop: measured against predicted, the residual before and after, and the candidates."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hyperfab.report.labels import AFTER, BEFORE, DATA, title, value_names

Array = NDArray[np.float64]

_MOST_CURVES, _MOST_STATES, _MOST_ENTRIES = 12, 5, 10
#: A state of no more values than this is shown value by value, under its own names.
_FEW = 8
#: States that say where on a sheet or mold a reading was taken.
PLACES = (("x0_mm", "y0_mm"), ("x_mm", "y_mm"))


def loop_figure(**given: Any) -> bytes:
    """Return the picture as PNG; ``given`` is what ``loop_drawing`` takes."""
    buffer = io.BytesIO()
    loop_drawing(**given).savefig(buffer, format="png", dpi=100, metadata={"Software": None})
    return buffer.getvalue()


def loop_drawing(
    *,
    abscissa: Array,
    label: str,
    unit: str,
    curves: Sequence[slice],
    measured: Array,
    before: Array,
    after: Array,
    sd: Array,
    states: Mapping[str, Array],
    scores: Mapping[str, float],
    scores_label: str,
    verdict: str,
    added: Sequence[str],
    value_words: Mapping[str, Sequence[str]] | None = None,
) -> Figure:
    """Return the picture.

    ``curves`` are the rows of each test, ``states`` the state variables the residual (in units of ``sd``) is drawn
    against; readings at scattered places are drawn as maps. ``value_words`` name what the values of a state number.
    """
    places = next((pair for pair in PLACES if all(name in states for name in pair)), None)
    shown = {name: values for name, values in states.items() if _varies(values)}
    shown = dict(list(shown.items())[:_MOST_STATES])
    columns = max(len(shown), 2)
    figure = Figure(figsize=(3.1 * columns + 1.0, 8.2), layout="constrained")
    FigureCanvasAgg(figure)
    halves = figure.add_gridspec(2, 1, height_ratios=[1.25, 1.0])
    split = max(columns - max(columns // 3, 1), 1)
    upper = halves[0].subgridspec(1, columns)
    if places is None:
        _curves(figure.add_subplot(upper[0, :split]), abscissa, label, unit, curves, measured, before, after)
    else:
        x, y = (states[name] for name in places)
        _maps(
            figure,
            upper[0, :split],
            places,
            x,
            y,
            states.get("axis"),
            measured - before,
            measured - after,
            unit,
        )
    _scores(figure.add_subplot(upper[0, split:]), scores, scores_label, added)
    scale = np.maximum(sd, 1e-300)
    lower = halves[1].subgridspec(1, columns)
    for column, (name, values) in enumerate(shown.items()):
        axes = figure.add_subplot(lower[0, column])
        known = (value_words or {}).get(name, ())
        _residual(axes, name, values, (measured - before) / scale, (measured - after) / scale, known)
        if column == 0:
            axes.set_ylabel("measured - model, in sd of the noise")
            axes.legend(fontsize=8, loc="best")
    heading = f"verdict: {verdict}" + (f" ({', '.join(added)})" if added else "")
    figure.suptitle(heading)
    return figure


def _varies(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 0 and float(np.ptp(known)) > 1e-6 * max(1.0, float(np.abs(known).max()))


def _curves(
    axes: Any,
    abscissa: Array,
    label: str,
    unit: str,
    curves: Sequence[slice],
    measured: Array,
    before: Array,
    after: Array,
) -> None:
    chosen = list(range(len(curves)))
    if len(chosen) > _MOST_CURVES:
        chosen = [round(i) for i in np.linspace(0, len(curves) - 1, _MOST_CURVES)]
    for number, index in enumerate(chosen):
        rows = curves[index]
        told = ("measured", "model before", "model after") if number == 0 else (None, None, None)
        axes.plot(abscissa[rows], measured[rows], ".", ms=2.5, color=DATA, label=told[0])
        axes.plot(abscissa[rows], before[rows], "-", lw=0.9, color=BEFORE, label=told[1])
        axes.plot(abscissa[rows], after[rows], "-", lw=1.2, color=AFTER, label=told[2])
    what = {
        "MPa": "nominal stress",
        "N/mm": "membrane stress",
        "N": "force",
        "degC": "temperature",
        "mm": "place",
    }
    axes.set(xlabel=label, ylabel=f"{what.get(unit, 'reading')} [{unit}]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    if len(chosen) < len(curves):
        axes.set_title(f"{len(chosen)} of {len(curves)} tests", fontsize=9)


def _maps(
    figure: Any,
    place: Any,
    names: tuple[str, str],
    x: Array,
    y: Array,
    axis: Array | None,
    before: Array,
    after: Array,
    unit: str,
) -> None:
    """Draw what is left at each place, before and after on one scale: arrows where it has two axes in the plane."""
    pair = place.subgridspec(1, 2)
    vectors = axis is not None and len(np.unique(axis)) == 3
    if vectors:
        assert axis is not None
        rows = [np.flatnonzero(axis == k) for k in range(3)]
        at = rows[0]
        rests = [np.stack([rest[k] for k in rows], axis=1) for rest in (before, after)]
        sizes = [np.linalg.norm(rest, axis=1) for rest in rests]
    else:
        at, sizes, rests = np.arange(len(x)), [before, after], []
    top = max(float(np.nanmax(np.abs(sizes[0]))), float(np.nanmax(np.abs(sizes[1]))), 1e-300)
    scale = Normalize(0.0 if vectors else -top, top)
    drawn, panels = None, []
    for number, (words, size) in enumerate(zip(("before", "after"), sizes, strict=True)):
        axes = figure.add_subplot(pair[0, number])
        colours = "viridis" if vectors else "RdBu_r"
        drawn = axes.scatter(
            x[at], y[at], c=size, cmap=colours, norm=scale, s=14, edgecolors="0.5", linewidths=0.2
        )
        if vectors:
            rest = rests[number]
            reach = 0.12 * max(float(np.ptp(x[at])), float(np.ptp(y[at])), 1e-9)
            axes.quiver(
                x[at], y[at], rest[:, 0], rest[:, 1], angles="xy", scale_units="xy", scale=top / reach,
                color="0.15", width=0.004,
            )  # fmt: skip
        root = float(np.sqrt(np.nanmean(size**2)))
        axes.set_title(f"{words}: {root:.3g} {unit} rms", fontsize=9)
        axes.set_aspect("equal")
        axes.set_xlabel(title(names[0]), fontsize=8)
        axes.set_ylabel(title(names[1]) if number == 0 else "", fontsize=8)
        axes.tick_params(labelsize=7)
        panels.append(axes)
    figure.colorbar(
        drawn, ax=panels, label=f"measured - model [{unit}]", shrink=0.75, location="bottom", aspect=40
    )


def _scores(axes: Any, scores: Mapping[str, float], label: str, added: Sequence[str]) -> None:
    rows = sorted(scores.items(), key=lambda item: item[1])[-_MOST_ENTRIES:]
    colours = [AFTER if name in added else "0.7" for name, _ in rows]
    values = np.array([max(value, 0.0) for _, value in rows])
    axes.barh(range(len(rows)), values, color=colours)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=8)
    if len(values) and values.max() > 0.0:
        axes.set_xscale("symlog", linthresh=10.0)
        axes.xaxis.set_major_formatter("{x:g}")
    else:
        axes.set_xlim(0.0, 10.0)
        axes.text(0.5, 0.5, "no entry helps", transform=axes.transAxes, ha="center", color="0.4")
    axes.set_xlabel(label)


def _residual(
    axes: Any, name: str, values: Array, before: Array, after: Array, known: Sequence[str] = ()
) -> None:
    """Draw what is left against a state: at its own values, or value by value where there are few."""
    axes.axhspan(-2.0, 2.0, color="0.9")
    finite = np.isfinite(values)
    distinct = np.unique(values[finite])
    at, beside = values, 0.0
    if len(distinct) <= _FEW:
        # Equally far apart, each under its own value, so that no reading seems to stand where none was taken.
        at, beside = np.full(len(values), np.nan), 0.14
        at[finite] = np.searchsorted(distinct, values[finite])
        axes.set_xticks(range(len(distinct)), value_names(name, distinct.tolist(), known))
        axes.set_xlim(-0.6, len(distinct) - 0.4)
        axes.tick_params(axis="x", labelsize=8, rotation=30 if len(distinct) > 4 else 0)
    else:
        axes.locator_params(axis="x", nbins=5)
    axes.plot(at - beside, before, ".", ms=2, color=BEFORE, alpha=0.5, label="before")
    axes.plot(at + beside, after, ".", ms=2, color=AFTER, alpha=0.5, label="after")
    axes.set_xlabel(title(name))
