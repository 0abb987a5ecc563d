"""Documents made to hand on a number more than their inputs tell: how a sheet was mounted, how hot all of a mold is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.field import HANDED, derivatives, read_field, read_handing
from hyperfab.documents.base import read_document
from hyperfab.documents.drape import DrapeDocument
from hyperfab.documents.uncertainty import SourceNumber, SourcePart, Uncertainty
from hyperfab.errors import NotConverged
from hyperfab.io.inputs import Inputs
from hyperfab.io.json_io import dump_json
from hyperfab.io.vtu import unstructured
from hyperfab.io.vtu_read import field_among
from hyperfab.numerics.propagation import LEVEL


@dataclass(frozen=True)
class More:
    """A number that a document shall hand on: the ``id`` by which it is one in all documents, its ``name`` and standard
    deviation, and what the fields of ``HANDED`` change by with it, by name."""

    id: str
    name: str
    sd: float
    by: Mapping[str, Array]


def hands_on(inputs: Inputs, name: str) -> bool:
    """Whether a document says how its field goes with its inputs."""
    told = read_handing(inputs, name).uncertainty
    return told is not None and bool(told.handed)


def handing(inputs: Inputs, name: str, numbers: list[More]) -> dict[str, bytes]:
    """Return a document that hands ``numbers`` on beside its own, and its field: files by name."""
    document = read_handing(inputs, name)
    grid = read_field(inputs, name, document)
    fields = HANDED[document.KIND]
    told = document.uncertainty or Uncertainty(level=LEVEL, method="linear", quantities={})
    known = len(derivatives(grid, fields[0]))
    arrays = {f"{field}_by_{known + k}": one.by[field] for k, one in enumerate(numbers, 1) for field in fields}
    points = {key: values for key, values in arrays.items() if len(values) == len(grid.points)}
    cells = {key: values for key, values in arrays.items() if key not in points}
    parts = [
        SourcePart(source=one.name, numbers=[SourceNumber(id=one.id, name=one.name, sd=one.sd)]) for one in numbers
    ]
    # Sources whose derivatives do not lie in the field are handed on by none.
    sources = [*told.sources, *parts] if known else parts
    told = told.model_copy(update={"sources": sources, "handed": list(fields)})
    document = document.model_copy(update={"uncertainty": told})
    field = unstructured(grid.points, grid.cells, {**grid.point_data, **points}, {**grid.cell_data, **cells})
    beside = inputs.beside(name, str(field_among(document.files)))
    return {name: dump_json(document.to_json()), beside: field}


def slope(inputs: tuple[Inputs, Inputs], name: str, step: float) -> dict[str, Array]:
    """Return what the field of a drape changes by, from the document ``step`` below to that above.

    Raises NotConverged where one of them has no answer.
    """
    below, above = (read_document(one, name, DrapeDocument) for one in inputs)
    if not (below.converged and above.converged):
        raise NotConverged("the sheet finds no rest beside it")
    low, high = (read_field(one, name, document) for one, document in zip(inputs, (below, above), strict=True))
    thicker = (high.cell_data["thickness_mm"] - low.cell_data["thickness_mm"]) / below.thickness_mm
    return {"thickness_ratio": thicker / (2.0 * step), "place_mm": (high.points - low.points) / (2.0 * step)}


def warmer(inputs: Inputs, name: str) -> dict[str, Array]:
    """Return what the field of a heat document changes by where all of it is warmer by a kelvin."""
    return {"temperature_degC": np.ones(len(read_field(inputs, name, read_handing(inputs, name)).points))}
