"""The test that a case of `hf fabric-contact` and its files describe."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.cases.contact import SHAPES, STICK, ContactCase
from hyperfab.chapters.fabric_contact.outline import is_file, read_outline
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import ask_unit_by_sheet, read_molds
from hyperfab.chapters.sheet import Fabric
from hyperfab.errors import InputError, UsageError
from hyperfab.membrane.contact import Coulomb, Frictionless, Stick, Tangential
from hyperfab.membrane.outline import Disc, Outline, Polygon, Square
from hyperfab.membrane.punch import Facets
from hyperfab.membrane.sphere_contact import SphereTest

_ORDERS = {"P1": 1, "P2": 2}
#: The sheet and the sphere [mm] where their options are not given.
_SIZE, SPHERE = 200.0, 40.0
#: Elements away from the contact, relative to half the size, where --mesh-size is not given.
_MESH = 0.08


@dataclass(frozen=True)
class Geometry:
    """What the files of a case hold besides the fabrics: the outline with the longer and the shorter side of its box,
    and the punch."""

    outline: Disc | Square | Polygon
    width: float
    narrow: float
    facets: Facets | None


@dataclass(frozen=True)
class Setup:
    """The test that a ``case`` and its ``geometry`` describe, with what the case leaves open [mm].

    ``outline`` is what is meshed, a quarter where all is symmetric; ``radius`` is the sphere's, or half the punch's
    width.
    """

    case: ContactCase
    geometry: Geometry
    outline: Outline
    thickness: float
    radius: float
    mesh_size: float

    @property
    def depths(self) -> list[float]:
        """The depths [mm] shown; the last is the one asked for."""
        return [float(part) for part in np.linspace(0.0, self.case.depth, self.case.steps + 1)[1:]]

    @property
    def friction(self) -> Tangential:
        """The law of friction."""
        given = self.case.friction
        if given == STICK:
            return Stick()
        return Coulomb(float(given)) if given else Frictionless()

    @property
    def lift(self) -> float:
        """How far [mm] off the sphere the sheet's middle surface is held."""
        return 0.5 * self.thickness if self.case.middle_surface else 0.0

    def test(self, fabric: Fabric) -> SphereTest:
        """Return the test of one fabric."""
        return SphereTest(
            self.outline,
            fabric.law,
            self.thickness,
            self.radius + self.lift,
            self.case.prestretch,
            self.mesh_size,
            order=_ORDERS[self.case.element],
            friction=self.friction,
            rim_slip=self.case.rim_slip,
            frame=self.case.yields,
            facets=self.punch,
        )

    @property
    def punch(self) -> Facets | None:
        """The punch with its edges as rounded as the case asks."""
        facets = self.geometry.facets
        return None if facets is None else replace(facets, edge_radius=self.case.edge_radius or 0.0)


def read_geometry(job: Job, case: ContactCase) -> Geometry:
    """Read what the case names besides material documents; a quarter of the outline where it is symmetric."""
    if case.shape not in SHAPES and is_file(case.shape):
        polygon = read_outline(job, case.shape, case.stl_unit, case.size)
        sides = np.ptp(polygon.vertices, axis=0)
        width, narrow = float(sides.max()), float(sides.min())
        _within(width, 1.0, 10_000.0, f"--shape {case.shape}: longer side {width:g}mm")
        outline: Disc | Square | Polygon = replace(polygon, quarter=polygon.convex and polygon.symmetric)
    else:
        width = narrow = case.size or _SIZE
        _within(width, 1.0, 10_000.0, f"--size {width:g}mm")
        if case.shape not in SHAPES:
            raise UsageError(f"--shape {case.shape}: choose disc or square, or name a file with the outline")
        outline = Disc(width / 2, quarter=True) if case.shape == "disc" else Square(width, quarter=True)
    _within(case.depth, 1e-3 * width, 2.0 * width, f"--depth {case.depth:g}mm")
    facets = None if case.punch is None else read_punch(job, case.punch, case.stl_unit, case.depth)
    if case.punch is not None and facets is not None:
        ask_unit_by_sheet(job, case.punch, facets.surface, case.stl_unit, width)
    return Geometry(outline, width, narrow, facets)


def setup_of(case: ContactCase, geometry: Geometry, fabric: Fabric) -> Setup:
    """Return the test that a case describes; UsageError or InputError say what cannot be meant."""
    outline, width, narrow = geometry.outline, geometry.width, geometry.narrow
    thickness = case.thickness or fabric.thickness or 1.0
    if case.punch is None or geometry.facets is None:
        radius = case.sphere_radius or SPHERE
        _within(radius, 5e-3 * width, 20.0 * width, f"--sphere-radius {radius:g}mm")
        check_sphere(outline.reach * case.prestretch, radius, case.depth)
    else:
        whole = replace(outline, quarter=False)
        check_punch(geometry.facets, whole, case.prestretch, case.depth, case.punch)
        radius = 0.5 * float(np.ptp(geometry.facets.above(case.depth)[:, :2], axis=0).min())
        if case.edge_radius is not None:
            _within(case.edge_radius, 0.01 * radius, 0.5 * radius, f"--edge-radius {case.edge_radius:g}mm")
        if not geometry.facets.is_mirrored(case.depth):
            outline = whole
    mesh = case.mesh_size or _MESH * narrow / 2
    if not narrow / 400 <= mesh <= narrow / 6:
        raise UsageError(f"--mesh-size {mesh:g}mm: between {narrow / 400:.3g}mm and {narrow / 6:.3g}mm for this sheet")
    return Setup(case, geometry, outline, thickness, radius, mesh)


def _within(value: float, least: float, most: float, shown: str) -> None:
    """Refuse what cannot be meant with this sheet."""
    if not least <= value <= most:
        raise UsageError(f"{shown}: between {least:g}mm and {most:g}mm for this sheet; check the unit")


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
