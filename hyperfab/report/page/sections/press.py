"""Press: where the molds touch (the blue spots), how hard, the spread of the gap, and what to change."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from hyperfab.report.bands import banded
from hyperfab.report.page.charts import bars, chart, line
from hyperfab.report.page.parts import (
    Figure,
    Section,
    Source,
    Table,
    asked,
    coordinates,
    facts,
    number,
    percent,
    word,
)
from hyperfab.report.page.scenes import Field, views

#: The molds are said to fit where at least this part of the molding surface touches.
ENOUGH = 0.95
#: Regions told one by one.
MAX_REGIONS = 8

_FIELDS = (
    Field("contact", "blue spots: contact", "", "marks", ends=(0.0, 1.0), words=("open", "touches")),
    Field("pressure_MPa", "pressure", "MPa"),
    Field("gap_mm", "gap", "mm", "Cividis"),
    Field("compression", "compression of the foam"),
)


def section(source: Source) -> Section:
    """Return the section of a press document."""
    data = source.data
    found = Section("", *_verdict(data))
    # A mold that has grown is not at the temperature it was drawn at.
    hot = ", hot" if any((data.get(mold) or {}).get("growth_strain") for mold in ("male", "female")) else ""
    share = banded(data, "contact_fraction", "%", 100.0, ".3g")
    found.figures = [
        Figure(share, "of the molding surface touches"),
        Figure(banded(data, "force_N", "N", form=".3g"), "closing force"),
        Figure(banded(data, "pressure_max_MPa", "kPa", 1000.0, ".2g"), "greatest pressure"),
    ]
    if data["converged"]:
        found.claim = f"{share} of the molding surface touches under {banded(data, 'force_N', 'N', form='.3g')}"
    found.parts += views(
        source, "The male mold, as blue paint would show it.", "The male mold coloured by contact.", _FIELDS
    )
    found.parts.append(
        facts(
            "Figures of the closed press",
            [
                ("touching part of the molding surface", percent(data["contact_fraction"])),
                ("touching area", number(data["contact_area_mm2"], "mm²")),
                ("closing force", number(data["force_N"], "N")),
                ("greatest pressure", number(1000.0 * data["pressure_max_MPa"], "kPa")),
                (f"least gap{hot}", number(data["gap_min_mm"], "mm")),
                (f"mean gap{hot}", number(data["gap_mean_mm"], "mm")),
                (f"greatest gap{hot}", number(data["gap_max_mm"], "mm")),
                ("stroke from the first touch", number(data["stroke_mm"], "mm")),
                ("tilt", number(data["tilt_deg"], "°")),
            ],
        )
    )
    histogram = data.get("histogram") or {}
    if histogram.get("area_mm2"):
        edges = histogram["edges_mm"]
        middles = [(low + high) / 2 for low, high in pairwise(edges)]
        found.parts.append(
            chart(
                "How much of the surface has which gap. An even press has one narrow peak.",
                f"Histogram of the gap from {number(edges[0], 'mm').text} to {number(edges[-1], 'mm').text}.",
                "gap, mm",
                "area, mm²",
                [bars("area", middles, histogram["area_mm2"])],
                bargap=0.05,
            )
        )
    if data.get("force_stroke"):
        pairs = data["force_stroke"]
        found.parts.append(
            chart(
                "Closing force against the stroke from the first touch.",
                f"The force rises to {number(pairs[-1][1], 'N').text}.",
                "stroke, mm",
                "force, N",
                [line("force", [pair[0] for pair in pairs], [pair[1] for pair in pairs])],
            )
        )
    found.parts.append(_regions(data["regions"]))
    if data.get("sensitivity"):
        found.parts.append(_changes(data["sensitivity"]))
    found.parts += asked(data)
    return found


def _verdict(data: Any) -> tuple[bool | None, str]:
    share = f"{number(100 * data['contact_fraction'], '%', 3).text} of the molding surface touches"
    if not data["converged"]:
        return False, f"Not converged: {data.get('status', '')}."
    if (data.get("states") or {}).get("interfering_mm2", 0.0) > 0.0 or data["gap_min_mm"] < 0.0:
        return False, f"Metal meets metal: open the press or take the mold down there. {share}."
    if data["contact_fraction"] >= ENOUGH:
        return True, f"{share}, under {number(data['force_N'], 'N', 3).text}."
    sandwich = data.get("sandwich_mm")
    if sandwich is None:
        return False, f"Only {share}."
    lacking = data["gap_max_mm"] - sandwich
    return False, (
        f"Only {share}: the widest gap is {number(data['gap_max_mm'], 'mm', 3).text}, the sandwich "
        f"{number(sandwich, 'mm', 3).text} thick. Foam thicker by {number(lacking, 'mm', 2).text}, or that much less "
        "gap there, would close it."
    )


def _regions(regions: list[Any]) -> Table:
    rows = [
        [
            word("touching" if region["contact"] else "open"),
            number(region["area_mm2"], "mm²"),
            word(coordinates(region["centroid_mm"])),
            number(region["gap_mean_mm"], "mm"),
            number(1000.0 * region["pressure_mean_MPa"], "kPa", 3),
        ]
        for region in sorted(regions, key=lambda region: -region["area_mm2"])[:MAX_REGIONS]
    ]
    more = len(regions) - len(rows)
    caption = "Regions of the male surface" + (f" (the {MAX_REGIONS} largest; {more} more)" if more > 0 else "")
    return Table(caption, ["state", "area", "centre x, y, z in mm", "mean gap", "mean pressure"], rows)


def _changes(changes: list[Any]) -> Table:
    rows = [
        [
            word(change["change"]),
            number(change.get("typical_step"), change.get("unit", "")),
            number(change.get("gap_rms_at_step_mm"), "mm"),
            number(change.get("closest_gap_mm_per_unit"), f"mm per {change.get('unit', '')}"),
        ]
        for change in changes
    ]
    return Table(
        "What to change: the strongest first",
        ["change", "by", "moves the gap by (rms)", "the least gap by"],
        rows,
    )
