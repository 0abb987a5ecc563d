"""The loop: the verdict in words, and the residual before and after."""

from __future__ import annotations

from typing import Any

from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import Part, Section, Source, Table, columns, floats, number, word

_VERDICTS = {
    "noise": (True, "Nothing lacks: what the model misses is the noise of the data."),
    "effect": (True, "Something lacked, and it is found: what is left is the noise of the data."),
    "ambiguous": (None, "Something lacks, and several effects explain it equally well on these data."),
    "unexplained": (False, "Something lacks, and no entry of the catalogue explains it."),
}


def section(source: Source) -> Section:
    """Return the section of a loop document."""
    data = source.data
    passed, words = _VERDICTS[data["verdict"]]
    names = ", ".join(effect.get("title", effect["id"]) for effect in data.get("effects", []))
    found = Section("", passed, f"{words}{f' Added: {names}.' if names else ''}")
    found.parts.append(_errors(data))
    found.parts += _residuals(source, data)
    if data.get("effects"):
        found.parts.append(_effects(data["effects"]))
    if data.get("candidates"):
        found.parts.append(_candidates(data["candidates"]))
    found.notes += [str(text) for text in data.get("summary", [])]
    if data.get("next_measurement"):
        found.notes.append(f"Next measurement: {data['next_measurement']['text']}")
    found.notes += [str(text) for text in data.get("warnings", [])]
    return found


def _errors(data: Any) -> Table:
    rows = []
    for title, errors in (("data used", data["error"]), ("held-out tests", data.get("held_out"))):
        if not errors:
            continue
        unit = errors.get("unit", "")
        for moment in ("before", "after", "noise"):
            figures = errors[moment]
            rows.append(
                [
                    word(f"{title}, {moment}"),
                    number(figures["rms"], unit),
                    number(figures["relative_rms"]),
                    number(figures["chi2_reduced"]),
                ]
            )
    return Table("Misfit of the model", ["", "rms", "relative rms", "chi², reduced"], rows)


def _residuals(source: Source, data: Any) -> list[Part]:
    table = columns(source.sibling(".csv"), source.name)
    # A mold has columns of each probe: the first stands for them.
    before = next((name for name in table if "before_" in name), None)
    after = next((name for name in table if "after_" in name), None)
    names = list(table)
    if before is None or after is None or names.index(before) < 2:
        return []
    measured = names[names.index(before) - 1]
    across = names[1] if names[1] != measured else names[0]
    x, y = floats(table[across]), floats(table[measured])
    traces = []
    for colour, (title, name) in enumerate((("before", before), ("after", after))):
        model = floats(table[name])
        rest = [None if a is None or b is None else a - b for a, b in zip(y, model, strict=True)]
        traces.append(line(title, x, rest, colour, points=True))
    return [
        chart(
            "Residual, measured less model, before and after.",
            f"The rms falls from {number(data['error']['before']['rms']).text} to "
            f"{number(data['error']['after']['rms']).text} {data['error'].get('unit', '')}.",
            across,
            f"residual of {measured}",
            traces,
        )
    ]


def _effects(effects: list[Any]) -> Table:
    rows = [
        [
            word(effect["id"]),
            word(name),
            number(value),
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
