"""One file a kind of document: what its section says first, and what it shows."""

from __future__ import annotations

import importlib

from hyperfab.errors import HyperfabError
from hyperfab.report.bands import figure, interval, shares, value_of
from hyperfab.report.labels import parted, title
from hyperfab.report.page.charts import bars, chart
from hyperfab.report.page.parts import Cell, Part, Section, Source, Table, word


def build(source: Source) -> Section:
    """Return the section of a document. What cannot be read in it costs this section, not the page."""
    module = importlib.import_module(f"{__name__}.{source.kind}")
    try:
        section: Section = module.section(source)
        section.parts += _sure(source)
        section.warnings = [str(text) for text in source.data.get("warnings") or []]
    except (HyperfabError, KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        reason = str(error) if isinstance(error, HyperfabError) else f"{type(error).__name__}: {error}"
        return Section("", None, f"Cannot be shown: {reason}. Make the document again with this hf.")
    left_out = source.data.get("left_out")
    if left_out and isinstance(left_out, list):  # of a fit they are rows, by reason
        section.notes.append(f"Left out: {', '.join(left_out)}.")
    missing = [name for name in source.data.get("files", []) if not _there(source, name)]
    if missing:
        section.notes.append(f"Gone from beside the document, and missing here: {', '.join(missing)}.")
    return section


def _there(source: Source, name: str) -> bool:
    if not name.endswith((".vtu", ".csv", ".png")) or name.removesuffix(".vtu").rpartition(".")[2].isdecimal():
        return True
    return source.sibling(name) is not None


def _sure(source: Source) -> list[Part]:
    """Return how sure the figures are and what that is made of, a table and a picture; nothing where nothing says."""
    told = source.data.get("uncertainty") or {}
    bands = told.get("quantities") or {}
    if not bands:
        return []
    rows = []
    for key, band in bands.items():
        unit, value = parted(key)[1], float(value_of(source.data, key))
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
                    for end, text in zip(("low", "high"), interval(band["low"], band["high"], band["sd"]), strict=True)
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
        each = [next((s["share"] for s in band["budget"] if s["source"] == one), 0.0) for band in bands.values()]
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
