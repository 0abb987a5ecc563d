"""``hf summary``: one screen about a set of documents, in words and rounded figures."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from hyperfab.cases.about import SummaryCase
from hyperfab.chapters.job import Job
from hyperfab.documents.base import document_class, parse_document, stated_kind
from hyperfab.errors import InputError
from hyperfab.io.json_io import load_json
from hyperfab.io.output import write_stdout
from hyperfab.report.bands import banded, constant, evenness, greatest_stretch, made_of, warmup

Plain = Mapping[str, Any]


def run(job: Job, case: SummaryCase) -> int:
    """Print a paragraph for each document; InputError where one is not a document of a known kind."""
    lines: list[str] = []
    for name in case.documents:
        loaded = load_json(job.inputs.read(name), name)
        kind = _kind(loaded, name)
        data = parse_document(loaded, name, document_class(kind)).to_json()
        job.ranges.taken(name, data)
        lines.append(f"{name} ({kind})")
        lines += [f"  {line}" for line in paragraph(data)]
        pictures = [job.inputs.beside(name, file) for file in data.get("files", []) if file.endswith(".png")]
        lines += [f"  picture: {picture}" for picture in pictures if os.path.exists(picture)]
    write_stdout(("\n".join(lines) + "\n").encode())
    job.judge_ranges()
    return 0


def paragraph(data: Plain) -> list[str]:
    """Return what the document ``data`` says, a few lines."""
    return [*_PARAGRAPHS[_kind(data, "-")](data), *made_of(data)]


def _kind(loaded: object, name: str) -> str:
    kind = stated_kind(loaded)
    if kind not in _PARAGRAPHS:
        raise InputError(
            "is not a document hf sums up",
            file=name,
            key="format",
            remedy=f"the kinds are {', '.join(_PARAGRAPHS)}",
        )
    return kind


def _material(data: Plain) -> Iterator[str]:
    # One law of the whole sheet is the same along all ways.
    sheet = data["model"] == "orthotropic"
    fits = {"": data} if sheet else data.get("directions") or {"": data}
    for direction, part in fits.items():
        fit = part.get("fit")
        constants = _constants(part["parameters"], fit or {})
        label = f"{direction}: " if direction else ""
        if fit is None:  # written by hand
            yield f"{label}{data['model']}: {constants}"
            continue
        yield f"{label}{data['model']}: {constants}; {_misfit(data, fit)} over {fit['points']} points"
        for test, figures in fit["tests"].items():
            if figures.get("predicted"):
                yield f"{label}{test} test, not used in the fit: {_misfit(data, figures)}"
    if "accepted" in data:
        yield "accepted" if data["accepted"] else "not accepted"


def _constants(values: Plain, fit: Plain) -> str:
    """Return constants with their standard deviations, where those are known, and what these are of."""
    sd = fit.get("parameters_sd") or {}
    told = ", ".join(
        f"{name} {constant(value, sd[name]) if name in sd else format(value, '.5g')}" for name, value in values.items()
    )
    alone = (fit.get("uncertainty") or {}).get("source") in ("readings", "stated")
    return f"{told} (± one sd of the readings alone)" if sd and alone else told


def _misfit(data: Plain, figures: Plain) -> str:
    """Return the figure that the fit was judged by."""
    if data.get("objective") == "absolute":
        return f"rms error {100.0 * figures['nrmse']:.1f} % of the largest stress"
    return f"relative rms {figures['relative_rms']:.3f}"


def _contact(data: Plain) -> Iterator[str]:
    if data["converged"]:
        yield (
            f"force {banded(data, 'force_N', 'N')}, contact radius {banded(data, 'contact_radius_mm', 'mm')}, "
            f"stretch up to {banded(data, 'stretch_max', form='.3f')}, "
            f"stress up to {banded(data, 'stress_max_MPa', 'MPa', form='.3g')}"
        )
    else:
        yield f"not converged: {data['status']}"
    if "stress_difference_percent" in data:
        yield (
            f"against the other constants: stress differs by {data['stress_difference_percent']:.1f} %, "
            f"force ratio {data['force_ratio']:.3f}"
        )


def _drape(data: Plain) -> Iterator[str]:
    state = "equilibrium" if data["converged"] else "no equilibrium"
    edges = f" and {data['contact_edges']} springs on its edges" if data.get("contact_edges") else ""
    most, along = greatest_stretch(data)
    at = (data.get("stretch_max_at_mm") or {}).get("flat")
    where = f" at ({at[0]:.0f}, {at[1]:.0f}) mm of the flat sheet" if at else ""
    slack = "slack springs" if data.get("sheet", "net") == "net" else "cells wrinkled or slack"
    yield f"stretched to {most:.3f} at most{along}{where}"
    yield (
        f"{state}: {data['contact_nodes']} nodes on the mold{edges}, press force {banded(data, 'force_N', 'N')}, "
        f"thinnest {banded(data, 'thickness_min_mm', 'mm', form='.3f')}, {data['slack_springs']} {slack}"
    )
    yield (
        f"stress up to {banded(data, 'stress_warp_max_MPa', 'MPa', form='.3g')} (warp), "
        f"{banded(data, 'stress_weft_max_MPa', 'MPa', form='.3g')} (weft); "
        f"residual {data['residual_relative']:.1e}, deepest penetration {data['penetration_max_mm']:.2g} mm"
    )


def _heat(data: Plain) -> Iterator[str]:
    if "warmup_time_s" in data:
        yield f"warm-up in {warmup(data)}"
    surface = data.get("work_surface", {})
    for moment, words in (("at_warmup", "at warm-up"), ("at_end", "at the end")):
        figures = surface.get(moment)
        if figures is not None and (moment == "at_warmup" or figures != surface.get("at_warmup")):
            even = evenness(data, figures["spread_K"])
            yield f"work surface {words}: {figures['mean_degC']:.1f} degC, even to {even}"
    mass = f"mass {data['mass_kg']:.1f} kg"
    if "supplied_J" in data["energy"]:
        yield (
            f"energy {banded(data, 'energy.supplied_J', 'MJ', 1e-6, '.2f')}, "
            f"lost {banded(data, 'energy.lost_J', 'MJ', 1e-6, '.2f')}, {mass}"
        )
    else:  # a steady state takes no time
        power = data.get("power_supplied_W")
        yield f"steady state, {mass}" if power is None else f"steady state on {power:.4g} W, {mass}"


def _press(data: Plain) -> Iterator[str]:
    flange = " with the flange" if data.get("flange_area_mm2") else ""
    yield (
        f"the molds touch on {banded(data, 'contact_fraction', '%', 100.0, '.1f')} of the molding surface "
        f"({banded(data, 'contact_area_mm2', 'mm2', form='.0f')}{flange}), "
        f"force {banded(data, 'force_N', 'N')}, pressure up to {banded(data, 'pressure_max_MPa', 'kPa', 1e3, '.3g')}"
    )
    warm = " and ".join(dict.fromkeys(f"{data[mold]['temperature_degC']:.4g}" for mold in ("male", "female")))
    least, mean, most = (banded(data, f"gap_{which}_mm", "mm", form=".2f") for which in ("min", "mean", "max"))
    yield f"gap at {warm} degC {least} to {most}, mean {mean}"
    for change in (data.get("sensitivity") or [])[:3]:
        step = f"{change['typical_step']:g} {change.get('unit', '')}".strip()
        yield f"{change['change']} by {step} moves the gap by {change['gap_rms_at_step_mm']:.2g} mm"


def _loop(data: Plain) -> Iterator[str]:
    yield f"verdict: {data['verdict']}"
    yield from data["summary"]
    if "next_measurement" in data:
        yield f"measure next: {data['next_measurement']['text']}"


def _sweep(data: Plain) -> Iterator[str]:
    failed = sum(count for status, count in data["by_status"].items() if status not in ("0", "1"))
    yield f"{data['name']}: {data['cases']} cases, {failed} failed; table {data['table']}"
    if "within_limits" in data:
        yield f"{data['within_limits']} cases keep to the limits"
    if data.get("idle"):
        yield f"along {', '.join(data['idle'])} every case finds the same"
    best = data.get("best", {})
    for name, sense in (data.get("senses") or dict.fromkeys(best, "least")).items():
        if name not in best:
            continue
        row = best[name]
        shown = ", ".join(
            f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()
        )
        yield f"{sense} {name}: {shown}"


_PARAGRAPHS: dict[str, Callable[[Plain], Iterator[str]]] = {
    "material": _material,
    "contact": _contact,
    "drape": _drape,
    "heat": _heat,
    "press": _press,
    "loop": _loop,
    "sweep": _sweep,
}
