"""A machine that yields with the load: what it reads as depth is the punch's and force times compliance besides."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import PchipInterpolator

from hyperfab.arrays import Array
from hyperfab.membrane.sphere_contact import Outcome, SphereTest, rough_path

#: Depths are met to this part of the last one, in so many runs at most.
_MET, _RUNS = 1e-6, 5


def run_on_frame(
    test: SphereTest, read: Sequence[float], press: Callable[[Sequence[float]], list[Outcome]]
) -> list[Outcome]:
    """Return the outcome of ``press`` at those depths of the punch where the machine of a test reads ``read`` [mm].

    Where the path ends before, what it reached stands.
    """
    wanted = np.asarray(read, dtype=np.float64)
    rough = rough_path(test, read)[1]
    met = [(state.depth, state.force) for state in rough.states]
    for _ in range(_RUNS):
        outcomes = press([float(depth) for depth in punch_depths(wanted, met, test.frame)])
        solved = outcomes[0].solved
        off = [abs(one.read - depth) for one, depth in zip(solved, wanted, strict=False)]
        if outcomes[0].path.limit is not None or max(off, default=0.0) <= _MET * wanted[-1]:
            break
        met = [(one.state.depth, one.state.force) for one in solved]
    return outcomes


def punch_depths(read: Array, met: Sequence[tuple[float, float]], frame: float) -> Array:
    """Return the depths (n,) of the punch for depths ``read`` (n,), from depths and forces that were ``met``.

    Beyond them as far as if nothing yielded more. Where the force falls faster than the machine springs back, it reads
    a depth twice: the first counts.
    """
    if not met:
        return read
    depth, force = np.array([(0.0, 0.0), *met]).T
    there = depth + frame * force
    first = np.append(True, there[1:] > np.maximum.accumulate(there)[:-1])
    depth, there = depth[first], there[first]
    beyond = read - there[-1]
    between = PchipInterpolator(there, depth)(np.minimum(read, there[-1]))
    return np.asarray(np.where(beyond > 0.0, depth[-1] + beyond, between))
