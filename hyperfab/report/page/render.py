"""Sections made into one HTML page: everything escaped, nothing fetched, no script but what the page carries."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from jinja2 import DictLoader, Environment, StrictUndefined
from plotly.offline import get_plotlyjs

from hyperfab import __version__
from hyperfab.report.labels import title as words_of
from hyperfab.report.page.front import FrontPage, front
from hyperfab.report.page.parts import (
    KINDS,
    Cases,
    Cell,
    Chart,
    Part,
    Picture,
    Scene,
    Section,
    Source,
    Table,
    number,
    parents,
    word,
)

#: Levels of an axis that a filter lists; a drawn axis has more, and gets no filter.
MAX_LEVELS = 40


def page(title: str | None, told: Sequence[tuple[Source, Section]], comparison: Table | None) -> bytes:
    """Return the page: the sections in the order given; ``comparison`` sets designs side by side.

    Without a ``title`` a page of one document is called what that is.
    """
    sources = [source for source, _ in told]
    if not title:
        title = f"{KINDS[sources[0].kind]}: {_name(sources[0])}" if len(sources) == 1 else "From fabric to press"
    places = {id(source): f"section-{index + 1}" for index, source in enumerate(sources)}
    items = []
    for source, section in told:
        own = places[id(source)]
        made_from = [{"id": places[id(one)], "name": _short(one.name)} for one in parents(source, sources)]
        items.append(
            {
                "id": own,
                "heading": KINDS[source.kind],
                "name": _name(source),
                "section": section,
                "mark": {True: "pass", False: "fail", None: ""}[section.passed],
                "badge": {True: "Pass", False: "Does not pass", None: ""}[section.passed],
                "made_from": made_from,
                "parts": _grouped([_part(part, f"{own}-{index}") for index, part in enumerate(section.parts)]),
                "warnings": grouped_warnings(section.warnings),
                "count": len(section.warnings),
            }
        )
    here = files(__package__)
    css, script, plotly = (
        here.joinpath("page.css").read_text("utf-8"),
        here.joinpath("page.js").read_text("utf-8"),
        get_plotlyjs(),
    )
    templates = {name: here.joinpath(name).read_text("utf-8") for name in ("page.html.j2", "parts.html.j2")}
    environment = Environment(
        loader=DictLoader(templates),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = environment.get_template("page.html.j2").render(
        title=title,
        front=_front(front(told), items),
        summary=_summary([section for _, section in told]),
        style_ids=_own_styles(plotly),
        policy=policy(css, script, plotly),
        css=css,
        script=script,
        plotly=plotly,
        sections=items,
        comparison=comparison,
        provenance=_provenance(sources),
        version=__version__,
    )
    return text.encode("utf-8")


def policy(css: str, script: str, plotly: str) -> str:
    """Return the page's content-security policy: only the scripts and styles it carries, no connection, no eval.

    plotly adds style sheets that it fills by rule (their text is empty) and styles on its own elements.
    """
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash(plotly)} {_hash(script)}",
            f"style-src-elem {_hash(css)} {_hash('')}",
            "style-src-attr 'unsafe-inline'",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def safe_json(value: Any) -> str:
    """Return JSON that cannot end the element it stands in.

    >>> safe_json({"name": "</script><script>"})
    '{"name":"\\\\u003c/script\\\\u003e\\\\u003cscript\\\\u003e"}'
    """
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _own_styles(plotly: str) -> list[str]:
    """Return the names of style sheets that plotly adds, for its maps, unless they are there.

    The page has no map, and its policy forbids sheets with text: it brings them, empty.
    """
    return sorted(set(re.findall(r'getElementById\("([0-9a-f]{64})"\)', plotly)))


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _part(part: Part, own: str) -> dict[str, Any]:
    common: dict[str, Any] = {"id": own, "given": part}
    if isinstance(part, Table):
        return {**common, "kind": "table"}
    if isinstance(part, Chart):
        return {**common, "kind": "chart", "json": safe_json({"data": part.data, "layout": part.layout})}
    if isinstance(part, Scene):
        shown = {"mesh": part.mesh, "fields": part.fields, "eye": part.eye}
        return {**common, "kind": "scene", "json": safe_json(shown)}
    if isinstance(part, Picture):
        return {**common, "kind": "picture", "base64": base64.b64encode(part.data).decode("ascii")}
    return {**common, "kind": "cases", **_cases(part)}


def _cases(cases: Cases) -> dict[str, Any]:
    chosen = set(cases.front)
    filters, limits = [], []
    for column, name in enumerate(cases.columns):
        values = list(dict.fromkeys(row[column] for row in cases.rows))
        if name in cases.axes and len(values) <= MAX_LEVELS:
            levels = [{"value": _value(value), "text": _cell(value).text} for value in values]
            filters.append({"name": words_of(name), "column": column, "levels": levels})
        elif name in cases.axes or name in cases.figures:
            limits.append({"name": words_of(name), "column": column})
    rows = [
        {
            "front": any(cell in chosen for cell in row if isinstance(cell, str)),
            "cells": [{"value": _value(value), **vars(_cell(value))} for value in row],
        }
        for row in cases.rows
    ]
    heads = [words_of(name) for name in cases.columns]
    return {"filters": filters, "limits": limits, "rows": rows, "heads": heads}


def _cell(value: Any) -> Cell:
    if value is None:
        return Cell("")
    return number(value) if isinstance(value, (int, float)) else word(value)


def _value(value: Any) -> str:
    return "" if value is None else repr(value) if isinstance(value, (int, float)) else str(value)


def _front(given: FrontPage, items: Sequence[dict[str, Any]]) -> dict[str, Any]:
    pictures = [
        {
            **vars(picture),
            "id": items[picture.section]["id"],
            "heading": items[picture.section]["heading"],
            "base64": "" if picture.image is None else base64.b64encode(picture.image).decode("ascii"),
        }
        for picture in given.pictures
    ]
    figures = [
        {
            "text": figure.text,
            "label": figure.label,
            "id": items[number_]["id"],
            "name": items[number_]["name"],
            "mark": items[number_]["mark"],
        }
        for number_, figure in given.figures
    ]
    return {"sentence": given.sentence, "figures": figures, "pictures": pictures}


Shown = dict[str, Any]


def _grouped(parts: Sequence[Shown]) -> list[tuple[Shown | None, list[Shown]]]:
    """Put tables that follow each other side by side, and those that follow a view beside it."""
    groups: list[tuple[Shown | None, list[Shown]]] = []
    for part in parts:
        is_table = part["kind"] == "table" and not part["given"].folded
        view, tables = groups[-1] if groups else (None, [])
        if is_table and tables and tables[-1]["kind"] == "table" and not tables[-1]["given"].folded:
            tables.append(part)
        elif is_table and view is None and tables and tables[-1]["kind"] == "scene":
            groups[-1] = (tables[-1], [part])
        else:
            groups.append((None, [part]))
    return groups


def grouped_warnings(warnings: Sequence[str]) -> list[tuple[str, int]]:
    """Return each kind of warning once, as first said, and how often it was said: files and numbers aside.

    >>> grouped_warnings(["a.csv, line 7: 0.1 is too far", "b.csv, line 12: 0.2 is too far", "stop"])
    [('a.csv, line 7: 0.1 is too far', 2), ('stop', 1)]
    """
    kinds: dict[str, list[str]] = {}
    for text in warnings:
        rest = re.sub(r"^[^:]*?\.\w{2,5}(, [^:]*)?: ", "", text)
        kinds.setdefault(re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "0", rest), []).append(text)
    return [(texts[0], len(texts)) for texts in kinds.values()]


def _summary(sections: Sequence[Section]) -> str:
    failed = sum(section.passed is False for section in sections)
    count = f"{len(sections)} result{'s' if len(sections) != 1 else ''}"
    if failed:
        return f"{count}; {failed} of them {'does' if failed == 1 else 'do'} not pass."
    return f"{count}; nothing fails."


def _provenance(sources: Sequence[Source]) -> Table:
    rows = []
    for source in sources:
        made = source.data.get("provenance") or {}
        command = f"hf {made.get('command', '?')} {' '.join(map(str, made.get('arguments', [])))}"
        rows.append(
            [
                word(_short(source.name)),
                word(command),
                word(made.get("hf", "")),
                Cell(source.sha256[:12], source.sha256),
            ]
        )
    return Table("Documents", ["document", "made by", "hf", "sha256"], rows)


def _name(source: Source) -> str:
    """Return what a section is called: studies all write sweep.json, and have a name of their own."""
    return str(source.data.get("name") or _short(source.name)) if source.kind == "sweep" else _short(source.name)


def _short(name: str) -> str:
    return "standard input" if name == "-" else name.replace("\\", "/").rsplit("/", 1)[-1]
