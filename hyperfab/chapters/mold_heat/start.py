"""The temperatures at the start: those of an earlier mold, put on a mesh."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.field import read_field
from hyperfab.documents.base import read_document
from hyperfab.documents.heat import HeatDocument
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import Grid
from hyperfab.thermal.locate import Locator
from hyperfab.thermal.mesh import HeatMesh

#: A node further than this many elements outside the earlier mold has no temperature there.
BEYOND = 1.5


def earlier_field(inputs: Inputs, mold: str, relative: str) -> Grid:
    """Read the last field of the heat document that ``mold`` names; InputError where there is none."""
    name = inputs.beside(mold, relative)
    return read_field(inputs, name, read_document(inputs, name, HeatDocument), "tetra10", "temperature_degC")


def start_from(grid: Grid, mesh: HeatMesh, mold: str, own: Collection[int] = ()) -> Array:
    """Return an earlier field (points in mm) at the nodes of ``mesh``: part by part where the parts agree.

    Parts by the numbers ``own`` begin at temperatures of their own, and need not have been there.
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
    for part in sorted(set(range(int(mesh.parts.max()) + 1)) - set(own)):
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
