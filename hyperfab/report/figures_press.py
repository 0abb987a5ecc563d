"""Pictures of a pressed tool: the spotted male mold seen along the closing axis, the gaps, the force."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array

_LIGHT = np.array([-0.35, 0.45, 0.82])
_STEEL = np.array([0.80, 0.81, 0.82])
_BLUE = np.array([0.05, 0.20, 0.62])
_RED = np.array([0.80, 0.10, 0.10])


@dataclass(frozen=True)
class SpottedMold:
    """What the picture shows, in the press frame: ``vertices`` (n, 3), ``faces`` (m, 3), vertex ``normals`` (n, 3),
    ``gap`` and ``pressure`` (n,), ``level`` (n,) [mm] how deep the sandwich is touched, ``areas`` (n,) [mm^2]."""

    vertices: Array
    faces: NDArray[np.int64]
    normals: Array
    gap: Array
    pressure: Array
    level: Array
    areas: Array
    thickness: float
    axes: tuple[str, str]


def spotting(mold: SpottedMold, curve: Array, title: str) -> bytes:
    """Return a PNG: the male mold as blue paste would leave it, the gap's histogram, force over stroke.

    ``curve`` (k, 2) is stroke [mm] and force [N].
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    figure = Figure(figsize=(11.0, 5.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    grid = GridSpec(2, 2, figure=figure, width_ratios=[1.55, 1.0])
    _plan(figure, figure.add_subplot(grid[:, 0]), mold)
    _histogram(figure.add_subplot(grid[0, 1]), mold)
    _force(figure.add_subplot(grid[1, 1]), curve)
    figure.suptitle(title, fontsize=11)
    target = io.BytesIO()
    figure.savefig(target, format="png", metadata={"Software": None})
    return target.getvalue()


def _plan(figure: Any, axes: Any, mold: SpottedMold) -> None:
    """The mold from above: shaded steel, blue where it touches, deeper blue where it presses harder."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import TriMesh
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.tri import Triangulation

    # What lies higher is drawn later.
    order = np.argsort(mold.vertices[mold.faces, 2].mean(axis=1), kind="stable")
    shade = 0.55 + 0.45 * np.clip(mold.normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    top = max(float(mold.pressure.max()), 1e-30)
    # Half the blue comes with the first touch, as with paste; the rest grows with pressure.
    blue = np.where(mold.level > 0.0, 0.35 + 0.65 * np.sqrt(mold.pressure / top), 0.0)[:, None]
    colour = np.outer(shade, _STEEL) * (1.0 - blue) + _BLUE * blue * (0.6 + 0.4 * shade[:, None])
    colour[mold.gap <= 0.0] = _RED
    plan = TriMesh(Triangulation(mold.vertices[:, 0], mold.vertices[:, 1], mold.faces[order]))
    plan.set_facecolor(np.clip(colour, 0.0, 1.0))
    axes.add_collection(plan)
    if (mold.level > 0.0).any() and (mold.level < 0.0).any():
        axes.tricontour(
            mold.vertices[:, 0],
            mold.vertices[:, 1],
            mold.faces,
            mold.level,
            levels=[0.0],
            colors="0.15",
            linewidths=0.7,
        )
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel(f"{mold.axes[0]} [mm]")
    axes.set_ylabel(f"{mold.axes[1]} [mm]")
    axes.set_title("Male mold, blue where it touches", fontsize=10)
    steps = np.linspace(0.0, 1.0, 64)[:, None]
    ramp = 0.35 + 0.65 * np.sqrt(steps)
    bar = ScalarMappable(Normalize(0.0, 1000.0 * top), ListedColormap(_STEEL * (1.0 - ramp) + _BLUE * ramp))
    figure.colorbar(bar, ax=axes, label="pressure [kPa]", shrink=0.8)


def _histogram(axes: Any, mold: SpottedMold) -> None:
    finite = np.isfinite(mold.gap)
    axes.hist(mold.gap[finite], bins=60, weights=mold.areas[finite] / 100.0, color="0.6")
    axes.axvline(mold.thickness, color=tuple(_BLUE), linewidth=1.2)
    axes.set_xlabel("gap [mm]; the line is the sandwich's thickness")
    axes.set_ylabel("area [cm²]")


def _force(axes: Any, curve: Array) -> None:
    axes.plot(curve[:, 0], curve[:, 1], color=tuple(_BLUE), marker=".", markersize=4)
    axes.set_xlabel("stroke from first touch [mm]")
    axes.set_ylabel("closing force [N]")
    axes.grid(alpha=0.3)


@dataclass(frozen=True)
class FormedMold:
    """What stays when the press opens, in the press frame: ``vertices`` (n, 3), ``faces`` (m, 3) that mold, the formed
    ``thickness`` (n,) [mm] and, where one is wanted, by how much it is ``off`` (n,) [mm]."""

    vertices: Array
    faces: NDArray[np.int64]
    thickness: Array
    off: Array | None
    axes: tuple[str, str]


def formed_map(mold: FormedMold, title: str) -> bytes:
    """Return a PNG: the formed thickness seen along the closing axis, and what it misses the wanted one by."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.tri import Triangulation

    shown: list[tuple[str, Array, str, float | None]] = [
        ("formed thickness [mm]", mold.thickness, "viridis", None)
    ]
    used = np.unique(mold.faces)
    if mold.off is not None:
        farthest = max(float(np.abs(mold.off[used]).max()), 1e-6)
        shown.append(("formed less wanted [mm]", mold.off, "RdBu_r", farthest))
    figure = Figure(figsize=(5.8 * len(shown), 5.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    order = np.argsort(mold.vertices[mold.faces, 2].mean(axis=1), kind="stable")
    plan = Triangulation(mold.vertices[:, 0], mold.vertices[:, 1], mold.faces[order])
    for axes, (label, values, colours, most) in zip(
        figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True
    ):
        low, high = (float(values[used].min()), float(values[used].max())) if most is None else (-most, most)
        drawn = axes.tripcolor(
            plan, values, shading="gouraud", cmap=colours, vmin=low, vmax=max(high, low + 1e-6)
        )
        figure.colorbar(drawn, ax=axes, label=label, shrink=0.8)
        across = mold.vertices[used]
        axes.set_xlim(across[:, 0].min(), across[:, 0].max())
        axes.set_ylim(across[:, 1].min(), across[:, 1].max())
        axes.set_aspect("equal")
        axes.set_xlabel(f"{mold.axes[0]} [mm]")
        axes.set_ylabel(f"{mold.axes[1]} [mm]")
    figure.suptitle(title, fontsize=11)
    target = io.BytesIO()
    figure.savefig(target, format="png", metadata={"Software": None})
    return target.getvalue()
