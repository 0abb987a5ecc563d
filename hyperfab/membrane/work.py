"""The work of the punch: the integral of its force over the way it went, and where a further point would help it most.

The force at an equilibrium is sure to many digits; its slope is not, because nodes come to touch one by one. So the
curve is a spline through the forces. Where a slack sheet takes up the load it has a kink (known, or closed in on), and
at a turning point it ends with a vertical slope, as the root of the depth that is left: there the root is the better
variable.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hyperfab.arrays import Array

#: Depths and forces [mm], [N] in order of depth.
Trace = Sequence[tuple[float, float]]

_DEGREE = 5
#: Two splines differ by at least this times the error of the better one.
_CAUTION = 4.0
#: A kink within a step costs at most a quarter of the force at its end times its length.
_KINK = 0.25
#: A kink is closed in on from above, up to this part of the way that is left to it.
_SHORT_OF_KINK = 0.05


def work(trace: Trace, turning: float | None = None, taut: float | None = None) -> float:
    """Return the work [N mm] from depth zero to the last depth.

    ``turning``: depth of the turning point [mm] that the path ends at, where there is one; ``taut``: the depth at which
    a slack sheet begins to bear, where that is known.

    >>> round(work([(1.0, 1.0), (2.0, 8.0), (3.0, 27.0), (4.0, 64.0)]), 9)
    64.0
    """
    depth, force = _loaded(trace, taut)
    return float(_steps(depth, force, turning, _DEGREE).sum())


def doubtful(
    trace: Trace, tolerance: float, turning: float | None = None, most: int = 1, taut: float | None = None
) -> list[float]:
    """Return the depths at which one more force would help most, none where the work is sure to ``tolerance`` of it.

    They are the fewest without whose steps the rest is sure, or ``most``; one where a kink is closed in on, which moves
    with each. The doubt about a step is the difference of two splines; a step in which the sheet takes up the load may
    have a kink anywhere. Nothing is known of a curve through three points or fewer.
    """
    depth, force = _loaded(trace, taut)
    if len(depth) < 2:
        return []
    steps = _steps(depth, force, turning, _DEGREE)
    degree = _degree(_DEGREE, len(depth))
    if degree == 1:
        doubt = np.abs(steps)
    else:
        doubt = np.abs(steps - _steps(depth, force, turning, degree - 2)) / _CAUTION
    slack = max((deep for deep, pushed in trace if pushed <= 0.0), default=0.0) if taut is None else 0.0
    if slack > 0.0:
        doubt[0] = max(doubt[0], _KINK * force[1] * (depth[1] - slack))

    def within(step: int) -> float:
        if slack > 0.0 and step == 0:
            near = float(depth[0] + _SHORT_OF_KINK * (depth[1] - depth[0]))
            return near if depth[0] > slack else 0.5 * (slack + float(depth[1]))
        return 0.5 * float(depth[step] + depth[step + 1])

    asked: list[int] = []
    while len(asked) < (most if slack == 0.0 else 1) and doubt.sum() > tolerance * abs(steps.sum()):
        asked.append(int(np.argmax(doubt)))
        doubt[asked[-1]] = 0.0
    return [within(step) for step in asked]


def _loaded(trace: Trace, taut: float | None) -> tuple[Array, Array]:
    """Return depths and forces from where the sheet takes up the load: depth zero, or a kink after a slack way.

    Where it is not known that it is ``taut`` there, the kink lies where the line through the first two forces comes to
    zero, after the last depth without force.
    """
    depth, force = np.array([(0.0, 0.0), *trace], float).T
    pulled = np.flatnonzero(force > 0.0)
    first = int(pulled[0]) - 1 if len(pulled) else len(depth)
    depth, force = depth[first:].copy(), force[first:]
    if taut is not None and len(depth):
        depth[0] = taut
    elif first > 0 and len(depth) > 2 and force[2] > force[1]:
        depth[0] = max(depth[0], depth[1] - force[1] * (depth[2] - depth[1]) / (force[2] - force[1]))
    return depth, force


def _steps(depth: Array, force: Array, turning: float | None, degree: int) -> Array:
    """Return the work of each step, by a spline of odd ``degree`` or as high as the points allow."""
    from scipy.interpolate import make_interp_spline

    if len(depth) < 2:
        return np.zeros(1)
    degree = _degree(degree, len(depth))
    if turning is not None and turning >= depth[-1]:
        # With u = sqrt(turning - s): the integral of F ds is that of -2 u F du.
        root = np.sqrt(turning - depth)
        spline = make_interp_spline(-root, 2.0 * root * force, k=degree)
        ends = -root
    else:
        spline, ends = make_interp_spline(depth, force, k=degree), depth
    return np.diff(spline.antiderivative()(ends))


def _degree(wanted: int, points: int) -> int:
    """Return the highest odd degree up to ``wanted`` for which there are points enough."""
    most = min(wanted, points - 1)
    return most - 1 + most % 2
