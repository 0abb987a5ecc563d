"""The mold of ``hf drape``: read, mended or refused, and put under the sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.stl import read_stl
from hyperfab.surface import Soundness, Surface, consistently_wound


@dataclass(frozen=True)
class PlacedMold:
    """A sound surface and where it stands: its own coordinates plus ``shift`` mm, the sheet's plane at z = 0."""

    name: str
    surface: Surface
    soundness: Soundness
    shift: tuple[float, float, float]


def read_mold(job: Job, name: str, stl_unit: str, depth: float) -> PlacedMold:
    """Read an STL and centre it under the sheet, its highest point ``depth`` above the sheet's plane.

    Facets wound the wrong way round are turned, with a warning. Raises InputError where the surface has holes the
    sheet could fall through.
    """
    mesh = read_stl(job.inputs.read(name), name, stl_unit)
    for question in mesh.questions:
        job.console.warn(question)
    vertices, faces, facet = mesh.vertices, mesh.faces, mesh.facet_of_face
    found = Surface(vertices, faces).soundness()
    if len(found.degenerate_facets) or len(found.duplicate_facets):
        drop = np.union1d(found.degenerate_facets, found.duplicate_facets)
        keep = np.setdiff1d(np.arange(len(faces)), drop)
        if not len(keep):
            raise InputError("no facet has an area", file=name, remedy="export the surface again")
        job.console.warn(f"{name}: {len(drop)} facets without area or given twice were left out")
        faces, facet = faces[keep], facet[keep]
    faces, turned = consistently_wound(vertices, faces)
    if len(turned):
        job.console.warn(
            f"{name}: {len(turned)} facets faced the wrong way and were turned, facet {facet[turned[0]] + 1} first"
        )
    surface = Surface(vertices, faces)
    found = surface.soundness()
    if _inside_out(surface, found):
        job.console.warn(f"{name}: all facets faced inward and were turned")
        surface = Surface(vertices, faces[:, ::-1])
        found = surface.soundness()
    low, high = surface.bounds[0, :3], surface.bounds[0, 3:]
    shift = (-0.5 * (low[0] + high[0]), -0.5 * (low[1] + high[1]), depth - high[2])
    _refuse_holes(surface, found, facet, name, float(high[2] - depth))
    return PlacedMold(name, surface, found, (float(shift[0]), float(shift[1]), float(shift[2])))


def _inside_out(surface: Surface, found: Soundness) -> bool:
    """Does the surface face inward? By its volume where closed, else by what is seen from above."""
    if found.closed:
        return found.volume_mm3 < 0.0
    low, high = surface.bounds[0, :3], surface.bounds[0, 3:]
    x, y = np.meshgrid(*(np.linspace(low[k], high[k], 43)[1:-1] for k in (0, 1)))
    origins = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, high[2] + 1.0)])
    _, face = surface.ray(origins, [0.0, 0.0, -1.0])
    return bool(surface.normals[face[face >= 0], 2].sum() < 0.0)


def _refuse_holes(surface: Surface, found: Soundness, facet: np.ndarray, name: str, plane: float) -> None:
    """Refuse open or crowded edges that rise above the sheet's plane (z = ``plane`` in the mold's coordinates)."""
    for what, faces in (
        ("an open edge (a hole)", found.open_facets),
        ("an edge of more than two facets", found.crowded_facets),
    ):
        above = [f for f in faces if surface.vertices[surface.faces[f], 2].max() > plane + 1e-9]
        if what.startswith("an open"):
            above = [f for f in above if _open_above(surface, f, plane)]
        if above:
            at = surface.vertices[surface.faces[above[0]]].mean(0)
            raise InputError(
                f"has {what} above the plane of the sheet, near ({at[0]:.4g}, {at[1]:.4g}, {at[2]:.4g}) mm, and "
                f"{len(above) - 1} more such facets",
                file=name,
                facet=int(facet[above[0]]) + 1,
                remedy="close the surface in the program it comes from; below the sheet's plane it may be open",
            )


def _open_above(surface: Surface, face: int, plane: float) -> bool:
    for edge in np.flatnonzero(surface.twins[face] < 0):
        ends = surface.faces[face, [edge, (edge + 1) % 3]]
        if surface.vertices[ends, 2].max() > plane + 1e-9:
            return True
    return False
