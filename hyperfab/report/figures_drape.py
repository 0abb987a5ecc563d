"""Picture of a draped sheet: the net on its mold, and on the flat sheet stretch, stress, thickness, shear, contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LightSource, ListedColormap, Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from hyperfab.arrays import Array, Ints
from hyperfab.report.labels import draw_interval, png

if TYPE_CHECKING:
    from hyperfab.cloth import Answers

MOST_LINES = 60  # of the net in the picture, a side
MOST_FACETS = 4000  # of the mold in the picture; one of more is drawn from corners put together
COLOURS = "viridis"


@dataclass(frozen=True)
class Draped:
    """What a picture shows of a sheet of n by m nodes.

    ``points`` and ``flat`` (n, m, 3) mm, and the ``fields`` there. ``peak``: where it is stretched most, on the flat
    sheet and as draped. ``mold``: corners (k, 3) mm and facets (f, 3) in the frame of ``points``.
    """

    points: Array
    flat: Array
    fields: Answers
    peak: tuple[Sequence[float], Sequence[float]]
    mold: tuple[Array, Ints]


def drape_figure(
    draped: Draped,
    force_depth: Sequence[tuple[float, float]] | None,
    force: str,
    interval: tuple[float, float] | None,
) -> bytes:
    """PNG of a draped sheet with the ``force`` of the press in words, and where given in N against the depth in mm;
    ``interval`` is where the last force is to be expected, where that is known."""
    # A fixed layout: to measure out the room for labels would take as long as all the rest.
    figure = Figure(figsize=(19.0, 6.6))
    fields, larger = draped.fields, draped.fields.cell_stretch
    low = float(min(1.0, fields.cell_stretch_warp.min(), fields.cell_stretch_weft.min()))
    stretches = Normalize(low, max(fields.stretch_max, low + 1e-6))
    stresses = Normalize(0.0, float(max(fields.stress_warp.max(), fields.stress_weft.max(), 1e-12)))
    foot = 0.0 if force_depth is None else 0.27
    scene = figure.add_axes((0.0, foot + 0.13, 0.31, 0.72 - foot), projection="3d")
    _scene(scene, draped, larger, stretches)
    _worst(figure.add_axes((0.005, 0.85, 0.3, 0.13)), draped, force)
    bar = figure.add_axes((0.065, foot + 0.115, 0.18, 0.025))
    figure.colorbar(ScalarMappable(stretches, COLOURS), cax=bar, label="larger stretch", orientation="horizontal")
    if force_depth is not None:
        _curve(figure.add_axes((0.04, 0.085, 0.255, 0.18)), force_depth, interval)
    turn = max(float(np.abs(fields.cell_shear).max()), 1e-6)
    # Panels that share their colours share a bar, beside the last of them.
    panels = (
        ("Stretch along warp", fields.cell_stretch_warp, COLOURS, stretches, False),
        ("Stretch along weft", fields.cell_stretch_weft, COLOURS, stretches, False),
        (f"Larger stretch: {fields.stretch_max:.3f} at the cross", larger, COLOURS, stretches, True),
        (
            f"Thickness [mm], least {fields.cell_thickness.min():.3g}",
            fields.cell_thickness,
            COLOURS + "_r",
            None,
            True,
        ),
        ("Stress along warp [MPa]", fields.stress_warp, COLOURS, stresses, False),
        ("Stress along weft [MPa]", fields.stress_weft, COLOURS, stresses, True),
        ("Shear angle [deg]", fields.cell_shear, "RdBu_r", Normalize(-turn, turn), True),
    )
    x, y = draped.flat[:, :, 0], draped.flat[:, :, 1]
    grid = figure.add_gridspec(2, 4, left=0.345, right=0.965, bottom=0.085, top=0.945, wspace=0.36, hspace=0.16)
    sheets = np.asarray(grid.subplots(sharex=True, sharey=True))
    for axes in sheets[:, 0]:
        axes.set_ylabel("weft, flat [mm]", fontsize=8)
    for axes in sheets[1]:
        axes.set_xlabel("warp, flat [mm]", fontsize=8)
    for axes, (title, field, colours, norm, barred) in zip(sheets.flat, panels, strict=False):
        shading: Literal["gouraud", "flat"] = "gouraud" if field.shape == x.shape else "flat"
        image = axes.pcolormesh(x, y, field, cmap=colours, norm=norm, shading=shading, rasterized=True)
        if barred:
            figure.colorbar(image, cax=axes.inset_axes((1.03, 0.0, 0.05, 1.0))).ax.tick_params(labelsize=7)
        _label(axes, title)
    sheets[0, 2].plot(*draped.peak[0][:2], marker="x", color="tab:red", markersize=9, markeredgewidth=2)
    # 0 free, 1 on the mold, 2 slack, by cell: slack is what one looks for first.
    corner = fields.touching
    touching = corner[1:, 1:] | corner[:-1, 1:] | corner[1:, :-1] | corner[:-1, :-1]
    state = np.where(fields.cell_slack, 2, np.where(touching, 1, 0))
    three = ListedColormap(["#f2f2f2", "#7a9cc6", "#d62728"])
    sheets[1, 3].pcolormesh(x, y, state, cmap=three, vmin=-0.5, vmax=2.5, shading="flat", rasterized=True)
    _label(sheets[1, 3], "On the mold (blue), slack (red)")
    return png(figure, 100)


def _worst(axes: Any, draped: Draped, force: str) -> None:
    """What one looks for first, in words above the scene."""
    axes.set_axis_off()
    flat, at = draped.peak
    places = [", ".join(f"{round(x, 1) + 0.0:.1f}" for x in place) for place in (flat[:2], at)]
    axes.text(0.0, 1.0, f"Largest stretch {draped.fields.stretch_max:.3f}", fontsize=15, weight="bold", va="top")
    below = (
        f"at the red cross: ({places[0]}) mm of the flat sheet,\n({places[1]}) mm on the mold (grey).\n"
        f"Thinnest {draped.fields.cell_thickness.min():.3g} mm. Press force {force}."
    )
    axes.text(0.0, 0.55, below, fontsize=10.5, va="top", linespacing=1.4)


def _curve(axes: Any, force_depth: Sequence[tuple[float, float]], interval: tuple[float, float] | None) -> None:
    axes.plot(*zip(*force_depth, strict=True), marker="o", color="tab:blue")
    draw_interval(axes, force_depth[-1], force=interval, colour="tab:blue")
    axes.set_title("Force of the press", fontsize=10)
    axes.set_xlabel("depth [mm]", fontsize=8)
    axes.set_ylabel("force [N]", fontsize=8)
    axes.grid(alpha=0.3)
    axes.tick_params(labelsize=7)


def _label(axes: Any, title: str) -> None:
    axes.set_title(title, fontsize=10, y=1.0)  # no height given: all ticks would be measured
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)


def _scene(scene: Any, draped: Draped, field: Array, scale: Normalize) -> None:
    """The net, see-through, on the mold."""
    points = draped.points
    pick = [np.unique(np.linspace(0, k - 1, min(k, MOST_LINES)).round().astype(int)) for k in points.shape[:2]]
    p = points[np.ix_(*pick)]
    v = field[np.ix_(*(np.minimum(one[:-1], k - 1) for one, k in zip(pick, field.shape, strict=True)))]
    quads = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], 2).reshape(-1, 4, 3)
    colours = matplotlib.colormaps[COLOURS](scale(v.ravel()))
    colours[:, 3] = 0.62
    facets = _facets(*draped.mold, float(points[..., 2].min()))
    normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    light = 0.55 + 0.4 * np.clip(normal @ LightSource(azdeg=300, altdeg=50).direction, 0.0, 1.0)
    grey = np.column_stack([light, light, light, np.ones(len(light))])
    # One collection: matplotlib sorts by depth within a collection alone. All of four corners: it fills up those of
    # fewer with whatever the memory held, and its axes would span that.
    surfaces = Poly3DCollection(
        np.concatenate([facets[:, [0, 1, 2, 2]], quads]),
        facecolors=np.vstack([grey, colours]),
        edgecolors=["#00000000"] * len(facets) + ["#00000028"] * len(quads),
        linewidths=0.2,
    )
    scene.add_collection3d(surfaces)
    at = draped.peak[1]
    scene.plot([at[0]], [at[1]], [at[2]], marker="x", color="tab:red", markersize=9, markeredgewidth=2, zorder=99)
    low, high = points.reshape(-1, 3).min(0), points.reshape(-1, 3).max(0)
    span = np.maximum(high - low, 1e-9)
    scene.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], max(high[2], low[2] + 1e-9)))
    scene.set_box_aspect((span[0], span[1], max(span[2], 0.05 * span[0])))
    scene.set_xlabel("x [mm]", fontsize=8)
    scene.set_ylabel("y [mm]", fontsize=8)
    scene.locator_params(axis="z", nbins=3)
    scene.tick_params(labelsize=7, pad=0)
    scene.view_init(38.0, -58.0)


def _facets(corners: Array, faces: Ints, lowest: float) -> Array:
    """(f, 3, 3) facets that reach above ``lowest``, of corners put together where they are too many to draw."""
    faces = faces[corners[faces][..., 2].max(1) > lowest + 1e-9]
    cells = 60
    while len(faces) > MOST_FACETS and cells > 4:
        size = float(np.ptp(corners, axis=0).max()) / cells
        key = np.round((corners - corners.min(0)) / size).astype(np.int64)
        _, first, put = np.unique(key, axis=0, return_index=True, return_inverse=True)
        fewer = put.ravel()[faces]
        fewer = fewer[(np.diff(np.sort(fewer, axis=1), axis=1) > 0).all(1)]
        corners, faces, cells = corners[first], np.unique(fewer, axis=0) if len(fewer) else fewer, cells // 2
    found = corners[faces]
    # What is below the clamped sheet is cut off by the axes, not by matplotlib.
    found[..., 2] = np.maximum(found[..., 2], lowest)
    return np.asarray(found)
