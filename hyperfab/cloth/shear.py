"""Threads that resist turning against each other: an energy of the shear angle of each cell, and of that alone.

With u and v the mean sides of a cell along warp and weft, the shear angle is ``gamma = asin(u.v / |u||v|)``. A cell
stores ``V W(gamma)``, V its undeformed volume, so that it resists no stretch along the threads: simple shear meets the
stress ``dW/dgamma``, and a pull along the threads nothing. A law is kept as a table over ``1 + |gamma|`` (radians).
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.roots import zero_between

from .law import SpringLaw, evaluate, piecewise_linear
from .net import Arrays

#: Largest shear angle [rad] that a law is asked for: cells of a net cannot fold further.
FOLDED = 1.5
#: Beyond this sine the angle goes on straight, so that a cell folded flat has forces too.
STEEP = 0.995


def linear_shear(modulus: float) -> SpringLaw:
    """Law of a shear modulus in MPa: stress ``G gamma``.

    >>> float(linear_shear(0.05)(1.0 + 0.2)[1][0])
    0.01
    """
    return piecewise_linear([1.0, 1.0 + FOLDED], [0.0, modulus * FOLDED])


def shear_of_bias(bias: SpringLaw, warp: SpringLaw, weft: SpringLaw, largest: float) -> SpringLaw:
    """Law of the shear angle with which a net of ``warp`` and ``weft`` answers a test at 45 degrees as measured.

    A strip cut at 45 degrees, free across, is stretched to l under the nominal stress P. Its threads stretch to l1 and
    l2 and turn by gamma: ``l^2 = (l1^2 + l2^2 + 2 l1 l2 sin(gamma))/2``. Its energy W1(l1) + W2(l2) + W(gamma) is least
    at the given l, so that P1 = P (l1 + l2 sin gamma)/2l, P2 likewise, and dW/dgamma = P l1 l2 cos(gamma)/2l.
    ``largest`` is the largest stretch of the test. Raises ValueError where the threads alone would have to stretch
    further than the strip.
    """
    angles, stresses = [0.0], [0.0]
    l1 = l2 = 1.0
    for stretch in np.linspace(1.0, largest, 401)[1:]:
        pull = float(bias(stretch)[1][0])
        for _ in range(200):
            sine = (2.0 * stretch**2 - l1**2 - l2**2) / (2.0 * l1 * l2)
            new = [
                _stretch_at(law, pull * max(a + b * sine, 0.0) / (2.0 * stretch))
                for law, a, b in ((warp, l1, l2), (weft, l2, l1))
            ]
            moved = max(abs(new[0] - l1), abs(new[1] - l2))
            l1, l2 = 0.5 * (l1 + new[0]), 0.5 * (l2 + new[1])
            if moved < 1e-12:
                break
        sine = (2.0 * stretch**2 - l1**2 - l2**2) / (2.0 * l1 * l2)
        angle = float(np.arcsin(min(sine, 1.0))) if sine > 0.0 else 0.0
        if angle <= angles[-1]:
            if len(angles) > 1:
                break  # the threads lie along the pull: from here on they stretch alone
            raise ValueError("threads of these laws give more than the test at 45 degrees, before they turn")
        if angle > FOLDED:
            break
        angles.append(angle)
        stresses.append(max(pull * l1 * l2 * float(np.cos(angle)) / (2.0 * stretch), stresses[-1]))
    return piecewise_linear(1.0 + np.array(angles), stresses)


def _stretch_at(law: SpringLaw, stress: float) -> float:
    """Stretch at which a law carries a stress."""
    high = 2.0
    while float(law(high)[1][0]) < stress and high < 1e3:
        high *= 2.0
    if stress <= 0.0 or float(law(high)[1][0]) <= stress:
        return 1.0 if stress <= 0.0 else high
    return zero_between(lambda one: float(law(one)[1][0]) - stress, 1.0, high, 1e-15)


@part
def _angle(x: Array, i: int, j: int, u: Array, v: Array) -> tuple[float, float, float]:
    """Unit mean sides of cell (i, j) into ``u`` and ``v``; their lengths, and the cosine between them."""
    lu, lv = 0.0, 0.0
    for r in range(3):
        p, q = x[i + 1, j + 1, r] - x[i, j, r], x[i + 1, j, r] - x[i, j + 1, r]
        u[r], v[r] = 0.5 * (p + q), 0.5 * (p - q)
        lu += u[r] * u[r]
        lv += v[r] * v[r]
    lu, lv = max(np.sqrt(lu), 1e-12), max(np.sqrt(lv), 1e-12)
    c = 0.0
    for r in range(3):
        u[r] /= lu
        v[r] /= lv
        c += u[r] * v[r]
    return lu, lv, c


@part
def _energy(c: float, net: Arrays) -> tuple[float, float, float]:
    """Energy density of a cell whose sides stand at the cosine ``c``, and its first two derivatives by c."""
    size, sign = abs(c), 1.0 if c >= 0.0 else -1.0
    at = min(size, STEEP)
    root = np.sqrt(1.0 - at * at)
    angle, slope, bend = np.arcsin(at), 1.0 / root, at / (root * root * root)
    if size > STEEP:
        angle, bend = angle + slope * (size - STEEP), 0.0
    w, p, a = evaluate(1.0 + angle, net.shear[0], net.shear[1], net.shear[2])
    return w, sign * p * slope, a * slope * slope + p * bend


@kernel
def shear_forces(x: Array, net: Arrays, f: Array) -> float:
    """Add the forces of all cells on their nodes to ``f`` (n, m, 3) N; their energy in N mm."""
    n, m = x.shape[0], x.shape[1]
    u, v = np.empty(3), np.empty(3)
    total = 0.0
    for i in range(n - 1):
        row = 0.0
        for j in range(m - 1):
            lu, lv, c = _angle(x, i, j, u, v)
            w, first, _ = _energy(c, net)
            row += w * net.cell_volume
            first *= net.cell_volume
            for r in range(3):
                gu, gv = first * (v[r] - c * u[r]) / lu, first * (u[r] - c * v[r]) / lv
                gp, gq = 0.5 * (gu + gv), 0.5 * (gu - gv)
                f[i, j, r] += gp
                f[i + 1, j + 1, r] -= gp
                f[i + 1, j, r] -= gq
                f[i, j + 1, r] += gq
        total += row
    return total


@kernel
def shear_stiffness(x: Array, net: Arrays, diag: Array, off: Array) -> None:
    """Add the tangent of all cells: their diagonals p (to (i + 1, j + 1)) and q (to (i + 1, j)) with themselves
    (``one``, ``two``) and with each other (``cross``).
    """
    n, m = x.shape[0], x.shape[1]
    u, v = np.empty(3), np.empty(3)
    gu, gv = np.empty(3), np.empty(3)
    huu, hvv, huv = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for i in range(n - 1):
        for j in range(m - 1):
            lu, lv, c = _angle(x, i, j, u, v)
            _, k1, k2 = _energy(c, net)
            k1 *= net.cell_volume
            k2 *= net.cell_volume
            for r in range(3):
                gu[r], gv[r] = (v[r] - c * u[r]) / lu, (u[r] - c * v[r]) / lv
            for r in range(3):
                for s in range(3):
                    e = 1.0 if r == s else 0.0
                    turn_u = -(gu[r] * u[s] + u[r] * gu[s]) / lu - c * (e - u[r] * u[s]) / (lu * lu)
                    turn_v = -(gv[r] * v[s] + v[r] * gv[s]) / lv - c * (e - v[r] * v[s]) / (lv * lv)
                    both = (e - v[r] * v[s]) / (lu * lv) - u[r] * gv[s] / lu
                    huu[r, s] = k2 * gu[r] * gu[s] + k1 * turn_u
                    hvv[r, s] = k2 * gv[r] * gv[s] + k1 * turn_v
                    huv[r, s] = k2 * gu[r] * gv[s] + k1 * both
            at = 0
            for r in range(3):
                for s in range(3):
                    same, mixed = huu[r, s] + hvv[r, s], huv[r, s] + huv[s, r]
                    one, two = 0.25 * (same + mixed), 0.25 * (same - mixed)
                    cross = 0.25 * (huu[r, s] - hvv[r, s] - huv[r, s] + huv[s, r])
                    if s >= r:
                        diag[i, j, at] += one
                        diag[i + 1, j + 1, at] += one
                        diag[i + 1, j, at] += two
                        diag[i, j + 1, at] += two
                        at += 1
                    k, turned = 3 * r + s, 3 * s + r
                    off[i, j, 2, k] -= one
                    off[i, j + 1, 3, k] -= two
                    off[i, j, 0, k] -= cross
                    off[i, j + 1, 0, turned] -= cross
                    off[i, j, 1, k] += cross
                    off[i + 1, j, 1, turned] += cross
