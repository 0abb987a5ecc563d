"""The mesh of a mold document: its shapes, what it will take, STL surfaces made coarser, refusals of the mesher."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import psutil

from hyperfab.arrays import Array
from hyperfab.documents.mold import FacesInBox, MoldDocument
from hyperfab.documents.mold_shapes import BodySection, PartSection, ShapeSection
from hyperfab.errors import InputError, NotConverged, placed
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.geometry import Body, Box, Cylinder, Ellipsoid, Geometry, Patch, Shape, Stl
from hyperfab.thermal.mesher import (
    NODES_PER_TETRAHEDRON,
    RawMesh,
    expected_bytes,
    expected_tetrahedra,
    make_mesh,
)
from hyperfab.thermal.remesh import as_given, laid_back, remesh_surface, standing_for
from hyperfab.thermal.repair import crossing


def geometry_of(document: MoldDocument, name: str, inputs: Inputs, stl_unit: str, questions: list[str]) -> Geometry:
    """Return parts, cavities and the face patches that conditions name; STL files are read here.

    Doubts about STL files are added to ``questions``.
    """
    reader = _Reader(name, inputs, stl_unit, questions)
    parts = tuple(reader.body(section) for section in document.part)
    cavities = tuple(reader.body(section) for section in document.cavity)
    patches = []
    for _, place in document.places():
        if isinstance(place, FacesInBox):
            patches.append(Patch(place.part, Box(place.box.origin, place.box.size)))
    return Geometry(parts, cavities, tuple(dict.fromkeys(patches)))


class _Reader:
    """Reads shapes; keeps what STL files need."""

    def __init__(self, name: str, inputs: Inputs, stl_unit: str, questions: list[str]) -> None:
        self.name = name
        self.inputs = inputs
        self.stl_unit = stl_unit
        self.questions = questions

    def body(self, section: BodySection) -> Body:
        """Return a part or cavity."""
        sections: list[ShapeSection] | list[BodySection] = section.shapes or [section]
        shapes = [found for shape in sections for found in self.shape(shape)]
        size = section.mesh_size if isinstance(section, PartSection) else None
        return Body(section.name, tuple(shapes), size)

    def shape(self, section: ShapeSection | BodySection) -> list[Shape]:
        """Return one shape, or the pieces of an STL."""
        name = section.name if isinstance(section, ShapeSection) else None
        if section.box is not None:
            return [Box(section.box.origin, section.box.size, name)]
        if section.cylinder is not None:
            c = section.cylinder
            semi_axes = c.semi_axes if c.semi_axes is not None else (c.radius or 0.0, c.radius or 0.0)
            return [Cylinder(c.origin, c.axis, c.length, semi_axes, name)]
        if section.ellipsoid is not None:
            e = section.ellipsoid
            return [Ellipsoid(e.centre, e.semi_axes, e.half, name)]
        if section.stl is None:
            raise InputError("has no shape", file=self.name)
        # 0.7 s to load: only surfaces need them, and the mesher can begin on shapes before.
        from hyperfab.chapters.molds import TURNED, read_mesh
        from hyperfab.thermal.repair import as_typed, pieces, repaired

        file = self.inputs.beside(self.name, section.stl)
        surface = read_mesh(self.inputs, file, section.unit or self.stl_unit, self.questions.append)
        origin = np.asarray(section.origin or (0.0, 0.0, 0.0))
        vertices = as_typed(surface.vertices)[:, TURNED[section.axis or "z"]] + origin
        found = repaired(vertices, surface.faces, file)
        self.questions.extend(f"{file}: {note}" for note in found.notes)
        return [Stl(*piece, name) for piece in pieces(found.vertices, found.triangles)]


#: Share of the machine's memory a run may take, and from where on the expectation is worth a line.
MEMORY_SHARE = 0.8
WORTH_SAYING = 1e9

#: STL surfaces of more facets are meshed anew before booleans: sewing them takes a millisecond a facet and more.
MANY_FACETS = 3000
#: The deviation from them that is small enough, as a share of mesh_size.
DEVIATION = 0.015

Waiting = Callable[[float], None]
Built = Callable[[Array], None]


def mesh_mold(
    geometry: Geometry, mesh_size: float, file: str, notes: list[str], waiting: Waiting, built: Built
) -> tuple[Geometry, RawMesh]:
    """Return the geometry that was meshed and its mesh; remarks are added to ``notes``.

    ``waiting`` and ``built`` are those of ``make_mesh``.

    Raises InputError naming the key of ``file`` where parts overlap, or the mesh would not fit into the machine.
    """
    _refuse_too_large(geometry, mesh_size, file, notes)
    try:
        with placed(file, "part"):
            coarser = _coarsened(geometry, mesh_size, notes, waiting)
            raw = make_mesh(
                coarser, mesh_size, waiting=waiting, built=lambda volumes: built(as_given(volumes, coarser))
            )
            return coarser, laid_back(replace(raw, volumes=as_given(raw.volumes, coarser)), coarser)
    except NotConverged:
        _refuse_crossing(geometry, file)
        raise


def _refuse_crossing(geometry: Geometry, file: str) -> None:
    """Say where an STL surface goes through itself, which may be why it was not meshed."""
    for kind, bodies in (("part", geometry.parts), ("cavity", geometry.cavities)):
        for number, body in enumerate(bodies):
            for shape in body.shapes:
                found = crossing(shape.vertices, shape.triangles) if isinstance(shape, Stl) else None
                if found is None:
                    continue
                x, y, z = found[1]
                raise InputError(
                    f"the STL surface of {body.name!r} goes through itself at ({x:.4g}, {y:.4g}, {z:.4g}) mm, "
                    "and could not be meshed",
                    file=file,
                    key=f"{kind}.{number}",
                    remedy="mend it there in the program that made it",
                )


def _refuse_too_large(geometry: Geometry, mesh_size: float, file: str, notes: list[str]) -> None:
    """Say what a mesh will take before it is made; refuse one that the machine cannot hold."""
    count = expected_tetrahedra(geometry, mesh_size)
    needed, there = expected_bytes(count), psutil.virtual_memory().total
    if needed > MEMORY_SHARE * there:
        fitting = mesh_size * (needed / (MEMORY_SHARE * there)) ** (1 / 3)
        raise InputError(
            f"makes up to {count:.2g} tetrahedra, which take about {needed / 1e9:.1f} GB; "
            f"this machine has {there / 1e9:.1f}",
            file=file,
            key="run.mesh_size",
            remedy=f'write mesh_size = "{fitting * 1.05:.2g} mm" or more',
        )
    if needed > WORTH_SAYING:
        nodes = NODES_PER_TETRAHEDRON * count
        notes.append(f"up to {nodes:.2g} unknowns and {needed / 1e9:.1f} GB of memory were expected")


def _coarsened(geometry: Geometry, size: float, notes: list[str], waiting: Waiting) -> Geometry:
    """Mesh STL surfaces of many facets anew: each facet would become a face of the solid."""

    def coarser(given: Stl) -> Stl:
        if len(given.triangles) <= MANY_FACETS:
            return given
        found = remesh_surface(given, size, DEVIATION * size, waiting=waiting)
        if found is None:
            return given
        notes.append(
            f"an STL surface of {len(given.triangles)} facets was meshed anew with "
            f"{len(found.surface.triangles)} curved ones; they deviate by {found.deviation:.2g} mm at most"
        )
        return found.surface

    return standing_for(geometry, coarser)
