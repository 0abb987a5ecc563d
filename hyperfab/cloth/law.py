"""A spring's law: nominal stress against stretch, tension only, as piecewise cubics with their exact integral.

Energy, stress and stiffness are exact derivatives of each other, which the line search of the solver relies on. A
smooth law is tabulated by cubic Hermite pieces (error below 1e-9 of the largest stress, checked); a measured curve is
taken as it stands, as straight pieces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from hyperfab.arrays import Array
from hyperfab.materials.material import Uniaxial
from hyperfab.numerics.kernels import inlined

ERROR = 1e-9
PIECES = 512
#: How often a piece is halved at most.
_HALVINGS = 6


@dataclass(frozen=True)
class SpringLaw:
    """Stress P(stretch) in MPa for stretch > 1, zero below.

    ``knots`` (k + 1,) stretches from 1 up; ``pieces`` (k + 1, 5): energy density at the knot and the cubic's
    coefficients of P in (stretch - knot), the last row continuing the curve straight beyond the last knot;
    ``buckets`` finds the piece: the first whose end lies beyond the bucket's start. ``softens``: the stretch at which
    the law's stress stops rising, where it does; the table ends there.
    """

    knots: Array
    pieces: Array
    buckets: npt.NDArray[np.int64]
    softens: float | None = None

    @property
    def arrays(self) -> tuple[Array, Array, npt.NDArray[np.int64]]:
        """What the compiled kernels take."""
        return self.knots, self.pieces, self.buckets

    @property
    def largest_stretch(self) -> float:
        """Where the table ends; beyond it the curve goes on straight."""
        return float(self.knots[-1])

    def __call__(self, stretch: object) -> tuple[Array, Array, Array]:
        """Energy density (MPa), nominal stress (MPa) and its slope (MPa) at the stretches."""
        lam = np.atleast_1d(np.asarray(stretch, dtype=float))
        piece = np.maximum(np.searchsorted(self.knots, lam, side="right") - 1, 0)
        u = np.maximum(lam - self.knots[piece], 0.0)
        w0, c0, c1, c2, c3 = np.moveaxis(self.pieces[piece], -1, 0)
        w = w0 + u * (c0 + u * (c1 / 2.0 + u * (c2 / 3.0 + u * c3 / 4.0)))
        p = c0 + u * (c1 + u * (c2 + u * c3))
        a = c1 + u * (2.0 * c2 + 3.0 * u * c3)
        taut = lam > 1.0
        return w * taut, p * taut, a * taut


def _law(knots: Array, values: Array, slopes_left: Array, slopes_right: Array) -> SpringLaw:
    """Hermite pieces from the values at the knots and the slopes at both ends of each piece."""
    h = np.diff(knots)
    k = len(h)
    secant = np.diff(values) / h
    pieces = np.zeros((k + 1, 5))
    pieces[:-1, 1] = values[:-1]
    pieces[:-1, 2] = slopes_left
    pieces[:-1, 3] = (3.0 * secant - 2.0 * slopes_left - slopes_right) / h
    pieces[:-1, 4] = (slopes_left + slopes_right - 2.0 * secant) / h**2
    c = pieces[:-1]
    area = h * (c[:, 1] + h * (c[:, 2] / 2 + h * (c[:, 3] / 3 + h * c[:, 4] / 4)))
    pieces[1:, 0] = np.cumsum(area)
    pieces[-1, 1:3] = values[-1], slopes_right[-1]
    starts = np.linspace(knots[0], knots[-1], k + 1)[:-1]
    buckets = np.clip(np.searchsorted(knots, starts, side="right") - 1, 0, k - 1)
    return SpringLaw(knots, pieces, buckets.astype(np.int64))


def tabulate(law: Callable[[Array], tuple[Array, Array]], largest_stretch: float, pieces: int = PIECES) -> SpringLaw:
    """Table of a smooth law ``stretch -> (P, dP/dstretch)`` from 1 to ``largest_stretch``.

    Pieces are halved, those of a kink again and again, until the error at their middles is below 1e-9 of the largest
    stress.

    >>> law = tabulate(lambda l: (l - l**-2, 1 + 2 * l**-3), 2.0)
    >>> w, p, a = law(1.5)
    >>> round(float(p[0]), 8), round(float(w[0] - (1.5**2 / 2 + 1 / 1.5 - 1.5)), 9)
    (1.05555556, 0.0)
    """
    knots = np.linspace(1.0, largest_stretch, pieces + 1)
    stress, slope = law(knots)
    left = np.arange(pieces)
    for _ in range(_HALVINGS):
        h = knots[left + 1] - knots[left]
        middle = knots[left] + 0.5 * h
        there, steep = law(middle)
        cubic = 0.5 * (stress[left] + stress[left + 1]) + 0.125 * h * (slope[left] - slope[left + 1])
        far = ~(np.abs(cubic - there) <= ERROR * np.abs(stress).max())
        if not far.any():
            break
        place = left[far] + 1
        knots, stress, slope = (
            np.insert(values, place, more[far]) for values, more in ((knots, middle), (stress, there), (slope, steep))
        )
        first = left[far] + np.arange(len(place))
        left = np.stack([first, first + 1], axis=1).ravel()
    return _law(knots, stress - stress[0], slope[:-1], slope[1:])


def piecewise_linear(stretch: object, stress: object) -> SpringLaw:
    """Measured curve as straight pieces; a point (1, 0) is put in front where it lacks.

    Raises ValueError where the stretches do not rise.

    >>> law = piecewise_linear([1.0, 1.1, 1.4], [0.0, 0.1, 0.7])
    >>> [round(float(v[0]), 6) for v in law(1.25)]
    [0.0425, 0.4, 2.0]
    """
    lam, p = np.asarray(stretch, dtype=float), np.asarray(stress, dtype=float)
    keep = lam > 1.0
    lam, p = np.concatenate([[1.0], lam[keep]]), np.concatenate([[0.0], p[keep]])
    if len(lam) < 2 or (np.diff(lam) <= 0.0).any():
        raise ValueError("stretches must rise from row to row, and reach beyond 1")
    slope = np.diff(p) / np.diff(lam)
    return _law(lam, p, slope, slope)


@inlined
def evaluate(lam: float, knots: Array, pieces: Array, buckets: npt.NDArray[np.int64]) -> Any:
    """Energy density, nominal stress and slope at one stretch above 1."""
    last = knots.shape[0] - 1
    k = last
    if lam < knots[last]:
        k = buckets[int((lam - 1.0) / (knots[last] - 1.0) * buckets.shape[0])]
        while lam >= knots[k + 1]:
            k += 1
    u = lam - knots[k]
    w0, c0, c1, c2, c3 = pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3], pieces[k, 4]
    p = c0 + u * (c1 + u * (c2 + u * c3))
    a = c1 + u * (2.0 * c2 + 3.0 * u * c3)
    w = w0 + u * (c0 + u * (c1 / 2.0 + u * (c2 / 3.0 + u * c3 / 4.0)))
    return w, p, a


#: Largest stretch a table goes to; beyond its end the curve continues straight.
LARGEST = 5.0
#: In how many parts the curve is looked through for its end.
_PARTS = 20
#: A law that locks is cut where its slope passes this many times the slope at rest.
LOCKED = 1e3
#: Where tension begins: threads bear nothing at rest itself, and a sheet may have no stiffness there but theirs.
_PULLED = 1.0 + 1e-12


class Pulled(Protocol):
    """What a strip of fabric answers to tension along one direction, free to contract."""

    def uniaxial(self, stretch: ArrayLike) -> Uniaxial:
        """Return energy, nominal stress and its slope [MPa]."""
        ...


def spring_law(material: Pulled) -> SpringLaw:
    """Table of the nominal stress of a fabric strip in uniaxial tension, free to contract.

    Where the stress stops rising the table ends, and the curve goes on level: a falling stress would let the net
    tear itself apart. ``softens`` of the law says where.
    Raises ValueError where the law has no stiffness at rest or no values beyond it.

    >>> from hyperfab.materials import bind
    >>> law = spring_law(bind("neo-hookean", {"C10_MPa": 0.2}))
    >>> round(float(law(2.0)[1][0]), 10), law.largest_stretch, law.softens
    (0.7, 5.0, None)
    """
    stretch = np.maximum(np.linspace(1.0, LARGEST, 4001), _PULLED)
    count, falls, rest = 0, False, 0.0
    for part in np.array_split(stretch, _PARTS):  # a law that locks early is not asked of what lies far beyond
        found = material.uniaxial(part)
        rest = rest or max(float(found.A[0]), 0.0)
        sane = np.isfinite(found.P) & np.isfinite(found.A) & (LOCKED * rest > found.A)
        rising = sane & (found.A > 0.0)
        if not rising.all():
            at_end = int(np.argmin(rising))
            count, falls = count + at_end, bool(sane[at_end])
            break
        count += len(part)
    if count < 10:
        raise ValueError("the law has no stiffness in tension at rest")

    def law(at: Array) -> tuple[Array, Array]:
        answer = material.uniaxial(np.maximum(at, _PULLED))
        return answer.P, answer.A

    end = float(stretch[count - 1])
    table = tabulate(law, end)
    return replace(table, softens=end) if falls else table
