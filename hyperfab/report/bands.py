"""A figure with its uncertainty, as people read it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from math import floor, log10
from typing import Any

from hyperfab.report.labels import parted

#: Figures whose budget is told in a sentence.
HEADLINES = (
    "force_N", "stress_max_MPa", "stress_warp_max_MPa", "warmup_time_s", "work_surface.spread_K", "energy.supplied_J",
    "contact_fraction", "pressure_max_MPa", "gap_mean_mm",
)  # fmt: skip

#: A number whose standard deviation is so many times as large is not told by what it was found from.
_NOT_TOLD = 10.0
#: Figures below this are told with a power of ten.
_SMALL = 1e-5


def figure(value: float, sd: float) -> str:
    """Return a value rounded by its standard deviation, of which two figures are told (one from 3 to 9).

    >>> figure(41.76324, 1.4987), figure(0.01234, 0.00056), figure(1234.5, 310.0), figure(7.0, 1e-15)
    ('41.8 ± 1.5', '0.0123 ± 0.0006', '1200 ± 300', '7')
    >>> figure(2.41e-26, 4.2e-24), figure(2.513e-7, 3.1e-9)
    ('(0 ± 4)e-24', '(2.51 ± 0.03)e-07')
    """
    if not sd > 1e-9 * abs(value):  # of a sum, what rounding leaves
        return f"{value:.6g}"
    larger = max(abs(value), sd)
    if larger < _SMALL:  # or it would be all noughts
        scale = 10.0 ** floor(log10(larger))
        return f"({_rounded(value / scale, sd / scale)} ± {_rounded(sd / scale, sd / scale)})e{log10(scale):03.0f}"
    return f"{_rounded(value, sd)} ± {_rounded(sd, sd)}"


def determined(value: float, sd: float) -> bool:
    """Whether a number, unless it is none, is told at all by what its standard deviation rests on.

    >>> determined(0.6, 0.4), determined(0.6, 1e6)
    (True, False)
    """
    return value == 0.0 or sd < _NOT_TOLD * abs(value)


def constant(value: float, sd: float) -> str:
    """Return a constant rounded by its standard deviation, as it stands where it is not determined.

    >>> constant(0.5982, 0.0123), constant(0.5982, 1.1e6)
    ('0.598 ± 0.012', '0.598 (undetermined)')
    """
    return figure(value, sd) if determined(value, sd) else f"{value:.3g} (undetermined)"


def interval(low: float, high: float, sd: float) -> tuple[str, str]:
    """Return the ends of an interval, rounded as the figure itself.

    >>> interval(198.0312, 199.4121, 0.2081), interval(8631000.0, 9408000.0, 2.0e5)
    (('198.03', '199.41'), ('8630000', '9410000'))
    """
    return _rounded(low, sd), _rounded(high, sd)


def _rounded(value: float, sd: float) -> str:
    if not sd > 0.0:
        return f"{value:.6g}"
    place = floor(log10(sd))
    if f"{sd / 10.0**place:.1f}" < "3":  # 1.5 rather than 2, and 10 is as short as 9
        place -= 1
    return f"{round(value, -place):.0f}" if place >= 0 else f"{value:.{-place}f}"


def shares(budget: Sequence[Any], most: int = 3) -> str:
    """Return what a figure's uncertainty is made of, in per cent, the largest first.

    >>> shares([{"source": "warp", "share": 0.8}, {"source": "weft", "share": 0.195}, {"source": "t", "share": 0.005}])
    'warp 80 %, weft 20 %'
    """
    parts = [(one["source"], one["share"]) if isinstance(one, Mapping) else (one.source, one.share) for one in budget]
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
    value, band = value_of(data, key), _bands(data).get(key)
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


def evenness(data: Mapping[str, Any], spread: float | None = None) -> str:
    """Return by how much the work surface of a heat document is uneven [K]: half of its ``spread``, at the end of the
    run if that is not given, with the interval it has there.

    It is nowhere less than in the run itself and may be much more: the interval says it, a deviation would not.

    >>> evenness({"work_surface": {"spread_K": 2.28}})
    '±1.14 K'
    >>> band = {"sd": 0.4, "low": 2.28, "high": 3.78}
    >>> evenness({"work_surface": {"spread_K": 2.28}, "uncertainty": {"quantities": {"work_surface.spread_K": band}}})
    '±1.14 K (95 %: 1.14 to 1.89)'
    """
    own = data["work_surface"]["spread_K"]
    text = f"±{(own if spread is None else spread) / 2:.2f} K"
    band = _bands(data).get("work_surface.spread_K")
    if band is None or spread not in (None, own):
        return text
    low, high = interval(band["low"] / 2, band["high"] / 2, band["sd"] / 2)
    return f"{text} (95 %: {low} to {high})"


def greatest_stretch(data: Mapping[str, Any]) -> tuple[float, str]:
    """Return the greatest stretch of a draped sheet, and the threads it is along: of a membrane none, a principal
    stretch lies along neither.

    >>> ways = {"warp": {"stretch_max": 1.2}, "weft": {"stretch_max": 1.1}}
    >>> greatest_stretch(ways), greatest_stretch({"sheet": "membrane", "stretch_max": 1.25, **ways})
    ((1.2, ', along warp'), (1.25, ''))
    """
    way = max(("warp", "weft"), key=lambda way: data[way]["stretch_max"])
    most = data.get("stretch_max") or data[way]["stretch_max"]
    return float(most), f", along {way}" if data.get("sheet", "net") == "net" else ""


def made_of(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines on what the uncertainty of the headline figures is made of, one for all that are made alike; none
    where the document has no uncertainty."""
    alike: dict[str, list[str]] = {}
    for key, band in _bands(data).items():
        if key in HEADLINES:
            alike.setdefault(shares(band["budget"]), []).append(parted(key)[0].replace(".", " "))
    for budget, names in alike.items():
        yield f"uncertainty of {', '.join(names)}: {budget} ({data['uncertainty']['method']}, ± one sd)"


def value_of(data: Mapping[str, Any], key: str) -> Any:
    """Return what stands under a key of a document, with dots where it stands deeper."""
    value: Any = data
    for step in key.split("."):
        value = value[step]
    return value


def _bands(data: Mapping[str, Any]) -> Mapping[str, Any]:
    return (data.get("uncertainty") or {}).get("quantities", {})
