"""Turnable views: the outside of a grid and the fields on it, of fewer triangles where there are too many, packed."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.io.vtu_read import Grid, field_among, read_vtu
from hyperfab.report.page.parts import Scene, Source, rounded

#: A view of more triangles than this turns slowly on a phone, and weighs on the page.
MAX_TRIANGLES = 24_000

# Corners of the faces of a tetrahedron.
_FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@dataclass(frozen=True)
class Surface:
    """Triangles to show: ``points`` (n, 3) [mm], ``triangles`` (m, 3), ``origin`` (n,) the grid's node of each point.

    ``cells`` (m,) is the grid's cell of each triangle. ``moved_mm`` is how far thinning out moved a point at most
    (0: every point is where the grid has it).
    """

    points: Array
    triangles: Ints
    origin: Ints
    cells: Ints
    moved_mm: float = 0.0
    whole: int = 0


def outside(grid: Grid) -> Surface:
    """Return the triangles of a grid of triangles, quads or tetrahedra (of these the outer faces)."""
    triangles, cells, start = [], [], 0
    for kind, nodes in grid.cells.items():
        own = np.arange(start, start + len(nodes))
        start += len(nodes)
        if kind == "triangle6":
            for part in ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]):
                triangles.append(nodes[:, part])
                cells.append(own)
        elif kind == "triangle":
            triangles.append(nodes)
            cells.append(own)
        elif kind == "quad":
            triangles += [nodes[:, [0, 1, 2]], nodes[:, [0, 2, 3]]]
            cells += [own, own]
        elif kind in ("tetra", "tetra10"):
            faces = nodes[:, :4][:, _FACES].reshape(-1, 3)
            _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
            outer = np.sort(first[count == 1])
            triangles.append(faces[outer])
            cells.append(own[outer // 4])
    if not triangles:
        raise ValueError("the grid has no surface to show")
    faces = np.concatenate(triangles)
    used, compact = np.unique(faces, return_inverse=True)
    return Surface(grid.points[used], compact, used, np.concatenate(cells), whole=len(faces))


def thinned(surface: Surface, most: int = MAX_TRIANGLES) -> Surface:
    """Return a surface of at most ``most`` triangles: points that share a cube of space become one of them.

    It is the one nearest to their mean: every point that stays has the field's own values on it.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> flat = Surface(corners, np.array([[0, 1, 2]]), np.arange(3), np.zeros(1, int))
    >>> thinned(flat) is flat
    True
    """
    if len(surface.triangles) <= most:
        return surface
    size = float(np.ptp(surface.points, axis=0).max()) * (1.0 / np.sqrt(most))
    while True:
        thin = _clustered(surface, size)
        if len(thin.triangles) <= most:
            return thin
        size *= 1.15


def _clustered(surface: Surface, size: float) -> Surface:
    places = np.floor((surface.points - surface.points.min(axis=0)) / size).astype(np.int64)
    _, cluster = np.unique(places, axis=0, return_inverse=True)
    cluster = cluster.ravel()
    count = np.bincount(cluster)
    mean = np.stack([np.bincount(cluster, surface.points[:, axis]) / count for axis in range(3)], axis=1)
    distance = np.linalg.norm(surface.points - mean[cluster], axis=1)
    order = np.lexsort((distance, cluster))
    keep = order[np.r_[True, np.diff(cluster[order]) > 0]]
    moved = float(np.linalg.norm(surface.points - surface.points[keep][cluster], axis=1).max())
    triangles = cluster[surface.triangles]
    real = (
        (triangles[:, 0] != triangles[:, 1])
        & (triangles[:, 1] != triangles[:, 2])
        & (triangles[:, 2] != triangles[:, 0])
    )
    _, first = np.unique(np.sort(triangles[real], axis=1), axis=0, return_index=True)
    chosen = np.flatnonzero(real)[np.sort(first)]
    return Surface(
        surface.points[keep],
        triangles[chosen],
        surface.origin[keep],
        surface.cells[chosen],
        moved,
        surface.whole,
    )


#: Steps that a range is divided into on the page: two bytes a number.
STEPS = 65535


#: Colours from the least to the greatest value; each set is told apart in grey too.
COLOURS: dict[str, list[tuple[float, str]]] = {
    "Viridis": [(0.0, "#440154"), (0.13, "#482878"), (0.25, "#3e4989"), (0.38, "#31688e"), (0.5, "#26828e"),
                (0.63, "#35b779"), (0.75, "#6ece58"), (0.88, "#b5de2b"), (1.0, "#fde725")],
    "Cividis": [(0.0, "#00224e"), (0.25, "#434e6c"), (0.5, "#7d7c78"), (0.75, "#bcae6c"), (1.0, "#fee838")],
    "marks": [(0.0, "#dfe3e8"), (1.0, "#0b3d91")],
    "heat": [(0.0, "#1b0c41"), (0.25, "#781c6d"), (0.5, "#cf4446"), (0.75, "#fb9a06"), (1.0, "#fcffa4")],
}  # fmt: skip


@dataclass(frozen=True)
class Field:
    """A field to colour a surface by: the array of the grid, what people call it, its unit, and its colours."""

    array: str
    title: str
    unit: str = ""
    colours: str = "Viridis"
    #: Ends of the scale where they do not depend on the values, and what they stand for.
    ends: tuple[float, float] | None = None
    words: tuple[str, str] | None = None


def views(source: Source, caption: str, alt: str, fields: Sequence[Field]) -> list[Scene]:
    """Return the view of the field that lies beside a document; none where it is gone, or has none of ``fields``."""
    name = field_among(source.data.get("files", []))
    data = None if name is None else source.sibling(name)
    view = None if data is None else scene(caption, alt, read_vtu(data, str(name)), fields)
    return [] if view is None else [view]


def scene(caption: str, alt: str, grid: Grid, fields: Sequence[Field]) -> Scene | None:
    """Return a view of the outside of ``grid`` with those of ``fields`` that it has; None where it has none."""
    surface = thinned(outside(grid))
    packed = [_field(grid, surface, field) for field in fields if _has(grid, field)]
    if not packed:
        return None
    mesh = {
        **{axis: _packed(surface.points[:, index]) for index, axis in enumerate("xyz")},
        **{corner: _whole_numbers(surface.triangles[:, index]) for index, corner in enumerate("ijk")},
    }
    return Scene(f"{caption}{_loss(surface)}", alt, mesh, packed)


def _has(grid: Grid, field: Field) -> bool:
    values = grid.point_data.get(field.array, grid.cell_data.get(field.array))
    return values is not None and values.ndim == 1


def _field(grid: Grid, surface: Surface, field: Field) -> dict[str, Any]:
    at_points = field.array in grid.point_data
    values = grid.point_data[field.array][surface.origin] if at_points else grid.cell_data[field.array][surface.cells]
    values = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(values)
    low, high = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 1.0)
    if field.ends is not None:
        low, high = field.ends
    return {
        "name": field.array,
        "title": field.title,
        "unit": field.unit,
        "mode": "vertex" if at_points else "cell",
        "values": _packed(np.where(finite, values, low)),
        "low": low,
        "high": high if high > low else low + 1.0,
        "colours": COLOURS[field.colours] if field.words is None else _two(COLOURS[field.colours]),
        "words": field.words,
    }


def _two(stops: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Return two colours without any between: what is, is or is not."""
    low, high = stops[0][1], stops[-1][1]
    return [(0.0, low), (0.5, low), (0.5, high), (1.0, high)]


def _loss(surface: Surface) -> str:
    if surface.moved_mm == 0.0:
        return ""
    return (
        f" Thinned out for the page: {rounded(len(surface.triangles))} of {rounded(surface.whole)} triangles are "
        f"shown, points moved by up to {rounded(surface.moved_mm, 2)} mm; values at the points kept are the field's."
    )


def _packed(values: NDArray) -> dict[str, Any]:
    """Pack numbers as whole steps between the least and the greatest."""
    low = float(values.min())
    width = float(values.max()) - low
    steps = np.rint((values - low) * (STEPS / width)) if width > 0.0 else np.zeros(len(values))
    return {**_whole_numbers(steps), "low": low, "step": width / STEPS}


def _whole_numbers(values: NDArray) -> dict[str, Any]:
    """Pack whole numbers, in two bytes each where they fit, deflated."""
    kind = "u2" if values.max() <= STEPS else "u4"
    data = zlib.compress(np.ascontiguousarray(values, dtype=np.dtype(f"<{kind}")).tobytes(), 9)
    return {"dtype": kind, "deflated": base64.b64encode(data).decode("ascii")}
