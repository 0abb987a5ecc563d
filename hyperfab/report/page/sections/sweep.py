"""A study: what matters, the cases to filter, the front of two figures."""

from __future__ import annotations

from typing import Any

from hyperfab.report.labels import title
from hyperfab.report.page.charts import chart, line
from hyperfab.report.page.parts import (
    Cases,
    Figure,
    Part,
    Picture,
    Section,
    Source,
    Table,
    columns,
    floats,
    light,
    number,
    word,
)

#: The page carries this many cases; the table beside the document has all.
MAX_CASES = 2000

#: What a case is called by: its running number, and the name its files have.
_CALLED = ("number", "case")


def section(source: Source) -> Section:
    """Return the section of a sweep document."""
    data = source.data
    failed = sum(count for status, count in data["by_status"].items() if status not in ("0", "1"))
    found = Section("", *_verdict(data, failed))
    found.figures = [Figure(str(data["cases"]), f"cases of {data['name']}")]
    found.claim = f"{data['cases']} cases were computed"
    if "within_limits" in data:
        found.claim = f"{data['within_limits']} of {data['cases']} cases keep to the limits"
    for name, sense in senses(data).items():
        row = (data.get("best") or {}).get(name)
        if row is not None:
            words, _, unit = title(name).partition(", ")
            found.figures.append(Figure(number(row[name], unit, 3).text, f"{sense} {words}"))
    if len(found.figures) > 1:
        least = [f"the {one.label} is {one.text}" for one in found.figures[1:3]]
        found.claim += f", of these {' and '.join(least)}"
    if data.get("question"):
        found.notes.append(f"The question: {data['question']}")
    if data.get("idle"):
        found.notes.append(
            f"Along {', '.join(data['idle'])} every case finds the same: it plays no part in these runs."
        )
    if data.get("best"):
        found.parts.append(_best(data))
    if data.get("effects"):
        found.parts.append(_effects(data["effects"]))
    found.parts += _cases(source)
    for ending, caption, alt in (
        (".effects.png", "Main effects: the mean of each figure at each level of an axis.", "Main effects."),
        (
            ".cases.png",
            "All cases as lines across axes and figures; red: the cases that none beats.",
            "Parallel coordinates.",
        ),
    ):
        drawn = source.sibling(ending)
        picture = None if drawn is None else light(drawn)
        if picture is not None:
            found.parts.append(Picture(caption, alt, picture))
    return found


def _verdict(data: Any, failed: int) -> tuple[bool | None, str]:
    text = f"{data['cases']} cases of {data['name']}"
    if failed:
        return False, f"{text}; {failed} failed, the table says why."
    if "within_limits" in data:
        inside = data["within_limits"]
        return inside > 0, f"{text}, all computed; {inside} keep to the limits."
    return True, f"{text}, all computed."


def senses(data: Any) -> dict[str, str]:
    """Return of which figures the least or the greatest is the best; of all the least where nothing says."""
    said = data.get("senses")
    return dict(said) if said else dict.fromkeys(data.get("best") or {}, "least")


def _best(data: Any) -> Table:
    wanted = {name: sense for name, sense in senses(data).items() if name in data["best"]}
    first = next(iter(data["best"].values()))
    names = [name for name in first if name not in _CALLED]
    called = [name for name in _CALLED if name in first]
    rows = [
        [
            word(f"{sense} {title(figure)}"),
            *(
                number(row[name]) if isinstance(row.get(name), (int, float)) else word(row.get(name, ""))
                for name in [*names, *called]
            ),
        ]
        for figure, sense in wanted.items()
        for row in [data["best"][figure]]
    ]
    kept = ", of those that keep to the limits" if data.get("limits") else ""
    return Table(f"The best case by each figure{kept}", ["", *map(title, names), *called], rows)


def _effects(effects: list[Any]) -> Table:
    axes = list(dict.fromkeys(effect["axis"] for effect in effects))
    figures = list(dict.fromkeys(effect["figure"] for effect in effects))
    share = {(effect["axis"], effect["figure"]): effect["variance_share"] for effect in effects}
    rows = [
        [
            word(title(figure)),
            *(
                number(round(100 * share[axis, figure], 1), "%", 3) if (axis, figure) in share else word("")
                for axis in axes
            ),
        ]
        for figure in figures
    ]
    return Table(
        "What matters: share of each figure's variance that an axis explains on its own",
        ["figure", *axes],
        rows,
    )


def _cases(source: Source) -> list[Part]:
    table = columns(source.sibling(source.data["table"]), source.name)
    if "case" not in table:
        return []
    axes, figures = list(source.data["axes"].values()), list(source.data["figures"])
    called = [name for name in _CALLED if name in table and name not in (*axes, *figures)]
    names = [*axes, "status", *figures, *called]
    names += ["within_limits"] if "within_limits" in table else []
    numbers = {name: floats(table[name]) for name in names}
    cells = [
        table[name] if name == "case" or all(value is None for value in numbers[name]) else numbers[name]
        for name in names
    ]
    rows = [list(row) for row in zip(*cells, strict=True)]
    front = (source.data.get("front") or {}).get("cases", [])
    parts: list[Part] = []
    pair = (source.data.get("front") or {}).get("figures")
    if pair and all(name in numbers for name in pair):
        chosen = [row for row, case in enumerate(table["case"]) if case in set(front)]
        chosen.sort(key=lambda row: numbers[pair[0]][row] or 0.0)
        done = [status in (0, 1) for status in numbers["status"]]
        x, y = ([value if kept else None for value, kept in zip(numbers[name], done, strict=True)] for name in pair)
        parts.append(
            chart(
                "All cases by the two figures that pull against each other; the line joins those that none beats.",
                f"{len(front)} of {len(rows)} cases are on the front.",
                title(pair[0]),
                title(pair[1]),
                [
                    line("all cases", x, y, 0, points=True),
                    {
                        **line("cases that none beats", [x[row] for row in chosen], [y[row] for row in chosen], 1),
                        "mode": "lines+markers",
                        "marker": {"size": 9},
                    },
                ],
            )
        )
    shown = [[index, *row] for index, row in enumerate(rows, 1)][:: max(-(-len(rows) // MAX_CASES), 1)]
    caption = f"{len(shown)} of {len(rows)} cases" if len(shown) < len(rows) else f"All {len(rows)} cases"
    parts.append(
        Cases(
            f"{caption}. Choose levels of the axes and bounds of the figures to filter; bold: none beats it.",
            ["no.", *names],
            shown,
            axes,
            figures,
            front,
        )
    )
    return parts
