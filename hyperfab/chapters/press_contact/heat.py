"""How hot each mold is, and how it has grown: evenly, or by its field of temperature."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.cases.kinds import File
from hyperfab.cases.press import PressCase
from hyperfab.chapters.field import derivatives, read_field
from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.heat import HeatDocument
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import Grid, field_among
from hyperfab.pressing.mold import Expansion, FieldGrowth, Growth, Mold, PressFrame, even_growth, guide_line
from hyperfab.pressing.tetra import TetraMesh, at_boundary, boundary, merged, samples
from hyperfab.pressing.thermoelastic import deform, mounting

#: A heat model is of this mold where it covers its surface this well: the share of the mold's size, and [mm].
_COVERS = (0.002, 0.5)


@dataclass(frozen=True)
class HeatInput:
    """What is known of a mold's heat: its mean ``temperature`` [degC], and the ``grid`` of heat document ``name``;
    which ``part`` of it was named, and the ``parts`` it has; whether it
    is ``cold``, as nothing says how hot it is."""

    temperature: float
    known_from: str
    grid: Grid | None = None
    name: str = ""
    part: str = ""
    parts: tuple[str, ...] = ()
    cold: bool = False


@dataclass(frozen=True)
class Mode:
    """What a mold does with a number that its heat document hands on: its ``mean`` temperature changes [degC], and it
    grows by ``growth`` more, None where it grows evenly; ``celsius`` is its field at the nodes of the growth's mesh,
    None where it changes as a whole."""

    mean: float
    growth: Growth | None = None
    celsius: Array | None = None


@dataclass(frozen=True)
class ThermalDisplacement:
    """A mold's growth, the mean temperature [degC] and thermal strain behind it, and how they are known; ``celsius``
    is its field at the nodes of the growth's mesh, None where it is equally hot. ``modes`` are those of the numbers
    of its heat document, in their order; none where it hands nothing on."""

    growth: Growth
    temperature: float
    strain: float
    known_from: str
    even: bool
    celsius: Array | None = None
    modes: tuple[Mode, ...] = ()

    def warmer(self, temperature: float, amounts: Array) -> ThermalDisplacement:
        """Return the mold at another mean ``temperature`` [degC], so much of each of its modes hotter.

        ``amounts`` (modes,) are those of its heat document's numbers; growth stays.
        """
        celsius = self.celsius
        for by, mode in zip(amounts, self.modes, strict=True):
            if celsius is not None and mode.celsius is not None:
                celsius = celsius + by * mode.celsius
        return replace(self, temperature=temperature, celsius=celsius)

    def surface(self, points: Array) -> Array:
        """Return the temperature (n,) [degC] at cold ``points`` (n, 3) of the mold's surface."""
        if self.celsius is None:
            return np.full(len(points), self.temperature)
        assert isinstance(self.growth, FieldGrowth)
        return at_boundary(self.growth.mesh, self.growth.faces, self.celsius, points)[0]


def read_heat(inputs: Inputs, case: PressCase, reference: float) -> tuple[HeatInput, HeatInput]:
    """Return how hot male and female are: as given, or by their heat documents; a mold without either is cold."""
    if case.temperature is not None:
        given = HeatInput(case.temperature, "uniform, as given")
        return given, given
    cold = HeatInput(reference, "cold: the reference temperature", cold=True)
    male, female = (
        cold if name is None else _read(inputs, name, case.uncertainty != "none")
        for name in (case.male_heat, case.female_heat)
    )
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
) -> ThermalDisplacement:
    """Return how ``mold`` has grown; sideways both molds grow from the middle of the ``male``.

    With a field of temperature the mold is deformed by finite elements, provided a part of the heat model, or all of
    it, is this mold. Where none is, a model of one part counts by its mean temperature, and that is said; of several
    one must be named, or InputError is raised.
    """
    line = guide_line(male)
    if heat.grid is None:
        strain = float(expansion.strain(heat.temperature))
        return ThermalDisplacement(even_growth(mold, strain, line), heat.temperature, strain, heat.known_from, True)
    found = _of_mold(heat, frame, mold)
    mean, strain = _mean(found.grid), float(expansion.strain(_mean(found.grid)))
    named = f"part {found.part} of " if found.part else ""
    if found.off > found.allowed:
        if not (found.part or len(heat.parts) <= 1):
            raise InputError(
                f"none of its parts is this mold: {', '.join(f'{part} lies {off:.1f}' for part, off in found.others)} "
                "mm off the STL",
                file=heat.name,
                remedy=f"name the part whose temperature the mold has, as {heat.name}:{found.others[0][0]}, or give "
                "a heat document in which the mold stands where its STL has it",
            )
        job.console.warn(
            f"{heat.name}: {'that part' if found.part else 'its mold'} is another one (it lies {found.off:.1f} mm off "
            f"the STL); the STL's mold grows evenly with the mean temperature of {mean:.1f} degC"
        )
        known = f"mean of the field of {named}another mold's heat document"
        even = tuple(Mode(_mean(found.grid, by)) for by in found.by)
        return ThermalDisplacement(even_growth(mold, strain, line), mean, strain, known, True, modes=even)
    strains = [expansion.strain(found.celsius)]
    for by in found.by_node:
        # One standard deviation is kelvins, and a step of one is a chord of the expansion's table.
        size = max(float(np.abs(by).max()), 1e-300)
        up, down = (expansion.strain(found.celsius + way / size * by) for way in (0.5, -0.5))
        strains.append(size * (up - down))
    moved, *more = deform(found.mesh, np.array(strains), mounting(found.mesh, mold.side, flat, line), poisson)
    known = f"field of {named}the heat document, thermoelastic"
    modes = tuple(
        Mode(_mean(found.grid, by), FieldGrowth(found.mesh, found.faces, along), at_nodes)
        for by, along, at_nodes in zip(found.by, more, found.by_node, strict=True)
    )
    return ThermalDisplacement(
        FieldGrowth(found.mesh, found.faces, moved), mean, strain, known, False, found.celsius, modes
    )


@dataclass(frozen=True)
class _Found:
    """The part of a heat model that is a mold, or is taken for it: its ``grid``, its ``mesh`` in the press frame with
    outer ``faces`` and nodal ``celsius``, how far ``off`` the STL it lies and what is ``allowed`` [mm]; the name of the
    ``part``, empty for all of the model; how far each of the ``others`` lies off; what the temperature changes ``by``
    with each number of the document, at the grid's points and at the mesh's nodes."""

    grid: Grid
    mesh: TetraMesh
    faces: Ints
    celsius: Array
    off: float
    allowed: float
    part: str
    others: list[tuple[str, float]]
    by: list[Array]
    by_node: list[Array]


def _of_mold(heat: HeatInput, frame: PressFrame, mold: Mold) -> _Found:
    """Return the part that was named, or else the one that lies on the mold's surface, or else all parts together."""
    whole = heat.grid
    assert whole is not None
    size = float(np.ptp(mold.vertices, axis=0).max())
    allowed = max(_COVERS[0] * size, _COVERS[1])

    def tried(part: str) -> _Found:
        grid = _part(whole, heat.parts.index(part)) if part else whole
        mesh, number = merged(frame.inward(grid.points), grid.cells["tetra10"])

        def at_nodes(values: Array) -> Array:
            there = np.zeros(len(mesh.points))
            there[number] = values
            return there

        celsius = at_nodes(grid.point_data["temperature_degC"])
        by = derivatives(grid, "temperature_degC")
        faces = boundary(mesh)
        _, distance = at_boundary(mesh, faces, celsius, mold.vertices)
        off = float(np.quantile(distance, 0.95))
        return _Found(grid, mesh, faces, celsius, off, allowed, part, [], by, [at_nodes(one) for one in by])

    if heat.part:
        return tried(heat.part)
    parts = [tried(part) for part in heat.parts] if len(heat.parts) > 1 else []
    parts.sort(key=lambda found: found.off)
    if parts and parts[0].off <= allowed:
        return parts[0]
    return replace(tried(""), others=[(found.part, found.off) for found in parts])


def _part(grid: Grid, index: int) -> Grid:
    """Return the elements of one part, and their nodes."""
    elements = grid.cells["tetra10"][grid.cell_data["part"] == index]
    used, small = np.unique(elements, return_inverse=True)
    return Grid(
        grid.points[used],
        {"tetra10": small},
        {name: values[used] for name, values in grid.point_data.items()},
        {},
    )


def file_of(given: str) -> tuple[str, str]:
    """Return the heat document that an option names, and the part of it; empty where none is named."""
    name, part = File.parted(given)
    return name, part.removeprefix(":")


def _read(inputs: Inputs, given: str, unsure: bool) -> HeatInput:
    name, part = file_of(given)
    heat = read_document(inputs, name, HeatDocument)
    if heat.work_surface is not None and (name == "-" or field_among(heat.files) is None):
        return HeatInput(heat.work_surface.at_end.mean_degC, "mean of the heat document's work surface")
    grid = read_field(inputs, name, heat)
    if not unsure:
        grid = replace(grid, point_data={"temperature_degC": grid.point_data["temperature_degC"]})
    parts = tuple(heat.mass_by_part_kg)
    if "part" not in grid.cell_data or len(np.unique(grid.cell_data["part"])) != len(parts):
        parts = parts[:1]  # no telling them apart
    if part and part not in parts:
        raise InputError(f"has no part {part}", file=name, remedy=f"its parts are {', '.join(parts)}")
    whole = _part(grid, parts.index(part)) if part and len(parts) > 1 else grid
    return HeatInput(_mean(whole), "field", grid, name, part if len(parts) > 1 else "", parts)


def _mean(grid: Grid, values: Array | None = None) -> float:
    """Mean over the volume of the temperature, or of other ``values`` (n,) at the points."""
    mesh = TetraMesh(grid.points, grid.cells["tetra10"])
    at = samples(mesh, slice(None))
    values = grid.point_data["temperature_degC"] if values is None else values
    celsius = values[mesh.elements] @ at.value.T
    return float(np.average(celsius, weights=at.volume))
