"""Fields beside documents: found by their names and read; those that are handed on, with their derivatives, moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.documents.base import read_document, stated_kind
from hyperfab.documents.drape import DrapeDocument
from hyperfab.documents.heat import HeatDocument
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import Grid, field_among, read_vtu


def read_field(inputs: Inputs, name: str, document: DrapeDocument | HeatDocument) -> Grid:
    """Return the last field beside the document ``name``; InputError where there is none, or one of something else."""
    cells, array = ("quad", "thickness_mm") if isinstance(document, DrapeDocument) else ("tetra10", "temperature_degC")
    found = None if name == "-" else field_among(document.files)
    command = document.provenance.command if document.provenance is not None else document.KIND
    if found is None:
        raise InputError(
            f"has no field beside it; {array} is read from there",
            file=name,
            key="files",
            remedy=f"write it with hf {command} -o NAME.json, not to a pipe, and name that file",
        )
    path = inputs.beside(name, found)
    grid = read_vtu(inputs.read(path), path)
    if cells not in grid.cells or array not in {*grid.point_data, *grid.cell_data}:
        raise InputError(
            f"holds no {array} on elements of type {cells}", file=path, remedy=f"make it with hf {command}"
        )
    return grid


#: What later commands take from a document's field, by the kind of the document. A sheet's thickness counts as a share
#: of the flat one's; where its nodes lie is handed on too.
HANDED: dict[str, tuple[str, ...]] = {
    "drape": ("thickness_ratio", "place_mm"),
    "heat": ("temperature_degC",),
}


def derivatives(grid: Grid, name: str) -> list[Array]:
    """Return what a field changes by with each number of its document, in their order; none where it is not told."""
    known = grid.point_data if f"{name}_by_1" in grid.point_data else grid.cell_data
    found: list[Array] = []
    while f"{name}_by_{len(found) + 1}" in known:
        found.append(np.asarray(known[f"{name}_by_{len(found) + 1}"], dtype=np.float64))
    return found


def moved(grid: Grid, name: str, changes: Mapping[int, float]) -> Array | float:
    """Return what a field changes by where numbers of its document do."""
    by = derivatives(grid, name)
    return sum((change * by[index] for index, change in changes.items()), 0.0)


def read_handing(inputs: Inputs, name: str) -> DrapeDocument | HeatDocument:
    """Return a document that may hand fields on."""
    if stated_kind(inputs.plain(name)) == "drape":
        return read_document(inputs, name, DrapeDocument)
    return read_document(inputs, name, HeatDocument)


def moved_fields(inputs: Inputs, handed: Mapping[str, Mapping[int, float]]) -> dict[str, bytes]:
    """Return the fields beside documents with their numbers changed, as files by name."""
    found = {}
    for name, changes in handed.items():
        document = read_handing(inputs, name)
        grid = read_field(inputs, name, document)
        beside = inputs.beside(name, str(field_among(document.files)))
        if isinstance(document, DrapeDocument):
            thicker = moved(grid, "thickness_ratio", changes) * document.thickness_mm
            cells = {**grid.cell_data, "thickness_mm": grid.cell_data["thickness_mm"] + thicker}
            grid = replace(grid, points=grid.points + moved(grid, "place_mm", changes), cell_data=cells)
        else:
            warmer = grid.point_data["temperature_degC"] + moved(grid, "temperature_degC", changes)
            grid = replace(grid, point_data={**grid.point_data, "temperature_degC": warmer})
        found[beside] = unstructured(grid.points, grid.cells, grid.point_data, grid.cell_data)
    return found
