"""A figure with its uncertainty, as people read it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from math import floor, log10
from typing import Any

from hyperfab.report.labels import title


def figure(value: float, sd: float) -> str:
    """Return a value rounded by its standard deviation, of which two figures are told (one from 3 to 9).

    >>> figure(41.76324, 1.4987), figure(0.01234, 0.00056), figure(1234.5, 310.0), figure(7.0, 0.0)
    ('41.8 ± 1.5', '0.0123 ± 0.0006', '1200 ± 300', '7')
    """
    if not sd > 0.0:
        return f"{value:.6g}"
    place = floor(log10(sd))
    if f"{sd / 10.0**place:.1f}" < "3":  # 1.5 rather than 2, and 10 is as short as 9
        place -= 1
    if place >= 0:
        return f"{round(value, -place):.0f} ± {round(sd, -place):.0f}"
    return f"{value:.{-place}f} ± {sd:.{-place}f}"


def shares(budget: Sequence[Any], most: int = 3) -> str:
    """Return what a figure's uncertainty is made of, in per cent, the largest first.

    >>> shares([{"source": "warp", "share": 0.8}, {"source": "weft", "share": 0.195}, {"source": "t", "share": 0.005}])
    'warp 80 %, weft 20 %'
    """
    parts = [
        (one["source"], one["share"]) if isinstance(one, Mapping) else (one.source, one.share)
        for one in budget
    ]
    return ", ".join(f"{source} {100.0 * share:.0f} %" for source, share in parts[:most] if share >= 0.01)


def banded(data: Mapping[str, Any], key: str, unit: str = "", factor: float = 1.0, form: str = ".4g") -> str:
    """Return a figure of a document for a sentence, rounded by its uncertainty where it has one, with its unit.

    One that ``form`` rounds away is left out: a table tells it.

    >>> banded({"force_N": 41.76324}, "force_N", "N")
    '41.76 N'
    >>> banded({"force_N": 41.76324, "uncertainty": {"quantities": {"force_N": {"sd": 1.5}}}}, "force_N", "N")
    '41.8 ± 1.5 N'
    >>> banded({"force_N": 41.76324, "uncertainty": {"quantities": {"force_N": {"sd": 0.0015}}}}, "force_N", "N")
    '41.76 N'
    """
    value: Any = data
    for step in key.split("."):
        value = value[step]
    band = _bands(data).get(key)
    text = format(factor * value, form)
    if band is not None:
        whole = figure(factor * value, factor * band["sd"])
        # The last digit shown stands for so much.
        digit = 10.0 ** int(Decimal(text).as_tuple().exponent)
        text = whole if factor * band["sd"] >= 0.5 * digit else text
    return f"{text} {unit}".strip()


def warmup(data: Mapping[str, Any]) -> str:
    """Return the time to warm-up of a heat document as every place tells it.

    >>> warmup({"warmup_time_s": 1178.34}), warmup({"warmup_time_s": 3000.6})
    ('19.6 min', '50.0 min')
    """
    return banded(data, "warmup_time_s", "min", 1.0 / 60.0, ".1f")


def made_of(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line on what the first figure's uncertainty is made of; none where the document has no uncertainty."""
    for key, band in list(_bands(data).items())[:1]:
        yield f"uncertainty of {title(key)}: {shares(band['budget'])} ({data['uncertainty']['method']}, ± one sd)"


def _bands(data: Mapping[str, Any]) -> Mapping[str, Any]:
    found: Mapping[str, Any] = (data.get("uncertainty") or {}).get("quantities", {})
    return found
