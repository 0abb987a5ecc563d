"""Two layers pressed on each other: one pressure in both, their compressions add up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.pressing import foam_law
from hyperfab.pressing.foam_law import FoamLaw

#: A layer yields this share of its largest stress per strain at least: where a curve is level, its strain is not told.
_LEVEL = 1e-9
#: How far beyond its limit a law is followed along its last slope [-]; two bare molds are nowhere near.
_BEYOND = 10.0
#: Layers share a closing to this part of it, in no more rounds than halving it would take.
_SHARED, _ROUNDS = 1e-13, 60
#: Strain near which layers without any resistance count as flat.
_NEARLY_FLAT = 0.998


@dataclass(frozen=True)
class Series:
    """A ``first`` and a ``second`` law in series, straight between the pressures at which one of them bends.

    >>> both = Series(foam_law.linear(0.02), foam_law.linear(0.06))
    >>> at = both.at(np.array([2.0]), 3.0, 3.0)  # 2 mm of closing, shared out by 3 to 1
    >>> [part.round(6).item() for part in (at.strain, at.second, at.pressure, at.energy)]
    [0.5, 0.166667, 0.01, 0.01]
    """

    first: FoamLaw
    second: FoamLaw

    @cached_property
    def knots(self) -> tuple[Array, Array, Array, Array, Array]:
        """Pressures (k,) [MPa], strains of both (k,), and the energies of both there (k,) [MPa]."""
        return knots(self.first, self.second)

    def at(self, closing: Array, first: float | Array, second: float | Array) -> Shared:
        """Return how layers ``first`` and ``second`` [mm] thick, (n,) or numbers, share a ``closing`` (..., n) [mm]."""
        closing = np.maximum(closing, 0.0)
        if self.first.places is not None:
            return self._by_place(closing, first, second)
        pressure, one, two, energy_one, energy_two = self.knots
        low = np.zeros(np.broadcast(closing, first, second).shape, dtype=np.int64)
        high = np.full(low.shape, len(pressure) - 1)
        for _ in range(int(np.ceil(np.log2(len(pressure))))):
            middle = (low + high) // 2
            under = first * one[middle] + second * two[middle] <= closing
            low, high = np.where(under, middle, low), np.where(under, high, middle)
        high = low + 1
        begun = first * one[low] + second * two[low]
        span = first * one[high] + second * two[high] - begun
        t = np.where(span > 0.0, (closing - begun) / np.where(span > 0.0, span, 1.0), 0.0)
        rise = pressure[high] - pressure[low]
        now = pressure[low] + t * rise
        return Shared(
            strain=one[low] + t * (one[high] - one[low]),
            second=two[low] + t * (two[high] - two[low]),
            pressure=now,
            stiffness=np.where(closing > 0.0, rise / np.where(span > 0.0, span, np.inf), 0.0),
            energy=first * energy_one[low] + second * energy_two[low] + 0.5 * (pressure[low] + now) * (closing - begun),
        )

    def _by_place(self, closing: Array, first: float | Array, second: float | Array) -> Shared:
        """The same where the first law is another at each place: its strain by Newton's method, held in a bracket."""
        strains, pressures = _straight(self.second)
        slopes = np.diff(strains) / np.diff(pressures)
        stored = np.concatenate([[0.0], np.cumsum(0.5 * (pressures[1:] + pressures[:-1]) * np.diff(strains))])

        def yields(pressure: Array) -> tuple[Array, Array, Ints]:
            k = np.clip(np.searchsorted(pressures, pressure, side="right") - 1, 0, len(slopes) - 1)
            rate = slopes[k]
            return strains[k] + rate * (pressure - pressures[k]), rate, k

        low, high = np.zeros(closing.shape), closing / first
        strain = high
        for _ in range(_ROUNDS):
            pressure, slope = self.first.stress(strain), self.first.slope(strain)
            across, rate, _ = yields(pressure)
            over = first * strain + second * across - closing
            if np.abs(over).max(initial=0.0) <= _SHARED * np.max(closing, initial=0.0):
                break
            low, high = np.where(over < 0.0, strain, low), np.where(over < 0.0, high, strain)
            following = strain - over / (first + second * rate * slope)
            outside = (following < low) | (following > high)
            strain = np.where(outside, 0.5 * (low + high), following)
        pressure = self.first.stress(strain)
        across, rate, k = yields(pressure)
        slope = self.first.slope(strain)
        energy = stored[k] + 0.5 * (pressures[k] + pressure) * (across - strains[k])
        return Shared(
            strain=strain,
            second=across,
            pressure=pressure,
            stiffness=np.where(closing > 0.0, slope / (first + second * rate * slope), 0.0),
            energy=first * self.first.energy(strain) + second * energy,
        )


def knots(first: FoamLaw, second: FoamLaw | None) -> tuple[Array, Array, Array, Array, Array]:
    """Return pressures (k,) [MPa], the strains of two laws in series there (k,), and the energies of both (k,) [MPa].

    A second law of None is rigid.

    >>> [rows[1].round(6).item() for rows in knots(foam_law.linear(0.02), None)]
    [0.02, 1.0, 0.0, 0.01, 0.0]
    """
    laws = [_straight(first)] + ([] if second is None else [_straight(second)])
    pressure = np.unique(np.concatenate([[0.0], *(law[1] for law in laws)]))
    strains = [np.interp(pressure, law[1], law[0]) for law in laws]
    middle = 0.5 * (pressure[1:] + pressure[:-1])
    energies = [np.concatenate([[0.0], np.cumsum(middle * np.diff(e))]) for e in strains]
    if second is None:
        strains, energies = [*strains, np.zeros(len(pressure))], [*energies, np.zeros(len(pressure))]
    return pressure, strains[0], strains[1], energies[0], energies[1]


@dataclass(frozen=True)
class Shared:
    """What a closing does: the ``strain`` of the first layer and of the ``second``, the ``pressure`` [MPa], what it
    gains per closing (``stiffness`` [MPa/mm]), and the ``energy`` [N/mm] of both."""

    strain: Array
    second: Array
    pressure: Array
    stiffness: Array
    energy: Array


def together(layers: Sequence[tuple[float, FoamLaw | None]]) -> FoamLaw | None:
    """Return the law of layers on each other by their thickness [mm], None for all that is rigid.

    >>> stack = together([(1.0, foam_law.linear(0.1)), (3.0, None)])
    >>> round(stack.stress(0.125).item(), 8)
    0.05
    >>> round(together([(1.0, foam_law.linear(0.1)), (2.0, foam_law.linear(0.1))]).stress(0.5).item(), 8)
    0.05
    """
    soft = [(_straight(law), thick) for thick, law in layers if law is not None and thick > 0.0]
    if not soft:
        return None
    whole = sum(thick for thick, _ in layers)
    last = max(one[1][-2] for one, _ in soft)
    pressure = np.unique(np.concatenate([one[1] for one, _ in soft]))
    pressure = pressure[pressure <= last]
    strain = np.asarray(sum(thick / whole * np.interp(pressure, one[1], one[0]) for one, thick in soft))
    kept = np.append(True, np.diff(strain) > 0.0) & (strain < 1.0)
    if strain[-1] >= 1.0:  # laws that go down to nothing: a table ends a little before
        end = 0.5 * (1.0 + max(float(strain[kept][-1]), _NEARLY_FLAT))
        pressure = np.append(pressure[kept], np.interp(end, strain, pressure))
        return foam_law.table(np.append(strain[kept], end), pressure)
    return foam_law.table(strain[kept], pressure[kept])


def _straight(law: FoamLaw) -> tuple[Array, Array]:
    """Strains and stresses of a law between which it is taken as straight; both rise."""
    strain = np.append(law.knots, law.limit + _BEYOND)
    stress = law.stress(strain)
    return strain, stress + _LEVEL * stress[-2] * strain
