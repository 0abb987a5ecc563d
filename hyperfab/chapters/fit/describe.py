"""Results of a fit as the parts of a material document, and as a table for a person."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting
from hyperfab.chapters.fit.judge import Judged
from hyperfab.chapters.fit.readings import Readings
from hyperfab.documents.certainty import FitUncertainty, ScatterPart
from hyperfab.documents.material import (
    AtTemperature,
    Direction,
    FitFigures,
    MaterialDocument,
    ModelRow,
    StablePlane,
    StableRange,
    Tested,
    TestFigures,
    Unpredicted,
)
from hyperfab.materials.identification.quality import Certainty, Figures
from hyperfab.materials.modes import way
from hyperfab.materials.stability import stable_plane
from hyperfab.report.bands import constant

Reach = Mapping[str, tuple[float, float]]


def fit_figures(found: Identified, reach: Reach) -> FitFigures:
    """Return the figures of a fit, test by test."""
    tests: dict[str, TestFigures | Unpredicted] = {}
    for mode, (figures, points, predicted) in found.tests.items():
        flag = True if predicted else None
        if figures is None or not math.isfinite(figures.E2):
            status = "the test reaches beyond the limiting stretch of the law"
            tests[mode] = Unpredicted(points=points, predicted=flag, status=status)
        else:
            low, high = reach.get(way(mode), (None, None))
            tests[mode] = TestFigures(**vars(figures), stretch_min=low, stretch_max=high, predicted=flag)
    return with_certainty(FitFigures(**vars(found.total), tests=tests), found.certainty, found.specimens)


def with_certainty(figures: FitFigures, sure: Certainty, specimens: int) -> FitFigures:
    """Return the figures with how sure the constants are that so many ``specimens`` told."""
    figures.parameters_sd = deviations(sure)
    figures.uncertainty = uncertainty(sure, specimens)
    if np.isfinite(sure.correlation).all():
        figures.correlation = sure.correlation.tolist()
    if math.isfinite(sure.condition_number):
        figures.condition_number = sure.condition_number
    return figures


def document_of(readings: Readings, setting: Setting, **own: Any) -> MaterialDocument:
    """Return the material document of any law: what it says of tests and setting, and the law's ``own`` keys."""
    bulk = readings.bulk_figures
    if bulk is not None:  # no law of a sheet takes part in that; that of a foam has figures of its own there
        ratio = np.concatenate([test.stretch for test in readings.volumetric])
        low, high = min(1.0, float(ratio.min())), max(1.0, float(ratio.max()))
        own["fit"].tests.setdefault("volumetric", TestFigures(**vars(bulk), stretch_min=low, stretch_max=high))
    return MaterialDocument(
        thickness_mm=readings.thickness,
        thickness_nominal=readings.nominal or None,
        objective="relative" if setting.relative else "absolute",
        accepted_by="relative_rms" if setting.relative else "nrmse",
        fit_on=list(setting.fit_on),
        left_out=dict(sorted(readings.left_out.items())) or None,
        preparation=readings.preparation or None,
        bulk_modulus_MPa=readings.bulk_modulus,
        effects=[],
        **own,
    )


def uncertainty(sure: Certainty, specimens: int) -> FitUncertainty:
    """Return how sure the constants are, and what that is known from."""
    one = sure.scatter
    return FitUncertainty(
        order=list(sure.names),
        covariance=sure.covariance.tolist() if np.isfinite(sure.covariance).all() else None,
        specimens=specimens if one is None else one.specimens,
        degrees_of_freedom=0 if one is None else one.freedom,
        source="specimens" if one is not None else "stated" if sure.stated else "readings",
        parts=None
        if one is None or len(one.parts) < 2
        else [ScatterPart(covariance=part.tolist(), degrees_of_freedom=freedom) for part, freedom in one.parts],
    )


def stability(found: Identified, reach: Reach) -> dict[str, StableRange]:
    """Return the stable range of each mode, and whether it covers the data."""
    described = {}
    for mode, stable in found.ranges.items():
        covers = None
        if mode in reach:
            low, high = reach[mode]
            covers = stable.low <= low + 1e-9 and stable.high >= high - 1e-9
        described[mode] = StableRange(
            stretch_min=stable.low,
            stretch_max=stable.high,
            ended_by=stable.ended_by,
            first_unstable_stretch=stable.first_unstable,
            stable_over_data=covers,
        )
    return described


def plane(found: Identified, reach: Reach, wanted: bool) -> StablePlane | None:
    """Return the stability over the plane of both stretches, up to the largest stretch of the tests."""
    if not wanted or not reach:
        return None
    high = max(high for _, high in reach.values())
    seen = stable_plane(found.material, high**-0.5, high)
    first = None if seen.first_unstable is None else list(seen.first_unstable)
    return StablePlane(
        stretch_min=seen.low,
        stretch_max=seen.high,
        stable_fraction=seen.stable_fraction,
        first_unstable_stretches=first,
    )


def temperatures(found: Identified) -> list[AtTemperature] | None:
    """Return the constants against temperature, None where there is one temperature or none."""
    if len(found.materials) < 2:
        return None
    return [
        AtTemperature(
            temperature_degC=temperature,
            parameters=material.parameters,
            fit=None
            if figures is None
            else FitFigures(
                **vars(figures), parameters_sd=deviations(sure), uncertainty=uncertainty(sure, found.specimens)
            ),
        )
        for temperature, material, figures, sure in zip(
            found.temperatures, found.materials, found.per_temperature, found.certainties, strict=True
        )
        if temperature is not None
    ]


def deviations(sure: Certainty) -> dict[str, float] | None:
    """Return the standard deviations that are known, None where none is."""
    known = zip(sure.names, sure.sd, strict=True)
    return {name: float(value) for name, value in known if math.isfinite(value)} or None


def direction(
    found: Identified, fit: FitFigures, reach: Reach, with_plane: bool, tested: dict[str, Tested] | None
) -> Direction:
    """Return one direction of the fabric."""
    return Direction(
        parameters=found.material.parameters,
        fit=fit,
        stability=stability(found, reach),
        stability_plane=plane(found, reach, with_plane),
        stable=found.stable,
        temperatures=temperatures(found),
        tested=tested,
    )


def model_row(one: Judged, reach: Reach) -> ModelRow:
    """Return a law's row in the table of all."""
    found = one.failure or one.results[None]
    if isinstance(found, str):
        return ModelRow(model=one.law.name, status=found, accepted=False)
    return ModelRow(
        model=one.law.name,
        E2=found.total.E2,
        relative_rms=found.total.relative_rms,
        parameters=found.material.parameters,
        fit=fit_figures(found, reach),
        stability=stability(found, reach),
        carry_over=one.carry_over if math.isfinite(one.carry_over) else None,
        stable=one.stable,
        accepted=one.accepted,
    )


def figures_cells(figures: Figures | None) -> list[str]:
    """Return E2, relative rms and NRMSE for the table, dashes where there are none."""
    if figures is None or not math.isfinite(figures.E2):
        return ["-", "-", "-"]
    return [f"{figures.E2:.6g}", f"{figures.relative_rms:.4g}", f"{figures.nrmse:.4g}"]


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a plain table: the first column left-aligned, the others right-aligned.

    >>> print(table(["model", "E2"], [["gent", "1.5"]]))
    model   E2
    gent   1.5
    """
    widths = [max(len(row[k]) for row in [columns, *rows]) for k in range(len(columns))]
    lines = []
    for row in [columns, *rows]:
        cells = [
            row[0].ljust(widths[0]),
            *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)),
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def parameters_line(found: Identified) -> str:
    """Return the constants in one line, with their standard deviations where known."""
    parts = []
    for name, value, sd in zip(
        found.certainty.names, found.material.parameters.values(), found.certainty.sd, strict=True
    ):
        parts.append(f"{name} {constant(value, sd if math.isfinite(sd) else 0.0)}")
    return ", ".join(parts)
