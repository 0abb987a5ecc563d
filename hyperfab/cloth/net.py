"""The net: a rectangular grid of tension-only springs along warp (x) and weft (y)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import inlined, kernel
from hyperfab.numerics.threads import in_rows

from .law import SpringLaw, evaluate, piecewise_linear
from .round import MIDDLE, POINTS, gradients, rounded, shares

if TYPE_CHECKING:
    from .membrane import MembraneLaw

Bytes = npt.NDArray[np.uint8]

# Bits of ``Sheet.fixed``: the axes along which a node cannot move.
X, Y, Z = 1, 2, 4
FIXED = X | Y | Z

#: Standard acceleration of gravity, m/s^2 (ISO 80000-3); g/m^2 * m/s^2 = 1e-9 N/mm^2.
GRAVITY = 9.80665


class Arrays(NamedTuple):
    """A sheet as the kernels take it: rest lengths, cross-sections, laws, load per node."""

    rest: Array  # (2,) warp, weft
    warp_area: Array  # (m,) by row of nodes
    weft_area: Array  # (n,)
    cell_volume: float  # mm^3, undeformed
    warp: Any
    weft: Any
    shear: Any
    sheared: bool
    weight: Array  # (n, m) N, downward
    tension: Array  # (n, m, 2) N of each side of a membrane's cells, in place of the springs' laws; empty for springs


@dataclass(frozen=True)
class Sheet:
    """Flat sheet of ``size`` mm held by n by m nodes.

    ``prestretch``: how far the flat sheet is stretched already. Lengths, sections and weight are those of the sheet
    before that: a spring's rest length is its length in the flat sheet over the stretch along it, its section the
    thickness times its share of the width over the stretch across, half at the border (the sections of a direction
    add up to those of the undeformed sheet). ``fixed`` (n, m): bits X, Y, Z of the axes held at each node. ``shear``:
    law of the angle between the threads, over 1 + that angle; ``mass`` in g/m^2 of undeformed sheet loads the nodes
    downward.
    ``holder`` N/mm at each edge: a blank holder's friction a unit length, against which the edge is drawn in (its bits
    then hold Z alone). ``membrane``: the law of the sheet as a whole, obeyed in place of the springs'. ``round``: the
    membrane is the ellipse within ``size``, its rim the four edges of the grid.

    >>> law = piecewise_linear([1.0, 2.0], [0.0, 1.0])
    >>> sheet = Sheet(5, 3, (40.0, 20.0), 1.0, law, law)
    >>> sheet.spacing, sheet.arrays.warp_area.tolist(), sheet.flat().shape
    ((10.0, 10.0), [5.0, 10.0, 5.0], (5, 3, 3))
    """

    n: int
    m: int
    size: tuple[float, float]
    thickness: float
    warp: SpringLaw
    weft: SpringLaw
    prestretch: tuple[float, float] = (1.0, 1.0)
    shear: SpringLaw | None = None
    mass: float = 0.0
    edges: tuple[int, int, int, int] = (FIXED, FIXED, FIXED, FIXED)  # x-, x+, y-, y+
    holder: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    membrane: MembraneLaw | None = None
    round: bool = False

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of the nodes along x and y in the flat sheet, mm."""
        return self.size[0] / (self.n - 1), self.size[1] / (self.m - 1)

    @property
    def rest(self) -> Array:
        """(2,) mm: the spacing before the flat sheet was stretched."""
        return np.array(self.spacing) / self.prestretch

    @property
    def fixed(self) -> Bytes:
        """(n, m) bits of the held axes."""
        out = np.zeros((self.n, self.m), np.uint8)
        for bits, side in zip(self.edges, (out[0], out[-1], out[:, 0], out[:, -1]), strict=True):
            side |= np.uint8(bits)
        return out

    @property
    def holder_force(self) -> Array:
        """(n, m) N that the blank holder's friction on each node can reach; none where a node is held in the plane."""
        hx, hy = self.spacing
        out = np.zeros((self.n, self.m))
        along, across = _shares(self.n) * hx, _shares(self.m) * hy
        for force, side, share in zip(
            self.holder, (out[0], out[-1], out[:, 0], out[:, -1]), (across, across, along, along), strict=True
        ):
            side += force * share
        return np.where((self.fixed & (X | Y)) == (X | Y), 0.0, out)

    def flat(self) -> Array:
        """Positions (n, m, 3) of the nodes in the flat sheet, centred at the origin."""
        out = np.zeros((self.n, self.m, 3))
        out[:, :, 0] = np.linspace(-0.5, 0.5, self.n)[:, None] * self.size[0]
        out[:, :, 1] = np.linspace(-0.5, 0.5, self.m)[None, :] * self.size[1]
        if self.round:
            half = 0.5 * np.array(self.size)
            out[:, :, 0], out[:, :, 1] = rounded(out[:, :, 0] / half[0], out[:, :, 1] / half[1])
            out[:, :, :2] *= half
        return out

    def gradients(self, points: Array) -> Array:
        """What turns a strain of the square grid into one of a round sheet at ``points`` (k, 2) of each cell."""
        return gradients(self.flat()[:, :, :2] / self.prestretch, self.rest, points)

    @property
    def rest_lengths(self) -> tuple[Array, Array]:
        """(n - 1, m) and (n, m - 1) mm: the undeformed sides along warp and along weft of the grid."""
        if not self.round:
            along, across = self.rest
            return np.full((self.n - 1, self.m), along), np.full((self.n, self.m - 1), across)
        places = self.flat() / (*self.prestretch, 1.0)
        return np.linalg.norm(np.diff(places, axis=0), axis=2), np.linalg.norm(np.diff(places, axis=1), axis=2)

    @property
    def skew(self) -> float:
        """How much more the rounding of a strain is felt in the most skewed cell than in a square: J's condition^2."""
        if not self.round:
            return 1.0
        of = self.gradients(POINTS)
        return float((0.5 * (of[..., :4] ** 2).sum(-1) * of[..., 4]).max() ** 2)

    @property
    def areas(self) -> Array:
        """(n - 1, m - 1) of the undeformed cells, over that of the grid's."""
        return self.gradients(MIDDLE)[:, :, 0, 4] if self.round else np.ones((self.n - 1, self.m - 1))

    @property
    def arrays(self) -> Arrays:
        """The sheet as the kernels take it."""
        rest = self.rest
        across, along = _shares(self.m) * rest[1], _shares(self.n) * rest[0]
        shear = self.shear or NO_FORCE
        borne = shares(self.gradients(POINTS), POINTS, rest) if self.round else along[:, None] * across[None, :]
        return Arrays(
            rest,
            across * self.thickness,
            along * self.thickness,
            self.thickness * float(rest[0] * rest[1]),
            self.warp.arrays,
            self.weft.arrays,
            shear.arrays,
            self.shear is not None,
            borne * (self.mass * GRAVITY * 1e-9),
            np.zeros((0, 0, 0)),
        )

    def coarser(self, n: int, m: int) -> Sheet:
        """The same sheet held by n by m nodes."""
        return replace(self, n=n, m=m)


def _shares(n: int) -> Array:
    out = np.ones(n)
    out[[0, -1]] = 0.5
    return out


#: Law of springs without force.
NO_FORCE = piecewise_linear([1.0, 2.0], [0.0, 0.0])


@inlined
def neighbour(i: int, j: int, side: int) -> tuple[int, int]:
    """Return the node next to one on a side of it: 0, 1 ahead and behind along the warp; 2, 3 along the weft."""
    way = 1 - 2 * (side % 2)
    return (i + way, j) if side < 2 else (i, j + way)


@inlined
def _spring(x: Array, i: int, j: int, k: int, l: int, rest: float, area: float, law: Any) -> Any:
    """Return a spring's energy and its force, as a number and along x, y and z on its first node."""
    dx, dy, dz = x[k, l, 0] - x[i, j, 0], x[k, l, 1] - x[i, j, 1], x[k, l, 2] - x[i, j, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    if length <= rest:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    w, p, _ = evaluate(length / rest, law[0], law[1], law[2])
    t = p * area
    s = t / length
    return w * area * rest, t, s * dx, s * dy, s * dz


@kernel
def _forces(x: Array, net: Arrays, f: Array, energy: Array, largest: Array, first: int, last: int) -> None:
    """Forces on the nodes of rows ``first:last``; ``energy`` and ``largest`` (n,) of the springs from each row."""
    n, m = x.shape[0], x.shape[1]
    loaded = net.weight[n // 2, m // 2] != 0.0
    f[first:last] = 0.0
    if first > 0:
        for j in range(m):
            _, _, a, b, c = _spring(x, first - 1, j, first, j, net.rest[0], net.warp_area[j], net.warp)
            f[first, j, 0] -= a
            f[first, j, 1] -= b
            f[first, j, 2] -= c
    for i in range(first, last):
        total, most = 0.0, 0.0
        for j in range(m):
            if i + 1 < n:
                e, t, a, b, c = _spring(x, i, j, i + 1, j, net.rest[0], net.warp_area[j], net.warp)
                f[i, j, 0] += a
                f[i, j, 1] += b
                f[i, j, 2] += c
                if i + 1 < last:
                    f[i + 1, j, 0] -= a
                    f[i + 1, j, 1] -= b
                    f[i + 1, j, 2] -= c
                total += e
                most = max(most, t)
            if j + 1 < m:
                e, t, a, b, c = _spring(x, i, j, i, j + 1, net.rest[1], net.weft_area[i], net.weft)
                f[i, j, 0] += a
                f[i, j, 1] += b
                f[i, j, 2] += c
                f[i, j + 1, 0] -= a
                f[i, j + 1, 1] -= b
                f[i, j + 1, 2] -= c
                total += e
                most = max(most, t)
            if loaded:
                f[i, j, 2] -= net.weight[i, j]
                total += net.weight[i, j] * x[i, j, 2]
        energy[i], largest[i] = total, most


def forces(x: Array, net: Arrays, f: Array) -> tuple[float, float]:
    """Spring forces and weight on every node into ``f`` (n, m, 3) N; (energy in N mm, largest spring force in N)."""
    energy, largest = np.empty(len(x)), np.empty(len(x))
    in_rows(lambda first, last: _forces(x, net, f, energy, largest, first, last), *x.shape[:2])
    return math.fsum(energy), float(largest.max())  # exact: energy differences matter near the end


@inlined
def _join(
    x: Array,
    i: int,
    j: int,
    d: int,
    rest: float,
    area: float,
    law: Any,
    floor: float,
    diag: Array,
    off: Array,
    here: bool,
    there: bool,
) -> None:
    """Add the stiffness of the spring from a node to its next along ``d``; at least ``floor`` along and across.

    ``here``, ``there``: to its first node, to its second.
    """
    k, l = (i + 1, j) if d == 0 else (i, j + 1)
    dx, dy, dz = x[k, l, 0] - x[i, j, 0], x[k, l, 1] - x[i, j, 1], x[k, l, 2] - x[i, j, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    along, across = floor, floor
    if length > rest:
        _, p, a = evaluate(length / rest, law[0], law[1], law[2])
        along = max(a * area / rest, floor)
        across = max(p * area / length, floor)
    inv = 1.0 / max(length, 1e-300)
    tx, ty, tz = dx * inv, dy * inv, dz * inv
    t = along - across
    xx, xy, xz = across + t * tx * tx, t * tx * ty, t * tx * tz
    yy, yz, zz = across + t * ty * ty, t * ty * tz, across + t * tz * tz
    for e, wanted in ((diag[i, j], here), (diag[k, l], there)):
        if wanted:
            e[0] += xx
            e[1] += xy
            e[2] += xz
            e[3] += yy
            e[4] += yz
            e[5] += zz
    if not here:
        return
    o = off[i, j, d]
    o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], o[8] = -xx, -xy, -xz, -xy, -yy, -yz, -xz, -yz, -zz


@kernel
def _stiffness(x: Array, net: Arrays, floor: float, diag: Array, off: Array, first: int, last: int) -> None:
    n, m = x.shape[0], x.shape[1]
    diag[first:last] = 0.0
    off[first:last] = 0.0
    if first > 0:
        for j in range(m):
            _join(x, first - 1, j, 0, net.rest[0], net.warp_area[j], net.warp, floor, diag, off, False, True)
    for i in range(first, last):
        for j in range(m):
            if i + 1 < n:
                inside = i + 1 < last
                _join(x, i, j, 0, net.rest[0], net.warp_area[j], net.warp, floor, diag, off, True, inside)
            if j + 1 < m:
                _join(x, i, j, 1, net.rest[1], net.weft_area[i], net.weft, floor, diag, off, True, True)


def stiffness(x: Array, net: Arrays, floor: float, diag: Array, off: Array) -> None:
    """Tangent of all springs into ``diag`` and ``off``."""
    in_rows(lambda first, last: _stiffness(x, net, floor, diag, off, first, last), *x.shape[:2])
