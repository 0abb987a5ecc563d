"""The mesh of a mold document: what it will take, STL surfaces made coarser, and the mesher's refusals."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable

import numpy as np

from hyperfab.errors import InputError, NotConverged
from hyperfab.thermal.geometry import Body, Geometry, Shape, Stl
from hyperfab.thermal.mesher import (
    NODES_PER_TETRAHEDRON,
    RawMesh,
    expected_bytes,
    expected_tetrahedra,
    make_mesh,
    remesh_surface,
)

#: Share of the machine's memory a run may take, and from where on the expectation is worth a line.
MEMORY_SHARE = 0.8
WORTH_SAYING = 1e9

#: STL surfaces of more facets are meshed anew before booleans: sewing them takes a millisecond a facet and more.
MANY_FACETS = 3000
#: Edge lengths tried for it, and the deviation that is small enough, as shares of mesh_size; seconds for each try.
SHARES = (1.0, 0.6)
PATIENCE = 15.0
DEVIATION = 0.05

Waiting = Callable[[float], None]


def mesh_mold(
    geometry: Geometry, mesh_size: float, file: str, notes: list[str], waiting: Waiting
) -> tuple[Geometry, RawMesh]:
    """Return the geometry that was meshed and its mesh; remarks are added to ``notes``.

    Raises InputError naming the key of ``file`` where parts overlap, or the mesh would not fit into the machine.
    """
    _refuse_too_large(geometry, mesh_size, file, notes)
    try:
        coarser = _coarsened(geometry, mesh_size, notes, waiting)
        return coarser, make_mesh(coarser, mesh_size, waiting=waiting)
    except InputError as error:
        raise InputError(error.message, file=file, key="part", remedy=error.remedy) from None


def _refuse_too_large(geometry: Geometry, mesh_size: float, file: str, notes: list[str]) -> None:
    """Say what a mesh will take before it is made; refuse one that the machine cannot hold."""
    count = expected_tetrahedra(geometry, mesh_size)
    needed, there = expected_bytes(count), os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
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

    def coarser(shape: Shape) -> Shape:
        if not isinstance(shape, Stl) or len(shape.triangles) <= MANY_FACETS:
            return shape
        found, deviation = None, np.inf
        for share in SHARES:
            with contextlib.suppress(
                NotConverged
            ):  # the mesher gives up on some edge lengths and not on others
                finer, closer = remesh_surface(shape, share * size, patience=PATIENCE, waiting=waiting)
                if found is not None and len(finer.triangles) > 2 * MANY_FACETS:
                    break
                if closer < deviation:
                    found, deviation = finer, closer
            if deviation <= DEVIATION * size:
                break
        if found is None:
            return shape
        notes.append(
            f"an STL surface of {len(shape.triangles)} facets was meshed anew with {len(found.triangles)}; "
            f"they deviate by {deviation:.2g} mm at most"
        )
        return found

    def body(given: Body) -> Body:
        return Body(given.name, tuple(coarser(shape) for shape in given.shapes))

    return Geometry(tuple(map(body, geometry.parts)), tuple(map(body, geometry.cavities)), geometry.patches)
