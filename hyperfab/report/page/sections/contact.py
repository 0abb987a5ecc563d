"""The sheet on the sphere or punch: force against depth, A against B, the stress on the sheet."""

from __future__ import annotations

from typing import Any

from hyperfab.report.bands import banded
from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import Figure, Section, Source, asked, computed, facts, known, number, percent
from hyperfab.report.page.scenes import Field, views

_FIELDS = (
    Field("stress_1_MPa", "greatest principal stress", "MPa"),
    Field("stress_difference_MPa", "difference of B from A", "MPa", "Cividis"),
    Field("stretch_1", "greatest stretch"),
    Field("thickness_mm", "thickness", "mm", "Cividis"),
    Field("contact", "contact", "", "marks", ends=(0.0, 1.0), words=("free", "touches")),
)


def section(source: Source) -> Section:
    """Return the section of a contact document."""
    data = source.data
    found = Section("", *_verdict(data))
    stability = data.get("stability") or {}
    other = data.get("against")
    found.parts.append(
        facts(
            "Figures at the full depth" if data["converged"] else "Figures at the depth that was reached",
            [
                ("press force", number(data.get("force_N"), "N")),
                ("press force with the constants of B", number(other.get("force_N"), "N") if other else None),
                ("contact radius", number(data.get("contact_radius_mm"), "mm")),
                ("greatest stretch", number(data.get("stretch_max"))),
                ("greatest stress (Cauchy)", number(data.get("stress_max_MPa"), "MPa")),
                ("energy in the sheet", number(data.get("energy_J"), "J")),
                ("wrinkled part of the area", percent(data.get("wrinkled_area_fraction"))),
                ("constants stable where used", number(stability.get("stable"))),
                ("stress of B differs from A by", known(data, "stress_difference_percent", "%")),
                ("force of A over force of B", known(data, "force_ratio")),
            ],
        )
    )
    found.figures = [
        Figure(_force(data), f"force on the {_punch(data)}"),
        Figure(number(data.get("stretch_max"), "", 4).text, "greatest stretch of the sheet"),
    ]
    if data["converged"]:
        found.claim = f"{_force(data)} push the {_punch(data)} into the sheet"
    traces = [line("A", *_curve(data["force_depth"]), 0)]
    if other and other.get("force_depth"):
        traces.append(line("B", *_curve(other["force_depth"]), 1, dash="dash"))
    found.parts.append(
        chart(
            f"Force on the {_punch(data)} against its depth"
            + (", with the constants of A and of B." if other else "."),
            f"The force rises to {number(data.get('force_N'), 'N').text} at the last depth.",
            "depth, mm",
            "force, N",
            traces,
        )
    )
    found.parts += views(
        source,
        "The pressed sheet.",
        f"The sheet as the {_punch(data)} has deformed it, coloured by a field.",
        _FIELDS,
    )
    steps = data.get("newton_iterations_total", data["newton_iterations"])
    found.parts += asked(data)
    found.parts.append(computed(("steps of Newton's method", number(steps)), ("unknowns", number(data["unknowns"]))))
    return found


def _verdict(data: Any) -> tuple[bool | None, str]:
    if not data["converged"]:
        return False, f"No equilibrium at the full depth: {data.get('status', 'not converged')}."
    if not (data.get("stability") or {}).get("stable", True):
        return False, "The constants are not stable at the stretches that occur in the sheet."
    text = f"Equilibrium found: {number(data['force_N'], 'N').text} press the {_punch(data)} in"
    if "stress_difference_percent" not in data:
        return True, f"{text}."
    differs = number(data["stress_difference_percent"], "%", 3).text
    return True, f"{text}; with the other constants the stress differs by up to {differs}."


def _punch(data: Any) -> str:
    return "punch" if (data.get("setup") or {}).get("punch") else "sphere"


def _curve(pairs: list[Any]) -> tuple[list[float], list[float]]:
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def _force(data: Any) -> str:
    return "not computed" if data.get("force_N") is None else banded(data, "force_N", "N", form=".3g")
