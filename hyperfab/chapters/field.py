"""The field that lies beside a document: found by its name, read, and looked at before it is used."""

from __future__ import annotations

from hyperfab.documents.base import Document
from hyperfab.errors import InputError
from hyperfab.io.inputs import Inputs
from hyperfab.io.vtu_read import Grid, field_among, read_vtu


def read_field(inputs: Inputs, name: str, document: Document, cells: str, array: str) -> Grid:
    """Return the last field of the document ``name``: values ``array`` on elements of the type ``cells``.

    Raises InputError where there is none, or it holds something else.
    """
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
