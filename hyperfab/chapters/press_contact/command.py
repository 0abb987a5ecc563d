"""The command as a recipe: read, place, heat, close, judge, write."""

from __future__ import annotations

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact import inputs as read
from hyperfab.chapters.press_contact.inputs import Heating
from hyperfab.chapters.press_contact.result import Told, curve_csv, document_of, grid_of, picture_of
from hyperfab.console import NEGATIVE_VERDICT
from hyperfab.documents.press import PressDocument
from hyperfab.errors import UsageError
from hyperfab.io.output import Output
from hyperfab.io.units import quantity
from hyperfab.pressing.closing import Case, Closed, close_press
from hyperfab.pressing.growth import Expansion, uniform_growth
from hyperfab.pressing.placement import check_roles, in_frame
from hyperfab.pressing.sandwich import Sandwich

#: Points of the force-stroke curve, from the first touch to the answer.
CURVE_POINTS = 21


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
    zero: str,
    min_spotted: float | None,
    facets: str,
    stl_unit: str,
    output: str,
) -> int:
    """Read, place, heat, close, judge, write. Returns 1 where the molds collide or too little is spotted."""
    out = Output(output, (".vtu", ".csv", ".png"))
    wanted_gap, wanted_force = _setting(gap, force)
    if zero not in ("cold", "hot"):
        raise UsageError(f"--zero {zero}: the clearance is set cold or hot")
    if facets not in ("smooth", "flat"):
        raise UsageError(f"--facets {facets}: facets are taken as smooth or flat")
    if min_spotted is not None and not 0.0 <= min_spotted <= 100.0:
        raise UsageError(f"--min-spotted {min_spotted:g}: a share in percent is between 0 and 100")

    document = read.read_foam(job.inputs, foam)
    law = read.compression_law(job.inputs, foam, document)
    sandwich = Sandwich(document.thickness, read.fabric_thickness(job.inputs, foam, document), law)
    expansions = read.expansions(job.inputs, foam, document)
    reference = document.expansion.reference
    heatings = read.heatings(job.inputs, temperature, male_heat, female_heat, reference)
    one, two, frame = read.read_molds(job, male, female, axis, stl_unit)
    if drape is not None:
        sandwich = sandwich.thinned(read.thinning(job, drape, male, one.vertices))
    out.refuse_inputs(job.inputs)

    with job.console.progress("Closing the press") as advance:
        smooth = facets == "smooth"
        male_mold, female_mold = in_frame(one, frame, 1, smooth), in_frame(two, frame, -1, smooth)
        check_roles(male_mold, female_mold)
        case = Case(
            male_mold,
            female_mold,
            sandwich,
            *uniform_growth(male_mold, female_mold, *_strains(expansions, heatings)),
            wanted_gap,
            wanted_force,
            zero == "hot",
        )
        closed = close_press(case)
        advance(0.5, "force over stroke")
        curve = _curve(closed)
        advance(0.8, "writing")
        told = Told(closed, frame, curve, reference, expansions, heatings, drape is not None)
        result = document_of(told)
        if out.wants_files:
            out.add(".vtu", grid_of(told))
            out.add(".csv", curve_csv(curve))
            out.add(".png", picture_of(told, result))
    job.write(out, result)
    return _judge(job, result, closed, min_spotted)


def _strains(
    expansions: tuple[Expansion, Expansion], heatings: tuple[Heating, Heating]
) -> tuple[float, float]:
    male, female = (float(e.strain(h.temperature)) for e, h in zip(expansions, heatings, strict=True))
    return male, female


def _curve(closed: Closed) -> np.ndarray:
    """Force over stroke from the first touch to the answer: stroke, force, touching area, smallest gap, energy."""
    last = max(closed.stroke, 0.0)
    rows = []
    for stroke in np.linspace(0.0, last, CURVE_POINTS if last > 0.0 else 1):
        here = closed.press.at(closed.first_touch - stroke)
        rows.append((stroke, here.closing_force, here.pressed_area, here.gap.min(), 1e-3 * here.energy))
    return np.array(rows)


def _judge(job: Job, result: PressDocument, closed: Closed, min_spotted: float | None) -> int:
    percent = 100.0 * result.contact_fraction
    job.console.note(
        f"touching {percent:.1f} % ({result.contact_area_mm2:.0f} mm2), gap {result.gap_min_mm:.3f} to "
        f"{result.gap_max_mm:.3f} mm, force {result.force_N:.4g} N"
    )
    status = 0
    if result.gap_min_mm <= 0.0 and closed.case.force is None:
        at = ", ".join(f"{value:.1f}" for value in result.gap_min_at_mm)
        apart = closed.press.metal_contact() - closed.opening
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
    value = quantity(force, "force", option="--force")
    if value <= 0.0:
        raise UsageError(f"--force {force}: a closing force is greater than zero")
    return None, value
