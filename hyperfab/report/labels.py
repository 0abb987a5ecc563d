"""What pictures and the page have in common: names that end in their unit as people read them, colours that mean
something, the bars of an interval, and how a figure becomes a file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

#: Orange for the model as it was, blue for the model as it is, grey for what was measured; on paper and on the page.
BEFORE, AFTER, DATA = "#d55e00", "#0072b2", "#6b7683"
#: Colours that are told apart on white and on black, also by most who see few colours (Okabe and Ito).
COLOURS = (AFTER, BEFORE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31")

#: Ends of names, the longest first, and the unit they stand for.
_UNITS = {
    "_m2K_W": "m²K/W", "_W_m2K": "W/m²K", "_W_m2_K": "W/m²K", "_W_m2": "W/m²", "_W_K": "W/K", "_J_K": "J/K",
    "_J_mol": "J/mol", "_mm2_N": "mm²/N", "_mm_kN": "mm/kN", "_mm_N": "mm/N", "_K_m": "K/m", "_K_s2": "K/s²",
    "_K_s3": "K/s³", "_MPa_s": "MPa/s", "_N_mm": "N/mm", "_MPa_mm": "MPa/mm", "_mm_per_unit": "mm a unit",
    "_K_s": "K/s", "_1_K": "1/K", "_1_s": "1/s", "_per_K2": "1/K²", "_per_K": "1/K", "_mm2": "mm²", "_g_m2": "g/m²",
    "_degC": "°C", "_deg": "°", "_MPa": "MPa", "_kPa": "kPa", "_mm": "mm", "_min": "min", "_kg": "kg", "_kJ": "kJ",
    "_MJ": "MJ", "_J": "J", "_N": "N", "_K": "K", "_s": "s", "_W": "W",
}  # fmt: skip
#: Names that do not say enough by themselves.
_WORDS = {
    "log rate": "rate of stretching, 1/s",
    "x0_mm": "x on the flat sheet, mm",
    "y0_mm": "y on the flat sheet, mm",
    "direction_deg": "direction, ° from warp",
    "from the middle_mm": "distance from the middle, mm",
}
#: States that say where on a sheet or mold a reading was taken.
PLACES = (("x0_mm", "y0_mm"), ("x_mm", "y_mm"))
#: What a number stands for where it numbers things.
_VALUES = {
    "branch": {-1: "unloading", 0: "not stated", 1: "loading"},
    "axis": {0: "x", 1: "y", 2: "z"},
}


def title(name: str) -> str:
    """Return what stands on an axis or before a figure: words, and the unit after a comma.

    >>> title("force_N"), title("work_surface_mean_degC"), title("softening_1_K"), title("stretch")
    ('force, N', 'work surface mean, °C', 'softening, 1/K', 'stretch')
    """
    if name in _WORDS:
        return _WORDS[name]
    words, unit = parted(name)
    return f"{words}, {unit}" if unit else words


def parted(name: str) -> tuple[str, str]:
    """Return the words of a name and its unit.

    >>> parted("gap_min_mm"), parted("C10_MPa"), parted("weft_more"), parted("rim_slip_mm2_N")
    (('gap min', 'mm'), ('C10', 'MPa'), ('weft more', ''), ('rim slip', 'mm²/N'))
    """
    for end, unit in _UNITS.items():
        if name.endswith(end) and len(name) > len(end):
            return name.removesuffix(end).replace("_", " ").strip(), unit
    return name.replace("_", " ").strip(), ""


def value_names(name: str, values: Sequence[float], known: Sequence[str] = ()) -> list[str]:
    """Return what the distinct ``values`` of a state stand for: names where they number things, else themselves.

    >>> value_names("branch", [-1.0, 1.0]), value_names("temperature_degC", [23.0, 80.0])
    (['unloading', 'loading'], ['23', '80'])
    """
    names = dict(enumerate(known)) or _VALUES.get(name, {})
    return [names.get(int(v), f"{v:.4g}") if v == int(v) else f"{v:.4g}" for v in values]


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
