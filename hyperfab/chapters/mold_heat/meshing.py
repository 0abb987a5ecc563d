"""The mesh of a mold document: what it will take, STL surfaces made coarser, and the mesher's refusals."""

from __future__ import annotations

from collections.abc import Callable

import psutil

from hyperfab.arrays import Array
from hyperfab.errors import InputError, NotConverged, placed
from hyperfab.thermal.geometry import Geometry, Stl
from hyperfab.thermal.mesher import (
    NODES_PER_TETRAHEDRON,
    RawMesh,
    expected_bytes,
    expected_tetrahedra,
    make_mesh,
)
from hyperfab.thermal.remesh import laid_back, remesh_surface, standing_for
from hyperfab.thermal.repair import crossing

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
            return coarser, laid_back(make_mesh(coarser, mesh_size, waiting=waiting, built=built), coarser)
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
