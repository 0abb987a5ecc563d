"""Times to step at: close where powers or surroundings jump, wide where little happens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array
from hyperfab.thermal.tables import Table

#: The first step after a jump, as a share of the whole, and by how much each next one is longer.
_FIRST, _LONGER = 1e-4, 1.3
#: A signal that bends by this share of its range within one step has a corner; one that changes so much in one, a jump.
_JUMP, _SUDDEN = 0.02, 0.3
#: The first step behind a corner, as a share of how far the signal is straight beside it.
_BEHIND = 0.1


def graded(begin: float, end: float, corners: Sequence[float], signals: Sequence[Table], steps: int) -> Array:
    """Return times from ``begin`` to ``end`` that meet every corner, wide steps ``steps`` to the whole.

    From the beginning, and from each corner at which one of ``signals`` jumps, the steps grow from short ones.

    >>> on = Table(np.array([50.0, 50.1]), np.array([0.0, 1.0]))
    >>> times = graded(0.0, 100.0, (50.0, 50.1), (on,), 10)
    >>> bool(np.diff(times)[times[:-1] >= 50.1][0] < 0.02), bool(np.max(np.diff(times)) < 10.5)
    (True, True)
    """
    whole = end - begin
    inside = sorted({float(c) for c in corners if begin < c < end})
    edges = np.array([begin, *inside, end])
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-3 * whole / steps])]
    edges[-1] = end
    firsts = _first_steps(edges, _FIRST * whole, whole / steps, signals)
    parts = []
    for start, stop, first in zip(edges[:-1], edges[1:], firsts, strict=True):
        length = float(stop - start)
        lengths = _growing(length, first, whole / steps) if first > 0.0 else _even(length, whole / steps)
        parts.append(start + np.concatenate([[0.0], np.cumsum(lengths)[:-1]]))
    return np.concatenate([*parts, [end]])


def _first_steps(edges: Array, least: float, most: float, signals: Sequence[Table]) -> Array:
    """Return the first step behind each edge but the last, 0 where no signal bends: ``least`` where one jumps, and a
    share of how far it goes on as it is where it has a corner."""
    at, length = edges[:-1], np.diff(edges)
    # No farther than to the next corner: a pulse may be over within a step.
    reach = np.minimum(most, np.minimum(length, np.append(most, length[:-1])))
    bends, jumps = np.zeros((2, len(at)), dtype=bool)
    jumps[0] = True
    for signal in signals:
        size = max(float(np.ptp(signal.y)), 1e-3 * float(np.max(np.abs(signal.y))))
        bends |= np.abs(signal(at + reach) - 2.0 * signal(at) + signal(at - reach)) > _JUMP * size
        jumps |= np.abs(signal(at + least) - signal(at - least)) > _SUDDEN * size
    return np.where(jumps, least, np.where(bends, np.maximum(least, _BEHIND * reach), 0.0))


def _even(length: float, most: float) -> Array:
    count = max(int(np.ceil(length / most - 1e-9)), 1)
    return np.full(count, length / count)


def _growing(length: float, first: float, most: float) -> Array:
    """Return steps that grow from ``first`` to ``most`` and fill ``length``."""
    count = max(int(np.ceil(np.log(most / first) / np.log(_LONGER))), 0)
    steps = first * _LONGER ** np.arange(count)
    ends = np.cumsum(steps)
    if length <= ends[-1]:
        steps = steps[: int(np.searchsorted(ends, length * (1.0 - 1e-9))) + 1]
    else:
        steps = np.concatenate([steps, _even(length - float(ends[-1]), most)])
    return steps * (length / steps.sum())
