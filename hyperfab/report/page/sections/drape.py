"""Drape: the fabric on the mold, turnable, with a switch among its fields; the energy on the way to equilibrium."""

from __future__ import annotations

from typing import Any

from hyperfab.report.bands import banded, greatest_stretch
from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import (
    Cell,
    Figure,
    Section,
    Source,
    asked,
    columns,
    computed,
    coordinates,
    facts,
    floats,
    number,
    word,
)
from hyperfab.report.page.scenes import Field, views

_FIELDS = (
    Field("stretch_larger", "larger stretch"),
    Field("stretch_warp", "stretch along warp"),
    Field("stretch_weft", "stretch along weft"),
    Field("stress_warp_MPa", "stress along warp", "MPa"),
    Field("stress_weft_MPa", "stress along weft", "MPa"),
    Field("thickness_mm", "thickness", "mm", "Cividis"),
    Field("slack", "slack", "", "marks", ends=(0.0, 1.0), words=("taut", "slack")),
    Field("contact", "contact with the mold", "", "marks", ends=(0.0, 1.0), words=("free", "touches")),
    Field("shear_deg", "shear angle", "deg"),
)


def section(source: Source) -> Section:
    """Return the section of a drape document."""
    data = source.data
    stretch, along = greatest_stretch(data)
    found = Section("", *_verdict(data))
    found.parts += views(
        source, "The draped fabric.", "The net of the fabric over the mold, coloured by a field.", _FIELDS
    )
    found.parts.append(
        facts(
            "Figures of the draped fabric",
            [
                ("greatest stretch", number(stretch)),
                ("there, on the flat sheet", _place(data, "flat")),
                ("there, draped", _place(data, "draped")),
                ("force of the press", number(data["force_N"], "N")),
                ("greatest stress along warp", number(data["stress_warp_max_MPa"], "MPa")),
                ("greatest stress along weft", number(data["stress_weft_max_MPa"], "MPa")),
                ("thinnest place", number(data["thickness_min_mm"], "mm")),
                ("nodes on the mold", number(data["contact_nodes"])),
                *([("springs on its edges", number(data["contact_edges"]))] if data.get("contact_edges") else []),
                (f"slack {_pieces(data)}", number(data["slack_springs"])),
                ("deepest inside the mold", number(data["penetration_max_mm"], "mm", 2)),
                ("strain energy", number(data["energy_J"], "J")),
            ],
        )
    )
    most = number(100.0 * (stretch - 1.0), "%", 2).text
    found.figures = [
        Figure(most, f"greatest stretch{along}"),
        Figure(banded(data, "thickness_min_mm", "mm", form=".2g"), "thinnest place of the fabric"),
    ]
    if data["converged"]:
        found.claim = f"the draped fabric stretches by {most} at most"
    found.parts += _on_the_way(data)
    table = columns(source.sibling(".csv"), source.name)
    if {"iteration", "energy_J"} <= set(table):
        energy = floats(table["energy_J"])
        sizes = [f"{x} x {y}" for x, y in zip(table.get("nodes_x", []), table.get("nodes_y", []), strict=False)]
        traces = [
            line(f"grid of {size}", *_of_size(energy, sizes, size), colour)
            for colour, size in enumerate(dict.fromkeys(sizes))
        ] or [line("energy", list(range(len(energy))), energy)]
        found.parts.append(
            chart(
                "Energy of the net on its way to equilibrium, coarse grids first.",
                f"The energy falls to {number(data['energy_J'], 'J').text}.",
                "step",
                "energy, J",
                traces,
            )
        )
    found.parts += asked(data)
    found.parts.append(
        computed(
            ("unbalanced force, relative", number(data["residual_relative"], "", 2)),
            ("steps", number(data["iterations"])),
        )
    )
    return found


def _place(data: Any, which: str) -> Cell | None:
    at = (data.get("stretch_max_at_mm") or {}).get(which)
    return None if at is None else word(f"{coordinates(at)} mm")


def _on_the_way(data: Any) -> list[Any]:
    """The force against the depth, and what friction took, where the document has them."""
    parts: list[Any] = []
    curve = data.get("force_depth")
    if curve:
        depth, force = [0.0, *(row[0] for row in curve)], [0.0, *(row[1] for row in curve)]
        parts.append(
            chart(
                "Force of the press at each depth asked for.",
                f"{number(force[-1], 'N').text} at {number(depth[-1], 'mm').text}.",
                "depth, mm",
                "force, N",
                [line("force of the press", depth, force)],
            )
        )
    rubbing = data.get("rubbing")
    if rubbing:
        rows = [
            ("work of the press", number(rubbing["work_J"], "J")),
            ("rubbed away on the mold", number(rubbing["rubbed_J"], "J")),
            ("taken by the blank holder", number(rubbing["drawn_J"], "J")),
            ("unaccounted for, relative", number(rubbing["balance_relative"])),
            ("nodes that slide", number(rubbing["sliding_nodes"])),
            ("nodes that stick", number(rubbing["sticking_nodes"])),
        ]
        if data.get("friction"):
            rows.insert(0, ("coefficient of friction", number(data["friction"])))
        for edge, way in (data.get("draw_in_mm") or {}).items():
            rows.append((f"edge {edge} drawn in", number(way, "mm")))
        parts.append(facts("Friction on the way there", rows))
    return parts


def _pieces(data: Any) -> str:
    """What a sheet is made of: springs, or cells of a membrane."""
    return "springs" if data.get("sheet", "net") == "net" else "cells"


def _verdict(data: Any) -> tuple[bool | None, str]:
    if not data["converged"]:
        return False, f"No equilibrium: {data.get('status', 'not converged')}."
    stretch, along = greatest_stretch(data)
    slack, edges = data["slack_springs"], data.get("contact_edges")
    on_edges = f" and {number(edges).text} springs run over its edges" if edges else ""
    return True, (
        f"In equilibrium on the mold: stretched to {number(stretch, '', 4).text} at most{along}; "
        f"{number(data['contact_nodes']).text} nodes touch{on_edges}, "
        f"{'none of its ' if slack == 0 else f'{slack} '}{_pieces(data)} are slack, "
        f"thinnest place {number(data['thickness_min_mm'], 'mm', 3).text}."
    )


def _of_size(energy: Any, sizes: list[str], size: str) -> tuple[list[float], list[float | None]]:
    rows = [row for row, own in enumerate(sizes) if own == size]
    return [float(row) for row in rows], [energy[row] for row in rows]
