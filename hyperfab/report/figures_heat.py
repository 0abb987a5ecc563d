"""Pictures of a heated mold: the work surface in temperature, and the curves of warm-up."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.report.labels import png


def heat_figure(
    points: Array,
    triangles: Ints,
    temperature: Array,
    curves: Mapping[str, Array],
    times: Array,
    target: float | None,
    title: str,
    warm: tuple[float, float] | None = None,
) -> bytes:
    """Return a PNG: the surface seen along its mean normal, and temperature against time.

    ``points`` (n, 3) [mm], ``triangles`` (m, 3), ``temperature`` (n,) [degC]; ``curves`` name arrays over ``times``
    [s]; without curves the surface is shown alone. ``title`` says at which time the surface is shown, and ``warm`` [s]
    between which times warm-up is to be expected, where that is known.
    """
    from matplotlib.figure import Figure
    from matplotlib.tri import Triangulation

    figure = Figure(figsize=(11 if curves else 6, 4.6), dpi=110, layout="constrained")
    axes = figure.subplots(1, 2 if curves else 1, squeeze=False)[0]
    across, labels = _view(points, triangles)
    flat = Triangulation(points[:, across[0]], points[:, across[1]], triangles)
    shown = axes[0].tripcolor(flat, temperature, shading="gouraud", cmap="inferno", rasterized=True)
    figure.colorbar(shown, ax=axes[0], shrink=0.85).ax.set_title(
        "°C", fontsize=9
    )  # the curves beside it have their own label
    axes[0].set(aspect="equal", xlabel=f"{labels[0]} [mm]", ylabel=f"{labels[1]} [mm]")
    axes[0].set_title(f"work surface {title}: {temperature.min():.1f} to {temperature.max():.1f} °C", fontsize=10)
    if curves:
        minutes = times / 60.0 if times[-1] > 600.0 else times
        for name, values in curves.items():
            axes[1].plot(minutes, values, label=name, linewidth=1.4)
        if warm is not None:
            scale = minutes[-1] / times[-1]
            axes[1].axvspan(*(scale * end for end in warm), color="0.85", zorder=0, label="warm-up, 95 % interval")
        if target is not None:
            axes[1].axhline(target, color="0.5", linewidth=0.8, linestyle="--")
        axes[1].set(xlabel="time [min]" if times[-1] > 600.0 else "time [s]", ylabel="temperature [°C]")
        axes[1].grid(alpha=0.3)
        if len(curves) <= 10:
            axes[1].legend(fontsize=8, frameon=False)
    return png(figure)


def _view(points: Array, triangles: Ints) -> tuple[tuple[int, int], tuple[str, str]]:
    """Look along the axis in which the surface faces most."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    facing = np.abs(np.cross(b - a, c - a)).sum(axis=0)
    along = int(np.argmax(facing))
    across = tuple(axis for axis in range(3) if axis != along)
    return (across[0], across[1]), ("xyz"[across[0]], "xyz"[across[1]])
