"""`hf press-contact`, two hot molds closed on the sandwich: read, place, heat, close, judge, write."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.cases.press import PressCase
from hyperfab.chapters.fabric import FabricDocument
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact import nearby
from hyperfab.chapters.press_contact.design import compensate, design_of
from hyperfab.chapters.press_contact.fields import formed_picture, grid_of, picture_of
from hyperfab.chapters.press_contact.formed import Wanted, formed, read_setting
from hyperfab.chapters.press_contact.formed import note_ranges as note_set_ranges
from hyperfab.chapters.press_contact.heat import file_of
from hyperfab.chapters.press_contact.laws import materials
from hyperfab.chapters.press_contact.model import Model, model_of, read_files, tilt_of
from hyperfab.chapters.press_contact.result import PressResult, document_of
from hyperfab.chapters.press_contact.warmth import settled, warmed
from hyperfab.chapters.uncertainty.carry import carry
from hyperfab.chapters.uncertainty.handed import identified, join
from hyperfab.chapters.uncertainty.sources import Origins, origins
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.documents.base import read_document
from hyperfab.documents.foam import FoamDocument, MaterialLaw, TableLaw
from hyperfab.documents.material import MaterialDocument
from hyperfab.documents.press import PressDocument
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError, NotConverged, UsageError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.inputs import Inputs
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.mold import PressFrame

#: Stress with held sides over that with free ones from which on it is told as a guess.
_GUESSED = 10.0
#: Facets that stand off the smooth molds by more than this share of the sandwich are told: what is behind them is known
#: to no more than a part of that where it is curved the most.
_COARSE = 0.1
#: The columns of the curve.
_CURVE = ("stroke_mm", "force_N", "pressed_area_mm2", "gap_min_mm", "energy_J")
#: What may be written beside the document.
SIBLINGS = (".vtu", ".csv", ".png", ".formed.png", ".design.stl", ".compensated.stl")


def run(job: Job, case: PressCase) -> int:
    """Read, place, heat, close, judge, write. Returns 1 where the molds collide or too little is spotted."""
    out = job.opened(*SIBLINGS)
    for option, asked in (("--design-gap", case.design_gap is not None), ("--compensate", case.compensate)):
        if asked and not out.wants_files:
            raise UsageError(f"{option} writes an STL beside the document: name it with -o press.json")
    files = read_files(job, case)
    setting = read_setting(job, case.foam, files.document)
    if case.wanted is not None and setting is None:
        raise InputError(
            "--wanted is the formed thickness, and nothing says what stays when the press opens",
            file=case.foam,
            key="set",
            remedy='add set = { measured = "set.csv" } or { rate = "3e8 1/s", activation = "95 kJ/mol" }',
        )
    if case.compensate and (case.floating or any(tilt_of(case, files))):
        raise UsageError("--compensate is for a press that closes in parallel: leave out --float and the tilt")
    wanted = None if case.wanted is None else Wanted(job, case, files.frame)
    with job.console.progress("Closing the press") as advance:
        model = model_of(job, case, files)
        out.refuse_inputs(job.inputs)
        advance(0.3, "closing")
        told = solve(job, model)
        told = replace(told, warmed=warmed(job, model, told.closed))
        if setting is not None and told.warmed is not None:
            stays = formed(setting, told.warmed.column, told.warmed.dwell, told.closed)
            note_set_ranges(job, stays, told.warmed.dwell, told.closed)
            told = replace(told, formed=stays, wanted=wanted)
        note_ranges(job, model, told.closed)
        _tell_overlap(job, told.closed, told.frame)
        _tell_coarse(job, model, told.closed)
        if told.closed.front.aside > 0.0:
            job.console.warn(
                f"{case.male}: {told.closed.front.aside:.0f} mm2 that look at the female lie on bodies no higher than "
                "the lowest level of the mold: they count with its flange, not with its molding surface"
            )
        advance(0.6, "design")
        stl = b""
        if case.design_gap is not None:
            stl, design = design_of(job, told.closed, told.frame, case.design_gap, model.grown[0].growth)
            told = replace(told, design=design)
        compensated = b""
        if case.compensate and setting is not None and told.beside is not None and wanted is not None:
            compensated, found = compensate(
                job, model, told.closed, setting, wanted, told.beside,
                lambda share: advance(0.6 + 0.2 * share, "compensating"),
            )  # fmt: skip
            told = replace(told, compensation=found)
        result = document_of(told)
        status = _judge(job, result, told.closed, case)
        advance(0.8, "following the press from the first touch")
        result.force_stroke = [(float(row[0]), float(row[1])) for row in told.curve]
        if out.wants_files:
            out.add(".csv", csv_bytes(_CURVE, list(told.curve)))
            if told.formed is not None:
                out.add(".formed.png", formed_picture(told))
        if stl:
            out.add(".design.stl", stl)
        if compensated:
            out.add(".compensated.stl", compensated)
    sure = carry(
        job,
        case,
        result,
        lambda: _origins(job, model, result),
        lambda known: nearby.beside(job, model, told.closed, known),
    )
    if out.wants_files:
        out.add(".vtu", grid_of(told, sure.fields))
        out.add(".png", picture_of(told, result, sure))
    cold = case.male_heat is None and case.female_heat is None
    job.write(out, result, case, temperature_degC=float(told.reference) if cold else None)
    return status


def _origins(job: Job, model: Model, result: PressDocument) -> Origins:
    """Return what the inputs say of how sure they are: what is typed, the laws of fabric and foam, and what drape and
    heat documents hand on."""
    case = model.case
    stated = {case.foam: FoamDocument} if case.foam.endswith(".toml") else {}
    laws = materials(job.inputs, case.foam, model.files.document, 0.5 * sum(grown.temperature for grown in model.grown))
    found = origins(job.inputs, case, laws, stated)
    identified(found, case, job)
    heat = [file_of(name)[0] for name in (case.male_heat, case.female_heat) if name is not None]
    join(found, job.inputs, heat if case.drape is None else [*heat, case.drape])
    told = (("warming", "the sandwich's temperature"), ("formed", "the thickness when the press has opened"))
    found.left_out += [what for key, what in told if found.found and getattr(result, key) is not None]
    return found


def solve(job: Job, model: Model) -> PressResult:
    """Close the press."""
    return PressResult(model, settled(job, model))


def note_ranges(job: Job, model: Model, closed: Closed) -> None:
    """Note where the laws and tables of foam.toml were used, beside what was tested or the rows they have."""
    document, sandwich, foam = model.files.document, closed.press.sandwich, model.case.foam
    strain = sandwich.strain(closed.contact.gap)
    if any(isinstance(law, TableLaw) for law in document.laws):
        # Of laws by place the one that is left the furthest.
        limits = np.broadcast_to(sandwich.law.limit, strain.shape)
        worst = float(limits[np.argmax(strain - limits)])
        then = "it counts as bottomed there"
        job.ranges.used(
            "strain", np.minimum(strain, strain - limits + worst), known=(0.0, worst), source=foam, then=then
        )
    for law in document.laws:
        if isinstance(law, MaterialLaw):
            path = Inputs.beside(foam, law.material)
            fitted = read_document(job.inputs, path, MaterialDocument)
            known, stress = fitted.tested_stretch(), None
            if known is not None and sandwich.law.places is None:
                most, tested = sandwich.law.stress([float(strain.max()), 1.0 - known[0]]).tolist()
                stress = most, tested
            job.ranges.used("stretch", 1.0 - strain, known=known, source=path, stress=stress)
            _tell_held(job, path, fitted, float(strain.max()))
    if sandwich.fabric_law is not None:
        across = 1.0 - sandwich.pressed(closed.contact.gap)[1] / sandwich.fabric
        known = (0.0, float(np.max(sandwich.fabric_law.limit)))
        job.ranges.used("fabric.compression", across, known=known, source=foam, then="its last slope goes on")
    tables = (document.expansion.male, document.expansion.female)
    sides = zip(("male", "female"), tables, model.files.expansions, model.grown, strict=True)
    for side, given, rows, grown in sides:
        if isinstance(given, TableFile):
            job.ranges.used(f"expansion.{side}", grown.temperature, known=rows.temperatures, source=foam, unit="degC")
    most = float(strain.max(initial=0.0))
    if most >= 1.0 and closed.contact.gap.min() > 0.0:  # where the molds touch, that is told
        job.console.warn(
            f"the foam would be pressed by {100.0 * most:.0f} % of its thickness, to nothing: layers of fabric fill "
            "the gap there, and force and pressure are those of its law drawn on"
        )
    if any(not isinstance(law, (TableLaw, MaterialLaw)) for law in document.laws):
        # Of laws by their constants alone nothing says how far they hold.
        job.ranges.used("strain", strain, known=None, source=foam)


def _tell_held(job: Job, path: str, fitted: MaterialDocument, strain: float) -> None:
    """Warn where a law's stress between plates, its sides held, is a guess far beyond that of the tests behind it."""
    if strain <= 0.0 or "confined-compression" in (fitted.tested or {}) or "volumetric" in (fitted.tested or {}):
        return
    _, law = FabricDocument(fitted, path).foams()[0]
    held, free = (abs(float(law.stress(test, [1.0 - strain])[0])) for test in ("confined-compression", "uniaxial"))
    if not held <= _GUESSED * free:
        job.console.warn(
            f"{path}: pressed by {100.0 * strain:.0f} % between plates, where its sides are held, its law says "
            f"{held / free:.3g} times the stress of a free specimen, and no test with held sides is behind it: give "
            "hf fit a confined compression test or the measured lateral stretch, or fewer terms"
        )


def _tell_overlap(job: Job, closed: Closed, way: PressFrame) -> None:
    """Say where and how deep the molds are drawn into each other."""
    depth = -closed.datum.gap
    if depth > 0.0:
        at = ", ".join(f"{value:.1f}" for value in way.outward(closed.datum.at))
        job.console.warn(
            f"as drawn the molds overlap by {depth:.3f} mm at ({at}) mm: they part when opened by that much, and "
            "the clearance is counted from there"
        )


def _tell_coarse(job: Job, model: Model, closed: Closed) -> None:
    """Say so where facets are too few to tell the molds behind them as well as the sandwich asks for."""
    off = model.files.chord_error
    if off > _COARSE * float(np.max(closed.press.sandwich.thickness)):
        job.console.warn(
            f"{model.case.male}, {model.case.female}: the facets stand off the smooth molds by {off:.2g} mm, and gaps "
            "may be wrong by nearly as much where the molds are curved the most: give a finer STL"
        )


def _judge(job: Job, result: PressDocument, closed: Closed, case: PressCase) -> int:
    percent = 100.0 * result.contact_fraction
    flange = " with the flange" if result.flange_area_mm2 > 0.0 else ""
    job.console.note(
        f"touching {percent:.1f} % of the molding surface, {result.contact_area_mm2:.0f} mm2{flange}, gap "
        f"{result.gap_min_mm:.3f} to {result.gap_max_mm:.3f} mm, force {result.force_N:.4g} N"
    )
    status = 0
    if result.formed is not None:
        made = result.formed
        job.console.note(
            f"formed {made.thickness_min_mm:.3f} to {made.thickness_max_mm:.3f} mm, mean "
            f"{made.thickness_mean_mm:.3f} mm; it springs back by {made.springback_mean_mm:.3f} mm"
        )
    for name, beside in (
        ("the product", result.wanted),
        ("with the compensated male the product", result.compensation and result.compensation.wanted),
    ):
        if beside:
            job.console.note(
                f"{name} misses the wanted thickness by {beside.worst_mm:+.3f} mm at most, {beside.rms_mm:.3f} mm rms; "
                f"{100 * beside.outside_area_fraction:.1f} % of its area by more than {beside.tolerance_mm:g} mm"
            )
    if result.compensation is not None and not result.compensation.converged:
        job.console.warn(
            f"{100 * result.compensation.unreached_area_fraction:.1f} % of the area is formed as wanted by no gap"
            if result.compensation.unreached_area_fraction > 0.0
            else f"the compensation still moves after {result.compensation.iterations} iterations"
        )
        status = NotConverged.exit_status
    # Of walls that slide along each other the nearest gap is none, however far the molds overlap.
    overlap = max(-result.gap_min_mm, -closed.clearance_hot)
    if overlap >= 0.0 and closed.case.force is None:
        at = ", ".join(f"{value:.1f}" for value in result.gap_min_at_mm)
        apart = max(closed.press.metal_contact - closed.pose.opening, -closed.clearance_hot)
        job.console.warn(
            f"the hot molds overlap by {overlap:.3f} mm at ({at}) mm: open by {apart:.3f} mm to part them"
            if overlap >= 0.0005
            else f"the hot molds touch at ({at}) mm"
        )
        status = NEGATIVE_VERDICT
    if result.border_area_fraction > 0.02:
        job.console.warn(
            f"for {100 * result.border_area_fraction:.0f} % of the male the nearest place is the female's open edge: "
            "the female does not reach over all of the male"
        )
    if case.min_spotted is not None and percent < case.min_spotted:
        job.console.warn(f"{percent:.1f} % of the molding surface touches, {case.min_spotted:g} % are asked for")
        status = NEGATIVE_VERDICT
    if case.max_pressure is not None and result.pressure_max_MPa > case.max_pressure:
        job.console.warn(f"the pressure reaches {result.pressure_max_MPa:g} MPa, {case.max_pressure:g} MPa are allowed")
        status = NEGATIVE_VERDICT
    return status
