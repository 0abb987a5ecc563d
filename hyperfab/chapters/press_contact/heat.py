"""How hot each mold is, and how it has grown: evenly, or by its field of temperature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.heat import HeatDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io.inputs import Inputs
from hyperfab.io.units import quantity
from hyperfab.io.vtu_read import Grid, read_vtu
from hyperfab.pressing.growth import Expansion, FieldGrowth, Growth, even_growth, guide_line
from hyperfab.pressing.mold import Mold, PressFrame
from hyperfab.pressing.tetra import TetraMesh, at_boundary, boundary, merged, samples
from hyperfab.pressing.thermoelastic import deform, mounting

#: A heat model is of this mold where it covers its surface this well: the share of the mold's size, and [mm].
_COVERS = (0.002, 0.5)


@dataclass(frozen=True)
class HeatInput:
    """What is known of a mold's heat: its mean ``temperature`` [degC], and the ``grid`` of heat document ``name``."""

    temperature: float
    known_from: str
    grid: Grid | None = None
    name: str = ""


@dataclass(frozen=True)
class Grown:
    """A mold's growth, the mean temperature [degC] and thermal strain behind it, and how they are known."""

    growth: Growth
    temperature: float
    strain: float
    known_from: str
    even: bool


def read_heat(
    inputs: Inputs, temperature: str | None, documents: tuple[str | None, str | None], reference: float
) -> tuple[HeatInput, HeatInput]:
    """Read ``--temperature`` or the heat documents of male and female; a mold without either is cold."""
    if temperature is not None and any(documents):
        raise UsageError("--temperature and heat documents exclude each other; give one of them")
    if temperature is not None:
        given = HeatInput(quantity(temperature, "temperature", option="--temperature"), "uniform, as given")
        return given, given
    cold = HeatInput(reference, "cold: the reference temperature")
    male, female = (cold if name is None else _read(inputs, name) for name in documents)
    return male, female


def grow(
    job: Job,
    mold: Mold,
    male: Mold,
    heat: HeatInput,
    expansion: Expansion,
    poisson: float,
    frame: PressFrame,
    flat: bool,
) -> Grown:
    """Return how ``mold`` has grown; sideways both molds grow from the middle of the ``male``.

    With a field of temperature the mold is deformed by finite elements, provided the field is that of this mold;
    where it is not, the mold grows evenly by the field's mean temperature, and that is said.
    """
    line = guide_line(male)
    if heat.grid is None:
        strain = float(expansion.strain(heat.temperature))
        return Grown(even_growth(mold, strain, line), heat.temperature, strain, heat.known_from, True)
    mesh, number = merged(frame.inward(heat.grid.points), heat.grid.cells["tetra10"])
    celsius = np.zeros(len(mesh.points))
    celsius[number] = heat.grid.point_data["temperature_degC"]
    mean, strain = heat.temperature, float(expansion.strain(heat.temperature))
    faces = boundary(mesh)
    _, distance = at_boundary(mesh, faces, celsius, mold.vertices)
    size = float(np.ptp(mold.vertices, axis=0).max())
    off = float(np.quantile(distance, 0.95))
    if off > max(_COVERS[0] * size, _COVERS[1]):
        job.console.warn(
            f"{heat.name}: its mold is another one (it lies {off:.1f} mm off the STL); the STL's mold grows evenly "
            f"with the mean temperature of {mean:.1f} degC"
        )
        known = "mean of the field of another mold's heat document"
        return Grown(even_growth(mold, strain, line), mean, strain, known, True)
    moved = deform(
        mesh, np.asarray(expansion.strain(celsius)), mounting(mesh, mold.side, flat, line), poisson
    )
    known = "field of the heat document, thermoelastic"
    return Grown(FieldGrowth(mesh, faces, moved), mean, strain, known, False)


def _read(inputs: Inputs, name: str) -> HeatInput:
    heat = read_document(inputs, name, HeatDocument)
    fields = [file for file in heat.files if file.endswith(".vtu")]
    if name == "-" or not fields:
        if heat.work_surface is None:
            raise InputError(
                "has neither a field nor a work surface, so the mold's temperature is not known",
                file=name,
                key="files",
                remedy="write the heat document to a file with hf mold-heat, or use --temperature",
            )
        return HeatInput(heat.work_surface.at_end.mean_degC, "mean of the heat document's work surface")
    # Of a series the last field is the one that bears the document's own name.
    path = Inputs.beside(name, min(fields, key=len))
    grid = read_vtu(inputs.read(path), path)
    if "temperature_degC" not in grid.point_data or "tetra10" not in grid.cells:
        raise InputError(
            "holds no temperatures on tetrahedra", file=path, remedy="make it again with hf mold-heat"
        )
    return HeatInput(_mean(grid), "field", grid, name)


def _mean(grid: Grid) -> float:
    """Mean temperature over the volume."""
    mesh = TetraMesh(grid.points, grid.cells["tetra10"])
    at = samples(mesh, slice(None))
    celsius = grid.point_data["temperature_degC"][mesh.elements] @ at.value.T
    return float(np.average(celsius, weights=at.volume))
