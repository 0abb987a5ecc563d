"""The model of ``hf press-contact``: two hot molds and the sandwich between them, from a case and its files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.cases.press import PressCase
from hyperfab.chapters.job import Job
from hyperfab.chapters.molds import ask_unit
from hyperfab.chapters.press_contact import inputs as read
from hyperfab.chapters.press_contact.heat import HeatInput, ThermalDisplacement, grow, read_heat
from hyperfab.chapters.press_contact.laws import Fabrics, compression_law, fabrics, note_temperature, thinning
from hyperfab.documents.foam import FoamDocument, TableLaw
from hyperfab.errors import UsageError, placed
from hyperfab.pressing.closing import Case as Closing
from hyperfab.pressing.foam_law import Tempered
from hyperfab.pressing.mold import Expansion, PressFrame
from hyperfab.pressing.placement import check_roles, in_frame
from hyperfab.pressing.sandwich import Sandwich

#: A mold is wider than so many thicknesses of the sandwich; an inch read as a millimetre makes a cup two of them.
LEAST_LAYERS = 5.0


@dataclass(frozen=True)
class Files:
    """What the files of a case hold.

    law         of the foam at the end of the dwell by temperature, and the share of its stress ``relaxed`` by then
    fabrics     the layers below and above the foam
    uneven      the foam's thickness at the male's vertices over its nominal one
    thinned     how much thinner a draped sheet is there, and how much its foam; None where none is given
    draped      the same sheet, with what it goes with
    thinning    by which rule the foam thins; empty where none is draped
    expansions  of the male and the female
    heat        how hot the male and the female are
    shapes      of the male and the female, as drawn
    frame       how they close
    chord_error how far their facets stand off them as they come [mm]
    tilt        of ``press.tilt`` (3,) [deg], and ``offset`` of ``press.offset`` (3,) [mm]
    """

    document: FoamDocument
    law: Tempered
    relaxed: float
    fabrics: Fabrics
    uneven: np.ndarray | float
    thinned: tuple[np.ndarray, np.ndarray] | None
    draped: read.Draped | None
    thinning: str
    expansions: tuple[Expansion, Expansion]
    heat: tuple[HeatInput, HeatInput]
    shapes: tuple[read.Shape, read.Shape]
    frame: PressFrame
    chord_error: float
    tilt: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True)
class Foam:
    """The shares of its thickness and of its stress that the foam has lost by the end of the dwell, how much of its
    compression it gives back (None: not known), whether the sandwich is not equally thick everywhere, and the
    thickness [mm] that is left of the nominal one."""

    lost: float
    relaxed: float
    recovery: float | None
    uneven: bool
    thickness: float


@dataclass(frozen=True)
class Model:
    """What is computed on: the press ready to be closed, how its molds have grown, and what of the foam is lost and
    given back."""

    case: PressCase
    files: Files
    closing: Closing
    grown: tuple[ThermalDisplacement, ThermalDisplacement]
    foam: Foam


def read_files(job: Job, case: PressCase) -> Files:
    """Read what the case names; InputError where a file is not sound, UsageError where it and an option disagree."""
    document = read.read_foam(job.inputs, case.foam)
    heat = read_heat(job.inputs, case, document.expansion.reference)
    warm = 0.5 * (heat[0].temperature + heat[1].temperature)
    law, relaxed = compression_law(job, case.foam, document, warm, case.dwell)
    note_temperature(job, case.foam, document, warm)
    layers = fabrics(job, case.foam, document, warm)
    expansions = read.expansions(job.inputs, case.foam, document)
    tilt, offset = (read.across(case.foam, document, key, case.axis) for key in ("tilt", "offset"))
    molds, frame, chord_error = read.read_molds(job, case, offset)
    one, _ = molds[0]
    thickness = document.thickness + layers.thickness
    beside = f"the sandwich {thickness:.3g} mm thick"
    ask_unit(job, case.male, one, case.stl_unit, beside, LEAST_LAYERS * thickness, np.inf)
    uneven = read.variation(case.foam, document, case.axis, one.vertices)
    if case.floating and tilt.any():
        raise UsageError("a floating mold finds its tilt by itself: leave out --float, or the tilt")
    thinned, rule, draped = None, "", None
    if case.drape is not None:
        draped = read.thinning(job, case.drape, case.male, one.vertices, case.uncertainty != "none")
        foam, rule = thinning(law.at(warm), document, case.foam, draped.thinner)
        thinned = draped.thinner, foam
    return Files(
        document,
        law,
        relaxed,
        layers,
        uneven,
        thinned,
        draped,
        rule,
        expansions,
        heat,
        molds,
        frame,
        chord_error,
        tilt,
        offset,
    )


def reread(
    job: Job,
    case: PressCase,
    before: PressCase,
    files: Files,
    handed: Mapping[str, Mapping[int, float]],
) -> Files:
    """Return the files of a case like the one ``before`` but for its quantities and those of its foam document, on the
    same molds, with the drape that it is where numbers of its document, of those ``handed`` on, change."""
    document = read.read_foam(job.inputs, case.foam)
    reference = document.expansion.reference
    heat = files.heat
    if case.temperature is not None:
        heat = read_heat(job.inputs, case, reference)
    elif any(one.cold for one in heat):
        male, female = (replace(one, temperature=reference) if one.cold else one for one in heat)
        heat = male, female
    warm = 0.5 * (heat[0].temperature + heat[1].temperature)
    # One table is the law at any temperature; what is left of it goes with the dwell.
    laid = document.compression, document.relaxation, document.shrinkage, case.dwell
    known = files.document.compression, files.document.relaxation, files.document.shrinkage, before.dwell
    law, relaxed = files.law, files.relaxed
    if laid != known or not isinstance(document.compression, TableLaw):
        law, relaxed = compression_law(job, case.foam, document, warm, case.dwell)
    tilt, offset = (read.across(case.foam, document, key, case.axis) for key in ("tilt", "offset"))
    thinned, changes = files.thinned, handed.get(case.drape or "", {})
    if files.draped is not None and (changes or law is not files.law or document.poisson != files.document.poisson):
        fabric = files.draped.at(changes)
        thinned = fabric, thinning(law.at(warm), document, case.foam, fabric)[0]
    return replace(
        files,
        document=document,
        thinned=thinned,
        law=law,
        relaxed=relaxed,
        fabrics=fabrics(job, case.foam, document, warm),
        expansions=read.expansions(job.inputs, case.foam, document),
        heat=heat,
        tilt=tilt,
        offset=offset,
    )


def sandwich_of(job: Job, case: PressCase, files: Files, warm: float) -> tuple[Sandwich, Foam]:
    """Return the sandwich at the vertices of the male, at a mean temperature of the molds [degC]."""
    document = files.document
    lost = read.shrinkage(job, case.foam, document, warm, case.dwell)
    thickness = document.thickness * (1.0 - lost)
    # At one temperature for all; at that of each place as soon as the closed press tells it.
    law = files.law.at(warm)
    sandwich = Sandwich(thickness * files.uneven, files.fabrics.thickness, law, files.fabrics.law)
    if files.thinned is not None:
        fabric, foamed = files.thinned
        sandwich = sandwich.thinned(foamed, fabric)
    return sandwich, Foam(lost, files.relaxed, document.shrinkage.recovery, sandwich.uneven, thickness)


def tilt_of(case: PressCase, files: Files) -> tuple[float, float]:
    """Return how far out of parallel the press stands, in the press frame [rad]."""
    degrees = files.tilt if case.tilt is None else _across(case.tilt, case.axis)
    first, second, _ = np.radians(files.frame.inward(degrees)) + 0.0  # no negative zeros
    return float(first), float(second)


def offset_of(files: Files) -> np.ndarray:
    """Return how far off the male's axis the female is mounted (2,) [mm], in the press frame."""
    return np.asarray(files.frame.inward(files.offset)[:2] + 0.0)  # no negative zeros


def joint_of(case: PressCase, files: Files) -> np.ndarray | None:
    """Return where a floating female hangs (2,) [mm], in the press frame; None where it is not said."""
    return None if case.force_at is None else files.frame.inward(_across(case.force_at, case.axis))[:2]


def model_of(job: Job, case: PressCase, files: Files) -> Model:
    """Return the hot press that a case describes, with what its files hold."""
    frame, document, smooth = files.frame, files.document, case.facets == "smooth"
    (one, cut_one), (two, cut_two) = files.shapes
    molds = in_frame(one, frame, 1, smooth, cut_one), in_frame(two, frame, -1, smooth, cut_two)
    with placed(f"{case.male}, {case.female}"):
        check_roles(*molds)
    male, female = (
        grow(job, mold, molds[0], known, expansion, poisson, frame, case.mounted == "flat")
        for mold, known, expansion, poisson in zip(
            molds, files.heat, files.expansions, (document.poisson.male, document.poisson.female), strict=True
        )
    )
    warm = 0.5 * (male.temperature + female.temperature)
    sandwich, foam = sandwich_of(job, case, files, warm)
    closing = Closing(
        molds[0],
        molds[1],
        sandwich,
        male.growth.at(molds[0].vertices),
        female.growth.at(molds[1].vertices),
        gap=case.gap,
        force=case.force,
        zero_hot=case.zero == "hot",
        frame=case.frame_stiffness or document.press.stiffness,
        floating=case.floating,
        force_at=joint_of(case, files),
        tilt=tilt_of(case, files),
        offset=offset_of(files),
    )
    return Model(case, files, closing, (male, female), foam)


def _across(values: tuple[float, float], axis: str) -> np.ndarray:
    """Return two components across the closing axis, in the order x, y, z, as three."""
    found = np.zeros(3)
    found[[index for index, name in enumerate("xyz") if name != axis]] = values
    return found
