"""The picture of a fit: readings, the curves of the constants, unseen tests dashed, the unstable range shaded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hyperfab.arrays import Array, Flags
from hyperfab.report.labels import COLOURS, png

_COLOURS = (*COLOURS[:6], "#000000")
_MARKS = "os^Dv<>"
#: The test whose rows are shear strain and shear stress.
_SHEARED = "simple-shear"


@dataclass(frozen=True)
class Line:
    """One test: its readings, the curve of the constants, whether it was predicted, where it turns unstable.

    ``back`` marks readings taken on the way back. ``expected`` are stretches and both ends of the band in which
    readings of one more specimen are to be expected.
    """

    label: str
    mode: str
    stretch: Array
    stress: Array
    grid: Array
    model: Array
    predicted: bool
    unstable_from: float | None
    expected: tuple[Array, Array, Array] | None = None
    back: Flags | None = None


def fit_figure(panels: Sequence[tuple[str, Sequence[Line]]]) -> bytes:
    """Return the PNG of ``panels``, each a title and its tests; simple shear has axes of its own."""
    figure = Figure(figsize=(6.2 * len(panels), 4.6), dpi=120, layout="constrained")
    # One scale for all directions: side by side they are compared.
    ends = _ends([line.stress for _, lines in panels for line in lines if line.mode != _SHEARED])
    for number, (title, lines) in enumerate(panels, start=1):
        axes = figure.add_subplot(1, len(panels), number)
        if {line.mode for line in lines} == {_SHEARED}:
            _panel(
                axes,
                title,
                lines,
                _ends([line.stress for line in lines]),
                ("shear strain", "shear stress [MPa]"),
            )
        else:
            _panel(axes, title, lines, ends)
    return png(figure)


def _ends(measured: Sequence[Array]) -> tuple[float, float]:
    """Return the ends of the stress axis: a wild prediction must not squeeze the readings flat."""
    stress = np.concatenate(measured) if measured else np.zeros(1)
    low, high = min(0.0, float(stress.min())), float(stress.max())
    return 1.1 * low - 0.02 * (high - low), 1.25 * high + 1e-12


def _panel(
    axes: Axes,
    title: str,
    lines: Sequence[Line],
    ends: tuple[float, float],
    words: tuple[str, str] = ("stretch", "nominal stress [MPa]"),
) -> None:
    banded, returned = False, False
    for number, line in enumerate(lines):
        colour = _COLOURS[number % len(_COLOURS)]
        back = np.zeros(len(line.stretch), bool) if line.back is None else line.back
        axes.plot(
            line.stretch[~back],
            line.stress[~back],
            _MARKS[number % len(_MARKS)],
            color=colour,
            markersize=3.5,
            markerfacecolor="none",
            alpha=0.45,
        )
        if back.any():
            returned = True
            axes.plot(line.stretch[back], line.stress[back], ".", color=colour, markersize=2.5, alpha=0.45)
        if line.expected is not None:
            axes.fill_between(*line.expected, color=colour, alpha=0.15, linewidth=0)
            banded = True
        label = f"{line.label} (predicted)" if line.predicted else line.label
        axes.plot(
            line.grid,
            line.model,
            "--" if line.predicted else "-",
            color=colour,
            linewidth=1.8,
            zorder=3,
            label=label,
        )
        if line.unstable_from is not None and line.unstable_from < line.grid[-1]:
            axes.axvspan(line.unstable_from, line.grid[-1], color=colour, alpha=0.08, linewidth=0)
    axes.set(ylim=ends, xlabel=words[0], ylabel=words[1])
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3)
    if banded:
        axes.fill_between([], [], [], color="0.5", alpha=0.3, linewidth=0, label="next specimen, 95 %")
    if returned:
        axes.plot([], [], ".", color="0.4", markersize=4, label="unloading")
    if lines:
        axes.legend(fontsize=8)
