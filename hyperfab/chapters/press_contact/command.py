"""The command as a recipe: read, place, heat, close, judge, write."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact import inputs as read
from hyperfab.chapters.press_contact.heat import Grown, grow, read_heat
from hyperfab.chapters.press_contact.result import (
    Foam,
    Told,
    curve_csv,
    design_of,
    document_of,
    grid_of,
    picture_of,
)
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.documents.foam import FoamDocument, TableFile, TableLaw
from hyperfab.documents.press import PressDocument
from hyperfab.documents.press_terms import MOST_TILT_DEG
from hyperfab.errors import UsageError
from hyperfab.io.units import quantity
from hyperfab.pressing.closing import Case, Closed, close_press
from hyperfab.pressing.growth import Expansion
from hyperfab.pressing.mold import PressFrame
from hyperfab.pressing.placement import check_roles, in_frame
from hyperfab.pressing.sandwich import Sandwich

Expansions = tuple[Expansion, Expansion]


def run(
    job: Job,
    *,
    male: str,
    female: str,
    foam: str,
    axis: str,
    gap: str | None,
    force: str | None,
    temperature: str | None,
    male_heat: str | None,
    female_heat: str | None,
    drape: str | None,
    mounted: str,
    zero: str,
    floating: bool,
    force_at: str | None,
    frame_stiffness: str | None,
    tilt: str | None,
    strokes: int,
    min_spotted: float | None,
    design_gap: str | None,
    facets: str,
    stl_unit: str,
    output: str,
) -> int:
    """Read, place, heat, close, judge, write. Returns 1 where the molds collide or too little is spotted."""
    out = job.opened(output, (".vtu", ".csv", ".png", ".design.stl"))
    wanted_gap, wanted_force = _setting(gap, force)
    _check(mounted, zero, facets, min_spotted, strokes)
    stiffness = (
        None if frame_stiffness is None else _positive(frame_stiffness, "stiffness", "--frame-stiffness")
    )
    turned = None if tilt is None else _across(tilt, axis, "angle", "--tilt", "0.05deg,0deg")
    if turned is not None and np.linalg.norm(turned) > MOST_TILT_DEG:
        raise UsageError(f"--tilt {tilt}: a press does not tilt by more than {MOST_TILT_DEG:g} deg")
    design_mm = None if design_gap is None else _positive(design_gap, "length", "--design-gap")
    place = None if force_at is None else _across(force_at, axis, "length", "--force-at", "10mm,5mm")
    if place is not None and not floating:
        raise UsageError("--force-at says where a floating mold is pushed: add --float")
    if design_mm is not None and not out.wants_files:
        raise UsageError("--design-gap writes an STL beside the document: name it with -o press.json")

    document = read.read_foam(job.inputs, foam)
    law, relaxed = read.compression_law(job, foam, document)
    fabric = read.fabric_thickness(job.inputs, foam, document)
    expansions = read.expansions(job.inputs, foam, document)
    heat = read_heat(job.inputs, temperature, (male_heat, female_heat), document.expansion.reference)
    one, two, way = read.read_molds(job, male, female, axis, stl_unit)
    uneven = read.variation(foam, document, axis, one.vertices)
    turned = read.tilt(foam, document, axis) if turned is None else turned
    if floating and turned.any():
        raise UsageError("a floating mold finds its tilt by itself: leave out --float, or the tilt")
    with job.console.progress("Closing the press") as advance:
        molds = in_frame(one, way, 1, facets == "smooth"), in_frame(two, way, -1, facets == "smooth")
        check_roles(*molds)
        growth = [
            grow(job, mold, molds[0], known, expansion, poisson, way, mounted == "flat")
            for mold, known, expansion, poisson in zip(
                molds, heat, expansions, (document.poisson.male, document.poisson.female), strict=True
            )
        ]
        lost = read.shrinkage(
            job.inputs, foam, document, 0.5 * (growth[0].temperature + growth[1].temperature)
        )
        sandwich = Sandwich(document.thickness * (1.0 - lost) * uneven, fabric, law)
        if drape is not None:
            sandwich = sandwich.thinned(read.thinning(job, drape, male, one.vertices))
        out.refuse_inputs(job.inputs)
        advance(0.3, "closing")
        case = Case(
            molds[0],
            molds[1],
            sandwich,
            growth[0].growth.at(molds[0].vertices),
            growth[1].growth.at(molds[1].vertices),
            gap=wanted_gap,
            force=wanted_force,
            zero_hot=zero == "hot",
            frame=document.press.stiffness if stiffness is None else stiffness,
            floating=floating,
            force_at=None if place is None else way.inward(place)[:2],
            tilt=read.in_plan(way, turned),
        )
        closed = close_press(case)
        _note_ranges(job, foam, document, closed, expansions, growth)
        _tell_overlap(job, closed, way)
        advance(0.6, "force over stroke")
        curve = _curve(closed, strokes)
        design = None if design_mm is None else design_of(closed, way, design_mm, growth[0].growth)
        told = Told(
            closed,
            way,
            curve,
            document.expansion.reference,
            expansions,
            (growth[0], growth[1]),
            Foam(lost, relaxed, document.shrinkage.recovery, sandwich.uneven),
            None if design is None else design[1],
        )
        job.keep(told)
        result = document_of(told)
        advance(0.8, "pictures")
        if out.wants_files:
            out.add(".vtu", grid_of(told))
            out.add(".csv", curve_csv(curve))
            out.add(".png", picture_of(told, result))
        if design is not None:
            out.add(".design.stl", design[0])
    job.write(out, result)
    return _judge(job, result, closed, min_spotted)


def _note_ranges(
    job: Job, foam: str, document: FoamDocument, case: Closed, expansions: Expansions, growth: list[Grown]
) -> None:
    """Note where the tables of foam.toml were used, beside the rows they have."""
    sandwich = case.press.sandwich
    if isinstance(document.compression, TableLaw):
        strain = sandwich.strain(case.contact.gap)
        job.ranges.used(
            "strain", strain, known=(0.0, sandwich.law.limit), source=foam, then="it counts as bottomed there"
        )
    tables = (document.expansion.male, document.expansion.female)
    for side, given, rows, grown in zip(("male", "female"), tables, expansions, growth, strict=True):
        if isinstance(given, TableFile):
            job.ranges.used(
                f"expansion.{side}", grown.temperature, known=rows.temperatures, source=foam, unit="degC"
            )


def _curve(closed: Closed, strokes: int) -> np.ndarray:
    """Force over stroke from the first touch to the answer: stroke, force, touching area, smallest gap, energy.

    The female keeps the tilt it has at the answer.
    """
    last = max(closed.stroke, 0.0)
    rows = []
    for stroke in np.linspace(0.0, last, strokes if last > 0.0 else 1):
        here = closed.press.at(replace(closed.pose, opening=closed.first_touch - stroke))
        rows.append((stroke, here.closing_force, here.pressed_area, here.gap.min(), 1e-3 * here.energy))
    return np.array(rows)


def _tell_overlap(job: Job, closed: Closed, way: PressFrame) -> None:
    """Say where and how deep the molds are drawn into each other."""
    depth = -closed.datum.gap
    if depth > 0.0:
        at = ", ".join(f"{value:.1f}" for value in way.outward(closed.datum.at))
        job.console.warn(
            f"as drawn the molds overlap by {depth:.3f} mm at ({at}) mm: they part when opened by that much, and "
            "the clearance is counted from there"
        )


def _judge(job: Job, result: PressDocument, closed: Closed, min_spotted: float | None) -> int:
    percent = 100.0 * result.contact_fraction
    job.console.note(
        f"touching {percent:.1f} % ({result.contact_area_mm2:.0f} mm2), gap {result.gap_min_mm:.3f} to "
        f"{result.gap_max_mm:.3f} mm, force {result.force_N:.4g} N"
    )
    status = 0
    if result.gap_min_mm <= 0.0 and closed.case.force is None:
        at = ", ".join(f"{value:.1f}" for value in result.gap_min_at_mm)
        apart = closed.press.metal_contact() - closed.pose.opening
        job.console.warn(
            f"the hot molds overlap by {-result.gap_min_mm:.3f} mm at ({at}) mm: open by {apart:.3f} mm to part them"
        )
        status = NEGATIVE_VERDICT
    if result.border_area_fraction > 0.02:
        job.console.warn(
            f"for {100 * result.border_area_fraction:.0f} % of the male the nearest place is the female's open edge: "
            "the female does not reach over all of the male"
        )
    if min_spotted is not None and percent < min_spotted:
        job.console.warn(f"{percent:.1f} % of the molding surface touches, {min_spotted:g} % are asked for")
        status = NEGATIVE_VERDICT
    return status


def _setting(gap: str | None, force: str | None) -> tuple[float | None, float | None]:
    if (gap is None) == (force is None):
        raise UsageError("give --gap or --force" if gap is None else "give only one of --gap and --force")
    if gap is not None:
        value = quantity(gap, "length", option="--gap")
        if value < 0.0:
            raise UsageError(f"--gap {gap}: the molds would overlap at the datum; give 0 mm or more")
        return value, None
    return None, _positive(str(force), "force", "--force")


def _positive(text: str, kind: str, option: str) -> float:
    value = quantity(text, kind, option=option)
    if value <= 0.0:
        raise UsageError(f"{option} {text}: must be greater than zero")
    return value


def _check(mounted: str, zero: str, facets: str, min_spotted: float | None, strokes: int) -> None:
    if mounted not in ("flat", "free"):
        raise UsageError(f"--mounted {mounted}: a mounting face is held flat or free to warp")
    if zero not in ("cold", "hot"):
        raise UsageError(f"--zero {zero}: the clearance is set cold or hot")
    if facets not in ("smooth", "flat"):
        raise UsageError(f"--facets {facets}: facets are taken as smooth or flat")
    if min_spotted is not None and not 0.0 <= min_spotted <= 100.0:
        raise UsageError(f"--min-spotted {min_spotted:g}: a share in percent is between 0 and 100")
    if not 2 <= strokes <= 1001:
        raise UsageError(f"--strokes {strokes}: the curve has between 2 and 1001 points")


def _across(text: str, axis: str, kind: str, option: str, example: str) -> np.ndarray:
    """Read ``--force-at 10mm,5mm``: two components across the closing axis, in the order x, y, z."""
    parts = text.split(",")
    if len(parts) != 2:
        raise UsageError(f"{option} {text}: give the two components across the axis, as {example}")
    values = [quantity(part, kind, option=option) for part in parts]
    found = np.zeros(3)
    found[[index for index, name in enumerate("xyz") if name != axis]] = values
    return found
