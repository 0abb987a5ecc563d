"""The picture of a sphere test: force against depth, the deformed sheet, its stress, the difference of two laws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from hyperfab.arrays import Array, Ints
from hyperfab.report.labels import COLOURS, draw_interval, png


@dataclass(frozen=True)
class Surface:
    """A surface of triangles: points (n, 3) [mm], triangles (m, 3), a value (n,) at each point."""

    points: Array
    triangles: Ints
    values: Array


@dataclass(frozen=True)
class Curve:
    """A force-depth curve and its name; ``interval``: where the last force is to be expected, where that is known."""

    name: str
    depth: Sequence[float]
    force: Sequence[float]
    ended: str | None = None
    interval: tuple[float, float] | None = None


def contact_figure(curves: Sequence[Curve], stress: Surface | None, difference: Surface | None) -> bytes:
    """Return the picture as PNG: force against depth, and one or two views of the sheet."""
    views = [("larger Cauchy stress [MPa]", stress, "viridis")] if stress is not None else []
    if difference is not None:
        views.append(("difference of the two laws' stresses [MPa]", difference, "magma"))
    # A fixed layout: one that looks for the best place draws all triangles twice.
    width = 5.2 + 5.6 * len(views)
    figure = Figure(figsize=(width, 4.8))
    grid = figure.add_gridspec(
        1, 1 + len(views), width_ratios=[1.0] + [1.15] * len(views), left=0.7 / width, right=1 - 0.55 / width,
        bottom=0.12, top=0.96, wspace=0.12,
    )  # fmt: skip
    axes = figure.add_subplot(grid[0, 0])
    for curve, colour in zip(curves, COLOURS, strict=False):
        axes.plot(curve.depth, curve.force, marker="o", markersize=3, color=colour, label=curve.name)
        if curve.interval is not None:
            draw_interval(axes, (curve.depth[-1], curve.force[-1]), force=curve.interval, colour=colour)
        if curve.ended and len(curve.depth) > 1:
            axes.plot(curve.depth[-1], curve.force[-1], marker="x", markersize=9, color=colour)
            axes.annotate(
                curve.ended, (curve.depth[-1], curve.force[-1]), textcoords="offset points", xytext=(-6, 8),
                ha="right", fontsize=8,
            )  # fmt: skip
    axes.set(xlabel="depth [mm]", ylabel="force [N]", xlim=(0, None), ylim=(0, None))
    axes.grid(alpha=0.3)
    if len(curves) > 1:
        axes.legend()
    for number, (title, surface, colours) in enumerate(views, start=1):
        _view(figure, figure.add_subplot(grid[0, number], projection="3d"), surface, title, colours)
    return png(figure, 110)


def _view(figure: Figure, scene, surface: Surface, title: str, colours: str) -> None:  # type: ignore[no-untyped-def]
    corners = surface.points[surface.triangles]
    mean = surface.values[surface.triangles].mean(axis=1)
    scale = Normalize(min(0.0, float(mean.min())), max(float(mean.max()), 1e-12))
    mapped = ScalarMappable(scale, colours)
    scene.add_collection3d(Poly3DCollection(corners, facecolors=mapped.to_rgba(mean), edgecolor="none"))
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    scene.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], max(high[2], low[2] + 1.0)))
    scene.set_box_aspect(np.maximum(high - low, 0.05 * (high - low).max()))
    scene.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    scene.tick_params(labelsize=8, pad=0)
    for axis in (scene.xaxis, scene.yaxis, scene.zaxis):
        axis.set_major_locator(MaxNLocator(5))
    scene.view_init(elev=28, azim=-58)
    figure.colorbar(mapped, ax=scene, label=title, shrink=0.62, pad=0.14)
