"""The constants of one law that fit a set of rows best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.identification.design import Problem
from hyperfab.materials.identification.linear import least_norm
from hyperfab.materials.identification.polish import polish
from hyperfab.materials.identification.search import beside, starts, thinned
from hyperfab.materials.identification.stable import SLACKS, Stable
from hyperfab.materials.law import Array
from hyperfab.materials.material import Material
from hyperfab.materials.stability import stable_at, stable_ranges
from hyperfab.materials.stability import stable_over as stable

#: Rows beyond which not every start is followed on all of them.
MANY = 800
#: The power of a term that takes no part.
_IDLE = 2.0
#: A term that gains less than this share of the square sum is rounding.
_NO_GAIN = 1e-9

Reach = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Fit:
    """The optimum: weighted square sum ``sse``, one Material a group of rows, and where it lies in the box.

    ``jacobian`` has the weighted derivative of the rows' stresses by each free constant, linear ones (of every
    group) first. ``at_bound`` names nonlinear constants at the edge of their box.
    """

    problem: Problem
    materials: tuple[Material, ...]
    sse: float
    residual: Array
    jacobian: Array
    at_bound: tuple[str, ...]

    @property
    def material(self) -> Material:
        """The material of the first group."""
        return self.materials[0]


def fit_law(
    problem: Problem,
    stable_over: Reach | None = None,
    near: Sequence[float] | None = None,
    pairs: Array | None = None,
) -> Fit | None:
    """Return the global optimum of the weighted least squares; None where the law cannot carry the rows at all.

    Laws linear in their constants are solved by QR of the scaled design matrix; the others by variable
    projection, from a scan of the box, polished. With ``stable_over`` (mode: lowest and highest stretch) the best
    constants that are Drucker-stable there, and at ``pairs`` of stretches (n, 2), are returned, which the caller may
    verify. ``near`` are nonlinear
    constants to start from in place of the scan: the optimum of a part of the rows near that of all.

    >>> from hyperfab.materials import law
    >>> from hyperfab.curve import TestCurve
    >>> from hyperfab.materials.identification.rows import Rows
    >>> lam = np.linspace(1.1, 2.0, 10)
    >>> curve = TestCurve("shear", lam, 0.8 * (lam - lam**-3), np.ones(10))
    >>> found = fit_law(Problem(law("neo-hookean"), Rows.of([curve])))
    >>> {name: round(value, 12) for name, value in found.material.parameters.items()}
    {'C10_MPa': 0.4}
    """
    found = _free_optimum(problem, near)
    if found is None or stable_over is None or _is_stable(found, stable_over, pairs):
        return found
    for share in SLACKS:
        optimum = Stable(problem, stable_over, share, pairs).optimum()
        if optimum is None:
            return None
        found = _fit(problem, *optimum)
        if _is_stable(found, stable_over, pairs):
            break
    return found


def _is_stable(found: Fit, reach: Reach, pairs: Array | None) -> bool:
    return all(
        stable(stable_ranges(material), reach) and (pairs is None or stable_at(material, pairs))
        for material in found.materials
    )


def _free_optimum(problem: Problem, near: Sequence[float] | None) -> Fit | None:
    if not problem.axes:
        u = np.zeros(0)
        with np.errstate(all="ignore"):
            A = problem.design(u)
        if not np.isfinite(A).all():
            return None
        c = least_norm(A, problem.b)
        return _fit(problem, u, c)
    fewer = None
    if near is not None:
        points = problem.coordinates(near)[None]
    else:
        points, fewer = starts(problem), _with_idle_term(problem)
        if fewer is not None:
            points = np.concatenate([points, beside(problem, problem.coordinates(fewer.material.theta))])
        if len(problem.rows) > MANY:
            # Long tests: the starts are compared on some of the rows, the best one is finished on all.
            few = polish(thinned(problem, MANY), points, finish=False)
            points = few.u if len(few.u) == 1 else points
    state = polish(problem, points)
    if not np.isfinite(state.sse).any():
        return fewer if near is None else _with_idle_term(problem)
    u, c = state.u[0], state.projection.c[0]
    if problem.law.exchangeable:
        order = problem.law.order([float(value) for value in problem.theta(list(u))])
        u, c = u[order], c.reshape(problem.rows.groups, -1)[:, order].ravel()
    found = _fit(problem, u, c)
    return fewer if fewer is not None and fewer.sse < found.sse * (1.0 - _NO_GAIN) else found


def _with_idle_term(problem: Problem) -> Fit | None:
    """Return the optimum of the law with one term less, and that term with the constant zero; None where none is less.

    This is the optimum where the best set of terms has one whose constant would need the wrong sign.
    """
    lower = problem.law.lower()
    found = None if lower is None else _free_optimum(Problem(lower, problem.rows), None)
    if found is None:
        return None
    theta = [*found.material.theta, _IDLE]
    columns = np.array([[*material.c, 0.0] for material in found.materials])
    return _fit(problem, problem.coordinates(theta), columns.ravel())


def _fit(problem: Problem, u: Array, c: Array) -> Fit:
    theta = [float(value) for value in problem.theta(list(u))]
    with np.errstate(all="ignore"):
        A = problem.design(u)
        slopes = [  # by theta: what the design changes by with u, over d theta / d u
            (slope @ c) / float(np.imag(axis.value(value + 1e-40j)) / 1e-40)
            for slope, axis, value in zip(problem.slopes(u), problem.axes, u, strict=True)
        ]
    residual = problem.b - A @ c
    jacobian = np.column_stack([A, *slopes]) if slopes else A
    width = len(problem.free)
    materials = tuple(
        Material(problem.law, tuple(_with_held(problem, c[g * width : (g + 1) * width])), tuple(theta))
        for g in range(problem.rows.groups)
    )
    sought = [name for name in problem.law.nonlinear if name not in problem.law.held]
    at_bound = tuple(
        name
        for name, value, axis in zip(sought, u, problem.axes, strict=True)
        if min(value - axis.low, axis.high - value) <= 1e-9 * (axis.high - axis.low)
    )
    return Fit(problem, materials, float(residual @ residual), residual, jacobian, at_bound)


def _with_held(problem: Problem, free: Array) -> list[float]:
    values = iter(free)
    return [
        float(problem.law.held[name]) if name in problem.law.held else float(next(values))
        for name in problem.law.linear
    ]
