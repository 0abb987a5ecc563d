"""From the shapes of a mold document to the shapes that are meshed."""

from __future__ import annotations

import numpy as np

from hyperfab.documents.mold import FacesInBox, MoldDocument
from hyperfab.documents.mold_shapes import BodySection, PartSection, ShapeSection
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.geometry import Body, Box, Cylinder, Ellipsoid, Geometry, Patch, Shape, Stl


def geometry_of(
    document: MoldDocument, name: str, inputs: Inputs, stl_unit: str, questions: list[str]
) -> Geometry:
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
        from hyperfab.thermal.repair import pieces, repaired

        file = self.inputs.beside(self.name, section.stl)
        surface = read_mesh(self.inputs, file, section.unit or self.stl_unit, self.questions.append)
        origin = np.asarray(section.origin or (0.0, 0.0, 0.0))
        found = repaired(surface.vertices[:, TURNED[section.axis or "z"]] + origin, surface.faces, file)
        self.questions.extend(f"{file}: {note}" for note in found.notes)
        return [Stl(*piece, name) for piece in pieces(found.vertices, found.triangles)]
