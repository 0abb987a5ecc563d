"""How sure the figures of a document are, and what that is made of: a table and a picture for its section."""

from __future__ import annotations

from hyperfab.report.bands import figure, interval, shares
from hyperfab.report.labels import parted, title
from hyperfab.report.page.charts import bars, chart
from hyperfab.report.page.parts import Cell, Part, Source, Table, word


def parts(source: Source) -> list[Part]:
    """Return the table of bands and the picture of the budget; nothing where the document has no uncertainty."""
    told = source.data.get("uncertainty") or {}
    bands = told.get("quantities") or {}
    if not bands:
        return []
    rows = []
    for key, band in bands.items():
        unit, value = parted(key)[1], _value(source.data, key)
        rows.append(
            [
                word(title(key)),
                Cell(
                    f"{figure(value, band['sd'])} {unit}".strip(),
                    f"{value!r} ± {band['sd']!r} {unit}".strip(),
                    True,
                ),
                *(
                    Cell(f"{text} {unit}".strip(), f"{band[end]!r} {unit}".strip(), True)
                    for end, text in zip(
                        ("low", "high"), interval(band["low"], band["high"], band["sd"]), strict=True
                    )
                ),
                word(shares(band["budget"])),
            ]
        )
    how = {"linear": "to first order", "sampled": f"from {told.get('samples')} runs"}[told["method"]]
    level = f"{100.0 * told['level']:.0f} %"
    caption = f"How sure the figures are, {how}: ± one standard deviation, and the interval of {level}."
    found: list[Part] = [Table(caption, ["", "± sd", f"{level} from", "to", "made of"], rows)]
    sources = list(dict.fromkeys(share["source"] for band in bands.values() for share in band["budget"]))
    names = [title(key) for key in bands]
    traces = []
    for colour, one in enumerate(sources):
        each = [
            next((s["share"] for s in band["budget"] if s["source"] == one), 0.0) for band in bands.values()
        ]
        traces.append(bars(one, names, [100.0 * share for share in each], colour))
    told_of = f"Most of {names[0]} comes from {next(iter(bands.values()))['budget'][0]['source']}."
    found.append(
        chart(
            "What the uncertainty of each figure is made of: the share of its variance.",
            told_of,
            "",
            "share, %",
            traces,
            barmode="stack",
            showlegend=True,
        )
    )
    if told.get("left_out"):
        found.append(Table("Not carried", [""], [[word(text)] for text in told["left_out"]], folded=True))
    return found


def _value(data: object, key: str) -> float:
    found = data
    for step in key.split("."):
        found = found[step]  # type: ignore[index]
    return float(found)  # type: ignore[arg-type]
