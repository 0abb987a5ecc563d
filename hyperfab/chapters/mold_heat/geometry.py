"""From the shapes of a mold document to the shapes that are meshed, and an earlier field put on them."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.field import read_field
from hyperfab.chapters.molds import TURNED, read_mesh
from hyperfab.documents.base import read_document
from hyperfab.documents.heat import HeatDocument
from hyperfab.documents.mold import FacesInBox, MoldDocument
from hyperfab.documents.mold_shapes import BodySection, PartSection, ShapeSection
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import Grid
from hyperfab.thermal.geometry import Body, Box, Cylinder, Ellipsoid, Geometry, Patch, Shape, Stl
from hyperfab.thermal.locate import Locator
from hyperfab.thermal.mesh import HeatMesh
from hyperfab.thermal.repair import pieces, repaired


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
        file = self.inputs.beside(self.name, section.stl)
        surface = read_mesh(self.inputs, file, section.unit or self.stl_unit, self.questions.append)
        origin = np.asarray(section.origin or (0.0, 0.0, 0.0))
        found = repaired(surface.vertices[:, TURNED[section.axis or "z"]] + origin, surface.faces, file)
        self.questions.extend(f"{file}: {note}" for note in found.notes)
        return [Stl(*piece, name) for piece in pieces(found.vertices, found.triangles)]


#: A node further than this many elements outside the earlier mold has no temperature there.
BEYOND = 1.5


def earlier_field(inputs: Inputs, mold: str, relative: str) -> Grid:
    """Read the last field of the heat document that ``mold`` names; InputError where there is none."""
    name = inputs.beside(mold, relative)
    return read_field(inputs, name, read_document(inputs, name, HeatDocument), "tetra10", "temperature_degC")


def start_from(grid: Grid, mesh: HeatMesh, mold: str) -> Array:
    """Return an earlier field (points in mm) at the nodes of ``mesh``: part by part where the parts agree.

    Raises InputError where a node lies outside the earlier mold.
    """
    temperature = grid.point_data["temperature_degC"].astype(np.float64)
    points, elements = grid.points / 1e3, grid.cells["tetra10"]
    parts = np.asarray(grid.cell_data.get("part", np.zeros(len(elements))), dtype=np.int64)
    same = len(points) == mesh.solid and np.array_equal(elements, mesh.elements)
    if same and np.allclose(points, mesh.points[: mesh.solid], atol=1e-9):
        return temperature
    together = parts.max() != mesh.parts.max()
    result = np.full(mesh.solid, np.nan)
    for part in range(int(mesh.parts.max()) + 1):
        theirs = np.ones(len(elements), dtype=bool) if together else parts == part
        mine = np.unique(mesh.elements[mesh.parts == part])
        nodes, weights, outside = Locator(points, elements[theirs]).find(mesh.points[mine])
        if outside.max() > BEYOND:
            x, y, z = 1e3 * mesh.points[mine[int(np.argmax(outside))]]
            raise InputError(
                f"the earlier mold has nothing at ({x:.1f}, {y:.1f}, {z:.1f}) mm",
                file=mold,
                key="run.start",
                remedy="start from a run of the same mold",
            )
        result[mine] = np.einsum("pi,pi->p", weights, temperature[nodes])
    return result
