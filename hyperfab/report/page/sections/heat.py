"""Molds: temperature in 3-D, curves of the probes, where the energy goes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hyperfab.report.bands import evenness, warmup
from hyperfab.report.page.charts import bars, chart, line
from hyperfab.report.page.parts import (
    Cell,
    Figure,
    Section,
    Source,
    Table,
    asked,
    columns,
    computed,
    facts,
    floats,
    known,
    minutes,
    number,
    percent,
    warmup_cell,
    word,
)
from hyperfab.report.page.scenes import Field, views

#: Curves of more rows than this are thinned out for the page; every n-th row is kept.
MAX_ROWS = 1500


def section(source: Source) -> Section:
    """Return the section of a heat document."""
    data = source.data
    found = Section("", *_verdict(data))
    surface = data.get("work_surface") or {}
    warm = surface.get("at_warmup") or {}
    energy = data["energy"]
    varied = data.get("variations") or {}
    warmed = warmup(data) if "warmup_time_s" in data else None
    found.parts += views(
        source,
        "Temperature at the end of the run.",
        "The mold coloured by its temperature.",
        [Field("temperature_degC", "temperature", "°C", "heat")],
    )
    found.parts.append(
        facts(
            "Figures of the mold",
            [
                ("warm-up", warmup_cell(data) if warmed else None),
                ("work surface at warm-up, mean", known(warm, "mean_degC", "°C")),
                ("work surface at warm-up, spread", known(warm, "spread_K", "K")),
                ("work surface at the end, mean", known(surface, "mean_degC", "°C")),
                ("work surface at the end, spread", known(surface, "spread_K", "K")),
                ("heat supplied", known(energy, "supplied_J", "MJ", 1e-6)),
                ("heat lost", known(energy, "lost_J", "MJ", 1e-6)),
                ("heat stored", known(energy, "stored_J", "MJ", 1e-6)),
                (
                    "efficiency: heat stored in the parts of that supplied, to warm-up",
                    percent(data["efficiency"]) if data.get("efficiency") is not None else None,
                ),
                ("mass", number(data["mass_kg"], "kg")),
                ("variations on the reduced mold", number(len(varied["runs"])) if varied else None),
                (
                    "reduced mold, greatest difference from the full run",
                    known(varied, "difference_max_K", "K"),
                ),
            ],
        )
    )
    if warmed is not None:
        found.figures.append(Figure(warmed, "warm-up of the mold"))
        target = f" at {number(data['target_degC'], '°C').text}" if "target_degC" in data else " warm"
        found.claim = f"the mold is{target} after {warmed}"
    spread = warm.get("spread_K", surface.get("spread_K"))
    if spread is not None:
        found.figures.append(Figure(evenness(data, spread), "evenness of the work surface"))
    table = columns(source.sibling(".csv", but=".history.csv"), source.name)
    if "time_s" in table:
        step = -(-len(table["time_s"]) // MAX_ROWS)
        time = minutes(table["time_s"])[::step]
        traces = [
            line(name.removesuffix("_degC"), time, floats(cells)[::step], colour)
            for colour, (name, cells) in enumerate((n, c) for n, c in table.items() if n.endswith("_degC"))
        ]
        if traces:
            caption = "Temperature of the probes." + (f" Every {step}th row is drawn." if step > 1 else "")
            found.parts.append(
                chart(
                    caption,
                    f"Temperature against time of {len(traces)} probes.",
                    "time, min",
                    "temperature, °C",
                    traces,
                )
            )
    flows = energy.get("by_condition_J") or {}
    if flows:
        found.parts.append(
            chart(
                "Heat that entered through each condition; what was lost is negative.",
                "Bars of the heat in MJ through each heater and each cooled face.",
                "",
                "heat, MJ",
                [bars("heat", list(flows), [value / 1e6 for value in flows.values()])],
            )
        )
    found.parts += asked(data)
    found.parts.append(
        computed(
            ("unknowns", number(data["unknowns"])),
            ("time steps", number(data["steps"])),
            ("error of the account of heat", number(energy["imbalance_relative"], "", 2)),
        )
    )
    found.notes += [str(text) for text in data.get("notes", [])]
    return found


def _verdict(data: Any) -> tuple[bool | None, str]:
    if not data["converged"]:
        return False, f"Not converged: {data.get('status', '')}."
    spread = (data.get("work_surface") or {}).get("at_warmup", data.get("work_surface") or {}).get("spread_K")
    even = f", even to {evenness(data, spread)}" if spread is not None else ""
    if "warmup_time_s" in data:
        target = f"{number(data['target_degC'], '°C').text} " if "target_degC" in data else "the target "
        return True, f"The work surface is at {target}after {warmup(data)}{even}."
    if data.get("target_reached") is False or "target_degC" in data:
        return False, f"The work surface does not reach {number(data.get('target_degC'), '°C').text}."
    return None, f"Computed to its end{even}; no target was set."


def molds(sources: Sequence[Source]) -> Table | None:
    """Return the figures of all molds in one table; None where there are fewer than two."""
    heated = [source for source in sources if source.kind == "heat"]
    if len(heated) < 2:
        return None
    rows = []
    for title, unit, find in _ROWS:
        cells = [_cell(source, find, unit) for source in heated]
        if any(cell.number for cell in cells):
            rows.append([word(title), *cells])
    names = [source.name.rsplit("/", 1)[-1].removesuffix(".json") for source in heated]
    return Table("The molds of this page", ["", *names], rows)


_ROWS: tuple[tuple[str, str, Callable[[Any], Any]], ...] = (
    ("warm-up", "min", warmup_cell),
    ("spread at warm-up", "K", lambda data: data["work_surface"]["at_warmup"]["spread_K"]),
    ("heat supplied", "MJ", lambda data: data["energy"]["supplied_J"] / 1e6),
    ("heat lost", "MJ", lambda data: data["energy"]["lost_J"] / 1e6),
    ("heat stored", "MJ", lambda data: data["energy"]["stored_J"] / 1e6),
    ("efficiency", "%", lambda data: 100.0 * data["efficiency"]),
    ("mass", "kg", lambda data: data["mass_kg"]),
)


def _cell(source: Source, find: Callable[[Any], Any], unit: str) -> Cell:
    try:
        value = find(source.data)
    except (KeyError, TypeError):
        return Cell("")
    if isinstance(value, Cell):
        return value
    return number(value, unit) if isinstance(value, (int, float)) else Cell("")
