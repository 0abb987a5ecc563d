"""Heaters that switch between two readings: what is not known of when they did, as it shows at the probes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.heat import HeatProblem, Run
from hyperfab.thermal.reduced import ReducedMold

#: Share of the largest power by which it changes from one reading to the next where something was switched.
_SWITCHED = 0.2
#: Half waves between two readings that are followed, and points that each is drawn through.
_WAVES, _POINTS = 2, 17
#: Share of spells between two switches that last from one reading to the next, above which some must have been missed.
_BRIEF = 0.2


def switches(power: Array) -> Ints:
    """Return the readings of a ``power`` (t,) behind which something was switched, before the next.

    >>> switches(np.array([800.0, 800.0, 0.0, 0.0, 10.0, 800.0])).tolist()
    [1, 4]
    """
    return np.flatnonzero(np.abs(np.diff(power)) > _SWITCHED * float(np.max(np.abs(power), initial=0.0)))


def is_coarse(power: Array) -> bool:
    """Whether heaters switch about as fast as their ``power`` (t,) is read, so that some of it was between readings.

    >>> is_coarse(np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0])), is_coarse(np.array([1.0, 1.0, 0.0, 0.0, 0.0]))
    (True, False)
    """
    spells = np.diff(switches(power))
    return bool(np.count_nonzero(spells == 1) > _BRIEF * len(spells))


def of_switches(
    problem: HeatProblem, times: Array, power: Array, drawn: Callable[[Array, Array], ReducedMold]
) -> Array:
    """Return what is not known of the switching does to the readings, (rows, causes) [K], each by a standard deviation.

    Between two readings, of which one reads P watts more, the heaters were switched at any time alike. What a step at
    a time that is uniformly distributed has beside the ramp from one reading to the other is a Brownian bridge: sines
    of k half waves with independent amplitudes of the standard deviation sqrt(2) P / (k pi) (Karhunen and Loeve). What
    these do is computed for the first switch, by the mold that has ``drawn`` a power [W] at times [s]; later ones do
    the same later, as films and materials hardly change with it.
    """
    turns = switches(power)
    if not len(turns):
        return np.empty((0, 0))
    run, probes = problem.runs[0], len(problem.names)
    first, steps, sizes = times[turns[0]], np.diff(times)[turns], np.abs(np.diff(power)[turns])
    along = np.linspace(0.0, 1.0, _POINTS)
    at = np.union1d(times, first + steps[0] * along)
    known = np.interp(at, times, power)

    def shown(power: Array) -> Array:
        there = replace(problem, runs=[Run.whole(drawn(at, power), at)])
        return there.delivered.reshape(probes, -1)

    plain, found = shown(known), []
    for waves in range(1, _WAVES + 1):
        bridge = np.sqrt(2.0) / (waves * np.pi) * np.sin(waves * np.pi * along)
        more = np.interp(at, first + steps[0] * along, sizes[0] * bridge, left=0.0, right=0.0)
        rise = (shown(known + more) - plain) / sizes[0]
        for turn, step, size in zip(turns, steps, sizes, strict=True):
            # What a longer step brings in is larger by as much.
            scale = size * (step / steps[0]) ** waves
            found.append([scale * np.interp(times - times[turn], at - first, one, left=0.0) for one in rise])
    return np.array(found).reshape(len(found), -1).T[run.kept]
