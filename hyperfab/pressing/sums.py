"""What a sandwich does over the part of a front where it is pressed, in one pass: for presses that are many.

The same points as in ``clip`` and ``contact``, of laws that are straight between knots; nothing is kept a point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.numerics.kernels import kernel, part
from hyperfab.pressing.clip import POINTS, WEIGHTS
from hyperfab.pressing.gap import Front


@dataclass(frozen=True)
class Totals:
    """``force`` (3,) [N] and ``moment`` (3,) [N mm] about the origin on the male, the pressure's integral ``load`` [N]
    whatever its direction, the stored ``energy`` [N mm]."""

    force: Array
    moment: Array
    load: float
    energy: float

    @property
    def closing_force(self) -> float:
        """Force [N] that holds the molds at this position, along the closing axis."""
        return float(0.0 - self.force[2])


@dataclass(frozen=True)
class Touched:
    """The ``area`` [mm^2] that is touched, the share of it that is ``counted``, and the ``load`` [N] that it bears."""

    area: float
    counted: float
    load: float


@dataclass(frozen=True)
class Sums(Totals):
    """``tangent`` (3, 3) of the force by raising the female and turning it about x and y through an arm, the ``area``
    [mm^2] that is pressed, and what is ``touched``."""

    tangent: Array
    area: float
    touched: Touched


@dataclass(frozen=True)
class Stack:
    """A sandwich on a ``front``: its ``foam`` and ``fabric`` (n,) [mm], and its ``knots`` (5, k): pressures [MPa], the
    strains of foam and fabric there, and the energies of both [MPa]."""

    front: Front
    foam: Array
    fabric: Array
    knots: Array

    @cached_property
    def thickness(self) -> Array:
        """Of all (n,) [mm]."""
        return self.foam + self.fabric

    def sums(self, gap: Array, touch: Array, direction: Array, arm: Array, turns: bool = True) -> Sums:
        """Return what gaps (n,) [mm] do that push along ``direction`` (n, 3), and what the gaps ``touch`` touch.

        ``arm`` (3,) is where the female turns; where it does not, moments and all of the tangent but its first entry
        are left zero. The flange is touched but not counted.
        """
        front = self.front
        found = _sums(
            front.faces, front.areas, front.flange, self.thickness - gap, self.thickness - touch, self.foam,
            self.fabric, self.knots, np.ascontiguousarray(direction), front.vertices, arm, POINTS, WEIGHTS, turns,
        )  # fmt: skip
        force, moment, tangent = found[:3], found[3:6], found[6:15].reshape(3, 3)
        load, energy, area, *touched = map(float, found[15:])
        return Sums(force, moment, load, energy, tangent, area, Touched(*touched))


@kernel
def _sums(
    faces: Ints,
    areas: Array,
    flange: Flags,
    closing: Array,
    touching: Array,
    foam: Array,
    fabric: Array,
    knots: Array,
    direction: Array,
    places: Array,
    arm: Array,
    points: Array,
    weights: Array,
    turns: bool,
) -> Array:
    """Return force and moment (3 each), tangent (9), load, energy, area; touched area, counted area and load."""
    out, borne = np.zeros(21), np.zeros(14)
    three, cut, layers = np.zeros((2, 3, 3)), np.zeros((6, 3)), np.zeros((4, 3))
    for face in range(len(faces)):
        pressed = touched = 0
        for c in range(3):
            v = faces[face, c]
            layers[0, c], layers[1, c], layers[2, c], layers[3, c] = (
                closing[v],
                foam[v],
                fabric[v],
                touching[v],
            )
            pressed += closing[v] > 0.0
            touched += touching[v] > 0.0
        share = 0.0
        borne[:] = 0.0
        if pressed > 0:
            share = _bear(knots, layers, layers[0], pressed, points, weights, three, cut, borne)
            size = areas[face]
            _gather(faces[face], borne, size, direction, places, arm, turns, out)
            out[15] += borne[12] * size
            out[16] += borne[13] * size
            out[17] += share * size
        if touched > 0:
            if pressed < 3 or touched < 3:
                borne[:] = 0.0
                share = _bear(knots, layers, layers[3], touched, points, weights, three, cut, borne)
            out[18] += share * areas[face]
            out[19] += 0.0 if flange[face] else share * areas[face]
            out[20] += borne[12] * areas[face]
    out[9], out[12], out[13] = out[7], out[8], out[11]
    return out


@part
def _bear(
    knots: Array,
    layers: Array,
    level: Array,
    positive: int,
    points: Array,
    weights: Array,
    three: Array,
    cut: Array,
    borne: Array,
) -> float:
    """Add what a face of area 1 bears where ``level`` (3,) is positive, and return how much of it that is."""
    if positive == 3:
        _press(knots, layers, points, 1.0, weights, borne)
        return 1.0
    share = 0.0
    for piece in range(_pieces(level, positive, three)):
        size = _place(points, three[piece], cut)
        share += size
        _press(knots, layers, cut, size, weights, borne)
    return share


@part
def _pieces(value: Array, positive: int, corners: Array) -> int:
    """Cut a face where its ``value`` (3,) is zero: ``corners`` (2, 3, 3) of what is above; returns their number."""
    odd = 0
    for c in range(3):
        if (value[c] > 0.0) == (positive == 1):
            odd = c
    b, c = (odd + 1) % 3, (odd + 2) % 3
    corners[:] = 0.0
    by, cy = value[odd] / (value[odd] - value[b]), value[odd] / (value[odd] - value[c])
    if positive == 1:
        corners[0, 0, odd] = 1.0
        corners[0, 1, odd], corners[0, 1, b] = 1.0 - by, by
        corners[0, 2, odd], corners[0, 2, c] = 1.0 - cy, cy
        return 1
    corners[0, 0, odd], corners[0, 0, b] = 1.0 - by, by
    corners[0, 1, b], corners[0, 2, c] = 1.0, 1.0
    corners[1, 0, odd], corners[1, 0, b] = 1.0 - by, by
    corners[1, 1, c] = 1.0
    corners[1, 2, odd], corners[1, 2, c] = 1.0 - cy, cy
    return 2


@part
def _place(points: Array, corners: Array, cut: Array) -> float:
    """Carry ``points`` (6, 3) into a piece by its ``corners`` (3, 3), and return its share of the face."""
    for q in range(6):
        for c in range(3):
            cut[q, c] = points[q, 0] * corners[0, c] + points[q, 1] * corners[1, c] + points[q, 2] * corners[2, c]
    x, y, z = corners[0], corners[1], corners[2]
    return float(
        abs(
            x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0])
        )
    )


@part
def _press(knots: Array, layers: Array, points: Array, area: float, weights: Array, borne: Array) -> None:
    """Add load (6) and rate (6) by pairs of corners, load and energy of the six points of one piece.

    ``layers`` are the closing, the foam and the fabric [mm] at the corners of its face.
    """
    low = 0
    l0 = l1 = l2 = l3 = l4 = l5 = r0 = r1 = r2 = r3 = r4 = r5 = whole = energy = 0.0
    for q in range(6):
        p0, p1, p2 = points[q, 0], points[q, 1], points[q, 2]
        close = p0 * layers[0, 0] + p1 * layers[0, 1] + p2 * layers[0, 2]
        if close <= 0.0:
            continue
        one = p0 * layers[1, 0] + p1 * layers[1, 1] + p2 * layers[1, 2]
        two = p0 * layers[2, 0] + p1 * layers[2, 1] + p2 * layers[2, 2]
        low = _below(knots, one, two, close, low)
        begun = one * knots[1, low] + two * knots[2, low]
        span = one * knots[1, low + 1] + two * knots[2, low + 1] - begun
        rate = (knots[0, low + 1] - knots[0, low]) / span if span > 0.0 else 0.0
        now = knots[0, low] + rate * (close - begun)
        stored = one * knots[3, low] + two * knots[4, low] + 0.5 * (knots[0, low] + now) * (close - begun)
        size = area * weights[q]
        load, slope = now * size, rate * size
        whole, energy = whole + load, energy + stored * size
        x0, x1, x2 = load * p0, load * p1, load * p2
        l0, l1, l2, l3, l4, l5 = (
            l0 + x0 * p0, l1 + x1 * p1, l2 + x2 * p2, l3 + x0 * p1, l4 + x1 * p2, l5 + x2 * p0
        )  # fmt: skip
        y0, y1, y2 = slope * p0, slope * p1, slope * p2
        r0, r1, r2, r3, r4, r5 = (
            r0 + y0 * p0, r1 + y1 * p1, r2 + y2 * p2, r3 + y0 * p1, r4 + y1 * p2, r5 + y2 * p0
        )  # fmt: skip
    for k, (x, y) in enumerate(((l0, r0), (l1, r1), (l2, r2), (l3, r3), (l4, r4), (l5, r5))):
        borne[k] += x
        borne[6 + k] += y
    borne[12] += whole
    borne[13] += energy


@part
def _below(knots: Array, one: float, two: float, close: float, near: int) -> int:
    """Return the last knot that a closing has passed, but for the very last one; it is looked for from ``near`` on."""
    high = knots.shape[1] - 1
    low = 0
    if one * knots[1, near] + two * knots[2, near] <= close:
        low = near
        if near + 1 == high or close < one * knots[1, near + 1] + two * knots[2, near + 1]:
            return near
    else:
        high = near
    while high - low > 1:
        middle = (low + high) // 2
        if one * knots[1, middle] + two * knots[2, middle] <= close:
            low = middle
        else:
            high = middle
    return low


@part
def _gather(
    face: Ints,
    borne: Array,
    area: float,
    direction: Array,
    places: Array,
    arm: Array,
    turns: bool,
    out: Array,
) -> None:
    """Take what one face bears by pairs of its corners along its directions and levers."""
    for c in range(3):
        for d in range(3):
            # Pairs lie as 00, 11, 22, 01, 12, 20.
            pair = c if c == d else (3 if c + d == 1 else (4 if c + d == 3 else 5))
            load, rate = area * borne[pair], area * borne[6 + pair]
            v, w = face[c], face[d]
            x0, x1, x2 = direction[v, 0], direction[v, 1], direction[v, 2]
            y0, y1, y2 = direction[w, 0], direction[w, 1], direction[w, 2]
            # A point's weights add up to one: pairs add up to the corner alone.
            out[0] += load * x0
            out[1] += load * x1
            out[2] += load * x2
            out[6] += rate * x2 * y2
            if turns:
                p0, p1, p2 = places[w, 0], places[w, 1], places[w, 2]
                out[3] += load * (p1 * x2 - p2 * x1)
                out[4] += load * (p2 * x0 - p0 * x2)
                out[5] += load * (p0 * x1 - p1 * x0)
                # Raising or turning the female is the male moving the other way.
                q0, q1, q2 = p0 - arm[0], p1 - arm[1], p2 - arm[2]
                r0, r1, r2 = places[v, 0] - arm[0], places[v, 1] - arm[1], places[v, 2] - arm[2]
                a1, a2 = r1 * x2 - r2 * x1, r2 * x0 - r0 * x2
                b1, b2 = q1 * y2 - q2 * y1, q2 * y0 - q0 * y2
                out[7] += rate * x2 * b1
                out[8] += rate * x2 * b2
                out[10] += rate * a1 * b1
                out[11] += rate * a1 * b2
                out[14] += rate * a2 * b2
