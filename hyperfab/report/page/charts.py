"""Charts for the page: curves and bars, as plotly understands them."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

from hyperfab.report.labels import COLOURS
from hyperfab.report.page.parts import Chart

Values = Sequence[float | None]


def label(text: object) -> str:
    """Return text that plotly shows as it is: it reads a little HTML in labels."""
    return html.escape(str(text), quote=False)


def line(
    name: str,
    x: Values,
    y: Values,
    colour: int | str = 0,
    *,
    dash: str = "solid",
    points: bool = False,
    symbol: str = "circle-open",
    legend: bool = True,
) -> dict[str, Any]:
    """Return a curve, or points where ``points``: light, so that a line is seen over them."""
    shade = COLOURS[colour % len(COLOURS)] if isinstance(colour, int) else colour
    trace: dict[str, Any] = {"type": "scatter", "name": label(name), "x": list(x), "y": list(y)}
    if not legend:
        trace["showlegend"] = False
    if points:
        marker = {"color": shade, "size": 6, "symbol": symbol, "opacity": 0.55}
        return {**trace, "mode": "markers", "marker": marker}
    return {**trace, "mode": "lines", "line": {"color": shade, "dash": dash, "width": 2.5}}


def dots(
    name: str,
    x: Values,
    y: Values,
    shades: Values,
    *,
    low: float,
    high: float,
    unit: str,
    bar: bool,
    axes: str,
) -> dict[str, Any]:
    """Return points coloured by a value on a scale from low to high, on both sides of nothing where low is less;

    ``bar`` shows the scale, ``axes`` is the number of the panel.
    """
    marker: dict[str, Any] = {
        "color": list(shades),
        "cmin": low,
        "cmax": high,
        "colorscale": "RdBu" if low < 0.0 else "Viridis",
        "reversescale": low < 0.0,
        "size": 8,
        "line": {"width": 0.5, "color": "#6b7683"},
        "showscale": bar,
    }
    if bar:
        marker["colorbar"] = {"title": {"text": label(unit), "side": "right"}, "thickness": 12}
    return {
        "type": "scatter",
        "mode": "markers",
        "name": label(name),
        "x": list(x),
        "y": list(y),
        "marker": marker,
        "xaxis": f"x{axes}",
        "yaxis": f"y{axes}",
    }


def bars(name: str, x: Sequence[Any], y: Values, colour: int = 0) -> dict[str, Any]:
    """Return bars."""
    names = [label(item) if isinstance(item, str) else item for item in x]
    shade = COLOURS[colour % len(COLOURS)]
    return {"type": "bar", "name": label(name), "x": names, "y": list(y), "marker": {"color": shade}}


def chart(caption: str, alt: str, x: str, y: str, data: list[dict[str, Any]], **layout: Any) -> Chart:
    """Return a chart with titled axes."""
    axes: dict[str, Any] = {
        "xaxis": {"title": {"text": label(x), "standoff": 8}, "automargin": True, **layout.pop("xaxis", {})},
        "yaxis": {"title": {"text": label(y)}, "automargin": True, **layout.pop("yaxis", {})},
        "showlegend": len(data) > 1,
    }
    return Chart(caption, alt, data, {**axes, **layout})
