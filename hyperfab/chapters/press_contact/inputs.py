"""What `hf press-contact` reads: the two molds, the sandwich, how hot each mold is."""

from __future__ import annotations

import os

import numpy as np

from hyperfab.cases.press import PressCase
from hyperfab.chapters.field import read_field
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import MoldFile, read_mold
from hyperfab.console import Console
from hyperfab.documents.base import document_class, read_document
from hyperfab.documents.drape import DrapeDocument
from hyperfab.documents.foam import (
    FoamDocument,
    HyperfoamLaw,
    LinearLaw,
    MaterialLaw,
    PlateauLaw,
    TableFile,
    TableLaw,
)
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.materials.hyperfoam import ORDERS, Hyperfoam
from hyperfab.pressing import foam_law
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.growth import Expansion
from hyperfab.pressing.mold import PressFrame
from hyperfab.pressing.placement import closing_frame
from hyperfab.pressing.thinning import thickness_factor, thinning_at
from hyperfab.surface import Surface

#: Aluminium 6061: mean coefficients of expansion from 20 degC to 100 and to 300 degC (ASM Handbook, volume 2).
ALUMINIUM = ((100.0, 300.0), (23.6e-6, 25.2e-6))
#: A surface of which more than this share of the edges is open is a heap of facets.
_TORN = 0.8
#: Strain and stress of a foam test that go back by less than this share of their largest value only jitter.
_JITTER = 0.02
#: What is done beyond a table's rows.
_END_ROWS = "its end rows hold there"
_REFERENCE_RANGE = (-50.0, 60.0)


def read_molds(job: Job, case: PressCase) -> tuple[Surface, Surface, PressFrame]:
    """Read both molds and find how they close. Winding is mended and said; what cannot be mended is refused."""
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
                frame = closing_frame(*surfaces, case.axis)
            except InputError as error:
                failure = failure or error
                continue
            for name, turned in ((case.male, turn_one), (case.female, turn_two)):
                if turned:
                    job.console.warn(
                        f"{name}: all facets face away from the other mold; they were turned over"
                    )
            return *surfaces, frame
    raise failure or InputError("the molds do not face each other")


def read_foam(inputs: Inputs, name: str) -> FoamDocument:
    """Read the sandwich; a material document is a foam of its thickness without fabric."""
    if name.endswith(".json"):
        material = read_document(inputs, name, MaterialDocument)
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
    if not name.endswith(".toml"):
        raise InputError("is no .toml document", file=name, remedy="write the sandwich as foam.toml")
    return read_document(inputs, name, FoamDocument)


def compression_law(job: Job, name: str, document: FoamDocument, temperature: float) -> tuple[FoamLaw, float]:
    """Return the law at a temperature [degC] and the end of the dwell, and the share of stress relaxed by then."""
    left = 1.0
    dwell = document.relaxation.dwell or document.shrinkage.dwell
    if dwell is not None:
        left = foam_law.relaxed(document.relaxation.share, document.relaxation.time, dwell)
    law = _law(job, name, document, temperature)
    return law.scaled(left), 1.0 - left


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


def tilt(name: str, document: FoamDocument, axis: str) -> np.ndarray:
    """Return the tilt (3,) [deg] of ``press.tilt`` about the drawing's axes."""
    given = document.press.tilt
    found = np.array([given.x, given.y, given.z])
    if found["xyz".index(axis)] != 0.0:
        raise InputError(
            f"a turn about the closing axis {axis} is no tilt",
            file=name,
            key=f"press.tilt.{axis}",
            remedy=f"name an axis across {axis}",
        )
    return found


def in_plan(frame: PressFrame, degrees: np.ndarray) -> tuple[float, float]:
    """Return a tilt (3,) [deg] about the drawing's axes in the press frame [rad]."""
    first, second, _ = np.radians(frame.inward(degrees)) + 0.0  # no negative zeros
    return float(first), float(second)


def _law(job: Job, name: str, document: FoamDocument, temperature: float) -> FoamLaw:
    given = document.compression
    if isinstance(given, LinearLaw):
        return foam_law.linear(given.modulus)
    if isinstance(given, PlateauLaw):
        return foam_law.plateau(given.plateau, given.modulus, given.densification, given.power)
    if isinstance(given, HyperfoamLaw):
        return foam_law.hyperfoam(given.mu, given.alpha, given.nu)
    if isinstance(given, MaterialLaw):
        return _fitted_law(job, Inputs.beside(name, given.material), temperature)
    return _table_law(job.inputs, Inputs.beside(name, given.table), given, job.console)


def _fitted_law(job: Job, path: str, temperature: float) -> FoamLaw:
    """Return the law of a material document at a temperature, linear between those of its tests."""
    document = read_document(job.inputs, path, MaterialDocument)
    if document.model not in ORDERS:
        raise InputError(
            f"{document.model} is no law of a foam",
            file=path,
            key="model",
            remedy=f"fit the foam's tests with --model {', '.join(ORDERS)}",
        )
    try:
        law = Hyperfoam.of(document.constants(None, temperature))
    except (KeyError, ValueError) as error:
        raise InputError(f"no constants of {document.model}: {error}", file=path, key="parameters") from None
    known = [row.temperature_degC for row in document.temperatures or []]
    if not known and document.temperature_degC is not None:
        known = [document.temperature_degC]
    then = "the constants of the nearest test are taken" if known else "its tests state no temperature"
    job.ranges.used("temperature_degC", temperature, known=known or None, source=path, then=then)
    found = foam_law.hyperfoam(law.mu, law.alpha, law.nu)
    strain = np.linspace(0.0, found.limit, 400)
    falling = np.flatnonzero(np.diff(found.raw_stress(strain)) < 0.0)
    if len(falling):
        raise InputError(
            f"its stress between plates falls from a strain of {strain[falling[0]]:.2g} on",
            file=path,
            key="parameters",
            remedy="fit with fewer terms, or give a confined compression test too",
        )
    return found


def fabric_thickness(inputs: Inputs, name: str, document: FoamDocument) -> float:
    """Return the thickness [mm] of both fabric layers together; a material document gives its own."""
    total = 0.0
    for side, layer in (("above", document.fabric.above), ("below", document.fabric.below)):
        if isinstance(layer, str):
            material = read_document(inputs, Inputs.beside(name, layer), document_class("material"))
            thickness = getattr(material, "thickness_mm", None)
            if thickness is None:
                raise InputError(
                    f"the material document {layer} states no thickness",
                    file=name,
                    key=f"fabric.{side}",
                    remedy='write the thickness itself, as "0.5 mm"',
                )
            total += float(thickness)
        else:
            total += layer
    return total


def shrinkage(job: Job, name: str, document: FoamDocument, temperature: float) -> float:
    """Return the share of the foam's thickness that is lost at ``temperature`` [degC] by the end of the dwell."""
    given = document.shrinkage
    if isinstance(given.amount, TableFile):
        path = Inputs.beside(name, given.amount.table)
        columns = {"temperature": "temperature", "shrinkage": "dimensionless"}
        table = read_table(job.inputs.read(path), path, columns, increasing="temperature")
        wrong = np.flatnonzero((table["shrinkage"] < 0.0) | (table["shrinkage"] > 0.9))
        if len(wrong):
            raise InputError(
                "shrinkage is a share of the thickness, between 0 and 0.9",
                file=path,
                line=int(table.lines[wrong[0]]),
                column="shrinkage",
                remedy="give 0.05 for five percent",
            )
        amount = float(np.interp(temperature, table["temperature"], table["shrinkage"]))
        rows = table["temperature"]
        job.ranges.used("shrinkage", temperature, known=rows, source=name, unit="degC", then=_END_ROWS)
    else:
        amount = float(given.amount)
    if given.time is None or given.dwell is None:
        return amount
    return amount * -float(np.expm1(-given.dwell / given.time))


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
    male, female = (
        _expansion(inputs, name, value, section.reference) for value in (section.male, section.female)
    )
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


def _without_jitter(stress: np.ndarray) -> np.ndarray:
    """Return the never falling stress (n,) nearest to one that falls by no more than jitter; another one as it is."""
    if (np.maximum.accumulate(stress) - stress).max() > _JITTER * stress.max():
        return stress
    from scipy.optimize import isotonic_regression

    return np.asarray(isotonic_regression(stress).x)


def _table_law(inputs: Inputs, path: str, given: TableLaw, console: Console) -> FoamLaw:
    table = read_table(inputs.read(path), path, {"strain": "dimensionless", "stress": "stress"})
    strain, stress = table["strain"], table["stress"]
    # A test as the machine wrote it: the way down to the largest strain is the law, rows that only jitter are left out.
    down = slice(0, int(np.argmax(strain)) + 1)
    highest = np.maximum.accumulate(strain[down])
    back = highest - strain[down]
    if (back > _JITTER * highest[-1]).any():
        row = int(np.argmax(back > _JITTER * highest[-1]))
        raise InputError(
            f"the strain goes back from {highest[row]:g} to {strain[row]:g} before its largest value, {highest[-1]:g}",
            file=path,
            line=int(table.lines[row]),
            column="strain",
            remedy="keep one loading of one specimen, in the order in which it was measured",
        )
    rising = np.flatnonzero(np.diff(highest, prepend=-np.inf) > 0.0)
    # Before the plates touch the foam, strain and stress jitter about zero.
    rising = rising[
        strain[rising] >= (0.0 if strain[0] < 0.0 and strain[0] > -_JITTER * highest[-1] else -np.inf)
    ]
    lines = table.lines[rising]
    strain, stress = strain[rising], _without_jitter(stress[rising])
    stress = np.where((stress < 0.0) & (stress > -_JITTER * stress.max()), 0.0, stress)
    if len(rising) < len(table["strain"]):
        console.note(
            f"{path}: {len(rising)} rows of the loading are the law; {len(table['strain']) - down.stop} of the way "
            f"back and {down.stop - len(rising)} in which the strain does not rise are left out"
        )

    def refuse(row: int, message: str, remedy: str, column: str = "strain") -> None:
        raise InputError(message, file=path, line=int(lines[row]), column=column, remedy=remedy)

    if len(strain) < 2:
        refuse(0, "one row is no curve", "give at least two rows")
    if strain[0] < 0.0:
        refuse(0, "compression strain is negative", "give compression as positive strain and stress")
    if strain[-1] >= 1.0:
        refuse(
            len(strain) - 1, "foam cannot be compressed by 100 % or more", "give strain as a fraction below 1"
        )
    if stress[0] < 0.0:
        refuse(
            0, "compression stress is negative", "give compression as positive strain and stress", "stress"
        )
    falling = np.flatnonzero(np.diff(stress) < 0.0)
    if len(falling):
        message = f"stress falls from {stress[falling[0]]:g} to {stress[falling[0] + 1]:g} MPa"
        refuse(int(falling[0]) + 1, message, "smooth the curve so that stress never falls", "stress")
    if stress[-1] <= 0.0:
        refuse(len(strain) - 1, "the foam bears nothing", "check the column and its unit", "stress")
    return foam_law.table(strain, stress)


def _expansion(inputs: Inputs, name: str, value: float | TableFile | None, reference: float) -> Expansion:
    if value is None:
        return Expansion(reference, *ALUMINIUM)
    if isinstance(value, float):
        return Expansion.constant(value, reference)
    path = Inputs.beside(name, value.table)
    columns = {"temperature": "temperature", "expansion": "thermal-expansion"}
    table = read_table(inputs.read(path), path, columns, increasing="temperature")
    return Expansion(reference, tuple(table["temperature"].tolist()), tuple(table["expansion"].tolist()))


def thinning(job: Job, drape: str, male: str, vertices: np.ndarray) -> np.ndarray:
    """Return how much thinner the draped sheet is at each of the male's ``vertices`` (n, 3), as drawn."""
    document = read_document(job.inputs, drape, DrapeDocument)
    if not document.converged:
        job.console.warn(f"{drape}: the drape did not converge; its thickness is taken as it is")
    grid = read_field(job.inputs, drape, document, "quad", "thickness_mm")
    _check_same_mold(job, document, drape, male)
    factor = grid.cell_data["thickness_mm"] / document.thickness_mm
    return thinning_at(vertices + np.array(document.mold.shift_mm), grid.points, grid.cells["quad"], factor)


def _check_same_mold(job: Job, document: DrapeDocument, drape: str, male: str) -> None:
    known = {item.sha256 for item in document.provenance.inputs} if document.provenance else set()
    ours = {item.sha256 for item in job.inputs.files if item.name == male}
    if known and not ours & known:
        job.console.warn(f"{drape}: was draped on another mold than {male}")
