"""Fabric: curves against data, unseen tests dashed, stability."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hyperfab.report.labels import parted
from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import (
    Cell,
    Chart,
    Figure,
    Section,
    Source,
    Table,
    columns,
    floats,
    number,
    percent,
    word,
)

#: Predictions at one stretch that differ by more than this share do not lie on one line.
ONE_LINE = 1e-6


def section(source: Source) -> Section:
    """Return the section of a material document."""
    data = source.data
    parts: dict[str, Any] = data.get("directions") or {"": data}
    found = Section("", *_verdict(data, parts))
    found.parts += list(_curves(source))
    found.parts.append(_constants(data, parts))
    if any(part.get("fit") for part in parts.values()):
        found.parts.append(_fits(parts))
    fits = {way: part["fit"] for way, part in parts.items() if part.get("fit")}
    if fits:
        worst = percent(max(fit["relative_rms"] for fit in fits.values()), 2).text
        found.claim = f"{data['model']} carries the tests to {worst}"
        found.figures = [
            Figure(percent(fit["relative_rms"], 2).text, f"misfit {way}".strip()) for way, fit in fits.items()
        ]
    stability = _stability(parts)
    if stability.rows:
        found.parts.append(stability)
    if data.get("models"):
        found.parts.append(_models(data["models"]))
    for effect in data.get("effects") or []:
        found.notes.append(f"Beyond the law: {effect.get('id', 'an effect')}.")
    return found


def _verdict(data: Any, parts: dict[str, Any]) -> tuple[bool | None, str]:
    fits = {direction: part["fit"] for direction, part in parts.items() if part.get("fit")}
    if not fits:
        return None, f"{data['model']}, given without a fit."
    misfits = (
        f"{direction} {percent(fit['relative_rms'], 2).text} over {fit['points']} readings".strip()
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
            label, unit = parted(name)
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
                    percent(figures["relative_rms"]) if "relative_rms" in figures else word(figures.get("status", "")),
                    percent(figures["nrmse"]) if "nrmse" in figures else word(""),
                    number(figures.get("E2")),
                ]
            )
    carrier = "the constants written here" if list(parts) == [""] else "the constants of its own direction"
    return Table(
        f"How well each test is carried by {carrier}: the relative rms is the root mean square of "
        "1 - model/measured, E2 the sum of its squares, NRMSE the rms error over the largest stress",
        ["test", "use", "readings", "relative rms", "NRMSE", "E2"],
        rows,
    )


def _curves(source: Source) -> Iterator[Chart]:
    table = columns(source.sibling(".csv"), source.name)
    if not {"test", "stretch", "stress_MPa", "stress_model_MPa", "predicted"} <= set(table):
        return
    names = ("test", "direction", "temperature_degC", "predicted")
    groups: dict[tuple[str, ...], list[int]] = {}
    for row in range(len(table["test"])):
        key = tuple(table[name][row] if name in table else "" for name in names)
        groups.setdefault(key, []).append(row)
    warm = len({key[2] for key in groups}) > 1
    readings, laws = [], []
    for colour, (key, rows) in enumerate(sorted(groups.items(), key=_order)):
        test, direction, temperature, predicted = key
        stretch, stress, model = (
            floats([table[name][row] for row in rows]) for name in ("stretch", "stress_MPa", "stress_model_MPa")
        )
        heat = f" {float(temperature):g} °C" if warm and temperature else ""
        name = f"{test} {direction}".strip() + heat
        readings.append(line(f"{name}, measured", stretch, stress, colour, points=True, legend=False))
        along = _single(stretch, model)
        unseen = predicted == "1"
        words = f"{name}, {'predicted' if unseen else 'fitted'}"
        if along is None:  # two axes at once: no line of one stretch goes through what the law says
            laws.append(line(words, stretch, model, colour, points=True, symbol="x-thin-open"))
        else:
            laws.append(line(words, *along, colour, dash="dash" if unseen else "solid"))
    yield chart(
        "Measured stress (rings) and the law (lines, or crosses where a test has two stretches; dashed where it "
        "took no part in the fit)" + (", temperature by temperature." if warm else "."),
        f"Nominal stress against stretch for {len(groups)} tests, measured and by the law.",
        "stretch",
        "nominal stress, MPa",
        [*readings, *laws],
        showlegend=True,
    )


def _order(item: tuple[tuple[str, ...], list[int]]) -> tuple[str, str, float, str]:
    test, direction, temperature, predicted = item[0]
    return test, direction, float(temperature) if temperature else 0.0, predicted


def _single(stretch: list[float | None], model: list[float | None]) -> tuple[list[float], list[float]] | None:
    """Return the line through the predictions of one test at one temperature; None where they lie on none."""
    known = sorted((x, y) for x, y in zip(stretch, model, strict=True) if x is not None and y is not None)
    size = max((abs(y) for _, y in known), default=0.0)
    xs: list[float] = []
    ys: list[float] = []
    for x, y in known:
        if xs and x == xs[-1]:
            if abs(y - ys[-1]) > ONE_LINE * size:
                return None
            continue
        xs.append(x)
        ys.append(y)
    return xs, ys


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
    return Table("Stretches over which the constants are stable (Drucker)", ["mode", "from", "to", "end"], rows)


def _models(models: list[dict[str, Any]]) -> Table:
    rows = [
        [
            word(row["model"]),
            percent(row.get("relative_rms")),
            percent(row["carry_over"]) if row.get("carry_over") is not None else word(""),
            number(row.get("stable")),
            word(row.get("status") or ("accepted" if row.get("accepted") else "not accepted")),
        ]
        for row in models
    ]
    return Table("All laws, best first", ["law", "relative rms", "on unseen tests", "stable", "status"], rows)
