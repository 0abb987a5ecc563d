"""The tests of a fabric and its law, as the entries of the catalogue are scaled to them."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Flags
from hyperfab.curve import TestCurve
from hyperfab.loop.fabric_tests import ONE_PACE, setups_of
from hyperfab.materials.effects.path import GENERAL, Path
from hyperfab.materials.law import Array, Law


def _folded(angles: Array) -> Array:
    return np.minimum(angles % 180.0, -angles % 180.0)


def is_slanted(angles: Array) -> Flags:
    """Return which directions [deg from the warp] lie between warp and weft, on either side of the warp; none unknown.

    >>> is_slanted(np.array([0.0, 45.0, 90.0, 150.0, np.nan])).tolist()
    [False, True, False, True, False]
    """
    folded = _folded(angles)
    return np.asarray((folded > 1.0) & (folded < 89.0))


@dataclass(frozen=True)
class DataContext:
    """A law, its constants as they stand, and the measured curves.

    ``directions``: warp and weft have constants of their own; ``transverse``: contraction was measured; ``replicated``:
    most specimens were led as some other was, of another size perhaps; ``anisotropic``: constants of its own, or
    threads, make each direction answer in its own way; ``on_specimen``: all stretches were read on specimens.
    """

    law: Law
    constants: tuple[float, ...]
    path: Path
    stress: Array
    directions: bool = False
    transverse: bool = False
    replicated: bool = False
    anisotropic: bool = False
    on_specimen: bool = False

    @property
    def peak_stress(self) -> float:
        """Largest measured stress [MPa]."""
        return float(np.max(np.abs(self.stress), initial=0.0)) or 1.0

    @property
    def reach(self) -> float:
        """Largest strain in the data, of what was pressed that of a pull as far."""
        return self.path.reach

    def reach_along(self, weft: bool) -> float:
        """Largest strain of what was pulled along the warp or the ``weft``, or between."""
        share = np.abs(self.path.weft_share - (not weft))
        return max(float(np.max(self.path.outward.stretch[share > 1e-6], initial=1.0)) - 1.0, 1e-3)

    @property
    def reach_of_grips(self) -> float:
        """Largest strain in the data, as length in the first specimen whose length is stated."""
        shorter = self.path.shorter
        strain = self.path.outward.stretch - 1.0
        return self.reach if shorter is None else max(float(np.max(strain / shorter)), 1e-3)

    @property
    def least_reach(self) -> float:
        """Largest strain of the direction that was pulled least."""
        angle, strain = self.path.angle_deg, self.path.outward.stretch - 1.0
        return max(min((float(np.max(strain[angle == one])) for one in self.angles), default=self.reach), 1e-3)

    @property
    def energy(self) -> float:
        """Size of the strain energy at the largest strain [MPa]."""
        return 0.4 * self.peak_stress * self.reach

    @property
    def unloads(self) -> bool:
        """Whether any specimen was let go again."""
        return bool(np.any(self.path.up < 0))

    @property
    def several_rates(self) -> bool:
        """Whether specimens were pulled at rates further apart than one pace is kept, or held; of one direction where
        each answers in a way of its own."""
        # A test that states no direction is one along the warp.
        way = _folded(np.nan_to_num(self.path.angle_deg)).round(6) * self.anisotropic
        return any(map(self._tell_time, self._together(lambda rows: float(way[rows.start]))))

    @property
    def clocks(self) -> int:
        """At how many temperatures specimens were pulled at several rates, or held."""
        degrees = self.path.temperature_degC
        return sum(
            map(self._tell_time, self._together(lambda rows: float(np.round(2.0 * np.mean(degrees[rows])) / 2.0)))
        )

    def _together(self, state: Callable[[slice], float]) -> list[list[slice]]:
        found: dict[float, list[slice]] = {}
        for rows in self.path.curves:
            found.setdefault(state(rows), []).append(rows)
        return list(found.values())

    @property
    def paces(self) -> Array:
        """The rates at which specimens were pulled [1/s], each further from the last than one pace is kept."""
        return self._paces(self.path.curves)

    def _paces(self, curves: Sequence[slice]) -> Array:
        speed = np.abs(self.path.speed)
        going = [speed[rows][speed[rows] > 0.0] for rows in curves]
        found: list[float] = []
        for pace in sorted(float(np.median(one)) for one in going if len(one)):
            if not found or pace > ONE_PACE * found[-1]:
                found.append(pace)
        return np.array(found)

    def _tell_time(self, curves: Sequence[slice]) -> bool:
        return len(self._paces(curves)) > 1 or any(self.path.still[rows].any() for rows in curves)

    @property
    def angles(self) -> Array:
        """The directions in the data [deg]."""
        known = self.path.angle_deg[np.isfinite(self.path.angle_deg)]
        return np.unique(known)

    @property
    def slanted(self) -> Array:
        """The directions in the data between warp and weft, either side of the warp alike [deg]."""
        return self.ways[is_slanted(self.ways)]

    @property
    def tells_coupling(self) -> bool:
        """Whether warp and weft were tested, and what a pull along one does across: both pulled, or contraction
        read."""
        return len(self.angles) > 1 and (self.transverse or bool(np.any(self.path.mode == GENERAL)))

    @property
    def ways(self) -> Array:
        """The directions in the data to a sheet that is alike on either side of the warp [deg]."""
        return np.unique(_folded(self.angles).round(6))

    def has_one_curve(self, *, turns: bool, softens: bool) -> bool:
        """Whether all tests are alike but for the specimen, the rate and the amplitude.

        So are those of several directions where nothing ``turns`` with these, and of several temperatures where
        nothing ``softens`` with them.
        """
        several = (turns and len(self.angles) > 1) or (softens and len(self.temperatures) > 1)
        return self.has_one_mode and not several

    @property
    def led_alike(self) -> bool:
        """Whether one stretch tells the others in all tests, but for how a strip contracts: they are of one kind, and
        not of two axes pulled each in its way."""
        return len(np.unique(self.path.mode)) < 2 and not np.any(self.path.mode == GENERAL)

    @property
    def has_one_mode(self) -> bool:
        """Whether all tests are of one kind, and their stretch is all that was read."""
        return len(np.unique(self.path.mode)) < 2 and not self.transverse

    @property
    def each_way_at_its_own_heat(self) -> bool:
        """Whether every direction was tested at one temperature, and at that no other direction."""
        path = self.path
        states = np.column_stack([path.angle_deg, np.round(2.0 * path.temperature_degC) / 2.0])
        states = states[np.isfinite(states).all(axis=1)]
        ways, heats = (len(np.unique(column)) for column in states.T)
        return ways > 1 and ways == heats == len(np.unique(states, axis=0))

    @property
    def each_at_its_own_heat(self) -> bool:
        """Whether there are hardly more specimens than temperatures, each at one: how stiff it is by itself would pass
        for what heat does."""
        told, specimens = self.path.temperature_degC, self.path.curves
        return 1 < len(specimens) < 1.5 * len(self.temperatures) and all(np.ptp(told[rows]) < 0.5 for rows in specimens)

    @property
    def temperatures(self) -> Array:
        """The temperatures in the data [degC], a half-degree apart."""
        known = self.path.temperature_degC[np.isfinite(self.path.temperature_degC)]
        return np.unique(np.round(known * 2.0) / 2.0)

    @property
    def times(self) -> tuple[float, float]:
        """The shortest time that rows resolve and the longest test [s]."""
        steps = self.path.elapsed[self.path.elapsed > 0.0]
        longest = max(float(np.nansum(np.maximum(self.path.elapsed[rows], 0.0))) for rows in self.path.curves)
        return float(np.median(steps)) if len(steps) else 1.0, max(longest, 1e-6)


def context_of(
    law: Law,
    warp: Sequence[float],
    path: Path,
    tests: Sequence[TestCurve],
    stress: Array,
    ridden: Collection[str],
    across: bool,
    *,
    both: bool = False,
    turns: bool = False,
) -> DataContext:
    """Return what the entries of the catalogue are scaled to; ``both``: warp and weft have constants of their own.

    ``ridden`` are states that no replicates differ in, ``across`` says that contraction was measured, ``turns``
    that each direction answers in its own way.
    """
    setups = setups_of(path, tests, sized=False, ridden=ridden)
    replicated = sum(setups.count(one) > 1 for one in setups) > len(setups) / 2
    marked = all(test.on_specimen for test in tests)
    return DataContext(law, tuple(warp), path, stress, both, across, replicated, turns, marked)
