"""The punch of `hf fabric-contact`: a sphere, or an STL surface in its place."""

from __future__ import annotations

import math

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import read_molds
from hyperfab.errors import InputError, UsageError
from hyperfab.membrane.facets import Facets
from hyperfab.membrane.outline import Outline


def read_punch(job: Job, name: str, stl_unit: str, depth: float) -> Facets:
    """Read an STL surface and put it under the sheet: its middle on the axis, its highest point at z = 0.

    Raises InputError where the surface has holes above the sheet's plane, or no height that could be pushed in.
    """
    placed = read_molds(job, [name], stl_unit, depth)
    shift = np.asarray(placed.shift) - np.array([0.0, 0.0, depth])
    punch = Facets(placed.surface, shift)
    width = np.ptp(punch.above(depth)[:, :2], axis=0)
    if width.min() <= 0.0:
        raise InputError(
            "is flat: nothing of it can be pushed into the sheet",
            file=name,
            remedy="a surface with a height along z is meant",
        )
    return punch


def check_sphere(reach: float, radius: float, depth: float) -> None:
    """Refuse a sphere that strikes the clamp, a hard ring in the plane of the flat sheet ``reach`` mm from the axis."""
    if reach >= radius:
        return
    most = radius - math.sqrt(radius**2 - reach**2)
    if depth > most:
        raise UsageError(
            f"--depth {depth:g}mm: the sphere would strike the clamp at {most:.4g}mm; "
            "choose a smaller sphere or depth, or a larger sheet"
        )


def check_punch(punch: Facets, outline: Outline, prestretch: float, depth: float, name: str) -> None:
    """Refuse a punch that strikes the clamp on its way in; InputError says at what depth and where."""
    # A corner z above the plane at full depth reached it at depth - z.
    above = punch.above(depth)
    out = ~outline.inside(above[:, :2] / prestretch)
    if not out.any():
        return
    first = above[out][np.argmax(above[out, 2])]
    raise InputError(
        f"is too large for the sheet: pushed in by {depth:g} mm it would strike the clamp at "
        f"{depth - first[2]:.4g} mm, at ({first[0]:.4g}, {first[1]:.4g}) mm from the sheet's middle",
        file=name,
        remedy="choose a smaller --depth or punch, or a larger sheet",
    )


def symmetric(punch: Facets, depth: float) -> bool:
    """Whether what rises above the sheet's plane is its own mirror image in x and in y."""
    surface = punch.surface
    corners = surface.vertices[surface.faces] + punch.shift + np.array([0.0, 0.0, depth])
    risen = corners[corners[:, :, 2].max(axis=1) > 0.0]
    seen = np.concatenate(
        [risen.reshape(-1, 3), risen.mean(axis=1), 0.5 * (risen + np.roll(risen, 1, axis=1)).reshape(-1, 3)]
    )
    seen = seen[seen[:, 2] > 0.0]
    limit = _MIRRORED * punch.size
    return all(
        bool(np.abs(punch.near(seen * mirror, depth).gap).max(initial=0.0) <= limit)
        for mirror in (np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0]))
    )


#: Mirrored points lie on the surface to this part of its size: what single precision in an STL file leaves.
_MIRRORED = 1e-6
