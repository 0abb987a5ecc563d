"""Charts for the page: curves and bars, as plotly understands them."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

from hyperfab.report.page.parts import Chart

Values = Sequence[float | None]

#: Colours that are told apart on white and on black, also by most who see few colours (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31")


def label(text: object) -> str:
    """Return text that plotly shows as it is: it reads a little HTML in labels."""
    return html.escape(str(text), quote=False)


def line(
    name: str, x: Values, y: Values, colour: int = 0, *, dash: str = "solid", points: bool = False
) -> dict[str, Any]:
    """Return a curve, or points where ``points``."""
    shade = COLOURS[colour % len(COLOURS)]
    trace: dict[str, Any] = {"type": "scatter", "name": label(name), "x": list(x), "y": list(y)}
    if points:
        return {**trace, "mode": "markers", "marker": {"color": shade, "size": 7, "symbol": "circle-open"}}
    return {**trace, "mode": "lines", "line": {"color": shade, "dash": dash, "width": 2}}


def bars(name: str, x: Sequence[Any], y: Values, colour: int = 0) -> dict[str, Any]:
    """Return bars."""
    names = [label(item) if isinstance(item, str) else item for item in x]
    shade = COLOURS[colour % len(COLOURS)]
    return {"type": "bar", "name": label(name), "x": names, "y": list(y), "marker": {"color": shade}}


def chart(caption: str, alt: str, x: str, y: str, data: list[dict[str, Any]], **layout: Any) -> Chart:
    """Return a chart with titled axes."""
    axes: dict[str, Any] = {
        "xaxis": {"title": {"text": label(x)}, "automargin": True, **layout.pop("xaxis", {})},
        "yaxis": {"title": {"text": label(y)}, "automargin": True, **layout.pop("yaxis", {})},
        "showlegend": len(data) > 1,
    }
    return Chart(caption, alt, data, {**axes, **layout})
