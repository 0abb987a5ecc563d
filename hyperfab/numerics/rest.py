"""What a curve reads where nothing is pulled yet. Stretch and stress (n,) in the order they were read."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.doubt import FAR, Doubt, leap, scatter

#: A reading before the pull beyond this share of the peak is an offset.
OFFSET = 0.02
#: A pull that begins beyond this share of its way, its stress rising from there by less than a tenth of its slope, was
#: not counted from its own rest: of a stress that rises as the exponential of the strain, ten e-folds would lie before.
_BEGUN, _SECANT = 0.05, 0.1


def starts_off(way: Array, stress: Array) -> bool:
    """Return whether the first row, before the pull, reads what those behind it do not: an amplifier switched on."""
    if len(stress) < 8 or abs(way[0] - 1.0) > 1e-6:
        return False
    least = leap(stress[1:], float(np.abs(stress[1:]).max()))
    return bool(abs(stress[0]) > least and abs(stress[0] - stress[1]) > max(least, 4.0 * abs(stress[2] - stress[1])))


def offset(stretch: Array, stress: Array, stretch2: Array | None) -> Iterator[Doubt]:
    """Tell a stress before the pull: the load cell was not at zero, or the specimen is clamped taut."""
    rest = np.abs(stretch - 1.0) <= 1e-6
    if stretch2 is not None:
        rest &= np.abs(stretch2 - 1.0) <= 1e-6
    begin = int(starts_off(stretch, stress))
    first = int(np.argmin(rest)) if not rest.all() else 0
    if first <= begin:
        return
    peak, mean = float(np.abs(stress[begin:]).max()), float(np.mean(stress[begin:first]))
    if abs(mean) > max(OFFSET * peak, FAR * scatter(stress)):
        yield Doubt(
            "offset",
            tuple(range(begin, first)),
            abs(mean) / peak,
            f"the stress is {100 * mean / peak:.0f} % of the peak at a stretch of 1, before the pull",
            "--zero counts from the first row",
        )


def unzeroed(way: Array, stress: Array) -> Iterator[Doubt]:
    """Tell a stretch that is not counted from where the specimen begins to carry: a channel not set to zero."""
    strain = way - 1.0
    top = int(np.abs(strain).argmax())
    few = max(5, top // 10)
    begun = strain[0] / strain[top] if strain[top] else 0.0
    if top < 2 * few or begun < _BEGUN:
        return
    slope = np.polyfit(strain[:few], stress[:few], 1)[0]
    level = np.median(stress[:3])
    sure = abs(slope * np.ptp(strain[:few])) > FAR * scatter(stress) * np.sqrt(12.0 / few)
    rises = sure and slope * strain[top] * stress[top] > 0.0
    if rises and abs(level) < _SECANT * abs(slope * strain[0]):
        yield Doubt(
            "unzeroed",
            (0,),
            float(begun),
            f"the stretch is {way[0]:.4g} in the first row, and the stress rises from nothing there",
            "is it counted from elsewhere? --zero counts from the first row",
        )
