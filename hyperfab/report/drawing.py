"""What the pictures have in common: the bars of an interval, and how a figure becomes a file."""

from __future__ import annotations

import io
from typing import Any


def png(figure: Any, dpi: float | None = None) -> bytes:
    """Return a figure as PNG, the same bytes each time."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dpi or figure.dpi, metadata={"Software": None})
    return stream.getvalue()


def draw_interval(
    axes: Any,
    at: tuple[float, float],
    *,
    force: tuple[float, float] | None = None,
    across: tuple[float, float] | None = None,
    colour: Any,
) -> None:
    """Draw bars through the point ``at``, along the interval of its ``force`` and of what is ``across``."""
    for ends, value, place in ((across, at[0], "xerr"), (force, at[1], "yerr")):
        if ends is not None:
            off = [[max(value - ends[0], 0.0)], [max(ends[1] - value, 0.0)]]
            axes.errorbar(*at, **{place: off}, color=colour, capsize=4, linewidth=1.2)
