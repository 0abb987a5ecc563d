"""The loop: the verdict in words, and the residual before and after."""

from __future__ import annotations

import math
from typing import Any

from hyperfab.report.labels import AFTER, BEFORE, DATA, PLACES, parted, title
from hyperfab.report.page.charts import chart, dots, line
from hyperfab.report.page.parts import (
    Figure,
    Part,
    Section,
    Source,
    Table,
    columns,
    floats,
    minutes,
    number,
    percent,
    word,
)

_VERDICTS = {
    "noise": (True, "Nothing lacks: what the model misses is the noise of the data."),
    "effect": (True, "Something lacked, and it is found: what is left is the noise of the data."),
    "ambiguous": (None, "Something lacks, and several effects explain it equally well on these data."),
    "unexplained": (False, "Something lacks, and no entry of the catalogue explains it."),
}

#: What is drawn of a quantity, and how it is coloured.
_KINDS = {"measured": DATA, "before": BEFORE, "after": AFTER}
_MOMENTS = {
    "delivered": "the model as given",
    "before": "its constants refitted",
    "after": "with the effects",
    "noise": "noise of the data",
}


def section(source: Source) -> Section:
    """Return the section of a loop document."""
    data = source.data
    passed, words = _VERDICTS[data["verdict"]]
    names = ", ".join(effect.get("title", effect["id"]) for effect in data.get("effects", []))
    found = Section("", passed, f"{words}{f' Added: {names}.' if names else ''}")
    found.parts += _against_measurement(source, data)
    found.parts.append(_errors(data))
    before, after = (data["error"][moment]["relative_rms"] for moment in ("before", "after"))
    missed = percent(after, 2).text
    if data.get("effects"):
        given = data["error"].get("delivered")
        change = f"{percent(given['relative_rms'] if given else before, 2).text} → {missed}"
        how = "as given" if given else "before"
        found.figures = [Figure(change, f"the model misses measurement by, {how} and after")]
    else:
        found.figures = [Figure(missed, "the model misses measurement by")]
    sound = data["verdict"] != "unexplained"
    found.claim = f"the model meets measurement to {missed}" if sound else f"the model misses measurement by {missed}"
    if data.get("effects"):
        found.parts.append(_effects(data["effects"]))
    if data.get("candidates"):
        found.parts.append(_candidates(data["candidates"]))
    found.notes += [str(text) for text in data.get("summary", [])]
    if data.get("next_measurement"):
        found.notes.append(f"Next measurement: {data['next_measurement']['text']}")
    return found


def _errors(data: Any) -> Table:
    rows = []
    kinds = (
        ("data used", data["error"]),
        ("contraction", data.get("contraction")),
        ("held-out tests", data.get("held_out")),
    )
    for what, errors in kinds:
        if not errors:
            continue
        unit = errors.get("unit", "")
        for moment, words in _MOMENTS.items():
            figures = errors.get(moment)
            if not figures:
                continue
            rows.append(
                [
                    word(f"{what}, {words}"),
                    number(figures["rms"], unit),
                    percent(figures["relative_rms"]),
                    number(figures["chi2_reduced"]),
                ]
            )
    return Table("Misfit of the model", ["", "rms", "relative rms", "chi², reduced"], rows)


def _against_measurement(source: Source, data: Any) -> list[Part]:
    """Draw measured against model, and what is left: as a map where readings lie scattered on a sheet or mold."""
    table = columns(source.sibling(".csv"), source.name)
    if "time_s" in table:
        series = _of_probes(table)
        across, quantity = "time, min", "temperature, °C"
    else:
        series, across, quantity = _of_tests(table)
    if not series:
        return []
    maps = _maps(table, data)
    if maps:
        return maps
    places, read, before, after = ([value for one in series for value in one[kind]] for kind in ("x", *_KINDS))
    rests = []
    for kind, model in (("before", before), ("after", after)):
        rest = [None if a is None or b is None else a - b for a, b in zip(read, model, strict=True)]
        rests.append(line(kind, places, rest, _KINDS[kind], points=True))
    falls = _falls(data, data["error"].get("unit", ""))
    unit = quantity.rpartition(", ")[2] if ", " in quantity else ""
    return [
        chart(
            f"Measured, and the model before and after ({len(series)} curves).",
            falls,
            across,
            quantity,
            _traces(series),
        ),
        chart(
            "What is left: measured less model, before and after.",
            falls,
            across,
            f"measured - model, {unit}" if unit else "measured - model",
            rests,
        ),
        *_widths(table, data),
    ]


def _falls(data: Any, unit: str) -> str:
    before, after = (number(data["error"][moment]["rms"]).text for moment in ("before", "after"))
    return f"The rms falls from {before} to {after} {unit}."


Series = dict[str, list[float | None]]


def _of_probes(table: dict[str, list[str]]) -> list[Series]:
    time = minutes(table["time_s"])
    found = []
    for name in table:
        if name.endswith("_measured_degC"):
            probe = name.removesuffix("_measured_degC")
            kinds = {kind: floats(table[f"{probe}_{kind}_degC"]) for kind in _KINDS}
            found.append({"x": time, **kinds})
    return found


def _quantity(table: dict[str, list[str]]) -> dict[str, str]:
    """Return the columns of the first quantity that was measured, by what they hold; empty where there is none."""
    names = list(table)
    before = next((name for name in names if name.startswith("before_")), None)
    if before is None:
        return {}
    measured = names[names.index(before) - 1]
    return {"measured": measured, "before": before, "after": before.replace("before_", "after_", 1)}


def _of_tests(table: dict[str, list[str]]) -> tuple[list[Series], str, str]:
    """Return the curves of each test or file, by the first quantity that was measured."""
    kinds = _quantity(table)
    if not kinds:
        return [], "", ""
    series, across = _series(table, kinds)
    words, unit = parted(kinds["measured"])
    return series, title(across), f"{'reading' if words == 'measured' else words}, {unit}" if unit else words


def _series(table: dict[str, list[str]], kinds: dict[str, str]) -> tuple[list[Series], str]:
    """Return the curves of each test or file in some columns, and what they are drawn over."""
    group = "test" if "test" in table else "file"
    across = next(name for name in table if name != group)
    values = {kind: floats(table[name]) for kind, name in ({"x": across} | kinds).items()}
    rows: dict[str, list[int]] = {}
    for row, name in enumerate(table[group]):
        if values["measured"][row] is not None:
            rows.setdefault(name, []).append(row)
    return [{kind: [cells[row] for row in own] for kind, cells in values.items()} for own in rows.values()], across


def _widths(table: dict[str, list[str]], data: Any) -> list[Part]:
    """Draw how much narrower specimens become, where that was read."""
    if "transverse_stretch" not in table or not data.get("contraction"):
        return []
    before, after = (percent(data["contraction"][moment]["relative_rms"], 2).text for moment in ("before", "after"))
    falls = f"How much narrower specimens become is missed by {before} before, {after} after."
    kinds = {"measured": "transverse_stretch", "before": "transverse_before", "after": "transverse_after"}
    series, across = _series(table, kinds)
    caption = "Transverse stretch, measured and by both models."
    return [chart(caption, falls, title(across), "transverse stretch", _traces(series))]


def _traces(series: list[Series]) -> list[dict[str, Any]]:
    """Return what was measured and both models, of each all curves as one with a gap after each."""
    found = []
    for kind, colour in _KINDS.items():
        x, y = ([value for one in series for value in (*one[what], None)] for what in ("x", kind))
        measured = kind == "measured"
        found.append(line(kind if measured else f"model {kind}", x, y, colour, points=measured))
    return found


def _maps(table: dict[str, list[str]], data: Any) -> list[Part]:
    """Return what is left at each place, before and after side by side on one scale."""
    pair = next((pair for pair in PLACES if set(pair) <= set(table)), None)
    kinds = _quantity(table)
    if pair is None or not kinds:
        return []
    measured, before, after = (floats(table[name]) for name in kinds.values())
    places = list(zip(floats(table[pair[0]]), floats(table[pair[1]]), strict=True))
    vectors = "axis" in table
    rests: list[dict[tuple[Any, Any], list[float]]] = [{}, {}]
    for found, model in zip(rests, (before, after), strict=True):
        for place, read, said in zip(places, measured, model, strict=True):
            if None not in (*place, read, said):
                found.setdefault(place, []).append(read - said)  # type: ignore[operator]
    sizes = [[math.hypot(*rest) if vectors else rest[0] for rest in found.values()] for found in rests]
    top = max((abs(size) for both in sizes for size in both), default=0.0) or 1.0
    unit = parted(kinds["before"])[1]
    traces = [
        dots(
            words,
            [place[0] for place in found],
            [place[1] for place in found],
            size,
            low=0.0 if vectors else -top,
            high=top,
            unit=f"measured - model, {unit}",
            bar=number_ == 1,
            axes="2" if number_ else "",
        )
        for number_, (words, found, size) in enumerate(zip(("before", "after"), rests, sizes, strict=True))
    ]
    across = {"title": {"text": title(pair[0])}}
    return [
        chart(
            "Where the model misses: what is left at each place, before on the left, after on the right, on one scale.",
            _falls(data, unit),
            title(pair[0]),
            title(pair[1]),
            traces,
            xaxis={"domain": [0.0, 0.46]},
            xaxis2={"domain": [0.54, 1.0], "anchor": "y2", **across},
            yaxis={"scaleanchor": "x"},
            yaxis2={"anchor": "x2", "scaleanchor": "x2"},
            showlegend=False,
        )
    ]


def _effects(effects: list[Any]) -> Table:
    rows = [
        [
            word(effect["id"]),
            word(parted(name)[0]),
            number(value, parted(name)[1]),
            number((effect.get("parameters_sd") or {}).get(name), "", 2),
            number(effect["evidence"]["delta_bic"], "", 3),
        ]
        for effect in effects
        for name, value in effect["parameters"].items()
    ]
    return Table(
        "Effects that were added",
        ["effect", "parameter", "value", "standard deviation", "BIC lowered by"],
        rows,
    )


def _candidates(candidates: list[Any]) -> Table:
    rows = [
        [
            word(one["id"]),
            number(one.get("score"), "", 3),
            number(one.get("delta_bic"), "", 3),
            word(", ".join(one.get("confounded_with", []))),
            word(one.get("not_sought", "")),
            word(one.get("shown_by", "")),
        ]
        for one in candidates
    ]
    return Table(
        "The catalogue",
        ["effect", "score", "BIC lowered by", "not told from", "left out as", "shown by"],
        rows,
    )
