"""Drape: the fabric on the mold, turnable, with a switch among its fields; the energy on the way to equilibrium."""

from __future__ import annotations

from typing import Any

from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import Section, Source, columns, facts, floats, number
from hyperfab.report.page.scenes import Field, views

_FIELDS = (
    Field("stress_warp_MPa", "stress along warp", "MPa"),
    Field("stress_weft_MPa", "stress along weft", "MPa"),
    Field("thickness_mm", "thickness", "mm", "Cividis"),
    Field("slack", "slack", "", "marks"),
    Field("contact", "contact with the mold", "", "marks"),
    Field("shear_deg", "shear angle", "deg"),
)


def section(source: Source) -> Section:
    """Return the section of a drape document."""
    data = source.data
    found = Section("", *_verdict(data))
    found.parts += views(
        source, "The draped fabric.", "The net of the fabric over the mold, coloured by a field.", _FIELDS
    )
    found.parts.append(
        facts(
            "Figures of the draped fabric",
            [
                ("force of the press", number(data["force_N"], "N")),
                ("greatest stress along warp", number(data["stress_warp_max_MPa"], "MPa")),
                ("greatest stress along weft", number(data["stress_weft_max_MPa"], "MPa")),
                ("thinnest place", number(data["thickness_min_mm"], "mm")),
                ("nodes on the mold", number(data["contact_nodes"])),
                ("slack springs", number(data["slack_springs"])),
                ("deepest penetration", number(data["penetration_max_mm"], "mm")),
                ("energy of the springs", number(data["energy_J"], "J")),
                ("unbalanced force, relative", number(data["residual_relative"])),
                ("steps", number(data["iterations"])),
            ],
        )
    )
    table = columns(source.sibling(".csv"), source.name)
    if {"iteration", "energy_J"} <= set(table):
        energy = floats(table["energy_J"])
        sizes = [
            f"{x} x {y}" for x, y in zip(table.get("nodes_x", []), table.get("nodes_y", []), strict=False)
        ]
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
    found.notes += [f"Left out: {text}." for text in data.get("left_out", [])]
    return found


def _verdict(data: Any) -> tuple[bool | None, str]:
    if not data["converged"]:
        return False, f"No equilibrium: {data.get('status', 'not converged')}."
    slack = data["slack_springs"]
    return True, (
        f"In equilibrium on the mold: {number(data['contact_nodes']).text} nodes touch, "
        f"{'no spring is' if slack == 0 else f'{slack} springs are'} slack, "
        f"thinnest place {number(data['thickness_min_mm'], 'mm', 3).text}."
    )


def _of_size(energy: Any, sizes: list[str], size: str) -> tuple[list[float], list[float | None]]:
    rows = [row for row, own in enumerate(sizes) if own == size]
    return [float(row) for row in rows], [energy[row] for row in rows]
