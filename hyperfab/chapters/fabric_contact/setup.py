"""What `hf fabric-contact` was asked for: options and material documents, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io.units import quantity
from hyperfab.materials import Material, bind
from hyperfab.membrane.contact import Frictionless, Tangential
from hyperfab.membrane.friction import Coulomb, Stick
from hyperfab.membrane.orthotropic import OrthotropicSheet
from hyperfab.membrane.outline import Disc, Outline, Square
from hyperfab.membrane.tension_field import IsotropicSheet, SheetLaw

#: Load steps where --steps is not given.
_STEPS = 8
_MOST_STEPS = 500
#: Beyond this a coefficient is a slip of the pen; stick is meant.
_MOST_FRICTION = 2.0
#: Elements away from the contact, relative to half the size, where --mesh-size is not given.
_MESH = 0.08


@dataclass(frozen=True)
class Fabric:
    """A sheet's law as read from a material document, in words too."""

    name: str
    model: str
    law: SheetLaw
    words: str
    thickness: float | None
    left_out: list[str]


@dataclass(frozen=True)
class Setup:
    """The geometry and the settings of the test, in mm."""

    outline: Outline
    shape: str
    size: float
    thickness: float
    sphere_radius: float
    depths: list[float]
    prestretch: float
    mesh_size: float
    tolerance: float
    friction: Tangential

    @property
    def depth(self) -> float:
        """The depth asked for."""
        return self.depths[-1]


def read_setup(
    fabric: Fabric,
    *,
    shape: str,
    size: str,
    thickness: str | None,
    sphere_radius: str,
    depth: str,
    prestretch: float,
    friction: str | None,
    steps: int | None,
    mesh_size: str | None,
    tolerance: float,
) -> Setup:
    """Check the options; UsageError names the one that cannot be meant."""
    width = _length(size, "--size")
    radius = _length(sphere_radius, "--sphere-radius")
    deep = _length(depth, "--depth")
    _within(width, 1.0, 10_000.0, f"--size {size}")
    _within(radius, 5e-3 * width, 20.0 * width, f"--sphere-radius {sphere_radius}")
    _within(deep, 1e-3 * width, 2.0 * width, f"--depth {depth}")
    if not (0.5 <= prestretch <= 5.0):
        raise UsageError(
            f"--prestretch {prestretch:g}: a stretch ratio between 0.5 and 5 is meant, 1.05 for 5 %"
        )
    if steps is not None and not 1 <= steps <= _MOST_STEPS:
        raise UsageError(f"--steps {steps}: between 1 and {_MOST_STEPS} load steps")
    if not 1e-7 <= tolerance <= 0.1:
        raise UsageError(f"--tolerance {tolerance:g}: the relative error of the force, between 1e-7 and 0.1")
    outlines: dict[str, Outline] = {
        "disc": Disc(width / 2, quarter=True),
        "square": Square(width, quarter=True),
    }
    if shape not in outlines:
        raise UsageError(f"--shape {shape}: choose disc or square")
    mesh = _MESH * width / 2 if mesh_size is None else _length(mesh_size, "--mesh-size")
    if not width / 400 <= mesh <= width / 6:
        raise UsageError(
            f"--mesh-size {mesh_size}: between {width / 400:.3g}mm and {width / 6:.3g}mm for this sheet"
        )
    thick = _length(thickness, "--thickness") if thickness is not None else fabric.thickness or 1.0
    _check_clamp(width / 2 * prestretch, radius, deep)
    count = steps or _STEPS
    depths = [float(part) for part in np.linspace(0.0, deep, count + 1)[1:]]
    return Setup(
        outlines[shape], shape, width, thick, radius, depths, prestretch, mesh, tolerance, _friction(friction)
    )


def read_fabric(job: Job, name: str) -> Fabric:
    """Read a material document and make a sheet's law of it."""
    document = read_document(job.inputs, name, MaterialDocument)
    left_out = []
    untold = [effect for effect in document.effects or [] if not effect.get("told_by")]
    if untold:
        named = ", ".join(str(effect.get("id", "?")) for effect in untold)
        left_out.append(f"effects of the material document: {named}; the sheet obeys the law at rest alone")
    directions = document.directions or {}
    if {"warp", "weft"} <= set(directions):
        warp, weft = (
            _bound(document.model, directions[way].parameters, name, f"directions.{way}.parameters")
            for way in ("warp", "weft")
        )
        sheet = OrthotropicSheet(warp, weft)
        soft, stiff = ("weft", "warp") if sheet.stiff_axis == 0 else ("warp", "weft")
        words = (
            f"orthotropic: the {soft}'s law in the whole sheet, and along the {stiff} what its law has more "
            "in uniaxial tension; the warp runs along x"
        )
        left_out.append(
            "shear and biaxial stiffness of the fabric beyond the softer direction's law: not measured"
        )
        return Fabric(name, document.model, sheet, words, document.thickness_mm, left_out)
    law = IsotropicSheet(_bound(document.model, document.parameters, name, "parameters"))
    return Fabric(name, document.model, law, "isotropic", document.thickness_mm, left_out)


def _bound(model: str, parameters: dict[str, float], name: str, key: str) -> Material:
    try:
        return bind(model, parameters)
    except InputError as error:
        place = f"{key}.{error.key}" if error.key in parameters else error.key or key
        raise InputError(error.message, file=name, key=place, remedy=error.remedy) from None


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


def _check_clamp(rim: float, radius: float, depth: float) -> None:
    """The clamp is a hard ring in the plane of the flat sheet: the sphere must pass through it."""
    if rim >= radius:
        return
    most = radius - math.sqrt(radius**2 - rim**2)
    if depth > most:
        raise UsageError(
            f"--depth {depth:g}mm: the sphere would strike the clamp at {most:.4g}mm; "
            "choose a smaller sphere or depth, or a larger sheet"
        )
