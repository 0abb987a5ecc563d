"""``mold.toml``: the shapes of parts and bodies, from boxes, cylinders and STL files."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from hyperfab.documents.base import Section
from hyperfab.documents.quantity import Length, PositiveLength, Temperature

Way = Literal["x-", "x+", "y-", "y+", "z-", "z+"]
Point = tuple[Length, Length, Length]


class BoxSection(Section):
    """A box: its corner with the least coordinates, and its edges."""

    origin: Point
    size: tuple[PositiveLength, PositiveLength, PositiveLength]


class CylinderSection(Section):
    """A cylinder from the middle of its first end along an axis; ``semi_axes`` make it elliptic.

    ``semi_axes`` are along x and y for axis z, y and z for axis x, z and x for axis y.
    """

    origin: Point
    axis: Literal["x", "y", "z"]
    length: PositiveLength
    radius: PositiveLength | None = None
    semi_axes: tuple[PositiveLength, PositiveLength] | None = None

    @model_validator(mode="after")
    def _one_section(self) -> CylinderSection:
        if (self.radius is None) == (self.semi_axes is None):
            raise ValueError("a cylinder has either radius or semi_axes")
        return self


class EllipsoidSection(Section):
    """An ellipsoid, or the half of it on one side of its centre."""

    centre: Point
    semi_axes: tuple[PositiveLength, PositiveLength, PositiveLength]
    half: Way | None = None


class OneShape(Section):
    """A shape; a surface (``stl``) may be placed.

    ``origin`` is where the origin of the STL's own coordinates comes to stand, ``axis`` the one of its axes that points
    up along z, turned and not mirrored, ``unit`` that of its numbers.
    """

    box: BoxSection | None = None
    cylinder: CylinderSection | None = None
    ellipsoid: EllipsoidSection | None = None
    stl: str | None = None
    origin: Point | None = None
    axis: Literal["x", "y", "z"] | None = None
    unit: Literal["mm", "cm", "m", "in", "inch"] | None = None

    @field_validator("stl", mode="before")
    @classmethod
    def _name_of_a_file(cls, value: object) -> object:
        if isinstance(value, dict):
            raise ValueError(
                'stl is the name of a file, its place stands beside it: stl = "cup.stl", '
                'origin = ["0 mm", "0 mm", "40 mm"], axis = "z", unit = "mm"'
            )
        return value

    @model_validator(mode="after")
    def _placed(self) -> OneShape:
        if self.stl is None:
            for key in ("origin", "axis", "unit"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key} here places an stl; a box, cylinder or ellipsoid has its own")
        return self


class ShapeSection(OneShape):
    """One shape, with a name where its faces are wanted."""

    name: str | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> ShapeSection:
        if sum(s is not None for s in (self.box, self.cylinder, self.ellipsoid, self.stl)) != 1:
            raise ValueError("a shape is one of box, cylinder, ellipsoid, stl")
        return self


class BodySection(OneShape):
    """A part or cavity: one shape, or ``shapes``, their union."""

    name: Annotated[str, Field(min_length=1)]
    shapes: Annotated[list[ShapeSection], Field(min_length=1)] | None = None

    @field_validator("name")
    @classmethod
    def _plain_name(cls, value: str) -> str:
        if "." in value:
            raise ValueError("a name has no dot in it: NAME.z+ is a face")
        return value

    @model_validator(mode="after")
    def _one_way(self) -> BodySection:
        given = (self.box, self.cylinder, self.ellipsoid, self.stl, self.shapes)
        if sum(s is not None for s in given) != 1:
            raise ValueError(f"{self.name!r} is one of box, cylinder, ellipsoid, stl, shapes")
        return self


class PartSection(BodySection):
    """A part: a body of one material, by the name of its table.

    ``start`` where it begins at another temperature, ``mesh_size`` where it is meshed finer than the rest.
    """

    material: str
    start: Temperature | None = None
    mesh_size: PositiveLength | None = None
