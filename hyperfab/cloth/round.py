"""A round sheet on the grid of the net: where its nodes lie, and what its cells measure in place of squares.

The elliptical grid mapping carries the square [-1, 1]^2 onto the unit disc, straight lines onto arcs of ellipses; it is
smooth, keeps each mirror image of the square, leaves the spacing in the middle as it is, and its inverse is as plain
(C. Fong, Analytical methods for squaring the disc, arXiv:1509.06344). The corners of the square lie on the rim, where
one cell each has an angle near 180 degrees. A cell's strain is that of the square grid, carried over to warp and weft
by the mapping's gradient at each point: the bilinear cells become isoparametric ones, and the kernels of the square
grid serve both.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.vectors import cross2

#: Places in a cell, as shares of its sides along x and y: its middle, and its Gauss points as ``cells.py`` takes them.
MIDDLE = np.array([[0.5, 0.5]])
_NEAR = 0.5 - 0.5 / 3.0**0.5
POINTS = np.array([[a, b] for b in (_NEAR, 1.0 - _NEAR) for a in (_NEAR, 1.0 - _NEAR)])


def rounded(u: Array, v: Array) -> tuple[Array, Array]:
    """Places on the unit disc of places in [-1, 1]^2.

    >>> import numpy as np
    >>> x, y = rounded(np.array([0.0, 1.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    >>> np.hypot(x, y).round(12).tolist()
    [0.0, 1.0, 1.0]
    """
    return u * np.sqrt(1.0 - 0.5 * v * v), v * np.sqrt(1.0 - 0.5 * u * u)


def squared(x: Array, y: Array) -> tuple[Array, Array]:
    """Places in [-1, 1]^2 of places on the unit disc: the inverse of ``rounded``.

    >>> import numpy as np
    >>> [float(one.round(12)) for one in squared(*rounded(np.array(0.3), np.array(-0.8)))]
    [0.3, -0.8]
    """
    found, root = [], np.sqrt(8.0)
    for a, b in ((x, y), (y, x)):
        part = 2.0 + a * a - b * b
        found.append(0.5 * (np.sqrt(np.maximum(part + root * a, 0.0)) - np.sqrt(np.maximum(part - root * a, 0.0))))
    return found[0], found[1]


def gradients(places: Array, rest: Array, points: Array) -> Array:
    """(n - 1, m - 1, k, 5) what turns a strain of the square grid into one of the sheet, at ``points`` (k, 2) of cells.

    ``places`` (n, m, 2) mm: the nodes in the undeformed sheet; ``rest`` (2,) mm: the grid's spacing. The first four of
    each are the inverse J^-1 of the gradient of the places by those of the grid, row by row; the last is det J.
    """
    a, b = points[:, 0], points[:, 1]
    one, two = np.diff(places, axis=0)[:, :, None] / rest[0], np.diff(places, axis=1)[:, :, None] / rest[1]
    one = one[:, :-1] * (1.0 - b)[:, None] + one[:, 1:] * b[:, None]
    two = two[:-1] * (1.0 - a)[:, None] + two[1:] * a[:, None]
    det = cross2(one, two)
    return np.stack([two[..., 1] / det, -two[..., 0] / det, -one[..., 1] / det, one[..., 0] / det, det], axis=-1)


def shares(gradient: Array, points: Array, rest: Array) -> Array:
    """(n, m) mm^2 of the undeformed sheet that each node carries, of the ``gradients`` at Gauss ``points`` (4, 2)."""
    n, m = gradient.shape[0] + 1, gradient.shape[1] + 1
    out = np.zeros((n, m))
    part = 0.25 * rest[0] * rest[1] * gradient[..., 4]
    a, b = points[:, 0], points[:, 1]
    for rows, of_i in ((np.s_[:-1], 1.0 - a), (np.s_[1:], a)):
        for columns, of_j in ((np.s_[:-1], 1.0 - b), (np.s_[1:], b)):
            out[rows, columns] += part @ (of_i * of_j)
    return out


@kernel
def to_sheet(gradient: Array, strain: Array) -> None:
    """Turn right Cauchy-Green tensors (k, 3) of the grid, C11, C22, C12, into those of the sheet: J^-T C J^-1."""
    for k in range(strain.shape[0]):
        a, b, c, d = gradient[k, 0], gradient[k, 1], gradient[k, 2], gradient[k, 3]
        c11, c22, c12 = strain[k, 0], strain[k, 1], strain[k, 2]
        strain[k, 0] = a * a * c11 + c * c * c22 + 2.0 * a * c * c12
        strain[k, 1] = b * b * c11 + d * d * c22 + 2.0 * b * d * c12
        strain[k, 2] = a * b * c11 + c * d * c22 + (a * d + b * c) * c12


@kernel
def to_grid(gradient: Array, energy: Array, stress: Array, stiffness: Array) -> float:
    """Turn what a law answers (k, 3) and (k, 6) into what the grid feels: J^-1 S J^-T det J, its tangent likewise.

    Returns the sum of the ``energy`` (k,), each times det J.
    """
    t, h, full = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    total = 0.0
    for k in range(stress.shape[0]):
        a, b, c, d = gradient[k, 0], gradient[k, 1], gradient[k, 2], gradient[k, 3]
        det = gradient[k, 4]
        total += det * energy[k]
        s11, s22, s12 = stress[k, 0], stress[k, 1], stress[k, 2]
        stress[k, 0] = det * (a * a * s11 + b * b * s22 + 2.0 * a * b * s12)
        stress[k, 1] = det * (c * c * s11 + d * d * s22 + 2.0 * c * d * s12)
        stress[k, 2] = det * (a * c * s11 + b * d * s22 + (a * d + b * c) * s12)
        t[0, 0], t[0, 1], t[0, 2] = a * a, b * b, 2.0 * a * b
        t[1, 0], t[1, 1], t[1, 2] = c * c, d * d, 2.0 * c * d
        t[2, 0], t[2, 1], t[2, 2] = a * c, b * d, a * d + b * c
        m = stiffness[k]
        full[0, 0], full[1, 1], full[2, 2] = m[0], m[1], m[2]
        full[0, 1], full[0, 2], full[1, 2] = m[3], m[4], m[5]
        full[1, 0], full[2, 0], full[2, 1] = m[3], m[4], m[5]
        for p in range(3):
            for q in range(3):
                h[p, q] = t[p, 0] * full[0, q] + t[p, 1] * full[1, q] + t[p, 2] * full[2, q]
        for at in range(6):
            p, q = at, at
            if at > 2:
                p, q = (at - 3) // 2, (at - 2) // 2 + 1
            m[at] = det * (h[p, 0] * t[q, 0] + h[p, 1] * t[q, 1] + h[p, 2] * t[q, 2])
    return total
