"""Picture of a draped sheet: the net in space with its stress, and the flat sheet with stress, thickness, contact."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

Floats = npt.NDArray[np.float64]

MOST_LINES = 60  # of the net in the picture, a side


def drape_figure(
    points: Floats,
    flat: Floats,
    stress_warp: Floats,
    stress_weft: Floats,
    thickness: Floats,
    contact: npt.NDArray[np.bool_],
    slack: npt.NDArray[np.bool_],
    force_depth: Sequence[tuple[float, float]] | None = None,
) -> bytes:
    """PNG of a draped sheet, and where given the force in N of the press against the depth in mm.

    ``points`` and ``flat`` (n, m, 3) mm; stresses (n, m) MPa; ``thickness`` (n - 1, m - 1) mm; ``contact`` (n, m);
    ``slack`` (n - 1, m - 1).
    """
    figure = Figure(figsize=(12.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    heights = (1.0, 1.0) if force_depth is None else (1.7, 1.0)
    grid = figure.add_gridspec(2, 3, width_ratios=(1.7, 1.0, 1.0))
    left = grid[:, 0].subgridspec(2, 1, height_ratios=heights, hspace=0.05)
    scene = figure.add_subplot(left[:] if force_depth is None else left[0], projection="3d")
    if force_depth is not None:
        axes = figure.add_subplot(left[1])
        axes.plot(*zip(*force_depth, strict=True), marker="o", color="tab:blue")
        axes.set_title("Force of the press", fontsize=10)
        axes.set_xlabel("depth [mm]", fontsize=8)
        axes.set_ylabel("force [N]", fontsize=8)
        axes.grid(alpha=0.3)
        axes.tick_params(labelsize=7)
    top = float(max(stress_warp.max(), stress_weft.max(), 1e-12))
    scale = Normalize(0.0, top)
    _net(scene, points, np.maximum(stress_warp, stress_weft), scale)
    figure.colorbar(
        ScalarMappable(scale, "viridis"),
        ax=scene,
        label="larger nominal stress [MPa]",
        orientation="horizontal",
        shrink=0.6,
        pad=0.04,
    )
    x, y = flat[:, :, 0], flat[:, :, 1]
    panels = (
        ("Stress along warp [MPa]", stress_warp, "viridis", scale),
        ("Stress along weft [MPa]", stress_weft, "viridis", scale),
        ("Thickness [mm]", thickness, "cividis", None),
    )
    for index, (title, field, colours, norm) in enumerate(panels):
        axes = figure.add_subplot(grid[index // 2, 1 + index % 2])
        image = axes.pcolormesh(
            x,
            y,
            field,
            cmap=colours,
            norm=norm,
            shading="gouraud" if field.shape == x.shape else "flat",
            rasterized=True,
        )
        figure.colorbar(image, ax=axes, shrink=0.8).ax.tick_params(labelsize=7)
        _label(axes, title)
    axes = figure.add_subplot(grid[1, 2])
    axes.pcolormesh(x, y, contact.astype(float), cmap="Greys", vmin=0.0, vmax=2.0, shading="gouraud")
    if slack.any():
        centres = 0.25 * (flat[1:, 1:] + flat[:-1, 1:] + flat[1:, :-1] + flat[:-1, :-1])[slack]
        axes.scatter(centres[:, 0], centres[:, 1], s=1.0, c="tab:red", linewidths=0.0)
    _label(axes, "On the mold (grey), slack (red)")
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110, metadata={"Software": None})
    return out.getvalue()


def _label(axes: Any, title: str) -> None:
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlabel("warp, flat [mm]", fontsize=8)
    axes.set_ylabel("weft, flat [mm]", fontsize=8)
    axes.tick_params(labelsize=7)


def _net(scene: Any, points: Floats, field: Floats, scale: Normalize) -> None:
    import matplotlib

    pick = [np.unique(np.linspace(0, k - 1, min(k, MOST_LINES)).round().astype(int)) for k in field.shape]
    p, v = points[np.ix_(*pick)], field[np.ix_(*pick)]
    quads = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], 2).reshape(-1, 4, 3)
    value = 0.25 * (v[:-1, :-1] + v[1:, :-1] + v[1:, 1:] + v[:-1, 1:]).ravel()
    colours = matplotlib.colormaps["viridis"](scale(value))
    scene.add_collection3d(
        Poly3DCollection(quads, facecolors=colours, edgecolors="#00000030", linewidths=0.2)
    )
    low, high = points.reshape(-1, 3).min(0), points.reshape(-1, 3).max(0)
    span = np.maximum(high - low, 1e-9)
    scene.set_xlim(low[0], high[0])
    scene.set_ylim(low[1], high[1])
    scene.set_zlim(low[2], max(high[2], low[2] + 1e-9))
    scene.set_box_aspect((span[0], span[1], max(span[2], 0.05 * span[0])), zoom=0.95)
    scene.set_xlabel("x [mm]", fontsize=8)
    scene.set_ylabel("y [mm]", fontsize=8)
    scene.set_zlabel("z [mm]", fontsize=8)
    scene.locator_params(axis="z", nbins=3)
    scene.tick_params(labelsize=7, pad=0)
    scene.view_init(32.0, -58.0)
