"""Molds: read from STL files and mended, for every command; those that a sheet is laid on are put under it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Ints
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.stl import SIZE_RANGE, SurfaceMesh, read_stl
from hyperfab.surface import Soundness, Surface, consistently_wound, inside_out
from hyperfab.surface.weld import unrounded

#: Which coordinates of a file become x, y and z where an axis of its own points up: turned, not mirrored.
TURNED = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}


#: A sheet is as wide as its mold or punch within this factor: an inch read as a millimetre is 25 times off, a cm 10.
_IN_PROPORTION = 8.0


@dataclass(frozen=True)
class PlacedMold:
    """A sound surface and where it stands: its own coordinates plus ``shift`` mm, the sheet's plane at z = 0 and its
    highest point ``depth`` mm above it; and ``aside``, how far its middle then is from the sheet's along x and y.
    """

    name: str
    surface: Surface
    closed: bool
    shift: tuple[float, float, float]
    depth: float
    aside: tuple[float, float] = (0.0, 0.0)

    def standing(self, depth: float) -> tuple[float, float, float]:
        """The shift at which its highest point is ``depth`` mm above the sheet's plane."""
        return self.shift[0] + self.aside[0], self.shift[1] + self.aside[1], self.shift[2] - self.depth + depth

    @property
    def touching(self) -> tuple[float, float, float]:
        """The shift at which its highest point touches the sheet's plane from below."""
        return self.standing(0.0)

    def larger(self, width: float, height: float) -> PlacedMold:
        """Return the mold larger by shares of itself across and along the way it is pushed, about its top's middle."""
        if not (width or height):
            return self
        middle = np.array([-self.shift[0], -self.shift[1], self.depth - self.shift[2]])
        vertices = middle + (self.surface.vertices - middle) * (1.0 + np.array([width, width, height]))
        return replace(self, surface=Surface(vertices, self.surface.faces))


def read_molds(job: Job, names: list[str], stl_unit: str, depth: float, axis: str = "z") -> PlacedMold:
    """Read the STL files, which share one frame, and centre them under the sheet.

    The highest point of all is put ``depth`` above the sheet's plane. ``axis`` of the files points up: their x, y, z
    are turned to y, z, x for x, to z, x, y for y. Facets wound the wrong way round are turned, with a warning. Raises
    InputError where a surface has holes the sheet could fall through.
    """
    bodies = [read_mold(job, name, stl_unit, axis) for name in names]
    bodies = [_outward(job, body) if not body.found.closed and _faces_down(body.surface) else body for body in bodies]
    low = np.min([body.surface.bounds[0, :3] for body in bodies], axis=0)
    high = np.max([body.surface.bounds[0, 3:] for body in bodies], axis=0)
    for body in bodies:
        _refuse_holes(body, float(high[2] - depth))
    offsets = np.cumsum([0, *(len(body.surface.vertices) for body in bodies)])
    surface = bodies[0].surface
    if len(bodies) > 1:
        surface = Surface(
            np.vstack([body.surface.vertices for body in bodies]),
            np.vstack([body.surface.faces + offset for body, offset in zip(bodies, offsets, strict=False)]),
        )
    shift = (float(-0.5 * (low[0] + high[0])), float(-0.5 * (low[1] + high[1])), float(depth - high[2]))
    return PlacedMold(", ".join(names), surface, all(body.found.closed for body in bodies), shift, depth)


def ask_unit(job: Job, name: str, surface: Surface, unit: str, beside: str, least: float, most: float) -> None:
    """Ask whether the unit is meant where the longest side [mm] is out of proportion to what is ``beside`` it."""
    sides = surface.bounds[0, 3:] - surface.bounds[0, :3]
    # Beyond SIZE_RANGE the reader has asked.
    if not least <= sides.max() <= most and SIZE_RANGE[0] <= sides.max() <= SIZE_RANGE[1]:
        shown = " x ".join(f"{side:.3g}" for side in sides)
        job.console.warn(
            f"{name}: measures {shown} mm when read in {unit}, {beside}; if that is not so, say --stl-unit (mm, cm, m, "
            "inch)"
        )


def ask_unit_by_sheet(job: Job, name: str, surface: Surface, unit: str, wide: float) -> None:
    """Ask the same of a mold or punch in a sheet that is so ``wide`` [mm]."""
    ask_unit(job, name, surface, unit, f"the sheet {wide:.4g} mm", wide / _IN_PROPORTION, wide * _IN_PROPORTION)


def read_mesh(inputs: Inputs, name: str, stl_unit: str, doubt: Callable[[str], None]) -> SurfaceMesh:
    """Read an STL file as it is; what is odd about it goes to ``doubt``."""
    mesh = read_stl(inputs.read(name), name, stl_unit)
    for question in mesh.questions:
        doubt(question)
    return mesh


@dataclass(frozen=True)
class MoldFile:
    """One file's surface, mended; ``facet`` numbers its faces as the file does."""

    name: str
    surface: Surface
    found: Soundness
    facet: Ints

    def turned(self, faces: Ints | None = None) -> MoldFile:
        """Return it with its other side outside, or that of some ``faces``."""
        which = np.arange(len(self.surface.faces)) if faces is None else faces
        wound = self.surface.faces.copy()
        wound[which] = wound[which][:, ::-1]
        surface = Surface(self.surface.vertices, wound)
        return MoldFile(self.name, surface, surface.soundness(), self.facet)


def read_mold(job: Job, name: str, stl_unit: str, axis: str = "z") -> MoldFile:
    """Read an STL file and mend it, saying what was mended.

    Corners that differ by rounding are one, facets without area or given twice go, neighbours are wound alike, a closed
    surface faces outward. ``axis`` of the file becomes z. Raises InputError where no facet has an area.
    """
    mesh = read_mesh(job.inputs, name, stl_unit, job.console.warn)
    vertices, faces, facet = mesh.vertices[:, TURNED[axis]], mesh.faces, mesh.facet_of_face
    if (one := unrounded(vertices, faces)) is not None:
        gone = len(faces) - len(one.faces)
        job.console.warn(
            f"{name}: corners that differ by rounding, closer than {one.distance:.2g} mm, were welded; none moved more "
            f"than {one.moved:.2g} mm" + (f"; {gone} facets without area or doubled were left out" if gone else "")
        )
        vertices, faces, facet = one.vertices, one.faces, facet[one.kept]
    surface = Surface(vertices, faces)
    found = surface.soundness()
    if len(found.degenerate_facets) or len(found.duplicate_facets):
        drop = np.union1d(found.degenerate_facets, found.duplicate_facets)
        keep = np.setdiff1d(np.arange(len(faces)), drop)
        if not len(keep):
            raise InputError("no facet has an area", file=name, remedy="export the surface again")
        job.console.warn(f"{name}: {len(drop)} facets without area or given twice were left out")
        faces, facet = faces[keep], facet[keep]
    wound, turned = consistently_wound(faces)
    if len(turned):
        first = facet[turned[0]] + 1
        job.console.warn(f"{name}: {len(turned)} facets faced the wrong way and were turned, facet {first} first")
    if len(turned) or len(wound) < len(surface.faces):
        surface = Surface(vertices, wound)
        found = surface.soundness()
    body = MoldFile(name, surface, found, facet)
    if not found.closed:
        return body
    body = _outward(job, body) if found.volume_mm3 < 0.0 else body
    if len(turned := inside_out(body.surface.vertices, body.surface.faces)):
        first = facet[turned[0]] + 1
        job.console.warn(
            f"{name}: {len(turned)} facets of whole pieces faced inward and were turned, facet {first} first"
        )
        body = body.turned(turned)
    return body


def _outward(job: Job, body: MoldFile) -> MoldFile:
    job.console.warn(f"{body.name}: all facets faced inward and were turned")
    return body.turned()


def _faces_down(surface: Surface) -> bool:
    """Does an open surface show its inside to the sheet above it?"""
    low, high = surface.bounds[0, :3], surface.bounds[0, 3:]
    x, y = np.meshgrid(*(np.linspace(low[k], high[k], 43)[1:-1] for k in (0, 1)))
    origins = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, high[2] + 1.0)])
    _, face = surface.ray(origins, [0.0, 0.0, -1.0])
    return bool(surface.normals[face[face >= 0], 2].sum() < 0.0)


def _refuse_holes(body: MoldFile, plane: float) -> None:
    """Refuse open or crowded edges that rise above the sheet's plane (z = ``plane`` in the mold's coordinates)."""
    surface, found = body.surface, body.found
    top = surface.vertices[surface.faces, 2].max(1)
    holes = [f for f in found.open_facets if top[f] > plane + 1e-9 and _open_above(surface, f, plane)]
    crowded = [f for f in found.crowded_facets if top[f] > plane + 1e-9]
    for what, above in (("an open edge (a hole)", holes), ("an edge of more than two facets", crowded)):
        if above:
            at = surface.vertices[surface.faces[above[0]]].mean(0)
            more = len(above) - 1
            others = f", and {more} more such facet{'s' if more > 1 else ''}" if more else ""
            raise InputError(
                f"has {what} above the plane of the sheet, near ({at[0]:.4g}, {at[1]:.4g}, {at[2]:.4g}) mm{others}",
                file=body.name,
                facet=int(body.facet[above[0]]) + 1,
                remedy="if this is the border of a patch of surface, extrude the border down, below the sheet's plane "
                "(there it may be open); if it is a hole, close it in the program it comes from",
            )


def _open_above(surface: Surface, face: int, plane: float) -> bool:
    for edge in np.flatnonzero(surface.twins[face] < 0):
        ends = surface.faces[face, [edge, (edge + 1) % 3]]
        if surface.vertices[ends, 2].max() > plane + 1e-9:
            return True
    return False
