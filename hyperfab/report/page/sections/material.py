"""Fabric: curves against data, unseen tests dashed, stability."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import Cell, Chart, Section, Source, Table, columns, floats, number, word


def section(source: Source) -> Section:
    """Return the section of a material document."""
    data = source.data
    parts: dict[str, Any] = data.get("directions") or {"": data}
    found = Section("", *_verdict(data, parts))
    found.parts.append(_constants(data, parts))
    if any(part.get("fit") for part in parts.values()):
        found.parts.append(_fits(parts))
    found.parts += list(_curves(source))
    stability = _stability(parts)
    if stability.rows:
        found.parts.append(stability)
    if data.get("models"):
        found.parts.append(_models(data["models"]))
    for effect in data.get("effects") or []:
        found.notes.append(f"Beyond the law: {effect.get('id', 'an effect')}.")
    found.notes += [str(text) for text in data.get("warnings") or []]
    return found


def _verdict(data: Any, parts: dict[str, Any]) -> tuple[bool | None, str]:
    fits = {direction: part["fit"] for direction, part in parts.items() if part.get("fit")}
    if not fits:
        return None, f"{data['model']}, given without a fit."
    misfits = (
        f"{direction} {number(fit['relative_rms'], '', 3).text} over {fit['points']} readings".strip()
        for direction, fit in fits.items()
    )
    within = f"{data['model']}: relative misfit {', '.join(misfits)}"
    stable = data.get("stable")
    if data.get("accepted") is False:
        return False, f"Not accepted. {within}, more than is allowed."
    if stable is False:
        return False, f"Accepted, but not stable over the stretches of the tests. {within}."
    return True, f"Accepted{' and stable over the tests' if stable else ''}. {within}."


def _constants(data: Any, parts: dict[str, Any]) -> Table:
    rows = []
    for direction, part in parts.items():
        spread = (part.get("fit") or {}).get("parameters_sd") or {}
        for name, value in part["parameters"].items():
            label, _, unit = name.rpartition("_")
            label, unit = (label, unit) if unit == "MPa" else (name, "")
            rows.append(
                [
                    word(f"{label} {direction}".strip()),
                    number(value, unit),
                    number(spread[name], unit, 2) if name in spread else Cell(""),
                ]
            )
    return Table(f"Constants of the law {data['model']}", ["constant", "value", "standard deviation"], rows)


def _fits(parts: dict[str, Any]) -> Table:
    rows = []
    for direction, part in parts.items():
        for test, figures in ((part.get("fit") or {}).get("tests") or {}).items():
            use = "predicted" if figures.get("predicted") else "fitted"
            rows.append(
                [
                    word(f"{test} {direction}".strip()),
                    word(use),
                    number(figures["points"]),
                    number(figures["relative_rms"])
                    if "relative_rms" in figures
                    else word(figures.get("status", "")),
                    number(figures.get("E2")),
                ]
            )
    return Table("How well each test is carried", ["test", "use", "readings", "relative rms", "E2"], rows)


def _curves(source: Source) -> Iterator[Chart]:
    table = columns(source.sibling(".csv"), source.name)
    if not {"test", "stretch", "stress_MPa", "stress_model_MPa", "predicted"} <= set(table):
        return
    groups: dict[tuple[str, str, str], list[int]] = {}
    for row in range(len(table["test"])):
        key = (table["test"][row], table["direction"][row], table["predicted"][row])
        groups.setdefault(key, []).append(row)
    traces = []
    for colour, ((test, direction, predicted), rows) in enumerate(sorted(groups.items())):
        stretch, stress, model = (
            floats([table[name][row] for row in rows])
            for name in ("stretch", "stress_MPa", "stress_model_MPa")
        )
        unseen = predicted == "1"
        name = f"{test} {direction}".strip()
        traces.append(line(f"{name}, measured", stretch, stress, colour, points=True))
        order = sorted(range(len(rows)), key=lambda place: stretch[place] or 0.0)
        traces.append(
            line(
                f"{name}, {'predicted' if unseen else 'fitted'}",
                [stretch[place] for place in order],
                [model[place] for place in order],
                colour,
                dash="dash" if unseen else "solid",
            )
        )
    yield chart(
        "Measured stress (rings) and the law (lines; dashed where the test took no part in the fit).",
        f"Nominal stress against stretch for {len(groups)} tests, measured and by the law.",
        "stretch",
        "nominal stress, MPa",
        traces,
    )


def _stability(parts: dict[str, Any]) -> Table:
    rows = []
    for direction, part in parts.items():
        for mode, span in (part.get("stability") or {}).items():
            ends = {
                "instability": "unstable beyond",
                "limit": "the law ends there",
                "scan": "as far as was looked",
            }
            rows.append(
                [
                    word(f"{mode} {direction}".strip()),
                    number(span["stretch_min"]),
                    number(span["stretch_max"]),
                    word(ends.get(span.get("ended_by", ""), "")),
                ]
            )
    return Table(
        "Stretches over which the constants are stable (Drucker)", ["mode", "from", "to", "end"], rows
    )


def _models(models: list[dict[str, Any]]) -> Table:
    rows = [
        [
            word(row["model"]),
            number(row.get("relative_rms")),
            number(row.get("carry_over")),
            number(row.get("stable")),
            word(row.get("status") or ("accepted" if row.get("accepted") else "not accepted")),
        ]
        for row in models
    ]
    return Table("All laws, best first", ["law", "relative rms", "on unseen tests", "stable", "status"], rows)
