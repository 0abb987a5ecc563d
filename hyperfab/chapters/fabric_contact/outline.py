"""The outline of the sheet from a file: a flat surface's edge, or a closed line; checked and centred."""

from __future__ import annotations

import os

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import read_mesh
from hyperfab.errors import InputError, UsageError, placed
from hyperfab.io.csv_table import read_table
from hyperfab.io.mesh_file import SUFFIXES, lonely, read_mesh_file
from hyperfab.io.units import column_factor
from hyperfab.membrane.outline import Polygon, crossing_sides, signed_area
from hyperfab.numerics.vectors import cross2

#: Heights within this part of the size count as one plane; points this close count as one.
_FLAT, _SAME = 1e-5, 1e-7
_MOST_POINTS = 20_000
_TABLES = (".csv", ".txt", ".tsv")


def is_file(shape: str) -> bool:
    """Whether ``--shape`` names a file: it has an ending."""
    return bool(os.path.splitext(shape)[1])


def read_outline(job: Job, name: str, unit: str, size: float | None) -> Polygon:
    """Read an outline from an STL surface, a mesh file, or a CSV table of x and y, its middle put at the origin.

    ``unit`` is that of the numbers where the file states none (STL, mesh files); with ``size`` [mm] the outline is
    scaled so that its longer side is this long. Raises InputError where it is not flat, not closed, not one loop, or
    crosses itself; UsageError for a kind of file that is not understood.
    """
    suffix = os.path.splitext(name)[1].lower()
    if suffix not in (*_TABLES, ".stl", *SUFFIXES):
        raise UsageError(f"--shape {name}: disc, square, or a file of STL, CSV (x, y) or {', '.join(SUFFIXES)}")
    with placed(name):
        if suffix in _TABLES:
            table = read_table(job.inputs.read(name), name, {"x": "length", "y": "length"})
            loop = np.column_stack([table["x"], table["y"]])
        elif suffix == ".stl":
            mesh = read_mesh(job.inputs, name, unit, job.console.warn)
            loop = _loop(_flat(mesh.vertices), lonely(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)))
        else:
            found = read_mesh_file(job.inputs.read(name), name)
            used = np.unique(found.edges)
            flat = np.zeros((len(found.points), 2))
            flat[used] = _flat(found.points[used] * float(column_factor(unit, "length")[0]))
            loop = _loop(flat, found.edges)
        outline = _checked(loop, size)
    return outline


def _flat(points: Array) -> Array:
    """Return the x and y of points that lie in a plane of equal z."""
    extent = np.ptp(points, axis=0)
    if extent[2] > _FLAT * extent.max():
        raise InputError(
            f"is not flat: z runs over {extent[2]:.4g} mm",
            remedy="a sheet in a plane of equal z is meant; cut it, or turn it so that z is its normal",
        )
    return points[:, :2]


def _loop(points: Array, edges: Ints) -> Array:
    """Join edges (k, 2) to one closed loop of points (k, 2)."""
    used, ends = np.unique(edges, return_inverse=True)
    meeting = np.bincount(ends.ravel(), minlength=len(used))
    if len(edges) == 0 or (meeting != 2).any():
        open_at = points[used[np.argmax(meeting != 2)]] if len(edges) else np.zeros(2)
        raise InputError(
            "has no closed edge: a surface without holes is closed all round"
            if not len(edges)
            else f"has an edge that is open or branches, at ({open_at[0]:.4g}, {open_at[1]:.4g}) mm",
            remedy="one flat surface with one closed edge, or one closed line, is meant",
        )
    order = np.argsort(ends.ravel(), kind="stable").reshape(-1, 2) // 2
    walked, edge, here = [], 0, int(ends[0, 0])
    while True:
        walked.append(here)
        here = int(ends[edge].sum() - here)
        edge = int(order[here].sum() - edge)
        if here == walked[0]:
            break
    if len(walked) < len(used):
        raise InputError(
            "has more than one closed edge: holes, or several sheets", remedy="one sheet without holes is meant"
        )
    return points[used[walked]]


def _checked(loop: Array, size: float | None) -> Polygon:
    """Return a simple loop, anticlockwise, its middle at the origin."""
    extent = float(np.ptp(loop, axis=0).max()) if len(loop) else 0.0
    away = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1)
    loop = loop[away > _SAME * extent]
    loop = loop[~_between(loop)] if len(loop) > 3 else loop
    crossing = crossing_sides(loop) if 3 < len(loop) <= _MOST_POINTS else None
    if crossing is None and (len(loop) < 3 or abs(signed_area(loop)) < _FLAT * extent**2):
        raise InputError("has no area", remedy="at least three points around the sheet are meant")
    if len(loop) > _MOST_POINTS:
        raise InputError(f"has {len(loop)} points around it, more than {_MOST_POINTS}", remedy="thin them out")
    if crossing is not None:
        at = loop[crossing[0]]
        raise InputError(
            f"crosses itself, near ({at[0]:.4g}, {at[1]:.4g}) mm",
            remedy="list the points in their order around the sheet",
        )
    if signed_area(loop) < 0.0:
        loop = loop[::-1]
    loop = loop - 0.5 * (loop.min(axis=0) + loop.max(axis=0))
    if size is not None:
        loop = loop * (size / extent)
    found = Polygon(np.ascontiguousarray(loop))
    if found.reach <= 0.0:
        raise InputError(
            "does not hold the place where the punch touches, the middle of its box",
            remedy="a sheet that covers its middle is meant",
        )
    return found


def _between(loop: Array) -> Flags:
    """Whether points lie straight between their neighbours: they say nothing of the outline."""
    back, on = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    level = np.abs(cross2(back, on)) <= 1e-9 * np.linalg.norm(back, axis=1) * np.linalg.norm(on, axis=1)
    return np.asarray(level & ((back * on).sum(axis=1) > 0.0))
