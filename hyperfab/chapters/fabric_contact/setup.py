"""What `hf fabric-contact` was asked for: options and material documents, checked."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.chapters.fabric_contact.fabric import Fabric
from hyperfab.chapters.fabric_contact.outline import is_file, read_outline
from hyperfab.chapters.fabric_contact.punch import check_punch, check_sphere, read_punch, symmetric
from hyperfab.chapters.job import Job
from hyperfab.errors import UsageError
from hyperfab.io.units import quantity
from hyperfab.membrane.contact import Frictionless, Tangential
from hyperfab.membrane.facets import Facets
from hyperfab.membrane.friction import Coulomb, Stick
from hyperfab.membrane.outline import Disc, Outline, Square
from hyperfab.membrane.polygon import Polygon
from hyperfab.membrane.sphere_test import SphereTest

#: Load steps where --steps is not given.
_STEPS = 8
_MOST_STEPS = 500
#: Beyond this a coefficient is a slip of the pen; stick is meant.
_MOST_FRICTION = 2.0
#: More is no clamp [mm per N/mm].
_MOST_SLIP = 1e4
_SHAPES = ("disc", "square")
_ORDERS = {"P1": 1, "P2": 2}
#: The sheet and the sphere where their options are not given.
_SIZE, _SPHERE = "200mm", "40mm"
#: Elements away from the contact, relative to half the size, where --mesh-size is not given.
_MESH = 0.08


@dataclass(frozen=True)
class Setup:
    """The geometry and the settings of the test, in mm.

    ``punch`` is pressed in place of a sphere; ``radius`` is the sphere's, or half the punch's width.
    """

    outline: Outline
    shape: str
    size: float
    thickness: float
    radius: float
    depths: list[float]
    prestretch: float
    mesh_size: float
    tolerance: float
    friction: Tangential
    order: int = 2
    rim_slip: float = 0.0
    punch: Facets | None = None
    punch_name: str | None = None

    @property
    def depth(self) -> float:
        """The depth asked for."""
        return self.depths[-1]

    def test(self, fabric: Fabric) -> SphereTest:
        """Return the test of one fabric."""
        return SphereTest(
            self.outline,
            fabric.law,
            self.thickness,
            self.radius,
            self.prestretch,
            self.mesh_size,
            order=self.order,
            friction=self.friction,
            rim_slip=self.rim_slip,
            facets=self.punch,
        )


def read_setup(
    job: Job,
    fabric: Fabric,
    *,
    shape: str,
    size: str | None,
    thickness: str | None,
    sphere_radius: str | None,
    punch: str | None,
    depth: str,
    prestretch: float,
    rim_slip: str | None,
    friction: str | None,
    steps: int | None,
    mesh_size: str | None,
    element: str,
    tolerance: float,
    stl_unit: str,
) -> Setup:
    """Check the options and read what they name; UsageError or InputError say what cannot be meant."""
    deep = _length(depth, "--depth")
    _check_numbers(prestretch, steps, tolerance)
    order = _ORDERS.get(element.upper())
    if order is None:
        raise UsageError(f"--element {element}: P1 (straight, constant strain) or P2 (curved)")
    if punch is not None and sphere_radius is not None:
        raise UsageError("--punch and --sphere-radius: one or the other is pushed in")
    outline, width, narrow = _outline(job, shape, size, stl_unit)
    _within(deep, 1e-3 * width, 2.0 * width, f"--depth {depth}")
    if punch is None:
        given = sphere_radius or _SPHERE
        facets, radius = None, _length(given, "--sphere-radius")
        _within(radius, 5e-3 * width, 20.0 * width, f"--sphere-radius {given}")
        check_sphere(outline.reach * prestretch, radius, deep)
    else:
        facets = read_punch(job, punch, stl_unit, deep)
        whole = replace(outline, quarter=False)
        check_punch(facets, whole, prestretch, deep, punch)
        radius = 0.5 * float(np.ptp(facets.above(deep)[:, :2], axis=0).min())
        if not symmetric(facets, deep):
            outline = whole
    mesh = _MESH * narrow / 2 if mesh_size is None else _length(mesh_size, "--mesh-size")
    if not narrow / 400 <= mesh <= narrow / 6:
        raise UsageError(
            f"--mesh-size {mesh_size}: between {narrow / 400:.3g}mm and {narrow / 6:.3g}mm for this sheet"
        )
    depths = [float(part) for part in np.linspace(0.0, deep, (steps or _STEPS) + 1)[1:]]
    return Setup(
        outline,
        shape if not is_file(shape) else os.path.basename(shape),
        width,
        _length(thickness, "--thickness") if thickness is not None else fabric.thickness or 1.0,
        radius,
        depths,
        prestretch,
        mesh,
        tolerance,
        _friction(friction),
        order,
        _rim_slip(rim_slip),
        facets,
        None if punch is None else os.path.basename(punch),
    )


def _outline(
    job: Job, shape: str, size: str | None, stl_unit: str
) -> tuple[Disc | Square | Polygon, float, float]:
    """Return the outline, a quarter where it is symmetric, and the longer and the shorter side of its box."""
    if shape not in _SHAPES and is_file(shape):
        polygon = read_outline(job, shape, stl_unit, None if size is None else _length(size, "--size"))
        sides = np.ptp(polygon.vertices, axis=0)
        width, narrow = float(sides.max()), float(sides.min())
        _within(width, 1.0, 10_000.0, f"--shape {shape}: longer side {width:g}mm")
        quarter = polygon.convex and polygon.symmetric
        return replace(polygon, quarter=quarter), width, narrow
    given = size or _SIZE
    width = _length(given, "--size")
    _within(width, 1.0, 10_000.0, f"--size {given}")
    if shape not in _SHAPES:
        raise UsageError(f"--shape {shape}: choose disc or square, or name a file with the outline")
    disc = shape == "disc"
    return (Disc(width / 2, quarter=True) if disc else Square(width, quarter=True)), width, width


def _check_numbers(prestretch: float, steps: int | None, tolerance: float) -> None:
    if not (0.5 <= prestretch <= 5.0):
        raise UsageError(
            f"--prestretch {prestretch:g}: a stretch ratio between 0.5 and 5 is meant, 1.05 for 5 %"
        )
    if steps is not None and not 1 <= steps <= _MOST_STEPS:
        raise UsageError(f"--steps {steps}: between 1 and {_MOST_STEPS} load steps")
    if not 1e-7 <= tolerance <= 0.1:
        raise UsageError(f"--tolerance {tolerance:g}: the relative error of the force, between 1e-7 and 0.1")


def _rim_slip(text: str | None) -> float:
    value = 0.0 if text is None else quantity(text, "compliance", option="--rim-slip")
    if not 0.0 <= value <= _MOST_SLIP:
        raise UsageError(
            f"--rim-slip {text}: from 0 to {_MOST_SLIP:g} mm^2/N (mm of slip per N/mm of tension)"
        )
    return value


def _length(text: str, option: str) -> float:
    value = quantity(text, "length", option=option)
    if not value > 0.0:
        raise UsageError(f"{option} {text}: must be more than 0mm")
    return value


def _friction(text: str | None) -> Tangential:
    if text is None:
        return Frictionless()
    if text == "stick":
        return Stick()
    coefficient = (
        quantity(text, "dimensionless", option="--friction") if text[:1] in "+-.0123456789" else math.nan
    )
    if not 0.0 <= coefficient <= _MOST_FRICTION:
        raise UsageError(f"--friction {text}: a coefficient from 0 to {_MOST_FRICTION:g}, as 0.3, or stick")
    return Coulomb(coefficient) if coefficient > 0.0 else Frictionless()


def _within(value: float, least: float, most: float, shown: str) -> None:
    """Refuse what cannot be meant with this sheet."""
    if not least <= value <= most:
        raise UsageError(f"{shown}: between {least:g}mm and {most:g}mm for this sheet; check the unit")
