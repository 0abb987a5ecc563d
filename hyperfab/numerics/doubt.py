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

    Kinds: ``unloading``, ``cycles``, ``step-back``, ``drop``, ``spike``, ``ringing``, ``saturation``, ``doubled``,
    ``offset``, ``unzeroed``, ``failing``.
    """

    kind: str
    rows: tuple[int, ...]
    size: float
    text: str
    remedy: str


def scatter(values: Array) -> float:
    """Return the standard deviation of a reading about its neighbours, by second differences, robustly.

    On a coarse curve its curvature counts as scatter: such a curve draws fewer remarks, not more.
    """
    if len(values) < 5:
        return float(np.ptp(values)) if len(values) else 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0))
