"""A smooth function of one state variable by a few values: what a law of an effect is where no formula is known."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from hyperfab.materials.law import Array

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline, PPoly


#: How much more closely than at its end a smooth law is told near rest, where it is told at even parts of the logarithm
#: ln(1 + CLOSER x).
CLOSER = 20.0


@lru_cache(maxsize=16)
def cardinal(count: int) -> CubicSpline:
    """Return the natural cubic splines (count) that are 1 at one of 1/count, 2/count, ... 1 and 0 at the others and 0.

    De Boor (2001), A Practical Guide to Splines, ch. IV.
    """
    from scipy.interpolate import CubicSpline  # 0.3 s to load: only smooth laws need it

    knots = np.linspace(0.0, 1.0, count + 1)
    return CubicSpline(knots, np.eye(count + 1)[:, 1:], bc_type="natural")


def through(x: Array, values: Array) -> Array:
    """Return the smooth function (n,) of ``x`` (n,) that is 0 at 0 and has ``values`` (k,) at 1/k, 2/k, ... 1.

    Beyond 1 it goes on straight; where ``x`` is unknown so is it.

    >>> through(np.array([0.0, 0.25, 0.5, 1.0, 2.0, np.nan]), np.array([1.0, 2.0]))
    array([0. , 0.5, 1. , 2. , 4. , nan])
    """
    count = len(values)
    pieces = _cardinal_pieces(count) @ np.asarray(values)
    inside = np.fmin(np.fmax(x, 0.0), 1.0)
    piece = np.minimum((inside * count).astype(np.int64), count - 1)
    step = inside - piece / count
    third, second, slope, start = pieces.take(piece, axis=1)
    found = ((third * step + second) * step + slope) * step + start
    beyond = x - inside
    if np.any(beyond):
        last = 1.0 / count
        at_end = (3.0 * pieces[0, -1] * last + 2.0 * pieces[1, -1]) * last + pieces[2, -1]
        found += beyond * np.where(x > 1.0, at_end, pieces[2, 0])
    return np.asarray(found)


@lru_cache(maxsize=16)
def _cardinal_pieces(count: int) -> Array:
    """Return the coefficients (4, count, count) of ``cardinal``: cubes first, piece by piece."""
    return np.asarray(cardinal(count).c)


def straight(spline: PPoly, x: Array, order: int = 0) -> Array:
    """Return a spline on 0 to 1, or its derivative of an ``order``, which goes on straight beyond 1.

    >>> straight(cardinal(1).antiderivative(), np.array([1.0, 2.0]), 1)[:, 0]
    array([1., 2.])
    """
    inside = np.clip(x, 0.0, 1.0)
    if np.array_equal(x, inside):
        return np.asarray(spline(inside, order))
    beyond = (x - inside).reshape(x.shape + (1,) * (spline.c.ndim - 2))
    if order > 0:
        return np.asarray(spline(inside, order) + beyond * spline(inside, order + 1))
    rise = spline(inside) + beyond * spline(inside, 1)
    # What is a slope itself goes on straight, so that its integral goes on as a parabola.
    return np.asarray(rise + 0.5 * beyond**2 * spline(inside, 2))
