"""What `hf press-contact` reads: the two molds, the sandwich, how hot each mold is."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.press import PressCase
from hyperfab.chapters.field import derivatives, read_field
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import MoldFile, read_mold
from hyperfab.documents.base import parse_document, read_document, told_format
from hyperfab.documents.drape import DrapeDocument
from hyperfab.documents.foam import FoamDocument
from hyperfab.documents.material import MaterialDocument
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError, placed
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.pressing.curved import Drawn, curving
from hyperfab.pressing.dense import dense
from hyperfab.pressing.mold import LOOKING, Expansion, PressFrame
from hyperfab.pressing.placement import closing_frame
from hyperfab.pressing.sandwich import thickness_factor, thinning_at
from hyperfab.surface import Surface

#: Aluminium 6061: mean coefficients of expansion from 20 degC to 100 and to 300 degC (ASM Handbook, volume 2).
ALUMINIUM = ((100.0, 300.0), (23.6e-6, 25.2e-6))
#: A surface of which more than this share of the edges is open is a heap of facets.
_TORN = 0.8
#: What is done beyond a table's rows.
_END_ROWS = "its end rows hold there"
#: How the name of a table ends, which is often given in a sandwich's place.
_TABLES = (".csv", ".tsv", ".txt", ".xlsx")
#: Steps of differences, over a standard deviation.
_STEP = 0.1
_REFERENCE_RANGE = (-50.0, 60.0)


#: A mold's surface, and what its facets are parts of where they were cut.
Shape = tuple[Surface, Drawn | None]


def read_molds(job: Job, case: PressCase, offset: np.ndarray) -> tuple[tuple[Shape, Shape], PressFrame, float]:
    """Read both molds, find how they close, and how far their facets stand off them [mm]. Winding is mended and said;
    what cannot be mended is refused. The female is mounted ``offset`` (3,) [mm] from where it is drawn.

    Gaps, temperatures and thicknesses are known at the corners of facets: large ones are cut, of the male, from whose
    corners gaps are measured, further beneath edges of the female.
    """
    one, two = (_read_mold(job, name, case.stl_unit) for name in (case.male, case.female))
    failure: InputError | None = None
    # Open surfaces do not tell their outside: try as they are, then turned.
    for turn_one in (False,) if one.found.closed else (False, True):
        for turn_two in (False,) if two.found.closed else (False, True):
            surfaces = (
                (one.turned() if turn_one else one).surface,
                (two.turned() if turn_two else two).surface,
            )
            try:
                with placed(f"{case.male}, {case.female}"):
                    frame = closing_frame(*surfaces, case.axis)
            except InputError as error:
                failure = failure or error
                continue
            for name, turned in ((case.male, turn_one), (case.female, turn_two)):
                if turned:
                    job.console.warn(f"{name}: all facets face away from the other mold; they were turned over")
            smooth = case.facets == "smooth"
            facing = frame.direction, -frame.direction
            mounted = [
                Surface(one.vertices + by, one.faces) for one, by in zip(surfaces, (-offset, offset), strict=True)
            ]
            male, female = (
                dense(surface, towards, other, smooth, edges)
                for surface, other, towards, edges in zip(surfaces, mounted[::-1], facing, (True, False), strict=True)
            )
            off = (_chord_error(one, towards, smooth) for one, towards in zip(surfaces, facing, strict=True))
            return (male, female), frame, sum(off)
    raise failure or InputError("the molds do not face each other")


def _chord_error(surface: Surface, towards: Array, smooth: bool) -> float:
    """Return how far the smooth surface stands off 95 % of the area of the facets that look ``towards`` (3,) [mm]."""
    looking = surface.normals @ towards > LOOKING
    height = np.linalg.norm(curving(surface, smooth).bulge[looking], axis=2).max(axis=1) / 4.0
    order = np.argsort(height)
    share = np.cumsum(surface.areas[looking][order])
    return float(height[order][np.searchsorted(share, 0.95 * share[-1])])


def read_foam(inputs: Inputs, name: str) -> FoamDocument:
    """Read the sandwich; a material document is a foam of its thickness without fabric."""
    if name.endswith(_TABLES):
        remedy = f'write a foam.toml with thickness = "10 mm" and compression = {{ table = "{name}" }}'
        raise InputError("is a table, no sandwich", file=name, remedy=remedy)
    return inputs.parsed(name, FoamDocument, lambda loaded: _foam_of(loaded, name))


def _foam_of(loaded: object, name: str) -> FoamDocument:
    told = told_format(loaded.get("format")) if isinstance(loaded, Mapping) else None
    if told is not None and told[0] == MaterialDocument.KIND:
        material = parse_document(loaded, name, MaterialDocument)
        if material.thickness_mm is None:
            raise InputError(
                "states no thickness of the foam",
                file=name,
                key="thickness_mm",
                remedy=f'write a foam.toml with thickness = "10 mm" and compression = {{ material = "{name}" }}',
            )
        return FoamDocument(
            format=FoamDocument.format_name(),
            thickness=f"{material.thickness_mm!r} mm",
            compression={"material": os.path.basename(name)},
        )
    return parse_document(loaded, name, FoamDocument)


def variation(name: str, document: FoamDocument, axis: str, vertices: np.ndarray) -> np.ndarray | float:
    """Return the foam's thickness at the male's ``vertices`` (n, 3), as drawn, over its nominal one; 1 if even."""
    terms = document.variation.terms()
    for term in terms:
        if axis in term:
            raise InputError(
                f"the foam's thickness cannot vary along the closing axis {axis}",
                file=name,
                key=f"variation.{term}",
                remedy=f"name coordinates across {axis}",
            )
    return thickness_factor(vertices, terms) if terms else 1.0


def across(name: str, document: FoamDocument, key: Literal["tilt", "offset"], axis: str) -> np.ndarray:
    """Return ``press.tilt`` [deg] or ``press.offset`` [mm], (3,) along the drawing's axes."""
    given = getattr(document.press, key)
    found = np.array([given.x, given.y, given.z])
    if found["xyz".index(axis)] != 0.0:
        what = "a turn about the closing axis {} is no tilt" if key == "tilt" else "the gap sets the place along {}"
        raise InputError(what.format(axis), file=name, key=f"press.{key}.{axis}", remedy=f"name an axis across {axis}")
    return found


def shrinkage(job: Job, name: str, document: FoamDocument, temperature: float, dwell: float | None) -> float:
    """Return the share of the foam's thickness that is lost at ``temperature`` [degC] by the end of the dwell."""
    given = document.shrinkage
    if isinstance(given.amount, TableFile):
        path = Inputs.beside(name, given.amount.table)
        columns = {"temperature": "temperature", "shrinkage": "dimensionless"}
        table = read_table(job.inputs.read(path), path, columns, increasing="temperature")
        table.refuse(
            (table["shrinkage"] < 0.0) | (table["shrinkage"] > 0.9),
            "shrinkage is a share of the thickness, between 0 and 0.9",
            column="shrinkage",
            remedy="give 0.05 for five percent",
        )
        amount = float(np.interp(temperature, table["temperature"], table["shrinkage"]))
        rows = table["temperature"]
        job.ranges.used("shrinkage", temperature, known=rows, source=name, unit="degC", then=_END_ROWS)
    else:
        amount = float(given.amount)
    dwell = dwell or given.dwell
    if given.time is None or dwell is None:
        return amount
    return amount * -float(np.expm1(-dwell / given.time))


def expansions(inputs: Inputs, name: str, document: FoamDocument) -> tuple[Expansion, Expansion]:
    """Return the expansion of the male and of the female mold."""
    section = document.expansion
    if not _REFERENCE_RANGE[0] <= section.reference <= _REFERENCE_RANGE[1]:
        raise InputError(
            f"{section.reference:g} degC is no room temperature",
            file=name,
            key="expansion.reference",
            remedy='give the temperature at which the STL files hold, as "20 degC"',
        )
    male, female = (_expansion(inputs, name, value, section.reference) for value in (section.male, section.female))
    return male, female


def _read_mold(job: Job, name: str, stl_unit: str) -> MoldFile:
    """Read a mold; refuse a heap of facets, and a surface of one side."""
    body = read_mold(job, name, stl_unit)
    found = body.found
    faces = len(body.surface.faces)
    edges = (3 * faces + found.open_edges) // 2
    if found.open_edges > _TORN * edges and faces > 100:
        raise InputError(
            f"its facets do not hang together: {found.open_edges} of their edges join no other facet",
            file=name,
            facet=int(body.facet[found.open_facets[0]]) + 1,
            remedy="export the surface with its corners merged, or weld it in a mesh editor",
        )
    if not found.consistent:
        raise InputError(
            "has facets whose outside cannot be told: the surface has only one side",
            file=name,
            facet=int(body.facet[found.flipped_facets[0]]) + 1,
            remedy="repair the surface in the CAD program",
        )
    return body


def _expansion(inputs: Inputs, name: str, value: float | TableFile | None, reference: float) -> Expansion:
    if value is None:
        return Expansion(reference, *ALUMINIUM)
    if isinstance(value, float):
        return Expansion.constant(value, reference)
    path = Inputs.beside(name, value.table)
    columns = {"temperature": "temperature", "expansion": "thermal-expansion"}
    table = read_table(inputs.read(path), path, columns, increasing="temperature")
    return Expansion(reference, tuple(table["temperature"].tolist()), tuple(table["expansion"].tolist()))


@dataclass(frozen=True)
class Draped:
    """How much ``thinner`` a draped sheet is at each of the male's vertices (n,).

    ``changes`` are the numbers of its document that are unsure, in their order: each one's standard deviation, what
    it changes of the thickness of the cells, and how it moves the nodes. None where it hands nothing on.
    """

    places: np.ndarray
    nodes: np.ndarray
    quads: np.ndarray
    factor: np.ndarray
    changes: Sequence[tuple[float, np.ndarray, np.ndarray]]

    @cached_property
    def thinner(self) -> np.ndarray:
        """How much thinner the sheet is (n,)."""
        return thinning_at(self.places, self.nodes, self.quads, self.factor)

    @cached_property
    def by(self) -> np.ndarray:
        """What each number changes of that (k, n)."""
        return np.array([self._by(*change) for change in self.changes]).reshape(-1, len(self.places))

    def at(self, changes: Mapping[int, float]) -> np.ndarray:
        """Return the thinning where numbers of the document change."""
        return np.asarray(self.thinner + sum((change * self.by[k] for k, change in changes.items()), 0.0))

    def _by(self, sd: float, thicker: np.ndarray, moved: np.ndarray) -> np.ndarray:
        # Nodes move as their cells thin: a place of the mold then meets another one of the sheet.
        up, down = (
            thinning_at(self.places, self.nodes + step * moved, self.quads, self.factor + step * thicker)
            for step in (_STEP * sd, -_STEP * sd)
        )
        return (up - down) / (2.0 * _STEP * sd)


def thinning(job: Job, drape: str, male: str, vertices: np.ndarray, unsure: bool) -> Draped:
    """Return how much thinner the draped sheet is at the male's ``vertices`` (n, 3), as drawn, and, where that is
    ``unsure``, by what it is."""
    document = read_document(job.inputs, drape, DrapeDocument)
    if not document.converged:
        job.console.warn(f"{drape}: the drape did not converge; its thickness is taken as it is")
    grid = read_field(job.inputs, drape, document)
    _check_same_mold(job, document, drape, male)
    numbers = [] if document.uncertainty is None else document.uncertainty.sources
    sds = [number.sd for source in numbers for number in source.numbers]
    known = zip(sds, derivatives(grid, "thickness_ratio"), derivatives(grid, "place_mm"), strict=False)
    return Draped(
        vertices + np.array(document.mold.shift_mm),
        grid.points,
        grid.cells["quad"],
        grid.cell_data["thickness_mm"] / document.thickness_mm,
        list(known) if unsure else [],
    )


def _check_same_mold(job: Job, document: DrapeDocument, drape: str, male: str) -> None:
    known = {item.sha256 for item in document.provenance.inputs} if document.provenance else set()
    ours = {item.sha256 for item in job.inputs.files if item.name == male}
    if known and not ours & known:
        job.console.warn(f"{drape}: was draped on another mold than {male}")
