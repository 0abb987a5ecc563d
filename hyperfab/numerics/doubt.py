"""What is odd about a measured curve, and from which size on it is said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array

#: Steps below this share of the whole way, or of the peak, are no remark's business.
SMALL_STEP, SMALL_LEAP = 0.003, 0.05
#: So many standard deviations of its own scatter make a step, of which a curve has hundreds, no chance.
FAR = 8.0


@dataclass(frozen=True)
class Doubt:
    """What is odd about a curve: its ``kind``, the rows (of the arrays given), a size as a share, and the words.

    Kinds: ``unloading``, ``cycles``, ``lost``, ``step-back``, ``drop``, ``spike``, ``ringing``, ``saturation``,
    ``doubled``, ``offset``, ``unzeroed``, ``failing``.
    """

    kind: str
    rows: tuple[int, ...]
    size: float
    text: str
    remedy: str


def leap(readings: Array, size: float) -> float:
    """Return what readings (n,) change by from row to row, at least, where that is no chance and no remark's business.

    It is a share of their ``size``, the peak or the range, or a multiple of their scatter.
    """
    return max(SMALL_LEAP * size, 1.5 * FAR * scatter(readings))


def pace(steps: Array, spans: Array) -> float:
    """Return the speed below which half of a way is gone, whose ``steps`` (n,) took the times ``spans`` (n,).

    >>> pace(np.array([1.0, 0.0, -2.0, 0.1]), np.array([1.0, 50.0, 1.0, 9.0]))
    2.0
    """
    way = np.abs(steps)
    speed = way / np.maximum(spans, 1e-12)  # a time may stand twice
    order = np.argsort(speed)
    travel = np.cumsum(way[order])
    return float(speed[order][np.searchsorted(travel, 0.5 * travel[-1])])


def scatter(values: Array) -> float:
    """Return the standard deviation of a reading about its neighbours, by second differences, robustly.

    On a coarse curve its curvature counts as scatter: such a curve draws fewer remarks, not more.
    """
    if len(values) < 5:
        return float(np.ptp(values)) if len(values) else 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0))


def moving(stretch: Array, across: Array) -> Array:
    """Return the one of two stretches that moves most, the first where they move alike.

    >>> moving(np.array([1.0, 1.0]), np.array([1.0, 1.2]))
    array([1. , 1.2])
    """
    return across if float(np.ptp(across)) > float(np.ptp(stretch)) else stretch
