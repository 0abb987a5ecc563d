"""Pictures of a pressed tool: the spotted male mold seen along the closing axis, the gaps, the force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.report.labels import draw_interval, png

_LIGHT = np.array([-0.35, 0.45, 0.82])
_STEEL = (0.80, 0.81, 0.82)
_BLUE = (0.05, 0.20, 0.62)
_RED = (0.80, 0.10, 0.10)
#: Least pressure to largest, as paste that is pressed away deepens.
_PASTE = ("#bcd3f2", "#5b8fd6", "#0d3399", "#06174d")

#: The gaps' bars span this at least [mm].
_LEAST_WIDTH_MM = 1e-3


@dataclass(frozen=True)
class SpottedMold:
    """What the picture shows, in the press frame: ``vertices`` (n, 3), ``faces`` (m, 3), vertex ``normals`` (n, 3),
    ``gap`` and ``pressure`` (n,), ``level`` (n,) [mm] how deep the sandwich is touched, ``areas`` (n,) [mm^2]."""

    vertices: Array
    faces: Ints
    normals: Array
    gap: Array
    pressure: Array
    level: Array
    areas: Array
    thickness: float
    axes: tuple[str, str]


#: Where a figure is to be expected, None where nothing says so.
Interval = tuple[float, float] | None


def spotting(mold: SpottedMold, curve: Array, title: str, sure: tuple[Interval, Interval] = (None, None)) -> bytes:
    """Return the picture as PNG; ``curve`` (k, 2) is stroke [mm] and force [N], ``sure`` where the last of both are to
    be expected."""
    return png(spotting_drawing(mold, curve, title, sure))


def spotting_drawing(
    mold: SpottedMold, curve: Array, title: str, sure: tuple[Interval, Interval] = (None, None)
) -> Any:
    """Return the picture: the male mold as blue paste would leave it, the gap's histogram, force over stroke."""
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    figure = Figure(figsize=(11.0, 5.6), dpi=110)
    grid = GridSpec(
        2, 2, figure=figure, width_ratios=[1.55, 1.0], left=0.08, right=0.985, bottom=0.09, top=0.88, wspace=0.17,
        hspace=0.3,
    )  # fmt: skip
    _plan(figure, figure.add_subplot(grid[:, 0]), mold)
    _histogram(figure.add_subplot(grid[0, 1]), mold)
    _force(figure.add_subplot(grid[1, 1]), curve, sure)
    figure.suptitle(title, fontsize=11)
    return figure


def _from_above(mold: SpottedMold | FormedMold) -> Any:
    """Return the mold's facets in plan, those that lie higher drawn later."""
    from matplotlib.tri import Triangulation

    order = np.argsort(mold.vertices[mold.faces, 2].mean(axis=1), kind="stable")
    return Triangulation(mold.vertices[:, 0], mold.vertices[:, 1], mold.faces[order])


def _plan(figure: Any, axes: Any, mold: SpottedMold) -> None:
    """The mold from above: shaded steel, and where it touches its pressure alone, unshaded, over the range it has."""
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    shade = 0.55 + 0.45 * np.clip(mold.normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    plane = _from_above(mold)
    axes.tripcolor(
        plane, shade, shading="gouraud", cmap=LinearSegmentedColormap.from_list("steel", [(0.1, 0.1, 0.1), _STEEL]),
        norm=Normalize(0.0, 1.0),
    )  # fmt: skip
    touched = mold.level > 0.0
    if touched.any():
        pressure = 1000.0 * mold.pressure
        low, high = float(pressure[touched].min()), float(pressure[touched].max())
        # A pressure that is the same everywhere, to rounding, has no range: the bar shows a tenth about it.
        low, high = _at_least(max(0.1 * high, 1e-12), low, high)
        blue = axes.tripcolor(
            plane, pressure, shading="gouraud", cmap=LinearSegmentedColormap.from_list("paste", _PASTE),
            norm=Normalize(low, high),
        )  # fmt: skip
        figure.colorbar(blue, ax=axes, label="pressure where it touches [kPa]", shrink=0.8)
        if not touched.all():
            # Cut along the line where the touch begins, not along the facets.
            inside = axes.tricontourf(plane, mold.level, levels=[0.0, float(mold.level.max()) + 1.0], alpha=0.0)
            blue.set_clip_path(inside.get_paths()[0], transform=axes.transData)
            axes.tricontour(plane, mold.level, levels=[0.0], colors="0.15", linewidths=0.7)
    if (mold.gap <= 0.0).any():
        axes.plot(*mold.vertices[mold.gap <= 0.0, :2].T, ".", color=_RED, markersize=3)
    axes.autoscale_view()
    axes.margins(0.02)
    axes.set(aspect="equal", xlabel=f"{mold.axes[0]} [mm]", ylabel=f"{mold.axes[1]} [mm]")
    axes.set_title("Male mold, blue where it touches" + ("" if touched.any() else ": nowhere"), fontsize=10)


def _at_least(width: float, low: float, high: float) -> tuple[float, float]:
    """Return a range that is as wide at least, about its middle."""
    room = max(0.5 * (width - (high - low)), 0.0)
    return low - room, high + room


def _histogram(axes: Any, mold: SpottedMold) -> None:
    finite = np.isfinite(mold.gap)
    gap = mold.gap[finite]
    low, high = (float(gap.min()), float(gap.max())) if len(gap) else (0.0, 1.0)
    # A gap that is the same everywhere, to rounding, is one bar, wide enough to be seen beside the line.
    least = max(_LEAST_WIDTH_MM, 0.02 * abs(mold.thickness - low))
    across = _at_least(least, low, high)
    axes.hist(
        gap,
        bins=60 if across == (low, high) else 1,
        range=across,
        weights=mold.areas[finite] / 100.0,
        color="0.6",
    )
    axes.axvline(mold.thickness, color=_BLUE, linewidth=1.2)
    axes.set(xlabel="gap [mm]; the line is the sandwich's thickness", ylabel="area [cm²]")


def _force(axes: Any, curve: Array, sure: tuple[Interval, Interval]) -> None:
    axes.plot(curve[:, 0], curve[:, 1], color=_BLUE, marker=".", markersize=4)
    draw_interval(axes, (curve[-1, 0], curve[-1, 1]), across=sure[0], force=sure[1], colour=_BLUE)
    axes.set(xlabel="stroke from first touch [mm]", ylabel="closing force [N]")
    axes.grid(alpha=0.3)


@dataclass(frozen=True)
class FormedMold:
    """What stays when the press opens, in the press frame: ``vertices`` (n, 3), ``faces`` (m, 3) that mold, the formed
    ``thickness`` (n,) [mm] and, where one is wanted, by how much it is ``off`` (n,) [mm]."""

    vertices: Array
    faces: Ints
    thickness: Array
    off: Array | None
    axes: tuple[str, str]


def formed_map(mold: FormedMold, title: str) -> bytes:
    """Return a PNG: the formed thickness seen along the closing axis, and what it misses the wanted one by."""
    from matplotlib.figure import Figure

    shown: list[tuple[str, Array, str, float | None]] = [("formed thickness [mm]", mold.thickness, "viridis", None)]
    used = np.unique(mold.faces)
    if mold.off is not None:
        farthest = max(float(np.abs(mold.off[used]).max()), 1e-6)
        shown.append(("formed less wanted [mm]", mold.off, "RdBu_r", farthest))
    figure = Figure(figsize=(5.8 * len(shown), 5.2), dpi=110, layout="constrained")
    plan = _from_above(mold)
    for axes, (label, values, colours, most) in zip(
        figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True
    ):
        low, high = (float(values[used].min()), float(values[used].max())) if most is None else (-most, most)
        drawn = axes.tripcolor(plan, values, shading="gouraud", cmap=colours, vmin=low, vmax=max(high, low + 1e-6))
        figure.colorbar(drawn, ax=axes, label=label, shrink=0.8)
        x, y = mold.vertices[used, :2].T
        axes.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), aspect="equal")
        axes.set(xlabel=f"{mold.axes[0]} [mm]", ylabel=f"{mold.axes[1]} [mm]")
    figure.suptitle(title, fontsize=11)
    return png(figure)
